//! `himmel info`

use himmel::Gpu;

use crate::{Failure, out};

/// Arguments of `himmel info`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  himmel info\n  himmel info --json\n\nExits with 1 where no GPU adapter answers.")]
pub struct Args {
    /// GPU adapter whose name contains this, such as llvmpipe.
    #[arg(long, value_name = "NAME", env = "HIMMEL_ADAPTER")]
    adapter: Option<String>,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
}

/// What is compiled in, with its licence.
const DATA: [(&str, &str); 14] = [
    ("JPL DE440, refitted 1850–2150", "public domain (NASA/JPL)"),
    ("VSOP87, ELP-MPP02 series, Pluto, Jupiter's moons", "MIT (astronomia); facts"),
    ("Stars (Hipparcos, van Leeuwen 2007; Hipparcos 1997)", "ESA, free with acknowledgement"),
    ("Names of stars, constellations (d3-celestial)", "BSD-3-Clause, © 2015 Olaf Frohn"),
    ("Letters of names in the sky (Ubuntu Light)", "Ubuntu font licence 1.0, © Canonical Ltd."),
    ("Libration of the Moon (fitted to JPL DE421)", "public domain (NASA/JPL)"),
    ("Earth orientation (IERS)", "BSD-3-Clause (astropy-iers-data)"),
    ("Leap seconds (USNO), Delta T (Morrison et al. 2021)", "public domain; facts"),
    ("CIE 1931 2° observer", "BSD-3-Clause (colour-science)"),
    ("Sun above the air (ASTM G-173), limb darkening (Neckel & Labs 1994)", "facts"),
    ("Ozone cross section (Serdyuchenko 2014), profile (US Standard Atmosphere 1976)", "facts"),
    ("Cities (GeoNames)", "CC BY 4.0, © GeoNames contributors"),
    ("Observing sites (astropy-data, SolarStations, Wikipedia)", "BSD-3-Clause; facts"),
    ("Time zones (tzf; OpenStreetMap)", "ODbL, © OpenStreetMap contributors"),
];

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let adapters = Gpu::adapters();
    let gpu = Gpu::open(args.adapter.as_deref())?;
    let report = gpu.report();
    let limits = gpu.device.limits();
    if args.json {
        let json = serde_json::json!({
            "adapter": { "name": report.name, "back_end": report.back_end, "kind": report.kind, "driver": report.driver },
            "adapters": adapters.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "limits": {
                "max_texture_dimension_2d": limits.max_texture_dimension_2d,
                "max_bind_groups": limits.max_bind_groups,
                "max_buffer_size": limits.max_buffer_size,
            },
            "time_stamps": gpu.device.features().contains(himmel::wgpu::Features::TIMESTAMP_QUERY),
            "presets": himmel::parts::air::preset::names().collect::<Vec<_>>(),
            "data": DATA.map(|(what, licence)| serde_json::json!({ "what": what, "licence": licence })),
        });
        out!("{}", serde_json::to_string_pretty(&json).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    out!("himmel {}", env!("CARGO_PKG_VERSION"));
    out!("adapter   {report}");
    for other in adapters.iter().filter(|other| **other != report) {
        out!("also      {other}   (--adapter)");
    }
    let stamps = gpu.device.features().contains(himmel::wgpu::Features::TIMESTAMP_QUERY);
    out!(
        "limits    textures to {}², buffers to {} MiB, {} bind groups, pass times {}",
        limits.max_texture_dimension_2d,
        limits.max_buffer_size >> 20,
        limits.max_bind_groups,
        if stamps { "measured" } else { "not offered" }
    );
    out!("presets   {}", himmel::parts::air::preset::names().collect::<Vec<_>>().join(", "));
    out!("data");
    for (what, licence) in DATA {
        out!("  {what}: {licence}");
    }
    Ok(())
}
