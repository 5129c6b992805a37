//! The sky in somebody else's pass: depth of both directions, several views, multisampling, formats, exposure.

use himmel::parts::gpu::SunState;
use himmel::{DepthDirection, Exposure, GpuError, Output, Pixels, Sky, Still, Target, View};
use himmel_tests::{gpu, model};
use wgpu::TextureFormat as F;

const SIZE: u32 = 16;

fn texture(format: F, samples: u32) -> wgpu::Texture {
    gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Draws one view into an 8-bit target whose depth was cleared to a value, over magenta; gives the pixels.
fn drawn(depth: Option<(DepthDirection, f32)>, samples: u32, index: usize, views: &[View]) -> Vec<[u8; 4]> {
    let gpu = gpu();
    let mut scene = model("earth", &[("light.sun.altitude_deg", "30")]).scene().clone();
    scene.output.exposure = Some(Exposure::Ev100(14.0));
    let target = Target {
        colour: F::Rgba8Unorm,
        depth: depth.map(|(direction, _)| (F::Depth32Float, direction)),
        samples,
        output: Output::Display,
    };
    let mut sky = Sky::with_scene(&gpu.device, &gpu.queue, &target, &scene).unwrap();
    let (colour, resolved) = (texture(F::Rgba8Unorm, samples), texture(F::Rgba8Unorm, 1));
    let depth_texture = texture(F::Depth32Float, samples);
    let [colour_view, resolved_view, depth_view] =
        [&colour, &resolved, &depth_texture].map(|t| t.create_view(&Default::default()));
    let row = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("host"),
        size: u64::from(row * SIZE),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    sky.prepare(&mut encoder, views).unwrap();
    let magenta = wgpu::Color { r: 1.0, g: 0.0, b: 1.0, a: 1.0 };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &colour_view,
            depth_slice: None,
            resolve_target: (samples > 1).then_some(&resolved_view),
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(magenta), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: depth.map(|(_, value)| wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(value), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    sky.draw(&mut pass, index);
    drop(pass);
    let source = if samples > 1 { &resolved } else { &colour };
    encoder.copy_texture_to_buffer(
        source.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
        },
        source.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, buffer.size()).unwrap();
    let row_of = |row: &[u8]| -> Vec<[u8; 4]> {
        row[..4 * SIZE as usize].chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
    };
    bytes.chunks(row as usize).flat_map(row_of).collect()
}

fn north() -> View {
    View::looking(0.0, 0.3, 1.0, 1.0)
}

const MAGENTA: [u8; 4] = [255, 0, 255, 255];

#[test]
fn the_sky_lies_behind_geometry_in_either_depth() {
    let free = drawn(None, 1, 0, &[north()]);
    assert!(free.iter().all(|pixel| *pixel != MAGENTA));
    for (direction, far, near) in [(DepthDirection::Standard, 1.0, 0.9999), (DepthDirection::Reversed, 0.0, 0.0001)] {
        assert_eq!(drawn(Some((direction, far)), 1, 0, &[north()]), free, "{direction:?}: open sky");
        let hidden = drawn(Some((direction, near)), 1, 0, &[north()]);
        assert!(hidden.iter().all(|pixel| *pixel == MAGENTA), "{direction:?}: behind geometry");
    }
}

#[test]
fn every_view_of_a_frame_has_its_own_camera() {
    let south = View::looking(3.0, 0.3, 1.0, 1.0);
    let both = [north(), south];
    assert_eq!(drawn(None, 1, 0, &both), drawn(None, 1, 0, &[north()]));
    assert_eq!(drawn(None, 1, 1, &both), drawn(None, 1, 0, &[south]));
    assert_ne!(drawn(None, 1, 0, &both), drawn(None, 1, 1, &both));
    let many: Vec<View> = (0..40).map(|i| View::looking(f64::from(i) * 0.1, 0.3, 1.0, 1.0)).collect();
    assert_eq!(drawn(None, 1, 30, &many), drawn(None, 1, 0, &[many[30]]), "buffers grow");
    assert!(drawn(None, 1, 7, &both).iter().all(|pixel| *pixel == MAGENTA), "a view that was not prepared is left out");
}

#[test]
fn multisampling_changes_little() {
    let (one, four) = (drawn(None, 1, 0, &[north()]), drawn(None, 4, 0, &[north()]));
    assert!(one.iter().zip(&four).all(|(a, b)| (0..3).all(|k| a[k].abs_diff(b[k]) <= 4)));
}

/// The texel of automatic exposure against the same picture's mean on the CPU.
#[test]
fn metering_puts_the_mean_on_middle_grey() {
    let settings = [("light.sun.altitude_deg", "-3"), ("output.width_px", "64"), ("output.height_px", "36")];
    let model = model("earth", &settings);
    let (frame, view) = (model.frame().unwrap(), model.view().unwrap());
    let render = |output| {
        let mut still = Still::new(gpu(), output, model.atmosphere()).unwrap();
        still.render(&frame, &view, 64, 36, &mut |_| true).unwrap()
    };
    let Pixels::Radiance(rgb) = render(Output::Radiance).pixels else { panic!("radiance was asked for") };
    let luminance: Vec<f64> =
        rgb.chunks(3).map(|c| f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]).max(0.0)).collect();
    let mean = luminance.iter().sum::<f64>() / luminance.len() as f64;
    let logs: Vec<f64> = luminance.iter().filter(|l| **l >= 1e-3 * mean).map(|l| l.log2()).collect();
    let expected = 0.18 / (logs.iter().sum::<f64>() / logs.len() as f64).exp2();
    let metered = render(Output::Display).exposure;
    assert!((metered / expected - 1.0).abs() < 1e-3, "{metered} {expected}");
}

