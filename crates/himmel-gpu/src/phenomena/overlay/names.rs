//! Names over the sky: what is written where, and what gives way to what.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::names_params::NamesParams;
use super::typeface::{Atlas, Cell, Typeface};
use crate::view::{Projection, View};

/// Most bodies of a frame that have names.
pub const MOST_NAMED_BODIES: usize = 16;
/// Letters of the longest name.
const LONGEST: usize = 48;
/// What is free between two names at least, em.
const APART_EM: f64 = 0.6;
/// From a point to its name, em.
const GAP_EM: f64 = 0.5;
/// From the baseline to the middle of small letters, em.
const MIDDLE_EM: f64 = 0.26;
/// Half of a line's height with what is free above it, em.
pub(super) const HALF_LINE_EM: f64 = 0.65;
/// Share of the room of two names that a constellation's and a star's get: they touch where one lies straight beside the other.
const CLOSE: f64 = 0.6;
/// A scale that no picture has: what f32 holds.
const NEVER: f64 = 1e30;

/// What a name belongs to; colour and size follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LabelKind {
    /// A star.
    Star,
    /// A constellation.
    Constellation,
    /// Sun, Moon, planets and other bodies.
    Body,
    /// A cardinal point.
    Cardinal,
    /// A line of the equatorial grid.
    Equatorial,
    /// A line of the horizontal grid.
    Horizontal,
}

impl LabelKind {
    pub(super) const COUNT: usize = 6;

    pub(super) fn index(self) -> usize {
        self as usize
    }

    /// Of the letters, relative to the size that is set.
    fn size(self) -> f64 {
        match self {
            Self::Star => 1.0,
            Self::Constellation => 1.0,
            Self::Body => 1.1,
            Self::Cardinal => 1.3,
            Self::Equatorial | Self::Horizontal => 0.85,
        }
    }

    /// Between letters, em.
    fn spacing(self) -> f64 {
        if self == Self::Constellation { 0.12 } else { 0.0 }
    }

    /// Lower left end of a line of that width relative to what it names, em.
    fn corner(self, width: f64) -> [f64; 2] {
        match self {
            Self::Star | Self::Body => [GAP_EM, -MIDDLE_EM],
            Self::Constellation => [-0.5 * width, -MIDDLE_EM],
            // Below the horizon.
            Self::Cardinal => [-0.5 * width, -1.0],
            // Off the line's crossing.
            Self::Equatorial | Self::Horizontal => [0.25, 0.3],
        }
    }
}

/// What a name stands beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// What turns with the stars.
    Sky {
        /// Unit vector at J2000.0, ICRS.
        place: DVec3,
        /// Its change per Julian year.
        velocity_per_year: DVec3,
        /// Annual parallax, rad.
        parallax_rad: f64,
    },
    /// A direction as it is seen, east-north-up.
    Seen(DVec3),
    /// The visible horizon below or above a direction, east-north-up.
    Horizon(DVec3),
    /// A body, by its place in [`Names::bodies`].
    Body(usize),
}

impl Anchor {
    /// What rests among the stars.
    pub fn fixed(place: DVec3) -> Self {
        Self::Sky { place, velocity_per_year: DVec3::ZERO, parallax_rad: 0.0 }
    }
}

/// A name.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// What is written; what is longer than 48 letters is cut off.
    pub text: String,
    /// What it belongs to.
    pub kind: LabelKind,
    /// Where it stands.
    pub anchor: Anchor,
    /// Of two that are in each other's way the one with the larger number gives way: a star's V.
    pub magnitude: f64,
}

/// A name with its letters laid out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Laid {
    pub label: Label,
    /// Farthest left and right of what it names, em.
    pub reach: [f64; 2],
    /// It is shown where a radian has so many em.
    pub from_scale: f64,
}

/// Names, in the order in which they are drawn: stars last, brightest first.
#[derive(Debug)]
pub struct LabelList {
    typeface: Arc<Typeface>,
    laid: Vec<Laid>,
    first_star: usize,
}

impl PartialEq for LabelList {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.typeface, &other.typeface) && self.laid == other.laid
    }
}

/// A letter of the list: its name, and its box from what is named, em and in the atlas.
pub(super) struct Letter {
    pub label: usize,
    pub box_em: [f32; 4],
    pub uv: [f32; 4],
}

