//! The Moon of a scene: where it is, what lights it, what of the Earth's shadow is on it.

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::{DMat3, DVec3};
use himmel_air::shadow::{Distances, NODES, Rays, ShadowLight, Veil};
use himmel_astro::events::ShadowConvention;
use himmel_astro::physical::{MoonOrientation, moonlight};
use himmel_astro::{Body, Instant, Place};
use himmel_core::constants::{ASTRONOMICAL_UNIT_M, SUN_RADIUS_M};
use himmel_gpu::SunState;
use himmel_gpu::phenomena::moon::{
    Crater, EclipseMap, MoonEclipse, MoonMap, MoonMaps, MoonPhotometry, MoonRelief, MoonState, ShadowRule,
};
use tracing::warn;

use crate::error::Result;
use crate::model::{SkyModel, direction_enu, visible_fraction};
use crate::scene::Scene;

/// By a brighter sky the Moon's own light in the air is below 1e-4 of the Sun's: it is left out, so that days cost one light.
const DAY_ABOVE_DEG: f64 = 5.0;
/// A Moon this far below the horizon lights less than 1e-6 lx.
const SET_BELOW_DEG: f64 = -8.0;
/// Moonlight weaker than a thousandth of the night sky's is no light, lx.
const LEAST_LX: f64 = 1e-6;
/// How far from 1 au the Earth may be, with some room.
const EARTHS_ORBIT_AU: f64 = 0.02;
/// Distances for which an eclipse's table serves: it is scaled to the edge of the shadow that is asked for.
const SAME_WITHIN: f64 = 0.003;

/// Where the Moon stands, and how it shines.
#[derive(Clone, Debug, PartialEq)]
pub struct Moon {
    /// From north through east, 0..360.
    pub azimuth_deg: f64,
    /// Above the horizon, as refraction shows it.
    pub altitude_deg: f64,
    /// Above the horizon, without air.
    pub airless_altitude_deg: f64,
    /// From the observer.
    pub distance_m: f64,
    /// Apparent radius, without the factor that enlarges the drawn disc.
    pub radius_deg: f64,
    /// Sun–Moon–observer.
    pub phase_angle_deg: f64,
    /// Lit part of the disc.
    pub illuminated_fraction: f64,
    /// Illuminance above the air, an eclipse included.
    pub illuminance_lx: f64,
    /// What an eclipse leaves of its light (1: none), by luminance.
    pub eclipse_fraction: f64,
    /// What the renderer draws.
    pub state: MoonState,
    /// Irradiance above the air at the four wavelengths relative to the preset's star at 1 au, an eclipse included.
    pub irradiance: [f64; 4],
}

/// Tables that moons of many frames share.
#[derive(Default)]
pub(crate) struct MoonCache {
    maps: Mutex<Option<(MapKey, Arc<MoonMaps>)>>,
    rays: Mutex<Option<Arc<Rays>>>,
    shadow: Mutex<Option<ShadowTable>>,
}

type MapKey = (String, String, PathBuf);

/// Light in the shadow for some distances.
#[derive(Clone)]
struct ShadowTable {
    veil: Veil,
    distances: Distances,
    thesis: bool,
    map: Arc<EclipseMap>,
    step_m: f64,
    edge_m: f64,
}

