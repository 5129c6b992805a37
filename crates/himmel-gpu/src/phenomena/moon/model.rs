//! The Moon as a frame needs it, its maps, and the f64 twin of its pixels.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use half::f16;
use himmel_air::refraction::Bending;

use super::heights::{MoonRelief, map_uv, sun_above};

/// Largest width of a map: WebGPU guarantees textures of 8,192.
const WIDEST: u32 = 8192;

/// Why a map cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "a map of the Moon is twice as wide as high, 2 × 1 to {WIDEST} pixels wide, got {width} × {height} with {bytes} bytes"
)]
pub struct MoonMapError {
    width: u32,
    height: u32,
    bytes: usize,
}

/// A map in latitude and longitude: longitude −180° on the left, north at the top. `N` bytes a texel, with smaller levels.
#[derive(Clone, PartialEq)]
pub struct MoonMap<const N: usize> {
    width: u32,
    height: u32,
    levels: Vec<Vec<[u8; N]>>,
}

impl<const N: usize> std::fmt::Debug for MoonMap<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MoonMap of {} × {} texels", self.width, self.height)
    }
}

impl<const N: usize> MoonMap<N> {
    /// The same everywhere.
    pub fn even(texel: [u8; N]) -> Self {
        Self { width: 2, height: 1, levels: vec![vec![texel; 2], vec![texel]] }
    }

    /// From rows of texels, and the levels of half their size by means of four.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; N]>) -> Result<Self, MoonMapError> {
        let fits = (2..=WIDEST).contains(&width) && width == 2 * height;
        if !fits || texels.len() != width as usize * height as usize {
            return Err(MoonMapError { width, height, bytes: N * texels.len() });
        }
        let mut levels = vec![texels];
        let (mut w, mut h) = (width as usize, height as usize);
        while w > 1 {
            let (half_w, half_h) = ((w / 2).max(1), (h / 2).max(1));
            let Some(before) = levels.last() else { break };
            let mean = |x: usize, y: usize| {
                let at = |x: usize, y: usize| before[y.min(h - 1) * w + x.min(w - 1)];
                let four = [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
                std::array::from_fn(|k| ((four.iter().map(|t| u32::from(t[k])).sum::<u32>() + 2) / 4) as u8)
            };
            let smaller = (0..half_h).flat_map(|y| (0..half_w).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
            levels.push(smaller);
            (w, h) = (half_w, half_h);
        }
        Ok(Self { width, height, levels })
    }

    /// Texels along a row and a column.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Texels by level, the finest first.
    pub fn levels(&self) -> &[Vec<[u8; N]>] {
        &self.levels
    }

    /// The same in another size, between texels.
    fn resampled(&self, width: u32) -> Self {
        if self.width == width {
            return self.clone();
        }
        let height = width / 2;
        let at = |i: u32| {
            let place = DVec2::new(
                (f64::from(i % width) + 0.5) / f64::from(width),
                (f64::from(i / width) + 0.5) / f64::from(height),
            );
            self.at(place).map(|value| (value * 255.0).round() as u8)
        };
        Self::new(width, height, (0..width * height).map(at).collect()).unwrap_or_else(|_| self.clone())
    }

    /// Between texels of the finest level, 0..=1. `own`: unit vector in the Moon's frame.
    pub fn sample(&self, own: DVec3) -> [f64; N] {
        self.at(map_uv(own))
    }

    fn at(&self, uv: DVec2) -> [f64; N] {
        let (w, h) = (self.width as usize, self.height as usize);
        let x = uv.x * w as f64 - 0.5;
        let y = (uv.y * h as f64 - 0.5).clamp(0.0, (h - 1) as f64);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let at = |dx: i64, dy: usize| {
            let column = (x0 as i64 + dx).rem_euclid(w as i64) as usize;
            self.levels[0][(y0 as usize + dy).min(h - 1) * w + column]
        };
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        std::array::from_fn(|k| {
            let [a, b, c, d] = [a, b, c, d].map(|texel| f64::from(texel[k]) / 255.0);
            (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + d * fx) * fy
        })
    }
}

/// What the Moon's ground is like.
#[derive(Clone, Debug, PartialEq)]
pub struct MoonMaps {
    /// Albedo up to a factor.
    pub albedo: MoonMap<1>,
    /// Normals: east, north, up as 0..=255.
    pub normals: Option<MoonMap<4>>,
    /// Heights, which stand back where there are normals.
    pub relief: Option<Arc<MoonRelief>>,
    /// That factor: the near side at full Moon has a mean of 1.
    pub albedo_scale: f64,
}

impl MoonMaps {
    /// Joins maps; the near side's mean, seen from the Earth's mean place under a Sun behind it, becomes 1.
    pub fn new(albedo: MoonMap<1>, normals: Option<MoonMap<4>>) -> Self {
        // Equal areas of the disc: at full Moon all of it shines alike.
        const SIDE: usize = 256;
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..SIDE * SIDE {
            let place = DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) * (2.0 / SIDE as f64) - 1.0;
            let rest = 1.0 - place.length_squared();
            if rest > 0.0 {
                sum += albedo.sample(DVec3::new(rest.sqrt(), place.x, place.y))[0];
                count += 1.0;
            }
        }
        let mean: f64 = sum / f64::max(count, 1.0);
        Self { albedo, normals, relief: None, albedo_scale: if mean > 0.0 { 1.0 / mean } else { 0.0 } }
    }

