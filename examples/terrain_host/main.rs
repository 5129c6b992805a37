//! Real relief in the evening sun, drawn by a renderer of its own, and Himmel's air in front of it: `terrain_host.png`.
//! From a summit one sees the Bernese Alps: their western slopes are lit, their valleys lie in shadow, and each ridge is
//! paler and bluer than the one before it, until the last has the colour of the sky.
//!
//! `cargo run --release -p himmel --example terrain_host`                                Bernese Alps from the Niesen
//! `cargo run --release -p himmel --example terrain_host -- --altitude 200e3`            Europe from 200 km
//! `cargo run --release -p himmel --example terrain_host -- --planet mars --altitude 200e3`   Olympus Mons from 200 km
//!
//! The host owns device, textures, meshes, shaders, shadow map and tone mapping. The four places where it meets Himmel are
//! numbered. `relief.rs` reads the height maps, `mesh.rs` bends them around the planet, `options.rs` is the command line,
//! `gpu.rs` is plain wgpu. Its pictures have four samples for each pixel by being drawn at twice the size, because
//! `apply_air` wants single samples.

mod gpu;
mod mesh;
mod options;
mod relief;

use std::path::{Path, PathBuf};

use himmel::glam::{DMat4, DVec3};
use himmel::{
    ApplyAir, DepthDirection, Light, Output, Pace, Picture, Pixels, Preset, Scene, ShadowMap, Sky, SkyModel, Target,
    View, picture,
};

use gpu::{
    TerrainPipelines, begin_pass, bind, display_pipeline, filled_buffer, open_device, read_rgb, shadow_sampler,
    shadow_texture, texture,
};
use mesh::{Mesh, Standpoint};
use options::Options;
use relief::Relief;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const SHADOW_PIXELS: u32 = 2048;
/// How far relief stands above or below the foot of the camera, as far as the Sun's camera cares.
const MOUNTAINS_M: f64 = 6e3;
/// Entries of the table of light, and where it begins: the root of −12.96° / 90°, late in civil twilight.
const LIGHTS: usize = 32;
const LIGHT_LOW: f64 = -0.38;

/// What the shaders of the terrain are told, as in `terrain.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct SceneUniform {
    clip_from_enu: [[f32; 4]; 4],
    shadow_from_enu: [[f32; 4]; 4],
    sun: [f32; 4],
    centre: [f32; 4],
    ground: [[f32; 4]; 5],
    sun_lx: [[f32; 4]; LIGHTS],
    sky_lx: [[f32; 4]; LIGHTS],
}

/// The host's camera: it stands in the origin of its east, north, up.
struct Camera {
    clip_from_view: DMat4,
    enu_from_view: DMat4,
}

impl Camera {
    fn new(options: &Options, at: &Standpoint) -> Self {
        let fov_rad = options.fov_deg.to_radians();
        let aspect = f64::from(options.size.0) / f64::from(options.size.1);
        // The horizon lies a tenth of the picture above its middle.
        let altitude_rad = options.altitude_deg.map_or(-at.dip_rad() - fov_rad / 10.0, f64::to_radians);
        let above_m = options.above_ground_m;
        let far_m = 3.0 * at.radius_m * at.dip_rad() + 2e6;
        let near_m = (above_m / 8.0).max(1.0);
        let clip_from_view = if options.orthographic {
            let half_m = above_m / altitude_rad.sin().abs().max(0.05) * (0.5 * fov_rad).tan();
            let [near, far] = match options.depth {
                DepthDirection::Standard => [0.0, far_m],
                DepthDirection::Reversed => [far_m, 0.0],
            };
            DMat4::orthographic_rh(-aspect * half_m, aspect * half_m, -half_m, half_m, near, far)
        } else {
            match options.depth {
                DepthDirection::Standard => DMat4::perspective_rh(fov_rad, aspect, near_m, far_m),
                DepthDirection::Reversed => DMat4::perspective_infinite_reverse_rh(fov_rad, aspect, 1.0),
            }
        };
        let looking = View::looking(options.azimuth_deg.to_radians(), altitude_rad, fov_rad, aspect);
        Self { clip_from_view, enu_from_view: looking.enu_from_view }
    }

    fn clip_from_enu(&self) -> DMat4 {
        self.clip_from_view * self.enu_from_view.inverse()
    }

    fn forward(&self) -> DVec3 {
        self.enu_from_view.transform_vector3(-DVec3::Z)
    }
}

/// The Sun's camera: a square of ground before ours, 60 km wide or as wide as one sees from higher up.
struct SunCamera {
    clip_from_enu: DMat4,
    texel_m: f64,
}

