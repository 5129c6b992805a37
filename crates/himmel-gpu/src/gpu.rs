//! A device without a window, for hosts that bring none: the command line, tests, batch jobs.

use std::sync::{Arc, OnceLock};

use crate::error::GpuError;

/// An adapter with its device and queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    lost: Arc<OnceLock<String>>,
}

/// What an adapter is, for people and logs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterReport {
    /// Name of the GPU or rasteriser.
    pub name: String,
    /// Vulkan, Metal, Dx12, Gl or BrowserWebGpu.
    pub back_end: String,
    /// DiscreteGpu, IntegratedGpu, VirtualGpu, Cpu or Other.
    pub kind: String,
    /// Driver and its version.
    pub driver: String,
}

impl AdapterReport {
    fn of(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            back_end: format!("{:?}", info.backend),
            kind: format!("{:?}", info.device_type),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
        }
    }

    /// Whether it runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == "Cpu"
    }
}

impl std::fmt::Display for AdapterReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}, {}, {})", self.name, self.back_end, self.kind, self.driver)
    }
}

/// Adapters of the modern back ends; of OpenGL only where there are no others (its drivers print to the terminal).
fn adapters() -> Vec<wgpu::Adapter> {
    let of = |backends| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        descriptor.backends &= backends;
        pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
    };
    let modern = of(wgpu::Backends::PRIMARY);
    if modern.is_empty() { of(wgpu::Backends::GL) } else { modern }
}

/// Whether an adapter draws to the floats that luminance needs. WebGPU guarantees it; OpenGL drivers often lack it.
fn draws_floats(adapter: &wgpu::Adapter) -> bool {
    let wanted = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    adapter.get_texture_format_features(wgpu::TextureFormat::Rgba32Float).allowed_usages.contains(wanted)
}

impl Gpu {
    /// Opens the fastest adapter, or the first whose name contains `wanted` (any case): `llvmpipe`, `nvidia`.
    ///
    /// Asks for no feature that WebGPU does not guarantee; takes time stamps and blending of 32-bit floats where they are
    /// offered.
    pub fn open(wanted: Option<&str>) -> Result<Self, GpuError> {
        let adapters = adapters();
        let describe = |adapter: &wgpu::Adapter| {
            let lack = if draws_floats(adapter) { "" } else { ", which cannot draw to 32-bit floats" };
            format!("{}{lack}", AdapterReport::of(&adapter.get_info()))
        };
        let names: Vec<String> = adapters.iter().map(describe).collect();
        let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Cpu => 3,
            wgpu::DeviceType::Other => 4,
        };
        let named = |adapter: &wgpu::Adapter| {
            wanted.is_none_or(|wanted| adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase()))
        };
        let fits = |adapter: &wgpu::Adapter| named(adapter) && draws_floats(adapter);
        let Some(adapter) = adapters.into_iter().filter(fits).min_by_key(rank) else {
            return Err(GpuError::NoAdapter {
                wanted: wanted.map_or_else(|| "answers".into(), |name| format!("named like \"{name}\" answers")),
                found: if names.is_empty() { "none was found".into() } else { format!("found {}", names.join("; ")) },
            });
        };
        let device = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("himmel"),
            required_features: adapter.features()
                & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::FLOAT32_BLENDABLE),
            required_limits: wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits()),
            ..Default::default()
        }));
        let (device, queue) = device.map_err(|error| GpuError::Device(error.to_string()))?;
        let lost = Arc::new(OnceLock::new());
        let remember = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            // The first reason is the one that counts.
            let _ = remember.set(format!("{reason:?}: {message}"));
        });
        // Without a handler wgpu panics; with one the next `wait` says what happened.
        let remember = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            tracing::error!(%error, "the GPU refused something");
            let _ = remember.set(error.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" "));
        }));
        Ok(Self { adapter, device, queue, lost })
    }

    /// What it runs on.
    pub fn report(&self) -> AdapterReport {
        AdapterReport::of(&self.adapter.get_info())
    }

    /// Every adapter of this machine.
    pub fn adapters() -> Vec<AdapterReport> {
        adapters().iter().map(|adapter| AdapterReport::of(&adapter.get_info())).collect()
    }

    /// Waits for all submitted work; an error if the device was lost meanwhile.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| GpuError::Device(error.to_string()))?;
        match self.lost.get() {
            Some(reason) => Err(GpuError::Device(reason.clone())),
            None => Ok(()),
        }
    }

    /// Waits for all submitted work and copies the first `size` bytes of a buffer with [`wgpu::BufferUsages::MAP_READ`].
    pub fn read_buffer(&self, buffer: &wgpu::Buffer, size: u64) -> Result<Vec<u8>, GpuError> {
        let slice = buffer.slice(..size);
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver outlives every call but one that has given up.
            let _ = sender.send(result);
        });
        self.wait()?;
        // Where several threads share a device, another one's poll may run our callback, a little later.
        match receiver.recv_timeout(std::time::Duration::from_secs(60)) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(GpuError::Device(error.to_string())),
            Err(_) => return Err(GpuError::Device("a buffer was not read back".into())),
        }
        let bytes = slice.get_mapped_range().to_vec();
        buffer.unmap();
        Ok(bytes)
    }
}
