use crate::constants::{EARTH_ROTATION_RAD_S, WGS84_EQUATORIAL_RADIUS_M, WGS84_FLATTENING};
use crate::error::{AstroError, Result, in_range};
use glam::{DMat3, DVec3};

/// A point fixed to the Earth: WGS84 latitude, longitude and height above the ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    latitude_rad: f64,
    longitude_rad: f64,
    height_m: f64,
}

impl Place {
    /// Latitude in −90..=90° (north positive), longitude in −360..=360° (east positive), height above the
    /// ellipsoid from −12 km to 10 million km.
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Result<Self> {
        let swapped = if latitude_deg.abs() <= 360.0 && longitude_deg.abs() <= 90.0 {
            " (are latitude and longitude swapped?)"
        } else {
            ""
        };
        in_range("latitude", "-90..=90 degrees", latitude_deg, -90.0, 90.0, swapped)?;
        in_range("longitude", "-360..=360 degrees, east positive", longitude_deg, -360.0, 360.0, "")?;
        in_range("height", "-12000..=1e10 m", height_m, -12_000.0, 1e10, "")?;
        Ok(Self { latitude_rad: latitude_deg.to_radians(), longitude_rad: longitude_deg.to_radians(), height_m })
    }

    /// Reads `latitude,longitude[,height_m]` in degrees, for example `52.4,13.06,35`.
    pub fn parse(text: &str) -> Result<Self> {
        let malformed = |reason: &str| AstroError::Malformed {
            what: "place",
            text: crate::error::shown(text),
            reason: reason.to_owned(),
        };
        let mut numbers = [0.0; 3];
        let mut count = 0;
        for part in text.split(',') {
            let slot = numbers.get_mut(count).ok_or_else(|| malformed("expected latitude,longitude[,height_m]"))?;
            *slot = part
                .trim()
                .parse()
                .map_err(|_| malformed("expected numbers as in 52.4,13.06,35 (degrees, degrees, metres)"))?;
            count += 1;
        }
        if count < 2 {
            return Err(malformed("expected latitude,longitude[,height_m]"));
        }
        Self::from_degrees(numbers[0], numbers[1], numbers[2])
    }

    /// Geodetic latitude, north positive.
    pub fn latitude_rad(&self) -> f64 {
        self.latitude_rad
    }

    /// Longitude, east positive.
    pub fn longitude_rad(&self) -> f64 {
        self.longitude_rad
    }

    /// Height above the ellipsoid.
    pub fn height_m(&self) -> f64 {
        self.height_m
    }

    /// Position in the Earth-fixed frame (ITRS axes, m).
    ///
    /// x = (N + h) cos φ cos λ,  z = (N (1 − e²) + h) sin φ,  N = a / √(1 − e² sin² φ)   [wgs84]
    ///
    /// Laws tested: on the equator r = a + h; at a pole r = b + h.
    pub fn ecef_m(&self) -> DVec3 {
        let e2 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        let n = WGS84_EQUATORIAL_RADIUS_M / (1.0 - e2 * sin_lat * sin_lat).sqrt();
        let rho = (n + self.height_m) * cos_lat;
        DVec3::new(rho * cos_lon, rho * sin_lon, (n * (1.0 - e2) + self.height_m) * sin_lat)
    }

    /// Velocity of the place in the inertial frame that has the Earth-fixed axes at this instant (m/s).
    pub fn ecef_velocity_m_s(&self) -> DVec3 {
        let p = self.ecef_m();
        DVec3::new(-p.y, p.x, 0.0) * EARTH_ROTATION_RAD_S
    }

    /// Rotation from Earth-fixed axes to local east, north, up (up along the ellipsoid's normal).
    pub fn enu_from_ecef(&self) -> DMat3 {
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        let east = DVec3::new(-sin_lon, cos_lon, 0.0);
        let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
        let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        DMat3::from_cols(east, north, up).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equator_and_pole_have_the_two_radii() {
        let equator = Place::from_degrees(0.0, 90.0, 100.0).unwrap().ecef_m();
        assert!((equator - DVec3::new(0.0, 6_378_237.0, 0.0)).length() < 1e-6);
        let pole = Place::from_degrees(-90.0, 0.0, 0.0).unwrap().ecef_m();
        assert!((pole.z + 6_356_752.314_245).abs() < 1e-5);
    }

    #[test]
    fn absurd_places_are_refused_with_a_reason() {
        for (lat, lon, h) in [(90.1, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (0.0, f64::INFINITY, 0.0), (0.0, 0.0, -1e5)] {
            assert!(Place::from_degrees(lat, lon, h).is_err());
        }
        let swapped = Place::from_degrees(139.7, 35.7, 0.0).unwrap_err().to_string();
        assert!(swapped.contains("swapped"), "{swapped}");
        assert!(Place::parse("52.4").is_err());
        assert!(Place::parse("52.4,13.06,35,1").is_err());
        assert!(Place::parse(" 52.4, 13.06 ").is_ok());
    }

    #[test]
    fn up_points_away_from_the_centre() {
        let p = Place::from_degrees(48.0, 9.0, 0.0).unwrap();
        let enu = p.enu_from_ecef() * p.ecef_m();
        assert!(enu.z > 6.36e6 && enu.x.abs() < 1e-6);
    }
}
