//! Blocks on a slab in the evening sun, drawn by a renderer of its own, and Himmel's sky behind them: `own_renderer.png`.
//! The faces towards the low Sun, off to the left, are warm and the others blue-grey from the sky. The inset is a second
//! camera in the same frame that looks into the Sun: there the same blocks show their dark sides.
//!
//! `cargo run -p himmel --example own_renderer [FILE.png]`
//!
//! The host owns everything: device, HDR target with four samples, depth that is 1 near and 0 far, shaders, pass, tone
//! mapping. Himmel is told the formats once (`Target`), prepares small uploads each frame and draws into the host's pass.
//! The five places where the two meet are numbered; `gpu.rs` is plain wgpu.

mod gpu;

use std::path::PathBuf;

use himmel::glam::{DMat4, DVec3};
use himmel::{DepthDirection, Observer, Output, Picture, Pixels, Preset, Sky, Target, View, picture};

use gpu::{bind, block_pipeline, display_pipeline, filled_buffer, open_device, read_rgb, texture};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const SIZE: (u32, u32) = (1280, 720);
const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const SAMPLES: u32 = 4;
/// Albedo of the slab that the blocks stand on, and that lights them from below.
const SLAB_ALBEDO: f32 = 0.25;

/// A camera of the host, in its own world: x east, y up, z south, metres.
struct Camera {
    eye: DVec3,
    azimuth_deg: f64,
    altitude_deg: f64,
    fov_deg: f64,
    /// Left, top, width, height in pixels.
    viewport: [f32; 4],
    /// The inset lies on top of the main view, so it gets the nearer half of the depth range.
    depth_range: [f32; 2],
}

const CAMERAS: [Camera; 2] = [
    Camera {
        eye: DVec3::new(0.0, 1.7, 0.0),
        azimuth_deg: 345.0,
        altitude_deg: 4.0,
        fov_deg: 44.0,
        viewport: [0.0, 0.0, SIZE.0 as f32, SIZE.1 as f32],
        depth_range: [0.0, 0.5],
    },
    Camera {
        eye: DVec3::new(6.0, 1.7, -6.0),
        azimuth_deg: 266.0,
        altitude_deg: 4.0,
        fov_deg: 40.0,
        viewport: [936.0, 24.0, 320.0, 180.0],
        depth_range: [0.5, 1.0],
    },
];

impl Camera {
    fn clip_from_view(&self) -> DMat4 {
        let aspect = f64::from(self.viewport[2]) / f64::from(self.viewport[3]);
        DMat4::perspective_infinite_reverse_rh(self.fov_deg.to_radians(), aspect, 0.1)
    }

    fn world_from_view(&self) -> DMat4 {
        let ((sin_a, cos_a), (sin_h, cos_h)) =
            (self.azimuth_deg.to_radians().sin_cos(), self.altitude_deg.to_radians().sin_cos());
        DMat4::look_to_rh(self.eye, DVec3::new(sin_a * cos_h, sin_h, -cos_a * cos_h), DVec3::Y).inverse()
    }
}

/// A box; the layout of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Block {
    centre: [f32; 3],
    half_size: [f32; 3],
    heading_rad: f32,
    albedo: [f32; 3],
}

fn blocks() -> Vec<Block> {
    let cube = |x: f32, z: f32, half: f32, heading_deg: f32, albedo| Block {
        centre: [x, half, z],
        half_size: [half; 3],
        heading_rad: heading_deg.to_radians(),
        albedo,
    };
    let slab = Block {
        centre: [-1.9, -0.1, -7.0],
        half_size: [6.0, 0.1, 3.5],
        heading_rad: 345f32.to_radians(),
        albedo: [SLAB_ALBEDO; 3],
    };
    vec![
        slab,
        cube(-1.5, -7.4, 0.9, 45.0, [0.7, 0.7, 0.68]),
        cube(-3.9, -5.4, 0.45, 30.0, [0.62, 0.28, 0.18]),
        cube(0.8, -7.0, 0.55, 62.0, [0.25, 0.4, 0.6]),
    ]
}

/// What the shader of the blocks is told, as in `scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct SceneUniform {
    clip_from_world: [[f32; 4]; 4],
    sun_direction: [f32; 4],
    sun_lx: [f32; 4],
    sky_lx: [f32; 4],
    ground_lx: [f32; 4],
}

