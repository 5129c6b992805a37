//! What of a frame is points of light: the catalogue, and where observer and hiding discs stand.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use himmel_air::{Preset, Starlight};
use himmel_astro::physical::{illuminance_lx, pole_icrs};
use himmel_astro::stars::StarFrame;
use himmel_astro::{Body, Catalogue, Observer, Star};
use himmel_gpu::{Hider, PlanetDisc, PointBody, PointSpread, StarField, StarList, StarPoint};

use crate::error::Result;
use crate::scene::Scene;

/// What a list was made of.
type Made = (String, PathBuf, PointSpread);

/// The star list in hand, made when it is first needed and when its source changes.
#[derive(Default)]
pub(crate) struct StarCache {
    list: Mutex<Option<(Made, Arc<StarList>)>>,
}

impl StarCache {
    fn get(&self, scene: &Scene) -> Arc<StarList> {
        let made = (scene.stars.catalogue.clone(), scene.folder.clone(), scene.stars.psf);
        let mut cached = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((of, list)) if *of == made => Arc::clone(list),
            _ => {
                let list = Arc::new(star_list(scene));
                *cached = Some((made, Arc::clone(&list)));
                list
            }
        }
    }

    /// The stars of a frame; `None` where they are off.
    pub(crate) fn field(&self, scene: &Scene, observer: &Observer<'_>, time_s: f64) -> Option<StarField> {
        scene.stars.enabled.then(|| {
            let frame = StarFrame::new(observer);
            StarField {
                list: self.get(scene),
                params: scene.stars.clone(),
                years_since_j2000: frame.years_since_j2000,
                beta: frame.beta,
                observer_au: frame.observer_au,
                enu_from_icrs: frame.enu_from_icrs,
                time_s,
            }
        })
    }
}

/// Reads the catalogue that the scene names. One that is missing or broken is a warning and no stars: the sky goes on.
fn star_list(scene: &Scene) -> StarList {
    let thesis = scene.stars.psf == PointSpread::Thesis;
    let points =
        |catalogue: &Catalogue| StarList::new(catalogue.stars().iter().map(|star| point(star, thesis)).collect());
    if scene.stars.catalogue.is_empty() {
        return points(Catalogue::embedded());
    }
    let path = scene.folder.join(&scene.stars.catalogue);
    let stand_aside = |reason: &dyn std::fmt::Display| {
        tracing::warn!(catalogue = %path.display(), %reason, "stars stand aside: night.stars.catalogue cannot be read");
        StarList::default()
    };
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => return stand_aside(&error),
    };
    match Catalogue::from_csv(&text) {
        Ok((catalogue, complaints)) => {
            if let Some(first) = complaints.first() {
                let count = complaints.len();
                tracing::warn!(catalogue = %path.display(), count, %first, "some stars are left out");
            }
            points(&catalogue)
        }
        Err(error) => stand_aside(&error),
    }
}

fn point(star: &Star, thesis: bool) -> StarPoint {
    let (place, velocity) = star.place_and_velocity();
    let at_2000 = place + velocity * (2000.0 - star.epoch_year);
    let temperature = if thesis { star.temperature_thesis_k() } else { star.temperature_k() };
    StarPoint {
        place: at_2000.normalize(),
        velocity_per_year: velocity,
        parallax_rad: star.parallax_rad,
        v_magnitude: star.v_magnitude,
        illuminance_lx: star.illuminance_lx(),
        // Without a colour: as the Sun.
        temperature_k: temperature.unwrap_or(0.0),
    }
}

/// Sun and Moon as they stand before the stars.
pub(crate) fn hiders(observer: &Observer<'_>) -> Result<Vec<Hider>> {
    [Body::Sun, Body::Moon]
        .into_iter()
        .map(|body| {
            let seen = observer.apparent(body)?;
            Ok(Hider { direction: seen.direction_enu, radius_rad: seen.semidiameter_rad() })
        })
        .collect()
}

