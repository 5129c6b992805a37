//! The Moon's textures and its uniform.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::model::{EclipseMap, MoonMap, MoonMaps, MoonState};
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, layout};

gpu_struct! {
    /// The Moon as a view sees it; the fields are explained in `moon.wgsl`.
    pub struct MoonUniform {
        /// Unit vector to its centre.
        pub centre: [f32; 3],
        /// Sine of its apparent radius.
        pub sine: f32,
        /// Unit vector to the Sun.
        pub to_sun: [f32; 3],
        /// Factor on slopes.
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
        /// Radiance in sunlight.
        pub sunlit: [f32; 4],
        /// Radiance in the Earth's light.
        pub earthlit: [f32; 4],
    }
}

impl MoonUniform {
    /// In the frame of a view. `view_from_enu`: its rotation.
    pub fn new(moon: &MoonState, view_from_enu: DMat3) -> Self {
        let vector = |v: DVec3| (view_from_enu * v).as_vec3().to_array();
        let body = moon.body_from_enu * view_from_enu.transpose();
        let row = |i: usize| body.row(i).extend(0.0).as_vec4().to_array();
        let eclipse = moon.eclipse.as_ref();
        let texels = eclipse.map_or(0, |eclipse| eclipse.map.ln_light.len()).min(SHADOW_TEXELS as usize);
        let relief = if moon.maps.normals.is_some() { moon.relief } else { 0.0 };
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
            sunlit: moon.sunlit.map(|value| value as f32),
            earthlit: moon.earthlit.map(|value| value as f32),
        }
    }
}

/// Most nodes of a shadow's table.
const SHADOW_TEXELS: u32 = 512;

/// The textures in hand, one group.
pub(crate) struct MoonTextures {
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    sampler: wgpu::Sampler,
    shadow: wgpu::Texture,
    maps: Arc<MoonMaps>,
    eclipse: Option<Arc<EclipseMap>>,
}

impl MoonTextures {
    /// Even ground, no eclipse.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let layout = layout(
            device,
            "moon",
            wgpu::ShaderStages::FRAGMENT,
            &[(0, Slot::FilteredTable), (1, Slot::FilteredTable), (2, Slot::Sampler), (3, Slot::Table)],
        );
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
        let maps = Arc::new(MoonMaps::even());
        let group = group(device, queue, &layout, &sampler, &shadow, &maps);
        Self { layout, group, sampler, shadow, maps, eclipse: None }
    }

    /// Uploads what is new.
    pub(crate) fn hold(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, moon: &MoonState) {
        if !Arc::ptr_eq(&self.maps, &moon.maps) {
            self.maps = Arc::clone(&moon.maps);
            self.group = group(device, queue, &self.layout, &self.sampler, &self.shadow, &self.maps);
        }
        let Some(eclipse) = &moon.eclipse else { return };
        if self.eclipse.as_ref().is_none_or(|held| !Arc::ptr_eq(held, &eclipse.map)) {
            let nodes = eclipse.map.ln_light.iter().take(SHADOW_TEXELS as usize);
            let texels: Vec<[f32; 4]> = nodes.map(|node| node.map(|value| value as f32)).collect();
            write(queue, &self.shadow, 0, texels.len() as u32, 1, 16, bytemuck::cast_slice(&texels));
            self.eclipse = Some(Arc::clone(&eclipse.map));
        }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let texels = |levels: usize, [w, h]: [u32; 2]| if levels > 1 { u64::from(w) * u64::from(h) * 4 / 3 } else { 1 };
        let albedo = texels(self.maps.albedo.levels().len(), self.maps.albedo.size());
        let normals = self.maps.normals.as_ref().map_or(0, |map| 4 * texels(map.levels().len(), map.size()));
        albedo + normals + 16 * u64::from(SHADOW_TEXELS)
    }
}

fn group(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    layout: &wgpu::BindGroupLayout,
    sampler: &wgpu::Sampler,
    shadow: &wgpu::Texture,
    maps: &MoonMaps,
) -> wgpu::BindGroup {
    let even = MoonMap::even([128, 128, 255, 255]);
    let albedo = texture(device, queue, "moon albedo", wgpu::TextureFormat::R8Unorm, &maps.albedo);
    let normals = maps.normals.as_ref().unwrap_or(&even);
    let normals = texture(device, queue, "moon normals", wgpu::TextureFormat::Rgba8Unorm, normals);
    bind(
        device,
        "moon",
        layout,
        &[
            (0, Bound::View(&albedo.create_view(&Default::default()))),
            (1, Bound::View(&normals.create_view(&Default::default()))),
            (2, Bound::Sampler(sampler)),
            (3, Bound::View(&shadow.create_view(&Default::default()))),
        ],
    )
}

fn texture<const N: usize>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    format: wgpu::TextureFormat,
    map: &MoonMap<N>,
) -> wgpu::Texture {
    let [width, height] = map.size();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: map.levels().len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, texels) in map.levels().iter().enumerate() {
        let size = |side: u32| (side >> level).max(1);
        write(queue, &texture, level as u32, size(width), size(height), N as u32, texels.as_flattened());
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
