use super::leap_seconds::tai_minus_utc_s;
use super::{DeltaTModel, JulianDateTdb, JulianDateTt, JulianDateUt1, JulianDateUtc};
use crate::constants::{SECONDS_PER_DAY, TT_MINUS_TAI_S};
use crate::error::{AstroError, Result, in_range, shown};

const UNIX_EPOCH_JD: f64 = 2_440_587.5;

/// One instant on two clocks: TT moves the bodies, UT1 turns the Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    tt: JulianDateTt,
    ut1: JulianDateUt1,
}

impl Instant {
    /// From both clocks, which takes Delta T out of the question. They may differ by at most 12 days (Delta T of 13,000 BC).
    pub fn from_tt_ut1(tt: JulianDateTt, ut1: JulianDateUt1) -> Result<Self> {
        in_range(
            "TT minus UT1",
            "-12..=12 days",
            tt.jd() - ut1.jd(),
            -12.0,
            12.0,
            " (are both Julian dates of the same instant?)",
        )?;
        Ok(Self { tt, ut1 })
    }

    /// From Terrestrial Time with a Delta T.
    pub fn from_tt(tt: JulianDateTt, model: DeltaTModel) -> Self {
        Self { tt, ut1: JulianDateUt1::unchecked(tt.plus_seconds(-model.seconds(tt)).jd()) }
    }

    /// From Universal Time UT1 with a Delta T.
    pub fn from_ut1(ut1: JulianDateUt1, model: DeltaTModel) -> Self {
        // Delta T is a function of TT; two rounds settle to a nanosecond.
        let mut tt = JulianDateTt::unchecked(ut1.jd());
        for _ in 0..3 {
            tt = JulianDateTt::unchecked(ut1.jd()).plus_seconds(model.seconds(tt));
        }
        Self { tt, ut1 }
    }

    /// From civil seconds since 1970-01-01T00:00Z (each day 86,400 of them) and the standard Delta T.
    pub fn from_unix_seconds(unix_s: f64) -> Result<Self> {
        Self::from_unix_seconds_with(unix_s, DeltaTModel::Standard)
    }

    /// From civil seconds since 1970-01-01T00:00Z and a Delta T.
    ///
    /// Since 1972 TT = UTC + leap seconds + 32.184 s; after the last known leap second none is added. Before 1972 civil
    /// time is taken as UT1 (UTC then kept within 0.1 s of it, or did not exist).
    pub fn from_unix_seconds_with(unix_s: f64, model: DeltaTModel) -> Result<Self> {
        let jd_utc = JulianDateUtc::new(UNIX_EPOCH_JD + unix_s / SECONDS_PER_DAY)?;
        Self::from_utc(jd_utc, model)
    }

    /// From a Julian date in UTC and a Delta T; see [`Instant::from_unix_seconds_with`].
    pub fn from_utc(utc: JulianDateUtc, model: DeltaTModel) -> Result<Self> {
        match tai_minus_utc_s(utc.jd() - 2_400_000.5) {
            Some(leap_s) => {
                let tt = JulianDateTt::new(utc.jd())?.plus_seconds(leap_s + TT_MINUS_TAI_S);
                Ok(Self::from_tt(tt, model))
            }
            None => Ok(Self::from_ut1(JulianDateUt1::new(utc.jd())?, model)),
        }
    }

    /// Reads ISO 8601 with `Z` or an offset (`2012-09-06T18:00Z`, `1999-08-11T12:33:00+02:00`), by the Gregorian calendar.
    /// A time without either is read as UTC; the local clock of a place is the caller's business.
    pub fn parse(text: &str) -> Result<Self> {
        // 23:59:60 is a second of its own on the days that have one; civil time counts it as 23:59:59 once more.
        let leap = super::civil::split_leap_second(text);
        let unix_s = super::civil::unix_seconds_from_iso(leap.as_deref().unwrap_or(text))?;
        let instant = Self::from_unix_seconds(unix_s)?;
        if leap.is_none() {
            return Ok(instant);
        }
        let next_mjd = (unix_s.floor() + 1.0) / SECONDS_PER_DAY + UNIX_EPOCH_JD - 2_400_000.5;
        if next_mjd.fract() != 0.0 || tai_minus_utc_s(next_mjd) == tai_minus_utc_s(next_mjd - 0.5) {
            return Err(malformed_time(text, "that minute has no leap second"));
        }
        instant.plus_seconds(1.0)
    }

