//! A folder of accepted pictures and the checks that compare new ones with them.
//!
//! A check that fails leaves its new picture in the work folder as a *proposal*, with a heat map of the difference.
//! With `HIMMEL_GOLDEN=propose` every check leaves its proposal and none fails for a difference, so that one run
//! proposes all; [`GoldenSet::review`] and [`GoldenSet::accept`] take it from there. A check that passes removes
//! what an earlier one left, so the work folder never shows an old failure.
//!
//! | file | what |
//! |---|---|
//! | `accepted_dir/NAME.exr` or `.png` | what was accepted |
//! | `work_dir/NAME.new.exr` or `.png` | the proposal |
//! | `work_dir/NAME.new.txt` | its kind and tolerance, for the review |
//! | `work_dir/NAME.diff.png` | the heat map |
//! | `work_dir/NAME.sheet.png` | accepted, new and difference side by side, from the review |

use crate::error::GoldenError;
use crate::files::{RadianceImage, Rgb8Image, encode_png, remove_if_there, write_whole};
use crate::heat::relative_heat;
use crate::picture::{FlipTolerance, Kind, Limits, Numbers, Picture, Tolerance, compare};
use std::fmt;
use std::path::{Path, PathBuf};

/// The environment variable that turns checks into proposals.
pub const MODE_VARIABLE: &str = "HIMMEL_GOLDEN";

/// What a check does with a picture that differs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// It fails, and leaves a proposal.
    #[default]
    Check,
    /// It leaves a proposal, always, and reports how it compares.
    Propose,
}

impl Mode {
    /// The mode that `HIMMEL_GOLDEN` asks for: `check` (or unset, or empty) or `propose`.
    pub fn from_env() -> Result<Self, GoldenError> {
        Mode::parse(&std::env::var_os(MODE_VARIABLE).unwrap_or_default().to_string_lossy())
    }

    fn parse(value: &str) -> Result<Self, GoldenError> {
        match value {
            "" | "check" => Ok(Mode::Check),
            "propose" => Ok(Mode::Propose),
            other => Err(GoldenError::Mode(other.to_owned())),
        }
    }
}

/// Accepted pictures, and the place for new ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GoldenSet {
    /// Pictures that were accepted; in version control.
    pub accepted_dir: PathBuf,
    /// Proposals, heat maps and sheets; not in version control.
    pub work_dir: PathBuf,
    /// What a check does with a picture that differs.
    pub mode: Mode,
}

/// How a new picture stands to the accepted one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within the tolerance.
    Pass,
    /// Beyond the tolerance or of another size; why, as a clause.
    Fail(String),
    /// Nothing is accepted under this name.
    New,
    /// One of the files cannot be read; why, as a clause.
    Broken(String),
}

impl Verdict {
    /// One word for a table.
    pub fn word(&self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail(_) => "FAIL",
            Verdict::New => "new",
            Verdict::Broken(_) => "BROKEN",
        }
    }
}

/// The outcome of a check that did not fail.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The golden.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// Always [`Verdict::Pass`] in [`Mode::Check`].
    pub verdict: Verdict,
    /// How far the pictures are apart, where they can be compared.
    pub numbers: Option<Numbers>,
    /// The new picture, where one was left.
    pub proposal: Option<PathBuf>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "golden `{}` ({}): {}", self.name, self.kind.extension(), self.verdict.word())?;
        self.numbers.map_or(Ok(()), |numbers| write!(f, "  {numbers}"))
    }
}

/// How a new picture stands to the accepted file, with all that a check or a review shows of it.
pub(crate) struct Judgement {
    pub(crate) verdict: Verdict,
    pub(crate) numbers: Option<Numbers>,
    pub(crate) heat: Option<Rgb8Image>,
    pub(crate) accepted: Option<Picture>,
}

impl GoldenSet {
    /// The goldens in `accepted_dir`, with proposals in `work_dir`, in the mode that `HIMMEL_GOLDEN` asks for.
    pub fn new(accepted_dir: impl Into<PathBuf>, work_dir: impl Into<PathBuf>) -> Result<Self, GoldenError> {
        Ok(GoldenSet { accepted_dir: accepted_dir.into(), work_dir: work_dir.into(), mode: Mode::from_env()? })
    }

    /// This workspace's goldens: `tests/golden/accepted` and `target/golden`.
    pub fn of_workspace() -> Result<Self, GoldenError> {
        let root = workspace_root();
        GoldenSet::new(root.join("tests/golden/accepted"), root.join("target/golden"))
    }

