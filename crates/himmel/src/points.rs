//! What of a frame is points of light: the catalogue, and where observer and hiding discs stand.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use himmel_air::{Preset, Starlight};
use himmel_astro::earth::ecliptic_j2000_from_gcrs;
use himmel_astro::orbits::OrbitalElements;
use himmel_astro::physical::{illuminance_lx, pole_icrs};
use himmel_astro::satellites::Satellite;
use himmel_astro::stars::{StarFrame, constellations};
use himmel_astro::{Body, Catalogue, Observer, Star};
use himmel_core::constants::ASTRONOMICAL_UNIT_M;
use himmel_gpu::{
    Hider, LabelList, LineKind, LineList, MOST_BODIES, Names, Overlay, OverlayParams, PlanetDisc, PointBody,
    PointSpread, StarField, StarList, StarPoint,
};

use crate::error::Result;
use crate::moon::Moon;
use crate::names::{Named, Source};
use crate::scene::Scene;

/// What a list was made of.
type Made = (String, PathBuf, PointSpread);

/// What is read once: made when it is first needed and when its source changes.
#[derive(Default)]
pub(crate) struct PointCache {
    list: Mutex<Option<(Made, Arc<StarList>)>>,
    satellites: Mutex<Option<(PathBuf, Arc<Vec<Satellite>>)>>,
    lines: Mutex<Option<(OverlayParams, Arc<LineList>)>>,
    names: Mutex<Option<(Source, Option<Arc<LabelList>>)>>,
    /// Of whom was warned already.
    warned: Mutex<HashSet<String>>,
}

impl PointCache {
    /// Says once that something stands aside.
    fn warn(&self, what: &str, name: &str, reason: &dyn std::fmt::Display) {
        if self.warned.lock().unwrap_or_else(PoisonError::into_inner).insert(format!("{what} {name}")) {
            tracing::warn!(name, %reason, "a {what} stands aside");
        }
    }

    /// Lines and names of a frame; `None` where none are on.
    pub(crate) fn overlay(&self, scene: &Scene, observer: &Observer<'_>, named: Option<Named>) -> Option<Overlay> {
        let params = &scene.overlay;
        if !(params.any() || named.is_some()) {
            return None;
        }
        let frame = StarFrame::new(observer);
        Some(Overlay {
            lines: self.lines(params),
            names: named.and_then(|named| self.names(scene, named, &frame)),
            params: params.clone(),
            enu_from_icrs: frame.enu_from_icrs,
        })
    }

