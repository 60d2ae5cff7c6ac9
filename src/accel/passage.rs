//! What a ray passes that only what has a material blocks: surfaces without material, where media may change.

use super::level::Level;
use super::primitive::PrimitiveId;
use crate::handles::InterfaceId;
use crate::math::DVec3;
use arrayvec::ArrayVec;

/// More crossings than this are found one after the other instead.
const MAX_CROSSINGS: usize = 8;

/// Where a ray passes from one medium to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Distance along the ray.
    pub(crate) t: f32,
    /// The interface between the media.
    pub(crate) interface: InterfaceId,
    /// The ray leaves on the side that the normal points to.
    pub(crate) is_outward: bool,
}

/// What an unblocked ray passes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passage {
    crossings: ArrayVec<Crossing, MAX_CROSSINGS>,
    /// There are more than are kept here.
    is_incomplete: bool,
}

/// Crossings coincide if their distances differ by no more than this part of them, which may be rounding.
const COINCIDENT: f32 = 4.0 * f32::EPSILON;

impl Passage {
    /// The crossings of a ray that begins in `medium`, in order; `None` if the search has not kept all: there are more than a few, or some of a curve
    /// or of a quadric that is not a whole sphere. `sides` tells the medium before a crossing, and that behind it.
    pub(crate) fn crossings<M: PartialEq>(
        &mut self,
        mut medium: M,
        sides: impl Fn(&Crossing) -> (M, M),
    ) -> Option<&[Crossing]> {
        if self.is_incomplete {
            return None;
        }
        let order = |a: &Crossing, b: &Crossing| {
            let otherwise = (a.interface, a.is_outward).cmp(&(b.interface, b.is_outward));
            a.t.total_cmp(&b.t).then(otherwise)
        };
        self.crossings.sort_unstable_by(order);
        for i in 0..self.crossings.len() {
            // Of those that coincide the first has before it the medium that the ray is in.
            let end = self.crossings[i].t * (1.0 + COINCIDENT);
            let mut here = self.crossings[i..].iter().take_while(|next| next.t <= end);
            let next = here.position(|next| sides(next).0 == medium).unwrap_or(0);
            self.crossings[i..=i + next].rotate_right(1);
            medium = sides(&self.crossings[i]).1;
        }
        Some(&self.crossings)
    }

    /// Adds the crossings `inside` an instance that are before `t_max`; `outer` tells distances along the ray from those there. Normals and directions
    /// have the same sign of their product in either space.
    pub(super) fn append(&mut self, inside: &Passage, outer: impl Fn(f32) -> f32, t_max: f32) {
        self.is_incomplete |= inside.is_incomplete;
        for crossing in &inside.crossings {
            let t = outer(crossing.t);
            if t < t_max {
                self.push(Crossing { t, ..*crossing });
            }
        }
    }

    /// Adds where the ray `o + t d` crosses a primitive of `level` before `t_max`; it meets it first at `t`.
    pub(super) fn add(
        &mut self,
        (level, id, interface): (&Level, PrimitiveId, InterfaceId),
        (o, d): (DVec3, DVec3),
        (t, t_max): (f32, f32),
    ) {
        let crossing = |t, is_outward| Crossing {
            t,
            interface,
            is_outward,
        };
        if id.is_triangle() {
            let (mesh, i) = level.locate(id.index());
            let n = mesh.bare_triangle(i).crossed(o, d).n;
            self.push(crossing(t, d.dot(n) > 0.0));
        } else if let Some(ball) = level.ball(id) {
            for (t, is_outward) in ball.crossings(o, d) {
                if t > 0.0 && (t as f32) < t_max {
                    self.push(crossing(t as f32, is_outward));
                }
            }
        } else {
            self.is_incomplete = true;
        }
    }

    fn push(&mut self, crossing: Crossing) {
        self.is_incomplete |= self.crossings.try_push(crossing).is_err();
    }
}
