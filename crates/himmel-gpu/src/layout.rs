//! Structs that Rust and WGSL share.

/// Declares a `#[repr(C)]` struct that is uploaded as it is, and remembers its fields' offsets, so that a test can
/// compare them with those that naga finds in the WGSL struct of the same name.
macro_rules! gpu_struct {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $Struct:ident {
            $( $(#[doc = $doc:literal])+ pub $name:ident : $ty:ty, )+
        }
    ) => {
        $(#[doc = $struct_doc])+
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $Struct {
            $( $(#[doc = $doc])+ pub $name: $ty, )+
        }

        impl $Struct {
            /// Its layout, for the test that compares it with WGSL.
            pub const LAYOUT: $crate::layout::Layout = $crate::layout::Layout {
                name: stringify!($Struct),
                size: std::mem::size_of::<$Struct>(),
                fields: &[$( (stringify!($name), std::mem::offset_of!($Struct, $name)) ),+],
            };
        }
    };
}
pub(crate) use gpu_struct;

/// Name, size and field offsets of a shared struct, in bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// The same in Rust and WGSL.
    pub name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Field names and offsets.
    pub fields: &'static [(&'static str, usize)],
}

/// Every struct that Rust and WGSL share.
pub const SHARED: &[Layout] = &[
    crate::frame::FrameUniform::LAYOUT,
    crate::frame::LightUniform::LAYOUT,
    crate::frame::ViewUniform::LAYOUT,
    crate::phenomena::air::uniform::Species::LAYOUT,
    crate::phenomena::air::uniform::Aerosol::LAYOUT,
    crate::phenomena::air::uniform::AirUniform::LAYOUT,
    crate::phenomena::moon::MoonUniform::LAYOUT,
    crate::phenomena::night_glow::NightUniform::LAYOUT,
    crate::phenomena::sun::BendingUniform::LAYOUT,
    crate::phenomena::sun::DiscUniform::LAYOUT,
    crate::phenomena::sun::ShadowUniform::LAYOUT,
];

/// Those of other passes, by their root.
pub const SHARED_ELSEWHERE: &[(&str, Layout)] = &[
    ("phenomena/air/build/resolve.wgsl", crate::phenomena::air::build::BuildUniform::LAYOUT),
    ("phenomena/air/apply.wgsl", crate::phenomena::air::ApplyUniform::LAYOUT),
    ("phenomena/air/query.wgsl", crate::phenomena::air::Query::LAYOUT),
    ("output/meter.wgsl", crate::output::meter::MeterUniform::LAYOUT),
    ("output/bloom.wgsl", crate::output::bloom::BloomUniform::LAYOUT),
    ("phenomena/overlay/lines.wgsl", crate::phenomena::overlay::LineSegment::LAYOUT),
    ("phenomena/overlay/names.wgsl", crate::phenomena::overlay::NameLabel::LAYOUT),
    ("phenomena/overlay/names.wgsl", crate::phenomena::overlay::NameLetter::LAYOUT),
    ("phenomena/overlay/names.wgsl", crate::phenomena::overlay::NamesUniform::LAYOUT),
    ("phenomena/bodies/bodies.wgsl", crate::phenomena::bodies::BodiesUniform::LAYOUT),
    ("phenomena/bodies/bodies.wgsl", crate::phenomena::bodies::FarBodyUniform::LAYOUT),
    ("phenomena/bodies/bodies.wgsl", crate::phenomena::bodies::FarLightUniform::LAYOUT),
    ("phenomena/planets/disc.wgsl", crate::phenomena::planets::PlanetUniform::LAYOUT),
    ("phenomena/stars/points.wgsl", crate::phenomena::stars::PointLight::LAYOUT),
    ("phenomena/stars/points.wgsl", crate::phenomena::stars::PointsUniform::LAYOUT),
    ("phenomena/stars/points.wgsl", crate::phenomena::stars::SeenPoint::LAYOUT),
    ("comparison/hillaire_sky.wgsl", crate::comparison::HillaireUniform::LAYOUT),
];
