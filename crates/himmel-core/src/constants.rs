//! Physical and photometric constants, each once, each with its source.

/// The astronomical unit in metres, exact by definition [iau2012b2].
pub const ASTRONOMICAL_UNIT_M: f64 = 149_597_870_700.0;

/// Nominal radius of the Sun in metres [iau2015b3].
pub const SUN_RADIUS_M: f64 = 695_700_000.0;

/// Luminous efficacy of monochromatic radiation of 540 THz in lm/W, exact by definition [si2019].
pub const LUMINOUS_EFFICACY_LM_W: f64 = 683.0;

/// Illuminance above the air of a star of V = 0, lx [allen1973].
pub const ILLUMINANCE_OF_V_0_LX: f64 = 2.54e-6;

/// One Dobson unit: molecules in a vertical column of one square metre [iup_dobson].
pub const DOBSON_UNIT_PER_M2: f64 = 2.686_780_111e20;

/// The speed of light in vacuum, m/s, exact by definition [si2019].
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// The Planck constant, J s, exact by definition [si2019].
pub const PLANCK_J_S: f64 = 6.626_070_15e-34;

/// The Boltzmann constant, J/K, exact by definition [si2019].
pub const BOLTZMANN_J_K: f64 = 1.380_649e-23;
