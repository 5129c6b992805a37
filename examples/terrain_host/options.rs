//! The command line.

use std::path::PathBuf;

use himmel::DepthDirection;

use crate::Result;

pub const USAGE: &str = "terrain_host [--planet earth|mars] [--place LAT,LON] [--altitude METRES above ground] [--time ISO | --sun AZ,ALT]
             [--look AZ,ALT] [--fov DEG] [--size WxH] [--map FILE.toml] [--shafts] [--standard-depth] [--orthographic] [-o FILE.png]";

/// What a planet looks like where nothing else is said.
pub struct Planet {
    pub name: &'static str,
    /// Its maps in `assets/terrain`, the coarsest first.
    pub maps: &'static [&'static str],
    /// Latitude and longitude, degrees, seen from the ground and from space.
    pub places: [[f64; 2]; 2],
    /// Azimuth to look along, degrees, likewise.
    pub azimuths_deg: [f64; 2],
    /// Albedo of its ground, linear Rec. 709, and a number each, in the order of `Scene` in `terrain.wgsl`: water, low and high
    /// ground, rock, snow. Plausible, not measured.
    pub ground: [[f32; 4]; 5],
}

/// The Bernese Alps from the Niesen; Europe from above Lyon.
const EARTH: Planet = Planet {
    name: "earth",
    maps: &["europe", "aletsch"],
    places: [[46.645, 7.651], [45.5, 4.5]],
    azimuths_deg: [118.0, 75.0],
    ground: [
        [0.02, 0.035, 0.05, 0.5],
        [0.06, 0.075, 0.035, 2000.0],
        [0.20, 0.18, 0.14, 2800.0],
        [0.17, 0.16, 0.15, 0.0],
        [0.80, 0.82, 0.85, 0.9],
    ],
};

/// Ascraeus Mons from the plain in the south-west; Olympus Mons on the horizon from space. Dust, bare rock, no water.
const MARS: Planet = Planet {
    name: "mars",
    maps: &["mars"],
    places: [[8.0, -107.0], [10.0, -118.0]],
    azimuths_deg: [40.0, 297.0],
    ground: [
        [0.0, 0.0, 0.0, -1e9],
        [0.26, 0.14, 0.075, 0.0],
        [0.26, 0.14, 0.075, 1e9],
        [0.16, 0.10, 0.07, 0.0],
        [0.26, 0.14, 0.075, 0.7],
    ],
};

pub struct Options {
    pub planet: &'static Planet,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    pub above_ground_m: f64,
    pub time: String,
    /// Azimuth and altitude, degrees, instead of the clock's.
    pub sun_deg: Option<[f64; 2]>,
    pub azimuth_deg: f64,
    /// Unset: the horizon lies above the middle.
    pub altitude_deg: Option<f64>,
    pub fov_deg: f64,
    pub size: (u32, u32),
    /// Further maps, over the planet's own.
    pub maps: Vec<PathBuf>,
    pub shafts: bool,
    pub depth: DepthDirection,
    pub orthographic: bool,
    pub file: PathBuf,
}

impl Options {
    pub fn parse(mut args: impl Iterator<Item = String>) -> Result<Self> {
        let (mut place, mut look, mut sun_deg, mut time) = (None, None, None, None);
        let mut planet = &EARTH;
        let mut above_ground_m = None;
        let mut options = Self {
            planet,
            latitude_deg: 0.0,
            longitude_deg: 0.0,
            above_ground_m: 0.0,
            time: String::new(),
            sun_deg: None,
            azimuth_deg: 0.0,
            altitude_deg: None,
            fov_deg: 30.0,
            size: (1280, 720),
            maps: Vec::new(),
            shafts: false,
            depth: DepthDirection::Reversed,
            orthographic: false,
            file: "terrain_host.png".into(),
        };
        while let Some(option) = args.next() {
            let mut value = || args.next().ok_or_else(|| format!("{option} needs a value; usage: {USAGE}"));
            match option.as_str() {
                "--planet" => {
                    planet = match value()?.as_str() {
                        "earth" => &EARTH,
                        "mars" => &MARS,
                        other => return Err(format!("--planet takes earth or mars, got {other}").into()),
                    }
                }
                "--place" => place = Some(pair(&option, &value()?, "LAT,LON", [-90.0..=90.0, -360.0..=360.0])?),
                "--altitude" => above_ground_m = Some(number(&option, &value()?, 0.0..=1e7)?),
                "--time" => time = Some(value()?),
                "--sun" => sun_deg = Some(pair(&option, &value()?, "AZ,ALT", [-360.0..=360.0, -90.0..=90.0])?),
                "--look" => look = Some(pair(&option, &value()?, "AZ,ALT", [-360.0..=360.0, -90.0..=90.0])?),
                "--fov" => options.fov_deg = number(&option, &value()?, 0.1..=150.0)?,
                "--size" => options.size = size(&value()?)?,
                "--map" => options.maps.push(value()?.into()),
                "--shafts" => options.shafts = true,
                "--standard-depth" => options.depth = DepthDirection::Standard,
                "--orthographic" => options.orthographic = true,
                "-o" => options.file = value()?.into(),
                _ => return Err(format!("{option} is no option; usage: {USAGE}").into()),
            }
        }
        options.planet = planet;
        // Parallel rays see no more than the picture is wide: from the ground, next to nothing.
        options.above_ground_m = above_ground_m.unwrap_or(if options.orthographic { 20e3 } else { 40.0 });
        let high = usize::from(options.above_ground_m >= 10e3 && !options.orthographic);
        [options.latitude_deg, options.longitude_deg] = place.unwrap_or(planet.places[high]);
        options.azimuth_deg = look.map_or(planet.azimuths_deg[high], |look| look[0]);
        options.altitude_deg = look.map(|look| look[1]);
        if options.orthographic {
            options.altitude_deg.get_or_insert(-35.0);
        }
        options.sun_deg = sun_deg;
        // Himmel's clock is the Earth's.
        if options.sun_deg.is_none() && time.is_none() && planet.name == "mars" {
            options.sun_deg = Some([230.0, 14.0]);
        }
        // Low for shadows; from space, high enough to shine through the air.
        options.time = time.unwrap_or(["2012-09-06T16:30Z", "2012-09-06T09:00Z"][high].into());
        Ok(options)
    }
}

fn number(option: &str, text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64> {
    match text.trim().parse() {
        Ok(number) if range.contains(&number) => Ok(number),
        _ => Err(format!("{option} takes a number in {range:?}, got {text}").into()),
    }
}

fn pair(option: &str, text: &str, form: &str, ranges: [std::ops::RangeInclusive<f64>; 2]) -> Result<[f64; 2]> {
    let [first, second] = ranges;
    let (one, other) = text.split_once(',').ok_or_else(|| format!("{option} takes {form} in degrees, got {text}"))?;
    Ok([number(option, one, first)?, number(option, other, second)?])
}

fn size(text: &str) -> Result<(u32, u32)> {
    let parse = |text: &str| text.parse::<u32>().ok().filter(|pixels| (16..=4096).contains(pixels));
    let parsed = text.split_once('x').and_then(|(width, height)| Some((parse(width)?, parse(height)?)));
    parsed.ok_or_else(|| format!("--size takes WIDTHxHEIGHT, each in 16..=4096, got {text}").into())
}
