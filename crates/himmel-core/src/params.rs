//! Parameters that describe themselves.
//!
//! Each phenomenon declares its parameters once, with [`params!`](crate::params!): name, unit, range, default and one
//! sentence. `--set`, the scene file, `himmel params` and every editor read that description.
//!
//! ```
//! himmel_core::params! {
//!     /// The Sun's disc.
//!     pub struct SunParams: "light.sun" {
//!         /// Whether the disc is drawn.
//!         enabled: bool = true;
//!         /// Factor on the disc's radius.
//!         radius_scale: f64 = 1.0, "", 0.0..=100.0;
//!     }
//! }
//! use himmel_core::params::{Params, Value};
//! let mut sun = SunParams::default();
//! sun.set("radius_scale", &Value::Number(2.0))?;
//! assert_eq!(sun.radius_scale, 2.0);
//! assert!(sun.set("radius_scal", &Value::Number(2.0)).unwrap_err().to_string().contains("did you mean"));
//! # Ok::<(), himmel_core::params::ParamError>(())
//! ```

use std::fmt;
use std::ops::RangeInclusive;

/// A parameter's value as it stands in a scene file or on the command line.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit.
    Number(f64),
    /// On or off.
    Flag(bool),
    /// A text: a choice, a place, a time.
    Text(String),
    /// Left to another source (the preset, the ephemeris); never written to a scene file.
    Unset,
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => write!(f, "{text}"),
            Self::Unset => write!(f, "unset"),
        }
    }
}

/// What a parameter accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A finite number within bounds.
    Number {
        /// Smallest and largest value.
        range: RangeInclusive<f64>,
        /// Whether only whole numbers are accepted.
        whole: bool,
    },
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Free text; its reader checks it.
    Text,
}

/// The description of one parameter.
#[derive(Clone, Debug)]
pub struct ParamInfo {
    /// The scene file's table, such as `light.sun`.
    pub table: &'static str,
    /// The name within it.
    pub name: &'static str,
    /// The unit, empty for pure numbers, flags and texts.
    pub unit: &'static str,
    /// What it accepts.
    pub kind: Kind,
    /// Its value where nobody sets one.
    pub default: Value,
    /// One sentence about what it does.
    pub sentence: String,
}

impl ParamInfo {
    /// `table.name`, as `--set` takes it.
    pub fn key(&self) -> String {
        format!("{}.{}", self.table, self.name)
    }

    /// What it accepts, for people: `0..=1`, `agx | linear`, `true | false`.
    pub fn accepts(&self) -> String {
        match &self.kind {
            Kind::Number { range, .. } => format!("{}..={}", range.start(), range.end()),
            Kind::Flag => "true | false".into(),
            Kind::Choice(words) => words.join(" | "),
            Kind::Text => "text".into(),
        }
    }

    /// Reads a value typed by a person.
    pub fn parse(&self, text: &str) -> Result<Value, ParamError> {
        let text = text.trim();
        let wrong = || ParamError::WrongType { key: self.key(), accepts: self.accepts(), got: shorten(text) };
        match self.kind {
            Kind::Number { .. } => text.parse().map(Value::Number).map_err(|_| wrong()),
            Kind::Flag => match text {
                "true" | "on" | "yes" | "1" => Ok(Value::Flag(true)),
                "false" | "off" | "no" | "0" => Ok(Value::Flag(false)),
                _ => Err(wrong()),
            },
            Kind::Choice(_) | Kind::Text => Ok(Value::Text(text.into())),
        }
    }

    fn wrong_type(&self, got: &Value) -> ParamError {
        ParamError::WrongType { key: self.key(), accepts: self.accepts(), got: shorten(&got.to_string()) }
    }
}

/// Cuts text for an error message.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

/// Why a parameter could not be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParamError {
    /// No parameter has this name.
    #[error("unknown parameter \"{key}\"{}", did_you_mean(.suggestion))]
    Unknown {
        /// What was asked for.
        key: String,
        /// The nearest name.
        suggestion: Option<String>,
    },
    /// The value is of the wrong kind.
    #[error("{key} takes {accepts}, got {got}")]
    WrongType {
        /// `table.name`.
        key: String,
        /// What it accepts.
        accepts: String,
        /// What came.
        got: String,
    },
    /// The number lies outside the parameter's range or is not finite.
    #[error("{key} must lie in {}..={}{}, got {got}", .range.start(), .range.end(), spaced(.unit))]
    OutOfRange {
        /// `table.name`.
        key: String,
        /// What it accepts.
        range: RangeInclusive<f64>,
        /// Its unit.
        unit: &'static str,
        /// What came.
        got: f64,
    },
}

fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

fn did_you_mean(suggestion: &Option<String>) -> String {
    match suggestion {
        Some(name) => format!(": did you mean {name}?"),
        None => "; `himmel params` lists them all".into(),
    }
}

/// The candidate nearest to `word`, if it is near enough to be a slip of the pen.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    if word.len() > 200 {
        return None;
    }
    candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_string())
}

