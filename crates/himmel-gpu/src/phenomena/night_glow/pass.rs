//! What shaders read of a night: a uniform, the star map, the table of zodiacal light.

use std::sync::Arc;

use glam::DMat3;

use super::{NightGlow, StarMap, zodiacal};
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, layers};

gpu_struct! {
    /// The fields are explained in `night_glow.wgsl`.
    pub struct NightUniform {
        /// Airglow at the zenith.
        pub airglow: [f32; 4],
        /// Of one S10 of red.
        pub four_from_red: [f32; 4],
        /// Of green.
        pub four_from_green: [f32; 4],
        /// Of blue.
        pub four_from_blue: [f32; 4],
        /// Factor on the light of cities.
        pub pollution: [f32; 4],
        /// The air's depth of the vertical.
        pub depth: [f32; 4],
        /// Depth below the camera over that above it.
        pub depth_below: [f32; 4],
        /// Mean radiance on the air.
        pub diffuse: [f32; 4],
        /// The factor of its transmission.
        pub diffuse_factor: [f32; 4],
        /// Radiance of the ground.
        pub ground: [f32; 4],
        /// Distance of the layer from the planet's centre, m.
        pub layer_radius_m: f32,
        /// One over its unit, 1/m.
        pub per_layer_unit: f32,
        /// Its unit over its vertical path.
        pub unit_over_vertical: f32,
        /// Radiance of a texel of the zodiacal table.
        pub zodiacal: f32,
    }
}

impl NightUniform {
    /// Of a night.
    pub fn new(night: &NightGlow) -> Self {
        let four = |values: [f64; 4]| values.map(|value| value as f32);
        let [red, green, blue] = night.four_from_s10.map(four);
        Self {
            airglow: four(night.airglow),
            four_from_red: red,
            four_from_green: green,
            four_from_blue: blue,
            pollution: four(night.pollution),
            depth: four(night.depth),
            depth_below: four(night.depth_below),
            diffuse: four(night.diffuse),
            diffuse_factor: four(night.diffuse_factor),
            ground: four(night.ground),
            layer_radius_m: night.layer.radius_m as f32,
            per_layer_unit: (1.0 / night.layer.unit_m) as f32,
            unit_over_vertical: night.layer.unit_over_vertical as f32,
            zodiacal: night.zodiacal as f32,
        }
    }
}

impl NightGlow {
    /// Rows of ICRS and of the ecliptic from view space, as the view's uniform has them.
    ///
    /// `pixel_rad`: what a pixel sees, for the level of the star map whose texels are as large.
    pub(crate) fn axes(&self, view_from_enu: DMat3, pixel_rad: f64) -> [[[f32; 4]; 3]; 2] {
        let rows = |from_enu: DMat3, w: [f64; 3]| {
            let from_view = from_enu * view_from_enu.transpose();
            std::array::from_fn(|i| from_view.row(i).extend(w[i]).as_vec4().to_array())
        };
        let (side, levels) = self.star_map.as_ref().map_or((1, 1), |map| (map.side(), map.levels().len()));
        // Half a face's side are the texels to a radian in its middle.
        let level = (pixel_rad * 0.5 * f64::from(side)).max(1.0).log2().round().min((levels - 1) as f64);
        let side = f64::from(side) / level.exp2();
        [rows(self.icrs_from_enu, [level, side, 0.0]), rows(self.ecliptic_from_enu, [0.0; 3])]
    }
}

/// What shaders read of a night, in the bind group of views: black and tiny until the first one.
pub(crate) struct NightTextures {
    pub buffer: wgpu::Buffer,
    star_map: wgpu::TextureView,
    zodiacal: wgpu::TextureView,
    /// What the textures hold.
    held_map: Option<Arc<StarMap>>,
    held_table: Option<Arc<Vec<[f64; 4]>>>,
    bytes: u64,
}

impl NightTextures {
    /// Its place in the layout of views.
    pub(crate) const SLOTS: [(u32, Slot); 3] =
        [(4, Slot::Uniform(size_of::<NightUniform>() as u64, false)), (5, Slot::Codes), (6, Slot::Table)];

    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("night glow"),
            size: size_of::<NightUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let star_map = layers(&cube(device, 1, 1));
        let zodiacal = table(device, [1, 1]).create_view(&Default::default());
        Self { buffer, star_map, zodiacal, held_map: None, held_table: None, bytes: 0 }
    }

    /// What is bound there.
    pub(crate) fn bound(&self) -> [(u32, Bound<'_>); 3] {
        [(4, Bound::Buffer(&self.buffer)), (5, Bound::View(&self.star_map)), (6, Bound::View(&self.zodiacal))]
    }

    /// Uploads what a night has and the textures do not hold yet: once, unless settings change. True where bind groups with
    /// them are stale.
    pub(crate) fn hold(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, night: &NightGlow) -> bool {
        let same_map = match (&self.held_map, &night.star_map) {
            (Some(held), Some(wanted)) => Arc::ptr_eq(held, wanted),
            (None, None) => true,
            _ => false,
        };
        let same_table = self.held_table.as_ref().is_some_and(|held| Arc::ptr_eq(held, &night.zodiacal_table));
        if same_map && same_table {
            return false;
        }
        if !same_map {
            let texture = match &night.star_map {
                Some(map) => {
                    let texture = cube(device, map.side(), map.levels().len() as u32);
                    for (level, texels) in map.levels().iter().enumerate() {
                        let side = (map.side() >> level).max(1);
                        write(queue, &texture, level as u32, [side, side, 6], bytemuck::cast_slice(texels));
                    }
                    texture
                }
                None => cube(device, 1, 1),
            };
            self.star_map = layers(&texture);
            self.held_map = night.star_map.clone();
            self.bytes = night.star_map.as_ref().map_or(0, |map| map.levels().iter().map(|l| 4 * l.len() as u64).sum());
        }
        if !same_table {
            let [width, height] = zodiacal::FOLDED;
            let texture = table(device, zodiacal::FOLDED.map(|side| side as u32));
            let texels: Vec<f32> = night.zodiacal_table.iter().flatten().map(|s10| *s10 as f32).collect();
            if texels.len() == 4 * width * height {
                write(queue, &texture, 0, [width as u32, height as u32, 1], bytemuck::cast_slice(&texels));
            }
            self.zodiacal = texture.create_view(&Default::default());
            self.held_table = Some(Arc::clone(&night.zodiacal_table));
        }
        true
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }
}

fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height, layers]: [u32; 3],
    levels: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn cube(device: &wgpu::Device, side: u32, levels: u32) -> wgpu::Texture {
    texture(device, "star map", [side, side, 6], levels, wgpu::TextureFormat::R32Uint)
}

fn table(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    texture(device, "zodiacal light", [width, height, 1], 1, wgpu::TextureFormat::Rgba32Float)
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, level: u32, [width, height, layers]: [u32; 3], bytes: &[u8]) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32 / (height * layers).max(1)),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: layers },
    );
}
