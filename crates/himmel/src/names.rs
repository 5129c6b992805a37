//! Names over the sky: who has one, and what is written.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use himmel_astro::stars::{StarName, constellations};
use himmel_astro::{Body, Catalogue, Star};
use himmel_gpu::{Anchor, Label, LabelKind, LabelList, MOST_NAMED_BODIES, NamedBody, Typeface};

use crate::direction_enu;
use crate::scene::Scene;

/// Letters where the scene names no font of its own.
static LETTERS: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

/// What is on the horizon, clockwise from north.
const CARDINAL: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
/// Before everything: nothing in the sky is as bright.
const FIRST: f64 = -100.0;
/// Constellations and degrees stand between the stars as if they had these magnitudes: a constellation after its brightest star,
/// and none after stars of 2.5; faint stars that nobody names at 60° must not make others wait.
const CONSTELLATIONS_AT_LEAST: f64 = 2.5;
const DEGREES: f64 = 2.9;

/// Bodies of a frame that have names.
#[derive(Debug, Default)]
pub(crate) struct Named {
    pub(crate) bodies: Vec<NamedBody>,
    names: Vec<String>,
}

impl Named {
    /// The first one's name has precedence. What is too many is left out.
    pub(crate) fn push(&mut self, name: &str, direction: DVec3, radius_rad: f64) {
        if self.bodies.len() < MOST_NAMED_BODIES && !name.trim().is_empty() {
            self.bodies.push(NamedBody { direction, radius_rad });
            self.names.push(name.trim().to_owned());
        }
    }

    pub(crate) fn push_body(&mut self, body: Body, direction: DVec3, radius_rad: f64) {
        let mut name = body.name().to_owned();
        if let Some(first) = name.get_mut(..1) {
            first.make_ascii_uppercase();
        }
        self.push(&name, direction, radius_rad);
    }
}

/// What a list of names was made of.
#[derive(Debug, PartialEq)]
pub(crate) struct Source {
    switches: [bool; 7],
    font: PathBuf,
    catalogue: Option<PathBuf>,
    names: Vec<String>,
}

impl Source {
    pub(crate) fn of(scene: &Scene, named: &Named) -> Self {
        let (params, lines) = (&scene.names, &scene.overlay);
        let path = |name: &str| (!name.is_empty()).then(|| scene.folder.join(name));
        Self {
            switches: [
                params.stars && scene.stars.enabled,
                params.letters && scene.stars.enabled,
                params.constellations,
                params.bodies,
                params.cardinal_points,
                params.degrees && lines.equatorial_grid,
                params.degrees && lines.horizontal_grid,
            ],
            font: path(&params.font).unwrap_or_default(),
            catalogue: path(&scene.stars.catalogue),
            names: named.names.clone(),
        }
    }

    /// The list; `warn` says what stands aside.
    pub(crate) fn list(&self, warn: &dyn Fn(&str, &str, &dyn std::fmt::Display)) -> Option<LabelList> {
        let typeface = if self.font.as_os_str().is_empty() {
            Typeface::built_in(LETTERS).map_err(|error| error.to_string())
        } else {
            std::fs::read(&self.font)
                .map_err(|error| error.to_string())
                .and_then(|bytes| Typeface::read(bytes).map_err(|error| error.to_string()))
        };
        let typeface = match typeface {
            Ok(typeface) => typeface,
            Err(reason) => {
                warn("font", &self.font.display().to_string(), &reason);
                return None;
            }
        };
        let list = LabelList::new(Arc::new(typeface), self.labels(warn));
        let missing: String = list.missing().into_iter().take(40).collect();
        if !missing.is_empty() {
            warn("letter", &missing, &"the font has no glyph for it");
        }
        Some(list)
    }

