//! Letters as a texture of distances to their outlines: sharp at any size, and a halo costs nothing more.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use ab_glyph::{Font, FontArc, GlyphId, OutlineCurve};
use glam::{DVec2, Vec2};

use crate::error::GpuError;

/// Texels for each em; glyphs of 10 to 40 px are drawn from them.
pub const TEXELS_PER_EM: f32 = 48.0;
/// Distances are kept up to this from an outline, em: as far as a halo goes.
pub const SPREAD_EM: f32 = 0.18;
/// Width of the atlas and most of its rows: what WebGL 2 guarantees.
const WIDTH: u32 = 1024;
const MOST_ROWS: u32 = 2048;
/// Side of the largest glyph, em, and most pieces of an outline: beyond is no letter.
const LARGEST_EM: f32 = 4.0;
const MOST_PIECES: usize = 4096;
/// Straight pieces of a curve: within 1e-3 em of it.
const PIECES_OF_CURVE: usize = 6;

/// A font's outlines.
pub struct Typeface {
    font: FontArc,
    em: f32,
}

impl fmt::Debug for Typeface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Typeface of {} glyphs", self.font.glyph_count())
    }
}

impl Typeface {
    /// A font that is compiled in: TrueType or OpenType.
    pub fn built_in(bytes: &'static [u8]) -> Result<Self, GpuError> {
        Self::of(FontArc::try_from_slice(bytes))
    }

    /// A font that was read from a file.
    pub fn read(bytes: Vec<u8>) -> Result<Self, GpuError> {
        Self::of(FontArc::try_from_vec(bytes))
    }

    fn of(font: Result<FontArc, ab_glyph::InvalidFont>) -> Result<Self, GpuError> {
        let refused = || GpuError::Font("it is no TrueType or OpenType font".into());
        let font = font.map_err(|_| refused())?;
        let em = font.units_per_em().filter(|em| *em >= 16.0).ok_or_else(refused)?;
        Ok(Self { font, em })
    }

    /// Whether there is a glyph for a letter.
    pub fn has(&self, letter: char) -> bool {
        self.font.glyph_id(letter).0 != 0
    }

    /// Glyphs of a line of text with the places of their pens, em; and where it ends. `spacing`: between letters, em.
    pub(super) fn line(&self, text: &str, spacing: f64) -> (Vec<(GlyphId, f64)>, f64) {
        let mut glyphs: Vec<(GlyphId, f64)> = Vec::new();
        let mut pen = 0.0;
        for letter in text.chars() {
            let glyph = self.font.glyph_id(letter);
            if let Some(&(before, _)) = glyphs.last() {
                pen += spacing + f64::from(self.font.kern_unscaled(before, glyph) / self.em);
            }
            glyphs.push((glyph, pen));
            pen += f64::from(self.font.h_advance_unscaled(glyph) / self.em).clamp(0.0, f64::from(LARGEST_EM));
        }
        (glyphs, pen)
    }

    /// Outline in straight pieces, em; empty where there is nothing to draw.
    fn pieces(&self, glyph: GlyphId) -> Vec<[Vec2; 2]> {
        let Some(outline) = self.font.outline(glyph) else { return Vec::new() };
        let at = |p: ab_glyph::Point| Vec2::new(p.x, p.y) / self.em;
        let mut pieces = Vec::new();
        let mut curve = |place: &dyn Fn(f32) -> Vec2| {
            let step = |i: usize| place(i as f32 / PIECES_OF_CURVE as f32);
            pieces.extend((0..PIECES_OF_CURVE).map(|i| [step(i), step(i + 1)]));
        };
        let mut lines = Vec::new();
        for piece in outline.curves {
            match piece {
                OutlineCurve::Line(a, b) => lines.push([at(a), at(b)]),
                OutlineCurve::Quad(a, b, c) => {
                    let (a, b, c) = (at(a), at(b), at(c));
                    curve(&|t| a.lerp(b, t).lerp(b.lerp(c, t), t));
                }
                OutlineCurve::Cubic(a, b, c, d) => {
                    let (a, b, c, d) = (at(a), at(b), at(c), at(d));
                    curve(&|t| {
                        let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
                        ab.lerp(bc, t).lerp(bc.lerp(cd, t), t)
                    });
                }
            }
        }
        pieces.extend(lines);
        pieces.retain(|[a, b]| a.is_finite() && b.is_finite() && a != b);
        pieces
    }
}