impl LabelList {
    /// Lays them out; leaves out what is not finite.
    pub fn new(typeface: Arc<Typeface>, mut labels: Vec<Label>) -> Self {
        labels.retain(|label| {
            let place = match label.anchor {
                Anchor::Sky { place, velocity_per_year, parallax_rad } => place + velocity_per_year + parallax_rad,
                Anchor::Seen(place) | Anchor::Horizon(place) => place,
                Anchor::Body(index) => DVec3::splat(if index < MOST_NAMED_BODIES { 1.0 } else { f64::NAN }),
            };
            place.is_finite() && place.length_squared() > 0.0 && label.magnitude.is_finite() && !label.text.is_empty()
        });
        for label in &mut labels {
            if let Some((end, _)) = label.text.char_indices().nth(LONGEST) {
                label.text.truncate(end);
            }
        }
        labels.sort_by(|a, b| a.magnitude.total_cmp(&b.magnitude));
        let mut laid: Vec<Laid> = (labels.into_iter())
            .map(|label| {
                let (_, width) = typeface.line(&label.text, label.kind.spacing());
                let [left, _] = label.kind.corner(width);
                let reach = [-left, left + width].map(|end| label.kind.size() * end.max(0.0));
                Laid { label, reach, from_scale: 0.0 }
            })
            .collect();
        make_room(&mut laid);
        laid.sort_by_key(|laid| laid.label.kind == LabelKind::Star);
        let first_star = laid.partition_point(|laid| laid.label.kind != LabelKind::Star);
        Self { typeface, laid, first_star }
    }

    /// All of them, in the order in which they are drawn.
    pub fn labels(&self) -> impl Iterator<Item = &Label> {
        self.laid.iter().map(|laid| &laid.label)
    }

    pub(super) fn laid(&self) -> &[Laid] {
        &self.laid
    }

    /// Names that are drawn where stars have names to a magnitude.
    pub(super) fn count_to(&self, magnitude: f64) -> usize {
        let stars = self.laid.get(self.first_star..).unwrap_or_default();
        self.first_star + stars.partition_point(|laid| laid.label.magnitude <= magnitude)
    }

    /// Letters that have no glyph in the list's typeface.
    pub fn missing(&self) -> BTreeSet<char> {
        let letters = self.laid.iter().flat_map(|laid| laid.label.text.chars());
        letters.filter(|&letter| !self.typeface.has(letter)).collect()
    }

    /// The letters of all names, and the atlas that holds them.
    pub(super) fn letters(&self) -> (Vec<Letter>, Atlas) {
        let line = |laid: &Laid| self.typeface.line(&laid.label.text, laid.label.kind.spacing());
        let lines: Vec<_> = self.laid.iter().map(line).collect();
        let used = lines.iter().flat_map(|(glyphs, _)| glyphs.iter().map(|&(glyph, _)| glyph)).collect();
        let atlas = Atlas::new(&self.typeface, &used);
        let mut letters = Vec::new();
        for (index, (laid, (glyphs, width))) in self.laid.iter().zip(lines).enumerate() {
            let kind = laid.label.kind;
            let (size, [left, base]) = (kind.size(), kind.corner(width));
            for (glyph, pen) in glyphs {
                let Some(Cell { box_em: [x0, y0, x1, y1], uv }) = atlas.cell(glyph) else { continue };
                let (across, up) = (|x: f32| left + pen + f64::from(x), |y: f32| base + f64::from(y));
                let box_em = [across(x0), up(y0), across(x1), up(y1)].map(|end| (size * end) as f32);
                letters.push(Letter { label: index, box_em, uv });
            }
        }
        (letters, atlas)
    }
}

