//! A segment of a curve that light is sampled from.
//!
//! A strip that turns to whoever looks has no area to choose points on. Directions are chosen
//! instead, from boxes of directions that hold all of the segment as the receiving point sees it, and
//! the segment is then asked what the ray meets. So the density is that of the direction, whatever
//! shape the strip has, and what does not meet it is a sample that brings nothing.
//!
//! The segment is cut into pieces that are nearly straight. All that a ray may meet of one is within
//! half a width of the spline, so inside a capsule: the points within a radius r of the piece's chord.
//! Take the line through the receiving point o that is parallel to the chord as the pole of spherical
//! coordinates. From a distance h > r a capsule of any length is within the azimuths ±asin(r/h); the
//! cosines of the polar angle are within those of the corners of the rectangle that the capsule sweeps
//! around that line. Solid angle is azimuth times cosine, so that a uniform choice in that box is
//! one in solid angle, and nearly all of it for long strips, near and far, along and across.

use super::{Bezier, CurveKind, Curves, PlacedSegment, Placement, Segment};
use crate::math::float::{UNIT_ROUNDOFF, offset_ray_origin};
use crate::math::{DVec3, Vec2, Vec3};
use crate::shapes::emitter::EmitterSample;
use crate::shapes::local::LocalSurface;
use crate::surface::ReferencePoint;
use std::f64::consts::PI;

/// The spline is off its pieces' chords by at most this part of the width, unless it takes too many.
const BEND: f64 = 0.25;

/// The segment is halved at most so often.
const MOST_HALVINGS: u32 = 5;

/// Directions are rounded to single precision: relative to the distance, what that moves a ray by.
const DIRECTION_ERROR: f64 = 1e-7;

/// See the module.
#[derive(Clone, Debug)]
pub struct CurveEmitter {
    segment: Segment,
    normals: [DVec3; 2],
    kind: CurveKind,
    flip: bool,
    placement: Option<Placement>,
    /// The segment and its placement count from here, render space.
    anchor: DVec3,
    /// All of the segment, from `anchor`.
    pieces: Vec<Capsule>,
    /// Of a ribbon its area; else that of a tube as thick as the strip is wide, which has the same
    /// flux: π times as much.
    area: f64,
}

/// All points within `radius` of the line from `start` to `start + length · axis`.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    start: DVec3,
    axis: DVec3,
    length: f64,
    radius: f64,
}

/// Directions around a pole.
#[derive(Clone, Copy, Debug)]
struct DirectionBox {
    /// The pole, and where azimuths count from: unit vectors.
    pole: DVec3,
    zero: DVec3,
    /// Cosines of the polar angle.
    low: f64,
    high: f64,
    /// Azimuths are within ± this.
    azimuth: f64,
}

impl DirectionBox {
    fn solid_angle(&self) -> f64 {
        2.0 * self.azimuth * (self.high - self.low)
    }

    fn at(&self, u: f64, v: f64) -> DVec3 {
        let cos = self.low + (self.high - self.low) * u;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (sin_azimuth, cos_azimuth) = (self.azimuth * (2.0 * v - 1.0)).sin_cos();
        let across = self.zero * cos_azimuth + self.pole.cross(self.zero) * sin_azimuth;
        self.pole * cos + across * sin
    }

    fn holds(&self, direction: DVec3) -> bool {
        let cos = direction.dot(self.pole);
        let x = direction.dot(self.zero);
        let y = direction.dot(self.pole.cross(self.zero));
        cos >= self.low && cos <= self.high && y.atan2(x).abs() <= self.azimuth
    }
}

impl Capsule {
    fn new(start: DVec3, end: DVec3, radius: f64) -> Capsule {
        let chord = end - start;
        Capsule {
            start,
            axis: chord.try_normalize().unwrap_or(DVec3::Z),
            length: chord.length(),
            radius,
        }
    }

    /// The directions of all points within `margin` of it, as seen from `o`.
    fn seen_from(&self, o: DVec3, margin: f64) -> DirectionBox {
        let away = self.start - o;
        let first = away.dot(self.axis);
        let across = away - self.axis * first;
        let distance = across.length();
        let radius = self.radius + margin + DIRECTION_ERROR * (away.length() + self.length);
        let (low, high) = (first - radius, first + self.length + radius);
        let farthest = distance + radius;
        let (zero, nearest, azimuth) = if distance > radius {
            let azimuth = (radius / distance).asin();
            (across / distance, distance - radius, azimuth)
        } else {
            (self.axis.any_orthonormal_vector(), 0.0, PI)
        };
        let cosine = |along: f64, off: f64| (along / along.hypot(off)).clamp(-1.0, 1.0);
        DirectionBox {
            pole: self.axis,
            zero,
            low: cosine(low, if low > 0.0 { farthest } else { nearest }),
            high: cosine(high, if high > 0.0 { nearest } else { farthest }),
            azimuth,
        }
    }
}