#[test]
fn targets_that_cannot_hold_a_sky_are_refused() {
    let gpu = gpu();
    let scene = model("earth", &[]).scene().clone();
    let good = Target::new(F::Rgba8Unorm, Output::Display);
    for bad in [
        Target::new(F::Depth32Float, Output::Display),
        Target::new(F::R8Unorm, Output::Display),
        Target::new(F::Rgba8Unorm, Output::Radiance),
        Target { samples: 3, ..good },
        Target { samples: 16, ..good },
        Target { samples: 4, ..Target::new(F::Rgba32Float, Output::Radiance) },
        Target { depth: Some((F::Depth32FloatStencil8, DepthDirection::Standard)), ..good },
        Target { depth: Some((F::Rgba8Unorm, DepthDirection::Standard)), ..good },
    ] {
        let error = Sky::with_scene(&gpu.device, &gpu.queue, &bad, &scene).err();
        assert!(matches!(error, Some(himmel::Error::Gpu(GpuError::Target(_)))), "{bad:?}");
    }
}

/// 1,200 scenes that nobody would make: no pixel may be NaN or infinite.
#[test]
fn random_scenes_have_finite_pixels() {
    let mut random = himmel_tests::Random::new(11);
    for (preset, quality) in [("earth", "high"), ("mars-reference", "film"), ("earth-haze", "low"), ("giant", "medium")]
    {
        let model = model(preset, &[("air.quality", quality)]);
        let mut still = Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap();
        for scene in 0..300 {
            let mut frame = model.frame().unwrap();
            frame.altitude_m = 10f64.powf(random.within(-1.0, 9.0));
            frame.sun.direction = himmel::glam::DVec3::new(
                random.within(-1.0, 1.0),
                random.within(-1.0, 1.0),
                random.within(-1.0, 1.0) * 10f64.powf(random.within(-6.0, 0.0)),
            )
            .normalize();
            frame.sun.disc_direction = frame.sun.direction;
            frame.sun.radius_rad = 10f64.powf(random.within(-6.0, 0.0));
            let view = View::looking(
                random.within(0.0, 6.3),
                random.within(-1.57, 1.57) * 10f64.powf(random.within(-5.0, 0.0)),
                10f64.powf(random.within(-4.0, 0.49)),
                1.0,
            );
            if scene % 3 == 0 {
                let above = SunState { direction: himmel::glam::DVec3::Z, ..frame.sun };
                frame.other_suns = vec![above; 1 + scene % 2];
            }
            let picture = still.render(&frame, &view, 8, 8, &mut |_| true).unwrap();
            let Pixels::Radiance(rgb) = &picture.pixels else { panic!("radiance was asked for") };
            // A NaN may come out of the final clamp as the largest float: nothing real is near it. The smallest disc has 4e16.
            assert!(rgb.iter().all(|value| value.is_finite() && value.abs() < 1e20), "{preset} {frame:?} {view:?}");
        }
    }
}

