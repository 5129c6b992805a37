//! A night in numbers: the f64 twin of `night_glow.wgsl`.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3, DVec4};
use himmel_air::{Atmosphere, geometry};
use himmel_core::colour::rec709_from_xyz;
use himmel_core::quadrature::gauss_legendre_unit;

use super::{
    AirglowParams, Layer, LightPollutionParams, MilkyWayParams, S10_CD_M2, StarMap, ZodiacalParams, airglow, pollution,
    zodiacal,
};

/// Rays of the sums over the sphere: Gauss nodes up (and as many down), azimuths.
const NODES: usize = 8;
const AZIMUTHS: usize = 16;
/// Level of the star map that they sample: faces of 32 × 32 of 1,024.
const COARSE: usize = 5;

/// What a night is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NightSettings {
    /// `[night.airglow]`
    pub airglow: AirglowParams,
    /// `[night.zodiacal]`
    pub zodiacal: ZodiacalParams,
    /// `[night.milky_way]`
    pub milky_way: MilkyWayParams,
    /// `[night.light_pollution]`
    pub light_pollution: LightPollutionParams,
}

impl NightSettings {
    /// Whether nothing glows.
    pub fn is_dark(&self) -> bool {
        !self.airglow.enabled
            && !self.zodiacal.enabled
            && !self.milky_way.enabled
            && pollution::zenith_cd_m2(&self.light_pollution) == 0.0
    }
}

/// Four values (radiance per unit irradiance of the Sun at 1 au) of a linear Rec. 709 colour in cd m⁻²: columns R, G, B.
///
/// Of all that show the colour, those nearest to sunlight of the same luminance (in the mean square): the Sun's own colour is even.
pub fn four_from_rec709(rec709_from_four: &[DVec4; 3]) -> [DVec4; 3] {
    let m = rec709_from_four;
    // Rows of (M Mᵀ)⁻¹; the matrix is symmetric.
    let gram = DMat3::from_cols_array(&std::array::from_fn(|i| m[i / 3].dot(m[i % 3])));
    let inverse = gram.inverse();
    let pseudo: [DVec4; 3] = std::array::from_fn(|c| (0..3).fold(DVec4::ZERO, |sum, i| sum + m[i] * inverse.col(c)[i]));
    let luminance = DVec3::new(0.2126, 0.7152, 0.0722);
    let white = DVec3::from_array(std::array::from_fn(|i| m[i].dot(DVec4::ONE)));
    let per_luminance = 1.0 / luminance.dot(white).max(f64::MIN_POSITIVE);
    let rest = DVec4::ONE - (0..3).fold(DVec4::ZERO, |sum, c| sum + pseudo[c] * white[c]);
    std::array::from_fn(|c| pseudo[c] + rest * (luminance[c] * per_luminance))
}

/// Four values of one colour, for lights that are far from the Sun's: of all that show it, those whose least value is largest, so that
/// none is negative where that is possible.
pub fn four_of_light(rec709_from_four: &[DVec4; 3], rgb: DVec3) -> DVec4 {
    let columns = four_from_rec709(rec709_from_four);
    let four = (0..3).fold(DVec4::ZERO, |sum, c| sum + columns[c] * rgb[c]);
    // What can be added without being seen: the cross product of the rows in four dimensions.
    let [r, g, b] = rec709_from_four;
    let determinant = |[i, j, k]: [usize; 3]| {
        r[i] * (g[j] * b[k] - g[k] * b[j]) - r[j] * (g[i] * b[k] - g[k] * b[i]) + r[k] * (g[i] * b[j] - g[j] * b[i])
    };
    let invisible =
        DVec4::new(determinant([1, 2, 3]), -determinant([0, 2, 3]), determinant([0, 1, 3]), -determinant([0, 1, 2]))
            .normalize_or_zero();
    // The least of four straight lines is largest where two of them meet.
    let meetings = (0..4).flat_map(|i| (0..i).map(move |j| (four[j] - four[i]) / (invisible[i] - invisible[j])));
    let better = |best: DVec4, t: f64| {
        let moved = four + invisible * t;
        if moved.min_element() > best.min_element() { moved } else { best }
    };
    meetings.filter(|t| t.is_finite()).fold(four, better)
}

