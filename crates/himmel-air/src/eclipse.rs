//! Eclipses of the Sun: how much of its light passes a body that stands before it, anywhere in the air.
//!
//! Lengths on the sky are in radii of the Sun: `d` between the centres, `b` the occluder's radius. f32 then has six
//! digits for the last crescent, whatever the angles are. [`visible_part`] is exact to 4e-6 and costs eight arctangents;
//! [`EclipseTable`] is the same over `d` for one `b`, for a march that asks at every sample. Twin of `eclipse.wgsl`.
//!
//! **Known to look wrong**: the occluder is a smooth sphere (no valleys of the Moon, so no Baily's beads) without air of
//! its own, and the Sun has no chromosphere.

use std::f64::consts::{FRAC_2_PI, PI};

use glam::DVec3;
use himmel_core::interpolate::lerp;
use himmel_core::quadrature::gauss_legendre_unit;

/// Nodes of the ring that both discs share. Against 400: 4e-6 for occluders from 0.9 radii up, 4e-5 at worst (0.5); with
/// 4 nodes it would be 1.3e-4 and 1.4e-3.
pub const NODES: usize = 8;

/// Share of the flux of a limb-darkened disc that comes from outside the circle of µ: M(µ) = Σ 2 c_k µ^(k+2) / (k + 2)
///
/// Laws tested: 0 at the limb, 1 in the centre.
pub fn outer_flux<const N: usize>(mu: f64, coefficients: &[[f64; 6]; N]) -> [f64; N] {
    coefficients.map(|c| {
        let sum = c.iter().enumerate().rev().fold(0.0, |sum, (k, c)| sum * mu + 2.0 * c / (k as f64 + 2.0));
        sum * mu * mu
    })
}

/// Share of the Sun's light that passes a dark disc before it, 0..=1 by wavelength.
///
/// V = ∫₀¹ 2 r I(r) (1 − φ(r)/π) dr,   tan(φ/2) = √[(b − d + r)(b + d − r)] / √[(d + r − b)(d + r + b)]
///
/// r: distance from the Sun's centre.  I: [`limb_darkening`](crate::sun::limb_darkening), mean 1.  φ: half the angle of the ring of radius r
/// that is covered. Rings wholly bare or covered are summed in closed form by [`outer_flux`]; those that the occluder's
/// edge cuts by Gauss–Legendre in u with r = r₀ + (r₁ − r₀) u²(3 − 2u), which takes the square roots out of both ends.
/// Every factor is a sum of positive terms: the last crescent keeps its digits.
///
/// `d`: separation of the centres, `b`: radius of the occluder, both in radii of the Sun. `coefficients`: by wavelength.
/// Laws tested: exactly 1 outside, exactly 0 in totality; continuous and monotone; an even disc gives the lens of two
/// circles; brute-force sum over the disc.
pub fn visible_part<const N: usize>(d: f64, b: f64, coefficients: &[[f64; 6]; N]) -> [f64; N] {
    visible_part_by(NODES, d, b, coefficients)
}

fn visible_part_by<const N: usize>(nodes: usize, d: f64, b: f64, coefficients: &[[f64; 6]; N]) -> [f64; N] {
    if d >= 1.0 + b || b <= 0.0 {
        return [1.0; N];
    }
    if d <= b - 1.0 {
        return [0.0; N];
    }
    let (r0, r1) = ((d - b).abs(), (d + b).min(1.0));
    let (width, beyond, gap) = (r1 - r0, d + b - r1, 1.0 - r1);
    let inner = outer_flux(((1.0 - r0) * (1.0 + r0)).max(0.0).sqrt(), coefficients);
    let outer = outer_flux((gap * (1.0 + r1)).max(0.0).sqrt(), coefficients);
    let mut sum: [f64; N] = std::array::from_fn(|k| outer[k] + if d > b { 1.0 - inner[k] } else { 0.0 });
    for (u, w) in gauss_legendre_unit(nodes) {
        let from_inner = width * u * u * (3.0 - 2.0 * u);
        let to_outer = width * (1.0 - u) * (1.0 - u) * (1.0 + 2.0 * u);
        let r = r0 + from_inner;
        let mu = ((gap + to_outer) * (1.0 + r)).sqrt();
        let (covered, bare) = if d >= b { (from_inner, r0 + r) } else { (r0 + r, from_inner) };
        // 1 − φ/π.
        let share = FRAC_2_PI * (bare * (d + r + b)).sqrt().atan2((covered * (beyond + to_outer)).sqrt());
        let weight = w * 6.0 * u * (1.0 - u) * width * 2.0 * r * share;
        for k in 0..N {
            sum[k] += weight * coefficients[k].iter().rev().fold(0.0, |sum, c| sum * mu + c);
        }
    }
    sum.map(|sum| sum.clamp(0.0, 1.0))
}

