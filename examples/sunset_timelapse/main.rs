//! A sunset in twelve small pictures, `timelapse/00.png` and on: the Sun sinks to the right, the horizon reddens, twilight
//! climbs. Exposure follows as a camera's would.
//!
//! `cargo run -p himmel --example sunset_timelapse [FOLDER [FRAMES]]`

use std::path::PathBuf;

use himmel::{Gpu, Output, Scene, SkyModel, Still, picture};

/// Of the whole film, in virtual seconds: 19:00 to 20:30.
const DURATION_S: f64 = 90.0 * 60.0;
const SIZE: (u32, u32) = (320, 180);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().unwrap_or("timelapse".into()));
    let frames: u32 = args.next().map_or(Ok(12), |text| text.parse())?;
    std::fs::create_dir_all(&folder)?;

    let mut scene = Scene::default();
    scene.set("observer.place", "Potsdam")?;
    scene.set("clock.time", "2012-09-06T19:00")?;
    // The whole film takes a second of ours for each frame but the first.
    scene.set("clock.rate", &(DURATION_S / f64::from(frames.max(2) - 1)).to_string())?;
    scene.set("camera.look", "275,12")?;
    scene.set("output.width_px", &SIZE.0.to_string())?;
    scene.set("output.height_px", &SIZE.1.to_string())?;

    let mut model = SkyModel::new(&scene)?;
    // Kept for all frames: pipelines, tables and textures are made once.
    let mut still = Still::new(&Gpu::open(None)?, Output::Display, model.atmosphere())?;
    for index in 0..frames {
        let frame = still.render(&model.frame()?, &model.view()?, SIZE.0, SIZE.1, &mut |_| true)?;
        let path = folder.join(format!("{index:02}.png"));
        picture::save(&frame, &path)?;
        println!("{}: {}, EV {:.1}", path.display(), model.local_time(), frame.ev100);
        model.clock_mut().advance(1.0);
    }
    Ok(())
}