    fn labels(&self, warn: &dyn Fn(&str, &str, &dyn std::fmt::Display)) -> Vec<Label> {
        let [stars, letters, constellations, bodies, cardinal_points, equatorial, horizontal] = self.switches;
        let mut labels = Vec::new();
        if stars || letters {
            labels.extend(self.stars(stars, letters));
        }
        if constellations {
            match constellations::parse(constellations::EMBEDDED) {
                Ok(all) => labels.extend(all.iter().filter_map(constellation)),
                Err(error) => warn("overlay", "names of constellations", &error),
            }
        }
        if bodies {
            labels.extend(self.names.iter().enumerate().map(|(index, name)| Label {
                text: name.clone(),
                kind: LabelKind::Body,
                anchor: Anchor::Body(index),
                magnitude: FIRST,
            }));
        }
        if cardinal_points {
            labels.extend(CARDINAL.iter().enumerate().map(|(eighth, name)| Label {
                text: (*name).to_owned(),
                kind: LabelKind::Cardinal,
                anchor: Anchor::Horizon(direction_enu(45.0 * eighth as f64, 0.0)),
                magnitude: FIRST + name.len() as f64,
            }));
        }
        if equatorial {
            labels.extend(equatorial_degrees());
        }
        if horizontal {
            labels.extend(horizontal_degrees(cardinal_points));
        }
        labels
    }

    /// Those of the catalogue that is drawn, by what the built-in one calls them. A file that cannot be read has no stars.
    fn stars(&self, proper: bool, letters: bool) -> Vec<Label> {
        let embedded = Catalogue::embedded();
        let own = self.catalogue.as_deref().map(read);
        let all = own.as_ref().map_or(embedded.stars(), |own| own.as_slice());
        (all.iter())
            .filter_map(|star| {
                let text = called(embedded.name(star.hip)?, proper, letters)?;
                let (place, velocity_per_year) = star.place_and_velocity();
                let place = (place + velocity_per_year * (2000.0 - star.epoch_year)).normalize();
                let anchor = Anchor::Sky { place, velocity_per_year, parallax_rad: star.parallax_rad };
                Some(Label { text, kind: LabelKind::Star, anchor, magnitude: star.v_magnitude })
            })
            .collect()
    }
}

fn read(path: &Path) -> Vec<Star> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    Catalogue::from_csv(&text).map(|(catalogue, _)| catalogue.stars().to_vec()).unwrap_or_default()
}

/// What is written beside a star: its proper name, else Bayer's letter, else Flamsteed's number.
fn called(name: &StarName, proper: bool, letters: bool) -> Option<String> {
    if !name.proper.is_empty() && proper {
        return Some(name.proper.clone());
    }
    if !letters || (!name.proper.is_empty() && proper) {
        return None;
    }
    bayer(&name.bayer).or_else(|| (!name.flamsteed.is_empty()).then(|| name.flamsteed.clone()))
}

/// `κ1` as κ¹. What is no letter with a number is left out.
fn bayer(name: &str) -> Option<String> {
    let mut rest = name.chars();
    let letter = rest.next().filter(|letter| letter.is_alphabetic())?;
    let numbers =
        rest.map(|digit| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit.to_digit(10)? as usize)).collect::<Option<String>>()?;
    Some(format!("{letter}{numbers}"))
}

fn icrs((right_ascension, declination): (f64, f64)) -> DVec3 {
    let (sin_ra, cos_ra) = right_ascension.sin_cos();
    let (sin_dec, cos_dec) = declination.sin_cos();
    DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec)
}

/// In capitals.
fn constellation(own: &constellations::Constellation) -> Option<Label> {
    let catalogue = Catalogue::embedded();
    let belongs = |star: &&Star| catalogue.name(star.hip).is_some_and(|name| name.constellation == own.id);
    // Brightest first.
    let brightest = catalogue.stars().iter().find(belongs).map_or(CONSTELLATIONS_AT_LEAST, |star| star.v_magnitude);
    (!own.name.is_empty()).then(|| Label {
        text: own.name.to_uppercase(),
        kind: LabelKind::Constellation,
        anchor: Anchor::fixed(icrs(own.label)),
        magnitude: brightest.min(CONSTELLATIONS_AT_LEAST),
    })
}

/// Hours along the equator and 60° from it, declinations every three hours.
fn equatorial_degrees() -> impl Iterator<Item = Label> {
    let label = |text: String, hour: u32, degrees: i32, order: f64| Label {
        text,
        kind: LabelKind::Equatorial,
        anchor: Anchor::fixed(icrs((f64::from(15 * hour).to_radians(), f64::from(degrees).to_radians()))),
        magnitude: DEGREES + 0.01 * order,
    };
    let hours =
        [0, 60, -60].into_iter().flat_map(move |at| (0..24).map(move |hour| label(format!("{hour}h"), hour, at, 0.0)));
    let tens = || (-8..=8).map(|tens| 10 * tens).filter(|degrees| degrees % 60 != 0);
    let declinations = (0..24).step_by(3).flat_map(move |hour| {
        tens().map(move |degrees| label(format!("{degrees:+}°").replace('-', "−"), hour, degrees, 1.0))
    });
    hours.chain(declinations)
}

