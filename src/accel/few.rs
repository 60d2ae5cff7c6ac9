//! Few triangles and quadrics and nothing else, as a whole scene: rays are tested against all of them, which takes less time than to walk a tree.
//!
//! Of many rays sixteen are tested side by side, corners being shared by triangles; of one or some, each against eight triangles side by side. The
//! test of triangles is the [watertight](super::watertight) one of the tree's packets, in loops that are compiled to vector instructions
//! ([`crate::math::instruction_set`]). Both ways give the same bits: a hit is the nearest, and of equally near ones the first. (Next to a corner the
//! tree may find another triangle: the test's rounding lets rays in that pass the box.)

mod many_rays;
mod one_ray;

use super::primitive::{Item, OtherKind, PrimitiveId};
use super::tree::{Visitor, Visitors};
use super::watertight::{Plane, is_inside_exactly};
use crate::math::Vec3;
use crate::math::instruction_set::InstructionSet;
use crate::shapes::ball::Ball;
use crate::shapes::quadric::Quadric;
use arrayvec::ArrayVec;
use many_rays::{Meetings, RAYS, Rays};
use one_ray::Lots;
use std::ops::RangeInclusive;

/// So many triangles: with fewer, or more, a tree is faster for one ray ([measured](Few)).
const COUNTS: RangeInclusive<usize> = 16..=48;

/// At most so many full spheres, and other quadrics.
const BALLS: usize = 8;
const OTHERS: usize = 2;

/// At most so many corners: in the sheared spaces of sixteen rays they fill half of a first-level cache.
const CORNERS: usize = 64;

/// Fewer rays than these go one by one.
const SOME: usize = 7;

/// The triangles that a ray meets, a bit for each, and those of which one edge function is 0: then what exact signs say counts.
#[derive(Default)]
struct Meeting {
    met: u64,
    on_edge: u64,
}

/// Triangles without a tree.
///
/// Nanoseconds a ray in rooms with boxes (AMD EPYC with AVX2, least of 25), closest hit and any hit of a shadow ray:
///
/// | triangles | tree | one ray | sixteen |
/// |--:|--:|--:|--:|
/// | 8 | 43, 23 | 58, 50 | 28, 25 |
/// | 16 | 65, 54 | 65, 70 | 37, 37 |
/// | 34 | 95, 74 | 88, 84 | 55, 51 |
/// | 46 | 97, 72 | 117, 112 | 64, 59 |
/// | 60 | 99, 77 | 113, 105 | 73, 70 |
pub(super) struct Few {
    ids: Box<[PrimitiveId]>,
    /// Corners of the triangles, by index.
    corners: Box<[[u8; 3]]>,
    places: ArrayVec<Vec3, CORNERS>,
    planes: Box<[Plane]>,
    balls: ArrayVec<(PrimitiveId, Ball), BALLS>,
    /// Other quadrics, which are tested one ray at a time, and balls around them.
    others: ArrayVec<(PrimitiveId, Around), OTHERS>,
    lots: Lots,
}

/// A ball that something is in.
#[derive(Clone, Copy)]
struct Around {
    center: Vec3,
    radius: f32,
}

impl Few {
    /// No more triangles than these.
    pub(super) const MOST: usize = *COUNTS.end();

