//! UTC against TAI.

/// MJD (UTC) from which TAI − UTC has the value, in seconds [iers-bulletin-c]. The last entry holds until another is announced;
/// none will be before 2027-06-28.
static LEAP_SECONDS: [(f64, f64); 28] = [
    (41_317.0, 10.0),
    (41_499.0, 11.0),
    (41_683.0, 12.0),
    (42_048.0, 13.0),
    (42_413.0, 14.0),
    (42_778.0, 15.0),
    (43_144.0, 16.0),
    (43_509.0, 17.0),
    (43_874.0, 18.0),
    (44_239.0, 19.0),
    (44_786.0, 20.0),
    (45_151.0, 21.0),
    (45_516.0, 22.0),
    (46_247.0, 23.0),
    (47_161.0, 24.0),
    (47_892.0, 25.0),
    (48_257.0, 26.0),
    (48_804.0, 27.0),
    (49_169.0, 28.0),
    (49_534.0, 29.0),
    (50_083.0, 30.0),
    (50_630.0, 31.0),
    (51_179.0, 32.0),
    (53_736.0, 33.0),
    (54_832.0, 34.0),
    (56_109.0, 35.0),
    (57_204.0, 36.0),
    (57_754.0, 37.0),
];

/// TAI − UTC in seconds at an MJD of UTC since 1972; `None` before, when UTC had another rate or did not exist.
pub(super) fn tai_minus_utc_s(mjd_utc: f64) -> Option<f64> {
    let after = LEAP_SECONDS.partition_point(|(mjd, _)| *mjd <= mjd_utc);
    after.checked_sub(1).map(|i| LEAP_SECONDS[i].1)
}