/// Azimuths along the horizon, altitudes every 30°. `cardinal`: whether the cardinal points have letters already.
fn horizontal_degrees(cardinal: bool) -> impl Iterator<Item = Label> {
    let label = |text: String, azimuth: i32, altitude: i32, order: f64| Label {
        text,
        kind: LabelKind::Horizontal,
        anchor: Anchor::Seen(direction_enu(f64::from(azimuth), f64::from(altitude))),
        magnitude: DEGREES + 0.01 * order,
    };
    let azimuths = (0..36)
        .map(|tens| 10 * tens)
        .filter(move |azimuth| !(cardinal && azimuth % 90 == 0))
        .map(move |azimuth| label(format!("{azimuth}°"), azimuth, 0, 0.0));
    let altitudes = (0..12).flat_map(move |third| {
        (-8..=8)
            .filter(|tens| *tens != 0)
            .map(move |tens| label(format!("{}°", 10 * tens).replace('-', "−"), 30 * third, 10 * tens, 1.0))
    });
    azimuths.chain(altitudes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(scene: &Scene) -> Source {
        let mut named = Named::default();
        for body in [Body::Sun, Body::Moon].into_iter().chain(Body::PLANETS) {
            named.push_body(body, DVec3::Z, 0.0);
        }
        Source::of(scene, &named)
    }

    fn everything() -> Scene {
        let mut scene = Scene::default();
        for key in ["overlay.names.enabled", "overlay.equatorial_grid", "overlay.horizontal_grid"] {
            scene.set(key, "on").unwrap();
        }
        scene
    }

    /// Every glyph that the catalogue, the constellations, the bodies and the grids need is in the built-in font.
    #[test]
    fn the_built_in_font_has_every_letter_of_the_sky() {
        let quiet = |what: &str, name: &str, _: &dyn std::fmt::Display| panic!("{what} {name}");
        for letters_only in [false, true] {
            let mut scene = everything();
            scene.names.stars = !letters_only;
            let list = source(&scene).list(&quiet).unwrap();
            assert!(list.missing().is_empty());
            let count = |kind| list.labels().filter(|label| label.kind == kind).count();
            assert!(count(LabelKind::Star) > 3000, "{}", count(LabelKind::Star));
            assert_eq!(count(LabelKind::Body), 9);
            assert_eq!(count(LabelKind::Cardinal), 8);
            assert!((88..=90).contains(&count(LabelKind::Constellation)));
        }
    }

    #[test]
    fn a_star_is_called_by_its_name_else_by_its_letter() {
        let name = |hip| Catalogue::embedded().name(hip).unwrap();
        assert_eq!(called(name(32_349), true, true).as_deref(), Some("Sirius"));
        assert_eq!(called(name(32_349), false, true).as_deref(), Some("α"));
        assert_eq!(called(name(32_349), false, false), None);
        assert_eq!(called(name(761), true, true).as_deref(), Some("κ¹"));
        assert_eq!(called(name(154), true, true).as_deref(), Some("30"));
        assert_eq!(called(name(154), true, false), None);
        assert_eq!(bayer("undefined3"), None);
        assert_eq!(bayer(""), None);
    }

    #[test]
    fn a_font_that_cannot_be_used_is_named_once_and_names_stand_aside() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("broken.ttf"), b"\0\x01\0\0 and no font").unwrap();
        for (file, reason) in [("missing.ttf", "No such file"), ("broken.ttf", "TrueType")] {
            let mut scene = everything();
            scene.folder = folder.path().into();
            scene.names.font = file.into();
            let said = std::cell::RefCell::new(Vec::new());
            let warn = |what: &str, name: &str, why: &dyn std::fmt::Display| {
                said.borrow_mut().push(format!("{what} {name}: {why}"));
            };
            assert!(source(&scene).list(&warn).is_none());
            let said = said.into_inner();
            assert!(said.len() == 1 && said[0].contains(file) && said[0].contains(reason), "{said:?}");
        }
    }
}
