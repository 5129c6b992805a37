//! The harness can fail: each way in which a picture can be wrong, and each broken file.

use himmel_golden::{
    Acceptance, FlipTolerance, GoldenError, GoldenSet, Kind, Mode, RadianceImage, Rgb8Image, Tolerance, Verdict,
    decode_exr, decode_png, encode_exr, encode_png,
};
use std::fs;

const WIDTH: usize = 48;
const HEIGHT: usize = 32;

/// A dusk in cd/m²: five decades from top to bottom, a little colour.
fn dusk() -> Vec<f32> {
    let row = |i: usize| (i / WIDTH) as f32 / HEIGHT as f32;
    (0..WIDTH * HEIGHT)
        .flat_map(|i| {
            let light = 2e-2 * 10f32.powf(5.0 * row(i));
            [light * (1.0 + (i % WIDTH) as f32 / 100.0), light, 0.7 * light]
        })
        .collect()
}

fn blue() -> Vec<u8> {
    (0..WIDTH * HEIGHT).flat_map(|i| [(i / WIDTH) as u8 * 4, 90 + (i % WIDTH) as u8, 230]).collect()
}

struct Bench {
    folder: tempfile::TempDir,
    set: GoldenSet,
}

impl Bench {
    fn empty() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let set = GoldenSet {
            accepted_dir: folder.path().join("accepted"),
            work_dir: folder.path().join("deep/work"),
            mode: Mode::Check,
        };
        Bench { folder, set }
    }

    /// With `dusk` and `blue` accepted.
    fn accepted() -> Self {
        let bench = Bench::empty();
        assert!(matches!(bench.dusk(&dusk()), Err(GoldenError::Failed { .. })));
        assert!(matches!(bench.blue(&blue()), Err(GoldenError::Failed { .. })));
        assert_eq!(bench.set.accept_all().unwrap().rows.len(), 2);
        assert_eq!(bench.left(), Vec::<String>::new());
        bench
    }

    fn dusk(&self, rgb: &[f32]) -> Result<himmel_golden::Report, GoldenError> {
        self.set.check_exr("dusk", WIDTH, HEIGHT, rgb, Tolerance::default())
    }

    fn blue(&self, rgb: &[u8]) -> Result<himmel_golden::Report, GoldenError> {
        self.set.check_png("blue", WIDTH, HEIGHT, rgb, FlipTolerance::default())
    }

    /// The files in the work folder.
    fn left(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.set.work_dir).into_iter().flatten();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// That this is a failed check whose sentence holds these words and the way on, and that the proposal is there.
    fn assert_failed(&self, outcome: Result<himmel_golden::Report, GoldenError>, words: &[&str]) {
        let error = outcome.expect_err("the check must fail");
        let sentence = error.to_string();
        let GoldenError::Failed { name, proposal, .. } = &error else { panic!("{sentence}") };
        assert!(proposal.exists(), "{sentence}");
        let accept = format!("`cargo xtask golden accept {name}`");
        for word in words.iter().chain(&["`cargo xtask golden review`", accept.as_str()]) {
            assert!(sentence.contains(word), "no {word:?} in: {sentence}");
        }
        assert_eq!(format!("{error:?}"), sentence, "what a test that returns the error shows");
        assert!(self.left().iter().all(|f| !f.ends_with(".tmp")));
    }
}

#[test]
fn the_same_picture_passes_with_an_error_of_0() {
    let bench = Bench::accepted();
    let (dusk, blue) = (bench.dusk(&dusk()).unwrap(), bench.blue(&blue()).unwrap());
    assert!(dusk.to_string().ends_with("max 0.00000") && blue.to_string().ends_with("max 0.00000"));
    assert_eq!((dusk.verdict, dusk.proposal), (Verdict::Pass, None));
    assert_eq!(bench.left(), Vec::<String>::new());
}

#[test]
fn a_gain_of_one_percent_fails() {
    let bench = Bench::accepted();
    let brighter: Vec<f32> = dusk().iter().map(|v| v * 1.01).collect();
    bench.assert_failed(bench.dusk(&brighter), &["relative error median 0.0", "where 0.002 is allowed"]);
    assert_eq!(bench.left(), ["dusk.diff.png", "dusk.new.exr", "dusk.new.txt"]);
    let brighter: Vec<u8> = blue().iter().map(|v| v.saturating_add(3)).collect();
    bench.assert_failed(bench.blue(&brighter), &["FLIP mean 0.0", "where 0.005 is allowed"]);
}

