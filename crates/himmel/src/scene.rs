//! A scene: everything that decides a picture, as a versioned TOML file. `docs/scene.md` is its schema.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use himmel_air::{AirParams, GroundParams, Preset, SunParams};
use himmel_core::params::{ParamError, ParamInfo, Params, Value, nearest, shorten};
use himmel_core::{choices, params};
use himmel_gpu::phenomena::moon::MoonParams;
use himmel_gpu::phenomena::night_glow::NightSettings;
use himmel_gpu::{MOST_FAR_BODIES, NamesParams, OutputParams, OverlayParams, PlanetsParams, StarsParams};
use toml::de::{DeTable, DeValue};

use crate::bodies::BodyParams;
use crate::error::{Error, Result};

/// The version that this library writes. Older ones are read; so far there is none.
pub const VERSION: i64 = 1;

/// First and last line of a scene that this library wrote: half of one is no scene, though it may be valid TOML.
const SAVED_MARK: &str = "# Saved by Himmel. The file is whole if it ends with the line: # end";
const END_MARK: &str = "# end";

params! {
    /// Where you stand.
    pub struct ObserverParams: "observer" {
        /// A city or site, or lat,lon[,height_m] in degrees and metres.
        place: String = "Potsdam".to_string();
        /// Height of the camera above the sea; unset: the place's height and 2 m for your eyes.
        altitude_m: Option<f64> = None, "m", 0.0..=1e9;
    }
}

params! {
    /// When it is.
    pub struct ClockParams: "clock" {
        /// ISO 8601 with Z or an offset, bare and local to the place, or now.
        time: String = "now".to_string();
        /// Virtual seconds for each real second; negative runs backwards.
        rate: f64 = 1.0, "s/s", -1e9..=1e9;
        /// Whether the clock stands still.
        paused: bool = false;
    }
}

choices! {
    /// How directions become pixels.
    pub enum ProjectionKind {
        /// Straight lines stay straight.
        Perspective = "perspective",
        /// Equidistant all-sky lens.
        Fisheye = "fisheye",
        /// The whole sphere, for environment maps.
        Equirect = "equirect",
    }
}

params! {
    /// The camera.
    pub struct CameraParams: "camera" {
        /// AZIMUTH,ALTITUDE in degrees, sun, sunward (the Sun's azimuth, horizon in the lower third), zenith, nadir, a body or star such as moon or Vega, or a compass point such as NW or NW,20.
        look: String = "sunward".to_string();
        /// Vertical field of view; perspective below 180, fisheye up to 360.
        fov_deg: f64 = 60.0, "°", 0.001..=360.0;
        /// How directions become pixels.
        projection: ProjectionKind = ProjectionKind::Perspective;
    }
}

/// Everything that decides a picture.
///
/// ```
/// let mut scene = himmel::Scene::from_toml(r#"
///     version = 1
///     preset = "earth"
///     [observer]
///     place = "Potsdam"
///     [clock]
///     time = "2012-09-06T18:00Z"
/// "#, "sunset.toml")?;
/// scene.set("ground.albedo", "0.3")?;
/// let again = himmel::Scene::from_toml(&scene.to_toml(), "again.toml")?;
/// assert_eq!(again, scene);
/// # Ok::<(), himmel::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name of a preset, or the path of its file (relative to the scene file).
    pub preset: String,
    /// `[observer]`
    pub observer: ObserverParams,
    /// `[clock]`
    pub clock: ClockParams,
    /// `[camera]`
    pub camera: CameraParams,
    /// `[light.sun]`
    pub sun: SunParams,
    /// `[body.moon]`
    pub moon: MoonParams,
    /// `[air]`
    pub air: AirParams,
    /// `[ground]`
    pub ground: GroundParams,
    /// `[night.stars]`
    pub stars: StarsParams,
    /// `[night.planets]`
    pub planets: PlanetsParams,
    /// `[night.airglow]`, `[night.zodiacal]`, `[night.milky_way]`, `[night.light_pollution]`
    pub night: NightSettings,
    /// `[[bodies]]`: other planets and moons in the sky; at most three that are enabled.
    pub bodies: Vec<BodyParams>,
    /// `[overlay]`
    pub overlay: OverlayParams,
    /// `[overlay.names]`
    pub names: NamesParams,
    /// `[output]`
    pub output: OutputParams,
    /// Folder that a preset's relative path starts from; not part of the file.
    pub folder: PathBuf,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            preset: "earth".into(),
            observer: ObserverParams::default(),
            clock: ClockParams::default(),
            camera: CameraParams::default(),
            sun: SunParams::default(),
            moon: MoonParams::default(),
            air: AirParams::default(),
            ground: GroundParams::default(),
            stars: StarsParams::default(),
            planets: PlanetsParams::default(),
            night: NightSettings::default(),
            bodies: Vec::new(),
            overlay: OverlayParams::default(),
            names: NamesParams::default(),
            output: OutputParams::default(),
            folder: PathBuf::new(),
        }
    }
}

