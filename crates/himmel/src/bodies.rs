//! Other planets and moons of a scene: where they stand, what they are made of, what lights them.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use himmel_air::{AirParams, Atmosphere, GroundParams, Preset};
use himmel_core::{choices, params};
use himmel_gpu::{AlbedoMap, FarBody, FarLight, MOST_FAR_BODIES};
use tracing::warn;

use crate::clock::parse_time;
use crate::error::{Error, Result};
use crate::model::{SkyModel, direction_enu};
use crate::scene::Scene;

/// The Moon's, where nobody says anything else.
const ALBEDO: f64 = 0.12;

choices! {
    /// Who goes around whom.
    pub enum Orbit {
        /// It stands where directions and distance say.
        None = "none",
        /// It goes around the planet of the scene.
        AroundHome = "around-home",
        /// The planet of the scene goes around it.
        HomeAround = "home-around",
    }
}

params! {
    /// Another planet or moon in the sky: one table [[bodies]] for each, at most three.
    pub struct BodyParams: "bodies" {
        /// What camera.look and messages call it.
        name: String = String::new();
        /// Whether it is there.
        enabled: bool = true;
        /// Its air: a preset's name or file; empty: no air.
        preset: String = String::new();
        /// Factor on the amount of every gas of its air that scatters.
        molecules: f64 = 1.0, "", 0.0..=100.0;
        /// Factor on the amount of every aerosol of its air.
        aerosols: f64 = 1.0, "", 0.0..=1000.0;
        /// Radius of its ground; unset: the preset's.
        radius_km: Option<f64> = None, "km", 1.0..=1e6;
        /// Mean share of light that its ground reflects; unset: the map's, the preset's, or the Moon's 0.12.
        albedo: Option<f64> = None, "", 0.0..=1.0;
        /// Picture of its albedo, twice as wide as high, north at the top (relative to the scene file); empty: even ground.
        albedo_map: String = String::new();
        /// Azimuth of its centre from north through east, without refraction.
        azimuth_deg: Option<f64> = None, "°", -360.0..=360.0;
        /// Altitude of its centre above the level, without refraction.
        altitude_deg: Option<f64> = None, "°", -90.0..=90.0;
        /// Right ascension of its centre (ICRS) instead of azimuth.
        right_ascension_deg: Option<f64> = None, "°", -360.0..=360.0;
        /// Declination of its centre (ICRS) instead of altitude.
        declination_deg: Option<f64> = None, "°", -90.0..=90.0;
        /// From the camera to its centre.
        distance_km: Option<f64> = None, "km", 1.0..=5e11;
        /// Who goes around whom; an orbit takes the place of direction and distance.
        orbit: Orbit = Orbit::None;
        /// Semi-major axis of the orbit, from centre to centre.
        semi_major_axis_km: Option<f64> = None, "km", 1.0..=5e11;
        /// How long one turn takes.
        period_h: Option<f64> = None, "h", 1e-3..=1e9;
        /// Eccentricity; 0: a circle.
        eccentricity: f64 = 0.0, "", 0.0..=0.99;
        /// Inclination of the orbit to the equator of ICRS.
        inclination_deg: f64 = 0.0, "°", 0.0..=180.0;
        /// Right ascension of the ascending node.
        node_deg: f64 = 0.0, "°", -360.0..=360.0;
        /// From the node to the point that is nearest.
        periapsis_deg: f64 = 0.0, "°", -360.0..=360.0;
        /// Mean anomaly at the epoch.
        mean_anomaly_deg: f64 = 0.0, "°", -360.0..=360.0;
        /// When the mean anomaly is that: ISO 8601.
        epoch: String = "2000-01-01T12:00Z".to_string();
        /// Longitude in the middle of the disc.
        longitude_deg: f64 = 0.0, "°", -360.0..=360.0;
        /// Latitude in the middle of the disc.
        latitude_deg: f64 = 0.0, "°", -90.0..=90.0;
        /// How far its north is turned from the zenith, anticlockwise.
        tilt_deg: f64 = 0.0, "°", -360.0..=360.0;
        /// Azimuth of its sun, as from the camera; unset: the scene's Sun.
        sun_azimuth_deg: Option<f64> = None, "°", -360.0..=360.0;
        /// Altitude of its sun, as from the camera; unset: the scene's Sun.
        sun_altitude_deg: Option<f64> = None, "°", -90.0..=90.0;
        /// Factor on the sunlight that the scene's planet gets.
        sunlight: f64 = 1.0, "", 0.0..=1e6;
    }
}

/// What decides a body's air.
#[derive(Clone, Debug, PartialEq)]
struct AirKey {
    preset: String,
    folder: PathBuf,
    factors: [f64; 2],
    radius_m: f64,
    albedo: Option<f64>,
    /// Wavelengths are the scene's.
    air: AirParams,
}

