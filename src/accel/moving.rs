//! Motion: objects and shapes whose placement depends on the time of the ray.
//!
//! A scene without motion has none of these, and its rays never get here.

use super::aabb::Aabb;
use super::instance::Place;
use super::level::Level;
use crate::handles::ObjectId;
use crate::math::DVec3;
use crate::math::motion::Motion;

/// What moves.
pub(super) enum Inner {
    /// A shape, with a tree of its own.
    Shape(Box<Level>),
    /// A named object.
    Object(ObjectId),
}

/// A moving shape or object in the space of a tree.
pub(super) struct Moving {
    pub inner: Inner,
    /// From the inner level's coordinates, relative to the origin and not to its anchor, to those of the tree.
    motion: Motion,
    /// The inner level's anchor.
    anchor: DVec3,
}

impl Moving {
    /// A moving `inner`, a level with the given anchor; `motion` maps the space its shapes were compiled in to that of
    /// the outer tree.
    pub(super) fn new(inner: Inner, anchor: DVec3, motion: Motion) -> Moving {
        Moving {
            inner,
            motion,
            anchor,
        }
    }

    /// Its placement at `time`.
    pub(super) fn place(&self, time: f32) -> Place {
        let mut outer_from_inner = self.motion.at(f64::from(time));
        outer_from_inner.translation = outer_from_inner.transform_point3(self.anchor);
        Place {
            outer_from_inner,
            inner_from_outer: outer_from_inner.inverse(),
        }
    }

    /// Bounding box in the outer space over all times, from that of the inner level ([`Level::padded_bounds`]).
    pub(super) fn bounds(&self, inner: Option<(DVec3, DVec3)>) -> Aabb {
        let Some((low, high)) = inner else {
            return Aabb::EMPTY;
        };
        let (min, max) = self.motion.bounds(low + self.anchor, high + self.anchor);
        Aabb::around(min, max)
    }
}
