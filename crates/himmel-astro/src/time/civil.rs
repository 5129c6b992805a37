//! Civil dates by the proleptic Gregorian calendar, with jiff.

use super::instant::malformed_time;
use crate::error::Result;

/// Seconds since 1970-01-01T00:00Z of an ISO 8601 text with `Z`, an offset, or neither (then UTC).
pub(super) fn unix_seconds_from_iso(text: &str) -> Result<f64> {
    let text = text.trim();
    if let Ok(t) = text.parse::<jiff::Timestamp>() {
        return Ok(t.as_second() as f64 + f64::from(t.subsec_nanosecond()) * 1e-9);
    }
    let bare = text.strip_suffix(['Z', 'z']).unwrap_or(text);
    let civil: jiff::civil::DateTime = bare
        .parse()
        .map_err(|_| malformed_time(text, "expected ISO 8601 as in 2012-09-06T18:00Z or 2012-09-06T20:00:00+02:00"))?;
    let t = jiff::tz::TimeZone::UTC
        .to_timestamp(civil)
        .map_err(|_| malformed_time(text, "the date lies outside the calendar's years -9999..=9999"))?;
    Ok(t.as_second() as f64 + f64::from(t.subsec_nanosecond()) * 1e-9)
}

/// The same text with 59 for 60 seconds, where it names a sixtieth second.
pub(super) fn split_leap_second(text: &str) -> Option<String> {
    let text = text.trim();
    let time = text.find(['T', 't', ' '])? + 1;
    let seconds = time + 5;
    (text.get(seconds..seconds + 3)? == ":60").then(|| format!("{}:59{}", &text[..seconds], &text[seconds + 3..]))
}

/// ISO 8601 in UTC to the millisecond; outside the years −9999..=9999 the Julian date.
pub(super) fn iso_from_unix_seconds(unix_s: f64) -> String {
    let milliseconds = (unix_s * 1000.0).round();
    match jiff::Timestamp::from_millisecond(milliseconds as i64) {
        Ok(t) => {
            let z = jiff::tz::TimeZone::UTC.to_datetime(t);
            let year = match z.year() {
                year @ 0..=9999 => format!("{year:04}"),
                year => format!("{year:+07}"),
            };
            format!(
                "{year}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z",
                z.month(),
                z.day(),
                z.hour(),
                z.minute(),
                z.second(),
                z.millisecond()
            )
        }
        Err(_) => format!("JD {}", unix_s / 86_400.0 + 2_440_587.5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_people_type() {
        assert_eq!(unix_seconds_from_iso("2012-09-06T18:00Z").unwrap(), 1_346_954_400.0);
        assert_eq!(unix_seconds_from_iso("2012-09-06T20:00:00+02:00").unwrap(), 1_346_954_400.0);
        assert_eq!(unix_seconds_from_iso("2012-09-06 18:00").unwrap(), 1_346_954_400.0);
        assert_eq!(unix_seconds_from_iso("1970-01-02").unwrap(), 86_400.0);
        assert_eq!(unix_seconds_from_iso("1970-01-01T00:00:00.25Z").unwrap(), 0.25);
        assert!(unix_seconds_from_iso("tomorrow").unwrap_err().to_string().contains("ISO 8601"));
    }

    #[test]
    fn writes_what_it_reads() {
        assert_eq!(iso_from_unix_seconds(1_346_954_400.0), "2012-09-06T18:00:00.000Z");
        assert_eq!(iso_from_unix_seconds(-109_500_000_000.0), "-001500-01-30T21:20:00.000Z");
        assert_eq!(unix_seconds_from_iso("-001500-01-30T21:20:00.000Z").unwrap(), -109_500_000_000.0);
        assert!(iso_from_unix_seconds(1e18).starts_with("JD"));
    }
}
