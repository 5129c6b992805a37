//! Shader modules: plain WGSL files, joined by `//#include "path"` lines, each file once.
//!
//! WGSL needs no order of declarations, so an include is a concatenation. The text that runs is the text in the files:
//! errors point to real lines, and an editor can replace one file and link again.

/// Every WGSL file by the path that `#include` uses.
pub const FILES: &[(&str, &str)] = &[
    ("comparison/empty.wgsl", include_str!("comparison/empty.wgsl")),
    ("comparison/hillaire.wgsl", include_str!("comparison/hillaire.wgsl")),
    ("comparison/hillaire_sky.wgsl", include_str!("comparison/hillaire_sky.wgsl")),
    ("comparison/hillaire_tables.wgsl", include_str!("comparison/hillaire_tables.wgsl")),
    ("frame/frame.wgsl", include_str!("frame/frame.wgsl")),
    ("frame/sphere.wgsl", include_str!("frame/sphere.wgsl")),
    ("output/bloom.wgsl", include_str!("output/bloom.wgsl")),
    ("output/dither.wgsl", include_str!("output/dither.wgsl")),
    ("output/eye.wgsl", include_str!("output/eye.wgsl")),
    ("output/meter.wgsl", include_str!("output/meter.wgsl")),
    ("output/tonemap.wgsl", include_str!("output/tonemap.wgsl")),
    ("phenomena/air/aerial.wgsl", include_str!("phenomena/air/aerial.wgsl")),
    ("phenomena/air/apply.wgsl", include_str!("phenomena/air/apply.wgsl")),
    ("phenomena/air/build/build.wgsl", include_str!("phenomena/air/build/build.wgsl")),
    ("phenomena/air/build/fill.wgsl", include_str!("phenomena/air/build/fill.wgsl")),
    ("phenomena/air/build/first.wgsl", include_str!("phenomena/air/build/first.wgsl")),
    ("phenomena/air/build/next.wgsl", include_str!("phenomena/air/build/next.wgsl")),
    ("phenomena/air/build/rays.wgsl", include_str!("phenomena/air/build/rays.wgsl")),
    ("phenomena/air/build/resolve.wgsl", include_str!("phenomena/air/build/resolve.wgsl")),
    ("phenomena/air/cells.wgsl", include_str!("phenomena/air/cells.wgsl")),
    ("phenomena/air/depth.wgsl", include_str!("phenomena/air/depth.wgsl")),
    ("phenomena/air/froxels.wgsl", include_str!("phenomena/air/froxels.wgsl")),
    ("phenomena/air/march.wgsl", include_str!("phenomena/air/march.wgsl")),
    ("phenomena/air/medium.wgsl", include_str!("phenomena/air/medium.wgsl")),
    ("phenomena/air/query.wgsl", include_str!("phenomena/air/query.wgsl")),
    ("phenomena/air/sky_view.wgsl", include_str!("phenomena/air/sky_view.wgsl")),
    ("phenomena/air/sky_view_refine.wgsl", include_str!("phenomena/air/sky_view_refine.wgsl")),
    ("phenomena/air/sky_view_table.wgsl", include_str!("phenomena/air/sky_view_table.wgsl")),
    ("phenomena/bodies/bodies.wgsl", include_str!("phenomena/bodies/bodies.wgsl")),
    ("phenomena/ground/ground.wgsl", include_str!("phenomena/ground/ground.wgsl")),
    ("phenomena/moon/moon.wgsl", include_str!("phenomena/moon/moon.wgsl")),
    ("phenomena/moon/uniform.wgsl", include_str!("phenomena/moon/uniform.wgsl")),
    ("phenomena/overlay/lines.wgsl", include_str!("phenomena/overlay/lines.wgsl")),
    ("phenomena/overlay/names.wgsl", include_str!("phenomena/overlay/names.wgsl")),
    ("phenomena/planets/disc.wgsl", include_str!("phenomena/planets/disc.wgsl")),
    ("phenomena/planets/shade.wgsl", include_str!("phenomena/planets/shade.wgsl")),
    ("phenomena/stars/binned.wgsl", include_str!("phenomena/stars/binned.wgsl")),
    ("phenomena/stars/bins.wgsl", include_str!("phenomena/stars/bins.wgsl")),
    ("phenomena/stars/move.wgsl", include_str!("phenomena/stars/move.wgsl")),
    ("phenomena/stars/points.wgsl", include_str!("phenomena/stars/points.wgsl")),
    ("phenomena/stars/psf.wgsl", include_str!("phenomena/stars/psf.wgsl")),
    ("phenomena/stars/wide.wgsl", include_str!("phenomena/stars/wide.wgsl")),
    ("phenomena/night_glow/grid.wgsl", include_str!("phenomena/night_glow/grid.wgsl")),
    ("phenomena/night_glow/night_glow.wgsl", include_str!("phenomena/night_glow/night_glow.wgsl")),
    ("phenomena/sun/bending.wgsl", include_str!("phenomena/sun/bending.wgsl")),
    ("phenomena/sun/disc.wgsl", include_str!("phenomena/sun/disc.wgsl")),
    ("phenomena/sun/eclipse.wgsl", include_str!("phenomena/sun/eclipse.wgsl")),
    ("phenomena/sun/sun.wgsl", include_str!("phenomena/sun/sun.wgsl")),
    ("sky.wgsl", include_str!("sky.wgsl")),
];

