//! The usual approximation of the sky on the GPU [hillaire2020], at its usual sizes.
//!
//! | table | texels | made |
//! |---|---|---|
//! | transmittance to space | 256 × 64, 40 steps | once for a medium |
//! | light scattered twice and more | 32 × 32, 64 directions of 20 steps | once for a medium |
//! | sky view | 200 × 100, 30 steps | each frame |
//! | aerial perspective | 32³ froxels of 1 km, 2 steps each | each frame |
//!
//! All are rgba16float, four wavelengths in RGBA, read through the hardware's bilinear filter. The formulas are those of
//! [`himmel_air::hillaire`], whose page says what they leave out and how wrong they are.
//!
//! **Made to be fast**, because a slow rival proves nothing. The 64 directions are mirrored about the Sun, so 32 are
//! summed, and what the air weighs along them is summed once for the four azimuths. The froxels of a column are filled
//! by one march where the published code marches to each of them. Components with equal phase functions are joined.
//!
//! **Where it differs from the paper.** Aerial perspective keeps the transmittance of each wavelength in a second volume
//! (the paper keeps its mean beside RGB). The ground that a ray meets is in the sky view, as in the f64 twin. Rows of
//! the sky view belong to one side of the horizon. The paper marches pixel by pixel where the camera is in space; that
//! compares no tables, and is refused.

use glam::{DMat3, DVec3};
use himmel_air::{Atmosphere, geometry, sun};

use super::medium::Arrays;
use super::passes::{TablePass, picture_pipeline, table};
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::output::params::Tonemap;
use crate::renderer::FrameState;
use crate::shader;
use crate::target::Target;
use crate::timing::Stamps;
use crate::view::{Projection, View};

gpu_struct! {
    /// Everything that the approximation's passes know; the fields are explained in `hillaire.wgsl`.
    pub struct HillaireUniform {
        /// Row R of colour from radiance.
        pub rec709_from_four_r: [f32; 4],
        /// Row G.
        pub rec709_from_four_g: [f32; 4],
        /// Row B.
        pub rec709_from_four_b: [f32; 4],
        /// Irradiance of the Sun relative to 1 au.
        pub sun_irradiance: [f32; 4],
        /// Ground albedo at the four wavelengths.
        pub ground_albedo: [f32; 4],
        /// Limb-darkening coefficients at the four wavelengths.
        pub limb_darkening: [[f32; 4]; 6],
        /// Ray through the middle of the picture, in the Sun's frame.
        pub ray_origin: [f32; 3],
        /// Radius of the ground, m.
        pub bottom_radius_m: f32,
        /// Change of the ray with ndc.x.
        pub ray_x: [f32; 3],
        /// Altitude of the top of the air, m.
        pub top_altitude_m: f32,
        /// Change of the ray with ndc.y.
        pub ray_y: [f32; 3],
        /// Altitude of the camera, m.
        pub altitude_m: f32,
        /// Refracted direction of the Sun's disc.
        pub sun_disc: [f32; 3],
        /// Apparent radius of the disc, rad.
        pub sun_radius: f32,
        /// Cosine of the Sun's zenith angle without refraction.
        pub mu_s: f32,
        /// Factor on luminance.
        pub exposure: f32,
        /// Cosine of the zenith angle of the camera's horizon.
        pub horizon: f32,
        /// Whether the disc is drawn.
        pub sun_disc_visible: u32,
        /// Index of the tone mapper.
        pub tonemap: u32,
        /// 1: display-encoded target, 2: sRGB target.
        pub encoding: u32,
        /// Steps of the target that dithering hides; 0: off.
        pub dither_levels: f32,
        /// Largest finite value of the target.
        pub largest: f32,
        /// First pixel of the part that is drawn.
        pub pixel: [f32; 2],
        /// Fills up.
        pub padding: [f32; 2],
    }
}

/// Coefficients of a disc that is equally bright everywhere.
const EVEN_DISC: [[f32; 4]; 6] = [[1.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]];

/// Which tables a frame makes anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redo {
    /// Those that depend on Sun and camera: sky view and aerial perspective. The others are made with the first frame.
    SkyOnly,
    /// All four, as engines do that ask nobody whether the medium changed.
    Everything,
}

/// The approximation, drawn into render passes of one kind.
pub struct Hillaire {
    queue: wgpu::Queue,
    target: Target,
    uniform_buffer: wgpu::Buffer,
    /// Transmittance and multiple scattering.
    medium_passes: [TablePass; 2],
    /// Sky view and aerial perspective.
    sky_passes: [TablePass; 2],
    picture: wgpu::RenderPipeline,
    picture_group: wgpu::BindGroup,
    tables: [wgpu::Texture; 5],
    /// The part of the uniform that follows from the medium.
    air: HillaireUniform,
    first_frame: bool,
}