    /// Terrestrial Time.
    pub fn tt(&self) -> JulianDateTt {
        self.tt
    }

    /// Universal Time UT1.
    pub fn ut1(&self) -> JulianDateUt1 {
        self.ut1
    }

    /// Barycentric Dynamical Time.
    pub fn tdb(&self) -> JulianDateTdb {
        self.tt.to_tdb()
    }

    /// TT − UT1 of this instant.
    pub fn delta_t_s(&self) -> f64 {
        (self.tt.jd() - self.ut1.jd()) * SECONDS_PER_DAY
    }

    /// UTC: leap seconds since 1972, UT1 before.
    pub fn utc(&self) -> JulianDateUtc {
        // From the side of 1972 (10 leap seconds) the rounds settle on the right side of every leap second.
        let mut utc = self.tt.jd() - (TT_MINUS_TAI_S + 10.0) / SECONDS_PER_DAY;
        for _ in 0..3 {
            match tai_minus_utc_s(utc - 2_400_000.5) {
                Some(leap_s) => utc = self.tt.jd() - (TT_MINUS_TAI_S + leap_s) / SECONDS_PER_DAY,
                None => return JulianDateUtc::unchecked(self.ut1.jd()),
            }
        }
        JulianDateUtc::unchecked(utc)
    }

    /// Civil seconds since 1970-01-01T00:00Z.
    pub fn unix_seconds(&self) -> f64 {
        (self.utc().jd() - UNIX_EPOCH_JD) * SECONDS_PER_DAY
    }

    /// ISO 8601 in UTC to the millisecond, `2012-09-06T18:00:00.000Z`.
    pub fn to_iso_utc(&self) -> String {
        super::civil::iso_from_unix_seconds(self.unix_seconds())
    }

    /// The instant some seconds of TT later, with the same Delta T.
    pub fn plus_seconds(&self, seconds: f64) -> Result<Self> {
        let tt = JulianDateTt::new(self.tt.jd() + seconds / SECONDS_PER_DAY)?;
        let ut1 = JulianDateUt1::new(self.ut1.jd() + seconds / SECONDS_PER_DAY)?;
        Ok(Self { tt, ut1 })
    }
}

pub(super) fn malformed_time(text: &str, reason: &str) -> AstroError {
    AstroError::Malformed { what: "time", text: shown(text), reason: reason.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leap_second_lies_between_its_neighbours() {
        let at = |text: &str| Instant::parse(text).unwrap().tt().jd() * SECONDS_PER_DAY;
        let (before, leap, after) =
            (at("2016-12-31T23:59:59Z"), at("2016-12-31T23:59:60Z"), at("2017-01-01T00:00:00Z"));
        // A Julian date in f64 resolves 40 µs.
        assert!((leap - before - 1.0).abs() < 1e-4 && (after - leap - 1.0).abs() < 1e-4);
        assert!((at("2017-01-01T01:59:60+02:00") - leap).abs() < 1e-4);
        for text in ["2017-12-31T23:59:60Z", "2016-12-31T12:00:60Z", "1950-12-31T23:59:60Z"] {
            assert!(Instant::parse(text).unwrap_err().to_string().contains("leap second"), "{text}");
        }
    }

    #[test]
    fn leap_seconds_enter_terrestrial_time() {
        // J2000.0 is 2000-01-01T12:00:00 TT = 11:58:55.816 UTC.
        let i = Instant::from_unix_seconds(946_727_935.816).unwrap();
        assert!((i.tt().jd() - 2_451_545.0).abs() * SECONDS_PER_DAY < 1e-4);
        assert!((i.delta_t_s() - 63.8285).abs() < 1e-3);
    }

    #[test]
    fn unix_seconds_come_back() {
        for s in [-3e10, -1e9, 63_072_001.0, 78_796_799.0, 78_796_801.0, 1e9, 1.7e9, 2.5e9] {
            let back = Instant::from_unix_seconds(s).unwrap().unix_seconds();
            assert!((back - s).abs() < 2e-4, "{s} became {back}");
        }
    }

    #[test]
    fn absurd_dates_are_errors() {
        for s in [f64::NAN, f64::INFINITY, 1e15, -1e300] {
            assert!(Instant::from_unix_seconds(s).is_err());
        }
        let tt = JulianDateTt::new(2_451_545.0).unwrap();
        assert!(Instant::from_tt_ut1(tt, JulianDateUt1::new(2_451_600.0).unwrap()).is_err());
    }
}