/// A host may record several frames before it submits the first.
#[test]
fn frames_may_be_recorded_ahead() {
    let gpu = gpu();
    let scene = model("earth", &[]).scene().clone();
    let target = Target::new(F::Rgba8Unorm, Output::Display);
    let mut sky = Sky::with_scene(&gpu.device, &gpu.queue, &target, &scene).unwrap();
    for _ in 0..3 {
        let mut recorded = Vec::new();
        for _ in 0..3 {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            sky.prepare(&mut encoder, &[north()]).unwrap();
            recorded.push(encoder.finish());
        }
        gpu.queue.submit(recorded);
        gpu.wait().unwrap();
    }
}

/// Hosts keep the sky in resources that several threads see.
#[test]
fn the_sky_is_send_and_sync() {
    fn check<T: Send + Sync>() {}
    check::<Sky>();
    check::<himmel::SkyModel>();
}

/// What the pixels of the disc add up to is the Sun's illuminance, whatever the projection and the size of a pixel.
#[test]
fn the_disc_keeps_its_flux() {
    let base = [
        ("air.enabled", "off"),
        ("ground.enabled", "off"),
        ("output.exposure", "none"),
        ("light.sun.altitude_deg", "47"),
    ];
    let cases: [(&str, himmel_tests::Settings, f64); 5] = [
        ("narrow", &[("camera.look", "sun"), ("camera.fov_deg", "2")], 0.01),
        ("normal", &[("camera.look", "sun"), ("camera.fov_deg", "40")], 0.03),
        ("wide", &[("camera.look", "S,30"), ("camera.fov_deg", "100"), ("light.sun.azimuth_deg", "200")], 0.08),
        ("fisheye", &[("camera.look", "zenith"), ("camera.projection", "fisheye"), ("camera.fov_deg", "180")], 0.08),
        (
            "equirect",
            &[("camera.projection", "equirect"), ("output.width_px", "512"), ("output.height_px", "256")],
            0.08,
        ),
    ];
    for (name, settings, tolerance) in cases {
        let size = [("output.width_px", "240"), ("output.height_px", "240")];
        let model = model("earth", &[&base[..], &size, settings].concat());
        let (frame, view, size) = (model.frame().unwrap(), model.view().unwrap(), model.scene().output.clone());
        let (width, height) = (size.width_px, size.height_px);
        let mut still = Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap();
        let picture = still.render(&frame, &view, width, height, &mut |_| true).unwrap();
        let Pixels::Radiance(rgb) = &picture.pixels else { panic!("radiance was asked for") };
        let ndc = |x: f64, y: f64| [2.0 * x / f64::from(width) - 1.0, 1.0 - 2.0 * y / f64::from(height)];
        let mut lux = 0.0;
        for (i, pixel) in rgb.chunks(3).enumerate() {
            let luminance = f64::from(0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2]);
            let (x, y) = (f64::from(i as u32 % width), f64::from(i as u32 / width));
            let corners =
                [(0.0, 0.5), (1.0, 0.5), (0.5, 0.0), (0.5, 1.0)].map(|(dx, dy)| view.direction(ndc(x + dx, y + dy)));
            if let ([Some(left), Some(right), Some(top), Some(bottom)], true) = (corners, luminance > 0.0) {
                lux += luminance * (right - left).cross(bottom - top).length();
            }
        }
        let expected = model.light().unwrap().sun.illuminance_lx;
        println!("{name}: {:.3}", lux / expected);
        assert!((lux / expected - 1.0).abs() < tolerance, "{name}: {lux} of {expected} lx");
    }
}