/// Share of an even light above the air that reaches a level below it on a line of sight by being scattered there.
///
/// t(µ) − T, with the total transmission of a scattering layer above ground of albedo A, t = ((2 + 3µ) + (2 − 3µ) T) /
/// ((4 + 3τ)(1 − A s)), s = 3τ/(4 + 3τ)   [sobolev1975, chapter 8]. By reciprocity the light that an even sky sends down a line of
/// sight is what a beam along that line would send through the layer.
///
/// `through`: T′ along the line; `depth`: τ′ of the vertical. What ozone absorbs counts as scattered: 7 % too much at 15° and
/// 560 nm. Law tested: the moments' illuminance of the ground over µ, within 3 % from 25° up but for that.
pub fn diffuse_transmission(mu: f64, through: f64, depth: f64, albedo: f64) -> f64 {
    let mu = mu.clamp(0.0, 1.0);
    ((2.0 + 3.0 * mu) + (2.0 - 3.0 * mu) * through) * diffuse_factor(depth, albedo) - through
}

/// 1/((4 + 3τ)(1 − A s)) = 1/(4 + 3τ (1 − A)).
pub(super) fn diffuse_factor(depth: f64, albedo: f64) -> f64 {
    1.0 / (4.0 + 3.0 * depth * (1.0 - albedo))
}

/// What air that is lit from below scatters into a line of sight: 1 − e^(−τ′ X), X = (1 − 0.96 sin² z)^(−1/2)
///
/// The scattering term of [krisciunas1991, eqs. 3 and 15], written for moonlight: X ends at 5 air masses, beyond which cities do
/// not reach. Law tested: 2 to 4 times the zenith at the horizon.
pub fn polluted_share(mu: f64, depth: f64) -> f64 {
    let mu = mu.clamp(0.0, 1.0);
    1.0 - (-depth / (1.0 - 0.96 * (1.0 - mu * mu)).sqrt()).exp()
}

/// What one sees in a direction, part by part: radiance per unit irradiance of the Sun at 1 au, sr⁻¹.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NightParts {
    /// The layer's own light, through the air below it.
    pub airglow: [f64; 4],
    /// Zodiacal light through the air.
    pub zodiacal: [f64; 4],
    /// The star map through the air.
    pub starlight: [f64; 4],
    /// All three, scattered into the line of sight; below the horizon also the ground lit by them.
    pub scattered: [f64; 4],
    /// Light of cities.
    pub pollution: [f64; 4],
}

impl NightParts {
    /// All together.
    pub fn sum(&self) -> [f64; 4] {
        std::array::from_fn(|k| {
            self.airglow[k] + self.zodiacal[k] + self.starlight[k] + self.scattered[k] + self.pollution[k]
        })
    }
}

/// A frame's night.
#[derive(Clone, Debug, PartialEq)]
pub struct NightGlow {
    /// ICRS from east-north-up.
    pub icrs_from_enu: DMat3,
    /// x to the Sun, z to the ecliptic's pole, from east-north-up.
    pub ecliptic_from_enu: DMat3,
    /// The layer of airglow.
    pub layer: Layer,
    /// Its radiance at the zenith, no air below it; 0: none.
    pub airglow: [f64; 4],
    /// Radiance of one S10 of the Sun's colour, times the settings' factor; 0: none.
    pub zodiacal: f64,
    /// The star map.
    pub star_map: Option<Arc<StarMap>>,
    /// Radiance of one S10 of the map's red, green, blue.
    pub four_from_s10: [[f64; 4]; 3],
    /// What [`polluted_share`] is multiplied by for the light of cities.
    pub pollution: [f64; 4],
    /// τ′ of the vertical above the observer.
    pub depth: [f64; 4],
    /// τ′ of the vertical below the observer over that above.
    pub depth_below: [f64; 4],
    /// Mean radiance that falls on the air.
    pub diffuse: [f64; 4],
    /// The factor of [`diffuse_transmission`].
    pub diffuse_factor: [f64; 4],
    /// Radiance of the ground lit by the night.
    pub ground: [f64; 4],
    /// The table of zodiacal light, S10 at the four wavelengths.
    pub zodiacal_table: Arc<Vec<[f64; 4]>>,
}

