//! `Shape "curve"`: swept strips along Bézier splines, for hair and grass.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `point3 P` | required | control points, see below |
//! | `integer degree` | 3 | 2 or 3 |
//! | `string basis` | "bezier" | or "bspline" (uniform) |
//! | `string type` | "flat" | "flat" faces the ray, "cylinder" does too but is shaded as round, "ribbon" faces where N points |
//! | `normal N` | – | ribbon: one at each end of each segment, segments + 1 in all |
//! | `float width` | 1 | full width, object units |
//! | `float width0`, `width1` | width | at the first and at the last end, linear between |
//! | `integer splitdepth` (or `float`) | 3 | boxes per segment, as a power of two; speed only |
//!
//! A Bézier spline takes degree + 1 points, and degree more for each further segment; a B-spline
//! takes at least degree + 1, and has a segment for each one more. u runs from 0 to 1 along each
//! segment, v from 0 to 1 across it (docs/scene-language.md §3.7; Pharr, Jakob and Humphreys 2016, §3.7).
//!
//! Curves cannot be area lights: pbrt-v3 aborts, and here it is an error at the shape.

mod bezier;
mod segment;

pub use bezier::Bezier;
pub use segment::{CurveHit, Segment};

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, left_out, needed, triples};
use crate::math::transform::{Place, Transform, box_around};
use crate::math::{DMat4, DVec3};
use crate::params::ParamReader;
use crate::syntax::suggest::nearest;

/// More boxes per segment than 2 to this do not pay.
const MAX_SPLITS: i64 = 3;

/// A piece of a segment is at least about this many widths long: shorter ones have no tighter boxes.
const PIECE_WIDTHS: f64 = 4.0;

/// How a curve is shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// A ribbon that faces the ray.
    Flat,
    /// The same, shaded as the front of a cylinder.
    Cylinder,
    /// A strip that faces along its normals.
    Ribbon,
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSpec {
    /// How it is shaded.
    pub kind: CurveKind,
    /// The segments, object space.
    pub segments: Vec<Bezier>,
    /// For ribbons unit normals at the segments' ends, one more than segments; else empty.
    pub normals: Vec<DVec3>,
    /// Full widths at both ends of the whole spline, object units.
    pub width: [f64; 2],
    /// Boxes per segment are at most 2 to this.
    pub split_depth: u32,
}

impl CurveSpec {
    /// Reads the parameters; `None` where the control points or normals are missing or not as many
    /// as they must be (reported).
    pub fn from_params(reader: &ParamReader) -> Option<CurveSpec> {
        let width = read_widths(reader);
        let splits = match reader.find_float("splitdepth") {
            Some(float) if float.is_finite() => float as i64,
            _ => reader.integer("splitdepth", MAX_SPLITS),
        };
        let degree = match reader.integer("degree", 3) {
            degree @ (2 | 3) => degree as usize,
            other => {
                let why = format_args!("curves are of degree 2 or 3, not {other}");
                return left_out(reader, "degree", why);
            }
        };
        let basis = reader.one_of("basis", &["bezier", "bspline"]);
        let kind = read_kind(reader);
        let segments = read_segments(reader, basis, degree)?;
        let normals = read_normals(reader, kind, segments.len())?;
        Some(CurveSpec {
            kind,
            segments,
            normals,
            width,
            split_depth: splits.clamp(0, MAX_SPLITS) as u32,
        })
    }

