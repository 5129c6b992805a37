//! A dusk frame by frame, each at its own exposure: nothing jumps, nothing pumps.

use himmel::{Output, Pixels, Still};
use himmel_tests::{gpu, model};

/// Every half degree from +6° to −12°, as an eye sees it. A jump shows in the second difference of the exposure: a smooth dusk
/// has less than a tenth of a stop. And the picture never grows brighter while the light falls, but for rounding.
#[test]
fn a_dusk_does_not_pump() {
    let at = |step: i32| {
        let altitude = format!("{}", 6.0 - 0.5 * f64::from(step));
        let size = [("output.width_px", "64"), ("output.height_px", "36"), ("output.tonemap", "eye")];
        let sun =
            [("light.sun.altitude_deg", altitude.as_str()), ("light.sun.azimuth_deg", "270"), ("camera.look", "N")];
        model("earth", &[size.as_slice(), sun.as_slice(), &[("air.quality", "low")]].concat())
    };
    let first = at(0);
    let mut still = Still::new(gpu(), Output::Display, first.atmosphere()).unwrap();
    let view = first.view().unwrap();
    let (mut ev, mut means) = (Vec::new(), Vec::new());
    for step in 0..=36 {
        let picture = still.render(&at(step).frame().unwrap(), &view, 64, 36, &mut |_| true).unwrap();
        let Pixels::Display(rgb) = picture.pixels else { panic!("a finished picture was asked for") };
        means.push(rgb.iter().map(|byte| f64::from(*byte)).sum::<f64>() / rgb.len() as f64);
        ev.push(picture.ev100);
    }
    for three in ev.windows(3) {
        let bend = three[0] - 2.0 * three[1] + three[2];
        assert!(three[1] < three[0] && bend.abs() < 0.25, "{bend}: {ev:.2?}");
    }
    for two in means.windows(2) {
        assert!(two[1] < two[0] + 1.0 && two[0] - two[1] < 12.0, "{means:.1?}");
    }
    println!("EV {:.2} to {:.2}, mean of the picture {:.0} to {:.0}", ev[0], ev[36], means[0], means[36]);
}
