//! The Moon's textures and its uniform.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use half::slice::HalfFloatSliceExt;
use himmel_air::refraction::Bending;

use super::heights::{RADIUS_KM, darkest_tan};
use super::model::{EclipseMap, MoonMap, MoonMaps, MoonState};
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot};

gpu_struct! {
    /// The Moon as a view sees it; the fields are explained in `moon.wgsl`.
    pub struct MoonUniform {
        /// Unit vector to its centre.
        pub centre: [f32; 3],
        /// Sine of its apparent radius.
        pub sine: f32,
        /// Unit vector to the Sun.
        pub to_sun: [f32; 3],
        /// Factor on slopes, or radii for a km.
        pub relief: f32,
        /// Unit vector to the Earth.
        pub to_earth: [f32; 3],
        /// Relative albedo of a texel of 1.
        pub albedo_scale: f32,
        /// Axis of the Earth's shadow.
        pub axis: [f32; 3],
        /// Texels for a radius of the Moon.
        pub texels_per_radius: f32,
        /// From the axis to the centre.
        pub offset: [f32; 3],
        /// Texels of the shadow's table.
        pub shadow_texels: f32,
        /// Row x of the Moon's frame.
        pub body_x: [f32; 4],
        /// Row y.
        pub body_y: [f32; 4],
        /// Row z.
        pub body_z: [f32; 4],
        /// Deviation by elevation.
        pub lift: [f32; 4],
        /// Middle of the elevations, rad.
        pub lift_middle: f32,
        /// Half their span, rad.
        pub lift_reach: f32,
        /// Highest ground, radii.
        pub highest: f32,
        /// Tangent of the Sun that lights no ground.
        pub darkest_tan: f32,
        /// Radiance in sunlight.
        pub sunlit: [f32; 4],
        /// Radiance in the Earth's light.
        pub earthlit: [f32; 4],
    }
}

impl MoonUniform {
    /// In the frame of a view. `view_from_enu`: its rotation; `span_km`: lowest and highest ground.
    pub fn new(moon: &MoonState, bending: &Bending, view_from_enu: DMat3, span_km: [f64; 2]) -> Self {
        let (lift, [lift_middle, lift_reach]) = lift(moon, bending);
        let vector = |v: DVec3| (view_from_enu * v).as_vec3().to_array();
        let body = moon.body_from_enu * view_from_enu.transpose();
        let row = |i: usize| body.row(i).extend(0.0).as_vec4().to_array();
        let eclipse = moon.eclipse.as_ref();
        let texels = eclipse.map_or(0, |eclipse| eclipse.map.ln_light.len()).min(SHADOW_TEXELS as usize);
        let relief = if moon.maps.normals.is_some() { moon.relief } else { moon.relief / RADIUS_KM };
        Self {
            centre: vector(moon.direction),
            sine: moon.radius_rad.clamp(1e-6, 1.5).sin() as f32,
            to_sun: vector(moon.to_sun),
            relief: relief as f32,
            to_earth: vector(moon.to_earth),
            albedo_scale: moon.maps.albedo_scale as f32,
            axis: eclipse.map_or([0.0; 3], |eclipse| vector(eclipse.axis)),
            texels_per_radius: eclipse.map_or(0.0, |eclipse| eclipse.nodes_per_radius as f32),
            offset: eclipse.map_or([0.0; 3], |eclipse| vector(eclipse.offset)),
            shadow_texels: texels.max(2) as f32,
            body_x: row(0),
            body_y: row(1),
            body_z: row(2),
            lift: lift.map(|value| value as f32),
            lift_middle: lift_middle as f32,
            lift_reach: lift_reach as f32,
            highest: (span_km[1] * relief) as f32,
            darkest_tan: darkest_tan(span_km, moon.relief) as f32,
            sunlit: moon.sunlit.map(|value| value as f32),
            earthlit: moon.earthlit.map(|value| value as f32),
        }
    }
}

