//! The night on the command line: what is missing or broken is named, stands aside, and the sky still renders.

use crate::{himmel, listing};

const TLE: &str = "ISS (ZARYA)\n1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927\n\
                   2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537\n";

#[test]
fn what_is_broken_stands_aside_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).expect("written");
    write("old.tle", TLE.as_bytes());
    write("broken.tle", TLE.replace("51.6416", "5x.6416").as_bytes());
    write("binary", &[0xff, 0xfe, 0x00, 0x80]);
    write("header.csv", b"ra_deg,dec_deg\n1,2\n");
    write("rows.csv", b"ra_deg,dec_deg,v_magnitude\n83,-5,1\n83,-95,1\n");
    for (set, words) in [
        ("night.stars.catalogue=missing.csv", ["missing.csv", "stars stand aside"]),
        ("night.stars.catalogue=binary", ["binary", "stars stand aside"]),
        ("night.stars.catalogue=header.csv", ["header.csv", "v_magnitude"]),
        ("night.stars.catalogue=rows.csv", ["rows.csv", "line 3"]),
        ("night.planets.satellites=missing.tle", ["missing.tle", "stands aside"]),
        ("night.planets.satellites=old.tle", ["ISS (ZARYA)", "newer"]),
        ("night.planets.satellites=broken.tle", ["ISS (ZARYA)", "stands aside"]),
        ("night.planets.comet=Halley q=0.5", ["Halley", "stands aside"]),
        ("night.planets.comet=X q=1 e=1 i=1 node=1 peri=1 tp=2451545", ["m1", "stands aside"]),
    ] {
        let args = ["render", "--time", "2022-01-20T22:00Z", "--look", "S,30", "--size", "16x9", "-o", "night.png"];
        let output = himmel(folder.path(), &[&args[..], &["--set", set]].concat());
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{set}: {err}");
        assert!(words.iter().all(|word| err.contains(word)), "{set}: {err}");
        assert!(listing(folder.path()).contains(&"night.png".to_string()), "{set}");
        std::fs::remove_file(folder.path().join("night.png")).expect("removed");
    }
}