/// A body with what was loaded for it.
#[derive(Clone)]
struct Loaded {
    params: BodyParams,
    radius_m: f64,
    albedo: [f64; 4],
    map: Option<(PathBuf, Arc<AlbedoMap>)>,
    air: Option<(AirKey, Arc<Atmosphere>)>,
}

/// The bodies of a scene.
#[derive(Clone, Default)]
pub(crate) struct Bodies(Vec<Loaded>);

impl Bodies {
    /// Loads airs and maps, those that `old` has too from there.
    pub(crate) fn new(scene: &Scene, old: &Self) -> Result<Self> {
        let enabled: Vec<_> = scene.bodies.iter().filter(|body| body.enabled).collect();
        if enabled.len() > MOST_FAR_BODIES {
            return Err(Error::Body {
                body: title(enabled[MOST_FAR_BODIES], MOST_FAR_BODIES),
                message: format!("a scene has at most {MOST_FAR_BODIES} other bodies, got {}", enabled.len()),
            });
        }
        let load = |(index, params): (usize, &&BodyParams)| load(scene, params, &title(params, index), old);
        enabled.iter().enumerate().map(load).collect::<Result<_>>().map(Self)
    }

    /// Their airs, in the order that [`FarBody::air`] counts.
    pub(crate) fn airs(&self) -> Vec<Arc<Atmosphere>> {
        self.0.iter().filter_map(|body| body.air.as_ref()).map(|(_, air)| Arc::clone(air)).collect()
    }
}

/// What messages call a body.
fn title(params: &BodyParams, index: usize) -> String {
    match params.name.as_str() {
        "" => format!("bodies[{index}]"),
        name => format!("body \"{}\"", himmel_core::params::shorten(name)),
    }
}

fn load(scene: &Scene, params: &BodyParams, title: &str, old: &Bodies) -> Result<Loaded> {
    let wrong = |message: &str| Error::Body { body: title.into(), message: message.into() };
    let preset = match params.preset.as_str() {
        "" => None,
        name => {
            let named = Scene { preset: name.into(), folder: scene.folder.clone(), ..Scene::default() };
            Some(named.load_preset()?)
        }
    };
    let radius_m = match (params.radius_km, &preset) {
        (Some(km), _) => km * 1e3,
        (None, Some(preset)) => preset.medium.bottom_radius_m,
        (None, None) => return Err(wrong("it has no preset and needs a radius_km")),
    };
    check_position(params).map_err(|message| wrong(&message))?;
    let map = load_map(scene, params, title, old);
    let mean = map.as_ref().map(|(_, map)| {
        let [r, g, b] = map.mean();
        0.2126 * r + 0.7152 * g + 0.0722 * b
    });
    // With a map: what white is.
    let scale = match (params.albedo, mean) {
        (Some(albedo), Some(mean)) => Some(if mean > 1e-4 { albedo / mean } else { 0.0 }),
        (albedo, mean) => albedo.or(mean.map(|_| 1.0)),
    };
    let ground = params.albedo.or(mean);
    let air = preset.map(|preset| load_air(scene, params, preset, radius_m, ground, old));
    let own = air.as_ref().map_or([ALBEDO; 4], |(_, air)| air.sampled().ground_albedo);
    Ok(Loaded { params: params.clone(), radius_m, albedo: scale.map_or(own, |scale| [scale; 4]), map, air })
}

fn load_air(
    scene: &Scene,
    params: &BodyParams,
    mut preset: Preset,
    radius_m: f64,
    albedo: Option<f64>,
    old: &Bodies,
) -> (AirKey, Arc<Atmosphere>) {
    let air = AirParams {
        enabled: true,
        molecules: params.molecules,
        aerosols: params.aerosols,
        absorbers: 1.0,
        ..scene.air.clone()
    };
    let factors = [params.molecules, params.aerosols];
    let (name, folder) = (params.preset.clone(), scene.folder.clone());
    let key = AirKey { preset: name, folder, factors, radius_m, albedo, air: air.clone() };
    let known = old.0.iter().filter_map(|body| body.air.as_ref()).find(|(other, _)| *other == key);
    match known {
        Some((_, air)) => (key, Arc::clone(air)),
        None => {
            preset.medium.bottom_radius_m = radius_m;
            let ground = GroundParams { albedo, ..GroundParams::default() };
            (key, Arc::new(Atmosphere::new(&preset, &air, &ground)))
        }
    }
}

