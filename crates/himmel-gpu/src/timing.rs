//! How long passes take on the GPU.

use crate::error::GpuError;
use crate::gpu::Gpu;

/// Times of a frame's passes in milliseconds, in the order in which they ran.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Label and milliseconds.
    pub passes: Vec<(&'static str, f64)>,
}

/// Begin and end stamps for a few passes; nothing where the adapter offers none.
pub(crate) struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    period_ns: f64,
    labels: Vec<&'static str>,
}

impl Stamps {
    const MOST: u32 = 8;

    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * Self::MOST,
        });
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(2 * Self::MOST) * 8,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            set,
            resolved: buffer("pass times", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer("pass times, readable", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            period_ns: f64::from(gpu.queue.get_timestamp_period()),
            labels: Vec::new(),
        })
    }

    /// Stamps for the next pass.
    pub(crate) fn next(&mut self, label: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let index = self.labels.len() as u32;
        if index >= Self::MOST {
            return None;
        }
        self.labels.push(label);
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(2 * index),
            end_of_pass_write_index: Some(2 * index + 1),
        })
    }

    /// The same for a compute pass.
    pub(crate) fn next_compute(&mut self, label: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let stamps = self.next(label)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: stamps.query_set,
            beginning_of_pass_write_index: stamps.beginning_of_pass_write_index,
            end_of_pass_write_index: stamps.end_of_pass_write_index,
        })
    }

    /// Copies the stamps where the CPU can read them; call last before the submission.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = 2 * self.labels.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, u64::from(count) * 8);
        }
    }

    /// Reads the stamps of the last submission and starts anew.
    pub(crate) fn read(&mut self, gpu: &Gpu) -> Result<PassTimes, GpuError> {
        let labels = std::mem::take(&mut self.labels);
        if labels.is_empty() {
            return Ok(PassTimes::default());
        }
        let bytes = gpu.read_buffer(&self.readable, labels.len() as u64 * 16)?;
        let stamps: Vec<u64> = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * self.period_ns * 1e-6;
        Ok(PassTimes { passes: labels.into_iter().zip(stamps.chunks(2).map(ms)).collect() })
    }
}
