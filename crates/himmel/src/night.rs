//! The night of a scene: what glows, whether anybody sees it, and the zenith part by part.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::{DMat3, DVec3};
use himmel_astro::Catalogue;
use himmel_gpu::NightGlow;
use himmel_gpu::phenomena::night_glow::{NightParts, StarMap, mag_arcsec2_of_cd_m2, zodiacal};
use image::{DynamicImage, ImageError, ImageFormat};

use crate::error::Result;
use crate::model::{SkyModel, direction_enu};

/// By day with the Sun above this airless altitude nothing is drawn, degrees: the zenith has some 60 cd m⁻² then, and the night at
/// its brightest (an inner city) 0.01.
const DAY_ABOVE_DEG: f64 = -3.0;
/// Air that takes less than this from the zenith (at the second wavelength) makes no day.
const THIN: f64 = 0.01;
/// From this share of the air's top on, and from 60 km on, the sky is black by day.
const SPACE_FROM: (f64, f64) = (0.6, 60e3);

#[cfg(feature = "milky-way")]
static BUILT_IN: &[u8] = include_bytes!("../../../assets/sky/milky_way/milky_way.jpg");
#[cfg(not(feature = "milky-way"))]
static BUILT_IN: &[u8] = &[];

/// What frames share: made when first needed.
#[derive(Debug, Default)]
pub(crate) struct NightCache {
    table: Mutex<Option<Table>>,
    /// The last map that was asked for by its file, `None` where it could not be read.
    map: Mutex<Option<(PathBuf, Option<Arc<StarMap>>)>>,
}

/// Zodiacal light at four wavelengths.
type Table = ([f64; 4], Arc<Vec<[f64; 4]>>);

impl NightCache {
    fn table(&self, wavelengths_nm: [f64; 4]) -> Arc<Vec<[f64; 4]>> {
        let mut cached = self.table.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((at, table)) if *at == wavelengths_nm => Arc::clone(table),
            _ => {
                let table = Arc::new(zodiacal::four_table(wavelengths_nm));
                *cached = Some((wavelengths_nm, Arc::clone(&table)));
                table
            }
        }
    }

    /// The star map of a file, or the built-in one; `None`, and a warning once, where it is broken.
    fn star_map(&self, folder: &Path, file: &str) -> Option<Arc<StarMap>> {
        if file.is_empty() {
            static MAP: OnceLock<Option<Arc<StarMap>>> = OnceLock::new();
            let built_in =
                || read_map("milky_way.jpg", image::load_from_memory_with_format(BUILT_IN, ImageFormat::Jpeg));
            return MAP.get_or_init(built_in).clone();
        }
        let path = folder.join(file);
        let mut cached = self.map.lock().unwrap_or_else(PoisonError::into_inner);
        match cached.as_ref() {
            Some((at, map)) if *at == path => map.clone(),
            _ => {
                let map = read_map(&path.display().to_string(), image::open(&path));
                *cached = Some((path, map.clone()));
                map
            }
        }
    }
}

fn read_map(name: &str, picture: std::result::Result<DynamicImage, ImageError>) -> Option<Arc<StarMap>> {
    let map = picture.map_err(|error| error.to_string()).and_then(|picture| {
        let rgb = picture.into_rgb8();
        StarMap::from_codes(rgb.width(), rgb.height(), &rgb).map_err(|error| error.to_string())
    });
    map.map(Arc::new)
        .map_err(|error| {
            tracing::warn!(error, "the star map {name} cannot be used: the sky is drawn without the Milky Way");
        })
        .ok()
}

/// Luminance of the zenith at night, part by part, cd m⁻².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NightZenith {
    /// The upper air's own light.
    pub airglow_cd_m2: f64,
    /// Sunlight on interplanetary dust.
    pub zodiacal_cd_m2: f64,
    /// Stars that are not drawn one by one.
    pub starlight_cd_m2: f64,
    /// All three, scattered by the air.
    pub scattered_cd_m2: f64,
    /// Light of cities.
    pub pollution_cd_m2: f64,
    /// Light of the Sun (and of every other light of the scene) scattered by the air: twilight.
    pub twilight_cd_m2: f64,
    /// Mean over the sky of the stars that are drawn one by one, no air before them; not part of the sum.
    pub drawn_stars_cd_m2: f64,
}

impl NightZenith {
    /// The zenith between the drawn stars.
    pub fn sum_cd_m2(&self) -> f64 {
        self.airglow_cd_m2
            + self.zodiacal_cd_m2
            + self.starlight_cd_m2
            + self.scattered_cd_m2
            + self.pollution_cd_m2
            + self.twilight_cd_m2
    }

