//! Time that runs as fast as you like, in either direction.

use himmel_core::params::shorten;
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use crate::error::{Error, Result};

/// A clock: an instant, and how many seconds it moves for each second of yours.
///
/// It does not look at the computer's clock by itself: call [`advance`](Self::advance) each frame, so that the same calls give
/// the same skies.
///
/// ```
/// use himmel::Clock;
/// let mut clock = Clock::at("2012-09-06T18:00Z")?;
/// clock.set_rate(60.0); // a minute each second
/// clock.advance(30.0);
/// assert_eq!(clock.to_string(), "2012-09-06T18:30:00Z");
/// clock.set_rate(-60.0); // backwards
/// clock.advance(30.0);
/// assert_eq!(clock.to_string(), "2012-09-06T18:00:00Z");
/// # Ok::<(), himmel::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    now: Timestamp,
    start: Timestamp,
    rate: f64,
    paused: bool,
}

impl Clock {
    /// A clock that stands at an instant: ISO 8601 with `Z` or an offset; a bare time is UTC.
    pub fn at(text: &str) -> Result<Self> {
        Ok(Self::from_timestamp(parse_time(text, &TimeZone::UTC)?))
    }

    /// A clock that stands at an instant.
    pub fn from_timestamp(now: Timestamp) -> Self {
        Self { now, start: now, rate: 1.0, paused: false }
    }

    /// The instant it shows.
    pub fn now(&self) -> Timestamp {
        self.now
    }

    /// Seconds since 1970-01-01T00:00Z, each day 86,400 of them.
    pub fn unix_seconds(&self) -> f64 {
        self.now.as_second() as f64 + f64::from(self.now.subsec_nanosecond()) * 1e-9
    }

    /// Sets the instant; [`reset`](Self::reset) comes back to it.
    pub fn set(&mut self, now: Timestamp) {
        self.now = now;
        self.start = now;
    }

    /// The time of day as a fraction 0..1 of the 24 hours of a zone's clock.
    pub fn day_fraction(&self, zone: &TimeZone) -> f64 {
        let time = zone.to_datetime(self.now).time();
        let seconds = f64::from(time.hour()) * 3600.0 + f64::from(time.minute()) * 60.0 + f64::from(time.second());
        (seconds + f64::from(time.subsec_nanosecond()) * 1e-9) / 86_400.0
    }

    /// Moves to a fraction of the day that the zone's calendar shows: 0.5 is noon. Values outside 0..1 reach other days.
    /// Non-finite fractions are refused.
    pub fn set_day_fraction(&mut self, fraction: f64, zone: &TimeZone) -> Result<()> {
        let reason = |reason: &str| Error::Time { text: format!("day fraction {fraction}"), reason: reason.into() };
        if !(fraction.is_finite() && fraction.abs() < 1e7) {
            return Err(reason("it must be a finite number of days"));
        }
        let date = zone.to_datetime(self.now).date();
        let midnight = date.to_datetime(jiff::civil::Time::midnight());
        let span = jiff::SignedDuration::try_from_secs_f64(fraction * 86_400.0).map_err(|e| reason(&e.to_string()))?;
        let civil = midnight.checked_add(span).map_err(|e| reason(&e.to_string()))?;
        self.now = zone.to_timestamp(civil).map_err(|e| reason(&e.to_string()))?;
        Ok(())
    }

    /// Virtual seconds for each real second; negative runs backwards.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Sets the rate. Non-finite rates are taken as 0.
    pub fn set_rate(&mut self, rate: f64) {
        self.rate = if rate.is_finite() { rate } else { 0.0 };
    }

    /// Turns its direction round.
    pub fn reverse(&mut self) {
        self.rate = -self.rate;
    }

    /// Stops.
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Goes on.
    pub fn resume(&mut self) {
        self.paused = false;
    }

    /// Whether it stands still.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Back to the instant that was set last; rate and pause stay.
    pub fn reset(&mut self) {
        self.now = self.start;
    }

    /// Moves on by some real seconds. Stops at the ends of the calendar (years −9999 and 9999).
    pub fn advance(&mut self, real_seconds: f64) {
        let virtual_seconds = real_seconds * self.rate;
        if self.paused || !virtual_seconds.is_finite() {
            return;
        }
        let end = if virtual_seconds > 0.0 { Timestamp::MAX } else { Timestamp::MIN };
        self.now = jiff::SignedDuration::try_from_secs_f64(virtual_seconds)
            .ok()
            .and_then(|span| self.now.checked_add(span).ok())
            .unwrap_or(end);
    }
}

impl std::fmt::Display for Clock {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.now)
    }
}

