//! The air's tables saved, loaded and kept: the same picture without a rebuild.

use himmel::{Output, Picture, Still, TablesCache};
use himmel_tests::{gpu, model};

fn still(preset: &str) -> Still {
    Still::new(gpu(), Output::Radiance, model(preset, &[("air.quality", "low")]).atmosphere()).unwrap()
}

fn picture(still: &mut Still, preset: &str) -> Picture {
    let model = model(preset, &[("light.sun.altitude_deg", "8"), ("air.quality", "low")]);
    let picture = still.render(&model.frame().unwrap(), &model.view().unwrap(), 64, 36, &mut |_| true).unwrap();
    Picture { times: Default::default(), ..picture }
}

#[test]
fn what_was_saved_is_loaded() {
    let mut built = still("earth");
    assert!(built.renderer().save_tables().is_err(), "nothing is finished yet");
    let expected = picture(&mut built, "earth");
    let bytes = built.renderer().save_tables().unwrap().wait().unwrap();
    let mut asked = built.renderer().save_tables().unwrap();
    let polled = loop {
        if let Some(bytes) = asked.poll() {
            break bytes.unwrap();
        }
    };
    assert_eq!(polled, bytes);
    println!("{} bytes, key {}", bytes.len(), built.renderer().tables_key().unwrap());

    let mut loaded = still("earth");
    assert_eq!(loaded.renderer().tables_key().unwrap(), built.renderer().tables_key().unwrap());
    for broken in [&bytes[..0], &bytes[..100], &bytes[..bytes.len() - 1]] {
        assert!(loaded.renderer().load_tables(broken).is_err());
    }
    assert!(loaded.renderer().rebuilding().is_some(), "broken files change nothing");
    loaded.renderer().load_tables(&bytes).unwrap();
    assert!(loaded.renderer().rebuilding().is_none());
    assert_eq!(picture(&mut loaded, "earth"), expected);

    let error = still("mars").renderer().load_tables(&bytes).unwrap_err().to_string();
    assert!(error.contains("other air"), "{error}");
    built.renderer().cancel_rebuild();
    assert!(built.renderer().save_tables().is_ok(), "there was nothing to cancel");
    let mut cancelled = still("earth");
    cancelled.renderer().cancel_rebuild();
    assert!(cancelled.renderer().save_tables().is_err());
}

#[test]
fn a_cache_heals_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let cache = TablesCache::in_folder(&folder.path().join("new"));
    let mut built = still("earth");
    assert!(!cache.load(built.renderer()));
    let expected = picture(&mut built, "earth");
    cache.store(built.renderer()).unwrap();
    let mut again = still("earth");
    assert!(cache.load(again.renderer()));
    assert_eq!(picture(&mut again, "earth"), expected);
    let file = std::fs::read_dir(cache.folder()).unwrap().next().unwrap().unwrap().path();
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&file, bytes).unwrap();
    assert!(!cache.load(still("earth").renderer()));
    cache.store(built.renderer()).unwrap();
    assert!(cache.load(still("earth").renderer()));
    assert_eq!(std::fs::read_dir(cache.folder()).unwrap().count(), 1);
}

#[test]
fn airs_that_are_kept_need_no_rebuild() {
    let mut still = still("earth");
    let earth = picture(&mut still, "earth");
    still.renderer().set_kept(2);
    assert_eq!(still.renderer().kept_bytes(), 0);
    let take = |still: &mut Still, preset: &str| {
        still.renderer().set_atmosphere(model(preset, &[("air.quality", "low")]).atmosphere()).unwrap();
        still.renderer().rebuilding().is_some()
    };
    assert!(take(&mut still, "mars"), "Mars is new");
    assert!(still.renderer().kept_bytes() > 0);
    let mars = picture(&mut still, "mars");
    assert!(!take(&mut still, "earth"), "the Earth was kept");
    assert_eq!(picture(&mut still, "earth"), earth);
    assert!(!take(&mut still, "mars"));
    assert_eq!(picture(&mut still, "mars"), mars);
    println!("{} bytes kept", still.renderer().kept_bytes());
    still.renderer().set_kept(0);
    assert_eq!(still.renderer().kept_bytes(), 0);
    assert!(take(&mut still, "earth"), "nothing is kept any more");
}
