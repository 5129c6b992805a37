//! Everything about a sky but its GPU: where the Sun is, what its light amounts to, what a frame needs.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use himmel_air::disc::Disc;
use himmel_air::eclipse::Shadow;
use himmel_air::refraction::Bending;
use himmel_air::scene_light::{Ambient, Eclipse};
use himmel_air::single::Ray;
use himmel_air::{Atmosphere, Preset};
use himmel_astro::query::Target;
use himmel_astro::{Body, Ephemeris, Fast, Instant, Place, Precise, observe};
use himmel_core::constants::{ASTRONOMICAL_UNIT_M, SUN_RADIUS_M};
use himmel_gpu::{FarBody, FrameState, Occluder, Projection, SunState, View};
use jiff::Timestamp;

use crate::bodies::Bodies;
use crate::clock::{Clock, parse_time};
use crate::error::{Error, Result};
use crate::light::{AmbientLight, Light, LightSource, MOON, SunLight, pure_colour};
use crate::moon::{Moon, MoonCache};
use crate::names::Named;
use crate::night::NightCache;
use crate::observer::Observer;
use crate::points::{Moving, PointCache, hiders};
use crate::scene::{ProjectionKind, Scene};

/// Eyes above the ground, m.
const EYE_HEIGHT_M: f64 = 2.0;
/// The Moon farther than this from the Sun shades no air that one sees: its own parallax over 2,000 km is 0.3°, the two
/// radii half a degree.
const ECLIPSE_WITHIN_RAD: f64 = 0.05;

/// Cells along a ray of the renderer's f64 twin.
const TWIN_STEPS: usize = 48;
/// With the Sun lower than this the air leaves all stars visible.
const DARK_BELOW_DEG: f64 = -9.0;
/// Cells of the rays that tell how dark the sky is.
const DARK_STEPS: usize = 12;

/// A sky that can be asked for numbers, without a GPU.
///
/// ```
/// let mut scene = himmel::Scene::default();
/// scene.set("observer.place", "Potsdam")?;
/// scene.set("clock.time", "2012-09-06T16:00Z")?;
/// let model = himmel::SkyModel::new(&scene)?;
/// let light = model.light()?;
/// assert!((light.sun.altitude_deg - 14.9).abs() < 0.1);
/// assert!(light.horizontal_illuminance_lx() > 10_000.0);
/// # Ok::<(), himmel::Error>(())
/// ```
pub struct SkyModel {
    scene: Scene,
    preset: Preset,
    atmosphere: Atmosphere,
    observer: Observer,
    clock: Clock,
    ephemeris: Box<dyn Ephemeris + Send + Sync>,
    /// The bent sky of the altitude that was last asked for.
    bending: Mutex<Option<(f64, Arc<Bending>)>>,
    moon: MoonCache,
    night: NightCache,
    points: PointCache,
    bodies: Bodies,
}

/// The Sun's place for an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPlace {
    /// From north through east, 0..360.
    pub azimuth_deg: f64,
    /// Above the horizon, as refraction shows it.
    pub altitude_deg: f64,
    /// Above the horizon, without air.
    pub airless_altitude_deg: f64,
    /// From the observer.
    pub distance_au: f64,
    /// Apparent radius of its disc.
    pub radius_deg: f64,
}