/// The files that are entry points of pipelines.
pub const ROOTS: &[&str] = &[
    "sky.wgsl",
    "output/bloom.wgsl",
    "output/meter.wgsl",
    "comparison/empty.wgsl",
    "comparison/hillaire_sky.wgsl",
    "comparison/hillaire_tables.wgsl",
    "phenomena/air/depth.wgsl",
    "phenomena/air/build/rays.wgsl",
    "phenomena/air/build/first.wgsl",
    "phenomena/air/build/next.wgsl",
    "phenomena/air/build/resolve.wgsl",
    "phenomena/air/cells.wgsl",
    "phenomena/air/sky_view.wgsl",
    "phenomena/air/sky_view_refine.wgsl",
    "phenomena/air/query.wgsl",
    "phenomena/air/froxels.wgsl",
    "phenomena/air/apply.wgsl",
    "phenomena/night_glow/grid.wgsl",
    "phenomena/stars/move.wgsl",
    "phenomena/stars/bins.wgsl",
    "phenomena/stars/wide.wgsl",
    "phenomena/bodies/bodies.wgsl",
    "phenomena/planets/disc.wgsl",
    "phenomena/overlay/lines.wgsl",
    "phenomena/overlay/names.wgsl",
];

/// Why shader files could not be joined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{from} includes \"{path}\", which does not exist")]
pub struct IncludeError {
    /// The file with the line.
    pub from: String,
    /// What it asks for.
    pub path: String,
}

/// Joins a file with everything it includes. `read` gives the text of a path.
pub fn link<'a>(root: &str, read: impl Fn(&str) -> Option<&'a str>) -> Result<String, IncludeError> {
    let mut order: Vec<(String, &'a str)> = Vec::new();
    let mut waiting = vec![(String::from("the renderer"), root.to_string())];
    while let Some((from, path)) = waiting.pop() {
        if order.iter().any(|(seen, _)| *seen == path) {
            continue;
        }
        let Some(text) = read(&path) else { return Err(IncludeError { from, path }) };
        let includes = text.lines().filter_map(|line| line.trim().strip_prefix("//#include \"")?.strip_suffix('"'));
        waiting.extend(includes.map(|include| (path.clone(), include.to_string())));
        order.push((path, text));
    }
    Ok(order.into_iter().map(|(path, text)| format!("// ---- {path}\n{text}\n")).collect())
}

/// The text of a file that is compiled in.
pub fn embedded(path: &str) -> Option<&'static str> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}

/// One of [`ROOTS`] with all its includes.
pub fn module(root: &str) -> Result<String, IncludeError> {
    link(root, embedded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_root_links() {
        for root in ROOTS {
            let text = link(root, embedded).unwrap();
            assert_eq!(text.matches(&format!("// ---- {root}")).count(), 1);
        }
        assert_eq!(module("sky.wgsl").unwrap().matches("struct FrameUniform").count(), 1);
    }

    #[test]
    fn a_missing_include_names_both_files() {
        let read = |path: &str| (path == "a.wgsl").then_some("//#include \"b.wgsl\"\n");
        let error = link("a.wgsl", read).unwrap_err().to_string();
        assert_eq!(error, "a.wgsl includes \"b.wgsl\", which does not exist");
    }

    #[test]
    fn circles_end() {
        let read = |path: &str| Some(if path == "a" { "//#include \"b\"" } else { "//#include \"a\"" });
        assert_eq!(link("a", read).unwrap().matches("----").count(), 2);
    }
}
