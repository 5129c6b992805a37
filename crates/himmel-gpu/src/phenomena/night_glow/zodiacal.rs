//! Zodiacal light and gegenschein by the table of Leinert and others.

use glam::DVec3;

/// Ecliptic longitudes from the Sun of the table's rows, degrees.
const LONGITUDES: [f64; 19] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0, 135.0, 150.0, 165.0,
    180.0,
];
/// Ecliptic latitudes of its columns, degrees.
const LATITUDES: [f64; 11] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 45.0, 60.0, 75.0, 90.0];
/// At 500 nm, 1e-8 W m⁻² sr⁻¹ µm⁻¹   [leinert1998, table 17]; 0: not observable.
const TABLE: [[f64; 11]; 19] = [
    [0.0, 0.0, 0.0, 3140.0, 1610.0, 985.0, 640.0, 275.0, 150.0, 100.0, 77.0],
    [0.0, 0.0, 0.0, 2940.0, 1540.0, 945.0, 625.0, 271.0, 150.0, 100.0, 77.0],
    [0.0, 0.0, 4740.0, 2470.0, 1370.0, 865.0, 590.0, 264.0, 148.0, 100.0, 77.0],
    [11500.0, 6780.0, 3440.0, 1860.0, 1110.0, 755.0, 525.0, 251.0, 146.0, 100.0, 77.0],
    [6400.0, 4480.0, 2410.0, 1410.0, 910.0, 635.0, 454.0, 237.0, 141.0, 99.0, 77.0],
    [3840.0, 2830.0, 1730.0, 1100.0, 749.0, 545.0, 410.0, 223.0, 136.0, 97.0, 77.0],
    [2480.0, 1870.0, 1220.0, 845.0, 615.0, 467.0, 365.0, 207.0, 131.0, 95.0, 77.0],
    [1650.0, 1270.0, 910.0, 680.0, 510.0, 397.0, 320.0, 193.0, 125.0, 93.0, 77.0],
    [1180.0, 940.0, 700.0, 530.0, 416.0, 338.0, 282.0, 179.0, 120.0, 92.0, 77.0],
    [910.0, 730.0, 555.0, 442.0, 356.0, 292.0, 250.0, 166.0, 116.0, 90.0, 77.0],
    [505.0, 442.0, 352.0, 292.0, 243.0, 209.0, 183.0, 134.0, 104.0, 86.0, 77.0],
    [338.0, 317.0, 269.0, 227.0, 196.0, 172.0, 151.0, 116.0, 93.0, 82.0, 77.0],
    [259.0, 251.0, 225.0, 193.0, 166.0, 147.0, 132.0, 104.0, 86.0, 79.0, 77.0],
    [212.0, 210.0, 197.0, 170.0, 150.0, 133.0, 119.0, 96.0, 82.0, 77.0, 77.0],
    [188.0, 186.0, 177.0, 154.0, 138.0, 125.0, 113.0, 90.0, 77.0, 74.0, 77.0],
    [179.0, 178.0, 166.0, 147.0, 134.0, 122.0, 110.0, 90.0, 77.0, 73.0, 77.0],
    [179.0, 178.0, 165.0, 148.0, 137.0, 127.0, 116.0, 96.0, 79.0, 72.0, 77.0],
    [196.0, 192.0, 179.0, 165.0, 151.0, 141.0, 131.0, 104.0, 82.0, 72.0, 77.0],
    [230.0, 212.0, 195.0, 178.0, 163.0, 148.0, 134.0, 105.0, 83.0, 72.0, 77.0],
];
/// One S10 of the Sun's colour at 500 nm, in the table's unit   [leinert1998, table 2]
const S10_AT_500_NM: f64 = 1.28;
/// Brightness nearer to the Sun than the table: a power of elongation, as the F corona has it   [leinert1998, section 8.3]
const CORONA_POWER: f64 = -2.3;
/// Elongation that the power law holds to, degrees: nearer there is the corona proper.
const NEAREST_DEG: f64 = 2.5;

/// Nodes a degree apart of a table over longitude from the Sun (0..=180°) and latitude (0..=90°).
pub const SIZE: [usize; 2] = [181, 91];

