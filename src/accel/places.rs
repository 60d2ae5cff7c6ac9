//! Points about the surfaces that somebody asks for: where light that is aimed at them goes.

use super::aabb::Aabb;
use super::instance::{Inner, Instance};
use super::level::{Level, StoredMesh};
use super::{Geometry, PrimitiveAttributes};
use crate::math::distribution::Distribution1D;
use crate::math::hash::{mix2, unit_float};
use crate::math::{DVec3, Vec3};

/// Triangles of a mesh, and pieces of curves, that are looked at: enough to be everywhere about them, and no memory to speak of.
const MOST: usize = 1 << 16;

/// Surfaces that get as many points as others, however large they are: what is small may gather as much light.
enum Part<'a> {
    /// A mesh, and the areas of its triangles, or of some as far from each other as this.
    Mesh(&'a StoredMesh, Box<Distribution1D>, usize),
    /// A quadric, a piece of a curve, or what moves.
    Box(Aabb),
    /// At rest; with the parts of its object.
    Instance(&'a Instance, &'a [Part<'a>]),
}

impl Geometry {
    /// So many points, render space, spread over those surfaces whose attributes are `wanted`, or over the boxes that they are in; for each shape as
    /// many as for each other, and for each instance of an object. None where there are no such surfaces.
    pub fn points_about(
        &self,
        wanted: &dyn Fn(&PrimitiveAttributes) -> bool,
        count: usize,
    ) -> Vec<Vec3> {
        let objects: Vec<Vec<Part>> = { self.objects.iter() }
            .map(|level| parts(level, &self.objects, &[], wanted))
            .collect();
        let parts = parts(&self.top, &self.objects, &objects, wanted);
        if parts.is_empty() {
            return Vec::new();
        }
        // Where there are more parts than points, as far from each other as they go.
        let part = |point: usize| &parts[point * parts.len() / count];
        (0..count)
            .map(|i| part(i).point(i as u64).as_vec3())
            .collect()
    }
}

/// The parts of a level that are `wanted`, where `inner` are those of the objects.
fn parts<'a>(
    level: &'a Level,
    objects: &'a [Level],
    inner: &'a [Vec<Part<'a>>],
    wanted: &dyn Fn(&PrimitiveAttributes) -> bool,
) -> Vec<Part<'a>> {
    let meshes = { level.meshes.iter() }
        .filter(|mesh| !mesh.indices.is_empty() && wanted(&mesh.attributes))
        .map(|mesh| {
            let step = mesh.indices.len().div_ceil(MOST);
            Part::Mesh(mesh, Box::new(areas(mesh, step)), step)
        });
    let quadrics = { level.quadrics.iter() }
        .filter(|stored| wanted(&stored.attributes))
        .map(|stored| stored.quadric.bounds())
        .map(|(min, max)| Part::Box(Aabb::around(min, max)));
    // Of hair there may be millions of pieces, and none wanted.
    let any_curve = level.curves.all_attributes().any(wanted);
    let step = level.curves.piece_numbers().div_ceil(MOST).max(1);
    let curves = { any_curve.then(|| level.curves.pieces()).into_iter() }
        .flatten()
        .step_by(step)
        .filter(|&(piece, _)| wanted(level.curves.attributes(piece)))
        .map(|(_, bounds)| Part::Box(bounds));
    let instances = { level.instances.iter() }.filter_map(|instance| match &instance.inner {
        Inner::Shape(shape) => {
            let any = !parts(shape, objects, inner, wanted).is_empty();
            any.then(|| Part::Box(instance.bounds(shape)))
        }
        Inner::Object { object, .. } => {
            let of_object = inner
                .get(object.index())
                .filter(|parts| !parts.is_empty())?;
            Some(match instance.moves() {
                true => Part::Box(instance.bounds(instance.level(objects))),
                false => Part::Instance(instance, of_object),
            })
        }
    });
    meshes
        .chain(quadrics)
        .chain(curves)
        .chain(instances)
        .collect()
}

/// Of every so many of its triangles.
fn areas(mesh: &StoredMesh, step: usize) -> Distribution1D {
    let area = |i| {
        let [a, b, c] = mesh.corners(i);
        (b - a).cross(c - a).length()
    };
    Distribution1D::new((0..mesh.indices.len()).step_by(step).map(area))
}

impl Part<'_> {
    /// One of its points, in the coordinates of its level; which of them, a `number` says.
    fn point(&self, number: u64) -> DVec3 {
        let u = |dimension: u64| unit_float(mix2(number, dimension));
        match self {
            Part::Mesh(mesh, areas, step) => {
                let (i, ..) = areas.sample_discrete(u(0));
                let [a, b, c] = mesh.corners(i * step).map(Vec3::as_dvec3);
                let root = f64::from(u(1)).sqrt();
                a + root * ((b - a) + f64::from(u(2)) * (c - b))
            }
            Part::Box(bounds) => {
                let size = (bounds.max - bounds.min).as_dvec3();
                bounds.min.as_dvec3() + size * DVec3::from([u(0), u(1), u(2)].map(f64::from))
            }
            Part::Instance(instance, parts) => {
                let part = ((u(3) * parts.len() as f32) as usize).min(parts.len() - 1);
                let inside = parts[part].point(number);
                instance
                    .place(0.0)
                    .outer_from_inner
                    .transform_point3(inside)
            }
        }
    }
}
