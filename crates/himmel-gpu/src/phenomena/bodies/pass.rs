//! Uniforms, maps and rectangles of bodies.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::model::{AlbedoMap, FarBody, MOST_FAR_BODIES};
use crate::error::GpuError;
use crate::frame::MOST_LIGHTS;
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, layout};
use crate::view::{Projection, View};

gpu_struct! {
    /// A sun as a body sees it; the fields are explained in `bodies.wgsl`.
    pub struct FarLightUniform {
        /// Towards it.
        pub direction: [f32; 3],
        /// Fills up.
        pub padding: f32,
        /// Irradiance.
        pub irradiance: [f32; 4],
    }
}

gpu_struct! {
    /// A body as a view sees it; the fields are explained in `bodies.wgsl`.
    pub struct FarBodyUniform {
        /// Towards its centre.
        pub centre: [f32; 3],
        /// To its centre, m.
        pub distance_m: f32,
        /// Row x of its frame.
        pub body_x: [f32; 4],
        /// Row y.
        pub body_y: [f32; 4],
        /// Row z.
        pub body_z: [f32; 4],
        /// Where the map is white.
        pub albedo: [f32; 4],
        /// Of its ground, m.
        pub radius_m: f32,
        /// Top of its air, m.
        pub top_m: f32,
        /// The camera above it, m.
        pub altitude_m: f32,
        /// To its limb, m.
        pub limb_m: f32,
        /// Sine of its apparent radius.
        pub sine: f32,
        /// Its air.
        pub air: u32,
        /// Layer of the tables per station.
        pub station: u32,
        /// Its map.
        pub map: u32,
        /// Suns in use.
        pub light_count: u32,
        /// Whether it stands before the home planet.
        pub is_near: u32,
        /// Whether the camera is in its air.
        pub within: u32,
        /// Fills up.
        pub padding: u32,
        /// Its suns.
        pub lights: [FarLightUniform; MOST_LIGHTS],
        /// What it touches.
        pub rectangle: [f32; 4],
    }
}

gpu_struct! {
    /// The bodies of a view; the fields are explained in `bodies.wgsl`.
    pub struct BodiesUniform {
        /// The nearest first.
        pub bodies: [FarBodyUniform; MOST_FAR_BODIES],
        /// Reflectance of red ground.
        pub four_from_red: [f32; 4],
        /// Of green ground.
        pub four_from_green: [f32; 4],
        /// Of blue ground.
        pub four_from_blue: [f32; 4],
        /// Bodies in use.
        pub count: u32,
        /// Fills up.
        pub padding_0: u32,
        /// Fills up.
        pub padding_1: u32,
        /// Fills up.
        pub padding_2: u32,
    }
}

/// A body from a camera.
pub(crate) struct Apparent<'a> {
    pub body: &'a FarBody,
    /// Its number in the frame.
    pub index: usize,
    /// From the camera to its centre, east-north-up, m.
    to_centre_m: DVec3,
    /// Of the top of its air, m.
    top_m: f64,
    /// Of the camera above its ground, m.
    pub altitude_m: f64,
    is_near: bool,
}

impl Apparent<'_> {
    /// Which air, 0 for none.
    pub(crate) fn air(&self) -> u32 {
        self.body.air.map_or(0, |air| air as u32 + 1)
    }

    /// Whether the camera is in its air.
    pub(crate) fn within(&self) -> bool {
        self.altitude_m <= self.top_m
    }
}

/// The bodies of a frame from a camera, the nearest first. `home_m`: from the camera to the home planet's centre; `above`: whether
/// the camera is above that planet's air; `tops_m` of the bodies' airs.
pub(crate) fn apparent<'a>(
    bodies: &'a [FarBody],
    shift_m: DVec3,
    home_m: f64,
    above: bool,
    tops_m: &[f64],
) -> Result<Vec<Apparent<'a>>, GpuError> {
    let mut seen = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let to_centre_m = body.centre_m - shift_m;
        let altitude_m = to_centre_m.length() - body.radius_m;
        if altitude_m <= 0.0 {
            return Err(GpuError::View(format!(
                "a camera is inside body {index}, {:.0} m below its ground",
                -altitude_m
            )));
        }
        let top_m = body.air.and_then(|air| tops_m.get(air)).copied().unwrap_or(0.0);
        let is_near = above && to_centre_m.length() < home_m;
        seen.push(Apparent { body, index, to_centre_m, top_m, altitude_m, is_near });
    }
    seen.sort_by(|a, b| a.to_centre_m.length().total_cmp(&b.to_centre_m.length()));
    Ok(seen)
}