impl SkyModel {
    /// Reads place, time and preset of a scene and integrates the air's tables (about 40 ms).
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::with_preset(scene, scene.load_preset()?)
    }

    /// As [`new`](Self::new), with an atmosphere of your own instead of the one that the scene names.
    pub fn with_preset(scene: &Scene, preset: Preset) -> Result<Self> {
        let observer = Observer::at(&scene.observer.place)?;
        let mut clock = Clock::from_timestamp(parse_time(&scene.clock.time, &observer.time_zone)?);
        clock.set_rate(scene.clock.rate);
        if scene.clock.paused {
            clock.pause();
        }
        let atmosphere = Atmosphere::new(&preset, &scene.air, &scene.ground);
        let ephemeris: Box<dyn Ephemeris + Send + Sync> = match Precise::embedded() {
            Ok(precise) => Box::new(precise),
            Err(error) => {
                tracing::warn!(%error, "the ephemeris pack cannot be read; the fast series take over");
                Box::new(Fast)
            }
        };
        let bending = Mutex::new(None);
        Ok(Self {
            scene: scene.clone(),
            preset,
            atmosphere,
            observer,
            clock,
            ephemeris,
            bending,
            points: PointCache::default(),
            bodies: Bodies::new(scene, &Bodies::default())?,
            moon: MoonCache::default(),
            night: NightCache::default(),
        })
    }

    /// The settings as they were given; the clock may have run, and the observer moved, since.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The atmosphere with its tables.
    pub fn atmosphere(&self) -> &Atmosphere {
        &self.atmosphere
    }

    /// The preset that the scene names.
    pub fn preset(&self) -> &Preset {
        &self.preset
    }

    /// Where one stands.
    pub fn observer(&self) -> &Observer {
        &self.observer
    }

    /// Stands elsewhere.
    pub fn set_observer(&mut self, observer: Observer) {
        self.observer = observer;
    }

    pub(crate) fn ephemeris(&self) -> &dyn Ephemeris {
        self.ephemeris.as_ref()
    }

    pub(crate) fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    pub(crate) fn moon_cache(&self) -> &MoonCache {
        &self.moon
    }

    pub(crate) fn night_cache(&self) -> &NightCache {
        &self.night
    }

    /// The clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The clock, to run, stop or set it.
    pub fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    /// Sets the clock: ISO 8601; bare times are local to the observer.
    pub fn set_time(&mut self, text: &str) -> Result<()> {
        let now = parse_time(text, &self.observer.time_zone)?;
        self.clock.set(now);
        self.scene.clock.time = text.into();
        Ok(())
    }

    /// Changes settings; true if the air's tables had to be integrated anew.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<bool> {
        let old = std::mem::replace(&mut self.scene, scene.clone());
        let result = self.follow(&old);
        if result.is_err() {
            self.scene = old;
        }
        result
    }

    fn follow(&mut self, old: &Scene) -> Result<bool> {
        let clock_changed = self.scene.clock != old.clock;
        // Everything that can fail comes before anything that changes.
        // A place that was set by hand stays until another one is named.
        let place_changed = self.scene.observer.place != old.observer.place;
        let observer = if place_changed { Observer::at(&self.scene.observer.place)? } else { self.observer.clone() };
        // A bare time is local: at another place it is another instant, unless the clock has gone elsewhere meanwhile.
        let follows_place = place_changed
            && old.clock.time.trim() != "now"
            && parse_time(&old.clock.time, &self.observer.time_zone)? == self.clock.now();
        let time_changed = self.scene.clock.time != old.clock.time || follows_place;
        let now = if time_changed { Some(parse_time(&self.scene.clock.time, &observer.time_zone)?) } else { None };
        let preset_changed = (&self.scene.preset, &self.scene.folder) != (&old.preset, &old.folder);
        let preset = if preset_changed { Some(self.scene.load_preset()?) } else { None };
        let follows = self.scene.bodies != old.bodies || self.scene.air != old.air || self.scene.folder != old.folder;
        let bodies = if follows { Bodies::new(&self.scene, &self.bodies)? } else { self.bodies.clone() };
        self.bodies = bodies;
        self.observer = observer;
        if let Some(now) = now {
            self.clock.set(now);
        }
        if clock_changed {
            self.clock.set_rate(self.scene.clock.rate);
            if self.scene.clock.paused { self.clock.pause() } else { self.clock.resume() }
        }
        let air_changed = self.scene.air != old.air || self.scene.ground != old.ground;
        if let Some(preset) = preset {
            self.preset = preset;
        }
        if air_changed || preset_changed {
            self.atmosphere = self.atmosphere.edited(&self.preset, &self.scene.air, &self.scene.ground);
            self.bending = Mutex::new(None);
            self.moon.forget_air();
        }
        Ok(air_changed || preset_changed)
    }

    /// Height of the camera above the ground sphere, m.
    pub fn altitude_m(&self) -> f64 {
        self.scene.observer.altitude_m.unwrap_or(self.observer.height_m.max(0.0) + EYE_HEIGHT_M)
    }

    /// Where the Sun is.
    pub fn sun(&self) -> Result<SunPlace> {
        let instant = Instant::from_unix_seconds(self.clock.unix_seconds())?;
        let place = Place::from_degrees(self.observer.latitude_deg, self.observer.longitude_deg, self.altitude_m())?;
        let seen = observe(self.ephemeris.as_ref(), Body::Sun, &instant, &place)?;
        let settings = &self.scene.sun;
        let azimuth_deg = settings.azimuth_deg.unwrap_or(seen.azimuth_rad.to_degrees()).rem_euclid(360.0);
        let airless_altitude_deg = settings.altitude_deg.unwrap_or(seen.altitude_rad.to_degrees());
        let distance_au =
            settings.distance_au.or(self.preset.sun_distance_au).unwrap_or(seen.distance_m / ASTRONOMICAL_UNIT_M);
        let radius_suns = self.preset.stars.first().map_or(1.0, |star| star.radius_suns);
        let sine = radius_suns * SUN_RADIUS_M / (distance_au * ASTRONOMICAL_UNIT_M);
        Ok(SunPlace {
            azimuth_deg,
            altitude_deg: self.bending().apparent_rad(airless_altitude_deg.to_radians()).to_degrees(),
            airless_altitude_deg,
            distance_au,
            radius_deg: sine.min(1.0).asin().to_degrees(),
        })
    }

    /// How the air of the preset bends what is seen from the observer's altitude: two milliseconds for a new altitude.
    pub fn bending(&self) -> Arc<Bending> {
        let altitude_m = self.altitude_m();
        let mut cached = self.bending.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((at_m, bending)) if *at_m == altitude_m => Arc::clone(bending),
            _ => {
                let bends = self.preset.refraction && self.scene.air.enabled;
                let (medium, nm) = (self.atmosphere.medium(), self.atmosphere.wavelengths_nm());
                let new = if bends { Bending::new(medium, &nm, altitude_m) } else { Bending::none() };
                let new = Arc::new(new);
                *cached = Some((altitude_m, Arc::clone(&new)));
                new
            }
        }
    }

    /// The Moon, where it may stand before the Sun: by the ephemeris, so for the Earth's Sun at its own place and time.
    pub fn occluder(&self) -> Result<Option<Occluder>> {
        let settings = &self.scene.sun;
        let elsewhere = settings.azimuth_deg.is_some() || settings.altitude_deg.is_some();
        if elsewhere || settings.distance_au.or(self.preset.sun_distance_au).is_some() {
            return Ok(None);
        }
        let instant = Instant::from_unix_seconds(self.clock.unix_seconds())?;
        let place = Place::from_degrees(self.observer.latitude_deg, self.observer.longitude_deg, self.altitude_m())?;
        let observer = himmel_astro::Observer::new(self.ephemeris.as_ref(), &instant, &place)?;
        let (sun, moon) = (observer.apparent(Body::Sun)?, observer.apparent(Body::Moon)?);
        if sun.direction_enu.angle_between(moon.direction_enu) > ECLIPSE_WITHIN_RAD {
            return Ok(None);
        }
        let apparent_rad = self.bending().apparent_rad(moon.altitude_rad);
        Ok(Some(Occluder {
            direction: moon.direction_enu,
            disc_direction: direction_enu(moon.azimuth_rad.to_degrees(), apparent_rad.to_degrees()),
            distance_m: moon.distance_m,
            radius_m: Body::Moon.radius_m(),
            angular_radius_rad: moon.semidiameter_rad(),
        }))
    }

    /// The cone of the Moon's shadow in an eclipse that reaches the air around the observer.
    pub fn shadow(&self) -> Result<Option<Shadow>> {
        let Some(occluder) = self.occluder()? else { return Ok(None) };
        let sun = self.sun()?;
        let direction = direction_enu(sun.azimuth_deg, sun.airless_altitude_deg);
        let radius_rad = (sun.radius_deg * self.scene.sun.radius_scale).to_radians();
        let shadow = occluder.shadow(direction, radius_rad, sun.distance_au * ASTRONOMICAL_UNIT_M);
        // What one sees of the air: to the top of it beyond the horizon.
        let radius_m = self.atmosphere.medium().bottom_radius_m;
        let reach_m = himmel_air::geometry::top_distance(
            radius_m,
            self.atmosphere.medium().top_altitude_m.max(self.altitude_m()),
            self.altitude_m(),
            himmel_air::geometry::horizon_cosine(radius_m, self.altitude_m()),
        );
        Ok(shadow.reaches(reach_m).then_some(shadow))
    }

    /// Limb darkening of the Sun at the four wavelengths, or an even disc.
    pub fn limb_darkening(&self) -> [[f64; 6]; 4] {
        match self.scene.sun.limb_darkening {
            true => self.atmosphere.wavelengths_nm().map(himmel_air::sun::limb_darkening),
            false => [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; 4],
        }
    }

    /// The lights of the scene at the observer: the Sun with what an eclipse leaves of it, and sky and ground with all
    /// orders of scattering.
    ///
    /// The first call after an edit of the air fills a coarse table of all orders (some tenths of a second); others take
    /// some milliseconds. Nothing is read back from a GPU.
    pub fn light(&self) -> Result<Light> {
        let sun = self.sun()?;
        let air = &self.atmosphere;
        let irradiance = self.scene.sun.brightness / (sun.distance_au * sun.distance_au);
        let (shadow, limb) = (self.shadow()?, self.limb_darkening());
        let beam = self.beam()?.map(|b| b * irradiance);
        let (xyz, rec709) = (air.xyz(beam), air.rec709(beam));
        let star = direction_enu(sun.azimuth_deg, sun.airless_altitude_deg);
        let eclipse = shadow.as_ref().map(|shadow| Eclipse { shadow, limb: &limb });
        let visible = shadow.as_ref().map_or([1.0; 4], |shadow| shadow.fraction(DVec3::ZERO, &limb));
        let ambient = air.scene_light().at(&air.sampled(), air.columns(), self.altitude_m(), star, eclipse);
        let luminous = |relative: [f64; 4]| air.xyz(relative.map(|value| value * irradiance)).y.max(0.0);
        let moon = self.moon()?;
        // Moonlight in the air and on the ground, where it matters beside the Sun's.
        let by_moon = match &moon {
            Some(moon) if self.moon_as_light(moon)?.is_some() => {
                let direction = moon.state.direction;
                let ambient = air.scene_light().at(&air.sampled(), air.columns(), self.altitude_m(), direction, None);
                ambient.times(moon.irradiance)
            }
            _ => Ambient::default(),
        };
        let twilight_cd_m2 = luminous(ambient.zenith_per_sr) + air.xyz(by_moon.zenith_per_sr).y.max(0.0);
        let night = self.night()?;
        let night_zenith = night.as_ref().map(|night| self.night_zenith(night, twilight_cd_m2));
        let glow = match &night {
            Some(night) => Ambient::gathered(|add| night.all_around(air, self.altitude_m(), add)),
            None => Ambient::default(),
        };
        let sum = |sun: [f64; 4], moon: [f64; 4], glow: [f64; 4]| {
            std::array::from_fn(|k| sun[k] * irradiance + moon[k] + glow[k])
        };
        let down = sum(ambient.down, by_moon.down, glow.down);
        let up = sum(ambient.up, by_moon.up, glow.up);
        let harmonics: [[f64; 4]; 9] =
            std::array::from_fn(|i| sum(ambient.harmonics[i], by_moon.harmonics[i], glow.harmonics[i]));
        let direct = SunLight {
            direction_enu: direction_enu(sun.azimuth_deg, sun.altitude_deg),
            azimuth_deg: sun.azimuth_deg,
            altitude_deg: sun.altitude_deg,
            colour: pure_colour(rec709),
            illuminance_lx: xyz.y.max(0.0),
        };
        let mut sources = vec![LightSource {
            name: self.preset.stars.first().map_or_else(|| "Sun".into(), |star| star.name.clone()),
            direction_enu: direct.direction_enu,
            colour: direct.colour,
            illuminance_lx: direct.illuminance_lx,
        }];
        sources.extend(moon.map(|moon| {
            let beam = self.moon_beam(&moon);
            LightSource {
                name: MOON.into(),
                direction_enu: moon.state.disc_direction,
                colour: pure_colour(air.rec709(beam)),
                illuminance_lx: air.xyz(beam).y.max(0.0),
            }
        }));
        Ok(Light {
            sources,
            sun: direct,
            sky_illuminance_lx: air.xyz(down).y.max(0.0),
            sky_colour: pure_colour(air.rec709(down)),
            ground_illuminance_lx: air.xyz(up).y.max(0.0),
            zenith_luminance_cd_m2: night_zenith.map_or(twilight_cd_m2, |zenith| zenith.sum_cd_m2()),
            night: night_zenith,
            ambient: AmbientLight { harmonics_cd_m2: harmonics.map(|four| air.rec709(four).to_array()) },
            eclipse_fraction: luminous(visible) / luminous([1.0; 4]).max(f64::MIN_POSITIVE),
        })
    }

    /// What of the Sun's light arrives: its transmittance times the visible share of its disc, at the four wavelengths.
    pub(crate) fn beam(&self) -> Result<[f64; 4]> {
        let (sun, altitude_m) = (self.sun()?, self.altitude_m());
        let visible = visible_fraction(sun.altitude_deg - self.horizon_deg(), sun.radius_deg);
        let lowest_mu = himmel_air::geometry::horizon_cosine(self.atmosphere.medium().bottom_radius_m, altitude_m);
        // A disc that touches the horizon shines from its visible part, just above it.
        let mu = sun.altitude_deg.to_radians().sin().max(lowest_mu + 1e-9);
        let eclipse = match self.shadow()? {
            Some(shadow) => shadow.fraction(DVec3::ZERO, &self.limb_darkening()),
            None => [1.0; 4],
        };
        let through = self.atmosphere.sun_transmittance(altitude_m, mu);
        Ok(std::array::from_fn(|k| through[k] * visible * eclipse[k]))
    }

    /// Altitude of the geometric horizon, degrees (zero or negative).
    pub(crate) fn horizon_deg(&self) -> f64 {
        himmel_air::geometry::horizon_cosine(self.atmosphere.medium().bottom_radius_m, self.altitude_m())
            .asin()
            .to_degrees()
    }

    /// When and where one looks.
    pub(crate) fn standing(&self) -> Result<(Instant, Place)> {
        let instant = Instant::from_unix_seconds(self.clock.unix_seconds())?;
        let place = Place::from_degrees(self.observer.latitude_deg, self.observer.longitude_deg, self.altitude_m())?;
        Ok((instant, place))
    }

    /// The Sun as the air and the picture have it.
    fn sun_state(&self) -> Result<SunState> {
        let (sun, settings) = (self.sun()?, &self.scene.sun);
        Ok(SunState {
            direction: direction_enu(sun.azimuth_deg, sun.airless_altitude_deg),
            disc_direction: direction_enu(sun.azimuth_deg, sun.altitude_deg),
            radius_rad: (sun.radius_deg * settings.radius_scale).to_radians(),
            irradiance: [settings.brightness / (sun.distance_au * sun.distance_au); 4],
            disc: settings.disc,
            limb_darkening: settings.limb_darkening,
        })
    }

    /// No part of the sky above the horizon is darker: half of the least that light scattered once shows in some directions. 0 at
    /// night and while something stands before the Sun.
    fn darkest_sky_cd_m2(&self) -> Result<f64> {
        let sun = self.sun_state()?;
        let sun_deg = sun.direction.z.clamp(-1.0, 1.0).asin().to_degrees();
        if sun_deg < DARK_BELOW_DEG || self.occluder()?.is_some() || self.shadow()?.is_some() {
            return Ok(0.0);
        }
        let (altitude_m, azimuth) = (self.altitude_m().max(0.5), sun.direction.x.atan2(sun.direction.y));
        let mut darkest = f64::INFINITY;
        for (elevation_deg, turns) in [(2f64, 5), (15.0, 5), (35.0, 5), (60.0, 3), (90.0, 1)] {
            for turn in 0..turns {
                let aside = std::f64::consts::PI * f64::from(turn) / f64::from((turns - 1).max(1));
                let (sine, cosine) = elevation_deg.to_radians().sin_cos();
                let to = DVec3::new(cosine * (azimuth + aside).sin(), cosine * (azimuth + aside).cos(), sine);
                let nu = to.dot(sun.direction).clamp(-1.0, 1.0);
                let ray = Ray { altitude_m, mu: sine, mu_s: sun.direction.z, nu };
                let four = self.atmosphere.march(&ray, DARK_STEPS).radiance_per_sr;
                let rgb = self.atmosphere.rec709(std::array::from_fn(|k| four[k] * sun.irradiance[k]));
                darkest = darkest.min(rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722)));
            }
        }
        Ok(if darkest.is_finite() { (0.5 * darkest).max(0.0) } else { 0.0 })
    }

    /// What the renderer needs for a frame.
    pub fn frame(&self) -> Result<FrameState> {
        let moon = self.moon()?;
        let moonlight = moon.as_ref().map(|moon| self.moon_as_light(moon)).transpose()?.flatten();
        let (instant, place) = self.standing()?;
        let observer = himmel_astro::Observer::new(self.ephemeris.as_ref(), &instant, &place)?;
        let moving = Moving::of(&self.scene, &self.preset, &self.atmosphere.starlight(), &self.points, &observer)?;
        let far_bodies = self.far_bodies()?;
        let named = self.scene.names.enabled.then(|| self.named(moon.as_ref(), &moving, &far_bodies)).transpose()?;
        Ok(FrameState {
            sun: self.sun_state()?,
            other_suns: moonlight.into_iter().collect(),
            occluder: self.occluder()?,
            shadow: self.shadow()?,
            bending: self.bending(),
            stars: self.points.field(&self.scene, &observer, self.clock.unix_seconds(), self.darkest_sky_cd_m2()?),
            bodies: moving.points,
            planets: moving.discs,
            hiders: hiders(&observer, moon.as_ref())?,
            far_bodies,
            moon: moon.and_then(|moon| self.moon_as_disc(moon)),
            night: self.night()?,
            overlay: self.points.overlay(&self.scene, &observer, named),
            altitude_m: self.altitude_m(),
            output: self.scene.output.clone(),
            seconds: None,
        })
    }

    /// Bodies that have names, where they stand.
    fn named(&self, moon: Option<&Moon>, moving: &Moving, far_bodies: &[FarBody]) -> Result<Named> {
        let mut named = Named::default();
        if !self.scene.names.bodies {
            return Ok(named);
        }
        let sun = self.sun_state()?;
        if sun.disc {
            named.push_body(Body::Sun, sun.direction, sun.radius_rad);
        }
        if let Some(moon) = moon {
            named.push_body(Body::Moon, moon.state.direction, moon.state.radius_rad);
        }
        for (params, body) in self.scene.bodies.iter().filter(|params| params.enabled).zip(far_bodies) {
            let distance_m = body.centre_m.length();
            let radius_rad = (body.radius_m / distance_m).clamp(0.0, 1.0).asin();
            named.push(&params.name, body.centre_m / distance_m, radius_rad);
        }
        for (body, disc) in Body::PLANETS.into_iter().zip(&moving.discs) {
            named.push_body(body, disc.direction, disc.radius_rad);
        }
        if let Some((name, direction)) = &moving.comet {
            named.push(name, *direction, 0.0);
        }
        Ok(named)
    }

    /// What the sky shows in a direction (unit vector east-north-up), as linear Rec. 709 in cd m⁻²: air, ground, the
    /// Sun's disc, and the glow of the night. The f64 twin of the renderer's pixel.
    pub fn luminance(&self, direction: DVec3) -> Result<DVec3> {
        let (sun, settings) = (self.sun_state()?, &self.scene.sun);
        let direction = direction.normalize_or(DVec3::Z);
        let altitude_m = self.altitude_m().max(0.5);
        let nu = direction.dot(sun.direction).clamp(-1.0, 1.0);
        let ray = Ray { altitude_m, mu: direction.z, mu_s: sun.direction.z, nu };
        let mut four = self.atmosphere.radiance(&ray, TWIN_STEPS);
        let above = direction.z.asin().to_degrees() > self.horizon_deg();
        if settings.disc && above {
            let occluder = self.occluder()?;
            let disc = Disc {
                centre: sun.direction,
                radius_rad: sun.radius_rad,
                up: DVec3::Z,
                occluder: occluder.map(|occluder| (occluder.direction, occluder.angular_radius_rad)),
                corona: occluder.is_some(),
            };
            let light = disc.radiance_per_sr(direction, &self.bending(), &self.limb_darkening());
            let through = self.atmosphere.sun_transmittance(altitude_m, direction.z);
            for k in 0..4 {
                four[k] += through[k] * light[k];
            }
        }
        let mut sum: [f64; 4] = std::array::from_fn(|k| four[k] * sun.irradiance[k]);
        let mut add = |factor: [f64; 4], light: [f64; 4]| {
            for k in 0..4 {
                sum[k] += factor[k] * light[k];
            }
        };
        let moon = self.moon()?;
        if let Some(light) = moon.as_ref().map(|moon| self.moon_as_light(moon)).transpose()?.flatten() {
            let nu = direction.dot(light.direction).clamp(-1.0, 1.0);
            let ray = Ray { altitude_m, mu: direction.z, mu_s: light.direction.z, nu };
            add(light.irradiance, self.atmosphere.radiance(&ray, TWIN_STEPS));
        }
        let disc = moon.filter(|_| above).and_then(|moon| self.moon_as_disc(moon));
        if let Some(light) = disc.and_then(|moon| moon.radiance(direction, &self.bending())) {
            add(self.atmosphere.sun_transmittance(altitude_m, direction.z), light);
        }
        if let Some(night) = self.night()? {
            add([1.0; 4], night.parts(&self.atmosphere, altitude_m, direction, 0).sum());
        }
        Ok(self.atmosphere.rec709(sum))
    }

    /// Azimuth and altitude that `camera.look` means, degrees.
    pub fn look_deg(&self) -> Result<(f64, f64)> {
        let text = &self.scene.camera.look;
        look(text, self.scene.camera.fov_deg, &self.sun()?).or_else(|error| self.look_at_target(text, error))
    }

    /// A body's or star's apparent place, refracted where the air refracts; `error` where the name is neither.
    fn look_at_target(&self, name: &str, error: Error) -> Result<(f64, f64)> {
        if let Some(direction) = self.direction_of_body(name)? {
            let azimuth_deg = direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0);
            let apparent_rad = self.bending().apparent_rad(direction.z.clamp(-1.0, 1.0).asin());
            return Ok((azimuth_deg, apparent_rad.to_degrees()));
        }
        let Ok(target) = Target::parse(name) else {
            return Err(error);
        };
        // The Moon may have been put by hand.
        if target == Target::Body(Body::Moon)
            && let Some(moon) = self.moon()?
        {
            return Ok((moon.azimuth_deg, moon.altitude_deg));
        }
        let instant = Instant::from_unix_seconds(self.clock.unix_seconds())?;
        let place = Place::from_degrees(self.observer.latitude_deg, self.observer.longitude_deg, self.altitude_m())?;
        let seen = target.apparent(&himmel_astro::Observer::new(self.ephemeris.as_ref(), &instant, &place)?)?;
        Ok((seen.azimuth_rad.to_degrees(), self.bending().apparent_rad(seen.altitude_rad).to_degrees()))
    }

    /// The scene's camera as a view.
    pub fn view(&self) -> Result<View> {
        let camera = &self.scene.camera;
        let (azimuth_deg, altitude_deg) = self.look_deg()?;
        let (azimuth, altitude, fov) =
            (azimuth_deg.to_radians(), altitude_deg.to_radians(), camera.fov_deg.to_radians());
        let aspect = f64::from(self.scene.output.width_px) / f64::from(self.scene.output.height_px);
        let view = match camera.projection {
            ProjectionKind::Perspective if camera.fov_deg >= 179.5 => {
                return Err(Error::Camera(format!(
                    "a perspective camera sees less than 179.5°, got {}°; use --projection fisheye",
                    camera.fov_deg
                )));
            }
            ProjectionKind::Perspective => View::looking(azimuth, altitude, fov, aspect),
            ProjectionKind::Fisheye => View::with_projection(azimuth, altitude, Projection::Fisheye(fov), aspect),
            ProjectionKind::Equirect => View::with_projection(azimuth, 0.0, Projection::Equirectangular, aspect),
        };
        Ok(View { rows_px: self.scene.output.height_px, ..view })
    }

    /// The instant as the place's clock shows it.
    pub fn local_time(&self) -> String {
        self.clock.now().to_zoned_datetime(self.observer.time_zone.clone()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string()
    }

    /// The instant.
    pub fn utc(&self) -> Timestamp {
        self.clock.now()
    }
}

