//! Squares of planets: uniforms and pipelines.

use glam::DMat3;

use super::model::PlanetDisc;
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, layout};
use crate::view::{Projection, View};

/// Most discs of a frame.
pub(crate) const MOST_DISCS: usize = 8;
/// A planet is a disc where its diameter is more than so many pixels.
const DISC_FROM_PX: f64 = 3.0;

gpu_struct! {
    /// A planet as a view sees it; the fields are explained in `disc.wgsl`.
    pub struct PlanetUniform {
        /// To its centre.
        pub centre: [f32; 3],
        /// Equatorial radius, rad.
        pub radius: f32,
        /// Along the equator.
        pub along_x: [f32; 3],
        /// Apparent polar radius.
        pub flat_radius: f32,
        /// Along the pole.
        pub along_y: [f32; 3],
        /// Whether it has rings.
        pub rings: f32,
        /// To the Sun.
        pub sun: [f32; 3],
        /// Half the square's side.
        pub reach: f32,
        /// The pole.
        pub pole: [f32; 3],
        /// Fills up.
        pub padding: f32,
        /// Radiance.
        pub four: [f32; 4],
    }
}

/// Which of the frame's discs a view draws as such.
pub(crate) fn disc_slots(view: &View, discs: &[PlanetDisc]) -> Vec<usize> {
    let shown =
        |disc: &PlanetDisc| pixel_rad(view, disc).is_some_and(|pixel| 2.0 * disc.radius_rad > DISC_FROM_PX * pixel);
    (0..discs.len().min(MOST_DISCS)).filter(|&index| shown(&discs[index])).collect()
}

/// Height of a pixel where a disc stands, rad; `None` outside what the view can show.
fn pixel_rad(view: &View, disc: &PlanetDisc) -> Option<f64> {
    let rows = f64::from(view.rows_or_fewest());
    match view.projection {
        Projection::Matrix(_) => {
            let [_, _, up] = view.rays().ok()?;
            let seen = DMat3::from_mat4(view.enu_from_view).transpose() * disc.direction;
            // Distance from the axis squares the cosine.
            (seen.z < -0.05).then(|| 2.0 * up.length() / rows * seen.z * seen.z)
        }
        Projection::Fisheye(span) => Some(span / rows),
        Projection::Equirectangular => Some(std::f64::consts::PI / rows),
    }
}

/// The uniforms of discs.
pub(crate) struct Discs {
    pub layout: wgpu::BindGroupLayout,
    buffer: wgpu::Buffer,
    stride: u64,
    capacity: usize,
    group: wgpu::BindGroup,
}

impl Discs {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let layout = layout(
            device,
            "planets",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[(0, Slot::Uniform(size_of::<PlanetUniform>() as u64, true))],
        );
        let alignment = u64::from(device.limits().min_uniform_buffer_offset_alignment);
        let stride = (size_of::<PlanetUniform>() as u64).next_multiple_of(alignment);
        let capacity = MOST_DISCS;
        let (buffer, group) = Self::room(device, &layout, stride * capacity as u64);
        Self { layout, buffer, stride, capacity, group }
    }

    fn room(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, size: u64) -> (wgpu::Buffer, wgpu::BindGroup) {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("planets"),
            size,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let part = Bound::Part(&buffer, size_of::<PlanetUniform>() as u64);
        let group = bind(device, "planets", layout, &[(0, part)]);
        (buffer, group)
    }

    /// Makes room for a number of discs in all views.
    pub(crate) fn reserve(&mut self, device: &wgpu::Device, count: usize) {
        if count > self.capacity {
            self.capacity = count.next_power_of_two();
            (self.buffer, self.group) = Self::room(device, &self.layout, self.stride * self.capacity as u64);
        }
    }

    /// Uploads a disc into a slot.
    pub(crate) fn write(
        &self,
        view: &View,
        disc: &PlanetDisc,
        slot: usize,
        write: &mut dyn FnMut(&wgpu::Buffer, u64, &[u8]),
    ) {
        let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
        let frame = disc.frame();
        let into = |v: glam::DVec3| (view_from_enu * v).as_vec3().to_array();
        let scale = disc.radiance_scale();
        let uniform = PlanetUniform {
            centre: into(disc.direction),
            radius: disc.radius_rad as f32,
            along_x: into(frame.along[0]),
            flat_radius: frame.flat_radius as f32,
            along_y: into(frame.along[1]),
            rings: f32::from(u8::from(disc.rings)),
            sun: frame.sun.as_vec3().to_array(),
            reach: disc.reach() as f32,
            pole: frame.pole.as_vec3().to_array(),
            padding: 0.0,
            four: disc.irradiance.map(|value| (value * scale) as f32),
        };
        write(&self.buffer, slot as u64 * self.stride, bytemuck::bytes_of(&uniform));
    }

    /// Binds group 3.
    pub(crate) fn bind(&self, pass: &mut wgpu::RenderPass<'_>, slot: usize) {
        pass.set_bind_group(3, &self.group, &[(slot as u64 * self.stride) as u32]);
    }
}