#[test]
fn one_changed_pixel_fails_and_is_located() {
    let bench = Bench::accepted();
    let mut changed = dusk();
    changed[3 * (20 * WIDTH + 7) + 2] *= 2.0;
    bench.assert_failed(bench.dusk(&changed), &["max 0.5", "where 0.25 is allowed", "x 7, y 20"]);
    let mut changed = blue();
    changed[3 * (20 * WIDTH + 7)..][..3].copy_from_slice(&[255, 255, 255]);
    bench.assert_failed(bench.blue(&changed), &["max 0.", "where 0.2 is allowed"]);
    let heat = decode_png(&fs::read(bench.set.work_dir.join("blue.diff.png")).unwrap()).unwrap();
    let brightest = heat.pixels().enumerate().max_by_key(|(_, p)| u32::from(p[0]) + u32::from(p[1])).unwrap().0;
    assert_eq!(brightest, 20 * WIDTH + 7);
}

#[test]
fn rounding_passes_and_clears_what_an_older_failure_left() {
    let bench = Bench::accepted();
    bench.dusk(&vec![1.0; dusk().len()]).unwrap_err();
    assert_eq!(bench.left().len(), 3);
    let rounded: Vec<f32> = dusk().iter().map(|v| v * 1.0005).collect();
    bench.dusk(&rounded).unwrap();
    assert_eq!(bench.left(), Vec::<String>::new());
}

#[test]
fn another_size_fails() {
    let bench = Bench::accepted();
    let turned = bench.set.check_exr("dusk", HEIGHT, WIDTH, &dusk(), Tolerance::default());
    bench.assert_failed(turned, &["the accepted picture is 48×32, the new one 32×48"]);
    let turned = bench.set.check_png("blue", HEIGHT, WIDTH, &blue(), FlipTolerance::default());
    bench.assert_failed(turned, &["the accepted picture is 48×32, the new one 32×48"]);
    let review = bench.set.review().unwrap().to_string();
    assert!(review.contains("FAIL") && review.contains("32×48"), "{review}");
}

#[test]
fn a_buffer_of_another_length_is_an_error_and_proposes_nothing() {
    let bench = Bench::accepted();
    assert!(matches!(bench.dusk(&dusk()[1..]), Err(GoldenError::Shape { .. })));
    assert!(matches!(bench.blue(&[]), Err(GoldenError::Shape { .. })));
    let none = bench.set.check_png("none", 0, 0, &[], FlipTolerance::default());
    assert!(matches!(none, Err(GoldenError::Shape { .. })));
    let vast = bench.set.check_exr("vast", usize::MAX, usize::MAX, &[0.0; 3], Tolerance::default());
    assert!(matches!(vast, Err(GoldenError::Shape { .. })));
    assert_eq!(bench.left(), Vec::<String>::new());
}

#[test]
fn nan_fails_in_both_modes_and_is_never_proposed() {
    let mut bench = Bench::accepted();
    for mode in [Mode::Check, Mode::Propose] {
        bench.set.mode = mode;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut changed = dusk();
            changed[3 * (3 * WIDTH + 5) + 1] = bad;
            let error = bench.dusk(&changed).unwrap_err();
            assert!(matches!(error, GoldenError::NonFinite { pixels: 1, x: 5, y: 3, .. }), "{error}");
            assert_eq!(bench.left(), ["dusk.diff.png"]);
        }
    }
}

#[test]
fn a_missing_golden_fails() {
    let bench = Bench::empty();
    bench.assert_failed(bench.dusk(&dusk()), &["nothing is accepted under this name yet"]);
    bench.assert_failed(bench.blue(&blue()), &["nothing is accepted under this name yet"]);
    assert_eq!(bench.left(), ["blue.new.png", "blue.new.txt", "dusk.new.exr", "dusk.new.txt"]);
}

#[test]
fn a_broken_accepted_file_fails_and_can_be_replaced() {
    for file in ["dusk.exr", "blue.png"] {
        let bench = Bench::accepted();
        let path = bench.set.accepted_dir.join(file);
        let whole = fs::read(&path).unwrap();
        let check = || {
            if file == "dusk.exr" { bench.dusk(&dusk()) } else { bench.blue(&blue()) }
        };
        for broken in [&whole[..whole.len() / 2], &whole[..8], &[][..], b"no picture at all", &[0xff; 4096]] {
            fs::write(&path, broken).unwrap();
            bench.assert_failed(check(), &["the accepted picture is unreadable"]);
            assert_eq!(bench.set.review().unwrap().rows[0].verdict.word(), "BROKEN");
        }
        bench.set.accept_all().unwrap();
        assert_eq!(fs::read(&path).unwrap(), whole);
        check().unwrap();
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        bench.assert_failed(check(), &["the accepted picture is unreadable"]);
        assert!(matches!(bench.set.accept_all(), Err(GoldenError::Io { .. })));
    }
}