/// The cubic through the air's deviation at four elevations of the disc, by powers, and middle and half of their span: over
/// half a degree within 0.1″ of the map of bent rays, and cheaper than it in every pixel.
fn lift(moon: &MoonState, bending: &Bending) -> ([f64; 4], [f64; 2]) {
    let middle = moon.disc_direction.z.clamp(-1.0, 1.0).asin();
    let reach = 1.2 * moon.radius_rad.clamp(1e-3, 0.5) + 1e-3;
    let at = |x: f64| bending.deviation(middle + reach * x).0;
    let (a, b, c, d) = (at(-1.0), at(-1.0 / 3.0), at(1.0 / 3.0), at(1.0));
    // Lagrange at −1, −⅓, ⅓, 1.
    let even = [(-a + 9.0 * b + 9.0 * c - d) / 16.0, (9.0 * a - 9.0 * b - 9.0 * c + 9.0 * d) / 16.0];
    let odd = [(a - 27.0 * b + 27.0 * c - d) / 16.0, (-9.0 * a + 27.0 * b - 27.0 * c + 9.0 * d) / 16.0];
    ([even[0], odd[0], even[1], odd[1]], [middle, reach])
}

/// Most nodes of a shadow's table.
const SHADOW_TEXELS: u32 = 512;

/// What the ground's texture has beside albedo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GroundForm {
    /// Nothing.
    Albedo,
    /// Slopes by a map of normals.
    Normals,
    /// Heights.
    Heights,
}

/// The textures in hand.
pub(crate) struct MoonTextures {
    sampler: wgpu::Sampler,
    ground: wgpu::TextureView,
    ground_bytes: u64,
    form: GroundForm,
    span_km: [f64; 2],
    shadow: wgpu::Texture,
    shadow_view: wgpu::TextureView,
    maps: Arc<MoonMaps>,
    eclipse: Option<Arc<EclipseMap>>,
}

impl MoonTextures {
    /// In the group of a view.
    pub(crate) const SLOTS: [(u32, Slot); 3] = [(7, Slot::FilteredTable), (8, Slot::Sampler), (9, Slot::Table)];

    /// Even ground, no eclipse.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("moon"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let shadow = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("moon shadow"),
            size: wgpu::Extent3d { width: SHADOW_TEXELS, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let shadow_view = shadow.create_view(&Default::default());
        let maps = Arc::new(MoonMaps::even());
        let form = GroundForm::Albedo;
        let (ground, ground_bytes) = ground(device, queue, &maps, form);
        Self { sampler, ground, ground_bytes, form, span_km: [0.0; 2], shadow, shadow_view, maps, eclipse: None }
    }

