//! What a person does with proposals: look at them side by side, then accept them.

use crate::error::GoldenError;
use crate::files::{encode_png, write_whole};
use crate::golden::{GoldenSet, Judgement, Verdict, check_name, parse_tolerance_file, read_picture};
use crate::heat::sheet;
use crate::picture::{Kind, Limits, Numbers, Picture};
use std::fmt;
use std::path::PathBuf;

/// All proposals beside what is accepted; prints as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Review {
    /// One row for each proposal, by name.
    pub rows: Vec<ReviewRow>,
    /// Accepted goldens without a proposal: they passed, or no test makes them any more.
    pub without_proposal: Vec<String>,
}

/// One proposal beside what is accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct ReviewRow {
    /// The golden.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// How the proposal stands to the accepted picture.
    pub verdict: Verdict,
    /// How far they are apart, where they can be compared.
    pub numbers: Option<Numbers>,
    /// The sheet: accepted, new and difference side by side; `None` where the proposal cannot be read or is too large.
    pub sheet: Option<PathBuf>,
}

impl fmt::Display for Review {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.name.len()).max().unwrap_or(0).max(4);
        if !self.rows.is_empty() {
            writeln!(f, "{:width$}  kind  verdict  numbers, sheet", "name")?;
        }
        for row in &self.rows {
            let said = match (&row.verdict, row.numbers) {
                (Verdict::New, _) => "nothing accepted yet".to_owned(),
                (_, Some(numbers)) => numbers.to_string(),
                (Verdict::Fail(why) | Verdict::Broken(why), None) => why.clone(),
                (Verdict::Pass, None) => String::new(),
            };
            writeln!(f, "{:width$}  {:4}  {:7}  {said}", row.name, row.kind.extension(), row.verdict.word())?;
            if let Some(sheet) = &row.sheet {
                writeln!(f, "{:width$}                 {}", "", sheet.display())?;
            }
        }
        let count = |word: &str| self.rows.iter().filter(|row| row.verdict.word() == word).count();
        let (all, pass, new) = (self.rows.len(), count("pass"), count("new"));
        writeln!(f, "{all} proposals: {pass} pass, {} fail, {new} new", all - pass - new)?;
        if !self.without_proposal.is_empty() {
            let names = self.without_proposal.join(", ");
            writeln!(f, "accepted, without a proposal (they passed, or no test makes them): {names}")?;
        }
        Ok(())
    }
}

/// What [`GoldenSet::accept`] did; prints a line for each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// What became of each proposal, by name.
    pub rows: Vec<(String, Acceptance)>,
}

/// What accepting changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceptance {
    /// There was no such golden.
    Added,
    /// The accepted file was another.
    Replaced,
    /// The accepted file had the same bytes.
    Unchanged,
}

impl fmt::Display for Accepted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, acceptance) in &self.rows {
            writeln!(f, "{name}: {}", format!("{acceptance:?}").to_lowercase())?;
        }
        if self.rows.is_empty() { writeln!(f, "no proposals to accept") } else { Ok(()) }
    }
}

impl GoldenSet {
    /// Names and kinds of all proposals in the work folder, by name.
    pub fn proposals(&self) -> Result<Vec<(String, Kind)>, GoldenError> {
        pictures_in(&self.work_dir, ".new")
    }

    /// Compares every proposal with what is accepted, and writes a sheet of each.
    ///
    /// Radiance is tone-mapped at the exposure of the accepted picture, so that a change in brightness shows.
    pub fn review(&self) -> Result<Review, GoldenError> {
        let proposals = self.proposals()?;
        let mut rows = Vec::new();
        for (name, kind) in &proposals {
            rows.push(self.review_one(name, *kind)?);
        }
        let mut without_proposal: Vec<String> =
            pictures_in(&self.accepted_dir, "")?.into_iter().map(|(name, _)| name).collect();
        without_proposal.retain(|name| !proposals.iter().any(|(proposed, _)| proposed == name));
        Ok(Review { rows, without_proposal })
    }

    fn review_one(&self, name: &str, kind: Kind) -> Result<ReviewRow, GoldenError> {
        let row = |verdict, numbers, sheet| ReviewRow { name: name.to_owned(), kind, verdict, numbers, sheet };
        let new = match self.read_proposal(name, kind) {
            Ok(new) => new,
            Err(why) => return Ok(row(Verdict::Broken(why), None, None)),
        };
        let tolerance_path = self.work_path(name, "new.txt");
        let limits = std::fs::read_to_string(&tolerance_path).ok().and_then(|t| parse_tolerance_file(kind, &t));
        let judgement = self.judge(name, kind, &new, &limits.unwrap_or(default_limits(kind)))?;
        let sheet_path = self.work_path(name, "sheet.png");
        let written = write_sheet(&sheet_path, &new, &judgement).is_ok();
        let verdict = match (limits, judgement.verdict) {
            (None, Verdict::Pass | Verdict::Fail(_)) => {
                Verdict::Broken(format!("no tolerance is recorded in {}", tolerance_path.display()))
            }
            (_, verdict) => verdict,
        };
        let numbers = if limits.is_some() { judgement.numbers } else { None };
        Ok(row(verdict, numbers, written.then_some(sheet_path)))
    }

