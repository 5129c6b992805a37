//! Spectra: a quantity as a function of wavelength.

use crate::interpolate;

/// A quantity as a function of the vacuum wavelength in nanometres.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
    /// Piecewise linear between ascending wavelengths, clamped at the ends.
    Table {
        /// Ascending wavelengths, nm.
        wavelength_nm: Vec<f64>,
        /// The quantity at each of them.
        value: Vec<f64>,
    },
    /// `value · (λ / reference)^exponent`.
    PowerLaw {
        /// Wavelength at which the quantity equals `value`, nm.
        reference_nm: f64,
        /// The quantity there.
        value: f64,
        /// −4 for Rayleigh scattering; minus the Ångström exponent for aerosol extinction.
        exponent: f64,
    },
}

impl Spectrum {
    /// The value at a wavelength in nm.
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Table { wavelength_nm: nodes, value } => interpolate::linear(nodes, value, wavelength_nm),
            Self::PowerLaw { reference_nm, value, exponent } => value * (wavelength_nm / reference_nm).powf(*exponent),
        }
    }

    /// The values at several wavelengths.
    pub fn sample<const N: usize>(&self, wavelengths_nm: &[f64; N]) -> [f64; N] {
        wavelengths_nm.map(|wavelength_nm| self.at(wavelength_nm))
    }

    /// Every number it holds, for range checks.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Constant(value) | Self::PowerLaw { value, .. } => std::slice::from_ref(value),
            Self::Table { value, .. } => value,
        }
    }
}

/// Reads a two-column table with one header line, as those in `assets/`, keeping the columns `x` and `y`.
/// Lines that hold no two numbers are left out: only for tables that are compiled in and tested.
pub fn read_columns(csv: &str, x: usize, y: usize) -> (Vec<f64>, Vec<f64>) {
    csv.lines()
        .filter_map(|line| {
            let mut fields = line.split(',').map(str::trim);
            let a = fields.clone().nth(x)?.parse::<f64>().ok()?;
            let b = fields.nth(y)?.parse::<f64>().ok()?;
            Some((a, b))
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_law_and_table_agree_with_their_definition() {
        let law = Spectrum::PowerLaw { reference_nm: 550.0, value: 2.0, exponent: -1.3 };
        assert_eq!(law.at(550.0), 2.0);
        assert!((law.at(1100.0) - 2.0 * 0.5f64.powf(1.3)).abs() < 1e-15);
        let table = Spectrum::Table { wavelength_nm: vec![440.0, 550.0, 680.0], value: vec![1.0, 3.0, 2.0] };
        assert_eq!(table.sample(&[300.0, 495.0, 680.0, 900.0]), [1.0, 2.0, 2.0, 2.0]);
    }

    #[test]
    fn columns_skip_the_header() {
        let (x, y) = read_columns("a,b,c\n1,2,3\n4,5,6\n", 0, 2);
        assert_eq!((x, y), (vec![1.0, 4.0], vec![3.0, 6.0]));
    }
}
