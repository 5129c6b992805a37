//! Bins of a picture: what the sky's pixels look points up in.

use super::pass::PointsUniform;
use crate::error::GpuError;
use crate::pass::{Bound, Slot, bind, compute, layout, module};
use crate::view::{Projection, View};

/// Most bins along the sides of a picture: of 16:9, as square as they get.
const MOST: [u32; 2] = [160, 90];
/// A bin is at least so many pixels wide: twice the core of a star, which then stands in four bins at most.
const NARROWEST_PX: f64 = 8.0;
/// Words of a view: an indirect draw, an indirect dispatch, where the list of each bin begins, and the last one ends.
const WORDS: u32 = 8 + MOST[0] * MOST[1] + 4;
/// Bins that a point may stand in.
const MOST_OF_POINT: u32 = 4;
/// Texels in a row; the same in `binned.wgsl`.
const WIDTH: u32 = 1024;
/// Rows of a view's bins.
const VIEW_ROWS: u32 = (MOST[0] * MOST[1]).div_ceil(WIDTH);
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Bins along the sides of a view's picture.
pub(crate) fn bins_of_view(view: &View) -> [u32; 2] {
    let rows = f64::from(view.rows_or_fewest());
    let columns = match view.projection {
        Projection::Matrix(_) => view.rays().map_or(rows, |[_, x, y]| rows * x.length() / y.length()),
        _ => rows * view.aspect,
    };
    let along = |pixels: f64, most: u32| ((pixels / NARROWEST_PX) as u32).clamp(1, most);
    [along(columns, MOST[0]), along(rows, MOST[1])]
}

/// The texel at which the bins of a frame's view begin.
pub(crate) fn bins_texel(view_index: usize) -> u32 {
    view_index as u32 * VIEW_ROWS * WIDTH
}

/// Of the group that pixels read bins by.
pub(crate) fn read_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, "binned points", wgpu::ShaderStages::FRAGMENT, &[(0, Slot::CodeTable)])
}

/// The bins of a frame's views, and what fills them.
pub(super) struct Bins {
    device: wgpu::Device,
    reading: wgpu::BindGroupLayout,
    /// `scan_bins`, `list_points`, `sort_bins`.
    pipelines: [wgpu::ComputePipeline; 3],
    words: wgpu::Buffer,
    texture: wgpu::TextureView,
    pub(super) read_group: wgpu::BindGroup,
    views: u32,
    /// Points of all views that there is room for.
    room: u32,
}

impl Bins {
    /// What passes bind of a [`Bins`], and what drawing wide points does.
    pub(super) const SLOTS: [(u32, Slot); 2] = [(8, Slot::Buffer(true)), (10, Slot::Write(FORMAT))];
    pub(super) const WIDE_SLOT: (u32, Slot) = (11, Slot::Buffer(false));

    /// `groups`: of the air, of a view, of what moves points.
    pub(super) fn new(
        device: &wgpu::Device,
        groups: [&wgpu::BindGroupLayout; 3],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let reading = read_layout(device);
        let shader = module(device, "phenomena/stars/bins.wgsl")?;
        let pipelines =
            ["scan_bins", "list_points", "sort_bins"].map(|entry| compute(device, &shader, entry, constants, &groups));
        let (words, texture) = (words(device, 1, 1), texture(device, 1, 1));
        let read_group = bind(device, "binned points", &reading, &[(0, Bound::View(&texture))]);
        Ok(Self { device: device.clone(), reading, pipelines, words, texture, read_group, views: 1, room: 1 })
    }

    /// Makes room; true if what is bound has changed.
    pub(super) fn reserve(&mut self, views: usize, points: usize) -> bool {
        let (views, points) = ((views as u32).max(self.views), (points as u32).max(self.room));
        if views == self.views && points == self.room {
            return false;
        }
        (self.views, self.room) = (views, points);
        self.words = words(&self.device, views, points);
        self.texture = texture(&self.device, views, points);
        self.read_group = bind(&self.device, "binned points", &self.reading, &[(0, Bound::View(&self.texture))]);
        true
    }