    /// The same with heights.
    pub fn with_relief(self, relief: Arc<MoonRelief>) -> Self {
        Self { relief: Some(relief), ..self }
    }

    /// Albedo and height in km by level, and the texels of a row; `None` without heights. Makes their map.
    pub(crate) fn with_heights(&self) -> Option<(u32, Vec<Vec<[f16; 2]>>)> {
        let heights = self.relief.as_ref()?.heights();
        let width = heights.width();
        let albedo = self.albedo.resampled(width);
        let code: [f16; 256] = std::array::from_fn(|i| f16::from_f32(i as f32 / 255.0));
        let both = |(albedo, heights): (&Vec<[u8; 1]>, &Vec<f16>)| {
            albedo.iter().zip(heights).map(|([albedo], height)| [code[usize::from(*albedo)], *height]).collect()
        };
        Some((width, albedo.levels.iter().zip(heights.levels()).map(both).collect()))
    }

    /// Albedo, east and north slope, and nothing, at the albedo's texels; `None` without normals.
    pub(crate) fn with_normals(&self) -> Option<MoonMap<4>> {
        let normals = self.normals.as_ref()?;
        let [width, height] = self.albedo.size();
        // Even ground has two texels: normals deserve more.
        let [w, h] = if width > 2 { [width, height] } else { normals.size() };
        let texel = |i: u32| {
            let (longitude, latitude) = (
                ((f64::from(i % w) + 0.5) / f64::from(w) - 0.5) * TAU,
                (0.5 - (f64::from(i / w) + 0.5) / f64::from(h)) * PI,
            );
            let own = DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
            let [albedo] = self.albedo.sample(own);
            let [east, north, ..] = normals.sample(own);
            [albedo, east, north, 0.0].map(|value| (value * 255.0).round() as u8)
        };
        MoonMap::new(w, h, (0..w * h).map(texel).collect()).ok()
    }

    /// Even ground.
    pub fn even() -> Self {
        Self { albedo: MoonMap::even([255]), normals: None, relief: None, albedo_scale: 1.0 }
    }
}

/// What is left of sunlight in the Earth's shadow, over the distance from its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct EclipseMap {
    /// Natural logarithms at the four wavelengths; at least two.
    pub ln_light: Vec<[f64; 4]>,
}

impl EclipseMap {
    /// Between nodes; beyond the last one as there.
    pub fn at(&self, node: f64) -> [f64; 4] {
        let last = self.ln_light.len().saturating_sub(1);
        let x = node.clamp(0.0, (last as f64 - 1e-3).max(0.0));
        let i = x as usize;
        let (Some(a), Some(b)) = (self.ln_light.get(i), self.ln_light.get(i + 1)) else { return [1.0; 4] };
        std::array::from_fn(|k| (a[k] + (x - i as f64) * (b[k] - a[k])).exp())
    }
}

/// How the Moon stands in the Earth's shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct MoonEclipse {
    /// Unit vector along the shadow's axis, away from the Sun, east-north-up.
    pub axis: DVec3,
    /// From the axis to the Moon's centre, at right angles to it, in the Moon's radii.
    pub offset: DVec3,
    /// Nodes of the map for a radius of the Moon.
    pub nodes_per_radius: f64,
    /// The light in the shadow.
    pub map: Arc<EclipseMap>,
}

impl MoonEclipse {
    /// What of the Sun's light reaches a point. `from_axis`: in radii of the Moon.
    pub fn light(&self, from_axis: DVec3) -> [f64; 4] {
        self.map.at(from_axis.length() * self.nodes_per_radius)
    }

    /// What of the Sun's light the whole disc gets, seen with the Sun behind.
    pub fn mean(&self) -> [f64; 4] {
        const SIDE: usize = 24;
        let x = self.axis.any_orthonormal_vector();
        let y = self.axis.cross(x);
        let (mut sum, mut count) = ([0.0; 4], 0.0);
        for i in 0..SIDE * SIDE {
            let place = DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) * (2.0 / SIDE as f64) - 1.0;
            if place.length_squared() < 1.0 {
                let light = self.light(self.offset + x * place.x + y * place.y);
                for k in 0..4 {
                    sum[k] += light[k];
                }
                count += 1.0;
            }
        }
        sum.map(|sum| sum / f64::max(count, 1.0))
    }
}