    /// The proposal, whole and finite; the error is a clause.
    fn read_proposal(&self, name: &str, kind: Kind) -> Result<Picture, String> {
        let new = read_picture(&self.proposal_path(name, kind), kind)
            .and_then(|picture| picture.ok_or("gone".to_owned()))
            .map_err(|e| format!("the proposal is {e}"))?;
        match new.non_finite().len() {
            0 => Ok(new),
            n => Err(format!("the proposal has {n} pixels that are NaN or infinite")),
        }
    }

    /// Moves the proposals of these goldens into the accepted folder; all of them, or none where a name has no
    /// proposal or its proposal is not a whole picture.
    pub fn accept<S: AsRef<str>>(&self, names: &[S]) -> Result<Accepted, GoldenError> {
        let available = self.proposals()?;
        let mut chosen = Vec::new();
        for name in names {
            let name = name.as_ref();
            check_name(name)?;
            let found: Vec<_> = available.iter().filter(|(proposed, _)| proposed == name).cloned().collect();
            if found.is_empty() {
                let names: Vec<&str> = available.iter().map(|(name, _)| name.as_str()).collect();
                let available = match names.as_slice() {
                    [] => "there are none".to_owned(),
                    names => format!("these have: {}", names.join(", ")),
                };
                return Err(GoldenError::NoProposal { name: name.to_owned(), available });
            }
            chosen.extend(found);
        }
        chosen.sort_by(|a, b| a.0.cmp(&b.0));
        chosen.dedup();
        for (name, kind) in &chosen {
            let unreadable = |reason| GoldenError::Unreadable { reason, path: self.proposal_path(name, *kind) };
            self.read_proposal(name, *kind).map_err(unreadable)?;
        }
        let mut rows = Vec::new();
        for (name, kind) in chosen {
            rows.push((name.clone(), self.accept_one(&name, kind)?));
        }
        Ok(Accepted { rows })
    }

    /// Moves every proposal into the accepted folder, also those that pass.
    pub fn accept_all(&self) -> Result<Accepted, GoldenError> {
        let names: Vec<String> = self.proposals()?.into_iter().map(|(name, _)| name).collect();
        self.accept(&names)
    }

    /// Copies rather than renames: `target/` may be another file system.
    fn accept_one(&self, name: &str, kind: Kind) -> Result<Acceptance, GoldenError> {
        let (from, to) = (self.proposal_path(name, kind), self.accepted_path(name, kind));
        let bytes = std::fs::read(&from).map_err(GoldenError::io("read the proposal", &from))?;
        let acceptance = match std::fs::read(&to) {
            Ok(old) if old == bytes => Acceptance::Unchanged,
            Ok(_) => Acceptance::Replaced,
            Err(_) => Acceptance::Added,
        };
        if acceptance != Acceptance::Unchanged {
            write_whole(&to, &bytes)?;
        }
        self.clear(name)?;
        Ok(acceptance)
    }

    /// Removes all proposals, heat maps and sheets, so that none outlives its test.
    pub fn clear_proposals(&self) -> Result<(), GoldenError> {
        self.proposals()?.iter().try_for_each(|(name, _)| self.clear(name))
    }
}

/// Names and kinds of the files `NAME{suffix}.exr` and `NAME{suffix}.png`, by name; none where there is no such folder.
fn pictures_in(folder: &std::path::Path, suffix: &str) -> Result<Vec<(String, Kind)>, GoldenError> {
    let listing = || GoldenError::io("list the folder", folder);
    let entries = match std::fs::read_dir(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(listing())?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let file_name = entry.map_err(listing())?.file_name();
        for kind in Kind::ALL {
            let ending = format!("{suffix}.{}", kind.extension());
            let name = file_name.to_str().and_then(|f| f.strip_suffix(ending.as_str()));
            // Every name that a check could have given; this also leaves out `NAME.diff.png` and hidden files.
            found.extend(name.filter(|n| check_name(n).is_ok()).map(|n| (n.to_owned(), kind)));
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(found)
}

fn default_limits(kind: Kind) -> Limits {
    match kind {
        Kind::Exr => Limits::Exr(Default::default()),
        Kind::Png => Limits::Png(Default::default()),
    }
}

fn write_sheet(path: &std::path::Path, new: &Picture, judgement: &Judgement) -> Result<(), GoldenError> {
    let exposure = judgement.accepted.as_ref().unwrap_or(new).exposure();
    let panels = [
        judgement.accepted.as_ref().map(|picture| picture.shown(exposure)),
        Some(new.shown(exposure)),
        judgement.heat.clone(),
    ];
    write_whole(path, &encode_png(&sheet(&panels, new.size())?)?)
}
