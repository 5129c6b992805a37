//! What is on them.

/// Names and values of parameters.
type Settings = &'static [(&'static str, &'static str)];

/// One picture of one or more tiles.
pub struct Sheet {
    /// Its name, and its file's.
    pub name: &'static str,
    pub preset: &'static str,
    /// Of each tile, pixels.
    pub size: [u32; 2],
    /// The tracer's tiles beside ours are traced this many times smaller and enlarged; `None`: there are none.
    pub traced: Option<u32>,
    /// What all tiles have in common.
    pub common: Settings,
    /// Each tile's label, for the table that is printed, and its own settings.
    pub tiles: &'static [(&'static str, Settings)],
}

/// A tile at a time and at an exposure.
macro_rules! at {
    ($time:literal, $ev:literal) => {
        ($time, &[("clock.time", $time), ("output.exposure", $ev)])
    };
}

/// Stands for a map of bands that is made for the picture.
pub const BANDS: &str = "{bands}";

/// One tile, without settings of its own.
const ONE: &[(&str, Settings)] = &[("", &[])];

pub const SHEETS: [Sheet; 16] = [
    // A giant with bands under one bar of hydrogen, half lit, in the day of a moon with thin air.
    Sheet {
        name: "body-giant",
        preset: "earth-clean",
        size: [640, 360],
        traced: None,
        common: &[
            ("observer.place", "0,0"),
            ("clock.time", "2012-09-06T12:00Z"),
            ("air.molecules", "0.3"),
            ("air.aerosols", "0.2"),
            ("light.sun.azimuth_deg", "285"),
            ("light.sun.altitude_deg", "25"),
            ("body.moon.enabled", "off"),
            ("camera.look", "190,14"),
            ("camera.fov_deg", "42"),
            ("bodies.0.name", "giant"),
            ("bodies.0.preset", "giant"),
            ("bodies.0.molecules", "0.1"),
            ("bodies.0.albedo_map", BANDS),
            ("bodies.0.azimuth_deg", "196"),
            ("bodies.0.altitude_deg", "14"),
            ("bodies.0.distance_km", "420000"),
            ("bodies.0.tilt_deg", "20"),
        ],
        tiles: ONE,
    },
    // Mars, 80,000 km away, behind the Earth's limb from 400 km.
    Sheet {
        name: "body-setting",
        preset: "earth",
        size: [640, 360],
        traced: None,
        common: &[
            ("observer.place", "0,0"),
            ("clock.time", "2012-09-06T12:00Z"),
            ("observer.altitude_m", "400000"),
            ("light.sun.azimuth_deg", "200"),
            ("light.sun.altitude_deg", "10"),
            ("body.moon.enabled", "off"),
            ("camera.look", "90,-19"),
            ("camera.fov_deg", "9"),
            ("bodies.0.preset", "mars"),
            ("bodies.0.azimuth_deg", "90"),
            ("bodies.0.altitude_deg", "-19.2"),
            ("bodies.0.distance_km", "80000"),
        ],
        tiles: ONE,
    },
    // A moon of 400 km radius with air, 1,400 km away, before Mars from 6,000 km.
    Sheet {
        name: "body-moonlet",
        preset: "mars",
        size: [640, 360],
        traced: None,
        common: &[
            ("observer.place", "0,0"),
            ("clock.time", "2012-09-06T12:00Z"),
            ("observer.altitude_m", "6000000"),
            ("light.sun.azimuth_deg", "250"),
            ("light.sun.altitude_deg", "35"),
            ("camera.look", "180,-62"),
            ("camera.fov_deg", "50"),
            ("bodies.0.preset", "moonlet"),
            ("bodies.0.azimuth_deg", "205"),
            ("bodies.0.altitude_deg", "-52"),
            ("bodies.0.distance_km", "1400"),
        ],
        tiles: ONE,
    },
    // Horizon at the lower sixth, the sky up to 75°: the Sun of the first column is in it.
    Sheet {
        name: "strip",
        preset: "earth",
        size: [96, 144],
        traced: Some(2),
        common: &[("light.sun.azimuth_deg", "180"), ("camera.look", "180,30"), ("camera.fov_deg", "90")],
        tiles: &[
            ("+60°", &[("light.sun.altitude_deg", "60")]),
            ("+30°", &[("light.sun.altitude_deg", "30")]),
            ("+10°", &[("light.sun.altitude_deg", "10")]),
            ("+5°", &[("light.sun.altitude_deg", "5")]),
            ("0°", &[("light.sun.altitude_deg", "0")]),
            ("−2°", &[("light.sun.altitude_deg", "-2")]),
            ("−4°", &[("light.sun.altitude_deg", "-4")]),
            ("−6°", &[("light.sun.altitude_deg", "-6")]),
            ("−9°", &[("light.sun.altitude_deg", "-9")]),
            ("−12°", &[("light.sun.altitude_deg", "-12")]),
            ("−18°", &[("light.sun.altitude_deg", "-18")]),
        ],
    },
    Sheet {
        name: "orbit-traced",
        preset: "earth",
        size: [320, 180],
        traced: Some(2),
        common: &[
            ("observer.altitude_m", "400000"),
            ("light.sun.altitude_deg", "5"),
            ("light.sun.azimuth_deg", "229"),
            ("camera.look", "W,-20"),
            ("camera.fov_deg", "30"),
        ],
        tiles: ONE,
    },
    Sheet {
        name: "mars-noon",
        preset: "mars",
        size: [320, 180],
        traced: Some(2),
        common: &[
            ("light.sun.altitude_deg", "60"),
            ("light.sun.azimuth_deg", "180"),
            ("camera.look", "180,30"),
            ("camera.fov_deg", "80"),
        ],
        tiles: ONE,
    },
    Sheet {
        name: "mars-sunset",
        preset: "mars",
        size: [320, 180],
        traced: Some(2),
        common: &[
            ("light.sun.altitude_deg", "3"),
            ("light.sun.azimuth_deg", "270"),
            ("camera.look", "sunward"),
            ("camera.fov_deg", "40"),
        ],
        tiles: ONE,
    },
    // The tracer takes hours for the preset `titan`: ours from the ground and from above the haze.
    Sheet {
        name: "titan",
        preset: "titan",
        size: [320, 180],
        traced: None,
        common: &[("light.sun.azimuth_deg", "270")],
        tiles: &[
            ("ground", &[("light.sun.altitude_deg", "30"), ("camera.look", "sunward"), ("camera.fov_deg", "60")]),
            (
                "1,500 km",
                &[
                    ("observer.altitude_m", "1500000"),
                    ("light.sun.altitude_deg", "20"),
                    ("camera.look", "W,-52"),
                    ("camera.fov_deg", "50"),
                ],
            ),
        ],
    },
    Sheet {
        name: "titan-reference",
        preset: "titan-reference",
        size: [320, 180],
        traced: Some(2),
        common: &[
            ("light.sun.altitude_deg", "30"),
            ("light.sun.azimuth_deg", "270"),
            ("camera.look", "sunward"),
            ("camera.fov_deg", "60"),
        ],
        tiles: ONE,
    },
    Sheet {
        name: "haze",
        preset: "earth-haze",
        size: [320, 180],
        traced: Some(2),
        common: &[
            ("light.sun.altitude_deg", "20"),
            ("light.sun.azimuth_deg", "270"),
            ("camera.look", "sunward"),
            ("camera.fov_deg", "60"),
        ],
        tiles: ONE,
    },
    // From within the umbra; the tracer knows no occulter.
    Sheet {
        name: "eclipse",
        preset: "earth",
        size: [480, 270],
        traced: None,
        common: &[("observer.place", "Mazatlan"), ("clock.time", "2024-04-08T18:09:30Z")],
        tiles: &[
            ("sky", &[("camera.look", "180,25"), ("camera.fov_deg", "110")]),
            ("corona", &[("camera.look", "sun"), ("camera.fov_deg", "6"), ("output.exposure", "6")]),
        ],
    },
    // Full near the horizon, in partial eclipse, and a thin crescent in twilight.
    Sheet {
        name: "moon",
        preset: "earth",
        size: [320, 320],
        traced: None,
        common: &[("observer.place", "Potsdam"), ("camera.look", "moon"), ("camera.fov_deg", "0.8")],
        tiles: &[
            at!("2024-04-23T22:30Z", "11"),
            at!("2023-10-28T20:14Z", "12"),
            ("2024-04-10T18:50Z", &[("clock.time", "2024-04-10T18:50Z")]),
        ],
    },
    // First quarter: the disc, and Ptolemaeus with its neighbours at the terminator.
    Sheet {
        name: "moon-relief",
        preset: "earth",
        size: [480, 480],
        traced: None,
        common: &[
            ("observer.place", "Paranal"),
            ("clock.time", "2024-04-15T23:30Z"),
            ("camera.look", "moon"),
            ("output.exposure", "9"),
        ],
        tiles: &[("whole", &[("camera.fov_deg", "0.6")]), ("terminator", &[("camera.fov_deg", "0.1")])],
    },
    // Total from 07:41 to 08:53.
    Sheet {
        name: "moon-2010",
        preset: "earth",
        size: [104, 104],
        traced: None,
        common: &[("observer.place", "New York"), ("camera.look", "moon"), ("camera.fov_deg", "0.62")],
        tiles: &[
            at!("2010-12-21T06:15Z", "12"),
            at!("2010-12-21T06:30Z", "12"),
            at!("2010-12-21T06:45Z", "12"),
            at!("2010-12-21T07:00Z", "12"),
            at!("2010-12-21T07:15Z", "12"),
            at!("2010-12-21T07:30Z", "12"),
            at!("2010-12-21T07:45Z", "0"),
            at!("2010-12-21T08:00Z", "0"),
            at!("2010-12-21T08:15Z", "0"),
            at!("2010-12-21T08:30Z", "0"),
            at!("2010-12-21T08:45Z", "0"),
            at!("2010-12-21T09:00Z", "12"),
            at!("2010-12-21T09:15Z", "12"),
            at!("2010-12-21T09:30Z", "12"),
            at!("2010-12-21T09:45Z", "12"),
            at!("2010-12-21T10:00Z", "12"),
            at!("2010-12-21T10:15Z", "12"),
        ],
    },
    // Total from 03:29 to 04:54.
    Sheet {
        name: "moon-2022",
        preset: "earth",
        size: [104, 104],
        traced: None,
        common: &[("observer.place", "New York"), ("camera.look", "moon"), ("camera.fov_deg", "0.62")],
        tiles: &[
            at!("2022-05-16T02:15Z", "12"),
            at!("2022-05-16T02:30Z", "12"),
            at!("2022-05-16T02:45Z", "12"),
            at!("2022-05-16T03:00Z", "12"),
            at!("2022-05-16T03:15Z", "12"),
            at!("2022-05-16T03:30Z", "0"),
            at!("2022-05-16T03:45Z", "0"),
            at!("2022-05-16T04:00Z", "0"),
            at!("2022-05-16T04:15Z", "0"),
            at!("2022-05-16T04:30Z", "0"),
            at!("2022-05-16T04:45Z", "0"),
            at!("2022-05-16T05:00Z", "12"),
            at!("2022-05-16T05:15Z", "12"),
            at!("2022-05-16T05:30Z", "12"),
            at!("2022-05-16T05:45Z", "12"),
        ],
    },
    // The penumbra alone.
    Sheet {
        name: "moon-2023",
        preset: "earth",
        size: [104, 104],
        traced: None,
        common: &[("observer.place", "-31.95,115.86"), ("camera.look", "moon"), ("camera.fov_deg", "0.62")],
        tiles: &[
            at!("2023-05-05T15:15Z", "12"),
            at!("2023-05-05T15:30Z", "12"),
            at!("2023-05-05T15:45Z", "12"),
            at!("2023-05-05T16:00Z", "12"),
            at!("2023-05-05T16:15Z", "12"),
            at!("2023-05-05T16:30Z", "12"),
            at!("2023-05-05T16:45Z", "12"),
            at!("2023-05-05T17:00Z", "12"),
            at!("2023-05-05T17:15Z", "12"),
            at!("2023-05-05T17:30Z", "12"),
            at!("2023-05-05T17:45Z", "12"),
            at!("2023-05-05T18:00Z", "12"),
            at!("2023-05-05T18:15Z", "12"),
            at!("2023-05-05T18:30Z", "12"),
            at!("2023-05-05T18:45Z", "12"),
            at!("2023-05-05T19:00Z", "12"),
            at!("2023-05-05T19:15Z", "12"),
        ],
    },
];