impl MoonCache {
    /// Forgets what depends on the air.
    pub(crate) fn forget_air(&self) {
        *self.rays.lock().unwrap_or_else(PoisonError::into_inner) = None;
        *self.shadow.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn maps(&self, scene: &Scene) -> Arc<MoonMaps> {
        let key = (scene.moon.albedo_map.clone(), scene.moon.normal_map.clone(), scene.folder.clone());
        let mut held = self.maps.lock().unwrap_or_else(PoisonError::into_inner);
        match held.as_ref() {
            Some((of, maps)) if *of == key => Arc::clone(maps),
            _ => {
                let maps = load_maps(scene);
                *held = Some((key, Arc::clone(&maps)));
                maps
            }
        }
    }
}

/// The built-in maps, decoded once.
fn built_in() -> Arc<MoonMaps> {
    static MAPS: OnceLock<Arc<MoonMaps>> = OnceLock::new();
    let decode = || {
        let picture = image::load_from_memory(include_bytes!("../../../assets/moon/albedo.jpg"));
        let albedo = picture.map_err(|error| error.to_string()).and_then(|picture| grey(&picture));
        albedo.map_or_else(
            |reason| {
                warn!(%reason, "the Moon's built-in map cannot be read; its ground is even");
                MoonMaps::even()
            },
            |albedo| MoonMaps::new(albedo, None),
        )
    };
    Arc::clone(MAPS.get_or_init(|| Arc::new(craters(decode(), include_bytes!("../../../assets/moon/craters.bin")))))
}

/// Maps with the heights of a catalogue of craters.
fn craters(maps: MoonMaps, catalogue: &[u8]) -> MoonMaps {
    match Crater::read(catalogue) {
        Ok(craters) => maps.with_relief(Arc::new(MoonRelief::new(craters))),
        Err(reason) => {
            warn!(%reason, "the Moon's built-in craters cannot be read; its ground is smooth");
            maps
        }
    }
}

fn grey(picture: &image::DynamicImage) -> std::result::Result<MoonMap<1>, String> {
    let grey = picture.to_luma8();
    let texels = grey.as_raw().iter().map(|&value| [value]).collect();
    MoonMap::new(grey.width(), grey.height(), texels).map_err(|error| error.to_string())
}

fn colours(picture: &image::DynamicImage) -> std::result::Result<MoonMap<4>, String> {
    let rgba = picture.to_rgba8();
    let texels = rgba.as_raw().chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]).collect();
    MoonMap::new(rgba.width(), rgba.height(), texels).map_err(|error| error.to_string())
}

/// Maps that a scene names. One that is missing or broken is a warning and even ground: the sky goes on.
fn load_maps(scene: &Scene) -> Arc<MoonMaps> {
    let settings = &scene.moon;
    if settings.albedo_map.is_empty() && settings.normal_map.is_empty() {
        return built_in();
    }
    let open = |name: &str| {
        let path = scene.folder.join(Path::new(name));
        image::open(&path).map_err(|error| format!("{error} ({})", path.display()))
    };
    let albedo = match settings.albedo_map.as_str() {
        "" => built_in().albedo.clone(),
        "none" => MoonMap::even([255]),
        name => open(name).and_then(|picture| grey(&picture)).unwrap_or_else(|reason| {
            warn!(%reason, "body.moon.albedo_map cannot be used; the Moon's ground is even");
            MoonMap::even([255])
        }),
    };
    let normals = match settings.normal_map.as_str() {
        "" | "none" => None,
        name => open(name).and_then(|picture| colours(&picture)).map_or_else(
            |reason| {
                warn!(%reason, "body.moon.normal_map cannot be used; the Moon's ground is smooth");
                None
            },
            Some,
        ),
    };
    let relief = built_in().relief.clone().filter(|_| settings.normal_map.is_empty());
    Arc::new(MoonMaps { relief, ..MoonMaps::new(albedo, normals) })
}

/// Sun, Moon and observer, vectors east-north-up in metres.
struct Standing {
    /// From the observer to the Moon.
    moon_m: DVec3,
    /// From the observer to the Sun.
    sun_m: DVec3,
    /// From the Earth's centre to the observer.
    observer_m: DVec3,
    body_from_enu: DMat3,
}

