//! What depends on where a camera stands: where the cells of its rays lie, and the sky view. Filled each frame.

use crate::error::GpuError;
use crate::frame::ViewUniform;
use crate::pass::{self, Bound, Slot, bind, compute, layers, layout};

use super::sizes::AirSizes;
use super::tables::{Tables, texture_bytes};

/// Columns of the cell table; the same in `cells.wgsl`.
pub(crate) const CELL_COLUMNS: u32 = 65;

/// Half floats, which every adapter filters; scaled by each light, see `cells.wgsl`.
const SKY_VIEW_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const RAYS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Texels of the sky view for each of its rays, along each side.
const FINER: u32 = 2;

/// Tables for a number of stations, with their passes.
pub(crate) struct Stations {
    cells: wgpu::Texture,
    rays: wgpu::Texture,
    sky_view: wgpu::Texture,
    sky_view_rays: Option<[u32; 2]>,
    cells_pipeline: wgpu::ComputePipeline,
    /// For other bodies' air, once there is some.
    far_cells_pipeline: Option<wgpu::ComputePipeline>,
    march_pipeline: wgpu::ComputePipeline,
    refine_pipeline: wgpu::ComputePipeline,
    cells_layout: wgpu::BindGroupLayout,
    march_layout: wgpu::BindGroupLayout,
    refine_layout: wgpu::BindGroupLayout,
    station_layout: wgpu::BindGroupLayout,
    marching_layout: wgpu::BindGroupLayout,
    /// For each number of stations and buffer of views.
    groups: Option<Groups>,
    rows: u32,
    capacity: u32,
}

struct Groups {
    station: wgpu::BindGroup,
    marching: wgpu::BindGroup,
    cells: wgpu::BindGroup,
    march: wgpu::BindGroup,
    refine: wgpu::BindGroup,
}

/// The uniform of a view, with a dynamic offset.
pub(crate) fn view_slot() -> Slot {
    Slot::Uniform(size_of::<ViewUniform>() as u64, true)
}

impl Stations {
    pub(crate) fn new(
        device: &wgpu::Device,
        sizes: &AirSizes,
        tables: &Tables,
        air_layout: &wgpu::BindGroupLayout,
    ) -> Result<Self, GpuError> {
        let only = wgpu::ShaderStages::COMPUTE;
        let station_layout = layout(device, "station", only, &[(0, view_slot())]);
        let marching_layout = layout(device, "station, marching", only, &[(0, view_slot()), (1, Slot::Layers)]);
        let cells_layout = layout(device, "cells", only, &[(0, Slot::WriteLayers(wgpu::TextureFormat::Rg32Float))]);
        let march_layout = layout(device, "sky view rays", only, &[(0, Slot::WriteLayers(RAYS_FORMAT))]);
        let slots = [(0, Slot::Layers), (1, Slot::WriteLayers(SKY_VIEW_FORMAT))];
        let refine_layout = layout(device, "sky view", only, &slots);
        let constants = tables.constants(0..1);
        let cells_pipeline = compute(
            device,
            &pass::module(device, "phenomena/air/cells.wgsl")?,
            "fill_cells",
            &constants,
            &[air_layout, &station_layout, &cells_layout],
        );
        let march_pipeline = compute(
            device,
            &pass::module(device, "phenomena/air/sky_view.wgsl")?,
            "march_sky_view",
            &[constants[0], constants[1], ("split_peaks", 1.0), ("group_cells", 4.0)],
            &[air_layout, &marching_layout, &march_layout],
        );
        let refine_pipeline = compute(
            device,
            &pass::module(device, "phenomena/air/sky_view_refine.wgsl")?,
            "refine_sky_view",
            &constants,
            &[air_layout, &marching_layout, &refine_layout],
        );
        let [cells, rays, sky_view] = textures(device, sizes, 1, 1);
        Ok(Self {
            cells,
            rays,
            sky_view,
            sky_view_rays: sizes.sky_view,
            cells_pipeline,
            far_cells_pipeline: None,
            march_pipeline,
            refine_pipeline,
            cells_layout,
            march_layout,
            refine_layout,
            station_layout,
            marching_layout,
            groups: None,
            rows: sizes.cell_rows,
            capacity: 1,
        })
    }