/// [`visible_part`] for angles in radians.
pub fn visible_fraction<const N: usize>(
    separation_rad: f64,
    sun_radius_rad: f64,
    occluder_radius_rad: f64,
    coefficients: &[[f64; 6]; N],
) -> [f64; N] {
    let radius = sun_radius_rad.max(1e-12);
    visible_part(separation_rad / radius, occluder_radius_rad / radius, coefficients)
}

/// Where an occluder stands, so that every point near the camera can tell what it covers: a cone of shadow without
/// cancellation.
///
/// The large vector to the occluder is split in f64, along the Sun's direction and across it. A sample then moves the
/// shadow by its own offset across, which f32 holds to a metre: 3e-9 rad at the Moon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// Unit vector from the camera to the Sun, without refraction.
    pub sun: DVec3,
    /// What of the vector from the camera to the occluder's centre is across the Sun's direction, m.
    pub across_m: DVec3,
    /// What of it is along the Sun's direction, m; negative behind the camera.
    pub along_m: f64,
    /// Radius of the occluder, m.
    pub radius_m: f64,
    /// Apparent radius of the Sun, rad.
    pub sun_radius_rad: f64,
    /// 1 − distance of the occluder over the Sun's: what of a step across shows as parallax between the two.
    pub parallax: f64,
}

impl Shadow {
    /// Of a body at a place relative to the camera. `sun_distance_m` may be infinite.
    pub fn new(occluder_m: DVec3, radius_m: f64, sun: DVec3, sun_radius_rad: f64, sun_distance_m: f64) -> Self {
        let along_m = occluder_m.dot(sun);
        let parallax = 1.0 - (along_m / sun_distance_m).clamp(0.0, 1.0);
        Self { sun, across_m: occluder_m - sun * along_m, along_m, radius_m, sun_radius_rad, parallax }
    }

    /// Separation of the centres and radius of the occluder in radii of the Sun, as seen from a point.
    ///
    /// d = atan(|a − (x − s(x·s)) p| / (l − x·s)) / ρ,   b = asin(R / √(…² + …²)) / ρ
    ///
    /// a, l: occluder across and along.  x: `offset_m` of the point from the camera.  s: to the Sun.  p: parallax.  ρ: the
    /// Sun's radius, rad.
    /// Laws tested: agrees with the angles between the vectors themselves; parity with f32.
    pub fn discs(&self, offset_m: DVec3) -> (f64, f64) {
        let forward_m = offset_m.dot(self.sun);
        let aside_m = (self.across_m - (offset_m - self.sun * forward_m) * self.parallax).length();
        let along_m = self.along_m - forward_m;
        let distance_m = aside_m.hypot(along_m);
        let radius = (self.radius_m / distance_m.max(self.radius_m)).asin();
        (aside_m.atan2(along_m) / self.sun_radius_rad, radius / self.sun_radius_rad)
    }

    /// What of the Sun's light passes the occluder on its way to a point, by wavelength.
    pub fn fraction<const N: usize>(&self, offset_m: DVec3, coefficients: &[[f64; 6]; N]) -> [f64; N] {
        let (d, b) = self.discs(offset_m);
        visible_part(d, b, coefficients)
    }

    /// Whether the shadow touches anything within a distance of the camera: the rest of the frame may skip it.
    ///
    /// Law tested: where it says no, no point within the distance loses light.
    pub fn reaches(&self, distance_m: f64) -> bool {
        if self.along_m < -(self.radius_m + distance_m) {
            return false;
        }
        // The penumbra's radius where it is widest, on the far side of that ball; tan ρ < 1.01 ρ up to 9°.
        let penumbra_m = self.radius_m + (self.along_m.max(0.0) + distance_m) * 1.01 * self.sun_radius_rad;
        self.across_m.length() < penumbra_m + distance_m
    }
}

/// Radius of the level disc over which the light that feeds higher orders of scattering is averaged, m: photons that have
/// been scattered twice come from that far (spec: 100–200 km).
pub const BLUR_RADIUS_M: f64 = 150e3;

/// Where a mean over a disc takes its values, in radii of it, and with which weights: the middle, and a hexagon.
///
/// ⟨f⟩ = f(0)/4 + Σ f(√⅔ e_j)/8, exact for polynomials of fifth degree   [stroud1971, S2 5-1]
///
/// Laws tested: weights sum to 1; x², x²y², x⁴ have their means.
pub fn disc_rule() -> [([f64; 2], f64); 7] {
    let radius = (2f64 / 3.0).sqrt();
    std::array::from_fn(|i| match i {
        0 => ([0.0; 2], 0.25),
        _ => {
            let (sin, cos) = (PI / 3.0 * i as f64).sin_cos();
            ([radius * cos, radius * sin], 0.125)
        }
    })
}

