//! The options that describe a scene; shared by every command that shows or measures one.

use std::path::PathBuf;

use himmel::Scene;

use crate::Failure;

/// Options that describe a scene. A scene file comes first, then --set, then the options with names of their own.
#[derive(clap::Args)]
pub struct SceneArgs {
    /// Scene file (TOML); options override it. See docs/scene.md.
    #[arg(long, value_name = "FILE.toml")]
    pub scene: Option<PathBuf>,
    /// Atmosphere: earth, mars, titan, venus … (`himmel info` lists them), or a .toml file.
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// City or site, or lat,lon[,height_m].
    #[arg(long, allow_hyphen_values = true)]
    pub place: Option<String>,
    /// ISO 8601 with Z or an offset, bare and local to the place, or now.
    #[arg(long, allow_hyphen_values = true)]
    pub time: Option<String>,
    /// Height of the camera above the sea, m.
    #[arg(long, value_name = "M", allow_hyphen_values = true)]
    pub altitude: Option<String>,
    /// AZIMUTH,ALTITUDE in degrees, sun, moon, jupiter, Sirius, HIP 32349, sunward, zenith, nadir, or a compass point such as NW or NW,20.
    #[arg(long, allow_hyphen_values = true)]
    pub look: Option<String>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub fov: Option<String>,
    /// perspective, fisheye, or equirect.
    #[arg(long, value_name = "NAME")]
    pub projection: Option<String>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Option<String>,
    /// EV100, auto (meter the picture), camera (output.aperture, shutter_s, iso), or none (cd/m²; the default for .exr and .hdr).
    #[arg(long, value_name = "EV", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// linear, reinhard, hejl, agx, agx-punchy, neutral, eye, or eye-blue.
    #[arg(long, value_name = "NAME")]
    pub tonemap: Option<String>,
    /// Any parameter of `himmel params`, such as air.aerosols=2; may be given several times.
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// GPU adapter whose name contains this, such as llvmpipe.
    #[arg(long, value_name = "NAME", env = "HIMMEL_ADAPTER")]
    pub adapter: Option<String>,
}

impl SceneArgs {
    /// The scene that they describe.
    pub fn scene(&self) -> Result<Scene, Failure> {
        let mut scene = match &self.scene {
            Some(path) => Scene::load(path)?,
            None => Scene::default(),
        };
        if let Some(preset) = &self.preset {
            scene.preset.clone_from(preset);
            scene.folder = PathBuf::new();
        }
        for pair in &self.set {
            let (key, value) = key_and_value(pair)?;
            scene.set(key, value)?;
        }
        for (key, value) in [
            ("observer.place", &self.place),
            ("clock.time", &self.time),
            ("observer.altitude_m", &self.altitude),
            ("camera.look", &self.look),
            ("camera.fov_deg", &self.fov),
            ("camera.projection", &self.projection),
            ("output.exposure", &self.exposure),
            ("output.tonemap", &self.tonemap),
        ] {
            if let Some(value) = value {
                scene.set(key, value)?;
            }
        }
        if let Some(size) = &self.size {
            let (width, height) = parse_size(size)?;
            scene.set("output.width_px", &width.to_string())?;
            scene.set("output.height_px", &height.to_string())?;
        }
        Ok(scene)
    }
}

/// Reads `air.aerosols=2`.
pub fn key_and_value(pair: &str) -> Result<(&str, &str), Failure> {
    pair.split_once('=').map(|(key, value)| (key.trim(), value)).ok_or_else(|| {
        let pair = himmel::params::shorten(pair);
        Failure::usage(format!("--set takes KEY=VALUE, such as air.aerosols=2; got \"{pair}\""))
    })
}

/// Reads `1280x720`.
fn parse_size(text: &str) -> Result<(u32, u32), Failure> {
    let error = |why: &str| Failure::usage(format!("--size takes WIDTHxHEIGHT in pixels, such as 1280x720; {why}"));
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(|| error(&format!("got \"{text}\"")))?;
    let side =
        |text: &str| text.trim().parse::<u32>().map_err(|_| error(&format!("\"{text}\" is no number of pixels")));
    let (width, height) = (side(width)?, side(height)?);
    if width == 0 || height == 0 {
        return Err(error(&format!("a picture needs at least one pixel, got {width}x{height}")));
    }
    if width > 65_536 || height > 65_536 || u64::from(width) * u64::from(height) > 1 << 27 {
        return Err(error(&format!("at most 65536 on a side and 134 million in all, got {width}x{height}")));
    }
    Ok((width, height))
}