    /// Compares a picture in linear light, three values a pixel, with the accepted EXR of this name.
    ///
    /// Both sides are rounded to half floats first, so that the same picture has an error of exactly 0.
    pub fn check_exr(
        &self,
        name: &str,
        width: usize,
        height: usize,
        rgb: &[f32],
        tolerance: Tolerance,
    ) -> Result<Report, GoldenError> {
        check_name(name)?;
        let picture = RadianceImage::new(width, height, rgb.to_vec())?;
        self.refuse_non_finite(name, &picture)?;
        self.check(name, Picture::Exr(picture.rounded_to_half()), Limits::Exr(tolerance))
    }

    /// Compares a finished 8-bit sRGB picture, three values a pixel, with the accepted PNG of this name.
    pub fn check_png(
        &self,
        name: &str,
        width: usize,
        height: usize,
        rgb: &[u8],
        tolerance: FlipTolerance,
    ) -> Result<Report, GoldenError> {
        check_name(name)?;
        let picture = Rgb8Image::new(width, height, rgb.to_vec())?;
        self.check(name, Picture::Png(picture), Limits::Png(tolerance))
    }

    fn check(&self, name: &str, new: Picture, limits: Limits) -> Result<Report, GoldenError> {
        limits.validate()?;
        let (kind, other) = match &new {
            Picture::Exr(_) => (Kind::Exr, Kind::Png),
            Picture::Png(_) => (Kind::Png, Kind::Exr),
        };
        if self.accepted_path(name, other).exists() {
            return Err(GoldenError::OtherKind { name: name.to_owned(), path: self.accepted_path(name, other) });
        }
        let judgement = self.judge(name, kind, &new, &limits)?;
        let mut report = Report {
            name: name.to_owned(),
            kind,
            verdict: judgement.verdict,
            numbers: judgement.numbers,
            proposal: None,
        };
        self.clear(name)?;
        if self.mode == Mode::Check && report.verdict == Verdict::Pass {
            return Ok(report);
        }
        if let Some(heat) = judgement.heat {
            write_whole(&self.work_path(name, "diff.png"), &encode_png(&heat)?)?;
        }
        // The picture last: whoever finds a proposal finds its tolerance too.
        write_whole(&self.work_path(name, "new.txt"), tolerance_file(kind, &limits).as_bytes())?;
        let proposal = self.proposal_path(name, kind);
        write_whole(&proposal, &new.encode()?)?;
        let reason = match &report.verdict {
            _ if self.mode == Mode::Propose => None,
            Verdict::Pass => None,
            Verdict::New => Some("nothing is accepted under this name yet".to_owned()),
            Verdict::Fail(reason) | Verdict::Broken(reason) => Some(reason.clone()),
        };
        match reason {
            Some(reason) => Err(GoldenError::Failed { name: name.to_owned(), reason, proposal }),
            None => {
                report.proposal = Some(proposal);
                Ok(report)
            }
        }
    }

    /// Compares a new picture with the accepted file.
    pub(crate) fn judge(
        &self,
        name: &str,
        kind: Kind,
        new: &Picture,
        limits: &Limits,
    ) -> Result<Judgement, GoldenError> {
        let verdict_alone = |verdict| Judgement { verdict, numbers: None, heat: None, accepted: None };
        let accepted = match read_picture(&self.accepted_path(name, kind), kind) {
            Ok(Some(accepted)) => accepted,
            Ok(None) => return Ok(verdict_alone(Verdict::New)),
            Err(e) => {
                return Ok(verdict_alone(Verdict::Broken(format!("the accepted picture is {e}"))));
            }
        };
        if accepted.size() != new.size() {
            let sentence = GoldenError::SizesDiffer { accepted: accepted.size(), new: new.size() }.to_string();
            return Ok(Judgement { accepted: Some(accepted), ..verdict_alone(Verdict::Fail(sentence)) });
        }
        let (numbers, heat) = compare(&accepted, new, limits)?;
        let verdict = numbers.beyond(limits).map_or(Verdict::Pass, Verdict::Fail);
        Ok(Judgement { verdict, numbers: Some(numbers), heat: Some(heat), accepted: Some(accepted) })
    }

    /// NaN and infinities are never proposed: accepted once, they would hide every later one.
    fn refuse_non_finite(&self, name: &str, picture: &RadianceImage) -> Result<(), GoldenError> {
        let bad = Picture::Exr(picture.clone()).non_finite();
        let Some(&first) = bad.first() else {
            return Ok(());
        };
        self.clear(name)?;
        let mut map = vec![0.0; picture.width() * picture.height()];
        bad.iter().for_each(|&i| map[i] = f64::INFINITY);
        let heat = relative_heat(picture.width(), picture.height(), &map)?;
        let difference = self.work_path(name, "diff.png");
        write_whole(&difference, &encode_png(&heat)?)?;
        let (x, y) = (first % picture.width(), first / picture.width());
        Err(GoldenError::NonFinite { name: name.to_owned(), pixels: bad.len(), x, y, difference })
    }