/// The Moon of a frame; directions are unit vectors east-north-up.
#[derive(Clone, Debug, PartialEq)]
pub struct MoonState {
    /// Towards its centre, without refraction.
    pub direction: DVec3,
    /// Towards its disc, refracted.
    pub disc_direction: DVec3,
    /// Apparent radius that is drawn, rad.
    pub radius_rad: f64,
    /// From it to the Sun.
    pub to_sun: DVec3,
    /// From it to the Earth's centre.
    pub to_earth: DVec3,
    /// Its own frame (x to the middle of the near side, z north) from east-north-up.
    pub body_from_enu: DMat3,
    /// Radiance of ground with relative albedo 1 for µ₀/(µ₀ + µ) = 1, relative to the preset's star at 1 au.
    pub sunlit: [f64; 4],
    /// The same in the Earth's light.
    pub earthlit: [f64; 4],
    /// The Earth's shadow, where it reaches the Moon.
    pub eclipse: Option<MoonEclipse>,
    /// The ground.
    pub maps: Arc<MoonMaps>,
    /// Factor on the slopes of the ground.
    pub relief: f64,
}

/// µ₀/(µ₀ + µ), 0 where the source is below the horizon   [seeliger1887]
pub fn lommel_seeliger(mu_0: f64, mu: f64) -> f64 {
    let lit = mu_0.max(0.0);
    lit / (lit + mu).max(1e-6)
}

/// A slope that turns from the eye hides behind others: those that are seen have at least half the sphere's cosine. `mu`: that of the
/// sphere.
pub fn towards_eye(normal: DVec3, eye: DVec3, mu: f64) -> DVec3 {
    (normal + eye * (0.5 * mu.max(0.0) - normal.dot(eye)).max(0.0)).normalize()
}

/// The normal of the sphere where a ray meets it. `aside`: what of the ray is across the direction of the centre; `sine` of
/// the sphere's apparent radius. Rays that miss get the nearest point of the limb.
pub fn sphere_normal(aside: DVec3, centre: DVec3, sine: f64) -> DVec3 {
    let sin_2 = aside.length_squared().min(sine * sine);
    let near = (1.0 - sin_2).sqrt() - (sine * sine - sin_2).max(0.0).sqrt();
    let mut across = aside * (near / sine);
    across *= (0.99999 / across.length().max(1e-9)).min(1.0);
    across - centre * (1.0 - across.length_squared()).max(0.0).sqrt()
}

