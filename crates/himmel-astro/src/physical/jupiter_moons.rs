//! Jupiter's four great moons by Lieske's theory E5, as Meeus gives it   [lieske1987; meeus1998, ch. 44].
//!
//! The series below were taken over by machine from npm `astronomia` 4.2.0 (MIT); letters as in the book.

use crate::apparent::{Apparent, Observer};
use crate::body::Body;
use crate::constants::AU_M;
use crate::earth::{PrecessionAngles, axes_turned_x, axes_turned_z};
use crate::error::Result;
use crate::time::JulianDateTdb;
use glam::DVec3;

/// Io, Europa, Ganymede, Callisto.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum GalileanMoon {
    Io,
    Europa,
    Ganymede,
    Callisto,
}

impl GalileanMoon {
    /// All four, inside out.
    pub const ALL: [Self; 4] = [Self::Io, Self::Europa, Self::Ganymede, Self::Callisto];

    /// Mean radius in m   [archinal2018].
    pub fn radius_m(self) -> f64 {
        [1_821_490.0, 1_560_800.0, 2_631_200.0, 2_410_300.0][self as usize]
    }

    /// Visual magnitude at 1 au from Sun and observer   [almanac2006].
    fn absolute_magnitude(self) -> f64 {
        [-1.68, -1.41, -2.09, -1.05][self as usize]
    }
}

/// How a moon of Jupiter is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GalileanView {
    /// Place, distance, diameter.
    pub seen: Apparent,
    /// Nearer to the observer than Jupiter's centre.
    pub in_front: bool,
    /// Visual magnitude, phase left out (0.1 at most).
    pub magnitude: f64,
}

/// The theory's unit of length: Jupiter's equatorial radius   [lieske1987].
const JUPITER_RADIUS_M: f64 = 71_420e3;
const P: f64 = std::f64::consts::PI / 180.0;

fn sin(x: f64) -> f64 {
    x.sin()
}
fn cos(x: f64) -> f64 {
    x.cos()
}
fn atan(x: f64) -> f64 {
    x.atan()
}