#[test]
fn no_broken_file_panics() {
    let exr = encode_exr(&RadianceImage::new(6, 20, dusk()[..360].to_vec()).unwrap()).unwrap();
    let png = encode_png(&Rgb8Image::new(6, 20, blue()[..360].to_vec()).unwrap()).unwrap();
    for end in 0..exr.len() {
        assert!(decode_exr(&exr[..end]).is_err(), "an EXR cut after {end} bytes of {}", exr.len());
    }
    let ihdr_to_idat = png.len() - 12; // the last chunk, IEND, holds nothing
    for end in 0..ihdr_to_idat {
        assert!(decode_png(&png[..end]).is_err(), "a PNG cut after {end} bytes of {}", png.len());
    }
    // Any byte may hold anything; most give an error, some another picture, none a panic.
    for (bytes, is_exr) in [(&exr, true), (&png, false)] {
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff, bytes[at] ^ 0x10] {
                let mut changed = bytes.clone();
                changed[at] = value;
                if is_exr { drop(decode_exr(&changed)) } else { drop(decode_png(&changed)) }
            }
        }
    }
    assert!(decode_exr(&png).is_err() && decode_png(&exr).is_err());
}

#[test]
fn exr_keeps_half_floats_exactly_and_clamps_the_rest() {
    let values = [0.0, -0.0, 1.0, -2.5, 6.0e-8, 65504.0, 1.9e9, -1e30, f32::MAX, 0.1, 1.0e-9, 1234.5];
    let picture = RadianceImage::new(2, 2, values.to_vec()).unwrap();
    let half = picture.rounded_to_half();
    assert_eq!(decode_exr(&encode_exr(&picture).unwrap()).unwrap(), half);
    assert_eq!(half.rounded_to_half(), half);
    assert_eq!(half.rgb()[5..9], [65504.0, 65504.0, -65504.0, 65504.0]);
    assert!((half.rgb()[9] - 0.1).abs() < 0.1 / 2048.0);
    assert_eq!(half.rgb()[10], 0.0);
}

#[test]
fn exr_of_any_lossless_kind_is_read_and_no_other() {
    use exr::prelude::*;
    let encoded = |compression| {
        let encoding = Encoding { compression, ..Encoding::default() };
        let pixels = SpecificChannels::rgb(|at: Vec2<usize>| (0.1f32, at.x() as f32, at.y() as f32));
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = Image::from_layer(Layer::new((5, 3), LayerAttributes::default(), encoding, pixels));
        image.write().to_buffered(&mut bytes).unwrap();
        decode_exr(&bytes.into_inner())
    };
    for lossless in [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16] {
        let picture = encoded(lossless).unwrap();
        assert_eq!(picture.size(), (5, 3));
        assert_eq!(picture.pixels().nth(2 * 5 + 4), Some([0.1f32, 4.0, 2.0]), "floats keep all their bits");
    }
    for other in [Compression::B44, Compression::PXR24, Compression::PIZ] {
        assert!(encoded(other).unwrap_err().contains("uncompressed, RLE or ZIP"));
    }
}

#[test]
fn files_are_small_and_always_the_same() {
    let picture = RadianceImage::new(WIDTH, HEIGHT, dusk()).unwrap();
    let exr = encode_exr(&picture).unwrap();
    assert_eq!(exr, encode_exr(&picture).unwrap());
    assert!(exr.len() < 2 * 3 * WIDTH * HEIGHT, "{} bytes", exr.len());
}

#[test]
fn a_png_with_transparency_or_16_bits_is_refused() {
    for colour in [image::ExtendedColorType::Rgba8, image::ExtendedColorType::Rgb16] {
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        let data = vec![7; colour.bits_per_pixel() as usize / 8];
        image::ImageEncoder::write_image(encoder, &data, 1, 1, colour).unwrap();
        assert!(decode_png(&bytes).unwrap_err().contains("8-bit RGB"));
    }
}