impl BodiesUniform {
    /// For a view. `stations`: of the bodies in this order.
    pub(crate) fn new(view: &View, bodies: &[Apparent<'_>], stations: &[u32], wavelengths_nm: [f64; 4]) -> Self {
        let narrow = |four: [f64; 4]| four.map(|value| value as f32);
        let [red, green, blue] = AlbedoMap::four_from_rgb(wavelengths_nm).map(narrow);
        let mut uniform = Self {
            four_from_red: red,
            four_from_green: green,
            four_from_blue: blue,
            count: bodies.len().min(MOST_FAR_BODIES) as u32,
            ..Self::default()
        };
        let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
        let into = |v: DVec3| (view_from_enu * v).as_vec3().to_array();
        for ((slot, seen), &station) in uniform.bodies.iter_mut().zip(bodies).zip(stations) {
            let body = seen.body;
            let own = body.body_from_enu * view_from_enu.transpose();
            let row = |i: usize| own.row(i).extend(0.0).as_vec4().to_array();
            let (centre, distance_m) = (seen.to_centre_m.normalize_or(DVec3::Z), seen.to_centre_m.length());
            let within = seen.within();
            let sine = if within { 1.0 } else { (body.radius_m + seen.top_m) / distance_m };
            let mut lights = [FarLightUniform::default(); MOST_LIGHTS];
            for (slot, light) in lights.iter_mut().zip(&body.lights) {
                slot.direction = into(light.direction.normalize_or(DVec3::Z));
                slot.irradiance = narrow(light.irradiance);
            }
            let radius_rad = if within { PI } else { sine.asin() };
            *slot = FarBodyUniform {
                centre: into(centre),
                distance_m: distance_m as f32,
                body_x: row(0),
                body_y: row(1),
                body_z: row(2),
                albedo: narrow(body.albedo),
                radius_m: body.radius_m as f32,
                top_m: seen.top_m as f32,
                altitude_m: seen.altitude_m.max(0.5) as f32,
                limb_m: (seen.altitude_m * (2.0 * body.radius_m + seen.altitude_m)).sqrt() as f32,
                sine: sine as f32,
                air: seen.air(),
                station,
                map: seen.index as u32,
                light_count: body.lights.len().min(MOST_LIGHTS) as u32,
                is_near: u32::from(seen.is_near),
                within: u32::from(within),
                padding: 0,
                lights,
                rectangle: rectangle(view, centre, radius_rad).map_or(NOTHING, |corners| corners.map(|c| c as f32)),
            };
        }
        uniform
    }

    /// Whether a view shows any.
    fn shows_any(&self) -> bool {
        self.bodies.iter().take(self.count as usize).any(|body| body.rectangle != NOTHING)
    }
}

/// A rectangle without area.
const NOTHING: [f32; 4] = [2.0; 4];
/// Everything.
const WHOLE: [f64; 4] = [-1.0, -1.0, 1.0, 1.0];
/// Points of a circle that are looked at.
const RIM: usize = 64;

/// What a circle on the sky may touch of a view's part, with some room for refraction and soft edges: ndc of the part.
fn rectangle(view: &View, centre: DVec3, radius_rad: f64) -> Option<[f64; 4]> {
    let pixel_rad = view.degrees_per_pixel(view.rows_or_fewest()).to_radians();
    // Refraction lifts by 0.6° at the Earth's horizon.
    let radius = 1.02 * radius_rad + 0.02 + 3.0 * pixel_rad;
    let whole = circle(view, centre, radius).unwrap_or(WHOLE);
    let [left, bottom, width, height] = view.part;
    let x = |ndc: f64| ((0.5 + 0.5 * ndc - left) / width * 2.0 - 1.0).clamp(-1.0, 1.0);
    let y = |ndc: f64| ((0.5 + 0.5 * ndc - bottom) / height * 2.0 - 1.0).clamp(-1.0, 1.0);
    let part = [x(whole[0]), y(whole[1]), x(whole[2]), y(whole[3])];
    (part[2] > part[0] && part[3] > part[1]).then_some(part)
}

/// The corners of a circle on the sky in ndc of the picture; `None`: it may be anywhere.
fn circle(view: &View, centre: DVec3, radius: f64) -> Option<[f64; 4]> {
    if radius > 1.4 {
        return None;
    }
    let across = centre.any_orthonormal_vector();
    let other = centre.cross(across);
    let rim = (0..RIM).map(|i| {
        let (sin, cos) = (TAU * i as f64 / RIM as f64).sin_cos();
        // The corners of the polygon outside the circle.
        let angle = radius * 1.002;
        centre * angle.cos() + (across * cos + other * sin) * angle.sin()
    });
    let view_from_enu = DMat3::from_mat4(view.enu_from_view).transpose();
    let points: Vec<[f64; 2]> = match view.projection {
        Projection::Matrix(_) => {
            let [middle, right, top] = view.rays().ok()?;
            // The picture's point whose ray has a direction: middle + x · right + y · top = s · direction.
            let solved = |direction: DVec3| {
                let matrix = DMat3::from_cols(right, top, -(view_from_enu * direction));
                let solution = -(matrix.inverse() * middle);
                (solution.is_finite() && matrix.determinant().abs() > 1e-12).then_some(solution)
            };
            let rim: Vec<DVec3> = rim.map(solved).collect::<Option<_>>()?;
            if rim.iter().all(|point| point.z <= 0.0) {
                return Some([2.0; 4]);
            }
            if rim.iter().any(|point| point.z <= 0.0) {
                return None;
            }
            rim.iter().map(|point| [point.x, point.y]).collect()
        }
        Projection::Fisheye(span) => {
            if (view_from_enu * centre).angle_between(DVec3::Z) < radius + 0.1 {
                return None;
            }
            let place = |direction: DVec3| {
                let seen = view_from_enu * direction;
                let scale = seen.angle_between(-DVec3::Z) / (0.5 * span) / seen.truncate().length().max(1e-9);
                [seen.x * scale / view.aspect, seen.y * scale]
            };
            // Circles bulge between points of the rim where a fisheye spreads them.
            rim.map(place).collect()
        }
        Projection::Equirectangular => {
            let forward = view.enu_from_view.transform_vector3(-DVec3::Z);
            let azimuth = |d: DVec3| d.x.atan2(d.y) - forward.x.atan2(forward.y);
            let altitude = centre.z.clamp(-1.0, 1.0).asin();
            if altitude.abs() + radius > FRAC_PI_2 - 0.01 {
                return Some([-1.0, (altitude - radius) / FRAC_PI_2, 1.0, (altitude + radius) / FRAC_PI_2]);
            }
            let half = (radius.sin() / altitude.cos()).min(1.0).asin() / PI;
            let x = (azimuth(centre) / PI + 1.0).rem_euclid(2.0) - 1.0;
            let low = (altitude - radius) / FRAC_PI_2;
            let high = (altitude + radius) / FRAC_PI_2;
            if x - half < -1.0 || x + half > 1.0 {
                return Some([-1.0, low, 1.0, high]);
            }
            vec![[x - half, low], [x + half, high]]
        }
    };
    let mut corners = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for [x, y] in points {
        corners = [corners[0].min(x), corners[1].min(y), corners[2].max(x), corners[3].max(y)];
    }
    Some(corners)
}

/// What drawing bodies takes; made when there are some.
pub(crate) struct Bodies {
    pub layout: wgpu::BindGroupLayout,
    buffer: wgpu::Buffer,
    stride: u64,
    capacity: usize,
    sampler: wgpu::Sampler,
    even: Arc<AlbedoMap>,
    maps: [(Arc<AlbedoMap>, wgpu::TextureView); MOST_FAR_BODIES],
    map_bytes: u64,
    group: wgpu::BindGroup,
    /// Of each view: how many bodies are drawn.
    counts: Vec<u32>,
}

impl Bodies {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let size = size_of::<BodiesUniform>() as u64;
        let slots = [
            (0, Slot::Uniform(size, true)),
            (1, Slot::FilteredTable),
            (2, Slot::FilteredTable),
            (3, Slot::FilteredTable),
            (4, Slot::Sampler),
        ];
        let layout = layout(device, "bodies", wgpu::ShaderStages::VERTEX_FRAGMENT, &slots);
        let stride = size.next_multiple_of(u64::from(device.limits().min_uniform_buffer_offset_alignment));
        let capacity = 4;
        let buffer = room(device, stride * capacity as u64);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("albedo maps"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let even = Arc::new(AlbedoMap::even());
        let maps = std::array::from_fn(|_| (Arc::clone(&even), texture(device, queue, &even)));
        let group = group(device, &layout, &buffer, &maps, &sampler);
        Self { layout, buffer, stride, capacity, sampler, even, maps, map_bytes: 0, group, counts: Vec::new() }
    }