/// The moons from Jupiter's centre, m along GCRS axes, at an instant there; some hundred km.
pub fn galilean_moons_m(tdb: JulianDateTdb) -> [DVec3; 4] {
    let t = tdb.jd() - 2_443_000.5;
    let l1 = 106.07719 * P + 203.48895579 * P * t;

    let l2 = 175.73161 * P + 101.374724735 * P * t;

    let l3 = 120.55883 * P + 50.317609207 * P * t;

    let l4 = 84.44459 * P + 21.571071177 * P * t;

    let w1 = 97.0881 * P + 0.16138586 * P * t;

    let w2 = 154.8663 * P + 0.04726307 * P * t;

    let w3 = 188.184 * P + 0.00712734 * P * t;

    let w4 = 335.2868 * P + 0.00184 * P * t;

    let node1 = 312.3346 * P - 0.13279386 * P * t;

    let node2 = 100.4411 * P - 0.03263064 * P * t;

    let node3 = 119.1942 * P - 0.00717703 * P * t;

    let node4 = 322.6186 * P - 0.00175934 * P * t;

    let gamma = 0.33033 * P * sin(163.679 * P + 0.0010512 * P * t) + 0.03439 * P * sin(34.486 * P - 0.0161731 * P * t);

    let phi_lambda = 199.6766 * P + 0.1737919 * P * t;

    let psi = 316.5182 * P - 0.00000208 * P * t;

    let g = 30.23756 * P + 0.0830925701 * P * t + gamma;

    let g_saturn = 31.97853 * P + 0.0334597339 * P * t;

    let peri = 13.469942 * P;

    let sigma1 = 0.47259 * P * sin(2.0 * (l1 - l2))
        + -0.03478 * P * sin(w3 - w4)
        + 0.01081 * P * sin(l2 - 2.0 * l3 + w3)
        + 0.00738 * P * sin(phi_lambda)
        + 0.00713 * P * sin(l2 - 2.0 * l3 + w2)
        + -0.00674 * P * sin(w1 + w3 - 2.0 * peri - 2.0 * g)
        + 0.00666 * P * sin(l2 - 2.0 * l3 + w4)
        + 0.00445 * P * sin(l1 - w3)
        + -0.00354 * P * sin(l1 - l2)
        + -0.00317 * P * sin(2.0 * psi - 2.0 * peri)
        + 0.00265 * P * sin(l1 - w4)
        + -0.00186 * P * sin(g)
        + 0.00162 * P * sin(w2 - w3)
        + 0.00158 * P * sin(4.0 * (l1 - l2))
        + -0.00155 * P * sin(l1 - l3)
        + -0.00138 * P * sin(psi + node3 - 2.0 * peri - 2.0 * g)
        + -0.00115 * P * sin(2.0 * (l1 - 2.0 * l2 + node2))
        + 0.00089 * P * sin(w2 - w4)
        + 0.00085 * P * sin(l1 + w3 - 2.0 * peri - 2.0 * g)
        + 0.00083 * P * sin(node2 - node3)
        + 0.00053 * P * sin(psi - node2);

    let sigma2 = 1.06476 * P * sin(2.0 * (l2 - l3))
        + 0.04256 * P * sin(l1 - 2.0 * l2 + w3)
        + 0.03581 * P * sin(l2 - w3)
        + 0.02395 * P * sin(l1 - 2.0 * l2 + w4)
        + 0.01984 * P * sin(l2 - w4)
        + -0.01778 * P * sin(phi_lambda)
        + 0.01654 * P * sin(l2 - w2)
        + 0.01334 * P * sin(l2 - 2.0 * l3 + w2)
        + 0.01294 * P * sin(w3 - w4)
        + -0.01142 * P * sin(l2 - l3)
        + -0.01057 * P * sin(g)
        + -0.00775 * P * sin(2.0 * (psi - peri))
        + 0.00524 * P * sin(2.0 * (l1 - l2))
        + -0.0046 * P * sin(l1 - l3)
        + 0.00316 * P * sin(psi - 2.0 * g + node3 - 2.0 * peri)
        + -0.00203 * P * sin(w1 + w3 - 2.0 * peri - 2.0 * g)
        + 0.00146 * P * sin(psi - node3)
        + -0.00145 * P * sin(2.0 * g)
        + 0.00125 * P * sin(psi - node4)
        + -0.00115 * P * sin(l1 - 2.0 * l3 + w3)
        + -0.00094 * P * sin(2.0 * (l2 - node2))
        + 0.00086 * P * sin(2.0 * (l1 - 2.0 * l2 + node2))
        + -0.00086 * P * sin(5.0 * g_saturn - 2.0 * g + 52.225 * P)
        + -0.00078 * P * sin(l2 - l4)
        + -0.00064 * P * sin(3.0 * l3 - 7.0 * l4 + 4.0 * w4)
        + 0.00064 * P * sin(w1 - w4)
        + -0.00063 * P * sin(l1 - 2.0 * l3 + w4)
        + 0.00058 * P * sin(node3 - node4)
        + 0.00056 * P * sin(2.0 * (psi - peri - g))
        + 0.00056 * P * sin(2.0 * (l2 - l4))
        + 0.00055 * P * sin(2.0 * (l1 - l3))
        + 0.00052 * P * sin(3.0 * l3 - 7.0 * l4 + w3 + 3.0 * w4)
        + -0.00043 * P * sin(l1 - w3)
        + 0.00041 * P * sin(5.0 * (l2 - l3))
        + 0.00041 * P * sin(w4 - peri)
        + 0.00032 * P * sin(node2 - node3)
        + 0.00032 * P * sin(2.0 * (l3 - g - peri));

    let sigma3 = 0.1649 * P * sin(l3 - w3)
        + 0.09081 * P * sin(l3 - w4)
        + -0.06907 * P * sin(l2 - l3)
        + 0.03784 * P * sin(w3 - w4)
        + 0.01846 * P * sin(2.0 * (l3 - l4))
        + -0.0134 * P * sin(g)
        + -0.01014 * P * sin(2.0 * (psi - peri))
        + 0.00704 * P * sin(l2 - 2.0 * l3 + w3)
        + -0.0062 * P * sin(l2 - 2.0 * l3 + w2)
        + -0.00541 * P * sin(l3 - l4)
        + 0.00381 * P * sin(l2 - 2.0 * l3 + w4)
        + 0.00235 * P * sin(psi - node3)
        + 0.00198 * P * sin(psi - node4)
        + 0.00176 * P * sin(phi_lambda)
        + 0.0013 * P * sin(3.0 * (l3 - l4))
        + 0.00125 * P * sin(l1 - l3)
        + -0.00119 * P * sin(5.0 * g_saturn - 2.0 * g + 52.225 * P)
        + 0.00109 * P * sin(l1 - l2)
        + -0.001 * P * sin(3.0 * l3 - 7.0 * l4 + 4.0 * w4)
        + 0.00091 * P * sin(node3 - node4)
        + 0.0008 * P * sin(3.0 * l3 - 7.0 * l4 + w3 + 3.0 * w4)
        + -0.00075 * P * sin(2.0 * l2 - 3.0 * l3 + w3)
        + 0.00072 * P * sin(w1 + w3 - 2.0 * peri - 2.0 * g)
        + 0.00069 * P * sin(w4 - peri)
        + -0.00058 * P * sin(2.0 * l3 - 3.0 * l4 + w4)
        + -0.00057 * P * sin(l3 - 2.0 * l4 + w4)
        + 0.00056 * P * sin(l3 + w3 - 2.0 * peri - 2.0 * g)
        + -0.00052 * P * sin(l2 - 2.0 * l3 + w1)
        + -0.00050 * P * sin(w2 - w3)
        + 0.00048 * P * sin(l3 - 2.0 * l4 + w3)
        + -0.00045 * P * sin(2.0 * l2 - 3.0 * l3 + w4)
        + -0.00041 * P * sin(w2 - w4)
        + -0.00038 * P * sin(2.0 * g)
        + -0.00037 * P * sin(w3 - w4 + node3 - node4)
        + -0.00032 * P * sin(3.0 * l3 - 7.0 * l4 + 2.0 * w3 + 2.0 * w4)
        + 0.0003 * P * sin(4.0 * (l3 - l4))
        + 0.00029 * P * sin(l3 + w4 - 2.0 * peri - 2.0 * g)
        + -0.00028 * P * sin(node3 + psi - 2.0 * peri - 2.0 * g)
        + 0.00026 * P * sin(l3 - peri - g)
        + 0.00024 * P * sin(l2 - 3.0 * l3 + 2.0 * l4)
        + 0.00021 * P * sin(2.0 * (l3 - peri - g))
        + -0.00021 * P * sin(l3 - w2)
        + 0.00017 * P * sin(2.0 * (l3 - w3));

    let sigma4 = 0.84287 * P * sin(l4 - w4)
        + 0.03431 * P * sin(w4 - w3)
        + -0.03305 * P * sin(2.0 * (psi - peri))
        + -0.03211 * P * sin(g)
        + -0.01862 * P * sin(l4 - w3)
        + 0.01186 * P * sin(psi - node4)
        + 0.00623 * P * sin(l4 + w4 - 2.0 * g - 2.0 * peri)
        + 0.00387 * P * sin(2.0 * (l4 - w4))
        + -0.00284 * P * sin(5.0 * g_saturn - 2.0 * g + 52.225 * P)
        + -0.00234 * P * sin(2.0 * (psi - w4))
        + -0.00223 * P * sin(l3 - l4)
        + -0.00208 * P * sin(l4 - peri)
        + 0.00178 * P * sin(psi + node4 - 2.0 * w4)
        + 0.00134 * P * sin(w4 - peri)
        + 0.00125 * P * sin(2.0 * (l4 - g - peri))
        + -0.00117 * P * sin(2.0 * g)
        + -0.00112 * P * sin(2.0 * (l3 - l4))
        + 0.00107 * P * sin(3.0 * l3 - 7.0 * l4 + 4.0 * w4)
        + 0.00102 * P * sin(l4 - g - peri)
        + 0.00096 * P * sin(2.0 * l4 - psi - node4)
        + 0.00087 * P * sin(2.0 * (psi - node4))
        + -0.00085 * P * sin(3.0 * l3 - 7.0 * l4 + w3 + 3.0 * w4)
        + 0.00085 * P * sin(l3 - 2.0 * l4 + w4)
        + -0.00081 * P * sin(2.0 * (l4 - psi))
        + 0.00071 * P * sin(l4 + w4 - 2.0 * peri - 3.0 * g)
        + 0.00061 * P * sin(l1 - l4)
        + -0.00056 * P * sin(psi - node3)
        + -0.00054 * P * sin(l3 - 2.0 * l4 + w3)
        + 0.00051 * P * sin(l2 - l4)
        + 0.00042 * P * sin(2.0 * (psi - g - peri))
        + 0.00039 * P * sin(2.0 * (w4 - node4))
        + 0.00036 * P * sin(psi + peri - w4 - node4)
        + 0.00035 * P * sin(2.0 * g_saturn - g + 188.37 * P)
        + -0.00035 * P * sin(l4 - w4 + 2.0 * peri - 2.0 * psi)
        + -0.00032 * P * sin(l4 + w4 - 2.0 * peri - g)
        + 0.0003 * P * sin(2.0 * g_saturn - 2.0 * g + 149.15 * P)
        + 0.00029 * P * sin(3.0 * l3 - 7.0 * l4 + 2.0 * w3 + 2.0 * w4)
        + 0.00028 * P * sin(l4 - w4 + 2.0 * psi - 2.0 * peri)
        + -0.00028 * P * sin(2.0 * (l4 - node4))
        + -0.00027 * P * sin(w3 - w4 + node3 - node4)
        + -0.00026 * P * sin(5.0 * g_saturn - 3.0 * g + 188.37 * P)
        + 0.00025 * P * sin(node4 - node3)
        + -0.00025 * P * sin(l2 - 3.0 * l3 + 2.0 * l4)
        + -0.00023 * P * sin(3.0 * (l3 - l4))
        + 0.00021 * P * sin(2.0 * l4 - 2.0 * peri - 3.0 * g)
        + -0.00021 * P * sin(2.0 * l3 - 3.0 * l4 + w4)
        + 0.00019 * P * sin(l4 - w4 - g)
        + -0.00019 * P * sin(2.0 * l4 - w3 - w4)
        + -0.00018 * P * sin(l4 - w4 + g)
        + -0.00016 * P * sin(l4 + w3 - 2.0 * peri - 2.0 * g);

    let long1 = l1 + sigma1;

    let long2 = l2 + sigma2;

    let long3 = l3 + sigma3;

    let long4 = l4 + sigma4;

    let long = [long1, long2, long3, long4];
    let latitude: [f64; 4] = [
        atan(
            0.0006393 * sin(long1 - node1)
                + 0.0001825 * sin(long1 - node2)
                + 0.0000329 * sin(long1 - node3)
                + -0.0000311 * sin(long1 - psi)
                + 0.0000093 * sin(long1 - node4)
                + 0.0000075 * sin(3.0 * long1 - 4.0 * l2 - 1.9927 * sigma1 + node2)
                + 0.0000046 * sin(long1 + psi - 2.0 * peri - 2.0 * g),
        ),
        atan(
            0.0081004 * sin(long2 - node2)
                + 0.0004512 * sin(long2 - node3)
                + -0.0003284 * sin(long2 - psi)
                + 0.0001160 * sin(long2 - node4)
                + 0.0000272 * sin(l1 - 2.0 * l3 + 1.0146 * sigma2 + node2)
                + -0.0000144 * sin(long2 - node1)
                + 0.0000143 * sin(long2 + psi - 2.0 * peri - 2.0 * g)
                + 0.0000035 * sin(long2 - psi + g)
                + -0.0000028 * sin(l1 - 2.0 * l3 + 1.0146 * sigma2 + node3),
        ),
        atan(
            0.0032402 * sin(long3 - node3)
                + -0.0016911 * sin(long3 - psi)
                + 0.0006847 * sin(long3 - node4)
                + -0.0002797 * sin(long3 - node2)
                + 0.0000321 * sin(long3 + psi - 2.0 * peri - 2.0 * g)
                + 0.0000051 * sin(long3 - psi + g)
                + -0.0000045 * sin(long3 - psi - g)
                + -0.0000045 * sin(long3 + psi - 2.0 * peri)
                + 0.0000037 * sin(long3 + psi - 2.0 * peri - 3.0 * g)
                + 0.000003 * sin(2.0 * l2 - 3.0 * long3 + 4.03 * sigma3 + node2)
                + -0.0000021 * sin(2.0 * l2 - 3.0 * long3 + 4.03 * sigma3 + node3),
        ),
        atan(
            -0.0076579 * sin(long4 - psi)
                + 0.0044134 * sin(long4 - node4)
                + -0.0005112 * sin(long4 - node3)
                + 0.0000773 * sin(long4 + psi - 2.0 * peri - 2.0 * g)
                + 0.0000104 * sin(long4 - psi + g)
                + -0.0000102 * sin(long4 - psi - g)
                + 0.0000088 * sin(long4 + psi - 2.0 * peri - 3.0 * g)
                + -0.0000038 * sin(long4 + psi - 2.0 * peri - g),
        ),
    ];
    let radius: [f64; 4] = [
        5.90569
            * (1.0
                + -0.0041339 * cos(2.0 * (l1 - l2))
                + -0.0000387 * cos(l1 - w3)
                + -0.0000214 * cos(l1 - w4)
                + 0.000017 * cos(l1 - l2)
                + -0.0000131 * cos(4.0 * (l1 - l2))
                + 0.0000106 * cos(l1 - l3)
                + -0.0000066 * cos(l1 + w3 - 2.0 * peri - 2.0 * g)),
        9.39657
            * (1.0
                + 0.0093848 * cos(l1 - l2)
                + -0.0003116 * cos(l2 - w3)
                + -0.0001744 * cos(l2 - w4)
                + -0.0001442 * cos(l2 - w2)
                + 0.0000553 * cos(l2 - l3)
                + 0.0000523 * cos(l1 - l3)
                + -0.0000290 * cos(2.0 * (l1 - l2))
                + 0.0000164 * cos(2.0 * (l2 - node2))
                + 0.0000107 * cos(l1 - 2.0 * l3 + w3)
                + -0.0000102 * cos(l2 - w1)
                + -0.0000091 * cos(2.0 * (l1 - l3))),
        14.98832
            * (1.0
                + -0.0014388 * cos(l3 - w3)
                + -0.0007917 * cos(l3 - w4)
                + 0.0006342 * cos(l2 - l3)
                + -0.0001761 * cos(2.0 * (l3 - l4))
                + 0.0000294 * cos(l3 - l4)
                + -0.0000156 * cos(3.0 * (l3 - l4))
                + 0.0000156 * cos(l1 - l3)
                + -0.0000153 * cos(l1 - l2)
                + 0.000007 * cos(2.0 * l2 - 3.0 * l3 + w3)
                + -0.0000051 * cos(l3 + w3 - 2.0 * peri - 2.0 * g)),
        26.36273
            * (1.0
                + -0.0073546 * cos(l4 - w4)
                + 0.0001621 * cos(l4 - w3)
                + 0.0000974 * cos(l3 - l4)
                + -0.0000543 * cos(l4 + w4 - 2.0 * peri - 2.0 * g)
                + -0.0000271 * cos(2.0 * (l4 - w4))
                + 0.0000182 * cos(l4 - peri)
                + 0.0000177 * cos(2.0 * (l3 - l4))
                + -0.0000167 * cos(2.0 * l4 - psi - node4)
                + 0.0000167 * cos(psi - node4)
                + -0.0000155 * cos(2.0 * (l4 - peri - g))
                + 0.0000142 * cos(2.0 * (l4 - psi))
                + 0.0000105 * cos(l1 - l4)
                + 0.0000092 * cos(l2 - l4)
                + -0.0000089 * cos(l4 - peri - g)
                + -0.0000062 * cos(l4 + w4 - 2.0 * peri - 3.0 * g)
                + 0.0000048 * cos(2.0 * (l4 - node4))),
    ];
    // Precession from 1950.0 to the date; the node of Jupiter's equator on its orbit goes with it.
    let t0 = (tdb.jd() - 2_433_282.423) / 36_525.0;
    let precession = (1.396_662_6 + 0.000_308_8 * t0) * t0 * P;
    let psi = psi + precession;
    let t1900 = (tdb.jd() - 2_415_020.0) / 36_525.0;
    let equator_on_orbit = (3.120_262 + 0.000_6 * t1900) * P;
    let century = tdb.centuries_since_j2000();
    let node = (100.464_407 + 1.020_977_4 * century + 0.000_403_15 * century * century) * P;
    let inclination = (1.303_267 - 0.005_496_5 * century + 0.000_004_66 * century * century) * P;
    // Jupiter's equator → its orbit → the ecliptic of date → GCRS.
    let angles = PrecessionAngles::at(tdb.to_tt());
    let ecliptic_from_gcrs =
        axes_turned_z(-angles.psi_bar_rad) * axes_turned_x(angles.phi_bar_rad) * axes_turned_z(angles.gamma_bar_rad);
    let gcrs_from_equator = ecliptic_from_gcrs.transpose()
        * axes_turned_z(-node)
        * axes_turned_x(-inclination)
        * axes_turned_z(node - psi)
        * axes_turned_x(-equator_on_orbit);
    std::array::from_fn(|i| {
        let (sin_l, cos_l) = (long[i] + precession - psi).sin_cos();
        let (sin_b, cos_b) = latitude[i].sin_cos();
        gcrs_from_equator * DVec3::new(cos_l * cos_b, sin_l * cos_b, sin_b) * (radius[i] * JUPITER_RADIUS_M)
    })
}