impl NightGlow {
    /// Everything but where the sky stands: `icrs_from_enu`, `ecliptic_from_enu` as the fields say.
    ///
    /// `zodiacal_table`: [`zodiacal::four_table`] at the atmosphere's wavelengths. `star_map`: `None` where it is off or broken.
    /// `site_m`: altitude of the ground there, at which light of cities has its luminance.
    pub fn new(
        atmosphere: &Atmosphere,
        settings: &NightSettings,
        star_map: Option<Arc<StarMap>>,
        zodiacal_table: Arc<Vec<[f64; 4]>>,
        [icrs_from_enu, ecliptic_from_enu]: [DMat3; 2],
        [altitude_m, site_m]: [f64; 2],
    ) -> Self {
        let medium = atmosphere.medium();
        let rows = atmosphere.rec709_from_four();
        let four_of_xyz = |xyz: DVec3| four_of_light(&rows, rec709_from_xyz() * xyz).to_array();
        let luminance = |four: [f64; 4]| atmosphere.xyz(four).y;
        let s10 = S10_CD_M2 / luminance([1.0; 4]).max(f64::MIN_POSITIVE);

        // The lines are those of the Earth's air.
        let earth_sized = (medium.bottom_radius_m / 6.371e6 - 1.0).abs() < 0.01;
        let AirglowParams { enabled, solar_flux_sfu, brightness, altitude_km, thickness_km } = settings.airglow;
        let layer = Layer::new(medium.bottom_radius_m, altitude_km * 1e3, thickness_km * 1e3);
        let glowing =
            if enabled && earth_sized { brightness * airglow::zenith_s10(solar_flux_sfu) * S10_CD_M2 } else { 0.0 };
        let spectrum = airglow::xyz_cd_m2();
        let airglow = four_of_xyz(spectrum / spectrum.y * glowing);

        let zodiacal = if settings.zodiacal.enabled { settings.zodiacal.brightness * s10 } else { 0.0 };
        let stars = settings.milky_way.brightness * S10_CD_M2;
        let four_from_s10 = four_from_rec709(&rows).map(|four| (four * stars).to_array());

        // The lamps' light, as bright as it is to be at the zenith of the ground.
        let lamps = four_of_xyz(pollution::xyz(settings.light_pollution.lamp));
        let lost = |altitude_m: f64| atmosphere.extended_transmittance(altitude_m, 1.0).map(|t| 1.0 - t);
        let (from_ground, from_here) = (lost(site_m), lost(altitude_m.max(0.0)));
        let at_zenith = luminance(std::array::from_fn(|k| lamps[k] * from_ground[k]));
        let wanted = pollution::zenith_cd_m2(&settings.light_pollution);
        // Where there is no air nothing scatters; above some of it less is lit.
        let scale = if at_zenith > 1e-9 { wanted / at_zenith } else { 0.0 };
        let pollution = std::array::from_fn(|k| lamps[k] * scale * from_here[k] / from_ground[k].max(1e-12));

        let albedo = atmosphere.sampled().ground_albedo;
        let depth = from_here.map(|lost| -(1.0 - lost).max(1e-30).ln());
        let whole = lost(0.0).map(|lost| -(1.0 - lost).max(1e-30).ln());
        let depth_below = std::array::from_fn(|k| (whole[k] / depth[k].max(1e-9) - 1.0).clamp(0.0, 1e9));
        let diffuse_factor = std::array::from_fn(|k| diffuse_factor(depth[k], albedo[k]));
        let mut night = Self {
            icrs_from_enu,
            ecliptic_from_enu,
            layer,
            airglow,
            zodiacal,
            star_map: star_map.filter(|_| settings.milky_way.enabled && stars > 0.0),
            four_from_s10,
            pollution,
            depth,
            depth_below,
            diffuse: [0.0; 4],
            diffuse_factor,
            ground: [0.0; 4],
            zodiacal_table,
        };
        night.light_up(atmosphere, altitude_m);
        night
    }

    /// Sums what falls on the air, then what falls through it on the ground.
    fn light_up(&mut self, atmosphere: &Atmosphere, altitude_m: f64) {
        let medium = atmosphere.medium();
        if altitude_m > medium.top_altitude_m {
            // From above the ground alone shows it, unscattered.
            let falling = self.falling(|direction| self.above_the_air(medium.bottom_radius_m, 0.0, direction));
            let albedo = atmosphere.sampled().ground_albedo;
            self.ground = std::array::from_fn(|k| albedo[k] / PI * falling[k]);
            return;
        }
        let altitude_m = altitude_m.max(0.0);
        self.diffuse =
            self.falling(|direction| self.above_the_air(medium.bottom_radius_m, altitude_m, direction)).map(|e| e / PI);
        let falling = self.falling(|direction| self.parts(atmosphere, altitude_m, direction, COARSE).sum());
        let albedo = atmosphere.sampled().ground_albedo;
        self.ground = std::array::from_fn(|k| albedo[k] / PI * falling[k]);
    }

    /// Irradiance of a level surface by a sky.
    fn falling(&self, sky: impl Fn(DVec3) -> [f64; 4]) -> [f64; 4] {
        let mut sum = [0.0; 4];
        upper_half(|direction, weight| {
            let light = sky(direction);
            for k in 0..4 {
                sum[k] += weight * direction.z * light[k];
            }
        });
        sum
    }

    /// Light without any air, coarsely.
    fn above_the_air(&self, radius_m: f64, altitude_m: f64, direction: DVec3) -> [f64; 4] {
        let [near, far] = self.airglow_path(radius_m, altitude_m, direction, false);
        let (dust, stars) = (self.zodiacal_light(direction), self.starlight(direction, COARSE));
        std::array::from_fn(|k| self.airglow[k] * (near + far) + dust[k] + stars[k])
    }

