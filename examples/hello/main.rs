//! The smallest program: the evening sky over Potsdam as a picture, `hello.png`. The Sun went down a quarter of an hour
//! ago, a little to the right of the middle; above the red horizon its glow fades from cream to grey-blue.
//!
//! `cargo run -p himmel --example hello`

use himmel::{Gpu, Output, Scene, SkyModel, picture};

fn main() -> Result<(), himmel::Error> {
    let mut scene = Scene::default();
    scene.set("observer.place", "Potsdam")?;
    scene.set("clock.time", "2012-09-06T20:00")?; // the place's own clock
    scene.set("camera.look", "W,10")?;

    let model = SkyModel::new(&scene)?;
    let gpu = Gpu::open(None)?;
    let sky = picture::render(&gpu, &model, Output::Display, &mut |_| true)?;
    picture::save(&sky, "hello.png".as_ref())?;

    println!("hello.png: {}, the Sun at {:.1}°", model.local_time(), model.sun()?.altitude_deg);
    Ok(())
}