impl Observer<'_> {
    /// Jupiter's four moons, inside out. The light time to Jupiter's centre is taken for all (0.03″).
    pub fn galilean_moons(&self) -> Result<[GalileanView; 4]> {
        let (jupiter, light_way_m) = self.light_time_vector(Body::Jupiter)?;
        let then = JulianDateTdb::new(
            self.instant.tdb().jd()
                - light_way_m / crate::constants::LIGHT_SPEED_M_S / crate::constants::SECONDS_PER_DAY,
        )?;
        let offsets = galilean_moons_m(then);
        Ok(GalileanMoon::ALL.map(|moon| {
            let vector = jupiter + offsets[moon as usize];
            let distance_m = vector.length();
            let mut seen = self.seen(self.aberrated(self.deflected(vector / distance_m, Some(vector))));
            seen.distance_m = distance_m;
            seen.vector_m = vector;
            seen.angular_diameter_rad = 2.0 * (moon.radius_m() / distance_m).asin();
            let sun_distance_m = (self.state.position_m + vector - self.sun.position_m).length();
            GalileanView {
                seen,
                in_front: distance_m < jupiter.length(),
                magnitude: moon.absolute_magnitude() + 5.0 * (sun_distance_m / AU_M * distance_m / AU_M).log10(),
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instant, Place, Precise};

    /// [meeus1998, example 44.b]: 1992-12-16 0h UT, in Jupiter's radii, x west, y north along Jupiter's axis. Tolerance 0.01.
    #[test]
    fn moons_of_meeus() {
        let tt = crate::time::JulianDateTt::new(2_448_972.500_68).unwrap();
        let instant = Instant::from_tt(tt, crate::time::DeltaTModel::Standard);
        let precise = Precise::embedded().unwrap();
        let observer = Observer::new(&precise, &instant, &Place::GREENWICH_EQUATOR).unwrap();
        let jupiter = observer.apparent(Body::Jupiter).unwrap();
        let (ra, dec) = (268.057_f64.to_radians(), 64.495_f64.to_radians());
        let pole = DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin());
        let west = jupiter.direction_gcrs.cross(pole).normalize();
        let north = west.cross(jupiter.direction_gcrs);
        let radius = JUPITER_RADIUS_M / jupiter.distance_m;
        let expected = [(-3.4503, 0.2137), (7.4418, 0.2753), (1.2011, 0.5900), (7.0720, 1.0291)];
        for (view, (x, y)) in observer.galilean_moons().unwrap().iter().zip(expected) {
            let offset = (view.seen.direction_gcrs - jupiter.direction_gcrs) / radius;
            assert!((offset.dot(west) - x).abs() < 0.01, "{} {x}", offset.dot(west));
            assert!((offset.dot(north) - y).abs() < 0.01, "{} {y}", offset.dot(north));
            assert!((3.0..8.0).contains(&view.magnitude));
        }
    }
}