/// Reads a time: `now`, ISO 8601 with `Z` or an offset, or bare and local to a zone. A date alone is its midnight. Local
/// times that a change of clocks skips or repeats are read as the calendar standard says (later and earlier one).
pub fn parse_time(text: &str, zone: &TimeZone) -> Result<Timestamp> {
    let given = text.trim();
    if given == "now" {
        return Ok(Timestamp::now());
    }
    let error = |reason: String| Error::Time { text: shorten(given), reason };
    // ISO 8601 writes years before 1 and after 9999 with six digits; four are understood too.
    let padded = match given.split_at_checked(1) {
        Some((sign @ ("-" | "+"), rest)) if rest.split('-').next().is_some_and(|year| year.len() == 4) => {
            format!("{sign}00{rest}")
        }
        _ => given.to_string(),
    };
    let text = padded.as_str();
    if let Ok(timestamp) = text.parse::<Timestamp>() {
        return Ok(timestamp);
    }
    // `Z` or an offset was meant: a bare reading would silently drop it.
    let has_zone = text.split_once(['T', 't', ' ']).is_some_and(|(_, time)| time.contains(['Z', 'z', '+', '-', '[']));
    if has_zone {
        let reason = text.parse::<Timestamp>().err().map(|e| e.to_string()).unwrap_or_default();
        return Err(error(reason.lines().collect::<Vec<_>>().join(" ")));
    }
    let civil: DateTime =
        text.parse().map_err(|e: jiff::Error| error(e.to_string().lines().collect::<Vec<_>>().join(" ")))?;
    zone.to_timestamp(civil).map_err(|e| error(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn berlin() -> TimeZone {
        TimeZone::get("Europe/Berlin").unwrap()
    }

    #[test]
    fn times_are_utc_offset_or_local() {
        let utc: Timestamp = "2012-09-06T18:00:00Z".parse().unwrap();
        for text in [
            "2012-09-06T18:00Z",
            "2012-09-06T20:00+02:00",
            "2012-09-06T20:00",
            "2012-09-06 20:00:00",
            " 2012-09-06T20:00 ",
        ] {
            assert_eq!(parse_time(text, &berlin()).unwrap(), utc, "{text}");
        }
        assert_eq!(parse_time("2012-09-06", &berlin()).unwrap().to_string(), "2012-09-05T22:00:00Z");
        assert_eq!(parse_time("-2000-01-01T00:00Z", &berlin()).unwrap().to_string(), "-002000-01-01T00:00:00Z");
        // In the hour that spring skips, later; in the one that autumn repeats, earlier.
        assert_eq!(parse_time("2012-03-25T02:30", &berlin()).unwrap().to_string(), "2012-03-25T01:30:00Z");
        assert_eq!(parse_time("2012-10-28T02:30", &berlin()).unwrap().to_string(), "2012-10-28T00:30:00Z");
    }

    #[test]
    fn what_is_no_time_says_how_to_write_one() {
        for text in
            ["2012-13-45T99:00Z", "", "yesterday", "2012-09-06T25:00", "1e30", "2012-09-06T18:00+99:00", "🌞", "-"]
        {
            let error = parse_time(text, &berlin()).unwrap_err().to_string();
            assert!(error.contains("2012-09-06T18:00Z") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn day_fractions_and_instants_are_two_views_of_one_clock() {
        let mut clock = Clock::at("2012-09-06T10:00Z").unwrap();
        assert_eq!(clock.day_fraction(&berlin()), 0.5);
        clock.set_day_fraction(0.75, &berlin()).unwrap();
        assert_eq!(clock.to_string(), "2012-09-06T16:00:00Z");
        clock.reset();
        assert_eq!(clock.to_string(), "2012-09-06T10:00:00Z");
        assert!(clock.set_day_fraction(f64::NAN, &berlin()).is_err());
        assert!(clock.set_day_fraction(1e30, &berlin()).is_err());
    }

    #[test]
    fn pausing_reversing_and_running_off_the_calendar() {
        let mut clock = Clock::at("2012-09-06T10:00Z").unwrap();
        clock.set_rate(3600.0);
        clock.pause();
        clock.advance(1.0);
        assert_eq!(clock.to_string(), "2012-09-06T10:00:00Z");
        clock.resume();
        clock.reverse();
        clock.advance(2.0);
        assert_eq!(clock.to_string(), "2012-09-06T08:00:00Z");
        clock.advance(f64::NAN);
        clock.set_rate(1e300);
        clock.advance(1.0);
        assert_eq!(clock.now(), Timestamp::MAX);
    }
}
