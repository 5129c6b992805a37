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
    /// None: values stay in cd m⁻².
    None,
}

impl Exposure {
    /// The factor on luminance; `None` for automatic.
    pub fn factor(self) -> Option<f64> {
        match self {
            Self::Auto => None,
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
            Self::Ev100(ev100) => Value::Number(*ev100),
        }
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        let number = match value {
            Value::Text(text) if text == "auto" => return Ok(Self::Auto),
            Value::Text(text) if text == "none" => return Ok(Self::None),
            Value::Text(text) => text.trim().parse().ok(),
            Value::Number(number) => Some(*number),
            _ => None,
        };
        match number {
            Some(ev100) if (-20.0..=40.0).contains(&ev100) => Ok(Self::Ev100(ev100)),
            _ => Err(ParamError::WrongType {
                key: info.key(),
                accepts: "auto, none, or an EV100 in -20..=40".into(),
                got: shorten(&value.to_string()),
            }),
        }
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
    }
}

params! {
    /// From luminance to the picture.
    pub struct OutputParams: "output" {
        /// Exposure: auto (meter the picture), an EV100, or none (leave cd/m²); unset: auto for finished pictures, none for linear ones.
        exposure: Option<Exposure> = None;
        /// Added to the exposure; 1 is twice as bright.
        compensation_ev: f64 = 0.0, "EV", -10.0..=10.0;
        /// Tone mapper of finished pictures.
        tonemap: Tonemap = Tonemap::AgxPunchy;
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
        self.exposure.unwrap_or(match output {
            Output::Display => Exposure::Auto,
            Output::Radiance => Exposure::None,
        })
    }
}