/// Distance to an outline, em; positive inside (the winding number is not 0).
fn distance(pieces: &[[Vec2; 2]], place: Vec2) -> f32 {
    let (mut nearest, mut winding) = (f32::INFINITY, 0);
    for &[a, b] in pieces {
        let (along, to) = (b - a, place - a);
        let t = (to.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((to - along * t).length_squared());
        let left = along.perp_dot(to) > 0.0;
        if a.y <= place.y && b.y > place.y && left {
            winding += 1;
        } else if a.y > place.y && b.y <= place.y && !left {
            winding -= 1;
        }
    }
    if winding == 0 { -nearest.sqrt() } else { nearest.sqrt() }
}

/// Where a glyph lies in the atlas, and around its pen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    /// Left, bottom, right, top, em.
    pub box_em: [f32; 4],
    /// The same in the atlas, 0..1; rows run downward.
    pub uv: [f32; 4],
}

/// Glyphs side by side: a byte for each texel, 0.5 on the outline, [`SPREAD_EM`] away 0 or 1.
pub(super) struct Atlas {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<u8>,
    cells: BTreeMap<GlyphId, Cell>,
}

impl Atlas {
    /// Of these glyphs; those that have no outline, or for which there is no room, are left out.
    pub(super) fn new(typeface: &Typeface, glyphs: &BTreeSet<GlyphId>) -> Self {
        let (mut x, mut y, mut shelf) = (0, 0, 0);
        let mut placed = Vec::new();
        for &glyph in glyphs {
            let pieces = typeface.pieces(glyph);
            let ends = || pieces.iter().flatten().copied();
            let (Some(low), Some(high)) = (ends().reduce(Vec2::min), ends().reduce(Vec2::max)) else { continue };
            let (low, high) = (low - SPREAD_EM, high + SPREAD_EM);
            if (high - low).max_element() > LARGEST_EM || pieces.len() > MOST_PIECES {
                continue;
            }
            let size = ((high - low) * TEXELS_PER_EM).ceil().as_uvec2().max(glam::UVec2::ONE);
            if x + size.x > WIDTH {
                (x, y, shelf) = (0, y + shelf, 0);
            }
            if y + size.y > MOST_ROWS {
                break;
            }
            placed.push((glyph, pieces, low, size, [x, y]));
            (x, shelf) = (x + size.x, shelf.max(size.y));
        }
        let height = (y + shelf).max(1);
        let mut texels = vec![0u8; (WIDTH * height) as usize];
        let mut cells = BTreeMap::new();
        for (glyph, pieces, low, size, [left, top]) in placed {
            let high = low + size.as_vec2() / TEXELS_PER_EM;
            for row in 0..size.y {
                for column in 0..size.x {
                    let offset = Vec2::new(column as f32 + 0.5, -(row as f32 + 0.5)) / TEXELS_PER_EM;
                    let inside = distance(&pieces, Vec2::new(low.x, high.y) + offset);
                    let code = (0.5 + inside / (2.0 * SPREAD_EM)).clamp(0.0, 1.0) * 255.0;
                    texels[((top + row) * WIDTH + left + column) as usize] = code.round() as u8;
                }
            }
            let of = DVec2::new(f64::from(WIDTH), f64::from(height));
            let corner = |x: u32, y: u32| (DVec2::new(f64::from(x), f64::from(y)) / of).as_vec2();
            let (upper, lower) = (corner(left, top), corner(left + size.x, top + size.y));
            let cell = Cell { box_em: [low.x, low.y, high.x, high.y], uv: [upper.x, lower.y, lower.x, upper.y] };
            cells.insert(glyph, cell);
        }
        Self { width: WIDTH, height, texels, cells }
    }

    pub(super) fn cell(&self, glyph: GlyphId) -> Option<Cell> {
        self.cells.get(&glyph).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square ring, drawn as fonts do: the hole runs the other way round.
    fn ring() -> Vec<[Vec2; 2]> {
        let square = |r: f32, turn: f32| {
            let corners = [(-r, -r * turn), (r, -r * turn), (r, r * turn), (-r, r * turn)];
            let corner = move |i: usize| Vec2::new(corners[i % 4].0, corners[i % 4].1);
            (0..4).map(move |i| [corner(i), corner(i + 1)])
        };
        square(0.5, 1.0).chain(square(0.25, -1.0)).collect()
    }

    #[test]
    fn distances_are_those_to_the_outline_and_positive_inside() {
        let pieces = ring();
        for (place, expected) in
            [((0.0, 0.0), -0.25), ((0.375, 0.0), 0.125), ((0.3, 0.1), 0.05), ((0.7, 0.0), -0.2), ((0.8, 0.9), -0.5)]
        {
            let got = distance(&pieces, Vec2::new(place.0, place.1));
            assert!((got - expected).abs() < 1e-6, "{place:?}: {got} for {expected}");
        }
    }

    #[test]
    fn what_is_no_font_is_refused() {
        for bytes in [Vec::new(), b"no font".to_vec(), vec![0; 4096]] {
            let error = Typeface::read(bytes).unwrap_err().to_string();
            assert!(error.contains("TrueType"), "{error}");
        }
    }
}