    /// The same as astronomers have it.
    pub fn mag_arcsec2(&self) -> f64 {
        mag_arcsec2_of_cd_m2(self.sum_cd_m2())
    }
}

impl SkyModel {
    /// What glows at night; `None` where nothing does, and by day, when nobody could see it. The first night reads the star map (some tenths of a second).
    pub fn night(&self) -> Result<Option<NightGlow>> {
        let (sun, scene) = (self.sun()?, self.scene());
        let (air, altitude_m) = (self.atmosphere(), self.altitude_m());
        let above = altitude_m > SPACE_FROM.1.min(SPACE_FROM.0 * air.medium().top_altitude_m);
        let thin = air.extended_transmittance(altitude_m.min(air.medium().top_altitude_m), 1.0)[1] > 1.0 - THIN;
        if scene.night.is_dark() {
            return Ok(None);
        }
        if !above && !thin && sun.airless_altitude_deg > DAY_ABOVE_DEG && scene.sun.brightness > 1e-6 {
            return Ok(None);
        }
        let (instant, place) = self.standing()?;
        let observer = himmel_astro::Observer::new(self.ephemeris(), &instant, &place)?;
        let enu_from_icrs = observer.place.enu_from_ecef() * observer.orientation.ecef_from_gcrs;
        let pole = enu_from_icrs * observer.orientation.ecliptic_of_date_from_gcrs().transpose().z_axis;
        // A Sun that was set by hand takes its dust along.
        let to_sun = direction_enu(sun.azimuth_deg, sun.airless_altitude_deg);
        let across = pole.cross(to_sun).normalize_or(to_sun.any_orthonormal_vector());
        let ecliptic_from_enu = DMat3::from_cols(to_sun, across, to_sun.cross(across)).transpose();
        let file = &scene.night.milky_way.file;
        let map = scene.night.milky_way.enabled.then(|| self.night_cache().star_map(&scene.folder, file)).flatten();
        let table = self.night_cache().table(air.wavelengths_nm());
        let axes = [enu_from_icrs.transpose(), ecliptic_from_enu];
        let site_m = self.observer().height_m.max(0.0);
        Ok(Some(NightGlow::new(air, &scene.night, map, table, axes, [altitude_m, site_m])))
    }