    fn airglow_path(&self, radius_m: f64, altitude_m: f64, direction: DVec3, below: bool) -> [f64; 2] {
        let sin = direction.x.hypot(direction.y);
        self.layer.path(radius_m + altitude_m, direction.z, sin, below)
    }

    fn zodiacal_light(&self, direction: DVec3) -> [f64; 4] {
        if self.zodiacal == 0.0 {
            return [0.0; 4];
        }
        zodiacal::look_up(&self.zodiacal_table, self.ecliptic_from_enu * direction).map(|s10| s10 * self.zodiacal)
    }

    fn starlight(&self, direction: DVec3, level: usize) -> [f64; 4] {
        let Some(map) = &self.star_map else { return [0.0; 4] };
        let rgb = map.sample_s10(self.icrs_from_enu * direction, level);
        std::array::from_fn(|k| (0..3).map(|c| self.four_from_s10[c][k] * rgb[c]).sum())
    }

    /// What one sees in a direction (unit vector east-north-up) from an altitude; `level` of the star map, 0: the finest.
    pub fn parts(&self, atmosphere: &Atmosphere, altitude_m: f64, direction: DVec3, level: usize) -> NightParts {
        let radius_m = atmosphere.medium().bottom_radius_m;
        let below = direction.z < geometry::horizon_cosine(radius_m, altitude_m);
        let [near, far] = self.airglow_path(radius_m, altitude_m, direction, below);
        let mut parts = NightParts::default();
        if below {
            // The ground, and the air before it, lit by half a sky and by the ground.
            let through = self.through_to_ground(atmosphere, direction, altitude_m);
            parts.airglow = self.airglow.map(|light| light * near);
            parts.scattered = std::array::from_fn(|k| {
                self.ground[k] * through[k] + 0.5 * (self.diffuse[k] + self.ground[k]) * (1.0 - through[k])
            });
            return parts;
        }
        let through = atmosphere.extended_transmittance(altitude_m, direction.z);
        let (dust, stars) = (self.zodiacal_light(direction), self.starlight(direction, level));
        let mu = direction.z.clamp(0.0, 1.0);
        for k in 0..4 {
            parts.airglow[k] = self.airglow[k] * (near + far * through[k]);
            parts.zodiacal[k] = dust[k] * through[k];
            parts.starlight[k] = stars[k] * through[k];
            let total = ((2.0 + 3.0 * mu) + (2.0 - 3.0 * mu) * through[k]) * self.diffuse_factor[k];
            parts.scattered[k] = self.diffuse[k] * (total - through[k]).max(0.0);
            parts.pollution[k] = self.pollution[k] * polluted_share(mu, self.depth[k]);
        }
        parts
    }

    /// T′ between the eye (or where its ray enters the air) and the ground: within the air the depths below and above the eye are
    /// in the ratio of the vertical, which holds but for the last degrees above the horizon.
    fn through_to_ground(&self, atmosphere: &Atmosphere, direction: DVec3, altitude_m: f64) -> [f64; 4] {
        let medium = atmosphere.medium();
        if altitude_m > medium.top_altitude_m {
            let nearest =
                (medium.bottom_radius_m + altitude_m) * direction.x.hypot(direction.y) / medium.bottom_radius_m;
            return atmosphere.extended_transmittance(0.0, (1.0 - nearest * nearest).max(0.0).sqrt());
        }
        let above = atmosphere.extended_transmittance(altitude_m, -direction.z);
        std::array::from_fn(|k| above[k].max(1e-30).powf(self.depth_below[k]))
    }

    /// Calls `f` with directions all around, their solid angles and what the night shows there: for sums over the sphere.
    pub fn all_around(&self, atmosphere: &Atmosphere, altitude_m: f64, mut f: impl FnMut(DVec3, f64, [f64; 4])) {
        upper_half(|direction, weight| {
            for direction in [direction, DVec3::new(direction.x, direction.y, -direction.z)] {
                f(direction, weight, self.parts(atmosphere, altitude_m, direction, COARSE).sum());
            }
        });
    }
}

/// Directions over the horizon with their solid angles.
fn upper_half(mut f: impl FnMut(DVec3, f64)) {
    for (z, w) in gauss_legendre_unit(NODES) {
        let sin = (1.0 - z * z).sqrt();
        for j in 0..AZIMUTHS {
            let (y, x) = (2.0 * PI * (j as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
            f(DVec3::new(sin * x, sin * y, z), w * 2.0 * PI / AZIMUTHS as f64);
        }
    }
}