fn main() -> Result<()> {
    let path = PathBuf::from(std::env::args_os().nth(1).unwrap_or("own_renderer.png".into()));
    picture::check_writable(&path)?;
    let (device, queue) = pollster::block_on(open_device())?;

    // 1. Once: a sky for our kind of pass. Radiance, because we tone map the whole picture ourselves at the end.
    let target = Target {
        colour: HDR,
        depth: Some((DEPTH, DepthDirection::Reversed)),
        samples: SAMPLES,
        output: Output::Radiance,
    };
    let mut sky = Sky::new(&device, &queue, &target, &Preset::named("earth")?)?;
    sky.set_observer(Observer::at("Potsdam")?).set_time("2012-09-06T19:00")?;
    // Linear targets get cd/m² unless one chooses an exposure; 16-bit floats want one.
    sky.set("output.exposure", "auto")?;

    // 2. Our world is y-up; Himmel's is east-north-up. The observer stands at our origin.
    let views = CAMERAS
        .each_ref()
        .map(|camera| View::from_camera(camera.clip_from_view(), View::enu_from_y_up() * camera.world_from_view()));

    // 3. The light of that sky for our own shader, and the exposure that it is drawn with.
    let light = sky.light()?;
    let world_from_enu = View::enu_from_y_up().transpose();
    let ground_lx =
        f64::from(SLAB_ALBEDO) * (light.sun.rgb_lx() * light.sun.direction_enu.z.max(0.0) + light.sky_rgb_lx());
    let vec4 = |v: DVec3| v.as_vec3().extend(0.0).to_array();
    let uniforms = CAMERAS.each_ref().map(|camera| SceneUniform {
        clip_from_world: (camera.clip_from_view() * camera.world_from_view().inverse()).as_mat4().to_cols_array_2d(),
        sun_direction: vec4(world_from_enu.transform_vector3(light.sun.direction_enu)),
        sun_lx: vec4(light.sun.rgb_lx()),
        sky_lx: vec4(light.sky_rgb_lx()),
        ground_lx: vec4(ground_lx),
    });
    let block_pipeline = block_pipeline(&device);
    let scene_groups = uniforms.map(|uniform| {
        let buffer = filled_buffer(&device, &queue, bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM);
        let exposure = wgpu::BindingResource::TextureView(sky.exposure_view());
        bind(&device, &block_pipeline, &[buffer.as_entire_binding(), exposure])
    });
    let blocks = blocks();
    let block_buffer = filled_buffer(&device, &queue, bytemuck::cast_slice(&blocks), wgpu::BufferUsages::VERTEX);

    let samples = texture(&device, HDR, SAMPLES, wgpu::TextureUsages::empty());
    let hdr = texture(&device, HDR, 1, wgpu::TextureUsages::TEXTURE_BINDING);
    let depth = texture(&device, DEPTH, SAMPLES, wgpu::TextureUsages::empty());
    let finished = texture(&device, DISPLAY, 1, wgpu::TextureUsages::COPY_SRC);
    let [samples_view, hdr_view, depth_view, finished_view] =
        [&samples, &hdr, &depth, &finished].map(|texture| texture.create_view(&Default::default()));
    let display_pipeline = display_pipeline(&device)?;
    let display_group = bind(&device, &display_pipeline, &[wgpu::BindingResource::TextureView(&hdr_view)]);

    let mut encoder = device.create_command_encoder(&Default::default());
    // 4. Each frame, before the pass: all of its views at once. The first one is metered for the exposure.
    sky.prepare(&mut encoder, &views)?;

    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("host: scene"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &samples_view,
            depth_slice: None,
            resolve_target: Some(&hdr_view),
            // Red would show wherever neither we nor the sky drew.
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::RED), store: wgpu::StoreOp::Discard },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    for (index, camera) in CAMERAS.iter().enumerate() {
        let [x, y, width, height] = camera.viewport;
        pass.set_viewport(x, y, width, height, camera.depth_range[0], camera.depth_range[1]);
        pass.set_pipeline(&block_pipeline);
        pass.set_bind_group(0, &scene_groups[index], &[]);
        pass.set_vertex_buffer(0, block_buffer.slice(..));
        pass.draw(0..36, 0..blocks.len() as u32);
        // 5. In the same pass, behind our geometry. It leaves its own pipeline and bind groups 0 and 1 bound.
        sky.draw(&mut pass, index);
    }
    drop(pass);

    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("host: display"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &finished_view,
            depth_slice: None,
            resolve_target: None,
            ops: Default::default(),
        })],
        ..Default::default()
    });
    pass.set_pipeline(&display_pipeline);
    pass.set_bind_group(0, &display_group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);

    let rgb = read_rgb(&device, &queue, encoder, &finished)?;
    let (width, height) = SIZE;
    // Exposure and times are for pictures that Himmel renders itself.
    let finished =
        Picture { width, height, pixels: Pixels::Display(rgb), exposure: 1.0, ev100: 0.0, times: Default::default() };
    picture::save(&finished, &path)?;
    println!(
        "{}: {}, the Sun at azimuth {:.1}°, altitude {:.1}°, {:.0} lx; {:.0} lx from the sky",
        path.display(),
        sky.model().local_time(),
        light.sun.azimuth_deg,
        light.sun.altitude_deg,
        light.sun.illuminance_lx,
        light.sky_illuminance_lx
    );
    Ok(())
}
