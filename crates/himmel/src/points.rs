//! What of a frame is points of light: the catalogue, and where observer and hiding discs stand.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use himmel_astro::stars::StarFrame;
use himmel_astro::{Body, Catalogue, Observer, Star};
use himmel_gpu::{Hider, PointSpread, StarField, StarList, StarPoint};

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
    let points = |catalogue: &Catalogue| StarList::new(catalogue.stars().iter().map(|star| point(star, thesis)).collect());
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
