//! Parameters of exposure and tone mapping.

use himmel_core::params::{Kind, ParamError, ParamInfo, ParamType, Value, shorten};
use himmel_core::{choices, params};

use crate::target::Output;

/// How luminance becomes a number around 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// By metering the picture: its geometric mean luminance becomes middle grey, 0.18.
    Auto,
    /// A camera's exposure value at ISO 100: 1.2 · 2^EV cd m⁻² becomes 1 [lagarde2014].
    Ev100(f64),
    /// By the camera's aperture, shutter time and film speed.
    Camera,
    /// None: values stay in cd m⁻².
    None,
}

impl Exposure {
    /// The factor on luminance; `None` for automatic, and for a camera, which [`OutputParams::exposure_for`] knows.
    pub fn factor(self) -> Option<f64> {
        match self {
            Self::Auto | Self::Camera => None,
            Self::Ev100(ev100) => Some((-ev100).exp2() / 1.2),
            Self::None => Some(1.0),
        }
    }
}

impl ParamType for Exposure {
    fn kind(_: Option<std::ops::RangeInclusive<f64>>) -> Kind {
        Kind::Text
    }
    fn to_value(&self) -> Value {
        match self {
            Self::Auto => Value::Text("auto".into()),
            Self::None => Value::Text("none".into()),
            Self::Camera => Value::Text("camera".into()),
            Self::Ev100(ev100) => Value::Number(*ev100),
        }
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        let number = match value {
            Value::Text(text) if text == "auto" => return Ok(Self::Auto),
            Value::Text(text) if text == "none" => return Ok(Self::None),
            Value::Text(text) if text == "camera" => return Ok(Self::Camera),
            Value::Text(text) => text.trim().parse().ok(),
            Value::Number(number) => Some(*number),
            _ => None,
        };
        match number {
            Some(ev100) if (-20.0..=40.0).contains(&ev100) => Ok(Self::Ev100(ev100)),
            _ => Err(ParamError::WrongType {
                key: info.key(),
                accepts: "auto, camera, none, or an EV100 in -20..=40".into(),
                got: shorten(&value.to_string()),
            }),
        }
    }
}

choices! {
    /// How light spreads around what is bright.
    pub enum Bloom {
        /// It does not.
        None = "none",
        /// As in a young eye: the CIE's glare function, core included [vos1999].
        Eye = "eye",
        /// As in an old eye, of 80 years [vos1999].
        OldEye = "old-eye",
    }
}

choices! {
    /// How fast automatic exposure follows the light from frame to frame. A still is always adapted.
    pub enum Adaptation {
        /// At once.
        Instant = "instant",
        /// As nerves do: 0.1 s for cones, 0.4 s for rods [durand2000].
        Nerves = "nerves",
        /// Into the light as nerves do, into the dark as photopigments return: 110 s for cones, 400 s for rods [pattanaik2000].
        Pigments = "pigments",
    }
}

choices! {
    /// How exposed luminance is squeezed into a display's range.
    pub enum Tonemap {
        /// Clamped at 1, nothing else.
        Linear = "linear",
        /// Bruneton's variant of Reinhard's operator, with the display's gamma inside [collienne2013, eq. 4.25–4.26].
        Reinhard = "reinhard",
        /// Hejl and Burgess-Dawson's filmic curve, with the display's gamma inside [collienne2013, eq. 4.29].
        Hejl = "hejl",
        /// Sobotka's AgX in Wrensch's polynomial form: bright colours fade to white as on film [wrensch2023].
        Agx = "agx",
        /// AgX with its "punchy" look: more contrast and 40 % more saturation [wrensch2023].
        AgxPunchy = "agx-punchy",
        /// Khronos PBR Neutral: colours keep their hue up to 80 % [khronos2024neutral].
        Neutral = "neutral",
        /// An eye: rods and cones by light level, without colour and darker at night; then agx-punchy [cie191].
        Eye = "eye",
        /// The same with blue nights, as painters have them: an artistic setting [jensen2000].
        EyeBlue = "eye-blue",
    }
}