/// Unit vector east-north-up from azimuth and altitude in degrees.
pub fn direction_enu(azimuth_deg: f64, altitude_deg: f64) -> DVec3 {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_h, cos_h) = altitude_deg.to_radians().sin_cos();
    DVec3::new(sin_a * cos_h, cos_a * cos_h, sin_h)
}

/// The share of a disc that stands above a straight horizon; angles in degrees, from the horizon to the disc's centre.
///
/// Laws tested: 0 below, ½ on it, 1 above; rises.
pub fn visible_fraction(height_deg: f64, radius_deg: f64) -> f64 {
    if radius_deg <= 0.0 {
        return if height_deg >= 0.0 { 1.0 } else { 0.0 };
    }
    let x = (height_deg / radius_deg).clamp(-1.0, 1.0);
    // Area of a circular segment over that of the circle.
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI
}

/// Azimuth and altitude in degrees of what a person wants to look at.
fn look(text: &str, fov_deg: f64, sun: &SunPlace) -> Result<(f64, f64)> {
    let unknown = || Error::Look(himmel_core::params::shorten(text));
    match text.trim().to_lowercase().as_str() {
        "sun" => return Ok((sun.azimuth_deg, sun.altitude_deg)),
        // The horizon at the lower third of the picture.
        "sunward" => return Ok((sun.azimuth_deg, (fov_deg / 6.0).min(60.0))),
        // As star charts and maps have it: north at the top, east on the left above and on the right below.
        "zenith" => return Ok((180.0, 90.0)),
        "nadir" => return Ok((0.0, -90.0)),
        _ => {}
    }
    let mut parts = text.split(',').map(str::trim);
    let first = parts.next().unwrap_or("");
    let second = parts.next();
    if parts.next().is_some() {
        return Err(unknown());
    }
    const POINTS: [&str; 16] =
        ["n", "nne", "ne", "ene", "e", "ese", "se", "sse", "s", "ssw", "sw", "wsw", "w", "wnw", "nw", "nnw"];
    let point = POINTS.iter().position(|point| point.eq_ignore_ascii_case(first)).map(|i| i as f64 * 22.5);
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    let azimuth_deg = match (point, second) {
        (Some(azimuth_deg), _) => azimuth_deg,
        (None, Some(_)) => number(first).filter(|a| a.abs() <= 720.0).ok_or_else(unknown)?,
        (None, None) => return Err(unknown()),
    };
    let altitude_deg = match second {
        Some(text) => number(text).filter(|h| h.abs() <= 90.0).ok_or_else(unknown)?,
        None => (fov_deg / 6.0).min(60.0),
    };
    Ok((azimuth_deg.rem_euclid(360.0), altitude_deg))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUN: SunPlace = SunPlace {
        azimuth_deg: 250.0,
        altitude_deg: 10.0,
        airless_altitude_deg: 9.9,
        distance_au: 1.0,
        radius_deg: 0.27,
    };

    #[test]
    fn looks_are_understood() {
        for (text, expected) in [
            ("sun", (250.0, 10.0)),
            ("sunward", (250.0, 10.0)),
            ("180,35", (180.0, 35.0)),
            ("-90, -10.5", (270.0, -10.5)),
            ("NW", (315.0, 10.0)),
            ("sse,20", (157.5, 20.0)),
            ("zenith", (180.0, 90.0)),
        ] {
            assert_eq!(look(text, 60.0, &SUN).unwrap(), expected, "{text}");
        }
        for text in ["", "180", "180,91", "nan,3", "1,2,3", "the moon", "1e30,0"] {
            assert!(look(text, 60.0, &SUN).unwrap_err().to_string().contains("sunward"), "{text}");
        }
    }

    #[test]
    fn a_scene_that_is_set_is_the_scene_that_is_made() {
        let mut scene = Scene::default();
        scene.set("clock.time", "2012-09-06T12:00").unwrap();
        let mut model = SkyModel::new(&scene).unwrap();
        scene.set("observer.place", "Tokyo").unwrap();
        model.set_scene(&scene).unwrap();
        assert_eq!(model.utc(), SkyModel::new(&scene).unwrap().utc());
        assert_eq!(model.sun().unwrap(), SkyModel::new(&scene).unwrap().sun().unwrap());
        // From a zone with an offset to one without, too.
        scene.set("observer.place", "Accra").unwrap();
        model.set_scene(&scene).unwrap();
        assert_eq!(model.utc().to_string(), "2012-09-06T12:00:00Z");
        // A clock that runs keeps its instant wherever one goes.
        model.clock_mut().advance(60.0);
        let now = model.utc();
        scene.set("observer.place", "Paranal").unwrap();
        model.set_scene(&scene).unwrap();
        assert_eq!(model.utc(), now);
    }

    fn model(settings: &[(&str, &str)]) -> SkyModel {
        let mut scene = Scene::default();
        for (key, value) in settings {
            scene.set(key, value).unwrap();
        }
        SkyModel::new(&scene).unwrap()
    }

    /// The level surface gets what harmonics say; more orders than one; asked twice, the table is there.
    #[test]
    fn the_lights_of_a_scene_agree() {
        for altitude in ["60", "10", "-4"] {
            let model = model(&[("light.sun.altitude_deg", altitude), ("observer.altitude_m", "10")]);
            let light = model.light().unwrap();
            let up = light.ambient.irradiance_lx(DVec3::Z);
            let difference = (up - light.sky_rgb_lx()).abs().max_element();
            assert!(difference < 0.03 * light.sky_illuminance_lx, "{altitude}: {up} {}", light.sky_rgb_lx());
            assert!(light.ground_illuminance_lx > 0.0 && light.zenith_luminance_cd_m2 > 0.0);
            assert_eq!((light.sources.len(), light.eclipse_fraction), (1, 1.0));
            assert_eq!(light.sources[0].illuminance_lx, light.sun.illuminance_lx);
            assert_eq!(model.light().unwrap(), light);
        }
    }

    /// Mazatlán, 2024-04-08: totality from 18:07:25 to 18:11:45 UTC. Partial before, the day is back after.
    #[test]
    fn the_eclipse_of_2024() {
        let at = |time: &str| {
            let model =
                model(&[("observer.place", "23.2494, -106.4111"), ("observer.altitude_m", "10"), ("clock.time", time)]);
            (model.light().unwrap(), model.occluder().unwrap())
        };
        let (before, _) = at("2024-04-08T16:00Z");
        let (partial, _) = at("2024-04-08T17:30Z");
        let (total, moon) = at("2024-04-08T18:09:35Z");
        let lux = |light: &Light| light.horizontal_illuminance_lx();
        println!("{:.0} lx, partial {:.0} lx, total {:.2} lx", lux(&before), lux(&partial), lux(&total));
        println!("zenith {:.2e} cd/m²", total.zenith_luminance_cd_m2);
        assert_eq!((before.eclipse_fraction, total.eclipse_fraction), (1.0, 0.0));
        assert!((0.2..0.8).contains(&partial.eclipse_fraction), "{}", partial.eclipse_fraction);
        // 1 to 20 lx are measured in totalities.
        assert!((0.2..40.0).contains(&lux(&total)), "{}", lux(&total));
        let moon = moon.unwrap();
        assert!((moon.angular_radius_rad.to_degrees() * 60.0 - 16.6).abs() < 0.4);
        assert!((moon.distance_m / 3.54e8 - 1.0).abs() < 0.02);
        let (after, none) = at("2024-04-10T18:00Z");
        assert!(none.is_none() && after.eclipse_fraction == 1.0);
    }

    #[test]
    fn a_setting_sun_fades() {
        assert_eq!(visible_fraction(0.3, 0.27), 1.0);
        assert_eq!(visible_fraction(-0.3, 0.27), 0.0);
        assert!((visible_fraction(0.0, 0.27) - 0.5).abs() < 1e-15);
        assert!(visible_fraction(0.1, 0.27) > visible_fraction(0.05, 0.27));
    }
}