    /// Uploads maps that are new, and the uniforms of the metering view and all others.
    pub(crate) fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        bodies: &[FarBody],
        uniforms: &[BodiesUniform],
        write: &mut dyn FnMut(&wgpu::Buffer, u64, &[u8]),
    ) {
        let mut stale = false;
        for (index, slot) in self.maps.iter_mut().enumerate() {
            let wanted = bodies.get(index).and_then(|body| body.map.as_ref()).unwrap_or(&self.even);
            if !Arc::ptr_eq(&slot.0, wanted) {
                *slot = (Arc::clone(wanted), texture(device, queue, wanted));
                stale = true;
            }
        }
        if uniforms.len() > self.capacity {
            self.capacity = uniforms.len().next_power_of_two();
            self.buffer = room(device, self.stride * self.capacity as u64);
            stale = true;
        }
        if stale {
            let texels = |map: &AlbedoMap| map.levels().iter().map(|level| 4 * level.len() as u64).sum::<u64>();
            self.map_bytes = self.maps.iter().map(|(map, _)| texels(map)).sum();
            self.group = group(device, &self.layout, &self.buffer, &self.maps, &self.sampler);
        }
        for (slot, uniform) in uniforms.iter().enumerate() {
            write(&self.buffer, slot as u64 * self.stride, bytemuck::bytes_of(uniform));
        }
        let count = |uniform: &BodiesUniform| if uniform.shows_any() { uniform.count } else { 0 };
        self.counts = uniforms.iter().map(count).collect();
    }