    /// Memory of the tables in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        texture_bytes(&self.cells) + texture_bytes(&self.rays) + texture_bytes(&self.sky_view)
    }

    /// The tables, for the bind groups of views.
    pub(crate) fn views(&self) -> [wgpu::TextureView; 2] {
        [layers(&self.cells), layers(&self.sky_view)]
    }

    /// Makes room; true if the tables are new and bind groups with them stale.
    pub(crate) fn reserve(&mut self, device: &wgpu::Device, sizes: &AirSizes, stations: u32, lights: u32) -> bool {
        let wanted = stations.max(1) * lights.max(1);
        if wanted <= self.capacity {
            return false;
        }
        self.capacity = wanted.next_power_of_two();
        [self.cells, self.rays, self.sky_view] = textures(device, sizes, stations.next_power_of_two(), self.capacity);
        self.groups = None;
        true
    }

    /// Says which buffer holds the views.
    pub(crate) fn bind_views(&mut self, device: &wgpu::Device, buffer: &wgpu::Buffer) {
        let [cells, sky_view] = self.views();
        let rays = layers(&self.rays);
        let view = (0, Bound::Part(buffer, size_of::<ViewUniform>() as u64));
        self.groups = Some(Groups {
            station: bind(device, "station", &self.station_layout, &[view]),
            marching: bind(device, "station, marching", &self.marching_layout, &[view, (1, Bound::View(&cells))]),
            cells: bind(device, "cells", &self.cells_layout, &[(0, Bound::View(&cells))]),
            march: bind(device, "sky view rays", &self.march_layout, &[(0, Bound::View(&rays))]),
            refine: bind(
                device,
                "sky view",
                &self.refine_layout,
                &[(0, Bound::View(&rays)), (1, Bound::View(&sky_view))],
            ),
        });
    }

    /// Makes what places cells in other bodies' air.
    pub(crate) fn with_far(
        &mut self,
        device: &wgpu::Device,
        air_layout: &wgpu::BindGroupLayout,
        [groups, aerosols]: [(&'static str, f64); 2],
    ) -> Result<(), GpuError> {
        self.far_cells_pipeline = Some(compute(
            device,
            &pass::module(device, "phenomena/air/cells.wgsl")?,
            "fill_cells",
            &[groups, aerosols, ("far_airs", 1.0)],
            &[air_layout, &self.station_layout, &self.cells_layout],
        ));
        Ok(())
    }

    /// Places the cells of a station, whose uniform lies at an offset. `far`: in another body's air.
    pub(crate) fn record_cells(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        air_group: &wgpu::BindGroup,
        offset: u32,
        far: bool,
    ) {
        let pipeline = if far { self.far_cells_pipeline.as_ref() } else { Some(&self.cells_pipeline) };
        let (Some(groups), Some(pipeline)) = (&self.groups, pipeline) else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, air_group, &[]);
        pass.set_bind_group(1, &groups.station, &[offset]);
        pass.set_bind_group(2, &groups.cells, &[]);
        pass.dispatch_workgroups(self.rows.div_ceil(8).max(1), 1, 1);
    }

    /// Fills the sky view of a station.
    pub(crate) fn record_sky_view(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        air_group: &wgpu::BindGroup,
        offset: u32,
        lights: u32,
    ) {
        let (Some(groups), Some([width, height])) = (&self.groups, self.sky_view_rays) else { return };
        pass.set_pipeline(&self.march_pipeline);
        pass.set_bind_group(0, air_group, &[]);
        pass.set_bind_group(1, &groups.marching, &[offset]);
        pass.set_bind_group(2, &groups.march, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), lights);
        pass.set_pipeline(&self.refine_pipeline);
        pass.set_bind_group(2, &groups.refine, &[]);
        pass.dispatch_workgroups((FINER * width).div_ceil(8), (FINER * height).div_ceil(8), lights);
    }
}

fn textures(device: &wgpu::Device, sizes: &AirSizes, stations: u32, lights: u32) -> [wgpu::Texture; 3] {
    let texture = |label, [width, height]: [u32; 2], layers, format| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
            view_formats: &[],
        })
    };
    let layers = 2 * lights;
    // Where every pixel marches its own ray, the least that the shaders' tables may be.
    let rays = sizes.sky_view.unwrap_or([4, 12]);
    [
        texture("cells", [CELL_COLUMNS, sizes.cell_rows + 1], stations, wgpu::TextureFormat::Rg32Float),
        texture("sky view rays", rays, layers, RAYS_FORMAT),
        texture("sky view", rays.map(|size| FINER * size), layers, SKY_VIEW_FORMAT),
    ]
}
