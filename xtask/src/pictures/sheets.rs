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

/// One tile, without settings of its own.
const ONE: &[(&str, Settings)] = &[("", &[])];

pub const SHEETS: [Sheet; 8] = [
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
        name: "orbit",
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
];