    /// Places the curve.
    pub fn place(&self, level_from_object: &Transform, reverse_orientation: bool) -> Curves {
        let mirrors = level_from_object.swaps_handedness();
        let scale = level_from_object.similarity().filter(|_| !mirrors);
        // Widths and the strip's turning are object space's. Where the transformation keeps angles
        // the curve is placed once; elsewhere rays are taken to object space, counted from the
        // curve's first point so that single precision is spent on the curve.
        let (local_from_object, placement, scale) = match scale {
            Some(scale) => (*level_from_object, None, scale),
            None => {
                let anchor = self.segments.first().map_or(DVec3::ZERO, |s| s.0[0]);
                let placed =
                    (*level_from_object * Transform::translate(anchor)).with_translations_matched();
                let place = Place::new(&placed);
                (Transform::translate(-anchor), Some(place), 1.0)
            }
        };
        let count = self.segments.len() as f64;
        let width = |i: usize| {
            let t = i as f64 / count;
            scale * (self.width[0] * (1.0 - t) + self.width[1] * t)
        };
        let normal = |i: usize| {
            let n = self.normals.get(i).copied().unwrap_or(DVec3::Z);
            local_from_object.normal(n).normalize_or(DVec3::Z)
        };
        let segments = self.segments.iter().enumerate();
        Curves {
            kind: self.kind,
            flip: reverse_orientation ^ mirrors,
            placement,
            segments: segments
                .map(|(i, bezier)| PlacedSegment {
                    bezier: Bezier(bezier.0.map(|p| local_from_object.point(p))),
                    width: [width(i), width(i + 1)],
                    normals: [normal(i), normal(i + 1)],
                })
                .collect(),
            split_depth: self.split_depth,
        }
    }
}

impl ShapeType for CurveSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.needs_inverse()?;
        let curves = self.place(site.level_from_object, site.reverse_orientation);
        Ok(CompiledShape::Curves(Box::new(curves)))
    }
}

/// Full widths at both ends, never negative.
fn read_widths(reader: &ParamReader) -> [f64; 2] {
    let width = reader.float("width", 1.0);
    ["width0", "width1"].map(|name| {
        let (name, width) = match reader.find_float(name) {
            Some(width) => (name, width),
            None => ("width", width),
        };
        if width >= 0.0 && width.is_finite() {
            return width;
        }
        reader.warn(
            name,
            format!("`{name}` is {width}, no width: 0 is used, which nothing shows"),
        );
        0.0
    })
}

/// The segments of the spline with the control points given; `None` where these are missing or not as many as they
/// must be (reported).
fn read_segments(reader: &ParamReader, basis: &str, degree: usize) -> Option<Vec<Bezier>> {
    let message = "a curve needs control points: \"point3 P\"";
    let points = needed(reader, "P", reader.points3("P"), message)?;
    let points: Vec<DVec3> = triples(points).collect();
    // How many points each further segment takes.
    let (step, segment): (usize, fn(&[DVec3]) -> Bezier) = match basis {
        "bezier" => (degree, Bezier::from_bezier),
        _ => (1, Bezier::from_bspline),
    };
    if points.len() <= degree || !(points.len() - 1).is_multiple_of(step) {
        let more = match step {
            1 => "or more".to_string(),
            _ => format!("and {degree} more for each further segment"),
        };
        let (given, least) = (points.len(), degree + 1);
        let message = format!(
            "{given} control points: a {basis} curve of degree {degree} takes {least} {more}; the shape \
             is left out"
        );
        reader.error("P", message);
        return None;
    }
    let starts = (0..points.len() - degree).step_by(step);
    Some(starts.map(|i| segment(&points[i..=i + degree])).collect())
}

/// What is not known is a cylinder, as in pbrt-v3.
fn read_kind(reader: &ParamReader) -> CurveKind {
    match reader.string("type", "flat") {
        "flat" => CurveKind::Flat,
        "ribbon" => CurveKind::Ribbon,
        "cylinder" => CurveKind::Cylinder,
        other => {
            let mut message = format!(
                "`type` of a curve is \"flat\", \"ribbon\" or \"cylinder\", found \"{other}\": \
                 \"cylinder\" is used"
            );
            if let Some(meant) = nearest(other, ["flat", "ribbon", "cylinder"]) {
                message += &format!(" (did you mean \"{meant}\"?)");
            }
            reader.warn("type", message);
            CurveKind::Cylinder
        }
    }
}

