//! The night of a scene: what glows, whether anybody sees it, and the zenith part by part.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::{DMat3, DVec3};
use himmel_astro::{Catalogue, Instant, Place};
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
        let instant = Instant::from_unix_seconds(self.clock().unix_seconds())?;
        let place = Place::from_degrees(self.observer().latitude_deg, self.observer().longitude_deg, altitude_m)?;
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
        Ok(Some(NightGlow::new(air, &scene.night, map, table, axes, altitude_m)))
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
