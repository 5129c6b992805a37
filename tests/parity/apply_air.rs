//! The air before a host's picture, against differences of whole rays in f64, and with bad input.

use glam::{DMat4, DVec3};
use himmel::parts::air::single::Ray;
use himmel::parts::air::{AirParams, AirQuality, Atmosphere, GroundParams};
use himmel::parts::gpu::{FrameState, SkyRenderer, SunState};
use himmel::{ApplyAir, DepthDirection, Exposure, GpuError, Output, OutputParams, Preset, Projection, Target, View};
use himmel_tests::gpu;
use wgpu::util::DeviceExt;

const SIZE: u32 = 16;
const NEAR_M: f64 = 1.0;

fn atmosphere(preset: &str, quality: AirQuality) -> Atmosphere {
    let preset = Preset::named(preset).expect("a preset");
    let air = AirParams { quality: Some(quality), ..AirParams::default() };
    Atmosphere::new(&preset, &air, &GroundParams::default())
}

fn frame(altitude_m: f64, sun_deg: f64) -> FrameState {
    let (sin, cos) = sun_deg.to_radians().sin_cos();
    let direction = DVec3::new(0.0, cos, sin);
    let sun = SunState {
        direction,
        disc_direction: direction,
        radius_rad: 0.0047,
        irradiance: [1.0; 4],
        disc: true,
        limb_darkening: true,
    };
    let output = OutputParams { exposure: Some(Exposure::None), ..OutputParams::default() };
    FrameState::new(sun, altitude_m, output)
}

fn texture(format: wgpu::TextureFormat, usage: wgpu::TextureUsages, side: u32) -> wgpu::Texture {
    gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A picture of one colour and one depth with the air before it: its middle texel.
fn applied(
    renderer: &mut SkyRenderer,
    frame: &FrameState,
    view: &View,
    colour: f64,
    depth: f64,
    air: &ApplyAir<'_>,
) -> [f32; 4] {
    use wgpu::TextureUsages as Usage;
    let gpu = gpu();
    let whole = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING | Usage::COPY_SRC;
    let (colour_in, colour_out) = (
        texture(wgpu::TextureFormat::Rgba16Float, whole, SIZE),
        texture(wgpu::TextureFormat::Rgba32Float, whole, SIZE),
    );
    let depth_texture = texture(wgpu::TextureFormat::Depth32Float, whole, SIZE);
    let [a, b, c] = [&colour_in, &depth_texture, &colour_out].map(|texture| texture.create_view(&Default::default()));
    while renderer.rebuilding().is_some() {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.build(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait().expect("a device");
    }
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    renderer.prepare(&mut encoder, frame, std::slice::from_ref(view)).expect("a frame");
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("host"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &a,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r: colour, g: colour, b: colour, a: 1.0 }),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &b,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(depth as f32), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    renderer.apply_air(&mut encoder, &a, &b, &c, 0, air).expect("pictures that fit");
    let row = 256;
    let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("host"),
        contents: &vec![0u8; (row * SIZE) as usize],
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
    });
    encoder.copy_texture_to_buffer(
        colour_out.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
        },
        colour_out.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, buffer.size()).expect("a picture");
    let at = (row * SIZE / 2 + 16 * SIZE / 2) as usize;
    bytemuck::pod_read_unaligned(&bytes[at..at + 16])
}

/// The direction of that texel's middle.
fn middle(view: &View) -> DVec3 {
    let step = 1.0 / f64::from(SIZE);
    view.direction([step, -step]).expect("a direction")
}

