//! What stands in a preset's file: the tables of `docs/air.md`, read by serde.

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub version: u32,
    pub title: String,
    #[allow(dead_code)] // for people who read the file
    pub source: String,
    pub planet: PlanetTable,
    pub ground: GroundTable,
    pub light: Option<LightTable>,
    #[serde(default)]
    pub star: Vec<StarTable>,
    pub component: Vec<ComponentTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanetTable {
    pub radius_km: f64,
    pub top_altitude_km: Option<f64>,
    #[serde(default)]
    pub refraction: bool,
    pub gravity_m_s2: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GroundTable {
    pub albedo: SpectrumTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    pub distance_au: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StarTable {
    pub name: String,
    pub temperature_k: Option<f64>,
    #[serde(default = "one")]
    pub radius_suns: f64,
    pub distance_au: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ComponentTable {
    pub name: String,
    pub profile: ProfileTable,
    pub phase: Option<PhaseTable>,
    pub extinction_per_m: Option<SpectrumTable>,
    pub vertical_optical_depth: Option<SpectrumTable>,
    pub single_scattering_albedo: Option<SpectrumTable>,
    pub cross_section: Option<CrossSection>,
    pub cross_section_m2: Option<SpectrumTable>,
    pub mie: Option<MieTable>,
    pub number_density_per_m3: Option<f64>,
    pub number_density_per_cm3: Option<f64>,
    pub pressure_hpa: Option<f64>,
    pub temperature_k: Option<f64>,
    pub volume_fraction: Option<f64>,
    pub column_du: Option<f64>,
    pub optical_depth_550: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MieTable {
    pub mode: Vec<ModeTable>,
    pub n: SpectrumTable,
    #[serde(default)]
    pub k: Option<SpectrumTable>,
    #[serde(default)]
    pub method: Method,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModeTable {
    pub median_radius_um: f64,
    pub geometric_deviation: f64,
    pub number_per_cm3: f64,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Method {
    #[default]
    LorenzMie,
    HarmonicMean,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum CrossSection {
    Air,
    Nitrogen,
    CarbonDioxide,
    Methane,
    /// The table's averages over [λ, λ + 10 nm), each at the middle of its bin.
    Ozone,
    /// The same numbers at the printed λ, as published comparisons read them.
    OzoneAsPrinted,
}

/// What a table says about wavelengths beyond its ends.
#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outside {
    Hold,
    Zero,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a number, { wavelength_nm = […], value = […], outside = \"hold\" or \"zero\" } or { reference_nm = …, value = …, exponent = … }"
)]
pub(super) enum SpectrumTable {
    Constant(f64),
    Whole(i64),
    Table { wavelength_nm: Vec<f64>, value: Vec<f64>, outside: Option<Outside> },
    PowerLaw { reference_nm: f64, value: f64, exponent: f64 },
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum ProfileTable {
    Exponential {
        scale_height_km: Option<f64>,
        temperature_k: Option<f64>,
        molar_mass_g_mol: Option<f64>,
    },
    Gaussian {
        centre_km: f64,
        width_km: f64,
    },
    Tent {
        bottom_km: f64,
        peak_km: f64,
        top_km: f64,
    },
    Table {
        altitude_km: Vec<f64>,
        value: Vec<f64>,
        #[serde(default)]
        logarithmic: bool,
    },
    Sum(Vec<PartTable>),
    Layered {
        scale_height_km: f64,
        reference: f64,
        layer: Vec<LayerTable>,
    },
    OzoneUs1976 {},
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartTable {
    pub weight: f64,
    pub profile: ProfileTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LayerTable {
    pub altitude_km: f64,
    pub deviation_km: f64,
    pub value: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PhaseTable {
    Rayleigh {
        #[serde(default)]
        depolarisation: f64,
    },
    HenyeyGreenstein {
        g: SpectrumTable,
    },
    CornetteShanks {
        g: Option<SpectrumTable>,
        haze: Option<f64>,
    },
    Draine {
        g: SpectrumTable,
        alpha: f64,
    },
    Table {
        wavelength_nm: Vec<f64>,
        angle_deg: Vec<f64>,
        value: Vec<Vec<f64>>,
    },
}