    /// Views of so many points each that there can be room for.
    pub(super) fn most_views(device: &wgpu::Device, points: usize) -> usize {
        let limits = device.limits();
        let rows = VIEW_ROWS as usize + (points * MOST_OF_POINT as usize).div_ceil(WIDTH as usize);
        let bytes = 4 * (WORDS as usize + (MOST_OF_POINT as usize + 1) * points);
        (limits.max_texture_dimension_2d as usize / rows).min(limits.max_storage_buffer_binding_size as usize / bytes)
    }

    pub(super) fn bound(&self) -> [(u32, Bound<'_>); 2] {
        [(8, Bound::Buffer(&self.words)), (10, Bound::View(&self.texture))]
    }

    pub(super) fn wide(&self) -> (u32, Bound<'_>) {
        (11, Bound::Buffer(&self.words))
    }

    /// What a view's points are told of their bins.
    pub(super) fn tell(&self, uniform: &mut PointsUniform, view: &View, index: usize) {
        uniform.bins = bins_of_view(view);
        uniform.bins_first = index as u32 * WORDS;
        uniform.lists_first = self.views * WORDS;
        uniform.wide_first = uniform.lists_first + MOST_OF_POINT * self.room;
        uniform.binned_first = bins_texel(self.views as usize);
    }

    /// Empties the bins of a frame's first views.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, views: usize) {
        let views = u64::from(self.views).min(views as u64);
        encoder.clear_buffer(&self.words, 0, Some(4 * views * u64::from(WORDS)));
    }

    /// Fills the lists of a view whose points are moved; its groups are bound.
    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>, points: u32, bins: [u32; 2]) {
        let [scan, list, sort] = &self.pipelines;
        for (pipeline, groups) in [(scan, 1), (list, points.div_ceil(64)), (sort, (bins[0] * bins[1]).div_ceil(64))] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups, 1, 1);
        }
    }

    /// Runs a pipeline over the wide points of a view.
    pub(super) fn dispatch_wide(&self, pass: &mut wgpu::ComputePass<'_>, view_index: usize) {
        pass.dispatch_workgroups_indirect(&self.words, 4 * (u64::from(WORDS) * view_index as u64 + 4));
    }

    /// Draws the wide points of a view.
    pub(super) fn draw_wide(&self, pass: &mut wgpu::RenderPass<'_>, view_index: usize) {
        pass.draw_indirect(&self.words, 4 * u64::from(WORDS) * view_index as u64);
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.words.size() + 16 * u64::from(WIDTH * texture_rows(self.views, self.room))
    }
}

fn words(device: &wgpu::Device, views: u32, points: u32) -> wgpu::Buffer {
    let words = u64::from(WORDS) * u64::from(views) + u64::from(MOST_OF_POINT + 1) * u64::from(points);
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("bins of points"),
        size: 4 * words,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn texture_rows(views: u32, points: u32) -> u32 {
    views * VIEW_ROWS + (MOST_OF_POINT * points).div_ceil(WIDTH)
}

fn texture(device: &wgpu::Device, views: u32, points: u32) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("binned points"),
        size: wgpu::Extent3d { width: WIDTH, height: texture_rows(views, points), depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: a core of two pixels to each side is no wider than half a bin, unless the picture is smaller than a bin.
    #[test]
    fn bins_hold_cores() {
        for (rows, aspect) in [(720, 16.0 / 9.0), (2160, 2.0), (90, 1.0), (17, 5.0), (8, 0.5)] {
            let view = View { rows_px: rows, ..View::looking(0.0, 0.5, 1.0, aspect) };
            let bins = bins_of_view(&view);
            let sides = [f64::from(rows) * aspect / f64::from(bins[0]), f64::from(rows) / f64::from(bins[1])];
            assert!(bins[0] <= 160 && bins[1] <= 90 && bins[0] * bins[1] < WORDS - 8);
            assert!(sides[1] >= 8.0 && (sides[0] >= 8.0 || bins[0] == 1), "{bins:?}");
        }
    }
}