impl SkyModel {
    /// The Moon, where it stands before these stars: by the ephemeris above the Earth under its Sun, or by hand.
    pub fn moon(&self) -> Result<Option<Moon>> {
        let settings = &self.scene().moon;
        let Some(standing) = self.moon_standing()? else { return Ok(None) };
        let Standing { moon_m, sun_m, observer_m, body_from_enu } = standing;
        let direction = moon_m.normalize_or(DVec3::Z);
        let distance_m = moon_m.length();
        let sun_from_moon = sun_m - moon_m;
        let (to_sun, sun_distance_m) = (sun_from_moon.normalize_or(DVec3::Z), sun_from_moon.length());
        let from_earth = observer_m + moon_m;
        let to_earth = (-from_earth).normalize_or(-direction);
        let radius_rad = (Body::Moon.radius_m() / distance_m).min(1.0).asin();
        let phase_rad = angle(to_sun, -direction);
        let thesis = settings.photometry == MoonPhotometry::Thesis;
        let air = self.atmosphere();
        let coloured = |shape: [f64; 4], lx: f64| {
            let luminance = air.xyz(shape).y;
            shape.map(|value| if luminance > 0.0 { value * lx / luminance } else { 0.0 })
        };
        let nm = air.wavelengths_nm();
        let reflectance = nm.map(if thesis { moonlight::thesis_reflectance } else { moonlight::moon_reflectance });
        let law = if thesis { moonlight::thesis_illuminance_lx } else { moonlight::moon_illuminance_lx };
        let law = |phase_rad: f64| settings.brightness * law(phase_rad, sun_distance_m, distance_m);
        // Radiance of ground with µ₀/(µ₀ + µ) = 1 for an illuminance by the whole disc.
        let ground = |lx: f64, phase_rad: f64| {
            let disc = FRAC_PI_2 * radius_rad.sin().powi(2) * moonlight::lommel_seeliger_disc(phase_rad);
            if disc > 1e-12 * radius_rad.sin().powi(2) { lx / disc } else { 0.0 }
        };
        let uneclipsed = coloured(reflectance, law(phase_rad));
        let eclipse = self.moon_eclipse(sun_m + observer_m, from_earth);
        let left = eclipse.as_ref().map_or([1.0; 4], MoonEclipse::mean);
        let irradiance: [f64; 4] = std::array::from_fn(|k| uneclipsed[k] * left[k]);
        let boost = eclipse.as_ref().map_or(1.0, |_| self.eclipse_boost(sun_m + observer_m, from_earth));
        let sunlit = coloured(reflectance, boost * ground(law(phase_rad), phase_rad));
        let earth_phase_rad = angle(to_earth, -direction);
        let earthlight = self.earthlight(thesis, phase_rad, from_earth, sun_distance_m);
        let blue = nm.map(moonlight::earthlight_colour);
        let earthlit = coloured(
            std::array::from_fn(|k| reflectance[k] * blue[k]),
            settings.earthshine * earthlight * ground(law(earth_phase_rad), earth_phase_rad),
        );
        let airless = direction.z.clamp(-1.0, 1.0).asin();
        let azimuth_deg = direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0);
        let altitude_deg = self.bending().apparent_rad(airless).to_degrees();
        let luminance = |four: [f64; 4]| air.xyz(four).y.max(0.0);
        Ok(Some(Moon {
            azimuth_deg,
            altitude_deg,
            airless_altitude_deg: airless.to_degrees(),
            distance_m,
            radius_deg: radius_rad.to_degrees(),
            phase_angle_deg: phase_rad.to_degrees(),
            illuminated_fraction: 0.5 * (1.0 + phase_rad.cos()),
            illuminance_lx: luminance(irradiance),
            eclipse_fraction: luminance(irradiance) / luminance(uneclipsed).max(f64::MIN_POSITIVE),
            state: MoonState {
                direction,
                disc_direction: direction_enu(azimuth_deg, altitude_deg),
                radius_rad: (radius_rad * settings.radius_scale).min(1.5),
                to_sun,
                to_earth,
                body_from_enu,
                sunlit,
                earthlit,
                eclipse,
                maps: self.moon_cache().maps(self.scene()),
                relief: settings.relief,
            },
            irradiance,
        }))
    }

    /// What of a light the Earth's is on the Moon's ground, relative to the Sun's.
    fn earthlight(&self, thesis: bool, phase_rad: f64, from_earth: DVec3, sun_distance_m: f64) -> f64 {
        if thesis {
            let short = self.scene().moon.earthshine_short;
            let by = if short { moonlight::earthshine_short_w_m2 } else { moonlight::earthshine_w_m2 };
            let au = sun_distance_m / ASTRONOMICAL_UNIT_M;
            return by(phase_rad) / (moonlight::SOLAR_CONSTANT_W_M2 / (au * au));
        }
        // Sun–Earth–Moon: what is missing to π; the angle at the Sun is 0.15°.
        let earth_phase_rad = std::f64::consts::PI - phase_rad;
        let lx = moonlight::earthlight_lx(earth_phase_rad, sun_distance_m, from_earth.length().max(1e7));
        lx / moonlight::sunlight_lx(sun_distance_m)
    }

    fn moon_standing(&self) -> Result<Option<Standing>> {
        let (settings, sun_settings) = (&self.scene().moon, &self.scene().sun);
        let by_hand =
            settings.azimuth_deg.is_some() || settings.altitude_deg.is_some() || settings.distance_km.is_some();
        let sun_by_hand = sun_settings.azimuth_deg.is_some() || sun_settings.altitude_deg.is_some();
        // A Sun put by hand, or another star's, leaves the ephemeris' Moon without its light; other planets have none.
        let other_star = sun_settings.distance_au.or(self.preset().sun_distance_au);
        let other_star = other_star.is_some_and(|au| (au - 1.0).abs() > EARTHS_ORBIT_AU);
        let radius_m = self.atmosphere().medium().bottom_radius_m;
        let other_planet = (radius_m / Body::Earth.radius_m() - 1.0).abs() > 0.01;
        let elsewhere = sun_by_hand || other_star || other_planet;
        if !settings.enabled || (elsewhere && !by_hand) {
            return Ok(None);
        }
        let instant = Instant::from_unix_seconds(self.clock().unix_seconds())?;
        let observer = self.observer();
        let place = Place::from_degrees(observer.latitude_deg, observer.longitude_deg, self.altitude_m())?;
        let observer = himmel_astro::Observer::new(self.ephemeris(), &instant, &place)?;
        let seen = observer.apparent(Body::Moon)?;
        let sun = self.sun()?;
        let azimuth_deg = settings.azimuth_deg.unwrap_or(seen.azimuth_rad.to_degrees());
        let altitude_deg = settings.altitude_deg.unwrap_or(seen.altitude_rad.to_degrees());
        let distance_m = settings.distance_km.map_or(seen.distance_m, |km| km * 1e3);
        let enu_from_icrs = place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        let moon_m = direction_enu(azimuth_deg, altitude_deg) * distance_m;
        let body_from_enu = if by_hand {
            // The middle of its near side towards us, its north up.
            let x = -moon_m.normalize_or(DVec3::Z);
            let z = (DVec3::Z - x * x.z).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
            DMat3::from_cols(x, z.cross(x), z).transpose()
        } else {
            MoonOrientation::at(instant.tdb()).body_from_icrs * enu_from_icrs.transpose()
        };
        Ok(Some(Standing {
            moon_m,
            sun_m: direction_enu(sun.azimuth_deg, sun.airless_altitude_deg) * sun.distance_au * ASTRONOMICAL_UNIT_M,
            observer_m: place.enu_from_ecef() * place.ecef_m(),
            body_from_enu,
        }))
    }

    /// The Earth's shadow on the Moon; vectors from the Earth's centre.
    fn moon_eclipse(&self, sun: DVec3, moon: DVec3) -> Option<MoonEclipse> {
        let axis = -sun.normalize_or(DVec3::Z);
        let along_m = moon.dot(axis);
        let across = moon - axis * along_m;
        let moon_radius_m = Body::Moon.radius_m();
        // The penumbra of the Earth has 4.8 radii of the Moon; with a closer Moon up to the Earth's 3.7 and little more.
        if along_m < 1e7 || across.length() > 8.0 * moon_radius_m {
            return None;
        }
        let distances = Distances { moon_m: along_m, star_m: sun.length(), star_radius_m: SUN_RADIUS_M };
        let table = self.shadow_table(&distances)?;
        let rule = self.scene().moon.eclipse;
        let convention = match rule {
            ShadowRule::Danjon => ShadowConvention::Danjon,
            ShadowRule::Chauvenet => ShadowConvention::Chauvenet,
            ShadowRule::Thesis => ShadowConvention::Thesis,
            ShadowRule::Air => ShadowConvention::Geometric,
        };
        let (umbra_rad, _) = convention.radii_rad(along_m, distances.star_m);
        let asked_m = if rule == ShadowRule::Air { table.edge_m } else { along_m * umbra_rad.tan() };
        let stretch = if asked_m > 0.1 * table.edge_m { table.edge_m / asked_m } else { 1.0 };
        let nodes_per_radius = moon_radius_m * stretch / table.step_m;
        let offset = across / moon_radius_m;
        let last = (table.map.ln_light.len() - 1) as f64;
        ((offset.length() - 1.0) * nodes_per_radius < last).then_some(MoonEclipse {
            axis,
            offset,
            nodes_per_radius,
            map: table.map,
        })
    }

    fn shadow_table(&self, distances: &Distances) -> Option<ShadowTable> {
        let settings = &self.scene().moon;
        let veil = Veil {
            cloud_cover: settings.eclipse_cloud_cover,
            cloud_top_m: settings.eclipse_cloud_top_m,
            dust: settings.eclipse_dust,
        };
        let thesis = settings.eclipse == ShadowRule::Thesis;
        let cache = self.moon_cache();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < SAME_WITHIN;
        let mut held = cache.shadow.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = held.as_ref().filter(|table| {
            let of = &table.distances;
            table.veil == veil
                && table.thesis == thesis
                && near(of.moon_m, distances.moon_m)
                && near(of.star_m, distances.star_m)
        });
        if let Some(table) = fits {
            return Some(table.clone());
        }
        let air = self.atmosphere();
        let nm = air.wavelengths_nm();
        let table = if thesis {
            thesis_table(distances, &nm, veil)
        } else {
            let mut rays = cache.rays.lock().unwrap_or_else(PoisonError::into_inner);
            let rays = rays.get_or_insert_with(|| Arc::new(Rays::new(air.medium(), &nm)));
            let light = ShadowLight::new(rays, &veil, distances, &self.limb_darkening());
            let light = light.map_err(|error| warn!(%error, "the Earth's shadow is left out")).ok()?;
            let weights: [f64; 4] = std::array::from_fn(|k| {
                let one = std::array::from_fn(|i| f64::from(u8::from(i == k)));
                air.xyz(one).y.max(0.0)
            });
            ShadowTable {
                veil,
                distances: *distances,
                thesis,
                edge_m: light.umbra_edge_m(weights),
                step_m: light.step_m,
                map: Arc::new(EclipseMap { ln_light: light.ln_light }),
            }
        };
        *held = Some(table.clone());
        Some(table)
    }

    /// The artistic factor on the disc: i(t_m) of [mueller2012, eqs. 4.17, 4.18], 1 outside the umbra, its most where the
    /// Moon is wholly in it.
    fn eclipse_boost(&self, sun: DVec3, moon: DVec3) -> f64 {
        let boost = self.scene().moon.eclipse_boost;
        let axis = -sun.normalize_or(DVec3::Z);
        let (umbra, penumbra) = thesis_radii(moon.length(), sun.length());
        let d_m = (moon - axis * moon.dot(axis)).length() / Body::Moon.radius_m();
        let t = thesis_phase_of_disc(d_m, umbra, penumbra);
        let total = thesis_phase_of_disc((umbra - 1.0).max(0.0), umbra, penumbra);
        boost.powf(1.0 - smoothstep(total, 0.5, t))
    }

    /// The Moon as a light of a frame, where it matters.
    pub(crate) fn moon_as_light(&self, moon: &Moon) -> Result<Option<SunState>> {
        let day = self.sun()?.airless_altitude_deg > DAY_ABOVE_DEG;
        let shines = moon.airless_altitude_deg > SET_BELOW_DEG && moon.illuminance_lx > LEAST_LX;
        Ok((self.scene().moon.light && shines && !day).then_some(SunState {
            direction: moon.state.direction,
            disc_direction: moon.state.disc_direction,
            radius_rad: moon.radius_deg.to_radians(),
            irradiance: moon.irradiance,
            disc: false,
            limb_darkening: false,
        }))
    }

    /// What of the Moon's light arrives on a surface that faces it, at the four wavelengths.
    pub(crate) fn moon_beam(&self, moon: &Moon) -> [f64; 4] {
        let visible = visible_fraction(moon.altitude_deg - self.horizon_deg(), moon.radius_deg);
        let lowest_mu =
            himmel_air::geometry::horizon_cosine(self.atmosphere().medium().bottom_radius_m, self.altitude_m());
        let mu = moon.altitude_deg.to_radians().sin().max(lowest_mu + 1e-9);
        let through = self.atmosphere().sun_transmittance(self.altitude_m(), mu);
        std::array::from_fn(|k| moon.irradiance[k] * through[k] * visible)
    }

    /// The disc, wherever it stands: what it needs is there before it rises.
    pub(crate) fn moon_as_disc(&self, moon: Moon) -> Option<MoonState> {
        self.scene().moon.disc.then_some(moon.state)
    }
}

