//! From the closest hit to the surface there: normals, (u, v) and derivatives are computed only where a material needs them.

use super::instance::InnerRay;
use super::level::{Level, StoredMesh};
use super::primitive::{OtherKind, PrimitiveId};
use super::search::ClosestHit;
use super::{Geometry, GeometryHit, PrimitiveAttributes};
use crate::handles::LightId;
use crate::math::ray::Ray;
use crate::math::{DVec3, Vec2};
use crate::shapes::local::{
    Local, LocalHit, LocalPoint, LocalSurface, Parameters, ParametricPoint, TriangleSource,
};
use crate::shapes::triangle::Triangle;

/// A surface, its attributes and its light.
type Resolved<'a, L> = (L, &'a PrimitiveAttributes, Option<LightId>);

impl Geometry {
    /// The surface at the hit that a search found; with the parameters (u, v) of what has a material, whether or not anything else asks for them, if they
    /// are `wanted`.
    #[inline]
    pub(super) fn resolve(
        &self,
        ray: &Ray,
        found: &ClosestHit,
        wanted: bool,
    ) -> Option<GeometryHit> {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        if found.path[0] == PrimitiveId::NONE && found.id.is_triangle() {
            // The most common hit; nothing is copied on its way out.
            let triangle = StoredTriangle::new(&self.top, found);
            return match triangle.mesh.attributes.bare {
                true if wanted => self.resolve_as::<ParametricPoint>(ray, found),
                true => Some(hit(&triangle.resolve::<LocalPoint>(o, d), ray, found)),
                false => Some(hit(&triangle.resolve::<LocalSurface>(o, d), ray, found)),
            };
        }
        let attributes = self.attributes(found);
        match attributes.bare {
            true if wanted && attributes.material.is_some() => {
                self.resolve_as::<ParametricPoint>(ray, found)
            }
            true => self.resolve_as::<LocalPoint>(ray, found),
            false => self.resolve_as::<LocalSurface>(ray, found),
        }
    }

    /// As [`Geometry::resolve`], with all that is known of the surface.
    #[cfg(test)]
    pub(crate) fn whole(&self, ray: &Ray, found: &ClosestHit) -> Option<GeometryHit> {
        self.resolve_as::<LocalSurface>(ray, found)
    }

    /// The attributes of what a search found.
    pub(super) fn attributes(&self, found: &ClosestHit) -> &PrimitiveAttributes {
        let mut level = &self.top;
        for id in found.path.into_iter().filter(|&id| id != PrimitiveId::NONE) {
            level = level.instances[id.index()].level(&self.objects);
        }
        level.attributes(found.id)
    }

    /// The parameters (u, v) of what a search found, whether or not anything asks for them.
    pub fn parameters(&self, ray: &Ray, found: &ClosestHit) -> Vec2 {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let resolved = self.resolve_along::<Parameters>(&self.top, o, d, found, ray.time);
        resolved.map_or(Vec2::ZERO, |(Parameters(uv), ..)| uv)
    }

    fn resolve_as<L: LocalHit>(&self, ray: &Ray, found: &ClosestHit) -> Option<GeometryHit> {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let resolved = self.resolve_along::<L>(&self.top, o, d, found, ray.time)?;
        Some(hit(&resolved, ray, found))
    }

    /// The surface in the space of `level`, where the path of `found` starts.
    fn resolve_along<'a, L: Local>(
        &'a self,
        level: &'a Level,
        o: DVec3,
        d: DVec3,
        found: &ClosestHit,
        time: f32,
    ) -> Option<Resolved<'a, L>> {
        let [next, rest] = found.path;
        if next == PrimitiveId::NONE {
            return resolve_in(level, o, d, found);
        }
        let instance = &level.instances[next.index()];
        let (place, inside) = (instance.place(time), instance.level(&self.objects));
        let inner = InnerRay::new(&place, o, d, inside);
        let found = ClosestHit {
            path: [rest, PrimitiveId::NONE],
            ..*found
        };
        // Deeper levels use the ray as the search had it.
        let (o, d) = if rest == PrimitiveId::NONE {
            (inner.o, inner.d)
        } else {
            (inner.o.as_vec3().as_dvec3(), inner.d.as_vec3().as_dvec3())
        };
        let (local, attributes, light) = self.resolve_along::<L>(inside, o, d, &found, time)?;
        Some((local.transformed(&place), attributes, light))
    }
}

/// The hit of `ray` on a resolved surface.
#[inline(always)]
fn hit<L: LocalHit>(resolved: &Resolved<L>, ray: &Ray, found: &ClosestHit) -> GeometryHit {
    let &(ref local, attributes, light) = resolved;
    GeometryHit {
        surface: local.hit(ray),
        material: attributes.material,
        light,
        interface: attributes.interface,
        t: found.t,
        shape: attributes.shape,
        found: *found,
    }
}

/// A triangle of a level.
struct StoredTriangle<'a> {
    level: &'a Level,
    mesh: &'a StoredMesh,
    /// Its index in the mesh.
    i: usize,
}

impl<'a> StoredTriangle<'a> {
    #[inline(always)]
    fn new(level: &'a Level, found: &ClosestHit) -> StoredTriangle<'a> {
        let (mesh, i) = level.locate(found.id.index());
        StoredTriangle { level, mesh, i }
    }

    /// The surface in the space of the level where the line `o + t d` meets it.
    #[inline(always)]
    fn resolve<L: Local>(&self, o: DVec3, d: DVec3) -> Resolved<'a, L> {
        let attributes = &self.mesh.attributes;
        let number = self.i as u32 >> u32::from(attributes.paired_lights);
        let light = attributes.light.map(|first| LightId(first.0 + number));
        (L::of_triangle(self, o, d), attributes, light)
    }
}

impl TriangleSource for StoredTriangle<'_> {
    #[inline(always)]
    fn bare(&self) -> Triangle {
        self.mesh.bare_triangle(self.i)
    }

    #[inline(always)]
    fn parametric(&self) -> Triangle {
        self.mesh.parametric_triangle(self.i)
    }

    #[inline]
    fn whole(&self) -> Triangle {
        self.mesh.triangle(self.i)
    }

    fn face(&self) -> u32 {
        self.level.face_ids.of(self.mesh.first, self.i)
    }
}

/// The surface in the space of `level` where the line `o + t d` intersects the primitive found.
fn resolve_in<'a, L: Local>(
    level: &'a Level,
    o: DVec3,
    d: DVec3,
    found: &ClosestHit,
) -> Option<Resolved<'a, L>> {
    if found.id.is_triangle() {
        return Some(StoredTriangle::new(level, found).resolve(o, d));
    }
    let i = found.id.index();
    // The ray as the search had it, so that it finds the same point again.
    let (o, d) = (o.as_vec3().as_dvec3(), d.as_vec3().as_dvec3());
    let (surface, attributes) = match found.id.kind() {
        OtherKind::Curve => {
            let (surface, attributes) = level.curves.surface(i, o, d)?;
            (L::from(surface), attributes)
        }
        _ => {
            let stored = &level.quadrics[i];
            (L::of_quadric(&stored.quadric, o, d)?, &stored.attributes)
        }
    };
    Some((surface, attributes, attributes.light))
}