impl Scene {
    /// Every table of parameters, in the order of the file.
    pub fn tables(&self) -> [&dyn Params; 16] {
        [
            &self.observer,
            &self.clock,
            &self.camera,
            &self.sun,
            &self.moon,
            &self.air,
            &self.ground,
            &self.stars,
            &self.planets,
            &self.night.airglow,
            &self.night.zodiacal,
            &self.night.milky_way,
            &self.night.light_pollution,
            &self.overlay,
            &self.names,
            &self.output,
        ]
    }

    fn tables_mut(&mut self) -> [&mut dyn Params; 16] {
        [
            &mut self.observer,
            &mut self.clock,
            &mut self.camera,
            &mut self.sun,
            &mut self.moon,
            &mut self.air,
            &mut self.ground,
            &mut self.stars,
            &mut self.planets,
            &mut self.night.airglow,
            &mut self.night.zodiacal,
            &mut self.night.milky_way,
            &mut self.night.light_pollution,
            &mut self.overlay,
            &mut self.names,
            &mut self.output,
        ]
    }

    /// The description of every parameter.
    pub fn describe() -> Vec<ParamInfo> {
        let own = Self::default().tables().iter().flat_map(|table| table.describe()).collect::<Vec<_>>();
        own.into_iter().chain(BodyParams::default().describe()).collect()
    }

    /// Sets a parameter by its full name from what a person typed: `ground.albedo`, `0.3`. `bodies.0.albedo` is the first other
    /// body's; one more than there are is a new one, and `bodies.albedo` is that of the first.
    pub fn set(&mut self, key: &str, text: &str) -> Result<()> {
        let key = key.trim();
        let unknown = || {
            let known: Vec<String> = Self::describe().iter().map(ParamInfo::key).collect();
            let suggestion = nearest(key, known.iter().map(String::as_str));
            Error::Param(ParamError::Unknown { key: shorten(key), suggestion })
        };
        let Some((table, name)) = key.rsplit_once('.') else { return Err(unknown()) };
        if let Some(number) = table.strip_prefix("bodies") {
            let index = match number.strip_prefix('.') {
                None if number.is_empty() => 0,
                number => number.and_then(|number| number.parse().ok()).ok_or_else(unknown)?,
            };
            let Some(info) = BodyParams::default().describe().into_iter().find(|info| info.name == name) else {
                return Err(unknown());
            };
            if index > self.bodies.len() || index >= MOST_FAR_BODIES {
                return Err(Error::Body {
                    body: format!("bodies.{index}"),
                    message: format!("bodies are counted from 0, one after the other, at most {MOST_FAR_BODIES}"),
                });
            }
            let mut body = self.bodies.get(index).cloned().unwrap_or_default();
            body.set(name, &info.parse(text)?)?;
            match self.bodies.get_mut(index) {
                Some(known) => *known = body,
                None => self.bodies.push(body),
            }
            return Ok(());
        }
        let Some(table) = self.tables_mut().into_iter().find(|t| t.table() == table) else { return Err(unknown()) };
        let Some(info) = table.describe().into_iter().find(|info| info.name == name) else { return Err(unknown()) };
        Ok(table.set(name, &info.parse(text)?)?)
    }

