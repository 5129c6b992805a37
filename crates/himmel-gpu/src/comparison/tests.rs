//! The approximation's tables against their f64 twin, and its picture.

use std::f64::consts::PI;

use glam::DVec3;
use himmel_air::hillaire::{self, Settings};
use himmel_air::single::Ray;
use himmel_air::{AirParams, Atmosphere, Columns, GroundParams, Preset, geometry};

use super::{Hillaire, Redo, Stage};
use crate::gpu::Gpu;
use crate::output::params::Tonemap;
use crate::output::params::{Exposure, OutputParams};
use crate::renderer::{FrameState, SunState};
use crate::view::{Projection, View};

const ALTITUDE_M: f64 = 500.0;

fn gpu() -> Gpu {
    let wanted = std::env::var("HIMMEL_ADAPTER").ok();
    let gpu = Gpu::open(wanted.as_deref()).unwrap();
    eprintln!("adapter: {}", gpu.report());
    gpu
}

fn atmosphere(preset: &str) -> Atmosphere {
    Atmosphere::new(&Preset::named(preset).unwrap(), &AirParams::default(), &GroundParams::default())
}

/// The Sun in the south.
fn frame(sun_elevation_rad: f64) -> FrameState {
    let direction = DVec3::new(0.0, -sun_elevation_rad.cos(), sun_elevation_rad.sin());
    let sun = SunState {
        direction,
        disc_direction: direction,
        radius_rad: 0.0047,
        irradiance: [1.0; 4],
        disc: true,
        limb_darkening: true,
    };
    let output = OutputParams { exposure: Some(Exposure::Ev100(14.0)), ..OutputParams::default() };
    FrameState::new(sun, ALTITUDE_M, output)
}

fn southward(aspect: f64) -> View {
    View::looking(PI, 0.35, 1.0, aspect)
}

/// A two-dimensional texture's rows, top row first.
fn read<T: bytemuck::Pod>(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<T> {
    let (width, height) = (texture.width(), texture.height());
    let row = width * size_of::<T>() as u32;
    let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read"),
        size: u64::from(stride * height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, buffer.size()).unwrap();
    let rows = bytes.chunks_exact(stride as usize);
    rows.flat_map(|bytes| bytes[..row as usize].chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned))
        .collect()
}

/// Zenith cosine and cos φ of a node of the sky view: twin of the mapping in `hillaire_tables.wgsl`.
fn node(radius_m: f64, x: usize, y: usize) -> (f64, f64) {
    let horizon = geometry::horizon_cosine(radius_m, ALTITUDE_M);
    let (horizon_angle, s) = (horizon.acos(), (y % 50) as f64 / 49.0);
    let mu = if y < 50 {
        (horizon_angle * (1.0 - s * s)).cos().max(horizon + 1e-6)
    } else {
        (horizon_angle + (PI - horizon_angle) * s * s).cos().min(horizon - 1e-6)
    };
    (mu, 1.0 - 2.0 * (x as f64 / 199.0).powi(2))
}