/// A table of parameters.
pub trait Params {
    /// The table's name in scene files.
    fn table(&self) -> &'static str;
    /// Describes each parameter, in the order of declaration.
    fn describe(&self) -> Vec<ParamInfo>;
    /// The value of a parameter, `None` where there is no such name.
    fn get(&self, name: &str) -> Option<Value>;
    /// Sets a parameter; on an error nothing changes.
    fn set(&mut self, name: &str, value: &Value) -> Result<(), ParamError>;
}

/// A type that a parameter can have.
pub trait ParamType: Sized {
    /// What it accepts.
    fn kind(range: Option<RangeInclusive<f64>>) -> Kind;
    /// To a value.
    fn to_value(&self) -> Value;
    /// From a value that must fit the description.
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError>;
}

impl ParamType for f64 {
    fn kind(range: Option<RangeInclusive<f64>>) -> Kind {
        Kind::Number { range: range.unwrap_or(f64::MIN..=f64::MAX), whole: false }
    }
    fn to_value(&self) -> Value {
        Value::Number(*self)
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        let Value::Number(number) = *value else { return Err(info.wrong_type(value)) };
        match &info.kind {
            Kind::Number { range, .. } if !range.contains(&number) => {
                Err(ParamError::OutOfRange { key: info.key(), range: range.clone(), unit: info.unit, got: number })
            }
            Kind::Number { whole: true, .. } if number.fract() != 0.0 => Err(ParamError::WrongType {
                key: info.key(),
                accepts: "a whole number".into(),
                got: number.to_string(),
            }),
            _ => Ok(number),
        }
    }
}

impl ParamType for u32 {
    fn kind(range: Option<RangeInclusive<f64>>) -> Kind {
        Kind::Number { range: range.unwrap_or(0.0..=f64::from(u32::MAX)), whole: true }
    }
    fn to_value(&self) -> Value {
        Value::Number(f64::from(*self))
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        f64::from_value(value, info).map(|number| number as Self)
    }
}

impl ParamType for bool {
    fn kind(_: Option<RangeInclusive<f64>>) -> Kind {
        Kind::Flag
    }
    fn to_value(&self) -> Value {
        Value::Flag(*self)
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        match value {
            Value::Flag(flag) => Ok(*flag),
            _ => Err(info.wrong_type(value)),
        }
    }
}

impl ParamType for String {
    fn kind(_: Option<RangeInclusive<f64>>) -> Kind {
        Kind::Text
    }
    fn to_value(&self) -> Value {
        Value::Text(self.clone())
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        match value {
            Value::Text(text) => Ok(text.clone()),
            _ => Err(info.wrong_type(value)),
        }
    }
}

impl<T: ParamType> ParamType for Option<T> {
    fn kind(range: Option<RangeInclusive<f64>>) -> Kind {
        T::kind(range)
    }
    fn to_value(&self) -> Value {
        self.as_ref().map_or(Value::Unset, T::to_value)
    }
    fn from_value(value: &Value, info: &ParamInfo) -> Result<Self, ParamError> {
        match value {
            Value::Unset => Ok(None),
            _ => T::from_value(value, info).map(Some),
        }
    }
}