/// Angle between two unit vectors.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Radii of umbra and penumbra in radii of the Moon   [mueller2012, eqs. 4.14, 4.15]
fn thesis_radii(moon_m: f64, sun_m: f64) -> (f64, f64) {
    (3.6676 - 397.0001 * moon_m / sun_m, 3.6676 + 404.3354 * moon_m / sun_m)
}

/// t_m: 0 on the axis, ½ where the disc leaves the umbra, 1 where it leaves the penumbra   [mueller2012, eq. 4.17, whose second
/// case must add]
fn thesis_phase_of_disc(d_m: f64, umbra: f64, penumbra: f64) -> f64 {
    if d_m < umbra + 1.0 {
        d_m / (2.0 + 2.0 * umbra)
    } else {
        0.5 + (d_m - umbra - 1.0) / (2.0 * penumbra - 2.0 * umbra)
    }
}

/// h(t_f): factors on red, green and blue over the phase of a point of the ground   [mueller2012, listing A.2]
///
/// Laws tested: 1 at the penumbra's edge; the umbra dark and red, its rim blue; never negative.
fn thesis_colour(t_f: f64) -> [f64; 3] {
    const SOFT: f64 = 0.05;
    let penumbra = 0.9 * (1.0 - (2.0 * t_f - 1.0).clamp(0.0, 1.0));
    let umbra = 0.088 * (1.0 - smoothstep(0.5 * (1.0 - SOFT), 0.5 * (1.0 + SOFT), t_f));
    let inner = if t_f < 0.5 { (1.0 - 2.0 * t_f).clamp(0.0, 1.0) } else { 0.0 };
    let rim = smoothstep(0.5 * (1.0 - 4.0 * SOFT), 0.5 * (1.0 + SOFT), t_f) * (1.0 - smoothstep(0.5, 1.0, t_f));
    let (red, blue) = ([0.4, 0.7, 1.0], [0.3, 0.5, 1.0]);
    std::array::from_fn(|i| (1.0 - penumbra - umbra - 0.023 * red[i] * inner + 0.040 * blue[i] * rim).max(0.0))
}

