//! What a shader needs to move stars by itself: unit vectors and velocities once, two matrices and two vectors a frame.

use super::Star;
use crate::apparent::Observer;
use crate::constants::{AU_M, DAYS_PER_YEAR, J2000_JD, LIGHT_SPEED_M_S};
use glam::{DMat3, DVec3};

/// A star for the GPU: place at J2000.0 and motion. f32 keeps 0.02″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpuStar {
    /// Unit vector at J2000.0, ICRS.
    pub place: [f32; 3],
    /// Its change per Julian year.
    pub velocity_per_year: [f32; 3],
    /// Illuminance above the air in lx.
    pub illuminance_lx: f32,
    /// Temperature of the black body of its colour, 0 where unknown.
    pub temperature_k: f32,
}

impl From<&Star> for GpuStar {
    fn from(star: &Star) -> Self {
        let (place, velocity) = star.place_and_velocity();
        let at_2000 = (place + velocity * (2000.0 - star.epoch_year)).normalize();
        Self {
            place: at_2000.as_vec3().to_array(),
            velocity_per_year: velocity.as_vec3().to_array(),
            illuminance_lx: star.illuminance_lx() as f32,
            temperature_k: star.temperature_k().unwrap_or(0.0) as f32,
        }
    }
}

/// What all stars of one frame share. Parallax (0.8″ at most) and deflection (0.01″ at 45° from the Sun) are left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StarFrame {
    /// Years since J2000.0, to multiply the velocities by.
    pub years_since_j2000: f64,
    /// The observer's velocity by the speed of light, ICRS axes.
    pub beta: DVec3,
    /// Local east, north, up from ICRS axes.
    pub enu_from_icrs: DMat3,
    /// The observer from the barycentre in au, for whoever wants parallax: add −(parallax in rad) times this.
    pub observer_au: DVec3,
}

impl StarFrame {
    /// Of an observer.
    pub fn new(observer: &Observer<'_>) -> Self {
        Self {
            years_since_j2000: (observer.instant.tdb().jd() - J2000_JD) / DAYS_PER_YEAR,
            beta: observer.state.velocity_m_s / LIGHT_SPEED_M_S,
            enu_from_icrs: observer.place.enu_from_ecef() * observer.orientation.ecef_from_gcrs,
            observer_au: observer.state.position_m / AU_M,
        }
    }

    /// The f64 twin of what the shader does: airless direction along east, north, up.
    ///
    /// d = normalize(p + v t);  d′ = normalize(d + β + ½ (d·β) β − ½ β² d)
    pub fn direction_enu(&self, place: DVec3, velocity_per_year: DVec3) -> DVec3 {
        let d = (place + velocity_per_year * self.years_since_j2000).normalize();
        let along = d.dot(self.beta);
        let aberrated = d * (1.0 - 0.5 * self.beta.length_squared()) + self.beta * (1.0 + 0.5 * along);
        self.enu_from_icrs * aberrated.normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Catalogue;
    use super::*;
    use crate::{Fast, Instant, Place};

    /// Tolerance 0.9″: the largest parallax is 0.77″.
    #[test]
    fn the_shaders_path_agrees_with_the_full_one() {
        let place = Place::from_degrees(-30.0, 70.0, 0.0).unwrap();
        let observer = Observer::new(&Fast, &Instant::from_unix_seconds(1.6e9).unwrap(), &place).unwrap();
        let frame = StarFrame::new(&observer);
        let sun = observer.apparent(crate::Body::Sun).unwrap();
        for star in Catalogue::embedded().stars().iter().step_by(7) {
            let full = observer.apparent_star(star);
            if full.direction_enu.dot(sun.direction_enu) > 0.999 {
                continue;
            }
            let gpu = GpuStar::from(star);
            let direction = frame.direction_enu(
                glam::Vec3::from(gpu.place).as_dvec3(),
                glam::Vec3::from(gpu.velocity_per_year).as_dvec3(),
            );
            let arcsec = (direction - full.direction_enu).length().to_degrees() * 3600.0;
            assert!(arcsec < 0.9, "HIP {}: {arcsec}″", star.hip);
        }
    }
}