impl Hillaire {
    /// Compiles its pipelines for a target and one tone mapper (whatever frames say), and samples the medium.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target: &Target,
        atmosphere: &Atmosphere,
        tonemap: Tonemap,
    ) -> Result<Self, GpuError> {
        use wgpu::util::DeviceExt;
        target.check(device)?;
        let module = |label, root| {
            let source = wgpu::ShaderSource::Wgsl(shader::module(root)?.into());
            Ok::<_, GpuError>(device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source }))
        };
        let table_module = module("hillaire tables", "comparison/hillaire_tables.wgsl")?;
        let sky_module = module("hillaire sky", "comparison/hillaire_sky.wgsl")?;
        let arrays = Arrays::new(atmosphere)?;
        let buffer = |label, contents: &[[f32; 4]], usage| {
            let contents = bytemuck::cast_slice(contents);
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let medium = buffer("hillaire medium", &arrays.medium, wgpu::BufferUsages::STORAGE);
        let phases = buffer("hillaire phases", &arrays.phases, wgpu::BufferUsages::STORAGE);
        let uniform_buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("hillaire"),
            size: size_of::<HillaireUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("hillaire"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let tables = [
            table(device, "transmittance", (256, 64, 1)),
            table(device, "multiple scattering", (32, 32, 1)),
            table(device, "sky view", (200, 100, 1)),
            table(device, "aerial in-scatter", (32, 32, 32)),
            table(device, "aerial transmittance", (32, 32, 32)),
        ];
        let views = tables.each_ref().map(|table| table.create_view(&Default::default()));
        let [transmittance, multiple, sky_view, scattered, through] = &views;
        let bind = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let view = |binding, view| bind(binding, wgpu::BindingResource::TextureView(view));
        let uniform = bind(0, uniform_buffer.as_entire_binding());
        let medium = bind(1, medium.as_entire_binding());
        let phases = bind(2, phases.as_entire_binding());
        let sampler = bind(3, wgpu::BindingResource::Sampler(&sampler));
        let pass = |names, bindings: &[wgpu::BindGroupEntry<'_>], size| {
            TablePass::new(device, &table_module, names, arrays.phase_count, bindings, size)
        };
        let (to_sun, beyond) = (view(4, transmittance), view(5, multiple));
        let marched = [&uniform, &medium, &phases, &sampler, &to_sun, &beyond].map(Clone::clone);
        let medium_passes = [
            pass(
                ("hillaire transmittance", "transmittance_pass"),
                &[uniform.clone(), medium.clone(), view(7, transmittance)],
                (256, 64),
            ),
            pass(
                ("hillaire multiple scattering", "multiple_pass"),
                &[uniform.clone(), medium.clone(), sampler.clone(), to_sun.clone(), view(7, multiple)],
                (32, 32),
            ),
        ];
        let sky_passes = [
            pass(("hillaire sky view", "sky_view_pass"), &[&marched[..], &[view(7, sky_view)]].concat(), (200, 100)),
            pass(
                ("hillaire aerial perspective", "aerial_pass"),
                &[&marched[..], &[view(8, scattered), view(9, through)]].concat(),
                (32, 32),
            ),
        ];
        let picture = picture_pipeline(device, &sky_module, target, tonemap);
        let picture_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("hillaire sky"),
            layout: &picture.get_bind_group_layout(0),
            entries: &[uniform.clone(), sampler.clone(), to_sun.clone(), view(6, sky_view)],
        });
        Ok(Self {
            queue: queue.clone(),
            target: *target,
            uniform_buffer,
            medium_passes,
            sky_passes,
            picture,
            picture_group,
            tables,
            air: air_uniform(atmosphere),
            first_frame: true,
        })
    }

    /// Memory of its tables in bytes.
    pub fn table_bytes(&self) -> u64 {
        let texels = |table: &wgpu::Texture| {
            u64::from(table.width()) * u64::from(table.height()) * u64::from(table.depth_or_array_layers())
        };
        self.tables.iter().map(|table| 8 * texels(table)).sum()
    }

    /// Records the passes that make a frame's tables. The uniform goes with the queue's next submission: submit one
    /// prepared frame before the next is prepared.
    ///
    /// `frame`: its exposure must be fixed. `view`: perspective or orthographic, within the air.
    pub fn prepare(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        view: &View,
        redo: Redo,
    ) -> Result<(), GpuError> {
        self.prepare_timed(encoder, frame, view, redo, None)
    }

    pub(crate) fn prepare_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameState,
        view: &View,
        redo: Redo,
        mut stamps: Option<&mut Stamps>,
    ) -> Result<(), GpuError> {
        let uniform = self.uniform(frame, view)?;
        self.queue.write_buffer(&self.uniform_buffer, 0, bytemuck::bytes_of(&uniform));
        let medium = self.first_frame || redo == Redo::Everything;
        self.first_frame = false;
        let medium_passes = if medium { &self.medium_passes[..] } else { &[] };
        for pass in medium_passes.iter().chain(&self.sky_passes) {
            pass.record(encoder, stamps.as_mut().and_then(|stamps| stamps.next_compute(pass.label())));
        }
        Ok(())
    }

    /// Draws the prepared frame into the host's pass, at infinite depth.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.picture);
        pass.set_bind_group(0, &self.picture_group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// The sky view's texture.
    #[cfg(test)]
    pub(crate) fn sky_view(&self) -> &wgpu::Texture {
        &self.tables[2]
    }

    fn uniform(&self, frame: &FrameState, view: &View) -> Result<HillaireUniform, GpuError> {
        view.check()?;
        let Projection::Matrix(_) = view.projection else {
            return Err(GpuError::Comparison("it draws perspective and orthographic views only".into()));
        };
        let Some(exposure) = frame.output.exposure_for(self.target.output).factor() else {
            return Err(GpuError::Comparison("its exposure must be fixed: an EV100 or none, not auto".into()));
        };
        let radius_m = f64::from(self.air.bottom_radius_m);
        let centre = view.enu_from_view.w_axis.truncate() + DVec3::new(0.0, 0.0, radius_m + frame.altitude_m);
        let altitude_m = centre.length() - radius_m;
        if altitude_m > f64::from(self.air.top_altitude_m) {
            return Err(GpuError::Comparison(format!(
                "its tables are for cameras within the air, this one is {:.0} km high",
                altitude_m * 1e-3
            )));
        }
        // Half a metre: f32 cannot hold less above a planet, and eyes are higher.
        let altitude_m = altitude_m.max(0.5);
        let up = centre.normalize_or(DVec3::Z);
        let sun = &frame.sun;
        // Where the Sun stands in the zenith any azimuth is its own.
        let towards = (sun.direction - up * sun.direction.dot(up)).normalize_or(up.any_orthonormal_vector());
        let sun_from_enu = DMat3::from_cols(towards, up.cross(towards), up).transpose();
        let sun_from_view = sun_from_enu * DMat3::from_mat4(view.enu_from_view);
        let [middle, x, y] = view.rays()?;
        let [left, bottom, width, height] = view.part;
        let origin = middle + x * (2.0 * left + width - 1.0) + y * (2.0 * bottom + height - 1.0);
        let narrow = |v: DVec3| v.as_vec3().to_array();
        Ok(HillaireUniform {
            ray_origin: narrow(sun_from_view * origin),
            ray_x: narrow(sun_from_view * x * width),
            ray_y: narrow(sun_from_view * y * height),
            altitude_m: altitude_m as f32,
            horizon: geometry::horizon_cosine(radius_m, altitude_m) as f32,
            sun_disc: narrow(sun_from_enu * sun.disc_direction),
            sun_radius: sun.radius_rad as f32,
            mu_s: sun.direction.dot(up) as f32,
            sun_irradiance: sun.irradiance.map(|value| value as f32),
            exposure: (exposure * frame.output.compensation_ev.exp2()) as f32,
            sun_disc_visible: u32::from(sun.disc),
            tonemap: frame.output.tonemap as u32,
            encoding: if self.target.colour.is_srgb() { 2 } else { 1 },
            dither_levels: if frame.output.dither { self.target.levels() } else { 0.0 },
            largest: self.target.largest().unwrap_or(1.0),
            pixel: view.first_pixel.map(|pixel| pixel as f32),
            limb_darkening: if sun.limb_darkening { self.air.limb_darkening } else { EVEN_DISC },
            ..self.air
        })
    }
}

fn air_uniform(atmosphere: &Atmosphere) -> HillaireUniform {
    let [r, g, b] = atmosphere.rec709_from_four().map(|row| row.as_vec4().to_array());
    let coefficients = atmosphere.wavelengths_nm().map(sun::limb_darkening);
    HillaireUniform {
        rec709_from_four_r: r,
        rec709_from_four_g: g,
        rec709_from_four_b: b,
        ground_albedo: atmosphere.sampled().ground_albedo.map(|albedo| albedo as f32),
        limb_darkening: std::array::from_fn(|k| coefficients.map(|c| c[k] as f32)),
        bottom_radius_m: atmosphere.medium().bottom_radius_m as f32,
        top_altitude_m: atmosphere.medium().top_altitude_m as f32,
        ..HillaireUniform::default()
    }
}
