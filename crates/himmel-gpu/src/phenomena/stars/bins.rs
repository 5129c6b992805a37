//! Bins of a picture: what the sky's pixels look points up in.

use super::pass::{PointsUniform, rows_of};
use crate::error::GpuError;
use crate::pass::{Bound, Slot, bind, compute, layout, module};
use crate::view::{Projection, View};

/// Most bins along the sides of a picture: of 16:9, as square as they get.
const MOST: [u32; 2] = [160, 90];
/// A bin is at least so many pixels wide: twice the core of a star, which then stands in four bins at most.
const NARROWEST_PX: f64 = 8.0;
/// Words of a view: an indirect draw, where the list of each bin begins, and the last one ends.
const WORDS: u32 = 4 + MOST[0] * MOST[1] + 4;
/// Bins that a point may stand in.
const MOST_OF_POINT: u64 = 4;
/// Bytes of a point in a bin, `binned_points` in `bins.wgsl`.
const POINT_BYTES: u64 = 32;

/// Bins along the sides of a view's picture.
pub(crate) fn bins_of_view(view: &View) -> [u32; 2] {
    let rows = rows_of(view);
    let columns = match view.projection {
        Projection::Matrix(_) => view.rays().map_or(rows, |[_, x, y]| rows * x.length() / y.length()),
        _ => rows * view.aspect,
    };
    let along = |pixels: f64, most: u32| ((pixels / NARROWEST_PX) as u32).clamp(1, most);
    [along(columns, MOST[0]), along(rows, MOST[1])]
}

/// Where the bins of a frame's view begin, words.
pub(crate) fn first_of_view(index: usize) -> u32 {
    index as u32 * WORDS
}

/// Of the group that pixels read bins by.
pub(crate) fn read_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, "binned points", wgpu::ShaderStages::FRAGMENT, &[(1, Slot::Buffer(false)), (2, Slot::Buffer(false))])
}

/// The bins of a frame's views, and what fills them.
pub(super) struct Bins {
    device: wgpu::Device,
    reading: wgpu::BindGroupLayout,
    /// `scan_bins`, `list_points`, `sort_bins`.
    pipelines: [wgpu::ComputePipeline; 3],
    pub(super) words: wgpu::Buffer,
    pub(super) listed: wgpu::Buffer,
    points: wgpu::Buffer,
    pub(super) read_group: wgpu::BindGroup,
    views: usize,
    /// Points of all views that there is room for.
    room: usize,
}

impl Bins {
    /// What passes bind of a [`Bins`], and what drawing wide points does.
    pub(super) const SLOTS: [(u32, Slot); 3] =
        [(8, Slot::Buffer(true)), (9, Slot::Buffer(true)), (10, Slot::Buffer(true))];
    pub(super) const WIDE_SLOT: (u32, Slot) = (11, Slot::Buffer(false));

    /// `groups`: of the air, of a view, of what moves points.
    pub(super) fn new(
        device: &wgpu::Device,
        groups: [&wgpu::BindGroupLayout; 3],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let reading = read_layout(device);
        let pipelines = pipelines(device, groups, constants)?;
        let [words, listed, points] = buffers(device, 1, 1);
        let read_group = read_group(device, &reading, &words, &points);
        Ok(Self { device: device.clone(), reading, pipelines, words, listed, points, read_group, views: 1, room: 1 })
    }

    /// Makes room; true if what is bound has changed.
    pub(super) fn reserve(&mut self, views: usize, points: usize) -> bool {
        if views <= self.views && points <= self.room {
            return false;
        }
        self.views = views.max(self.views);
        self.room = points.max(self.room);
        [self.words, self.listed, self.points] = buffers(&self.device, self.views as u64, self.room as u64);
        self.read_group = read_group(&self.device, &self.reading, &self.words, &self.points);
        true
    }

    /// Points that a binding can hold.
    pub(super) fn most_points(device: &wgpu::Device) -> usize {
        (device.limits().max_storage_buffer_binding_size / (MOST_OF_POINT * POINT_BYTES)) as usize
    }

    pub(super) fn bound(&self) -> [(u32, Bound<'_>); 3] {
        [(8, Bound::Buffer(&self.words)), (9, Bound::Buffer(&self.listed)), (10, Bound::Buffer(&self.points))]
    }

    /// What a view's points are told of their bins.
    pub(super) fn tell(&self, uniform: &mut PointsUniform, view: &View, index: usize) {
        uniform.bins = bins_of_view(view);
        uniform.bins_first = first_of_view(index);
        uniform.wide_first = (MOST_OF_POINT * self.room as u64) as u32;
    }

    /// Empties the bins of a frame's first views.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, views: usize) {
        encoder.clear_buffer(&self.words, 0, Some(4 * u64::from(first_of_view(views.min(self.views)))));
    }

    /// Fills the lists of a view whose points are moved; its groups are bound.
    pub(super) fn record(&self, pass: &mut wgpu::ComputePass<'_>, points: u32, bins: [u32; 2]) {
        let [scan, list, sort] = &self.pipelines;
        for (pipeline, groups) in [(scan, 1), (list, points.div_ceil(64)), (sort, (bins[0] * bins[1]).div_ceil(64))] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups, 1, 1);
        }
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.words.size() + self.listed.size() + self.points.size()
    }
}

fn pipelines(
    device: &wgpu::Device,
    groups: [&wgpu::BindGroupLayout; 3],
    constants: &[(&str, f64)],
) -> Result<[wgpu::ComputePipeline; 3], GpuError> {
    let module = module(device, "phenomena/stars/bins.wgsl")?;
    Ok(["scan_bins", "list_points", "sort_bins"].map(|entry| compute(device, &module, entry, constants, &groups)))
}

fn buffers(device: &wgpu::Device, views: u64, points: u64) -> [wgpu::Buffer; 3] {
    let buffer = |label, size, usage| {
        let usage = wgpu::BufferUsages::STORAGE | usage;
        device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
    };
    [
        buffer(
            "bins of points",
            4 * u64::from(WORDS) * views,
            wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        ),
        buffer("listed points", 4 * (MOST_OF_POINT + 1) * points, wgpu::BufferUsages::empty()),
        buffer("points in bins", MOST_OF_POINT * POINT_BYTES * points, wgpu::BufferUsages::empty()),
    ]
}

fn read_group(
    device: &wgpu::Device,
    reading: &wgpu::BindGroupLayout,
    words: &wgpu::Buffer,
    points: &wgpu::Buffer,
) -> wgpu::BindGroup {
    bind(device, "binned points", reading, &[(1, Bound::Buffer(words)), (2, Bound::Buffer(points))])
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
            assert!(bins[0] <= 160 && bins[1] <= 90 && bins[0] * bins[1] < WORDS - 4);
            assert!(sides[1] >= 8.0 && (sides[0] >= 8.0 || bins[0] == 1), "{bins:?}");
        }
    }
}