/// What a stretch of air scatters is the whole ray's light minus what comes from behind the stretch through it. Only
/// within some per cent: how the two forms of the aerosol's peak are mixed depends on the ray as a whole, and in thick
/// dust light from behind also comes by small angles, which the difference leaves out.
#[test]
fn a_stretch_of_air_is_a_difference_of_rays() {
    for (preset, quality, tolerance) in
        [("bruneton2017", AirQuality::Film, 0.03), ("bruneton2017", AirQuality::High, 0.04)]
    {
        let atmosphere = atmosphere(preset, quality);
        let target = Target::new(wgpu::TextureFormat::Rgba16Float, Output::Radiance);
        let gpu = gpu();
        let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &target, &atmosphere).expect("a renderer");
        let radius_m = atmosphere.medium().bottom_radius_m;
        let mut worst: f64 = 0.0;
        for (altitude_m, sun_deg, elevation_deg, distance_m) in
            [(100.0, 30.0, 2.0, 2e4), (100.0, 3.0, 5.0, 8e4), (5000.0, 40.0, -2.0, 5e4), (1000.0, 60.0, 0.5, 1e5)]
        {
            let frame = frame(altitude_m, sun_deg);
            let azimuth = 60f64.to_radians();
            let view = View::looking(azimuth, f64::to_radians(elevation_deg), 0.01, 1.0);
            let direction = middle(&view);
            let (mu, mu_s) = (direction.z, frame.sun.direction.z);
            let nu = direction.dot(frame.sun.direction);
            let r0 = radius_m + altitude_m;
            let r = (r0 * r0 + distance_m * distance_m + 2.0 * r0 * mu * distance_m).sqrt();
            let ray = Ray { altitude_m, mu, mu_s, nu };
            let beyond = Ray {
                altitude_m: r - radius_m,
                mu: (r0 * mu + distance_m) / r,
                mu_s: (r0 * mu_s + distance_m * nu) / r,
                nu,
            };
            let whole = atmosphere.radiance(&ray, 64);
            let behind = atmosphere.radiance(&beyond, 64);
            let through: [f64; 4] = {
                let (a, b) = (
                    atmosphere.sun_transmittance(altitude_m, mu),
                    atmosphere.sun_transmittance(beyond.altitude_m, beyond.mu),
                );
                std::array::from_fn(|k| a[k] / b[k])
            };
            let expected = atmosphere.rec709(std::array::from_fn(|k| whole[k] - through[k] * behind[k]));
            // Depth along the axis, reversed: near / distance.
            let along = distance_m * direction.dot(view.enu_from_view.transform_vector3(-DVec3::Z));
            let air = ApplyAir { depth_direction: DepthDirection::Reversed, exposed: false, shadow: None };
            let found = applied(&mut renderer, &frame, &view, 0.0, NEAR_M / along, &air);
            for k in 0..3 {
                let error = f64::from(found[k]) / expected[k] - 1.0;
                println!(
                    "{preset} {quality:?} {altitude_m} m, Sun {sun_deg}°, {elevation_deg}°, {distance_m} m, {k}: {:.3} %",
                    100.0 * error
                );
                worst = worst.max(error.abs());
            }
        }
        assert!(worst < tolerance, "{preset} {quality:?}: {worst}");
    }
}

/// What the air scatters before something at a distance, against the f64 twin that marches to that distance: the same
/// model in clear air, haze and dust, so that only tables, half floats and cells are between them. Marched: as whole rays
/// are in air.rs. From froxels: straight lines between 32 slices; over one of optical depth 0.4 the light's bow is 2 %.
#[test]
fn a_stretch_of_air_agrees_with_the_twin() {
    for (preset, quality, tolerance) in [
        ("bruneton2017", AirQuality::Film, 0.005),
        ("bruneton2017", AirQuality::High, 0.03),
        ("earth-haze", AirQuality::Film, 0.005),
        ("mars-dusty", AirQuality::High, 0.03),
    ] {
        let atmosphere = atmosphere(preset, quality);
        let target = Target::new(wgpu::TextureFormat::Rgba16Float, Output::Radiance);
        let gpu = gpu();
        let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &target, &atmosphere).expect("a renderer");
        let mut worst: f64 = 0.0;
        for (altitude_m, sun_deg, elevation_deg, azimuth_deg, distance_m) in [
            (100.0, 30.0, 2.0, 60.0, 2e4),
            (100.0, 3.0, 5.0, 60.0, 8e4),
            (5000.0, 40.0, -2.0, 120.0, 5e4),
            (1000.0, 60.0, 0.5, 60.0, 1e5),
            (2.0, 20.0, 1.0, 10.0, 5e3),
            (2.0, 50.0, 0.2, 175.0, 500.0),
        ] {
            let frame = frame(altitude_m, sun_deg);
            let view = View::looking(f64::to_radians(azimuth_deg), f64::to_radians(elevation_deg), 0.01, 1.0);
            let direction = middle(&view);
            let nu = direction.dot(frame.sun.direction);
            let ray = Ray { altitude_m, mu: direction.z, mu_s: frame.sun.direction.z, nu };
            let expected = atmosphere.rec709(atmosphere.radiance_to(&ray, 256, distance_m));
            // Depth along the axis, reversed: near / distance.
            let along = distance_m * direction.dot(view.enu_from_view.transform_vector3(-DVec3::Z));
            let air = ApplyAir { depth_direction: DepthDirection::Reversed, exposed: false, shadow: None };
            let found = applied(&mut renderer, &frame, &view, 0.0, NEAR_M / along, &air);
            for k in 0..3 {
                let error = f64::from(found[k]) / expected[k] - 1.0;
                println!(
                    "{preset} {quality:?} {altitude_m} m, Sun {sun_deg}°, {elevation_deg}°, {azimuth_deg}°, {distance_m} m, {k}: {:.3} %",
                    100.0 * error
                );
                worst = worst.max(error.abs());
            }
        }
        println!("{preset} {quality:?}: worst {:.2} %", 100.0 * worst);
        assert!(worst < tolerance, "{preset} {quality:?}: {worst}");
    }
}