#[test]
fn proposing_leaves_every_picture_and_fails_for_none() {
    let mut bench = Bench::accepted();
    bench.set.mode = Mode::Propose;
    let brighter: Vec<f32> = dusk().iter().map(|v| v * 1.1).collect();
    assert!(matches!(bench.dusk(&brighter).unwrap().verdict, Verdict::Fail(_)));
    assert_eq!(bench.blue(&blue()).unwrap().verdict, Verdict::Pass);
    let new = bench.set.check_exr("noon", 1, 1, &[1.0; 3], Tolerance::default()).unwrap();
    assert_eq!(new.verdict, Verdict::New);
    let proposed: Vec<_> = bench.set.proposals().unwrap();
    let expected = [("blue", Kind::Png), ("dusk", Kind::Exr), ("noon", Kind::Exr)];
    assert_eq!(proposed, expected.map(|(name, kind)| (name.to_owned(), kind)));

    let review = bench.set.review().unwrap();
    assert_eq!(review.rows.iter().map(|r| r.verdict.word()).collect::<Vec<_>>(), ["pass", "FAIL", "new"]);
    assert!(review.to_string().ends_with("3 proposals: 1 pass, 1 fail, 1 new\n"), "{review}");
    for row in &review.rows {
        let sheet = decode_png(&fs::read(row.sheet.as_ref().unwrap()).unwrap()).unwrap();
        let (width, height) = if row.name == "noon" { (1, 1) } else { (WIDTH, HEIGHT) };
        assert_eq!(sheet.size(), (3 * width + 16, height));
    }

    let accepted = bench.set.accept_all().unwrap();
    let what: Vec<Acceptance> = accepted.rows.iter().map(|r| r.1).collect();
    assert_eq!(what, [Acceptance::Unchanged, Acceptance::Replaced, Acceptance::Added]);
    bench.set.mode = Mode::Check;
    bench.dusk(&brighter).unwrap();
}

#[test]
fn the_review_uses_the_tests_own_tolerance() {
    let bench = Bench::accepted();
    let brighter: Vec<f32> = dusk().iter().map(|v| v * 1.01).collect();
    let wide = Tolerance { median: 0.02, p99: 0.02, ..Tolerance::default() };
    let mut proposing = bench.set.clone();
    proposing.mode = Mode::Propose;
    proposing.check_exr("dusk", WIDTH, HEIGHT, &brighter, wide).unwrap();
    assert_eq!(bench.set.review().unwrap().rows[0].verdict, Verdict::Pass);
    fs::remove_file(bench.set.work_dir.join("dusk.new.txt")).unwrap();
    assert!(bench.set.review().unwrap().to_string().contains("no tolerance is recorded"));
}

#[test]
fn nothing_is_accepted_where_one_proposal_is_broken() {
    let bench = Bench::empty();
    bench.dusk(&dusk()).unwrap_err();
    bench.blue(&blue()).unwrap_err();
    let proposal = bench.set.work_dir.join("dusk.new.exr");
    let bytes = fs::read(&proposal).unwrap();
    fs::write(&proposal, &bytes[..bytes.len() - 9]).unwrap();
    assert!(matches!(bench.set.accept_all(), Err(GoldenError::Unreadable { .. })));
    assert!(!bench.set.accepted_dir.exists());
    assert_eq!(bench.set.review().unwrap().rows[1].verdict.word(), "BROKEN");
    bench.set.accept(&["blue", "blue"]).unwrap();
    assert_eq!(bench.set.proposals().unwrap(), [("dusk".to_owned(), Kind::Exr)]);
}

#[test]
fn a_name_belongs_to_one_kind() {
    let bench = Bench::accepted();
    let outcome = bench.set.check_png("dusk", WIDTH, HEIGHT, &blue(), FlipTolerance::default());
    assert!(matches!(outcome, Err(GoldenError::OtherKind { .. })));
}

#[test]
fn limits_that_mean_nothing_are_errors() {
    let bench = Bench::accepted();
    for bad in [f64::NAN, f64::INFINITY, -0.1] {
        let tolerance = Tolerance { p99: bad, ..Tolerance::default() };
        let outcome = bench.set.check_exr("dusk", WIDTH, HEIGHT, &dusk(), tolerance);
        assert!(matches!(outcome, Err(GoldenError::Tolerance { field: "99 %", .. })));
    }
}

#[test]
fn a_work_folder_that_cannot_be_made_is_an_error() {
    let mut bench = Bench::empty();
    let file = bench.folder.path().join("file");
    fs::write(&file, "in the way").unwrap();
    bench.set.work_dir = file.join("work");
    assert!(matches!(bench.dusk(&dusk()), Err(GoldenError::Io { .. })));
}
