//! Trees within a tree: instances of objects, at rest or moving, and moving shapes.
//!
//! A scene without motion has none that moves, and pays nothing for them.

use super::aabb::Aabb;
use super::level::Level;
use crate::handles::ObjectId;
use crate::math::DVec3;
use crate::math::motion::Motion;
use crate::math::transform::{Place, Transform, box_around, box_corners};
use std::borrow::Cow;

/// What stands in a tree.
pub(super) enum Inner {
    /// A shape, with a tree of its own.
    Shape(Box<Level>),
    /// A named object; the number of this instance among all of the scene.
    Object { object: ObjectId, number: u32 },
}

/// Where it stands.
enum Placement {
    /// From the inner tree's coordinates, relative to its anchor, to the outer tree's.
    AtRest(Place),
    Moving(Box<Moving>),
}

/// A placement that depends on the time of the ray.
struct Moving {
    /// From the inner level's coordinates, relative to the origin and not to its anchor, to those of the tree.
    motion: Motion,
    /// The inner level's anchor.
    anchor: DVec3,
}

/// A tree with its place in another one.
pub(super) struct Instance {
    pub inner: Inner,
    placement: Placement,
}

/// A ray transformed to an object's space, with its origin moved up to the object.
pub(super) struct InnerRay {
    /// Origin.
    pub o: DVec3,
    /// Unit direction.
    pub d: DVec3,
    /// Inner distances are outer ones times `scale`, minus `start`.
    pub scale: f64,
    /// How far the origin was moved along the ray.
    pub start: f64,
}

impl Instance {
    /// Places `inner`, whose shapes are `level`. `None` if the transformation is singular.
    pub(super) fn at_rest(
        inner: Inner,
        level: &Level,
        render_from_object: &Transform,
    ) -> Option<Instance> {
        let placed =
            (*render_from_object * Transform::translate(level.anchor)).with_translations_matched();
        placed.is_invertible().then(|| Instance {
            inner,
            placement: Placement::AtRest(Place::new(&placed)),
        })
    }

    /// A moving `inner`, a level with the given anchor; `motion` maps the space its shapes were compiled in to that of
    /// the outer tree.
    pub(super) fn moving(inner: Inner, anchor: DVec3, motion: Motion) -> Instance {
        Instance {
            inner,
            placement: Placement::Moving(Box::new(Moving { motion, anchor })),
        }
    }

    pub(super) fn moves(&self) -> bool {
        matches!(self.placement, Placement::Moving(_))
    }

    /// The inner tree, one of `objects` or its own.
    #[inline]
    pub(super) fn level<'a>(&'a self, objects: &'a [Level]) -> &'a Level {
        match &self.inner {
            Inner::Object { object, .. } => &objects[object.index()],
            Inner::Shape(level) => level,
        }
    }

    /// Its placement at `time`.
    #[inline]
    pub(super) fn place(&self, time: f32) -> Cow<'_, Place> {
        match &self.placement {
            Placement::AtRest(place) => Cow::Borrowed(place),
            Placement::Moving(moving) => Cow::Owned(moving.place(time)),
        }
    }

    /// Bounding box in the outer space, over all times.
    pub(super) fn bounds(&self, level: &Level) -> Aabb {
        let (min, max) = match &self.placement {
            Placement::AtRest(place) => bounds_at(place, level),
            Placement::Moving(moving) => {
                let Some(bounds) = level.padded_bounds() else {
                    return Aabb::EMPTY;
                };
                let [low, high] = [bounds.0, bounds.1].map(|corner| corner + moving.anchor);
                moving.motion.bounds(low, high)
            }
        };
        if min.x > max.x {
            // Not finite: the level leaves it out.
            return Aabb::EMPTY;
        }
        Aabb::around(min, max)
    }
}

impl Moving {
    #[cold]
    fn place(&self, time: f32) -> Place {
        let mut outer_from_inner = self.motion.at(f64::from(time));
        outer_from_inner.translation = outer_from_inner.transform_point3(self.anchor);
        Place {
            outer_from_inner,
            inner_from_outer: outer_from_inner.inverse(),
        }
    }
}

/// Corners of the box of `level` in the outer space. The transformed bounding box would be up to twice as wide as the
/// object, so this is the union of the transformed boxes of the root's children: correspondingly fewer rays enter in
/// vain.
fn bounds_at(place: &Place, level: &Level) -> (DVec3, DVec3) {
    let corners = level
        .padded_parts()
        .flat_map(|(low, high)| box_corners(low, high));
    box_around(corners.map(|corner| place.outer_from_inner.transform_point3(corner)))
}

impl InnerRay {
    /// The ray `o + t d` within `place`, starting near the object: distances are then small, and single precision is
    /// spent where it matters, however far away the ray began.
    pub(super) fn new(place: &Place, o: DVec3, d: DVec3, level: &Level) -> InnerRay {
        let (inner_o, inner_d) = place.inward(o, d);
        let scale = inner_d.length();
        let d = inner_d / scale;
        // The ray cannot reach the object's bounding sphere before this.
        let start = (-inner_o.dot(d) - level.radius * 1.001).max(0.0);
        InnerRay {
            o: inner_o + d * start,
            d,
            scale,
            start,
        }
    }

    /// The outer distance of an inner one.
    pub(super) fn outer(&self, t: f64) -> f64 {
        (t + self.start) / self.scale
    }

    /// The inner distance of an outer one.
    pub(super) fn inner(&self, t: f64) -> f64 {
        t * self.scale - self.start
    }
}

#[cfg(test)]
mod tests {
    use super::super::GeometryBuilder;
    use super::super::PrimitiveAttributes;
    use super::*;
    use crate::assets::mesh::MeshData;
    use crate::shapes::CompiledShape;
    use crate::shapes::mesh::TriangleMesh;

    #[test]
    fn the_box_of_a_turned_copy_is_around_the_object_and_not_around_its_box() {
        // Sixteen small triangles along a diagonal; rotated by 45° they are aligned with an axis.
        let mut data = MeshData::default();
        for i in 0..16 {
            let p = DVec3::new(f64::from(i), f64::from(i), 0.0);
            let corners = [p, p + DVec3::X * 0.1, p + DVec3::Y * 0.1];
            data.positions.extend(corners);
            data.indices.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mesh = TriangleMesh::new(data.clone(), &Transform::IDENTITY, false);
        let mut builder = GeometryBuilder::of_object();
        let shape = CompiledShape::Mesh(Box::new(mesh));
        builder.add(shape, PrimitiveAttributes::default());
        let level = builder.level(&[]).unwrap();
        let turn = Transform::rotate(45.0, DVec3::Z);
        let inner = Inner::Object {
            object: ObjectId(0),
            number: 0,
        };
        let instance = Instance::at_rest(inner, &level, &turn).unwrap();
        let bounds = instance.bounds(&level);
        for p in &data.positions {
            let p = turn.m.transform_point3(*p).as_vec3();
            assert!(bounds.min.cmple(p).all() && bounds.max.cmpge(p).all());
        }
        // The transformed box would be 15 √2 wide, as wide as it is long.
        let size = bounds.max - bounds.min;
        assert!(size.x < 5.0, "{size}");
        assert!((20.0..23.0).contains(&size.y), "{size}");
    }
}