/// Declares a table of parameters: a plain struct with public fields, its defaults, and its description.
/// Each field: sentence as a doc comment, `name: type = default`, then unit and range for numbers.
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $table_doc:literal])+
        $vis:vis struct $Struct:ident : $table:literal {
            $( $(#[doc = $doc:literal])+ $name:ident : $ty:ty = $default:expr $(, $unit:literal, $range:expr)? ; )+
        }
    ) => {
        $(#[doc = $table_doc])+
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $Struct {
            $( $(#[doc = $doc])+ pub $name: $ty, )+
        }

        impl Default for $Struct {
            fn default() -> Self {
                Self { $( $name: $default, )+ }
            }
        }

        impl $Struct {
            fn describe_one(name: &str) -> Option<$crate::params::ParamInfo> {
                use $crate::params::{ParamInfo, ParamType};
                match name {
                    $( stringify!($name) => {
                        #[allow(unused_mut, unused_assignments)]
                        let (mut unit, mut range) = ("", None);
                        $( unit = $unit; range = Some($range); )?
                        let default: $ty = $default;
                        Some(ParamInfo {
                            table: $table,
                            name: stringify!($name),
                            unit,
                            kind: <$ty as ParamType>::kind(range),
                            default: default.to_value(),
                            sentence: concat!($($doc),+).trim().to_string(),
                        })
                    } )+
                    _ => None,
                }
            }
        }

        impl $crate::params::Params for $Struct {
            fn table(&self) -> &'static str {
                $table
            }
            fn describe(&self) -> Vec<$crate::params::ParamInfo> {
                [$( stringify!($name) ),+].into_iter().filter_map(Self::describe_one).collect()
            }
            fn get(&self, name: &str) -> Option<$crate::params::Value> {
                use $crate::params::ParamType;
                match name {
                    $( stringify!($name) => Some(self.$name.to_value()), )+
                    _ => None,
                }
            }
            fn set(&mut self, name: &str, value: &$crate::params::Value) -> ::core::result::Result<(), $crate::params::ParamError> {
                use $crate::params::{nearest, shorten, ParamError, ParamType};
                let Some(info) = Self::describe_one(name) else {
                    let suggestion = nearest(name, [$( stringify!($name) ),+]);
                    return Err(ParamError::Unknown {
                        key: format!("{}.{}", $table, shorten(name)),
                        suggestion: suggestion.map(|name| format!("{}.{name}", $table)),
                    });
                };
                match name {
                    $( stringify!($name) => self.$name = <$ty as ParamType>::from_value(value, &info)?, )+
                    _ => {}
                }
                Ok(())
            }
        }
    };
}

/// Declares an enum that a parameter can take, with the word for each variant.
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $enum_doc:literal])+
        $vis:vis enum $Enum:ident {
            $( $(#[doc = $doc:literal])+ $Variant:ident = $word:literal, )+
        }
    ) => {
        $(#[doc = $enum_doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        $vis enum $Enum {
            $( $(#[doc = $doc])+ $Variant, )+
        }

        impl $Enum {
            /// Every variant, in the order of declaration.
            pub const ALL: &'static [Self] = &[$( Self::$Variant ),+];
            /// The word for each variant.
            pub const WORDS: &'static [&'static str] = &[$( $word ),+];

            /// The word that scene files and the command line use.
            pub fn word(self) -> &'static str {
                match self {
                    $( Self::$Variant => $word, )+
                }
            }
        }

        impl $crate::params::ParamType for $Enum {
            fn kind(_: Option<std::ops::RangeInclusive<f64>>) -> $crate::params::Kind {
                $crate::params::Kind::Choice(Self::WORDS)
            }
            fn to_value(&self) -> $crate::params::Value {
                $crate::params::Value::Text(self.word().into())
            }
            fn from_value(
                value: &$crate::params::Value,
                info: &$crate::params::ParamInfo,
            ) -> ::core::result::Result<Self, $crate::params::ParamError> {
                let text = match value {
                    $crate::params::Value::Text(text) => text.as_str(),
                    _ => "",
                };
                Self::ALL.iter().copied().find(|choice| choice.word() == text).ok_or_else(|| {
                    $crate::params::ParamError::WrongType {
                        key: info.key(),
                        accepts: Self::WORDS.join(" | "),
                        got: $crate::params::shorten(&value.to_string()),
                    }
                })
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::choices! {
        /// A shade.
        pub enum Shade {
            /// Light.
            Light = "light",
            /// Dark.
            Dark = "dark",
        }
    }

    crate::params! {
        /// For the tests.
        pub struct Sample: "sample" {
            /// How many.
            count: u32 = 3, "", 1.0..=10.0;
            /// How long.
            length_m: f64 = 1.5, "m", 0.0..=100.0;
            /// How dark.
            shade: Shade = Shade::Dark;
            /// Whose.
            owner: Option<f64> = None, "", 0.0..=1.0;
        }
    }

    #[test]
    fn describes_itself() {
        let info = Sample::default().describe();
        assert_eq!(info.len(), 4);
        assert_eq!(
            (info[1].key().as_str(), info[1].unit, info[1].sentence.as_str()),
            ("sample.length_m", "m", "How long.")
        );
        assert_eq!(info[2].accepts(), "light | dark");
        assert_eq!(info[3].default, Value::Unset);
    }

    #[test]
    fn every_value_round_trips() {
        let mut sample = Sample { count: 7, length_m: 99.5, shade: Shade::Light, owner: Some(0.25) };
        let original = sample.clone();
        for info in original.describe() {
            let value = original.get(info.name).unwrap();
            sample.set(info.name, &value).unwrap();
        }
        assert_eq!(sample, original);
    }

    #[test]
    fn refuses_what_does_not_fit_and_changes_nothing() {
        let mut sample = Sample::default();
        for (name, value, part) in [
            ("length_m", Value::Number(f64::NAN), "must lie in 0..=100 m, got NaN"),
            ("length_m", Value::Number(-1e30), "must lie in 0..=100 m"),
            ("length_m", Value::Flag(true), "sample.length_m takes 0..=100, got true"),
            ("count", Value::Number(2.5), "whole number"),
            ("shade", Value::Text("grey".into()), "light | dark, got grey"),
            ("lenght_m", Value::Number(1.0), "did you mean sample.length_m?"),
            ("zzz", Value::Number(1.0), "`himmel params`"),
        ] {
            let error = sample.set(name, &value).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        assert_eq!(sample, Sample::default());
        assert!(sample.describe()[0].parse("two").is_err());
        assert_eq!(sample.describe()[0].parse(" 4 ").unwrap(), Value::Number(4.0));
    }
}