    /// The frame has none.
    pub(crate) fn clear(&mut self) {
        self.counts.clear();
    }

    /// How many bodies are drawn of a view; the metering view is slot 0.
    pub(crate) fn count(&self, slot: usize) -> u32 {
        self.counts.get(slot).copied().unwrap_or(0)
    }

    /// Draws them after its pipeline and other groups are set.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, slot: usize) {
        pass.set_bind_group(2, &self.group, &[(slot as u64 * self.stride) as u32]);
        pass.draw(0..6, 0..self.count(slot));
    }

    /// Memory of the maps in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.map_bytes
    }
}

fn room(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("bodies"),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffer: &wgpu::Buffer,
    maps: &[(Arc<AlbedoMap>, wgpu::TextureView); MOST_FAR_BODIES],
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let [a, b, c] = maps;
    let bound = [
        (0, Bound::Part(buffer, size_of::<BodiesUniform>() as u64)),
        (1, Bound::View(&a.1)),
        (2, Bound::View(&b.1)),
        (3, Bound::View(&c.1)),
        (4, Bound::Sampler(sampler)),
    ];
    bind(device, "bodies", layout, &bound)
}

fn texture(device: &wgpu::Device, queue: &wgpu::Queue, map: &AlbedoMap) -> wgpu::TextureView {
    let [width, height] = map.size();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("albedo map"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: map.levels().len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, texels) in map.levels().iter().enumerate() {
        let side = |side: u32| (side >> level).max(1);
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level: level as u32, ..texture.as_image_copy() },
            texels.as_flattened(),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side(width) * 4), rows_per_image: None },
            wgpu::Extent3d { width: side(width), height: side(height), depth_or_array_layers: 1 },
        );
    }
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every direction of a disc that a view shows lies in its rectangle.
    #[test]
    fn rectangles_hold_their_discs() {
        let projections = [
            Projection::Matrix(glam::DMat4::perspective_infinite_reverse_rh(1.2, 1.5, 1.0)),
            Projection::Fisheye(3.5),
            Projection::Fisheye(TAU),
            Projection::Equirectangular,
        ];
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for case in 0..2000 {
            let projection = projections[case % 4];
            let view = View::with_projection(TAU * random(), PI * (random() - 0.5), projection, 1.5);
            let altitude = PI * (random() - 0.5);
            let azimuth = TAU * random();
            let centre = DVec3::new(altitude.cos() * azimuth.sin(), altitude.cos() * azimuth.cos(), altitude.sin());
            let radius = random() * random() * 1.5;
            let found = rectangle(&view, centre, radius);
            for i in 0..40 * 40 {
                let ndc = [(f64::from(i % 40) + 0.5) / 20.0 - 1.0, (f64::from(i / 40) + 0.5) / 20.0 - 1.0];
                let Some(direction) = view.direction(ndc) else { continue };
                if direction.angle_between(centre) < radius {
                    let Some([x0, y0, x1, y1]) = found else { panic!("{case}: nothing at {ndc:?}") };
                    let inside = (x0..=x1).contains(&ndc[0]) && (y0..=y1).contains(&ndc[1]);
                    assert!(inside, "{case} {projection:?}: {ndc:?} not in {found:?}");
                }
            }
        }
    }
}