/// Standard depth and an orthographic camera see the same air; infinity stays as it was; a colour is dimmed.
#[test]
fn depth_conventions_agree() {
    let atmosphere = atmosphere("bruneton2017", AirQuality::High);
    let gpu = gpu();
    let target = Target::new(wgpu::TextureFormat::Rgba16Float, Output::Radiance);
    let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &target, &atmosphere).expect("a renderer");
    let frame = frame(500.0, 25.0);
    let looking = View::looking(1.0, 0.02, 0.01, 1.0);
    let air = |depth_direction| ApplyAir { depth_direction, exposed: false, shadow: None };
    let distance_m = 3e4;
    let reversed =
        applied(&mut renderer, &frame, &looking, 1000.0, NEAR_M / distance_m, &air(DepthDirection::Reversed));
    let (near, far) = (10.0, 1e6);
    let standard = View { projection: Projection::Matrix(DMat4::perspective_rh(0.01, 1.0, near, far)), ..looking };
    let depth = far / (far - near) * (1.0 - near / distance_m);
    let found = applied(&mut renderer, &frame, &standard, 1000.0, depth, &air(DepthDirection::Standard));
    // f32 depth near 1 holds the distance within a few per cent.
    for k in 0..3 {
        assert!((found[k] / reversed[k] - 1.0).abs() < 0.02, "{found:?} {reversed:?}");
    }
    assert!(reversed[0] > 0.0 && reversed[0] < 1e5);
    let ortho =
        View { projection: Projection::Matrix(DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 0.0, 1e5)), ..looking };
    let found = applied(&mut renderer, &frame, &ortho, 1000.0, distance_m / 1e5, &air(DepthDirection::Standard));
    for k in 0..3 {
        assert!((found[k] / reversed[k] - 1.0).abs() < 0.02, "{found:?} {reversed:?}");
    }
    let nothing = applied(&mut renderer, &frame, &looking, 1000.0, 0.0, &air(DepthDirection::Reversed));
    assert_eq!(nothing[..3], [1000.0; 3]);
}

#[test]
fn pictures_that_do_not_fit_are_refused() {
    use wgpu::TextureUsages as Usage;
    let atmosphere = atmosphere("bruneton2017", AirQuality::Low);
    let gpu = gpu();
    let target = Target::new(wgpu::TextureFormat::Rgba16Float, Output::Radiance);
    let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &target, &atmosphere).expect("a renderer");
    let whole = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
    let view_of = |format, side| texture(format, whole, side).create_view(&Default::default());
    let colour = view_of(wgpu::TextureFormat::Rgba16Float, 16);
    let out = view_of(wgpu::TextureFormat::Rgba16Float, 16);
    let depth = view_of(wgpu::TextureFormat::Depth32Float, 16);
    let small = view_of(wgpu::TextureFormat::Depth32Float, 8);
    let air = ApplyAir { depth_direction: DepthDirection::Reversed, exposed: false, shadow: None };
    let mut try_it = |a, b, c, index, fisheye| -> Result<(), GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut view = View::looking(0.0, 0.0, 1.0, 1.0);
        if fisheye {
            view.projection = Projection::Fisheye(3.0);
        }
        renderer.prepare(&mut encoder, &frame(2.0, 30.0), &[view])?;
        let result = renderer.apply_air(&mut encoder, a, b, c, index, &air);
        gpu.queue.submit([encoder.finish()]);
        result
    };
    for (what, words) in [
        (try_it(&colour, &small, &out, 0, false), "8×8"),
        (try_it(&colour, &out, &out, 0, false), "holds no depth"),
        (try_it(&colour, &depth, &colour, 0, false), "two textures"),
        (try_it(&depth, &depth, &out, 0, false), "holds no floats"),
        (try_it(&colour, &depth, &out, 3, false), "not prepared"),
        (try_it(&colour, &depth, &out, 0, true), "projection matrix"),
    ] {
        let error = what.expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(try_it(&colour, &depth, &out, 0, false), Ok(()));
}