/// Decides from which scale on each name is shown; they come brightest first.
///
/// Two names are in each other's way where the angle between what they name has fewer em than both need side by side, however
/// the picture is turned. So what is shown hangs on the scale alone, and nothing comes or goes while the camera turns. The
/// fainter one waits until they are apart, if the brighter one is there before that.
fn make_room(laid: &mut [Laid]) {
    let frame = |anchor: &Anchor| match *anchor {
        Anchor::Sky { place, .. } => Some((true, place.normalize())),
        Anchor::Seen(place) | Anchor::Horizon(place) => Some((false, place.normalize())),
        // Bodies wander: see `beside`.
        Anchor::Body(_) => None,
    };
    for sky in [true, false] {
        let mut before: Vec<(DVec3, [f64; 2], bool, f64)> = Vec::new();
        for own in laid.iter_mut() {
            let Some((_, place)) = frame(&own.label.anchor).filter(|(of_sky, _)| *of_sky == sky) else { continue };
            let is_figure = own.label.kind == LabelKind::Constellation;
            let mut scale = 0f64;
            for &(other, reach, figure, from) in &before {
                let room = (own.reach[0] + reach[1]).max(own.reach[1] + reach[0]) + APART_EM;
                let needed = if figure == is_figure { room } else { CLOSE * room };
                let apart = (place - other).length();
                let until = if apart * NEVER > needed { needed / apart } else { NEVER };
                if from < until {
                    scale = scale.max(until);
                }
            }
            own.from_scale = scale;
            before.push((place, own.reach, is_figure, scale));
        }
    }
}

/// A body that has a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedBody {
    /// Unit vector to it, without refraction, east-north-up.
    pub direction: DVec3,
    /// Apparent radius, rad: the name stands beside the disc.
    pub radius_rad: f64,
}

/// On which side of its body a name stands in a view: the right one, else the left one, else it is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Beside {
    /// Ends of disc and name from the body, em.
    pub ends: [f64; 2],
    /// How far the name is moved from the right side, em.
    pub shift: f64,
    pub shown: bool,
}

/// Where right is in a picture, in view space.
fn right_of(view: &View, direction: DVec3) -> DVec3 {
    if view.projection == Projection::Equirectangular {
        let up = DMat3::from_mat4(view.enu_from_view).transpose() * DVec3::Z;
        return direction.cross(up).normalize_or(DVec3::X);
    }
    DVec3::X
}

/// Bodies one after the other, as far as there is room. `bodies`: direction in view space and radius; `reach`: of their names, em;
/// `scale`: em of a radian.
pub(super) fn beside(view: &View, bodies: &[(DVec3, f64)], reach: &[f64], scale: f64) -> Vec<Beside> {
    let mut all: Vec<Beside> = Vec::new();
    for (index, &(direction, radius_rad)) in bodies.iter().enumerate() {
        let (disc, reach) = (radius_rad * scale, reach.get(index).copied().unwrap_or(0.0));
        let right = right_of(view, direction);
        let up = right.cross(direction);
        let free = |[left, end]: [f64; 2]| {
            bodies.iter().zip(&all).all(|(&(other, other_rad), placed)| {
                let away = (other - direction) * scale;
                let high = 2.0 * HALF_LINE_EM.max(0.5 * (HALF_LINE_EM + other_rad * scale));
                !placed.shown
                    || direction.dot(other) < 0.0
                    || away.dot(up).abs() > high
                    || away.dot(right) + placed.ends[0] > end
                    || away.dot(right) + placed.ends[1] < left
            })
        };
        let gap = GAP_EM * LabelKind::Body.size();
        let sides = [(0.0, [disc, disc + reach]), (-reach - gap, [-disc - reach, -disc])];
        let chosen = sides.into_iter().find(|(_, ends)| free(*ends));
        all.push(chosen.map_or(Beside::default(), |(shift, [left, end])| Beside {
            ends: [left.min(-disc), end.max(disc)],
            shift,
            shown: true,
        }));
    }
    all
}

/// The names of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Names {
    /// Uploaded when it is another one than before.
    pub list: Arc<LabelList>,
    /// How they are drawn.
    pub params: NamesParams,
    /// Those that names are anchored to; at most 16.
    pub bodies: Vec<NamedBody>,
    /// Julian years since J2000.0.
    pub years_since_j2000: f64,
    /// The observer's velocity by the speed of light, ICRS axes.
    pub beta: DVec3,
    /// The observer from the barycentre, au, ICRS axes.
    pub observer_au: DVec3,
    /// Stars fainter than this have no name: they are not drawn.
    pub limiting_magnitude: f64,
}

/// Vertical field of view, rad.
fn field_of(view: &View) -> f64 {
    match view.projection {
        Projection::Fisheye(span) => span,
        Projection::Equirectangular => PI,
        Projection::Matrix(_) => {
            let [below, above] = [-1.0, 1.0].map(|y| view.direction([0.0, y]).unwrap_or(DVec3::Z));
            below.angle_between(above)
        }
    }
}

