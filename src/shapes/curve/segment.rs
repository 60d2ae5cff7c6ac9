//! Where a ray meets a segment of a curve.
//!
//! The method is that of Nakamaru and Ohno ("RayTracing for Curves Primitive", WSCG 2002) as Pharr,
//! Jakob and Humphreys (2016, §3.7) have it: seen along the ray a curve is flat, so it is turned
//! until the ray is the z axis and halved until pieces are nearly straight; one that comes within
//! half its width of the origin is hit. Of several the nearest counts. (pbrt-v3 takes the last one.)

use super::{Bezier, CurveKind};
use crate::math::{DVec2, DVec3, Vec2, Vec3};
use crate::shapes::local::{LocalPoint, LocalSurface};
use glam::DMat3;

/// Halvings at most.
const DEEPEST: i32 = 10;

/// Pieces are straight to this part of the width.
const STRAIGHTNESS: f64 = 0.05;

/// A segment as a tree keeps it: one line of cache.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    points: [Vec3; 4],
    width: [f32; 2],
    normals: u32,
    /// Number of the curve; above it whether the curve has a placement, and in the two upper bits
    /// how often the segment is halved for its boxes.
    owner: u32,
}

/// The bit of [`Segment::owner`] above the number of the curve.
const PLACED: u32 = 1 << 29;

/// How far up the halvings stand.
const SPLITS_SHIFT: u32 = 30;

/// No normals.
const NONE: u32 = u32::MAX;

/// A meeting with a curve, in the space that its widths are measured in.
#[derive(Clone, Copy, Debug)]
pub struct CurveHit {
    /// Distance in units of the direction's length.
    pub t: f64,
    /// Along the segment.
    pub u: f64,
    /// Across it.
    pub v: f64,
    /// Width of the strip as seen there.
    width: f64,
    /// The normal that a ribbon has there.
    normal: Option<DVec3>,
}

/// Axes of a space in which the ray `d` is z and the curve's chord is along x.
fn ray_frame(d: DVec3, chord: DVec3) -> Option<DMat3> {
    let z = d.try_normalize()?;
    let y = z.cross(chord).try_normalize();
    let y = y.unwrap_or_else(|| z.any_orthonormal_vector());
    Some(DMat3::from_cols(y.cross(z), y, z))
}

/// What all pieces of a segment share, and the nearest meeting so far.
struct Search<'a> {
    width: [f64; 2],
    normals: Option<&'a [DVec3; 2]>,
    /// Unit direction of the ray.
    d: DVec3,
    z_max: f64,
    /// With `t` as a length.
    found: Option<CurveHit>,
}

impl Segment {
    /// `normals` numbers those of a ribbon, `owner` (below 2²⁹) the curve; the segment is halved
    /// `splits` (at most 3) times for its boxes.
    pub fn new(
        points: [Vec3; 4],
        width: [f32; 2],
        normals: Option<u32>,
        (owner, placed): (u32, bool),
        splits: u32,
    ) -> Segment {
        Segment {
            points,
            width,
            normals: normals.unwrap_or(NONE),
            owner: owner | if placed { PLACED } else { 0 } | splits << SPLITS_SHIFT,
        }
    }

    /// Where its normals are, if it is a ribbon.
    pub fn normals(&self) -> Option<usize> {
        (self.normals != NONE).then_some(self.normals as usize)
    }

    /// The curve it belongs to.
    pub fn owner(&self) -> usize {
        (self.owner & (PLACED - 1)) as usize
    }

    /// Its widths are measured in another space than the tree's.
    pub fn is_placed(&self) -> bool {
        self.owner & PLACED != 0
    }

    /// How many boxes it has.
    pub fn pieces(&self) -> usize {
        1 << (self.owner >> SPLITS_SHIFT)
    }

    /// Parameters of the ends of a piece.
    fn range(&self, piece: usize) -> [f64; 2] {
        let n = self.pieces() as f64;
        [piece as f64 / n, (piece + 1) as f64 / n]
    }

    fn widest(&self, [u0, u1]: [f64; 2]) -> f64 {
        let at = |u| between(self.width.map(f64::from), u);
        at(u0).max(at(u1))
    }

    /// Corners of a box around a piece.
    pub fn bounds(&self, piece: usize) -> (DVec3, DVec3) {
        let range = self.range(piece);
        let (min, max) = Bezier::widened(&self.points)
            .part(range[0], range[1])
            .bounds();
        let margin = DVec3::splat(0.5 * self.widest(range));
        (min - margin, max + margin)
    }

    /// The nearest meeting of the ray `o + t d` with a piece at 0 < t < `t_max`.
    pub fn intersect(
        &self,
        piece: usize,
        normals: Option<&[DVec3; 2]>,
        o: DVec3,
        d: DVec3,
        t_max: f64,
    ) -> Option<CurveHit> {
        let range = self.range(piece);
        let curve = Bezier::widened(&self.points).part(range[0], range[1]);
        let frame = ray_frame(d, curve.0[3] - curve.0[0])?;
        let curve = Bezier(curve.0.map(|p| frame.transpose_mul_vec3(p - o)));
        let length = d.length();
        let mut search = Search {
            width: self.width.map(f64::from),
            normals,
            d: frame.z_axis,
            z_max: t_max * length,
            found: None,
        };
        if !search.may_meet(&curve, range) {
            return None;
        }
        // Wang's bound on the halvings that make a cubic straight to a tolerance (Pharr, Jakob and
        // Humphreys 2016, §3.7).
        let tolerance = STRAIGHTNESS * search.width[0].max(search.width[1]);
        let off = std::f64::consts::SQRT_2 * 6.0 * curve.bend() / (8.0 * tolerance);
        // Every halving makes a quarter of it; rounded about as pbrt-v3 does.
        let halvings = off.log2() / 2.0 + 0.25;
        search.descend(&curve, range, (halvings as i32).clamp(0, DEEPEST));
        let mut hit = search.found?;
        hit.t /= length;
        Some(hit)
    }