    /// These, if they are as few, and no others.
    pub(super) fn of<'a>(
        items: &[Item],
        corners: impl Fn(PrimitiveId) -> [Vec3; 3],
        quadric: impl Fn(PrimitiveId) -> &'a Quadric,
    ) -> Option<Few> {
        let count = items.iter().filter(|item| item.id.is_triangle()).count();
        let (flat, round) = items.split_at_checked(count)?;
        let counts = match round {
            [] => COUNTS,
            _ => 0..=Few::MOST,
        };
        if !counts.contains(&count) || round.iter().any(|item| item.id.is_triangle()) {
            return None;
        }
        let (mut balls, mut others) = (ArrayVec::new(), ArrayVec::new());
        for item in round {
            if item.id.kind() != OtherKind::Quadric {
                return None;
            }
            match quadric(item.id).ball() {
                Some(ball) => balls.try_push((item.id, *ball)).ok()?,
                None => others.try_push((item.id, Around::of(item))).ok()?,
            }
        }
        let triangles: Vec<[Vec3; 3]> = flat.iter().map(|item| corners(item.id)).collect();
        let mut places = ArrayVec::new();
        let mut index = |p| index_of(&mut places, p);
        let indices = triangles
            .iter()
            .map(|&[a, b, c]| Some([index(a)?, index(b)?, index(c)?]));
        Some(Few {
            ids: flat.iter().map(|item| item.id).collect(),
            corners: indices.collect::<Option<_>>()?,
            places,
            planes: triangles.iter().copied().map(Plane::of).collect(),
            balls,
            others,
            lots: Lots::of(&triangles),
        })
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.ids[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.planes[..])
            + self.lots.bytes()
    }

    /// Calls a visitor for everything that each of `count` rays hits.
    #[inline(always)]
    pub(super) fn visit<V: Visitors>(
        &self,
        instructions: InstructionSet,
        count: usize,
        mut from: V,
    ) {
        for _ in 0..count / RAYS {
            self.visit_side_by_side(instructions, RAYS, &mut from);
        }
        match count % RAYS {
            left if left < SOME => self.visit_one_by_one(instructions, from),
            left => self.visit_side_by_side(instructions, left, &mut from),
        }
    }

    #[inline(always)]
    fn visit_one_by_one<V: Visitors>(&self, instructions: InstructionSet, mut from: V) {
        while let Some((o, d, mut visitor)) = from.next() {
            if (o + d).is_finite() {
                let meeting = self.lots.test(instructions, (o, d), visitor.t_max());
                let triangle = |bit| self.lots.triangle(bit);
                let round = { self.balls.iter().map(|(id, _)| id) }
                    .chain(self.others.iter().map(|(id, _)| id));
                let _ = self.visit_met((meeting, triangle), (o, d), &mut visitor) || { round }
                    .any(|&id| visitor.other(id));
            }
            from.finish(visitor);
        }
    }

    #[inline(always)]
    fn visit_side_by_side<V: Visitors>(
        &self,
        instructions: InstructionSet,
        count: usize,
        from: &mut V,
    ) {
        let mut visitors = ArrayVec::<V::Visitor, RAYS>::new();
        let mut rays = Rays::new();
        for i in 0..count.min(RAYS) {
            if let Some((o, d, visitor)) = from.next() {
                rays.set(i, (o, d), visitor.t_max());
                visitors.push(visitor);
            }
        }
        let mut meetings = Meetings::new();
        rays.test(instructions, self, &mut meetings);
        for (i, visitor) in visitors.iter_mut().enumerate() {
            let met = (meetings.of(i), |bit| bit as usize);
            let _ = self.visit_met(met, rays.ray(i), visitor)
                || self.visit_round(&meetings, i, visitor);
        }
        visitors.drain(..).for_each(|visitor| from.finish(visitor));
    }

    /// Calls the visitor of ray `i` for what it meets besides triangles. Returns `true` if nothing more is wanted.
    #[inline(always)]
    fn visit_round(&self, meetings: &Meetings, i: usize, visitor: &mut impl Visitor) -> bool {
        let mut left = meetings.round(i);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let ends = match self.balls.get(bit) {
                Some(&(id, _)) => visitor.ball(id, meetings.distance(bit, i)),
                None => { self.others.get(bit - self.balls.len()) }
                    .is_some_and(|&(id, _)| visitor.other(id)),
            };
            if ends {
                return true;
            }
        }
        false
    }

    /// Calls the visitor of a ray for triangles that it meets. Returns `true` if nothing more is wanted.
    #[inline(always)]
    fn visit_met(
        &self,
        (meeting, triangle): (Meeting, impl Fn(u32) -> usize),
        ray: (Vec3, Vec3),
        visitor: &mut impl Visitor,
    ) -> bool {
        let mut left = meeting.met;
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let met = (triangle(bit), meeting.on_edge >> bit & 1 != 0);
            if self.visit_one(met, ray, visitor) {
                return true;
            }
        }
        false
    }

    /// Visits triangle `i`, which the ray has met, perhaps on an edge. Returns `true` if nothing more is wanted.
    #[inline(always)]
    fn visit_one(
        &self,
        (i, on_edge): (usize, bool),
        ray: (Vec3, Vec3),
        visitor: &mut impl Visitor,
    ) -> bool {
        let (Some(&id), Some(plane)) = (self.ids.get(i), self.planes.get(i)) else {
            return false;
        };
        if on_edge && !is_inside_exactly(ray.0, ray.1, plane.corners()) {
            return false;
        }
        let t = plane.distance(ray.0, ray.1);
        t > 0.0 && visitor.triangle(id, t)
    }
}

impl Around {
    fn of(item: &Item) -> Around {
        let (min, max) = (item.bounds.min, item.bounds.max);
        Around {
            center: 0.5 * (min + max),
            radius: 0.5 * (max - min).length(),
        }
    }
}

/// All bits, if it is so.
#[inline(always)]
fn mask(is_so: bool) -> u32 {
    if is_so { !0 } else { 0 }
}

/// Returns `true` if a ray that ends at `end` meets the triangle that has these corners in its sheared space; and `true` if also one
/// edge function is 0.
#[inline(always)]
fn verdict(a: (f32, f32, f32), b: (f32, f32, f32), c: (f32, f32, f32), end: f32) -> (bool, bool) {
    let [e0, e1, e2] = [
        b.0 * c.1 - b.1 * c.0,
        c.0 * a.1 - c.1 * a.0,
        a.0 * b.1 - a.1 * b.0,
    ];
    let (least, most) = (min(min(e0, e1), e2), max(max(e0, e1), e2));
    // The third coordinates are the distances of the corners, and the intersection is between them.
    let near = (min(min(a.2, b.2), c.2) <= end) & (max(max(a.2, b.2), c.2) >= 0.0);
    let met = near & ((least >= 0.0) | (most <= 0.0));
    let on_edge = met & !((least > 0.0) | (most < 0.0));
    (met, on_edge)
}

/// Without a case for NaN, as the instructions have it.
#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The index of a place among these, to which it is added if it is not there; `None` if there is no room.
fn index_of(places: &mut ArrayVec<Vec3, CORNERS>, p: Vec3) -> Option<u8> {
    let bits = |p: Vec3| p.to_array().map(f32::to_bits);
    let known = places.iter().position(|&q| bits(q) == bits(p));
    let index = known.unwrap_or(places.len());
    if known.is_none() {
        places.try_push(p).ok()?;
    }
    u8::try_from(index).ok()
}