/// A map that is missing or broken is a warning and even ground: the sky goes on.
fn load_map(scene: &Scene, params: &BodyParams, title: &str, old: &Bodies) -> Option<(PathBuf, Arc<AlbedoMap>)> {
    if params.albedo_map.is_empty() {
        return None;
    }
    let path = scene.folder.join(&params.albedo_map);
    if let Some(known) = old.0.iter().filter_map(|body| body.map.as_ref()).find(|(other, _)| *other == path) {
        return Some(known.clone());
    }
    let read = || {
        let picture = image::open(&path).map_err(|error| error.to_string())?.to_rgba8();
        let texels = picture.as_raw().chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]).collect();
        AlbedoMap::new(picture.width(), picture.height(), texels).map_err(|error| error.to_string())
    };
    match read() {
        Ok(map) => Some((path, Arc::new(map))),
        Err(reason) => {
            warn!(%reason, "albedo_map of {title} cannot be used ({}); its ground is even", path.display());
            None
        }
    }
}

/// Whether it is said once where a body stands.
fn check_position(params: &BodyParams) -> std::result::Result<(), String> {
    let level = [params.azimuth_deg, params.altitude_deg].map(|value| value.is_some());
    let equatorial = [params.right_ascension_deg, params.declination_deg].map(|value| value.is_some());
    let any = |pair: [bool; 2]| pair[0] || pair[1];
    if params.orbit != Orbit::None {
        parse_time(&params.epoch, &jiff::tz::TimeZone::UTC).map_err(|error| format!("its epoch: {error}"))?;
        return match params.semi_major_axis_km {
            None => Err("an orbit needs a semi_major_axis_km".into()),
            Some(_) if any(level) || any(equatorial) || params.distance_km.is_some() => {
                Err("an orbit takes the place of direction and distance_km: leave out either".into())
            }
            Some(_) => Ok(()),
        };
    }
    match (level, equatorial) {
        ([true, true], [false, false]) | ([false, false], [true, true]) => {}
        _ => {
            return Err(
                "it needs azimuth_deg and altitude_deg, or right_ascension_deg and declination_deg, or an orbit".into(),
            );
        }
    }
    if params.distance_km.is_none() { Err("it needs a distance_km".into()) } else { Ok(()) }
}

/// From what is gone around to what goes around it, ICRS, m.
fn on_orbit(params: &BodyParams, axis_m: f64, seconds: f64) -> DVec3 {
    let e = params.eccentricity;
    let turns = params.period_h.map_or(0.0, |hours| seconds / (3600.0 * hours));
    let mean = (params.mean_anomaly_deg.to_radians() + TAU * turns.fract()).rem_euclid(TAU);
    // Kepler's equation by Newton's steps from π, where they converge for every eccentricity.
    let mut anomaly = std::f64::consts::PI;
    for _ in 0..30 {
        anomaly -= (anomaly - e * anomaly.sin() - mean) / (1.0 - e * anomaly.cos());
    }
    let place = DVec3::new(anomaly.cos() - e, (1.0 - e * e).sqrt() * anomaly.sin(), 0.0) * axis_m;
    let turn = |axis: DVec3, degrees: f64| DMat3::from_axis_angle(axis, degrees.to_radians());
    turn(DVec3::Z, params.node_deg)
        * turn(DVec3::X, params.inclination_deg)
        * turn(DVec3::Z, params.periapsis_deg)
        * place
}

impl SkyModel {
    /// The airs of the scene's other bodies, for [`SkyRenderer::set_far_airs`](himmel_gpu::SkyRenderer::set_far_airs).
    pub fn far_airs(&self) -> Vec<Arc<Atmosphere>> {
        self.bodies().airs()
    }

    /// The scene's other bodies as they stand now.
    pub fn far_bodies(&self) -> Result<Vec<FarBody>> {
        if self.bodies().0.is_empty() {
            return Ok(Vec::new());
        }
        let sun = self.sun()?;
        let irradiance = self.scene().sun.brightness / (sun.distance_au * sun.distance_au);
        let mut airs = 0;
        let mut bodies = Vec::with_capacity(self.bodies().0.len());
        for (index, body) in self.bodies().0.iter().enumerate() {
            let params = &body.params;
            let centre_m = self.centre_of(params)?;
            if centre_m.length() <= body.radius_m {
                return Err(Error::Body {
                    body: title(params, index),
                    message: format!(
                        "the camera is inside: its centre is {:.0} km away, its radius is {:.0} km",
                        centre_m.length() / 1e3,
                        body.radius_m / 1e3
                    ),
                });
            }
            let air = body.air.as_ref().map(|_| airs);
            airs += usize::from(air.is_some());
            let light = FarLight {
                direction: direction_enu(
                    params.sun_azimuth_deg.unwrap_or(sun.azimuth_deg),
                    params.sun_altitude_deg.unwrap_or(sun.airless_altitude_deg),
                ),
                irradiance: [irradiance * params.sunlight; 4],
            };
            bodies.push(FarBody {
                centre_m,
                radius_m: body.radius_m,
                body_from_enu: facing(params, centre_m.normalize_or(DVec3::Z)),
                albedo: body.albedo,
                map: body.map.as_ref().map(|(_, map)| Arc::clone(map)),
                air,
                lights: vec![light],
            });
        }
        Ok(bodies)
    }

