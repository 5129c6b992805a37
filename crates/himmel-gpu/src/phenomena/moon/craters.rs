//! The Moon's craters: a catalogue of places and diameters, and the shape that a fresh crater of a diameter has.

use glam::DVec3;

/// Bytes of a crater in a catalogue.
const BYTES: usize = 6;
/// The craters that Pike measured end at this diameter, km: wider ones have its depth and rim.
const WIDEST_KM: f64 = 300.0;

/// Why a catalogue of craters cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CratersError {
    /// Not a number of craters.
    #[error("a catalogue of craters has {BYTES} bytes for each, got {0}")]
    Length(usize),
    /// Not a place.
    #[error("crater {0} of the catalogue has a latitude of {1}°")]
    Latitude(usize, f64),
}

/// A crater.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crater {
    /// North positive, rad.
    pub latitude_rad: f64,
    /// East positive, 0..2π.
    pub longitude_rad: f64,
    /// From rim to rim.
    pub diameter_km: f64,
    /// Whether its floor is lava.
    pub lava: bool,
}

impl Crater {
    /// A catalogue as `xtask/data/moon_craters.py` writes it, the widest first.
    pub fn read(bytes: &[u8]) -> Result<Vec<Self>, CratersError> {
        if !bytes.len().is_multiple_of(BYTES) {
            return Err(CratersError::Length(bytes.len()));
        }
        let crater = |(index, row): (usize, &[u8])| {
            let latitude_deg = f64::from(i16::from_le_bytes([row[0], row[1]])) / 360.0;
            let diameter = u16::from_le_bytes([row[4], row[5]]);
            match latitude_deg.abs() <= 90.0 {
                false => Err(CratersError::Latitude(index, latitude_deg)),
                true => Ok(Self {
                    latitude_rad: latitude_deg.to_radians(),
                    longitude_rad: f64::from(u16::from_le_bytes([row[2], row[3]])) / 65536.0 * std::f64::consts::TAU,
                    diameter_km: f64::from(diameter & 0x7fff) / 50.0,
                    lava: diameter & 0x8000 != 0,
                }),
            }
        };
        bytes.chunks_exact(BYTES).enumerate().map(crater).collect()
    }

    /// Unit vector to its middle, in the Moon's frame.
    pub fn own(&self) -> DVec3 {
        let ((sin, cos), (sin_l, cos_l)) = (self.latitude_rad.sin_cos(), self.longitude_rad.sin_cos());
        DVec3::new(cos * cos_l, cos * sin_l, sin)
    }

    /// Its shape.
    pub fn shape(&self) -> CraterShape {
        CraterShape::fresh(self.diameter_km, self.lava)
    }
}

/// A round crater: a flat floor, a straight wall, a flank that falls as ejecta do. Kilometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CraterShape {
    /// From the middle to the rim's crest.
    pub radius_km: f64,
    /// From the crest down to the floor.
    pub depth_km: f64,
    /// From the ground around up to the crest.
    pub rim_height_km: f64,
    /// From the crest out to the flank's foot.
    pub rim_width_km: f64,
    /// From the middle to the wall's foot.
    pub floor_radius_km: f64,
}

impl CraterShape {
    /// Fresh craters, D their diameter in km   [pike1977]
    ///
    /// depth 0.196 D^1.010 or 1.044 D^0.301, rim height 0.036 D^1.014 or 0.236 D^0.399, rim width 0.257 D^1.011 or 0.467 D^0.836,
    /// whichever is less (they meet at 11, 21 and 30 km); floor diameter 0.031 D^1.765 to 20 km, 0.187 D^1.249 above.
    ///
    /// `lava`: the floor stands as high as the ground around.
    /// Laws tested: Copernicus 4.1 km deep, Tycho 4.0; simple craters a fifth of their diameter; the floor inside the rim.
    pub fn fresh(diameter_km: f64, lava: bool) -> Self {
        let d = diameter_km.clamp(1e-3, WIDEST_KM);
        let rim_height_km = (0.036 * d.powf(1.014)).min(0.236 * d.powf(0.399));
        let floor_km = if d < 20.0 { 0.031 * d.powf(1.765) } else { 0.187 * d.powf(1.249) };
        Self {
            radius_km: 0.5 * diameter_km,
            depth_km: if lava { rim_height_km } else { (0.196 * d.powf(1.010)).min(1.044 * d.powf(0.301)) },
            rim_height_km,
            rim_width_km: (0.257 * d.powf(1.011)).min(0.467 * d.powf(0.836)),
            floor_radius_km: 0.5 * diameter_km * (floor_km / d),
        }
    }