/// B − V of the planets [allen1973], and of the Sun [ramirez2012].
fn colour_index(body: Body) -> f64 {
    match body {
        Body::Mercury => 0.93,
        Body::Venus => 0.82,
        Body::Mars => 1.36,
        Body::Jupiter => 0.83,
        Body::Saturn => 1.04,
        Body::Uranus => 0.56,
        Body::Neptune => 0.41,
        Body::Pluto => 0.80,
        Body::Moon => 0.92,
        Body::Sun | Body::Earth => SUN_B_MINUS_V,
    }
}
const SUN_B_MINUS_V: f64 = 0.653;

/// Polar over equatorial radius [archinal2018].
fn polar_radius(body: Body) -> f64 {
    match body {
        Body::Mars => 3376.2 / 3396.19,
        Body::Jupiter => 66_854.0 / 71_492.0,
        Body::Saturn => 54_364.0 / 60_268.0,
        Body::Uranus => 24_973.0 / 25_559.0,
        Body::Neptune => 24_341.0 / 24_764.0,
        _ => 1.0,
    }
}

/// What moves among the stars: planets, Jupiter's moons, satellites, a comet's head.
#[derive(Default)]
pub(crate) struct Moving {
    pub(crate) points: Vec<PointBody>,
    pub(crate) discs: Vec<PlanetDisc>,
}

impl Moving {
    /// As the Earth sees it; elsewhere (presets with a distance of their own) nothing is known of the sky's planets.
    pub(crate) fn of(scene: &Scene, preset: &Preset, starlight: &Starlight, observer: &Observer<'_>) -> Result<Self> {
        let mut moving = Self::default();
        if preset.sun_distance_au.is_some() || scene.sun.distance_au.is_some() || !scene.planets.enabled {
            return Ok(moving);
        }
        for body in Body::PLANETS {
            moving.planet(body, starlight, observer)?;
        }
        if scene.planets.moons {
            moving.moons_of_jupiter(starlight, observer)?;
        }
        Ok(moving)
    }

    fn point(&mut self, direction: DVec3, irradiance: [f64; 4], scintillation: f64) {
        self.points.push(PointBody { direction, irradiance, scintillation });
    }

    fn planet(&mut self, body: Body, starlight: &Starlight, observer: &Observer<'_>) -> Result<()> {
        let seen = observer.apparent(body)?;
        let look = observer.appearance(body, &seen)?;
        let irradiance = starlight.reflected(colour_index(body) - SUN_B_MINUS_V, illuminance_lx(look.magnitude));
        let turn = observer.place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        let to_sun = observer.sun.position_m - (observer.state.position_m + seen.vector_m);
        let pole = pole_icrs(body, observer.instant.tdb()).unwrap_or(DVec3::Z);
        self.discs.push(PlanetDisc {
            body: self.points.len(),
            direction: seen.direction_enu,
            radius_rad: seen.semidiameter_rad(),
            polar: polar_radius(body),
            sun: (turn * to_sun).normalize_or(DVec3::Z),
            pole: turn * pole,
            rings: body == Body::Saturn,
            irradiance,
        });
        self.point(seen.direction_enu, irradiance, 0.0);
        Ok(())
    }

    /// Those that neither Jupiter's disc nor its shadow hides.
    fn moons_of_jupiter(&mut self, starlight: &Starlight, observer: &Observer<'_>) -> Result<()> {
        let jupiter = observer.apparent(Body::Jupiter)?;
        let radius_m = Body::Jupiter.radius_m();
        let from_sun = observer.state.position_m + jupiter.vector_m - observer.sun.position_m;
        for moon in observer.galilean_moons()? {
            let aside = (moon.seen.direction_enu - jupiter.direction_enu).length();
            let behind = !moon.in_front && aside < jupiter.semidiameter_rad();
            let offset = moon.seen.vector_m - jupiter.vector_m;
            let along = offset.dot(from_sun.normalize());
            let eclipsed = along > 0.0 && (offset - along * from_sun.normalize()).length() < radius_m;
            if !behind && !eclipsed {
                // Their colours lie between those of Sun and Io: 1.17, 0.87, 0.83, 0.86 [millis1975].
                let irradiance = starlight.reflected(0.9 - SUN_B_MINUS_V, illuminance_lx(moon.magnitude));
                self.point(moon.seen.direction_enu, irradiance, 0.0);
            }
        }
        Ok(())
    }
}