    /// The surface at a meeting with the ray `o + t d`.
    pub fn surface(
        &self,
        hit: &CurveHit,
        kind: CurveKind,
        flip: bool,
        o: DVec3,
        d: DVec3,
    ) -> Option<LocalSurface> {
        let (_, dpdu) = Bezier::widened(&self.points).at(hit.u);
        let dpdv = match hit.normal {
            Some(normal) => normal.cross(dpdu).try_normalize()? * hit.width,
            None => {
                // Across the strip in the plane that faces the ray, on the side where v grows. A
                // curve seen end on has any.
                let across = ray_frame(d, dpdu)?.y_axis * hit.width;
                match kind {
                    CurveKind::Cylinder => {
                        let angle = (hit.v - 0.5) * std::f64::consts::PI;
                        let axis = dpdu.try_normalize()?;
                        glam::DQuat::from_axis_angle(axis, -angle) * across
                    }
                    _ => across,
                }
            }
        };
        let side = if flip { -1.0 } else { 1.0 };
        let n = dpdu.cross(dpdv).try_normalize()? * side;
        Some(LocalSurface {
            point: LocalPoint {
                p: o + d * hit.t,
                // pbrt-v3's choice: new rays start two widths away, beyond the body that the strip
                // represents.
                p_error: DVec3::splat(2.0 * hit.width),
                n,
                shading_n: n,
            },
            uv: Vec2::new(hit.u as f32, hit.v as f32),
            dpdu,
            dpdv,
            shading_dpdu: dpdu,
            shading_dpdv: dpdv,
            dndu: DVec3::ZERO,
            dndv: DVec3::ZERO,
            face: 0,
        })
    }
}

fn between([a, b]: [f64; 2], t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

impl Search<'_> {
    /// Returns `true` if the box around a piece in the ray's frame holds a point of the ray.
    fn may_meet(&self, curve: &Bezier, [u0, u1]: [f64; 2]) -> bool {
        let reach = 0.5 * between(self.width, u0).max(between(self.width, u1));
        let (min, max) = curve.bounds();
        max.y >= -reach
            && min.y <= reach
            && max.x >= -reach
            && min.x <= reach
            && max.z >= -reach
            && min.z <= self.z_max + reach
    }

    fn descend(&mut self, curve: &Bezier, [u0, u1]: [f64; 2], depth: i32) {
        if depth == 0 {
            return self.meet(curve, [u0, u1]);
        }
        let middle = 0.5 * (u0 + u1);
        for (half, range) in curve.halves().iter().zip([[u0, middle], [middle, u1]]) {
            if self.may_meet(half, range) {
                self.descend(half, range, depth - 1);
            }
        }
    }

    /// A piece that is nearly straight.
    fn meet(&mut self, curve: &Bezier, [u0, u1]: [f64; 2]) {
        let flat = |i: usize| curve.0[i].truncate();
        // Beyond the lines across the ends it is the neighbors' turn.
        let before = |end: DVec2, inner: DVec2| (inner - end).dot(-end) < 0.0;
        if before(flat(0), flat(1)) || before(flat(3), flat(2)) {
            return;
        }
        let chord = flat(3) - flat(0);
        let w = (-flat(0)).dot(chord) / chord.length_squared();
        if !w.is_finite() {
            return;
        }
        let u = between([u0, u1], w).clamp(u0, u1);
        let mut width = between(self.width, u);
        let normal = self.normals.map(|ends| ribbon_normal(ends, u));
        if let Some(n) = normal {
            width *= n.dot(self.d).abs();
        }
        let (p, derivative) = curve.at(w.clamp(0.0, 1.0));
        let distance = p.truncate().length();
        if distance > 0.5 * width || p.z <= 0.0 || p.z >= self.z_max || width == 0.0 {
            return;
        }
        let side = derivative.truncate().perp_dot(-p.truncate());
        let off = distance / width;
        self.z_max = p.z;
        self.found = Some(CurveHit {
            t: p.z,
            u,
            v: if side > 0.0 { 0.5 + off } else { 0.5 - off },
            width,
            normal,
        });
    }
}

/// The normal turned evenly from one end to the other. As in pbrt-v3 ends more than a right angle
/// apart count as a right angle apart.
fn ribbon_normal([a, b]: &[DVec3; 2], u: f64) -> DVec3 {
    let angle = a.dot(*b).clamp(0.0, 1.0).acos();
    // Below this the sines are their angles.
    if angle < 1e-4 {
        return *a * (1.0 - u) + *b * u;
    }
    (*a * ((1.0 - u) * angle).sin() + *b * (u * angle).sin()) / angle.sin()
}