impl CurveEmitter {
    /// The segments of a curve in render space, in order.
    pub fn of_curves(curves: &Curves) -> impl Iterator<Item = CurveEmitter> {
        curves
            .segments
            .iter()
            .map(|segment| CurveEmitter::new(curves, segment))
    }

    fn new(curves: &Curves, segment: &PlacedSegment) -> CurveEmitter {
        let alone = Curves {
            kind: curves.kind,
            flip: curves.flip,
            placement: curves.placement,
            segments: vec![*segment],
            split_depth: curves.split_depth,
        };
        let first = segment.bezier.0[0];
        let anchor = match &curves.placement {
            Some(placement) => placement.level_from_local.transform_point3(first),
            None => first,
        };
        let alone = alone.relative_to(anchor);
        let bezier = alone.segments.first().map_or(segment.bezier, |s| s.bezier);
        let pieces = pieces(&bezier, segment.width, alone.placement.as_ref());
        let [w0, w1] = segment.width;
        let length: f64 = pieces.iter().map(|piece| piece.length).sum();
        let around = match curves.kind {
            CurveKind::Ribbon => 1.0,
            CurveKind::Flat | CurveKind::Cylinder => PI,
        };
        let ribbon = curves.kind == CurveKind::Ribbon;
        CurveEmitter {
            segment: Segment::new(
                bezier.0.map(DVec3::as_vec3),
                segment.width.map(|w| w as f32),
                ribbon.then_some(0),
                (0, alone.placement.is_some()),
                segment.splits(curves.split_depth),
            ),
            normals: segment.normals.map(|n| n.as_vec3().as_dvec3()),
            kind: curves.kind,
            flip: curves.flip,
            area: around * length * 0.5 * (w0 + w1) * mean_scale(alone.placement.as_ref()),
            placement: alone.placement,
            anchor,
            pieces,
        }
    }

    /// Does it shine at whoever looks, whichever way its normals point? Strips that turn to whoever
    /// looks have no back.
    pub fn faces_everyone(&self) -> bool {
        self.kind != CurveKind::Ribbon
    }

    /// Area that has its flux if it shines on one side; of ribbons, the area.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Corners of a box around it, render space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.pieces.iter().fold(none, |(low, high), piece| {
            let (a, b) = (piece.start, piece.start + piece.axis * piece.length);
            let (a, b) = (a + self.anchor, b + self.anchor);
            let radius = DVec3::splat(piece.radius);
            (low.min(a.min(b) - radius), high.max(a.max(b) + radius))
        })
    }

    /// The boxes of directions that hold the segment as seen from `from`.
    fn boxes(&self, from: &ReferencePoint) -> impl Iterator<Item = DirectionBox> {
        let o = from.p.as_dvec3() - self.anchor;
        // Rays start beside the point, on either side.
        let moved = |side: Vec3| {
            let moved = offset_ray_origin(from.p, from.p_error, from.n, side);
            f64::from((moved - from.p).length())
        };
        let margin = moved(from.n).max(moved(-from.n));
        self.pieces
            .iter()
            .map(move |piece| piece.seen_from(o, margin))
    }

    /// Chooses a direction and finds where it meets the segment. `None` where it does not.
    pub fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<EmitterSample> {
        let total: f64 = self.boxes(from).map(|b| b.solid_angle()).sum();
        let mut chosen = f64::from(u.x) * total;
        let mut kept = None;
        for candidate in self.boxes(from) {
            let share = candidate.solid_angle();
            kept = Some((candidate, (chosen / share).clamp(0.0, 1.0)));
            if chosen < share {
                break;
            }
            chosen -= share;
        }
        let (kept, u_within) = kept?;
        let direction = kept.at(u_within, f64::from(u.y));
        let wi = direction.as_vec3().try_normalize()?;
        let pdf = self.density(from, wi);
        let o = offset_ray_origin(from.p, from.p_error, from.n, wi);
        let surface = self.meet(o.as_dvec3() - self.anchor, wi.as_dvec3())?;
        let p = (surface.p + self.anchor).as_vec3();
        Some(EmitterSample {
            p,
            // The ray that found it is the one that must be free, and ends just before the strip:
            // the two widths that new rays keep from it are no part of this.
            p_error: p.abs() * (2.0 * UNIT_ROUNDOFF),
            n: surface.n.as_vec3(),
            wi,
            pdf,
        })
    }

    /// Density per solid angle with which [`CurveEmitter::sample`] chooses the direction `wi`: boxes
    /// are chosen by their solid angle, so it is the number of those that hold `wi` over the
    /// solid angle of all.
    pub fn density(&self, from: &ReferencePoint, wi: Vec3) -> f32 {
        let Some(direction) = wi.as_dvec3().try_normalize() else {
            return 0.0;
        };
        let (holding, total) = self.boxes(from).fold((0.0, 0.0), |(n, sum), b| {
            let held = if b.holds(direction) { 1.0 } else { 0.0 };
            (n + held, sum + b.solid_angle())
        });
        (holding / total) as f32
    }

    /// The surface that the ray `o + t d` meets first, both counted from `anchor`.
    fn meet(&self, o: DVec3, d: DVec3) -> Option<LocalSurface> {
        let (o, d) = match &self.placement {
            None => (o, d),
            Some(placement) => (
                placement.local_from_level.transform_point3(o),
                placement.local_from_level.transform_vector3(d),
            ),
        };
        let normals = self.segment.normals().map(|_| &self.normals);
        let mut nearest = None;
        let mut t_max = f64::INFINITY;
        for piece in 0..self.segment.pieces() {
            if let Some(hit) = self.segment.intersect(piece, normals, o, d, t_max) {
                t_max = hit.t;
                nearest = Some(hit);
            }
        }
        let local = self
            .segment
            .surface(&nearest?, self.kind, self.flip, o, d)?;
        Some(match &self.placement {
            None => local,
            Some(p) => local.transformed(&p.level_from_local, &p.local_from_level),
        })
    }
}