/// Red, green and blue stand at 680, 550 and 440 nm in the thesis.
fn at_wavelength(rgb: [f64; 3], nm: f64) -> f64 {
    let [r, g, b] = rgb;
    if nm >= 550.0 {
        g + (r - g) * ((nm - 550.0) / 130.0).min(1.0)
    } else {
        b + (g - b) * ((nm - 440.0) / 110.0).max(0.0)
    }
}

fn thesis_table(distances: &Distances, nm: &[f64; 4], veil: Veil) -> ShadowTable {
    let (umbra, penumbra) = thesis_radii(distances.moon_m, distances.star_m);
    let (umbra, penumbra) = (umbra.max(0.01), penumbra.max(0.02));
    let node = |i: usize| {
        let d_f = penumbra * i as f64 / (NODES - 1) as f64;
        // [mueller2012, eq. 4.16]
        let t_f = if d_f < umbra { 0.5 * d_f / umbra } else { 0.5 + 0.5 * (d_f - umbra) / (penumbra - umbra) };
        let colour = thesis_colour(t_f);
        nm.map(|nm| at_wavelength(colour, nm).max(1e-9).ln())
    };
    let moon_radius_m = Body::Moon.radius_m();
    ShadowTable {
        veil,
        distances: *distances,
        thesis: true,
        map: Arc::new(EclipseMap { ln_light: (0..NODES).map(node).collect() }),
        step_m: penumbra * moon_radius_m / (NODES - 1) as f64,
        edge_m: umbra * moon_radius_m,
    }
}

#[cfg(test)]
mod tests;
