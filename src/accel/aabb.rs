//! Axis-aligned boxes.

use crate::math::{DVec3, Vec3};

/// An axis-aligned box; empty where `min > max` in some axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Aabb {
    /// The empty box: the neutral element of [`Aabb::union`].
    pub const EMPTY: Aabb = Aabb {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest single-precision box that contains `min` to `max`.
    pub fn around(min: DVec3, max: DVec3) -> Aabb {
        let down = |v: f64| {
            let r = v as f32;
            if f64::from(r) > v { r.next_down() } else { r }
        };
        let up = |v: f64| {
            let r = v as f32;
            if f64::from(r) < v { r.next_up() } else { r }
        };
        Aabb {
            min: Vec3::new(down(min.x), down(min.y), down(min.z)),
            max: Vec3::new(up(max.x), up(max.y), up(max.z)),
        }
    }

    /// This box extended to contain the point `p`.
    pub fn with_point(self, p: Vec3) -> Aabb {
        Aabb {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// The smallest box that contains both.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Half the surface area; infinite for boxes beyond about 1e19.
    pub fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Returns `true` if the box contains no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Center and radius of the bounding sphere; radius 0 if the box is empty.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        if self.is_empty() {
            return (Vec3::ZERO, 0.0);
        }
        // Halved before the addition: the sum of two large coordinates may overflow.
        let center = self.min * 0.5 + self.max * 0.5;
        (center, (self.max - center).length())
    }
}