/// Capsules around all of a segment with the widths at its ends.
fn pieces(bezier: &Bezier, width: [f64; 2], placement: Option<&Placement>) -> Vec<Capsule> {
    let halvings = (0..MOST_HALVINGS)
        .find(|&n| {
            let worst = parts(n).map(|[t0, t1]| off_chord(&bezier.part(t0, t1)));
            worst.fold(0.0, f64::max) <= BEND * width[0].max(width[1])
        })
        .unwrap_or(MOST_HALVINGS);
    let at = |t: f64| width[0] * (1.0 - t) + width[1] * t;
    parts(halvings)
        .filter(|[t0, t1]| at(*t0).max(at(*t1)) > 0.0)
        .map(|[t0, t1]| {
            let part = bezier.part(t0, t1);
            let radius = 0.5 * at(t0).max(at(t1)) + off_chord(&part);
            match placement {
                None => Capsule::new(part.0[0], part.0[3], radius),
                Some(placement) => {
                    let place = |p| placement.level_from_local.transform_point3(p);
                    let radius = radius * longest(placement);
                    Capsule::new(place(part.0[0]), place(part.0[3]), radius)
                }
            }
        })
        .filter(|capsule| capsule.start.is_finite() && capsule.radius.is_finite())
        .collect()
}

/// The ends of the pieces after `halvings` halvings.
fn parts(halvings: u32) -> impl Iterator<Item = [f64; 2]> {
    let n = 1u32 << halvings;
    (0..n).map(move |i| [i, i + 1].map(|i| f64::from(i) / f64::from(n)))
}

/// How far a spline is off its chord at most: not farther than its control points.
fn off_chord(part: &Bezier) -> f64 {
    let [a, b, c, d] = part.0;
    let off = |p: DVec3| {
        let t = (p - a).dot(d - a) / (d - a).length_squared();
        let t = if t.is_finite() {
            t.clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance(a.lerp(d, t))
    };
    off(b).max(off(c))
}

/// A bound on the factor by which lengths grow: the root of the product of the largest sums of
/// columns and of rows (Golub and Van Loan, "Matrix Computations", 2013, §2.3.3).
fn longest(placement: &Placement) -> f64 {
    let m = placement.spread();
    let columns = m.transpose() * DVec3::ONE;
    let rows = m * DVec3::ONE;
    (columns.max_element() * rows.max_element()).sqrt()
}

/// The factor by which lengths grow, on average over the axes.
fn mean_scale(placement: Option<&Placement>) -> f64 {
    placement.map_or(1.0, |p| {
        p.level_from_local.matrix3.determinant().abs().cbrt()
    })
}

#[cfg(test)]
mod tests;