/// The mean of a fraction over a level disc around a point. `fraction`: of an offset from the camera.
///
/// `up`: unit vector to the zenith of the point (the camera's will do within the air).
/// Laws tested: between the least and the largest of the disc; the mean of many points within 3e-3 at the umbra's edge.
pub fn blurred<const N: usize>(
    offset_m: DVec3,
    up: DVec3,
    radius_m: f64,
    fraction: impl Fn(DVec3) -> [f64; N],
) -> [f64; N] {
    let x = up.any_orthonormal_vector();
    let y = up.cross(x);
    let mut sum = [0.0; N];
    for ([a, b], weight) in disc_rule() {
        let part = fraction(offset_m + (x * a + y * b) * radius_m);
        for k in 0..N {
            sum[k] += weight * part[k];
        }
    }
    sum
}

/// Texels of [`EclipseTable`] between inner and outer contact, and inside (rings only).
pub const CROSSING: usize = 96;
/// Texels of the part where the smaller disc stands wholly before the Sun.
pub const INSIDE: usize = 16;

/// [`visible_part`] over the separation for one radius of the occluder: 112 texels for a march that asks often.
///
/// Another radius b′ near b reads the same table at the same place between its own contacts, so that umbra and penumbra
/// end where they must; a ring covers (b′/b)² as much. Errors tested: 2e-4 of full light for b itself; half a
/// per cent from b (the Moon over 2,000 km of altitude) 1e-3, and 5e-3 for rings.
#[derive(Clone, Debug, PartialEq)]
pub struct EclipseTable<const N: usize> {
    /// Radius of the occluder in radii of the Sun for which the texels hold.
    pub b: f64,
    /// Texels: [`INSIDE`], then [`CROSSING`].
    pub texels: Vec<[f64; N]>,
}

/// Where a separation stands in [`EclipseTable`], in texels.
///
/// Crossing: d = d₀ + (d₁ − d₀) sin²(π w/2) between the contacts d₀ = |1 − b| and d₁ = 1 + b: light changes with w³ at
/// both, so straight lines between texels do.  Inside: d / d₀.
pub fn table_coordinate(d: f64, b: f64) -> f64 {
    let (d0, d1) = ((1.0 - b).abs(), 1.0 + b);
    if d < d0 {
        return if b < 1.0 { d / d0 * (INSIDE - 1) as f64 } else { (INSIDE - 1) as f64 };
    }
    let u = ((d - d0) / (d1 - d0).max(1e-12)).clamp(0.0, 1.0);
    let w = FRAC_2_PI * u.sqrt().atan2((1.0 - u).sqrt());
    INSIDE as f64 + w * (CROSSING - 1) as f64
}

impl<const N: usize> EclipseTable<N> {
    /// For an occluder of radius `b` in radii of the Sun.
    pub fn new(b: f64, coefficients: &[[f64; 6]; N]) -> Self {
        let (d0, d1) = ((1.0 - b).abs(), 1.0 + b);
        let unit = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let inside = (0..INSIDE).map(|i| if b < 1.0 { d0 * unit(i, INSIDE) } else { 0.0 });
        let crossing = (0..CROSSING).map(|i| d0 + (d1 - d0) * (PI / 2.0 * unit(i, CROSSING)).sin().powi(2));
        Self { b, texels: inside.chain(crossing).map(|d| visible_part(d, b, coefficients)).collect() }
    }

    /// The visible part: straight lines between texels.
    pub fn at(&self, d: f64, b: f64) -> [f64; N] {
        let x = table_coordinate(d, b);
        // A ring's last texel inside and its first one crossing are the same moment.
        let i = (x as usize).min(INSIDE + CROSSING - 2);
        let (low, high) = (&self.texels[i], &self.texels[i + 1]);
        let ring = (b.min(1.0) / self.b.min(1.0)).powi(2);
        std::array::from_fn(|k| 1.0 - ring * (1.0 - lerp(low[k], high[k], x - i as f64)))
    }
}

/// Radiance of the corona relative to the mean of the Sun's disc, at a distance from the Sun's centre in radii.
///
/// B = 1e-6 (3.670 ρ⁻¹⁸ + 1.939 ρ⁻⁷·⁸ + 0.0551 ρ⁻²·⁵), K and F corona together   [november1996]
///
/// The formula of Baumbach with newer numbers; the real corona changes by a factor of two with the Sun's activity. It has
/// the Sun's colour. 0 within the disc (ρ < 1).
/// Laws tested: outside the Moon's disc it gives 0.4–1.4e-6 of the Sun's light, as eclipses do; falls.
///
/// **Known to look wrong**: round. The real one has streamers and polar plumes.
pub fn corona_brightness(rho: f64) -> f64 {
    if rho < 1.0 {
        return 0.0;
    }
    let q = 1.0 / rho;
    1e-6 * (3.670 * q.powi(18) + 1.939 * q.powf(7.8) + 0.0551 * q.powf(2.5))
}

#[cfg(test)]
mod tests;