/// Faintest star with a name in a view: m + 4 lg(60°/field). The sky has 10^(0.5 m) stars brighter than m [allen1973] and a
/// field shows its square of them, so that each field has about as many names.
pub(super) fn faintest(magnitude: f64, view: &View) -> f64 {
    magnitude + 4.0 * (60f64.to_radians() / field_of(view).max(1e-9)).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(degrees: f64, width: f64, magnitude: f64) -> Laid {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let anchor = Anchor::fixed(DVec3::new(cos, sin, 0.0));
        let label = Label { text: "x".into(), kind: LabelKind::Star, anchor, magnitude };
        Laid { label, reach: [0.0, width], from_scale: 0.0 }
    }

    /// At every scale no two that are shown are in each other's way, and what is shown stays when the scale grows.
    #[test]
    fn the_fainter_one_gives_way_and_none_overlap() {
        let mut random = 1u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut all: Vec<Laid> = (0..200).map(|i| laid(20.0 * next(), 1.0 + 5.0 * next(), f64::from(i))).collect();
        make_room(&mut all);
        assert_eq!(all[0].from_scale, 0.0, "the brightest one is always there");
        let mut most = 0;
        for scale in [10.0, 40.0, 200.0, 1000.0, 5000.0] {
            let shown: Vec<&Laid> = all.iter().filter(|laid| laid.from_scale <= scale).collect();
            for (i, a) in shown.iter().enumerate() {
                for b in &shown[..i] {
                    let (Anchor::Sky { place: p, .. }, Anchor::Sky { place: q, .. }) = (a.label.anchor, b.label.anchor)
                    else {
                        unreachable!()
                    };
                    let needed = a.reach[1].max(b.reach[1]) + APART_EM;
                    assert!((p - q).length() * scale >= needed * (1.0 - 1e-12), "{a:?} {b:?} at {scale}");
                }
            }
            assert!(shown.len() >= most);
            most = shown.len();
        }
        assert!(most > 100, "{most}");
    }

    /// A name that is hidden itself hides nothing: the third one need not wait for the second.
    #[test]
    fn what_is_hidden_hides_nothing() {
        let mut all = [laid(0.0, 2.4, 0.0), laid(0.9, 2.4, 1.0), laid(2.0, 2.4, 2.0)];
        make_room(&mut all);
        let radian = |degrees: f64| 3.0 / (2.0 * (0.5 * degrees.to_radians()).sin());
        assert!((all[1].from_scale / radian(0.9) - 1.0).abs() < 1e-9);
        assert!((all[2].from_scale / radian(2.0) - 1.0).abs() < 1e-9, "not 3 em by 1.1° from the second");
        let mut twins = [laid(5.0, 2.0, 0.0), laid(5.0, 2.0, 0.5)];
        make_room(&mut twins);
        assert_eq!((twins[0].from_scale, twins[1].from_scale), (0.0, NEVER));
    }

    /// Venus and Jupiter in March 2012, 3° apart: the fainter one's name goes to the left, a third one's nowhere.
    #[test]
    fn a_planet_beside_a_brighter_one_is_named_on_the_left() {
        let view = View::looking(0.0, 0.0, 1.0, 1.5);
        let at = |x: f64, y: f64| DVec3::new(x.to_radians(), y.to_radians(), -1.0).normalize();
        let bodies = [(at(0.0, 0.0), 0.0), (at(-3.0, -0.5), 0.0), (at(-2.9, -0.4), 0.0), (at(20.0, 0.0), 0.05)];
        let sides = beside(&view, &bodies, &[3.0; 4], 40.0);
        assert!(sides[0].shown && sides[0].shift == 0.0);
        assert!(sides[1].shown && sides[1].shift < 0.0 && sides[1].ends[0] == -3.0);
        assert!(!sides[2].shown);
        assert!(sides[3].shown && (sides[3].ends[1] - 5.0).abs() < 1e-12, "beside its disc of 2 em");
    }

    #[test]
    fn narrower_fields_name_fainter_stars() {
        let view = |fov: f64| View::looking(0.0, 0.5, fov.to_radians(), 1.5);
        assert!((faintest(3.0, &view(60.0)) - 3.0).abs() < 1e-9);
        assert!((faintest(3.0, &view(6.0)) - 7.0).abs() < 1e-9);
        for fov in [0.001, 179.0] {
            assert!(faintest(3.0, &view(fov)).is_finite());
        }
    }
}
