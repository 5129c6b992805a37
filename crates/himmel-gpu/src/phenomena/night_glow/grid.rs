//! The night's glow over a view, on a grid that pixels interpolate: it is smoother than pixels are, and costs more than they may.

use crate::error::GpuError;
use crate::pass::{self, Bound, Slot, bind, compute, layers, layout};
use crate::view::View;

/// Texels along the sides: six by three for each cell of a picture's tiles; the same in `sky.wgsl`.
const SIZE: [u32; 2] = [384, 216];
/// Half floats, which every adapter filters.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Views of a frame that have one; others evaluate the glow in each pixel.
pub(crate) const MOST_VIEWS: u32 = 8;
/// What tiles beside the horizon keep clear of it, as a share of their reach: more than a texel's diagonal, so that no texel
/// that a pixel interpolates lies beyond it.
pub(crate) const SPACING_OF_TILE: f64 = 0.13;

/// The grids of a frame's views.
pub(crate) struct NightGrid {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// The group that fills it, and the one that pixels read it by.
    held: Option<[wgpu::BindGroup; 2]>,
    layers: u32,
}

impl NightGrid {
    /// `groups`: of the air and of views.
    pub(crate) fn new(
        device: &wgpu::Device,
        groups: [&wgpu::BindGroupLayout; 2],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let layout = layout(device, "night grid", wgpu::ShaderStages::COMPUTE, &[(0, Slot::WriteLayers(FORMAT))]);
        let constants: Vec<_> =
            constants.iter().copied().chain([("marching", 0.0), ("linear", 1.0), ("night", 1.0)]).collect();
        let module = pass::module(device, "phenomena/night_glow/grid.wgsl")?;
        let pipeline = compute(device, &module, "fill_night_grid", &constants, &[groups[0], groups[1], &layout]);
        Ok(Self { layout, pipeline, held: None, layers: 0 })
    }

    /// Makes room for a number of views. `reading`: the layout of [`read_layout`].
    pub(crate) fn reserve(&mut self, device: &wgpu::Device, reading: &wgpu::BindGroupLayout, views: u32) {
        if views <= self.layers {
            return;
        }
        self.layers = views.next_power_of_two();
        let view = texture(device, SIZE, self.layers);
        let group = bind(device, "night grid", &self.layout, &[(0, Bound::View(&view))]);
        self.held = Some([group, read_group(device, reading, &view)]);
    }

    /// What pixels read.
    pub(crate) fn group(&self) -> Option<&wgpu::BindGroup> {
        self.held.as_ref().map(|[_, reading]| reading)
    }

    /// Fills a view's layer.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        air_group: &wgpu::BindGroup,
        view_group: &wgpu::BindGroup,
        offset: u32,
    ) {
        let Some([group, _]) = &self.held else { return };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, air_group, &[]);
        pass.set_bind_group(1, view_group, &[offset]);
        pass.set_bind_group(2, group, &[]);
        pass.dispatch_workgroups(SIZE[0].div_ceil(8), SIZE[1].div_ceil(8), 1);
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        8 * u64::from(SIZE[0] * SIZE[1] * self.layers)
    }
}

const READ: u32 = 6;

/// Of the group that pixels read a grid by.
pub(crate) fn read_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, "night grid", wgpu::ShaderStages::FRAGMENT, &[(READ, Slot::Filtered)])
}

fn read_group(device: &wgpu::Device, reading: &wgpu::BindGroupLayout, view: &wgpu::TextureView) -> wgpu::BindGroup {
    bind(device, "night grid", reading, &[(READ, Bound::View(view))])
}

/// That group where there is no grid.
pub(crate) fn no_grid(device: &wgpu::Device, reading: &wgpu::BindGroupLayout) -> wgpu::BindGroup {
    read_group(device, reading, &texture(device, [1, 1], 1))
}

/// The angle between two of its rows in a view, rad.
pub(crate) fn spacing_rad(view: &View) -> f64 {
    (view.degrees_per_pixel(SIZE[1]) * view.part[3]).to_radians()
}

fn texture(device: &wgpu::Device, [width, height]: [u32; 2], depth_or_array_layers: u32) -> wgpu::TextureView {
    layers(&device.create_texture(&wgpu::TextureDescriptor {
        label: Some("night grid"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    }))
}