    fn lines(&self, params: &OverlayParams) -> Arc<LineList> {
        let mut cached = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((of, lines)) if of == params => Arc::clone(lines),
            _ => {
                let lines = Arc::new(self.lines_of(params));
                *cached = Some((params.clone(), Arc::clone(&lines)));
                lines
            }
        }
    }

    /// `None` where the font cannot be used.
    fn names(&self, scene: &Scene, named: Named, frame: &StarFrame) -> Option<Names> {
        let source = Source::of(scene, &named);
        let mut cached = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        let list = match cached.as_ref() {
            Some((of, list)) if *of == source => list.clone(),
            _ => {
                let list = source.list(&|what, name, reason| self.warn(what, name, reason)).map(Arc::new);
                *cached = Some((source, list.clone()));
                list
            }
        };
        Some(Names {
            list: list?,
            params: scene.names.clone(),
            bodies: named.bodies,
            years_since_j2000: frame.years_since_j2000,
            beta: frame.beta,
            observer_au: frame.observer_au,
            limiting_magnitude: scene.stars.limiting_magnitude,
        })
    }

    fn lines_of(&self, params: &OverlayParams) -> LineList {
        let mut lines = LineList::default();
        if params.constellations || params.borders {
            let at = |&(ra, dec): &(f64, f64)| DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
            let mut draw = |chains: &[Vec<(f64, f64)>], closed: bool, kind: LineKind| {
                for chain in chains {
                    let ends = chain.iter().zip(chain.iter().skip(1));
                    let last = chain.last().zip(chain.first()).filter(|_| closed);
                    for (from, to) in ends.chain(last) {
                        LineList::arc(&mut lines.fixed, at(from), at(to), kind);
                    }
                }
            };
            match constellations::parse(constellations::EMBEDDED) {
                Ok(all) => {
                    for constellation in &all {
                        if params.constellations {
                            draw(&constellation.lines, false, LineKind::Figure);
                        }
                        if params.borders {
                            draw(&constellation.boundaries, true, LineKind::Border);
                        }
                    }
                }
                Err(error) => self.warn("overlay", "constellations", &error),
            }
        }
        if params.equatorial_grid {
            LineList::grid(&mut lines.fixed, 24, 10, LineKind::Equatorial);
        }
        if params.ecliptic {
            let pole = ecliptic_j2000_from_gcrs().transpose() * DVec3::Z;
            LineList::circle(&mut lines.fixed, pole, LineKind::Ecliptic);
        }
        if params.horizontal_grid {
            LineList::grid(&mut lines.local, 36, 10, LineKind::Horizontal);
        }
        lines
    }

    /// The satellites of the file that the scene names; broken ones are named and left out.
    fn satellites(&self, scene: &Scene) -> Arc<Vec<Satellite>> {
        let path = scene.folder.join(&scene.planets.satellites);
        let mut cached = self.satellites.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((of, satellites)) if *of == path => Arc::clone(satellites),
            _ => {
                let satellites = Arc::new(match std::fs::read_to_string(&path) {
                    Ok(text) => self.read_satellites(&text),
                    Err(error) => {
                        self.warn("file of satellites", &path.display().to_string(), &error);
                        Vec::new()
                    }
                });
                *cached = Some((path, Arc::clone(&satellites)));
                satellites
            }
        }
    }

    fn read_satellites(&self, text: &str) -> Vec<Satellite> {
        let lines: Vec<&str> = text.lines().map(str::trim_end).filter(|line| !line.is_empty()).collect();
        let mut satellites = Vec::new();
        for (at, pair) in lines.windows(2).enumerate() {
            if !(pair[0].starts_with("1 ") && pair[1].starts_with("2 ")) {
                continue;
            }
            let name = (at > 0).then(|| lines[at - 1]).filter(|line| !line.starts_with("2 ")).unwrap_or("");
            match Satellite::parse(&format!("{name}\n{}\n{}", pair[0], pair[1])) {
                Ok(satellite) => satellites.push(satellite),
                Err(error) => self.warn("satellite", if name.is_empty() { pair[0] } else { name }, &error),
            }
        }
        satellites
    }

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
    pub(crate) fn field(
        &self,
        scene: &Scene,
        observer: &Observer<'_>,
        time_s: f64,
        darkest_sky_cd_m2: f64,
    ) -> Option<StarField> {
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
                darkest_sky_cd_m2,
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
pub(crate) fn hiders(observer: &Observer<'_>, moon: Option<&Moon>) -> Result<Vec<Hider>> {
    let sun = observer.apparent(Body::Sun)?;
    let sun = Hider { direction: sun.direction_enu, radius_rad: sun.semidiameter_rad() };
    let moon = moon.map(|moon| Hider { direction: moon.state.direction, radius_rad: moon.state.radius_rad });
    Ok([sun].into_iter().chain(moon).collect())
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
    /// Name and direction of a comet.
    pub(crate) comet: Option<(String, DVec3)>,
}

impl Moving {
    /// As the Earth sees it; elsewhere (presets with a distance of their own) nothing is known of the sky's planets.
    pub(crate) fn of(
        scene: &Scene,
        preset: &Preset,
        starlight: &Starlight,
        cache: &PointCache,
        observer: &Observer<'_>,
    ) -> Result<Self> {
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
        if !scene.planets.comet.is_empty() {
            moving.comet(scene, starlight, cache, observer);
        }
        if !scene.planets.satellites.is_empty() {
            moving.satellites(scene, starlight, cache, observer);
        }
        Ok(moving)
    }

    fn point(&mut self, direction: DVec3, irradiance: [f64; 4], scintillation: f64) {
        self.points.push(PointBody { direction, irradiance, scintillation, width_rad: 0.0 });
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

    /// Those above the horizon, brightest first as far as there is room.
    ///
    /// m = m₁₀₀₀ + 5 lg(d / 1000 km) − 2.5 lg(sin β + (π − β) cos β) − 2.5 lg(sunlit part): a Lambert sphere, m₁₀₀₀ half lit
    /// [russell1916].
    fn satellites(&mut self, scene: &Scene, starlight: &Starlight, cache: &PointCache, observer: &Observer<'_>) {
        let mut seen: Vec<(f64, DVec3)> = Vec::new();
        let turn = observer.place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        let sun = (observer.sun.position_m - observer.state.position_m).normalize_or(DVec3::Z);
        for satellite in cache.satellites(scene).iter() {
            let view = match observer.satellite(satellite) {
                Ok(view) => view,
                Err(error) => {
                    let number = satellite.norad_id().to_string();
                    let name = if satellite.name().is_empty() { &number } else { satellite.name() };
                    cache.warn("satellite", name, &error);
                    continue;
                }
            };
            let direction = turn * view.seen.vector_m.normalize_or(DVec3::Z);
            let beta = std::f64::consts::PI - view.seen.vector_m.normalize_or(DVec3::Z).angle_between(sun);
            let phase = (beta.sin() + (std::f64::consts::PI - beta) * beta.cos()) * view.sunlit;
            if direction.z < 0.0 || phase <= 1e-6 {
                continue;
            }
            let magnitude =
                scene.planets.satellite_magnitude + 5.0 * (view.seen.distance_m / 1e6).log10() - 2.5 * phase.log10();
            seen.push((magnitude, direction));
        }
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        let room = MOST_BODIES.saturating_sub(self.points.len());
        for (magnitude, direction) in seen.into_iter().take(room) {
            self.point(direction, starlight.of_black_body(0.0, illuminance_lx(magnitude)), 1.0);
        }
    }

    /// Coma and tail as wide points: the coma 200,000 km across with 7 tenths of the light, the tail straight away from the
    /// Sun, fainter and wider along its way.
    fn comet(&mut self, scene: &Scene, starlight: &Starlight, cache: &PointCache, observer: &Observer<'_>) {
        let answer = OrbitalElements::parse(&scene.planets.comet)
            .and_then(|elements| Ok((elements.name.clone(), observer.apparent_orbit(&elements)?)));
        let (name, (seen, magnitude)) = match answer {
            Ok(answer) => answer,
            Err(error) => return cache.warn("comet", &scene.planets.comet, &error),
        };
        let Some(magnitude) = magnitude.filter(|magnitude| magnitude.is_finite()) else {
            return cache.warn("comet", &name, &"its elements say nothing of its brightness: add m1 and k1");
        };
        let turn = observer.place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        self.comet = Some((name, turn * seen.vector_m.normalize_or(DVec3::Z)));
        let from_sun = (observer.state.position_m + seen.vector_m - observer.sun.position_m).normalize_or(DVec3::Z);
        let light = starlight.reflected(0.0, illuminance_lx(magnitude));
        let mut piece = |vector_m: DVec3, across_m: f64, share: f64| {
            let distance_m = vector_m.length().max(1.0);
            self.points.push(PointBody {
                direction: turn * (vector_m / distance_m),
                irradiance: light.map(|value| value * share),
                scintillation: 0.0,
                width_rad: across_m / distance_m,
            });
        };
        for (across_m, share) in [(2e7, 0.2), (7e7, 0.25), (2e8, 0.25)] {
            piece(seen.vector_m, across_m, share);
        }
        const PIECES: i32 = 32;
        let weight = |i: i32| (-3.0 * f64::from(i) / f64::from(PIECES)).exp();
        let all: f64 = (1..=PIECES).map(weight).sum();
        let length_m = scene.planets.comet_tail_au * ASTRONOMICAL_UNIT_M;
        for i in 1..=PIECES {
            let along = f64::from(i) / f64::from(PIECES);
            // Pieces overlap: each is at least twice their distance wide.
            let across_m = 1e8 + length_m * (0.08 * along + 2.0 / f64::from(PIECES));
            piece(seen.vector_m + from_sun * (length_m * along), across_m, 0.3 * weight(i) / all);
        }
    }
}