    /// The direction to a body of that name, east-north-up without refraction.
    pub(crate) fn direction_of_body(&self, name: &str) -> Result<Option<DVec3>> {
        let named = |body: &&Loaded| body.params.name.eq_ignore_ascii_case(name.trim());
        match self.bodies().0.iter().filter(|body| !body.params.name.is_empty()).find(named) {
            Some(body) => Ok(Some(self.centre_of(&body.params)?.normalize_or(DVec3::Z))),
            None => Ok(None),
        }
    }

    /// From the camera, east-north-up, m.
    fn centre_of(&self, params: &BodyParams) -> Result<DVec3> {
        let (instant, place) = self.standing()?;
        let observer = himmel_astro::Observer::new(self.ephemeris(), &instant, &place)?;
        let enu_from_icrs = place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        if let (Orbit::AroundHome | Orbit::HomeAround, Some(axis_km)) = (params.orbit, params.semi_major_axis_km) {
            let epoch = parse_time(&params.epoch, &jiff::tz::TimeZone::UTC)?;
            let seconds = self.clock().unix_seconds() - epoch.as_duration().as_secs_f64();
            let relative = enu_from_icrs * on_orbit(params, axis_km * 1e3, seconds);
            let from_home = if params.orbit == Orbit::HomeAround { -relative } else { relative };
            let camera_m = self.atmosphere().medium().bottom_radius_m + self.altitude_m();
            return Ok(from_home - DVec3::Z * camera_m);
        }
        let distance_m = params.distance_km.unwrap_or(0.0) * 1e3;
        let direction = match (params.right_ascension_deg, params.declination_deg) {
            (Some(ra), Some(dec)) => {
                let ((sin_a, cos_a), (sin_d, cos_d)) = (ra.to_radians().sin_cos(), dec.to_radians().sin_cos());
                enu_from_icrs * DVec3::new(cos_d * cos_a, cos_d * sin_a, sin_d)
            }
            _ => direction_enu(params.azimuth_deg.unwrap_or(0.0), params.altitude_deg.unwrap_or(0.0)),
        };
        Ok(direction * distance_m)
    }
}

/// The frame of a body whose disc shows a place in its middle; `direction` to it.
fn facing(params: &BodyParams, direction: DVec3) -> DMat3 {
    let towards = -direction;
    let up = (DVec3::Z - towards * towards.z).try_normalize().unwrap_or(DVec3::Y);
    let up = DMat3::from_axis_angle(towards, params.tilt_deg.to_radians()) * up;
    let right = up.cross(towards);
    // Rows: towards us, to the right, up; then turned so that latitude and longitude are in the middle.
    let disc_from_enu = DMat3::from_cols(towards, right, up).transpose();
    let latitude = DMat3::from_rotation_y(-params.latitude_deg.to_radians());
    DMat3::from_rotation_z(params.longitude_deg.to_radians()) * latitude * disc_from_enu
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_the_disc_is_the_place_that_was_asked_for() {
        let params = BodyParams { longitude_deg: 30.0, latitude_deg: -20.0, tilt_deg: 77.0, ..BodyParams::default() };
        let direction = DVec3::new(0.3, -0.5, 0.2).normalize();
        let own = facing(&params, direction) * -direction;
        assert!((own.y.atan2(own.x).to_degrees() - 30.0).abs() < 1e-9, "{own}");
        assert!((own.z.asin().to_degrees() + 20.0).abs() < 1e-9, "{own}");
        // North is up, east to the right.
        let plain = facing(&BodyParams::default(), DVec3::Y);
        assert!((plain * DVec3::Z - DVec3::Z).length() < 1e-12);
        assert!((plain * DVec3::X - DVec3::Y).length() < 1e-12);
    }

    /// Kepler's laws: distances at both ends, and equal areas.
    #[test]
    fn orbits_follow_kepler() {
        let params =
            BodyParams { eccentricity: 0.6, period_h: Some(10.0), inclination_deg: 40.0, ..BodyParams::default() };
        let at = |hours: f64| on_orbit(&params, 1e8, hours * 3600.0);
        assert!((at(0.0).length() - 0.4e8).abs() < 1.0 && (at(5.0).length() - 1.6e8).abs() < 1.0);
        assert!((at(10.0) - at(0.0)).length() < 1.0);
        let area = |hours: f64| at(hours).cross(at(hours + 1e-3)).length();
        assert!((area(1.0) / area(4.0) - 1.0).abs() < 1e-3);
        let circle = BodyParams { period_h: Some(4.0), ..BodyParams::default() };
        assert!((on_orbit(&circle, 1.0, 3600.0) - DVec3::Y).length() < 1e-9);
    }
}
