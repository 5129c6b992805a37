//! Constants of astronomy, each once, with its source.

/// Speed of light in m/s, exact by definition [si2019].
pub const LIGHT_SPEED_M_S: f64 = 299_792_458.0;
/// Astronomical unit in m, exact by definition [iau2012-b2].
pub const AU_M: f64 = 149_597_870_700.0;
/// Julian date (TT) of the epoch J2000.0.
pub const J2000_JD: f64 = 2_451_545.0;
/// Days in a Julian century.
pub const DAYS_PER_CENTURY: f64 = 36_525.0;
/// Days in a Julian year.
pub const DAYS_PER_YEAR: f64 = 365.25;
/// Seconds in a day.
pub const SECONDS_PER_DAY: f64 = 86_400.0;
/// Radians in a second of arc.
pub const ARCSECOND_RAD: f64 = std::f64::consts::PI / 648_000.0;
/// TT − TAI in seconds, exact by definition.
pub const TT_MINUS_TAI_S: f64 = 32.184;
/// Equatorial radius of WGS84 in m [wgs84].
pub const WGS84_EQUATORIAL_RADIUS_M: f64 = 6_378_137.0;
/// Flattening of WGS84 [wgs84].
pub const WGS84_FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Earth's rate of rotation in rad per second of UT1 [iers2010, eq. 5.15].
pub const EARTH_ROTATION_RAD_S: f64 = std::f64::consts::TAU * 1.002_737_811_911_354_48 / SECONDS_PER_DAY;
/// Schwarzschild radius of the Sun in m: 2 G M / c² [sofa2021, `SRS` 1.97412574336e-8 au].
pub const SUN_SCHWARZSCHILD_RADIUS_M: f64 = 1.974_125_743_36e-8 * AU_M;
/// Nominal radius of the Sun in m [iau2015-b3].
pub const SUN_RADIUS_M: f64 = 695_700_000.0;
/// Mean radius of the Moon in m [archinal2018].
pub const MOON_RADIUS_M: f64 = 1_737_400.0;
/// Equatorial radius of the Earth as eclipse canons take it, in m [espenak2009].
pub const EARTH_ECLIPSE_RADIUS_M: f64 = 6_378_136.6;
/// Mass of the Earth over that of the Moon in DE440 [park2021].
pub const EARTH_MOON_MASS_RATIO: f64 = 81.300_568_221_497_22;