/// Brightness at 500 nm in S10 a degree apart, `[latitude][longitude]`.
///
/// Between the table's nodes monotone cubics of the logarithm [fritsch1980], level where the table is symmetric: straight lines
/// show creases in a picture. What the table leaves out follows a power of elongation from its values at 15°.
///
/// Laws tested: the table's values at its nodes, no value outside its neighbours', S10 of gegenschein and pole.
pub fn s10_table() -> Vec<f64> {
    let filled: Vec<[f64; 11]> = (0..19).map(|row| std::array::from_fn(|column| node(row, column).ln())).collect();
    // Along latitude for each row, then along longitude.
    let rows: Vec<Vec<f64>> = filled
        .iter()
        .map(|row| (0..SIZE[1]).map(|beta| monotone_cubic(&LATITUDES, row, beta as f64)).collect())
        .collect();
    let mut table = Vec::with_capacity(SIZE[0] * SIZE[1]);
    for beta in 0..SIZE[1] {
        let column: [f64; 19] = std::array::from_fn(|row| rows[row][beta]);
        table.extend((0..SIZE[0]).map(|l| monotone_cubic(&LONGITUDES, &column, l as f64).exp() / S10_AT_500_NM));
    }
    table
}

fn node(row: usize, column: usize) -> f64 {
    let value = TABLE[row][column];
    if value > 0.0 {
        return value;
    }
    let (longitude, latitude) = (LONGITUDES[row], LATITUDES[column]);
    let distance = longitude.hypot(latitude).max(NEAREST_DEG);
    let sine_squared = (latitude * latitude / (longitude.hypot(latitude).powi(2)).max(1e-9)).min(1.0);
    // At 15°: 11,500 along the ecliptic, 3,140 across it.
    let at_15 = (TABLE[3][0].ln() * (1.0 - sine_squared) + TABLE[0][3].ln() * sine_squared).exp();
    at_15 * (distance / 15.0).powf(CORONA_POWER)
}

/// Interpolates with slopes that keep to the data   [fritsch1980]; level at both ends.
fn monotone_cubic<const N: usize>(x: &[f64; N], y: &[f64; N], at: f64) -> f64 {
    let last = N - 2;
    let i = x.iter().skip(1).position(|&node| at <= node).unwrap_or(last).min(last);
    let secant = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    let slope = |i: usize| {
        if i == 0 || i == N - 1 {
            return 0.0;
        }
        let (a, b) = (secant(i - 1), secant(i));
        if a * b <= 0.0 { 0.0 } else { 3.0 * a * b / (a + b + a.abs().max(b.abs()) * a.signum()) }
    };
    let h = x[i + 1] - x[i];
    let t = ((at - x[i]) / h).clamp(0.0, 1.0);
    let (m0, m1) = (slope(i) * h, slope(i + 1) * h);
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * y[i] + (t3 - 2.0 * t2 + t) * m0 + (3.0 * t2 - 2.0 * t3) * y[i + 1] + (t3 - t2) * m1
}

/// Redder than the Sun: brightness at a wavelength over that at 500 nm, relative to the Sun's   [leinert1998, eq. 22]
///
/// 1 + c lg(λ/500 nm); c at elongations of 30° and less 1.2 below 500 nm and 0.8 above, of 90° and more 0.9 and 0.6; straight
/// between.
pub fn reddening(wavelength_nm: f64, elongation_rad: f64) -> f64 {
    let share = ((elongation_rad.to_degrees() - 30.0) / 60.0).clamp(0.0, 1.0);
    let (near, far) = if wavelength_nm < 500.0 { (1.2, 0.9) } else { (0.8, 0.6) };
    1.0 + (near + (far - near) * share) * (wavelength_nm / 500.0).log10()
}

/// Texels of the folded table, across and down.
pub const FOLDED: [usize; 2] = [512, 256];

/// A place in the folded table, 0..1: (1 + x/s)/2 and |z|/s with s = |x| + |y| + |z|, the octahedron's map of a quarter of the
/// sphere. x to the Sun, z to the ecliptic's pole. It costs a shader eight operations, longitude and latitude sixty.
fn fold(ecliptic: DVec3) -> [f64; 2] {
    let [x, y, z] = [ecliptic.x, ecliptic.y.abs(), ecliptic.z.abs()];
    let sum = (x.abs() + y + z).max(f64::MIN_POSITIVE);
    [0.5 + 0.5 * x / sum, z / sum]
}

