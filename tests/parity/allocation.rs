//! A running renderer allocates nothing.

use himmel::{Exposure, Gpu, Output, Sky, Target, View};
use himmel_tests::{gpu, model};

/// Memory of the device after a few frames and after a hundred more, with metering, two views and a moving Sun.
#[test]
fn frames_allocate_no_memory() {
    // A device of its own: on the shared one other tests allocate at the same time.
    let gpu = Gpu::open(Some(&gpu().report().name)).unwrap();
    let mut scene = model("earth", &[]).scene().clone();
    scene.output.exposure = Some(Exposure::Auto);
    let target = Target::new(wgpu::TextureFormat::Rgba8Unorm, Output::Display);
    let mut sky = Sky::with_scene(&gpu.device, &gpu.queue, &target, &scene).unwrap();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: target.colour,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let attachment = texture.create_view(&Default::default());
    let views = [View::looking(0.0, 0.3, 1.0, 1.0), View::looking(3.0, 0.3, 1.0, 1.0)];
    let mut frame = || {
        sky.clock_mut().advance(60.0);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        sky.prepare(&mut encoder, &views).unwrap();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &attachment,
                depth_slice: None,
                resolve_target: None,
                ops: Default::default(),
            })],
            ..Default::default()
        });
        for index in 0..views.len() {
            sky.draw(&mut pass, index);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait().unwrap();
    };
    for _ in 0..5 {
        frame();
    }
    let allocations = || {
        let report =
            gpu.device.generate_allocator_report().expect("this adapter reports no allocations; run on Vulkan");
        (report.allocations.len(), report.total_allocated_bytes, report.total_reserved_bytes)
    };
    let before = allocations();
    assert!(before.0 > 5, "the report knows the renderer's buffers");
    for _ in 0..100 {
        frame();
    }
    assert_eq!(allocations(), before);
}