impl SunCamera {
    fn new(towards_sun: DVec3, forward: DVec3, above_ground_m: f64) -> Self {
        let half_m = (1.5 * above_ground_m).clamp(30e3, 300e3);
        let level = DVec3::new(forward.x, forward.y, 0.0);
        let middle = 0.8 * half_m * level - above_ground_m * DVec3::Z;
        // Mountains outside of the square still shade it.
        let back_m = 2.0 * half_m;
        let up = if towards_sun.z.abs() > 0.99 { DVec3::Y } else { DVec3::Z };
        let view_from_enu = DMat4::look_to_rh(middle + back_m * towards_sun, -towards_sun, up);
        // A low Sun sees the square flat, with mountains that stand up from it.
        let flat_m = (half_m * towards_sun.z.abs() + MOUNTAINS_M).min(half_m);
        let clip_from_view = DMat4::orthographic_rh(-half_m, half_m, -flat_m, flat_m, 0.0, 2.0 * back_m);
        Self { clip_from_enu: clip_from_view * view_from_enu, texel_m: 2.0 * half_m / f64::from(SHADOW_PIXELS) }
    }
}

/// Altitude of the Sun for an entry of the table of light; inverse of `light_entry` in `terrain.wgsl`.
fn light_altitude_deg(entry: usize) -> f64 {
    let root = LIGHT_LOW + (1.0 - LIGHT_LOW) * entry as f64 / (LIGHTS - 1) as f64;
    90.0 * root * root.abs()
}

/// The light on the ground for every altitude of the Sun: from 200 km one sees places where it is high and where it sets.
fn lights_on_ground(scene: &Scene, ground_m: f64) -> Result<Vec<Light>> {
    let mut scene = scene.clone();
    scene.observer.altitude_m = Some(ground_m);
    let mut model = SkyModel::new(&scene)?;
    (0..LIGHTS)
        .map(|entry| {
            scene.sun.altitude_deg = Some(light_altitude_deg(entry));
            model.set_scene(&scene)?;
            Ok(model.light()?)
        })
        .collect()
}