    /// Reads a scene file.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
        let file = path.display().to_string();
        let text = String::from_utf8(bytes)
            .map_err(|_| Error::Scene { file: file.clone(), message: "it is not a text file (UTF-8)".into() })?;
        let mut scene = Self::from_toml(&text, &file)?;
        scene.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Ok(scene)
    }

    /// Reads a scene's TOML; `file` stands in error messages. What the file does not say keeps its default.
    pub fn from_toml(text: &str, file: &str) -> Result<Self> {
        let line_of =
            |offset: usize| text.as_bytes()[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count() + 1;
        let error = |offset: usize, message: String| Error::Scene {
            file: file.into(),
            message: format!("line {}: {message}", line_of(offset)),
        };
        let root = DeTable::parse(text).map_err(|e| {
            let offset = e.span().map_or(0, |span| span.start);
            error(offset, e.message().lines().collect::<Vec<_>>().join(" "))
        })?;
        if text.starts_with(SAVED_MARK) && text.trim_end().lines().last() != Some(END_MARK) {
            return Err(error(
                text.len(),
                format!("the file is cut off: a whole one ends with the line \"{END_MARK}\""),
            ));
        }
        let mut scene = Self::default();
        let mut version = None;
        // Tables still to be read, with their names.
        let mut waiting = vec![(String::new(), root.get_ref())];
        while let Some((path, table)) = waiting.pop() {
            for (key, value) in table {
                let at = key.span().start;
                let full =
                    if path.is_empty() { key.get_ref().to_string() } else { format!("{path}.{}", key.get_ref()) };
                match (full.as_str(), value.get_ref()) {
                    ("version", value) => {
                        let number = value.as_integer().and_then(|i| i64::from_str_radix(i.as_str(), i.radix()).ok());
                        if number != Some(VERSION) {
                            return Err(error(at, format!("version must be {VERSION}; this program reads no other")));
                        }
                        version = number;
                    }
                    ("preset", DeValue::String(name)) => scene.preset = name.to_string(),
                    ("preset", _) => return Err(error(at, "preset takes a name or a path in quotes".into())),
                    ("bodies", DeValue::Array(list)) => {
                        scene.bodies = bodies(list.iter().map(|item| (item.span().start, item.get_ref())), &error)?;
                    }
                    ("bodies", DeValue::Table(_)) => {
                        return Err(error(at, "bodies are written [[bodies]], a table for each".into()));
                    }
                    (_, DeValue::Table(inner)) => {
                        let prefix = format!("{full}.");
                        let known = |t: &&dyn Params| t.table() == full || t.table().starts_with(&prefix);
                        if !scene.tables().iter().any(known) {
                            let suggestion = nearest(&full, scene.tables().iter().map(|t| t.table()));
                            let hint = suggestion.map_or_else(String::new, |name| format!(": did you mean [{name}]?"));
                            return Err(error(at, format!("unknown table [{}]{hint}", shorten(&full))));
                        }
                        waiting.push((full, inner));
                    }
                    (_, value) => {
                        let value = plain(value).ok_or_else(|| {
                            error(at, format!("{full} takes a number, true, false or a text in quotes"))
                        })?;
                        let table = scene.tables_mut().into_iter().find(|t| t.table() == path);
                        match table {
                            Some(table) => {
                                table.set(key.get_ref(), &value).map_err(|e| error(at, e.to_string()))?;
                            }
                            None => {
                                let known = ["version", "preset"]
                                    .into_iter()
                                    .chain(Self::default().tables().map(|t| t.table()));
                                let hint = nearest(&full, known)
                                    .map_or_else(String::new, |name| format!(": did you mean {name}?"));
                                return Err(error(at, format!("unknown key \"{}\"{hint}", shorten(&full))));
                            }
                        }
                    }
                }
            }
        }
        if version.is_none() {
            return Err(error(0, format!("version is missing: begin with `version = {VERSION}`")));
        }
        Ok(scene)
    }

    /// Writes the scene as TOML: what differs from the defaults, each with its sentence.
    pub fn to_toml(&self) -> String {
        let mut text =
            format!("{SAVED_MARK}\nversion = {VERSION}\npreset = {}\n", toml::Value::from(self.preset.as_str()));
        let own = self.tables().map(|table| (format!("[{}]", table.table()), false, table));
        let bodies = self.bodies.iter().map(|body| ("[[bodies]]".to_string(), true, body as &dyn Params));
        for (header, always, table) in own.into_iter().chain(bodies) {
            let changed = table.describe().into_iter().filter_map(|info| {
                let value = table.get(info.name)?;
                (value != info.default && value != Value::Unset).then_some((info, value))
            });
            let mut header = Some(header);
            let mut begin = |text: &mut String| {
                if let Some(header) = header.take() {
                    // Writing to a String cannot fail.
                    let _ = write!(text, "\n{header}\n");
                }
            };
            if always {
                begin(&mut text);
            }
            for (info, value) in changed {
                begin(&mut text);
                let value = match value {
                    // 1280, not 1280.0: all that fit are exact.
                    Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                        toml::Value::from(number as i64)
                    }
                    Value::Number(number) => toml::Value::from(number),
                    Value::Flag(flag) => toml::Value::from(flag),
                    Value::Text(words) => toml::Value::from(words),
                    Value::Unset => continue,
                };
                let _ = writeln!(text, "{} = {value}  # {}", info.name, info.sentence);
            }
        }
        text.push_str(END_MARK);
        text.push('\n');
        text
    }

    /// The atmosphere that it names: a preset that is compiled in, or a file.
    pub fn load_preset(&self) -> Result<Preset> {
        if !self.preset.ends_with(".toml") {
            return Ok(Preset::named(&self.preset)?);
        }
        let path = self.folder.join(&self.preset);
        let text = std::fs::read_to_string(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        Ok(Preset::from_toml(&text, &path.display().to_string())?)
    }
}