    pub(crate) fn bound(&self) -> [(u32, Bound<'_>); 3] {
        [(7, Bound::View(&self.ground)), (8, Bound::Sampler(&self.sampler)), (9, Bound::View(&self.shadow_view))]
    }

    /// Uploads what is new; true if bind groups with it are stale. `near`: whether heights would be seen. Once there they stay.
    pub(crate) fn hold(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, moon: &MoonState, near: bool) -> bool {
        let new = !Arc::ptr_eq(&self.maps, &moon.maps);
        let form = match (&moon.maps.normals, &moon.maps.relief) {
            (Some(_), _) => GroundForm::Normals,
            (None, Some(_)) if near && moon.relief > 0.0 || !new && self.form == GroundForm::Heights => {
                GroundForm::Heights
            }
            _ => GroundForm::Albedo,
        };
        let stale = new || form != self.form;
        if stale {
            self.maps = Arc::clone(&moon.maps);
            self.form = form;
            (self.ground, self.ground_bytes) = ground(device, queue, &self.maps, form);
            let relief = self.maps.relief.as_ref().filter(|_| form == GroundForm::Heights);
            self.span_km = relief.map_or([0.0; 2], |relief| relief.heights().span_km());
        }
        if let Some(eclipse) = &moon.eclipse
            && self.eclipse.as_ref().is_none_or(|held| !Arc::ptr_eq(held, &eclipse.map))
        {
            let nodes = eclipse.map.ln_light.iter().take(SHADOW_TEXELS as usize);
            let texels: Vec<[f32; 4]> = nodes.map(|node| node.map(|value| value as f32)).collect();
            write(queue, &self.shadow, 0, texels.len() as u32, 1, 16, bytemuck::cast_slice(&texels));
            self.eclipse = Some(Arc::clone(&eclipse.map));
        }
        stale
    }

    /// What the ground's texture has.
    pub(crate) fn form(&self) -> GroundForm {
        self.form
    }

    /// Lowest and highest ground, where there are heights.
    pub(crate) fn span_km(&self) -> [f64; 2] {
        self.span_km
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.ground_bytes + 16 * u64::from(SHADOW_TEXELS)
    }
}

/// Albedo, and beside it slopes or heights: one texture, one look-up. Its memory in bytes.
fn ground(device: &wgpu::Device, queue: &wgpu::Queue, maps: &MoonMaps, form: GroundForm) -> (wgpu::TextureView, u64) {
    use wgpu::TextureFormat::{R8Unorm, Rg16Float, Rgba8Unorm};
    fn bytes<const N: usize>(map: &MoonMap<N>) -> impl Iterator<Item = &[u8]> {
        map.levels().iter().map(|level| level.as_flattened())
    }
    let (normals, heights) = match form {
        GroundForm::Albedo => (None, None),
        GroundForm::Normals => (maps.with_normals(), None),
        GroundForm::Heights => (None, maps.with_heights()),
    };
    let texture = match (&normals, &heights) {
        (Some(map), _) => texture(device, queue, Rgba8Unorm, map.size(), bytes(map)),
        (_, Some((width, levels))) => {
            let levels = levels.iter().map(|level| bytemuck::cast_slice(level.as_flattened().reinterpret_cast()));
            texture(device, queue, Rg16Float, [*width, *width / 2], levels)
        }
        _ => texture(device, queue, R8Unorm, maps.albedo.size(), bytes(&maps.albedo)),
    };
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(1);
    let texels = u64::from(texture.width()) * u64::from(texture.height()) * 4 / 3;
    (texture.create_view(&Default::default()), u64::from(texel_bytes) * texels)
}

fn texture<'a>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: wgpu::TextureFormat,
    [width, height]: [u32; 2],
    levels: impl Iterator<Item = &'a [u8]>,
) -> wgpu::Texture {
    let levels: Vec<_> = levels.collect();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("moon ground"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let texel_bytes = format.block_copy_size(None).unwrap_or(1);
    for (level, texels) in levels.into_iter().enumerate() {
        let size = |side: u32| (side >> level).max(1);
        write(queue, &texture, level as u32, size(width), size(height), texel_bytes, texels);
    }
    texture
}

fn write(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    level: u32,
    width: u32,
    height: u32,
    texel_bytes: u32,
    bytes: &[u8],
) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() },
        bytes,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * texel_bytes), rows_per_image: None },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use himmel_air::Preset;

    /// On the horizon and above: 0.5″ of the map, which itself is good to 0.6″ there.
    #[test]
    fn the_disc_is_lifted_as_bent_rays_are() {
        let earth = Preset::named("earth").unwrap().medium;
        let bending = Bending::new(&earth, &[630.0, 560.0, 490.0, 430.0], 2.0);
        for degrees in [0.3f64, 1.0, 5.0, 40.0] {
            let elevation = degrees.to_radians();
            let disc_direction = DVec3::new(0.0, elevation.cos(), elevation.sin());
            let moon = MoonState { disc_direction, ..MoonState::even(disc_direction, 0.0045) };
            let (c, [middle, reach]) = lift(&moon, &bending);
            for i in -10..=10 {
                let seen = elevation + 0.0045 * f64::from(i) / 10.0;
                let x = (seen - middle) / reach;
                let ours = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
                let arcsec = (ours - bending.deviation(seen).0).to_degrees() * 3600.0;
                assert!(arcsec.abs() < 0.5 || seen < bending.lowest_rad, "{degrees}° {i}: {arcsec}″");
            }
        }
    }
}