/// The normals of a ribbon, or none for others; `None` where a ribbon has not as many as it needs.
fn read_normals(reader: &ParamReader, kind: CurveKind, segments: usize) -> Option<Vec<DVec3>> {
    let given = reader.normals("N");
    if kind != CurveKind::Ribbon {
        if given.is_some() {
            reader.warn("N", "normals turn curves of type \"ribbon\" only: not used");
        }
        return Some(Vec::new());
    }
    let message = "a ribbon needs \"normal N\" at the ends of its segments";
    let given = needed(reader, "N", given, message)?;
    let normals: Vec<DVec3> = triples(given).map(DVec3::normalize_or_zero).collect();
    if normals.len() != segments + 1 {
        let (given, taken) = (normals.len(), segments + 1);
        let why = format_args!(
            "{given} normals for a ribbon of {segments} segments, which takes {taken}"
        );
        return left_out(reader, "N", why);
    }
    if let Some(zero) = normals.iter().position(|n| *n == DVec3::ZERO) {
        let message = "a normal of no length turns nothing: the shape is left out";
        reader.error_item("N", 3 * zero, message);
        return None;
    }
    Some(normals)
}

/// One segment of a curve in place.
#[derive(Clone, Copy, Debug)]
pub struct PlacedSegment {
    /// Its control points.
    pub bezier: Bezier,
    /// Full widths at its ends.
    pub width: [f64; 2],
    /// Unit normals at its ends; they count for ribbons.
    pub normals: [DVec3; 2],
}

impl PlacedSegment {
    /// Into how many boxes it is cut, as a power of two.
    fn splits(&self, most: u32) -> u32 {
        let widest = self.width[0].max(self.width[1]);
        let pieces = self.bezier.hull_length() / (PIECE_WIDTHS * widest);
        (0..most)
            .find(|&depth| pieces <= f64::from(1u32 << depth))
            .unwrap_or(most)
    }
}

/// A curve in place, in double precision.
#[derive(Clone, Debug)]
pub struct Curves {
    /// How it is shaded.
    pub kind: CurveKind,
    /// Normals are turned.
    pub flip: bool,
    /// Of the space that widths are measured in; `None` where that is the space of the tree.
    pub placement: Option<Place>,
    /// The segments.
    pub segments: Vec<PlacedSegment>,
    split_depth: u32,
}

impl Curves {
    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Curves>() + size_of_val(&self.segments[..])
    }

    /// Corners of a box around the finite control points, in the space of the tree; `min > max`
    /// without any.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let points = self.segments.iter().flat_map(|s| s.bezier.0);
        let placed = points.map(|p| match &self.placement {
            Some(placement) => placement.outer_from_inner.transform_point3(p),
            None => p,
        });
        box_around(placed.filter(|p| p.is_finite()))
    }

    /// The same curve with coordinates that count from `anchor`.
    pub fn relative_to(mut self, anchor: DVec3) -> Curves {
        match &mut self.placement {
            None => {
                for segment in &mut self.segments {
                    segment.bezier = Bezier(segment.bezier.0.map(|p| p - anchor));
                }
            }
            Some(placement) => {
                let moved = Transform::from_matrix(DMat4::from(placement.outer_from_inner));
                let moved = (Transform::translate(-anchor) * moved).with_translations_matched();
                placement.outer_from_inner.translation -= anchor;
                placement.inner_from_outer.translation = moved.inverse.w_axis.truncate();
            }
        }
        self
    }

    /// The segments as a tree keeps them; `owner` is the number of this curve there, and
    /// normals are numbered from `first_normal`.
    pub fn stored(&self, owner: u32, first_normal: u32) -> impl Iterator<Item = Segment> {
        let ribbon = self.kind == CurveKind::Ribbon;
        let placed = self.placement.is_some();
        self.segments.iter().zip(first_normal..).map(move |(s, i)| {
            Segment::new(
                s.bezier.0.map(DVec3::as_vec3),
                s.width.map(|w| w as f32),
                ribbon.then_some(i),
                (owner, placed),
                s.splits(self.split_depth),
            )
        })
    }

    /// Normals at the ends of the segments, of ribbons.
    pub fn stored_normals(&self) -> impl Iterator<Item = [DVec3; 2]> {
        let ribbon = self.kind == CurveKind::Ribbon;
        let segments = self.segments.iter().filter(move |_| ribbon);
        segments.map(|s| s.normals.map(|n| n.as_vec3().as_dvec3()))
    }
}

#[cfg(test)]
mod tests;
