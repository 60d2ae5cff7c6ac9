//! Ours and obvhs's two behind one interface.

use crate::meshes::Mesh;
use fstop::accel::{Geometry, GeometryBuilder, GeometryStatistics, PrimitiveAttributes};
use fstop::inputs::FloatInput;
use fstop::math::Vec3;
use fstop::math::ray::Ray;
use fstop::math::transform::Transform;
use fstop::shapes::CompiledShape;
use fstop::shapes::mesh::TriangleMesh;
use fstop::surface::TexturePoint;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::fmt;

/// What is asked along a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Query {
    /// The distance of the closest hit.
    Closest,
    /// Whether there is one.
    Any,
}

impl fmt::Display for Query {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Query::Closest => "closest",
            Query::Any => "any",
        })
    }
}

/// Something that finds hits.
pub(crate) trait Contender {
    /// Finds the closest hit and says whether there is one.
    fn closest(&self, ray: &Ray) -> bool;
    /// Is there any hit?
    fn any(&self, ray: &Ray) -> bool;
}

/// Our tree: distances and numbers of triangles, as the others find them.
pub(crate) struct Ours(Geometry);

fn opaque(_: &FloatInput, _: &TexturePoint) -> f32 {
    1.0
}

impl Ours {
    pub(crate) fn new(mesh: &Mesh) -> Ours {
        let mut builder = GeometryBuilder::default();
        let placed = TriangleMesh::new(mesh.data.clone(), &Transform::IDENTITY, false);
        builder.add(
            CompiledShape::Mesh(Box::new(placed)),
            PrimitiveAttributes::default(),
        );
        Ours(builder.build(vec![]).expect("not too many triangles"))
    }

    pub(crate) fn statistics(&self) -> GeometryStatistics {
        self.0.statistics()
    }

    /// Where the ray meets the mesh, and the normal on the side it comes from.
    pub(crate) fn surface(&self, ray: &Ray) -> Option<(Vec3, Vec3)> {
        let surface = self.0.intersect(ray, &opaque)?.surface;
        let n = surface.n * -surface.n.dot(ray.d).signum();
        Some((surface.p, n))
    }
}

impl Contender for Ours {
    fn closest(&self, ray: &Ray) -> bool {
        self.0.distance(ray, &opaque).is_some()
    }

    fn any(&self, ray: &Ray) -> bool {
        self.0.occluded(ray, &opaque)
    }
}

/// The same with what a renderer needs besides: point, normals and derivatives.
pub(crate) struct OursWithSurfaces<'a>(pub &'a Ours);

impl Contender for OursWithSurfaces<'_> {
    fn closest(&self, ray: &Ray) -> bool {
        self.0.0.intersect(ray, &opaque).is_some()
    }

    fn any(&self, ray: &Ray) -> bool {
        self.0.any(ray)
    }
}

fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let corner = |i: u32| mesh.data.positions[i as usize].as_vec3().into();
    let of = |t: &[u32; 3]| Triangle {
        v0: corner(t[0]),
        v1: corner(t[1]),
        v2: corner(t[2]),
    };
    mesh.data.indices.iter().map(of).collect()
}

fn convert(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.o.into(), ray.d.into(), 0.0, ray.t_max)
}

/// obvhs's binary tree, with its triangles in the order of the leaves.
pub(crate) struct Tree2(Bvh2, Vec<RtTriangle>);

impl Tree2 {
    pub(crate) fn new(mesh: &Mesh) -> Tree2 {
        let triangles = triangles(mesh);
        let parameters = BvhBuildParams::medium_build();
        let bvh = build_bvh2_from_tris(&triangles, parameters, &mut Default::default());
        let ordered = bvh.primitive_indices.iter();
        let ordered = ordered.map(|&i| (&triangles[i as usize]).into()).collect();
        Tree2(bvh, ordered)
    }
}

impl Contender for Tree2 {
    fn closest(&self, ray: &Ray) -> bool {
        let mut hit = RayHit::none();
        let meet = |ray: &obvhs::ray::Ray, i: usize| self.1[i].intersect(ray);
        self.0.ray_traverse(convert(ray), &mut hit, meet)
    }

    fn any(&self, ray: &Ray) -> bool {
        let meet = |ray: &obvhs::ray::Ray, i: usize| self.1[i].intersect(ray);
        !self.0.ray_traverse_miss(convert(ray), meet)
    }
}

/// obvhs's compressed 8-wide tree, likewise.
pub(crate) struct CwBvhTree(CwBvh, Vec<RtTriangle>);

impl CwBvhTree {
    pub(crate) fn new(mesh: &Mesh) -> CwBvhTree {
        let triangles = triangles(mesh);
        let parameters = BvhBuildParams::medium_build();
        let bvh = build_cwbvh_from_tris(&triangles, parameters, &mut Default::default());
        let ordered = bvh.primitive_indices.iter();
        let ordered = ordered.map(|&i| (&triangles[i as usize]).into()).collect();
        CwBvhTree(bvh, ordered)
    }
}

impl Contender for CwBvhTree {
    fn closest(&self, ray: &Ray) -> bool {
        let mut hit = RayHit::none();
        let meet = |ray: &obvhs::ray::Ray, i: usize| self.1[i].intersect(ray);
        self.0.ray_traverse(convert(ray), &mut hit, meet)
    }

    fn any(&self, ray: &Ray) -> bool {
        let meet = |ray: &obvhs::ray::Ray, i: usize| self.1[i].intersect(ray);
        !self.0.ray_traverse_miss(convert(ray), meet)
    }
}