    /// The zenith of a night part by part; `twilight_cd_m2`: what Sun and Moon add by the air.
    pub(crate) fn night_zenith(&self, night: &NightGlow, twilight_cd_m2: f64) -> NightZenith {
        let air = self.atmosphere();
        // Over some degrees: the map's single stars are not the zenith's.
        const LEVEL: usize = 6;
        let NightParts { airglow, zodiacal, starlight, scattered, pollution } =
            night.parts(air, self.altitude_m(), DVec3::Z, LEVEL);
        let luminance = |four: [f64; 4]| air.xyz(four).y.max(0.0);
        let drawn: f64 = Catalogue::embedded().stars().iter().map(|star| star.illuminance_lx()).sum();
        NightZenith {
            airglow_cd_m2: luminance(airglow),
            zodiacal_cd_m2: luminance(zodiacal),
            starlight_cd_m2: luminance(starlight),
            scattered_cd_m2: luminance(scattered),
            pollution_cd_m2: luminance(pollution),
            twilight_cd_m2,
            drawn_stars_cd_m2: drawn / (4.0 * std::f64::consts::PI),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn model(settings: &[(&str, &str)]) -> SkyModel {
        let mut scene = Scene::default();
        for (key, value) in settings {
            scene.set(key, value).unwrap();
        }
        SkyModel::new(&scene).unwrap()
    }

    /// Zenith far from the Milky Way at a new Moon: V = 21.7 to 22.0 mag/arcsec² at dark sites near the Sun's minimum
    /// [leinert1998, section 6; benn1998: 21.9 on La Palma at high ecliptic latitude].
    #[test]
    fn the_zenith_of_a_dark_site() {
        for (place, time) in [
            ("Potsdam", "2012-04-20T23:30Z"),
            ("28.7606,-17.8814,2396", "2012-04-21T01:00Z"),
            ("-24.6272,-70.4042,2635", "2012-10-15T04:00Z"),
        ] {
            let light = model(&[("observer.place", place), ("clock.time", time)]).light().unwrap();
            let night = light.night.unwrap();
            println!("{place}: {:.2} mag/arcsec², {night:?}", night.mag_arcsec2());
            assert!((21.7..22.0).contains(&night.mag_arcsec2()), "{place}: {}", night.mag_arcsec2());
            // Most of it is airglow, then zodiacal light, then stars.
            let share = |part: f64| part / night.sum_cd_m2();
            assert!(share(night.airglow_cd_m2) > 0.45 && share(night.zodiacal_cd_m2) > 0.15);
            assert!(night.zodiacal_cd_m2 > night.starlight_cd_m2 && night.twilight_cd_m2 < 1e-7);
            assert_eq!(light.zenith_luminance_cd_m2, night.sum_cd_m2());
            // Level ground has 0.5 to 1 mlx of it.
            assert!((4e-4..1.5e-3).contains(&light.sky_illuminance_lx), "{}", light.sky_illuminance_lx);
            let up = light.ambient.irradiance_lx(DVec3::Z);
            assert!((up - light.sky_rgb_lx()).abs().max_element() < 0.02 * light.sky_illuminance_lx);
        }
    }

    #[test]
    fn each_part_can_be_switched_off_and_cities_switched_on() {
        let night = [("observer.place", "Potsdam"), ("clock.time", "2012-04-20T23:30Z")];
        let off =
            [("night.airglow.enabled", "off"), ("night.zodiacal.enabled", "off"), ("night.milky_way.enabled", "off")];
        let light = model(&[&night[..], &off].concat()).light().unwrap();
        assert!(light.night.is_none() && light.zenith_luminance_cd_m2 < 1e-7);
        let city = ("night.light_pollution.zenith_mcd_m2", "2.5");
        let zenith = model(&[&night[..], &off, &[city]].concat()).light().unwrap().night.unwrap();
        // Eyes are 2 m above the ground, and most aerosols below a kilometre.
        assert!((zenith.sum_cd_m2() / 2.5e-3 - 1.0).abs() < 5e-3);
        // On a mountain it is what was asked for, too; from an aircraft it is less.
        let mountain = [("observer.place", "Paranal"), ("clock.time", "2012-10-15T04:00Z"), city];
        let at = |settings: &[(&str, &str)]| model(settings).light().unwrap().night.unwrap().pollution_cd_m2;
        assert!((at(&mountain) / 2.5e-3 - 1.0).abs() < 5e-3);
        assert!(at(&[&mountain[..], &[("observer.altitude_m", "10000")]].concat()) < 1e-3);
    }

    /// A missing file, one that is no picture, a picture that is no map: the Milky Way stands aside, the rest is there.
    #[test]
    fn a_broken_map_stands_aside() {
        let folder = tempfile::tempdir().unwrap();
        let (text, square) = (folder.path().join("text.jpg"), folder.path().join("square.png"));
        std::fs::write(&text, "no picture").unwrap();
        image::RgbImage::new(16, 16).save(&square).unwrap();
        for file in [folder.path().join("missing.jpg"), text, square] {
            let file = file.display().to_string();
            let model = model(&[("clock.time", "2012-04-20T23:30Z"), ("night.milky_way.file", &file)]);
            let night = model.night().unwrap().unwrap();
            assert!(night.star_map.is_none(), "{file}");
            let zenith = model.light().unwrap().night.unwrap();
            assert!(zenith.starlight_cd_m2 == 0.0 && zenith.airglow_cd_m2 > 0.0);
        }
    }

    /// The map's centre is where the Galaxy's is, and both Clouds are there.
    #[test]
    fn the_map_lies_right() {
        let map = NightCache::default().star_map(Path::new(""), "").unwrap();
        let at = |ra_deg: f64, dec_deg: f64| {
            let (ra, dec) = (ra_deg.to_radians(), dec_deg.to_radians());
            let direction = DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
            map.sample_s10(direction, 4).dot(DVec3::new(0.2126, 0.7152, 0.0722))
        };
        let (baade, clouds, beside) = (at(270.9, -30.0), [at(80.0, -69.0), at(13.2, -72.8)], at(60.0, -62.0));
        println!("Baade's window {baade:.0}, clouds {clouds:.0?}, beside {beside:.0}, pole {:.0} S10", at(192.9, 27.1));
        assert!(baade > 350.0 && clouds[0] > 3.0 * beside && clouds[1] > 2.0 * beside);
        assert!((15.0..35.0).contains(&at(192.9, 27.1)));
        // Coal Sack against its surroundings.
        println!("Coal Sack {:.0}, Carina {:.0}", at(187.8, -63.7), at(161.0, -59.7));
        assert!(at(187.8, -63.7) < 0.7 * at(161.0, -59.7));
    }
}