    /// From the middle to where the ground is as it was.
    pub fn reach_km(&self) -> f64 {
        self.radius_km + self.rim_width_km
    }

    /// Height at a distance from the middle, above the ground that was there, and what of that ground the crater has levelled:
    /// 1 on the floor, 0 from the crest outwards.
    ///
    /// The flank falls as ejecta do, with the third power of the distance [mcgetchin1973], down to nothing at its foot.
    pub fn at(&self, distance_km: f64) -> (f64, f64) {
        if distance_km < self.radius_km {
            let up = (distance_km - self.floor_radius_km) / (self.radius_km - self.floor_radius_km);
            let up = up.max(0.0);
            return (self.rim_height_km - self.depth_km * (1.0 - up), 1.0 - up);
        }
        let foot = (self.radius_km / self.reach_km()).powi(3);
        let ejecta = (self.radius_km / distance_km).powi(3);
        (self.rim_height_km * ((ejecta - foot) / (1.0 - foot)).max(0.0), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresh_craters_are_pikes() {
        for (name, diameter_km, depth_km, rim_km) in
            [("Copernicus", 96.07, 4.12, 1.46), ("Tycho", 85.29, 3.98, 1.39), ("Copernicus A", 3.219, 0.638, 0.118)]
        {
            let shape = CraterShape::fresh(diameter_km, false);
            println!("{name}: {shape:?}");
            assert!((shape.depth_km / depth_km - 1.0).abs() < 0.01, "{name}: {}", shape.depth_km);
            assert!((shape.rim_height_km / rim_km - 1.0).abs() < 0.01, "{name}: {}", shape.rim_height_km);
        }
        for step in 0..200 {
            let diameter_km = 3.0 * 1.0265f64.powi(step);
            let shape = CraterShape::fresh(diameter_km, false);
            assert!(shape.floor_radius_km < 0.8 * shape.radius_km && shape.rim_height_km < shape.depth_km);
            let ((floor, levelled), (crest, _)) = (shape.at(0.0), shape.at(shape.radius_km));
            assert!((crest - floor - shape.depth_km).abs() < 1e-9 && levelled == 1.0);
            assert!((crest - shape.rim_height_km).abs() < 1e-9 && shape.at(shape.reach_km()).0.abs() < 1e-9);
            assert!((shape.at(shape.radius_km - 1e-9).0 - crest).abs() < 1e-6, "no step at the crest");
            let ratio = shape.depth_km / diameter_km;
            assert!(diameter_km > 10.0 || (0.19..0.21).contains(&ratio), "{diameter_km}: {ratio}");
        }
        let plato = CraterShape::fresh(100.7, true);
        assert!(plato.at(0.0).0.abs() < 1e-9);
    }

    #[test]
    fn catalogues_that_are_broken_say_so() {
        assert_eq!(Crater::read(&[0; 7]), Err(CratersError::Length(7)));
        let error = Crater::read(&[0, 0, 0, 0, 1, 0, 0xff, 0x7f, 0, 0, 1, 0]).unwrap_err();
        assert!(error.to_string().contains("crater 1 of the catalogue has a latitude of 91"), "{error}");
        let [a, b] = &Crater::read(&[0, 0, 0, 64, 50, 0, 0x70, 0xfe, 0, 0, 50, 0x80]).unwrap()[..] else {
            panic!("two craters");
        };
        assert!((a.longitude_rad.to_degrees() - 90.0).abs() < 1e-9 && a.diameter_km == 1.0 && !a.lava);
        assert!((b.latitude_rad.to_degrees() + 400.0 / 360.0).abs() < 1e-9 && b.lava);
    }
}