/// The same formulas in f64: what lies between is f32, half floats in three tables (2e-4 each), filters whose weights
/// have eight bits (at most 1/512 of the difference of neighbours), and the medium's 256 nodes. A tenth of the tables'
/// own error.
#[test]
fn the_sky_view_is_that_of_the_twin() {
    let gpu = gpu();
    for preset in ["earth", "mars", "earth-haze"] {
        let atmosphere = atmosphere(preset);
        let (air, columns) = (atmosphere.sampled(), Columns::new(atmosphere.medium()));
        let twin = hillaire::Hillaire::build(&air, &columns, &Settings::USUAL);
        let mut hillaire =
            Hillaire::new(&gpu.device, &gpu.queue, &Stage::target(), &atmosphere, Tonemap::AgxPunchy).unwrap();
        let mut stage = Stage::new(&gpu, 16, 16).unwrap();
        for sun_elevation_deg in [60.0f64, 5.0, -2.0] {
            let sun_elevation_rad = sun_elevation_deg.to_radians();
            stage.hillaire(&mut hillaire, &frame(sun_elevation_rad), &southward(1.0), Redo::SkyOnly).unwrap();
            let texels: Vec<[u16; 4]> = read(&gpu, hillaire.sky_view());
            let mu_s = sun_elevation_rad.sin();
            let mut errors = Vec::new();
            for y in (0..100).step_by(3) {
                for x in (0..200).step_by(7) {
                    let (mu, cos_azimuth) = node(atmosphere.medium().bottom_radius_m, x, y);
                    let nu = mu * mu_s + ((1.0 - mu * mu) * (1.0 - mu_s * mu_s)).sqrt() * cos_azimuth;
                    let ray = Ray { altitude_m: ALTITUDE_M, mu, mu_s, nu };
                    let expected = twin.radiance(&air, &columns, &ray);
                    for k in 0..4 {
                        let got = half::f16::from_bits(texels[y * 200 + x][k]).to_f64() / 256.0;
                        // Below 1e-5 /sr (a hundred-thousandth of the day's sky) half floats have few digits.
                        let error = (got - expected[k]).abs() / expected[k].max(1e-5);
                        errors.push(if error.is_nan() { f64::INFINITY } else { error });
                    }
                }
            }
            errors.sort_by(f64::total_cmp);
            let (median, p99) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
            println!(
                "{preset} {sun_elevation_deg}°: median {median:.1e}, 99 % {p99:.1e}, worst {:.1e}",
                errors[errors.len() - 1]
            );
            assert!(median < 3e-3 && p99 < 1e-2, "{preset} {sun_elevation_deg}: {median} {p99}");
        }
    }
}

/// Blue above, brighter towards the Sun, white where it stands; every pixel opaque.
#[test]
fn the_picture_is_a_sky() {
    let gpu = gpu();
    let atmosphere = atmosphere("earth");
    let (width, height) = (192, 108);
    let mut hillaire =
        Hillaire::new(&gpu.device, &gpu.queue, &Stage::target(), &atmosphere, Tonemap::AgxPunchy).unwrap();
    let mut stage = Stage::new(&gpu, width, height).unwrap();
    let view = southward(f64::from(width) / f64::from(height));
    stage.hillaire(&mut hillaire, &frame(0.3), &view, Redo::Everything).unwrap();
    let pixels: Vec<[u8; 4]> = read(&gpu, stage.texture());
    let at = |x: u32, y: u32| pixels[(y * width + x) as usize].map(i32::from);
    let (top, beside, sun) = (at(10, 2), at(96, 40), at(96, 59));
    assert!(top[2] > top[0] + 20, "{top:?}");
    assert!(beside[1] > top[1] && sun[0] > 240 && sun[2] > 230, "{beside:?} {sun:?}");
    assert!(pixels.iter().all(|pixel| pixel[3] == 255));
    assert_eq!(hillaire.table_bytes(), 8 * (256 * 64 + 32 * 32 + 200 * 100 + 2 * 32 * 32 * 32));
}

#[test]
fn what_it_cannot_show_is_refused() {
    let gpu = gpu();
    let mut hillaire =
        Hillaire::new(&gpu.device, &gpu.queue, &Stage::target(), &atmosphere("earth"), Tonemap::AgxPunchy).unwrap();
    let mut refuse = |frame: &FrameState, view: &View| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        hillaire.prepare(&mut encoder, frame, view, Redo::SkyOnly).unwrap_err().to_string()
    };
    let high = FrameState { altitude_m: 4e5, ..frame(0.3) };
    assert!(refuse(&high, &southward(1.0)).contains("400 km"));
    let automatic = FrameState { output: OutputParams::default(), ..frame(0.3) };
    assert!(refuse(&automatic, &southward(1.0)).contains("exposure"));
    let fisheye = View { projection: Projection::Fisheye(3.0), ..southward(1.0) };
    assert!(refuse(&frame(0.3), &fisheye).contains("perspective"));
}