impl MoonState {
    /// Even ground, full, the Sun and the Earth behind the observer; without light.
    pub fn even(direction: DVec3, radius_rad: f64) -> Self {
        Self {
            direction,
            disc_direction: direction,
            radius_rad,
            to_sun: -direction,
            to_earth: -direction,
            body_from_enu: DMat3::IDENTITY,
            sunlit: [0.0; 4],
            earthlit: [0.0; 4],
            eclipse: None,
            maps: Arc::new(MoonMaps::even()),
            relief: 1.0,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [self.direction, self.disc_direction, self.to_sun, self.to_earth];
        vectors.iter().all(|v| v.is_finite())
            && self.radius_rad.is_finite()
            && self.body_from_enu.is_finite()
            && self.sunlit.iter().chain(&self.earthlit).all(|value| value.is_finite())
    }

    /// Radiance in a direction as the air shows it, relative to the preset's star at 1 au, without the air's extinction;
    /// `None` beside the disc. `ray`: unit vector. The twin of `moon_light` for a pixel of no size.
    pub fn radiance(&self, ray: DVec3, bending: &Bending) -> Option<[f64; 4]> {
        let sine = self.radius_rad.sin();
        let level = DVec3::Z - ray * ray.z;
        let tangent = level / level.length().max(1e-6);
        let deviation = bending.deviation(ray.z.clamp(-1.0, 1.0).asin()).0;
        let base = ray - tangent * deviation - self.direction;
        let aside = base - self.direction * base.dot(self.direction);
        let off = aside.length();
        if off > sine || base.length_squared() > 2.0 {
            return None;
        }
        let normal = sphere_normal(aside, self.direction, sine);
        let mu = (1.0 - (off / sine).powi(2)).max(0.0).sqrt();
        let eye = -(self.direction + aside).normalize();
        Some(self.ground_radiance(normal, eye, mu))
    }

    /// Radiance of the ground. `normal`: of the sphere; `eye`: unit vector to the observer, `mu` its cosine. With heights, without the
    /// map of normals.
    pub fn ground_radiance(&self, normal: DVec3, eye: DVec3, mu: f64) -> [f64; 4] {
        let own = self.body_from_enu * normal;
        let albedo = self.maps.albedo.sample(own)[0] * self.maps.albedo_scale;
        let (mu_0, mu_seen) =
            self.relief_cosines(own, self.body_from_enu * eye).unwrap_or((normal.dot(self.to_sun), mu));
        let shade = self.eclipse.as_ref().map_or([1.0; 4], |eclipse| {
            let from_axis = eclipse.offset + normal - eclipse.axis * normal.dot(eclipse.axis);
            eclipse.light(from_axis)
        });
        let by_sun = lommel_seeliger(mu_0, mu_seen);
        let by_earth = lommel_seeliger(normal.dot(self.to_earth), mu);
        std::array::from_fn(|k| albedo * (self.sunlit[k] * shade[k] * by_sun + self.earthlit[k] * by_earth))
    }

    /// Cosines to the Sun, in shadow 0, and to the observer on ground with heights. `own`, `eye`: of the sphere and to the observer,
    /// in the Moon's frame.
    fn relief_cosines(&self, own: DVec3, eye: DVec3) -> Option<(f64, f64)> {
        let relief = self.maps.relief.as_ref().filter(|_| self.maps.normals.is_none() && self.relief > 0.0)?;
        let heights = relief.heights();
        let sun = self.body_from_enu * self.to_sun;
        let north = (DVec3::Z - own * own.z + DVec3::splat(1e-9)).normalize();
        let east = north.cross(own);
        let slopes = heights.slopes(own, 0.0, self.relief);
        let tilted = (own - slopes.x * east - slopes.y * north).normalize();
        let aside = DVec2::new(east.dot(sun), north.dot(sun));
        let level = aside.length().max(1e-4);
        let tan = own.dot(sun) / level;
        let horizon = heights.horizon(own, 0.0, self.relief, aside / level, tan);
        let tilted = towards_eye(tilted, eye, own.dot(eye));
        let eye_aside = DVec2::new(east.dot(eye), north.dot(eye));
        let eye_level = eye_aside.length().max(1e-4);
        let one_side = (eye_aside.dot(aside / level) / eye_level).max(0.0);
        let hidden = one_side * (1.0 - sun_above(own.dot(eye) / eye_level, horizon));
        Some((tilted.dot(sun).max(0.0) * sun_above(tan, horizon).max(hidden), tilted.dot(eye)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_a_shape() {
        assert!(MoonMap::new(4, 2, vec![[7u8]; 8]).is_ok());
        for (w, h, n) in [(4, 3, 12), (4, 2, 7), (0, 0, 0), (20_000, 10_000, 1), (1, 1, 1)] {
            let error = MoonMap::new(w, h, vec![[7u8]; n]).unwrap_err().to_string();
            assert!(error.contains("twice as wide"), "{error}");
        }
        let map = MoonMap::new(8, 4, vec![[100u8]; 32]).unwrap();
        assert_eq!(map.levels().len(), 4);
        assert!((map.sample(DVec3::new(-1.0, 1e-9, 0.1).normalize())[0] - 100.0 / 255.0).abs() < 1e-12);
    }

    #[test]
    fn the_near_sides_mean_is_one() {
        let texels = (0..32 * 16).map(|i| [(40 + (i * 37) % 180) as u8]).collect();
        let maps = MoonMaps::new(MoonMap::new(32, 16, texels).unwrap(), None);
        assert!((0.5..3.0).contains(&(maps.albedo_scale * 130.0 / 255.0)));
        assert_eq!(MoonMaps::even().albedo_scale, 1.0);
    }

    #[test]
    fn normals_are_those_of_a_sphere() {
        let centre = DVec3::new(0.3, 0.2, 0.9).normalize();
        for sine in [0.0045f64, 0.3, 0.9] {
            for share in [0.0, 0.3, 0.9, 0.999] {
                let side = centre.any_orthonormal_vector();
                let sin = sine * share;
                let ray = centre * (1.0 - sin * sin).sqrt() + side * sin;
                let normal = sphere_normal(side * sin, centre, sine);
                // The point on a sphere of radius `sine` at distance 1, along the ray.
                let point = centre + normal * sine;
                assert!(point.normalize().angle_between(ray) < 1e-5, "{sine} {share}");
                assert!((normal.length() - 1.0).abs() < 1e-12);
                // The cosine to the observer.
                assert!((-normal.dot(ray) - (1.0 - share * share).sqrt()).abs() < 5e-3);
            }
        }
    }
}