fn main() -> Result<()> {
    let options = Options::parse(std::env::args().skip(1))?;
    picture::check_writable(&options.file)?;
    let preset = Preset::named(options.planet.name)?;

    // The host's world. Himmel's planet is a smooth sphere and its air begins there: the lowest ground in sight is put on it.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/terrain");
    let own = options.planet.maps.iter().map(|name| folder.join(format!("{name}.toml")));
    let paths: Vec<PathBuf> = own.chain(options.maps.iter().cloned()).collect();
    let relief = Relief::load(paths.iter().map(PathBuf::as_path))?;
    let mut at = Standpoint {
        latitude_deg: options.latitude_deg,
        longitude_deg: options.longitude_deg,
        radius_m: preset.medium.bottom_radius_m,
        altitude_m: options.above_ground_m,
    };
    let lowest_m = Mesh::around(&at, &relief, 256, 0.0).lowest_m;
    let lift_m = (-lowest_m).max(0.0);
    let ground_m = at.ground_m(&relief) + lift_m;
    at.altitude_m += ground_m;
    let camera = Camera::new(&options, &at);
    // A spoke every four pixels.
    let sectors = (90.0 / options.fov_deg * f64::from(options.size.1)).clamp(512.0, 4096.0) as usize;
    let mesh = Mesh::around(&at, &relief, sectors, lift_m);

    // 1. Once: a sky for our kind of pass. Radiance, because we tone map the whole picture ourselves at the end; with an
    // exposure, because 16-bit floats want one.
    let mut scene = Scene { preset: options.planet.name.into(), ..Scene::default() };
    scene.set("observer.place", &format!("{},{}", at.latitude_deg, at.longitude_deg))?;
    scene.set("clock.time", &options.time)?;
    scene.set("output.exposure", "auto")?;
    scene.observer.altitude_m = Some(at.altitude_m);
    if let Some([azimuth_deg, altitude_deg]) = options.sun_deg {
        (scene.sun.azimuth_deg, scene.sun.altitude_deg) = (Some(azimuth_deg), Some(altitude_deg));
    }
    let (device, queue) = pollster::block_on(open_device())?;
    let target = Target { colour: HDR, depth: Some((DEPTH, options.depth)), samples: 1, output: Output::Radiance };
    let mut sky = Sky::with_scene(&device, &queue, &target, &scene)?;
    // There is but one frame; a host that runs lets the orders of scattering come over several.
    sky.renderer_mut().set_pace(Pace::AtOnce);
    let views = [View::from_camera(camera.clip_from_view, camera.enu_from_view)];

    // 2. The light of that sky for our own shaders.
    let light = sky.light()?;
    let lights = lights_on_ground(&scene, ground_m)?;
    let sun_camera = SunCamera::new(light.sun.direction_enu, camera.forward(), options.above_ground_m);
    let vec4 = |v: DVec3, w: f64| v.as_vec3().extend(w as f32).to_array();
    let uniform = SceneUniform {
        clip_from_enu: camera.clip_from_enu().as_mat4().to_cols_array_2d(),
        shadow_from_enu: sun_camera.clip_from_enu.as_mat4().to_cols_array_2d(),
        sun: vec4(light.sun.direction_enu, sun_camera.texel_m),
        centre: vec4(DVec3::new(0.0, 0.0, -(at.radius_m + at.altitude_m)), 0.0),
        ground: options.planet.ground,
        sun_lx: std::array::from_fn(|entry| vec4(lights[entry].sun.rgb_lx(), 0.0)),
        sky_lx: std::array::from_fn(|entry| vec4(lights[entry].sky_rgb_lx(), 0.0)),
    };

    let (width, height) = options.size;
    let large = (2 * width, 2 * height);
    let bindable = wgpu::TextureUsages::TEXTURE_BINDING;
    let ground = texture(&device, large, HDR, bindable);
    let with_air = texture(&device, large, HDR, bindable);
    let depth = texture(&device, large, DEPTH, bindable);
    let shadow = shadow_texture(&device);
    let finished = texture(&device, options.size, DISPLAY, wgpu::TextureUsages::COPY_SRC);
    let [ground_view, with_air_view, depth_view, shadow_view, finished_view] =
        [&ground, &with_air, &depth, &shadow, &finished].map(|texture| texture.create_view(&Default::default()));

    let pipelines = TerrainPipelines::new(&device, options.depth);
    let uniform = filled_buffer(&device, &queue, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
    let vertices = filled_buffer(&device, &queue, bytemuck::cast_slice(&mesh.vertices), wgpu::BufferUsages::VERTEX);
    let indices = filled_buffer(&device, &queue, bytemuck::cast_slice(&mesh.indices), wgpu::BufferUsages::INDEX);
    let shadow_group = bind(&device, &pipelines.shadow, &[uniform.as_entire_binding()]);
    let terrain_group = bind(
        &device,
        &pipelines.terrain,
        &[
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(sky.exposure_view()),
            wgpu::BindingResource::TextureView(&shadow_view),
            wgpu::BindingResource::Sampler(&shadow_sampler(&device)),
        ],
    );
    let draw_mesh = |pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, group: &wgpu::BindGroup| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..mesh.indices.len() as u32, 0, 0..1);
    };

    let mut frame = device.create_command_encoder(&Default::default());
    sky.prepare(&mut frame, &views)?;

    let mut pass = begin_pass(&mut frame, "host: shadow", None, Some((&shadow_view, 1.0)));
    draw_mesh(&mut pass, &pipelines.shadow, &shadow_group);
    drop(pass);

    let far = match options.depth {
        DepthDirection::Standard => 1.0,
        DepthDirection::Reversed => 0.0,
    };
    let mut pass = begin_pass(&mut frame, "host: terrain", Some(&ground_view), Some((&depth_view, far)));
    draw_mesh(&mut pass, &pipelines.terrain, &terrain_group);
    // 3. In the same pass, behind our ground.
    sky.draw(&mut pass, 0);
    drop(pass);

    // 4. After the pass: what the air takes from the light of the ground, and adds to it. Where only sky was drawn it
    // leaves the picture alone.
    let air = ApplyAir {
        depth_direction: options.depth,
        exposed: true,
        shadow: options.shafts.then_some(ShadowMap { depth: &shadow_view, clip_from_enu: sun_camera.clip_from_enu }),
    };
    sky.apply_air(&mut frame, &ground_view, &depth_view, &with_air_view, 0, &air)?;

    let display = display_pipeline(&device)?;
    let display_group = bind(&device, &display, &[wgpu::BindingResource::TextureView(&with_air_view)]);
    let mut pass = begin_pass(&mut frame, "host: display", Some(&finished_view), None);
    pass.set_pipeline(&display);
    pass.set_bind_group(0, &display_group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);

    let rgb = read_rgb(&device, &queue, frame, &finished)?;
    // Exposure and times are for pictures that Himmel renders itself.
    let finished =
        Picture { width, height, pixels: Pixels::Display(rgb), exposure: 1.0, ev100: 0.0, times: Default::default() };
    picture::save(&finished, &options.file)?;
    println!(
        "{}: {}, {:.0} m above ground at {:.0} m; horizon {:.2}° down; the Sun at azimuth {:.1}°, altitude {:.1}°; {} triangles",
        options.file.display(),
        options.planet.name,
        options.above_ground_m,
        ground_m,
        at.dip_rad().to_degrees(),
        light.sun.azimuth_deg,
        light.sun.altitude_deg,
        mesh.indices.len() / 3
    );
    Ok(())
}