params! {
    /// From luminance to the picture.
    pub struct OutputParams: "output" {
        /// Exposure: auto (meter the picture), camera (aperture, shutter_s, iso), an EV100, or none (leave cd/m²); unset: auto for finished pictures, none for linear ones.
        exposure: Option<Exposure> = None;
        /// F-number of the camera.
        aperture: f64 = 16.0, "", 0.5..=1000.0;
        /// Time that the camera's shutter is open.
        shutter_s: f64 = 0.01, "s", 1e-6..=1e6;
        /// Film speed of the camera, ISO 12232.
        iso: f64 = 100.0, "", 1.0..=1e7;
        /// How fast automatic exposure follows the light from frame to frame.
        adaptation: Adaptation = Adaptation::Instant;
        /// Added to the exposure; 1 is twice as bright.
        compensation_ev: f64 = 0.0, "EV", -10.0..=10.0;
        /// Tone mapper of finished pictures.
        tonemap: Tonemap = Tonemap::AgxPunchy;
        /// How light spreads around what is bright, in the picture after it is drawn: none, or as in an eye or a lens.
        bloom: Bloom = Bloom::None;
        /// Factor on the share of light that bloom spreads; 1 is the eye's or the lens's own.
        bloom_amount: f64 = 1.0, "", 0.0..=10.0;
        /// Whether the picture is blurred as far as eyes are in dim light, after it is drawn.
        acuity: bool = false;
        /// Noise of one step against banding in 8-bit pictures.
        dither: bool = true;
        /// Width of the picture.
        width_px: u32 = 1280, "px", 1.0..=65536.0;
        /// Height of the picture.
        height_px: u32 = 720, "px", 1.0..=65536.0;
    }
}

impl OutputParams {
    /// The exposure that a kind of output gets: where nobody chose one, finished pictures are metered and linear ones
    /// stay in cd m⁻².
    pub fn exposure_for(&self, output: Output) -> Exposure {
        match self.exposure {
            Some(Exposure::Camera) => Exposure::Ev100(camera_ev100(self.aperture, self.shutter_s, self.iso)),
            Some(exposure) => exposure,
            None if output == Output::Display => Exposure::Auto,
            None => Exposure::None,
        }
    }

    /// Whether automatic exposure is an eye's: darker where an eye sees less.
    pub(crate) fn sees_as_eye(&self) -> bool {
        matches!(self.tonemap, Tonemap::Eye | Tonemap::EyeBlue)
    }

    /// Whether a pass over the finished picture is asked for: [`Bloom`](crate::output::bloom::BloomPass) or acuity.
    pub fn has_post(&self) -> bool {
        self.bloom != Bloom::None || self.acuity
    }
}

/// Exposure value at ISO 100 of a camera: lg2(N² / t · 100 / S) [iso2720].
///
/// A sensor is full at 78 / S lx s (ISO 12232), which a lens of transmission and vignetting q = 0.65 reaches at
/// 78 / (q S) · N² / t = 1.2 · 2^EV cd m⁻²: the factor of [`Exposure::Ev100`].
///
/// `aperture`: N, the f-number.  `shutter_s`: t.  `iso`: S.  Laws tested: sunny 16; one stop is one stop in each.
pub fn camera_ev100(aperture: f64, shutter_s: f64, iso: f64) -> f64 {
    (aperture * aperture / shutter_s * 100.0 / iso).log2()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sunny 16: f/16 and 1/ISO s suit a clear noon. 1e5 lx on a grey card of 18 % is 5,700 cd m⁻², which must become
    /// middle grey within a third of a stop.
    #[test]
    fn sunny_16() {
        for iso in [50.0, 100.0, 400.0] {
            let output = OutputParams {
                exposure: Some(Exposure::Camera),
                aperture: 16.0,
                shutter_s: 1.0 / iso,
                iso,
                ..OutputParams::default()
            };
            let exposure = output.exposure_for(Output::Display);
            assert_eq!(exposure, output.exposure_for(Output::Radiance));
            let grey = exposure.factor().unwrap() * 1e5 * 0.18 / std::f64::consts::PI;
            println!("ISO {iso}: {exposure:?}, grey card at {grey:.3}");
            assert!((grey / 0.18).log2().abs() < 1.0 / 3.0, "{grey}");
        }
        let at = |n, t, s| camera_ev100(n, t, s);
        assert!((at(16.0, 0.01, 100.0) - 14.6439).abs() < 1e-4);
        assert!((at(16.0, 0.02, 100.0) + 1.0 - at(16.0, 0.01, 100.0)).abs() < 1e-12);
        assert!((at(16.0, 0.01, 200.0) + 1.0 - at(16.0, 0.01, 100.0)).abs() < 1e-12);
        assert!((at(16.0 * 2f64.sqrt(), 0.01, 100.0) - 1.0 - at(16.0, 0.01, 100.0)).abs() < 1e-12);
    }
}
