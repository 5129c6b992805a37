//! What the rungs share: one GPU for a process, a harness that runs WGSL functions, a seeded generator.

use std::sync::OnceLock;

use himmel::parts::gpu::shader;
use himmel::{Gpu, Scene, SkyModel};

/// The device of this process, opened once. The software rasteriser where there is one, because goldens are pinned to it;
/// `HIMMEL_ADAPTER` chooses another.
///
/// # Panics
/// Where no adapter answers: these are tests.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let wanted = std::env::var("HIMMEL_ADAPTER").ok();
        let gpu = match &wanted {
            Some(name) => Gpu::open(Some(name)),
            None => Gpu::open(Some("llvmpipe")).or_else(|_| Gpu::open(None)),
        };
        let gpu = gpu.unwrap_or_else(|error| panic!("{error}"));
        // Straight to the file: the test runner swallows what passing tests print.
        eprintln!("adapter: {}", gpu.report());
        gpu
    })
}

/// Parameters by name.
pub type Settings = &'static [(&'static str, &'static str)];

/// A model of a scene given as `key = value` pairs.
///
/// # Panics
/// Where a pair is wrong.
pub fn model(preset: &str, settings: &[(&str, &str)]) -> SkyModel {
    let mut scene = Scene { preset: preset.into(), ..Scene::default() };
    scene.set("clock.time", "2012-09-06T18:00Z").unwrap_or_else(|error| panic!("{error}"));
    for (key, value) in settings {
        scene.set(key, value).unwrap_or_else(|error| panic!("{error}"));
    }
    SkyModel::new(&scene).unwrap_or_else(|error| panic!("{error}"))
}

/// Numbers that are the same in every run (xorshift64*).
pub struct Random(u64);

impl Random {
    /// Starts from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed | 1)
    }

    /// A number in low..high.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let unit = (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64;
        low + unit * (high - low)
    }
}

/// A WGSL file without bindings, whose functions can be called one by one.
pub struct Kernel {
    source: String,
}

impl Kernel {
    /// The text of a shader file with its includes.
    ///
    /// # Panics
    /// If there is no such file.
    pub fn of(path: &str) -> Self {
        Self { source: shader::link(path, shader::embedded).unwrap_or_else(|error| panic!("{error}")) }
    }

    /// The same with a mistake in it, to show that a comparison can fail.
    ///
    /// # Panics
    /// If there is nothing to replace.
    pub fn sabotaged(mut self, from: &str, to: &str) -> Self {
        assert!(self.source.contains(from), "nothing to sabotage: {from}");
        self.source = self.source.replace(from, to);
        self
    }

    /// Evaluates an expression of `in: vec4f` (a vec4f) for each input in one dispatch.
    ///
    /// # Panics
    /// If the shader does not compile or the device fails.
    pub fn evaluate(&self, expression: &str, inputs: &[[f32; 4]]) -> Vec<[f32; 4]> {
        let gpu = gpu();
        let device = &gpu.device;
        let source = format!(
            "{}\n@group(0) @binding(0) var<storage, read> kernel_inputs: array<vec4f>;\n\
             @group(0) @binding(1) var<storage, read_write> kernel_outputs: array<vec4f>;\n\
             @compute @workgroup_size(64)\nfn kernel_main(@builtin(global_invocation_id) id: vec3u) {{\n\
             if id.x < arrayLength(&kernel_inputs) {{ let in = kernel_inputs[id.x]; kernel_outputs[id.x] = {expression}; }}\n}}\n",
            self.source
        );
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("kernel"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("kernel"),
            layout: None,
            module: &module,
            entry_point: Some("kernel_main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let bytes: &[u8] = bytemuck::cast_slice(inputs);
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("kernel"),
                size: bytes.len() as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let input = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
        let output = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        gpu.queue.write_buffer(&input, 0, bytes);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kernel"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
            ],
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(inputs.len().div_ceil(64) as u32, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&output, 0, &readable, 0, bytes.len() as u64);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read_buffer(&readable, readable.size()).unwrap_or_else(|error| panic!("{error}"));
        bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
    }
}

/// The largest |a − b| / max(|b|, floor) over all components, and where it is.
pub fn worst_error(gpu: &[[f32; 4]], cpu: &[[f64; 4]], floor: f64) -> (f64, usize) {
    let mut worst = (0.0, 0);
    for (i, (a, b)) in gpu.iter().zip(cpu).enumerate() {
        for k in 0..4 {
            let error = (f64::from(a[k]) - b[k]).abs() / b[k].abs().max(floor);
            // A NaN must not pass.
            if error > worst.0 || error.is_nan() {
                worst = (if error.is_nan() { f64::INFINITY } else { error }, i);
            }
        }
    }
    worst
}