/// The tables of `[[bodies]]` with where they stand.
fn bodies<'a>(
    list: impl Iterator<Item = (usize, &'a DeValue<'a>)>,
    error: &dyn Fn(usize, String) -> Error,
) -> Result<Vec<BodyParams>> {
    let mut all = Vec::new();
    for (at, item) in list {
        let DeValue::Table(table) = item else {
            return Err(error(at, "bodies are written [[bodies]], a table for each".into()));
        };
        if all.len() == MOST_FAR_BODIES {
            return Err(error(at, format!("a scene has at most {MOST_FAR_BODIES} tables [[bodies]]")));
        }
        let mut body = BodyParams::default();
        for (key, value) in table {
            let at = key.span().start;
            let value = plain(value.get_ref()).ok_or_else(|| {
                error(at, format!("bodies.{} takes a number, true, false or a text in quotes", key.get_ref()))
            })?;
            body.set(key.get_ref(), &value).map_err(|e| error(at, e.to_string()))?;
        }
        all.push(body);
    }
    Ok(all)
}

fn plain(value: &DeValue<'_>) -> Option<Value> {
    match value {
        DeValue::String(text) => Some(Value::Text(text.to_string())),
        DeValue::Boolean(flag) => Some(Value::Flag(*flag)),
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| Value::Number(i as f64)),
        DeValue::Float(float) => float.as_str().parse().ok().map(Value::Number),
        // Times need no quotes: `time = 2012-09-06T18:00:00Z`.
        DeValue::Datetime(time) => Some(Value::Text(time.to_string())),
        DeValue::Array(_) | DeValue::Table(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_scene_round_trips() {
        let mut scene = Scene::default();
        for (key, value) in [
            ("observer.place", "-24.6272,-70.4042,2635"),
            ("clock.time", "2012-09-06T18:00Z"),
            ("clock.rate", "-60"),
            ("camera.look", "180,35"),
            ("camera.projection", "fisheye"),
            ("light.sun.altitude_deg", "-4"),
            ("air.aerosols", "2.5"),
            ("ground.albedo", "0.3"),
            ("output.exposure", "12.5"),
            ("output.tonemap", "neutral"),
            ("output.dither", "off"),
        ] {
            scene.set(key, value).unwrap();
        }
        let text = scene.to_toml();
        assert_eq!(Scene::from_toml(&text, "test").unwrap(), scene, "{text}");
    }

    #[test]
    fn every_parameter_round_trips_through_a_file() {
        for info in Scene::describe() {
            let mut scene = Scene::default();
            let value = match &info.kind {
                himmel_core::params::Kind::Number { range, whole } => {
                    let middle = 0.5 * (range.start().max(-1e3) + range.end().min(1e3));
                    let middle = middle.clamp(*range.start(), *range.end());
                    (if *whole { middle.round() } else { middle }).to_string()
                }
                himmel_core::params::Kind::Flag => "false".into(),
                himmel_core::params::Kind::Choice(words) => words[words.len() - 1].into(),
                himmel_core::params::Kind::Text if info.name == "exposure" => "14".into(),
                himmel_core::params::Kind::Text => "a \"quoted\" text\n".into(),
            };
            scene.set(&info.key(), &value).unwrap();
            let again = Scene::from_toml(&scene.to_toml(), "test").unwrap();
            assert_eq!(again, scene, "{}", info.key());
        }
    }

    #[test]
    fn mistakes_name_line_and_remedy() {
        for (text, parts) in [
            ("version = 1\n[air]\naerosol = 2", vec!["line 3", "did you mean air.aerosols?"]),
            ("version = 1\n[grund]\nalbedo = 0.1", vec!["line 2", "did you mean [ground]?"]),
            ("version = 1\n[ground]\nalbedo = nan", vec!["line 3", "0..=1", "NaN"]),
            ("version = 1\n[ground]\nalbedo = 1.5", vec!["ground.albedo", "1.5"]),
            ("version = 1\n[output]\ntonemap = \"filmic\"", vec!["agx", "filmic"]),
            ("version = 2", vec!["version must be 1"]),
            ("preset = \"earth\"", vec!["version is missing"]),
            ("version = 1\npreset = 3", vec!["quotes"]),
            ("version = 1\n[air", vec!["line 2"]),
            ("version = 1\nplace = \"Berlin\"", vec!["unknown key \"place\""]),
            ("version = 1\n[camera]\nlook = [1, 2]", vec!["camera.look"]),
        ] {
            let error = Scene::from_toml(text, "s.toml").unwrap_err().to_string();
            assert!(error.starts_with("s.toml: ") && !error.contains('\n'), "{error}");
            for part in parts {
                assert!(error.contains(part), "{error} lacks {part}");
            }
        }
    }

    #[test]
    fn half_a_file_is_an_error_or_a_scene_but_never_a_panic() {
        let text = "version = 1\n[observer]\nplace = \"München\"\n[air]\naerosols = 2.5\n";
        for end in (0..text.len()).filter(|&end| text.is_char_boundary(end)) {
            let _ = Scene::from_toml(&text[..end], "half");
        }
        let mut scene = Scene::default();
        scene.set("observer.place", "München").unwrap();
        scene.set("air.aerosols", "2.5").unwrap();
        let saved = scene.to_toml();
        let cuts = SAVED_MARK.len()..saved.len() - 1;
        for end in cuts.filter(|&end| saved.is_char_boundary(end)) {
            assert!(Scene::from_toml(&saved[..end], "half").is_err(), "{}", &saved[..end]);
        }
    }

    #[test]
    fn unknown_parameters_get_a_suggestion() {
        let error = Scene::default().set("air.nonsense", "1").unwrap_err().to_string();
        assert!(error.contains("unknown parameter \"air.nonsense\""), "{error}");
        let error = Scene::default().set("sun.radius_scale", "1").unwrap_err().to_string();
        assert!(error.contains("did you mean light.sun.radius_scale?"), "{error}");
    }
}