    /// Removes what earlier checks and reviews left of this golden in the work folder.
    pub(crate) fn clear(&self, name: &str) -> Result<(), GoldenError> {
        let left = ["new.exr", "new.png", "new.txt", "diff.png", "sheet.png"];
        left.iter().try_for_each(|ending| remove_if_there(&self.work_path(name, ending)))
    }

    pub(crate) fn accepted_path(&self, name: &str, kind: Kind) -> PathBuf {
        self.accepted_dir.join(format!("{name}.{}", kind.extension()))
    }

    pub(crate) fn proposal_path(&self, name: &str, kind: Kind) -> PathBuf {
        self.work_path(name, &format!("new.{}", kind.extension()))
    }

    pub(crate) fn work_path(&self, name: &str, ending: &str) -> PathBuf {
        self.work_dir.join(format!("{name}.{ending}"))
    }
}

/// A name becomes files on every system and an argument in a shell.
pub(crate) fn check_name(name: &str) -> Result<(), GoldenError> {
    let plain = |c: u8| c.is_ascii_alphanumeric() || c == b'-' || c == b'_';
    let good = (1..=64).contains(&name.len()) && name.bytes().all(plain) && !name.starts_with('-');
    if good { Ok(()) } else { Err(GoldenError::Name(name.to_owned())) }
}

/// A picture from a file, `None` where there is no such file; the error is a clause without the path's own.
pub(crate) fn read_picture(path: &Path, kind: Kind) -> Result<Option<Picture>, String> {
    match std::fs::read(path) {
        Ok(bytes) => Picture::decode(kind, &bytes).map(Some).map_err(|e| format!("unreadable, {e}")),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(format!("unreadable ({e})")),
    }
}

/// The text of `NAME.new.txt`: a line `name = value` for each limit, in their order.
fn tolerance_file(kind: Kind, limits: &Limits) -> String {
    let mut text = format!("kind = {}\n", kind.extension());
    for (name, value) in limits.fields() {
        text += &format!("{name} = {value}\n");
    }
    text
}

/// The limits from the text of `NAME.new.txt`, `None` where it is not as [`tolerance_file`] writes it.
pub(crate) fn parse_tolerance_file(kind: Kind, text: &str) -> Option<Limits> {
    let mut lines = text.lines();
    (lines.next()? == format!("kind = {}", kind.extension())).then_some(())?;
    let values: Option<Vec<f64>> = lines.map(|line| line.split_once(" = ")?.1.parse().ok()).collect();
    let limits = Limits::from_values(kind, &values?)?;
    (limits.validate().is_ok() && tolerance_file(kind, &limits) == text).then_some(limits)
}

/// The workspace that this crate was built in.
pub(crate) fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_survive_their_file() {
        for limits in [Limits::Exr(Tolerance::default()), Limits::Png(FlipTolerance { mean: 0.1 + 0.2, max: 1e-9 })] {
            let kind = if matches!(limits, Limits::Exr(_)) { Kind::Exr } else { Kind::Png };
            let text = tolerance_file(kind, &limits);
            assert_eq!(parse_tolerance_file(kind, &text), Some(limits), "{text}");
            for end in 0..text.len() {
                assert_eq!(parse_tolerance_file(kind, &text[..end]), None, "cut after {end} bytes");
            }
        }
        assert_eq!(parse_tolerance_file(Kind::Png, "kind = png\nmean = NaN\nmax = inf\n"), None);
    }

    #[test]
    fn a_misspelt_mode_is_an_error_and_not_a_check() {
        assert_eq!(Mode::parse("").unwrap(), Mode::Check);
        assert_eq!(Mode::parse("check").unwrap(), Mode::Check);
        assert_eq!(Mode::parse("propose").unwrap(), Mode::Propose);
        assert!(Mode::parse("Propose").is_err() && Mode::parse("1").is_err());
    }

    #[test]
    fn names_are_plain() {
        for good in ["twilight", "eclipse-2024_totality", "A", "_"] {
            assert!(check_name(good).is_ok(), "{good}");
        }
        for bad in ["", ".", "..", "a/b", "a\\b", "a.new", "--all", "ä", "a b", "a\n", &"x".repeat(65)] {
            assert!(check_name(bad).is_err(), "{bad:?}");
        }
    }
}