/// S10 times [`reddening`] at four wavelengths, as the shader samples it: rows of [`FOLDED`].
///
/// Beyond the triangle that is a quarter of the sphere its mirror image stands, as the sky has it on the other side.
pub fn four_table(wavelengths_nm: [f64; 4]) -> Vec<[f64; 4]> {
    let table = s10_table();
    let [width, height] = FOLDED;
    (0..height)
        .flat_map(|j| (0..width).map(move |i| (i, j)))
        .map(|(i, j)| {
            let (x, z) = (2.0 * (i as f64 + 0.5) / width as f64 - 1.0, (j as f64 + 0.5) / height as f64);
            let direction = DVec3::new(x, (1.0 - x.abs() - z).abs(), z).normalize_or(DVec3::X);
            let elongation = direction.x.clamp(-1.0, 1.0).acos();
            let s10 = at(&table, direction);
            wavelengths_nm.map(|nm| s10 * reddening(nm, elongation))
        })
        .collect()
}

/// Looks the table of longitude and latitude up, bilinear.
fn at(table: &[f64], ecliptic: DVec3) -> f64 {
    let x = ecliptic.y.abs().atan2(ecliptic.x).to_degrees().clamp(0.0, 180.0);
    let y = ecliptic.z.abs().min(1.0).asin().to_degrees();
    let (x0, y0) = ((x as usize).min(SIZE[0] - 2), (y as usize).min(SIZE[1] - 2));
    let (fx, fy) = (x - x0 as f64, y - y0 as f64);
    let node = |dx: usize, dy: usize| table[(y0 + dy) * SIZE[0] + x0 + dx];
    (node(0, 0) * (1.0 - fx) + node(1, 0) * fx) * (1.0 - fy) + (node(0, 1) * (1.0 - fx) + node(1, 1) * fx) * fy
}

/// Looks a folded table up as a sampler does. `ecliptic`: unit vector, x to the Sun, z to the ecliptic's pole.
pub fn look_up(table: &[[f64; 4]], ecliptic: DVec3) -> [f64; 4] {
    let [width, height] = FOLDED;
    let [u, v] = fold(ecliptic);
    let place = |c: f64, size: usize| (c * size as f64 - 0.5).clamp(0.0, (size - 1) as f64);
    let (x, y) = (place(u, width), place(v, height));
    let (x0, y0) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
    let (fx, fy) = (x - x0 as f64, y - y0 as f64);
    let at = |dx: usize, dy: usize| table.get((y0 + dy) * width + x0 + dx).copied().unwrap_or([0.0; 4]);
    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
    std::array::from_fn(|k| (a[k] * (1.0 - fx) + b[k] * fx) * (1.0 - fy) + (c[k] * (1.0 - fx) + d[k] * fx) * fy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_keep_their_values() {
        let table = s10_table();
        for (i, l) in LONGITUDES.iter().enumerate() {
            for (j, b) in LATITUDES.iter().enumerate() {
                if TABLE[i][j] > 0.0 {
                    let ours = table[*b as usize * SIZE[0] + *l as usize];
                    assert!((ours * S10_AT_500_NM / TABLE[i][j] - 1.0).abs() < 1e-12, "{l} {b}");
                }
            }
        }
        assert!(table.iter().all(|s10| s10.is_finite() && *s10 > 50.0));
    }

    /// [leinert1998]: pole 60 S10, gegenschein 180, at 30° from the Sun some 2,000.
    #[test]
    fn known_places() {
        let table = four_table([500.0; 4]);
        let at = |l: f64, b: f64| {
            let (l, b) = (l.to_radians(), b.to_radians());
            look_up(&table, DVec3::new(b.cos() * l.cos(), b.cos() * l.sin(), b.sin()))[0]
        };
        assert!((at(50.0, 90.0) - 60.0).abs() < 1.0);
        assert!((at(180.0, 0.0) - 180.0).abs() < 1.0);
        // Straight lines between texels of a third of a degree.
        assert!((at(30.0, 0.0) - 1940.0).abs() < 20.0, "{}", at(30.0, 0.0));
        // Both sides of the Sun and of the ecliptic are alike.
        assert_eq!(at(70.0, 20.0), at(-70.0, -20.0));
        // Between nodes nothing exceeds its neighbours.
        assert!(at(33.0, 0.0) < at(30.0, 0.0) && at(33.0, 0.0) > at(35.0, 0.0));
    }

    #[test]
    fn it_is_redder_than_the_sun() {
        let (blue, red) = (reddening(430.0, 0.5), reddening(630.0, 0.5));
        assert!((blue - 0.921).abs() < 1e-3 && (red - 1.080).abs() < 1e-3);
        assert_eq!(reddening(500.0, 2.0), 1.0);
    }
}
