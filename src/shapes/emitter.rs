//! Shapes that light is sampled from.
//!
//! Full spheres under rotations and uniform scales are sampled by the cone of directions they
//! fill; everything else uniformly over the object-space area, with the density converted by the world area
//! of the piece sampled, so that any affine transformation gives the right light. (The reference ignores
//! scale and cuts here: docs/scene-language.md §4.5. We do not.) Curves cannot emit, as in pbrt-v3.

use super::ball::Ball;
use super::mesh::TriangleMesh;
use super::quadric::{ObjectSurface, Quadric};
use super::triangle::Orientation;
use crate::math::float::{UNIT_ROUNDOFF, offset_ray_origin};
use crate::math::sampling::{concentric_disk, uniform_triangle};
use crate::math::{DVec3, Vec2, Vec3};
use crate::surface::{ReferencePoint, SurfaceHit};
use glam::DMat3;
use std::f64::consts::TAU;

mod parallelogram;

pub use parallelogram::ParallelogramEmitter;

/// A point chosen on an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// The point, render space.
    pub p: Vec3,
    /// Half-widths of the box around `p` that holds the exact point.
    pub p_error: Vec3,
    /// Unit normal, on the side that [`SurfaceHit::n`] has there.
    pub n: Vec3,
    /// Unit direction to it.
    pub wi: Vec3,
    /// Density per solid angle at the receiving point.
    pub pdf: f32,
}

/// A point chosen on an emitter for itself, not as seen from anywhere.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// See [`EmitterSample::p`].
    pub p: Vec3,
    /// See [`EmitterSample::p_error`].
    pub p_error: Vec3,
    /// See [`EmitterSample::n`].
    pub n: Vec3,
    /// Density per area; infinite where there is none.
    pub density: f32,
}

/// What is sampled without a branch, so that many samples can be computed side by side.
pub(crate) trait BranchlessEmitter: Copy {
    /// [`Emitter::sample`], and whether there is a sample; without one, the first part means nothing.
    fn sample(&self, from: &ReferencePoint, u: Vec2) -> (EmitterSample, bool);
}

/// A shape that light is sampled from: its own copy, nothing refers into the geometry.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A triangle of a mesh, sampled by area.
    Triangle(TriangleEmitter),
    /// Two triangles of a mesh that make a parallelogram, sampled by area.
    Parallelogram(Box<ParallelogramEmitter>),
    /// A full sphere, sampled by the cone of directions it fills.
    Sphere(Box<Ball>),
    /// Any other quadric, sampled by area.
    Quadric(Box<QuadricEmitter>),
}

impl Emitter {
    /// The pieces of `mesh`, in order: parallelograms where every two of its triangles make one, else its
    /// triangles ([`Emitter::is_pair`]). One by one: of many there is no list.
    pub fn of_mesh(mesh: &TriangleMesh) -> Box<dyn Iterator<Item = Emitter> + '_> {
        if let Some(pieces) = parallelograms(mesh) {
            return Box::new(pieces.into_iter());
        }
        let triangle = move |corners: &[u32; 3]| {
            let normal = |i: u32| mesh.data.normals.get(i as usize).copied();
            let [a, b, c] = corners.map(normal);
            let normals = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
            let corners = corners_of(mesh, corners);
            Emitter::Triangle(TriangleEmitter::new(corners, normals, mesh.orientation))
        };
        Box::new(mesh.data.indices.iter().map(triangle))
    }

    /// Returns `true` if this, which is of [`Emitter::of_mesh`], is two triangles; all others of the mesh are then, too.
    pub fn is_pair(&self) -> bool {
        matches!(self, Emitter::Parallelogram(_))
    }

    /// A quadric in render space.
    pub fn of_quadric(quadric: &Quadric) -> Emitter {
        if let Some(ball) = quadric.ball() {
            return Emitter::Sphere(Box::new(*ball));
        }
        Emitter::Quadric(Box::new(QuadricEmitter {
            quadric: *quadric,
            volume_area: quadric.form.area() * quadric.volume_scale(),
            area: quadric.area(),
            error: quadric.largest_position_error(),
        }))
    }

    /// Chooses a point as seen from `from`. `None` where nothing can be seen from there or the
    /// shape has no area: densities are positive and finite. The point may be hidden by other parts of
    /// the same shape.
    #[inline]
    pub fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<EmitterSample> {
        match self {
            Emitter::Triangle(triangle) => triangle.point(u).seen_from(from),
            Emitter::Parallelogram(piece) => piece.point(u).seen_from(from),
            Emitter::Sphere(sphere) => sphere.sample(from, u),
            Emitter::Quadric(quadric) => quadric.point(u).seen_from(from),
        }
    }

    /// Density per solid angle with which [`Emitter::sample`] chooses the point `hit`, where a
    /// ray from `from` along the unit direction `wi` met this emitter. 0 where it cannot.
    pub fn pdf(&self, from: &ReferencePoint, wi: Vec3, hit: &SurfaceHit) -> f32 {
        if let Emitter::Sphere(sphere) = self
            && let Some(cone) = sphere.cone(from)
        {
            return cone.density() as f32;
        }
        let area = self.area_around(hit.n);
        let distance2 = (hit.p.as_dvec3() - from.p.as_dvec3()).length_squared();
        let pdf = per_solid_angle(area, distance2, hit.n.as_dvec3().dot(wi.as_dvec3()));
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// Chooses a point by area: evenly, but for quadrics whose transformation deforms them, which stay even in object space.
    pub fn sample_area(&self, u: Vec2) -> AreaSample {
        let point = match self {
            Emitter::Triangle(triangle) => triangle.point(u),
            Emitter::Parallelogram(piece) => piece.point(u),
            Emitter::Sphere(sphere) => sphere.point(u),
            Emitter::Quadric(quadric) => quadric.point(u),
        };
        let p = point.p.as_vec3();
        AreaSample {
            p,
            p_error: rounded_box(point.error, p),
            n: point.n.as_vec3(),
            density: point.area.recip() as f32,
        }
    }

    /// Density per area with which [`Emitter::sample_area`] chooses a point where the unit normal is `n`, either side.
    pub fn area_density(&self, n: Vec3) -> f32 {
        self.area_around(n).recip() as f32
    }

    /// The area that points are spread over as densely as around one with the unit normal `n`.
    #[inline]
    fn area_around(&self, n: Vec3) -> f64 {
        match self {
            Emitter::Triangle(triangle) => triangle.area(),
            Emitter::Parallelogram(piece) => piece.area,
            Emitter::Sphere(sphere) => sphere.area(),
            Emitter::Quadric(quadric) => quadric.area_around(n.as_dvec3()),
        }
    }

    /// Surface area in world units squared.
    pub fn area(&self) -> f64 {
        match self {
            Emitter::Triangle(triangle) => triangle.area(),
            Emitter::Parallelogram(piece) => piece.area,
            Emitter::Sphere(sphere) => sphere.area(),
            Emitter::Quadric(quadric) => quadric.area,
        }
    }
}

/// Returns `true` if it is positive and finite.
#[inline(always)]
fn is_density(pdf: f32) -> bool {
    (pdf > 0.0) & pdf.is_finite()
}

/// The density per solid angle of points spread evenly over `area`.
#[inline(always)]
fn per_solid_angle(area: f64, distance2: f64, cosine: f64) -> f32 {
    (distance2 / (area * cosine.abs())) as f32
}

/// Half-widths of the box around a point of this error that has been rounded to `p`.
#[inline(always)]
fn rounded_box(error: DVec3, p: Vec3) -> Vec3 {
    error.as_vec3() + p.abs() * UNIT_ROUNDOFF
}

/// A point chosen by area.
struct AreaPoint {
    p: DVec3,
    /// That of `p`.
    error: DVec3,
    /// Unit normal.
    n: DVec3,
    /// What such points are spread over.
    area: f64,
}

impl AreaPoint {
    #[inline]
    fn seen_from(&self, from: &ReferencePoint) -> Option<EmitterSample> {
        let (sample, is_seen) = self.seen(from);
        is_seen.then_some(sample)
    }

    /// [`AreaPoint::seen_from`] without a branch, and whether it is seen at all.
    #[inline(always)]
    fn seen(&self, from: &ReferencePoint) -> (EmitterSample, bool) {
        let away = self.p - from.p.as_dvec3();
        let distance2 = away.length_squared();
        let wi = away * distance2.sqrt().recip();
        let pdf = per_solid_angle(self.area, distance2, wi.dot(self.n));
        let rounded = self.p.as_vec3();
        let sample = EmitterSample {
            p: rounded,
            p_error: rounded_box(self.error, rounded),
            n: self.n.as_vec3(),
            wi: wi.as_vec3(),
            pdf,
        };
        (sample, (distance2 != 0.0) & is_density(pdf))
    }
}

/// The corners of a triangle of `mesh`.
fn corners_of(mesh: &TriangleMesh, corners: &[u32; 3]) -> [Vec3; 3] {
    corners.map(|i| {
        let p = mesh.data.positions.get(i as usize);
        p.map_or(Vec3::NAN, |p| p.as_vec3())
    })
}

/// `mesh` as parallelograms of two triangles each, if it is nothing else. Normals would decide the side
/// that shines point by point.
fn parallelograms(mesh: &TriangleMesh) -> Option<Vec<Emitter>> {
    if !mesh.data.normals.is_empty() || !mesh.data.indices.len().is_multiple_of(2) {
        return None;
    }
    let piece = |pair: &[[u32; 3]]| {
        let [a, b] = [0, 1].map(|i| pair.get(i).map(|t| corners_of(mesh, t)));
        ParallelogramEmitter::of_triangles(a?, b?, mesh.orientation)
            .map(|piece| Emitter::Parallelogram(Box::new(piece)))
    };
    mesh.data.indices.chunks(2).map(piece).collect()
}

/// See [`Emitter::Triangle`].
#[derive(Clone, Debug)]
pub struct TriangleEmitter {
    /// Corners, render space.
    p: [Vec3; 3],
    /// Unit normals at the corners: they decide the side that shines.
    normals: Option<Box<[Vec3; 3]>>,
    orientation: Orientation,
}

impl TriangleEmitter {
    /// From corners and, if there are any, unit normals at them, in render space.
    pub fn new(
        p: [Vec3; 3],
        normals: Option<[Vec3; 3]>,
        orientation: Orientation,
    ) -> TriangleEmitter {
        TriangleEmitter {
            p,
            normals: normals.map(Box::new),
            orientation,
        }
    }

    /// The cross product of two edges. Of many lights what follows from it takes more memory than time.
    #[inline]
    fn cross(&self) -> DVec3 {
        let [a, b, c] = self.p.map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }

    fn area(&self) -> f64 {
        0.5 * self.cross().length()
    }

    #[inline]
    fn point(&self, u: Vec2) -> AreaPoint {
        let b = uniform_triangle(u).as_dvec2();
        let b = [b.x, b.y, (1.0 - b.x - b.y).max(0.0)];
        let corners = self.p.map(Vec3::as_dvec3);
        let p = corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2];
        let largest = corners.iter().fold(DVec3::ZERO, |m, p| m.max(p.abs()));
        let cross = self.cross();
        AreaPoint {
            p,
            error: largest * (8.0 * f64::EPSILON),
            n: self.normal(cross, b),
            area: 0.5 * cross.length(),
        }
    }

    /// The normal at `b` on the side that [`Triangle::surface`](super::triangle::Triangle::surface) has there.
    fn normal(&self, cross: DVec3, b: [f64; 3]) -> DVec3 {
        // That of the side that shines where there are no others.
        let face = self.orientation.geometric(cross.normalize_or(DVec3::Z));
        let Some(normals) = self.normals.as_deref() else {
            return face;
        };
        let [x, y, z] = normals.map(Vec3::as_dvec3);
        let n = x * b[0] + y * b[1] + z * b[2];
        // Where they cancel the corners' order decides.
        if self.orientation.shading(n).dot(face) < 0.0 && n.try_normalize().is_some() {
            -face
        } else {
            face
        }
    }
}

/// The directions under which a sphere is seen from a point outside.
struct Cone {
    /// Unit direction to the center.
    axis: DVec3,
    /// Sine of the half-angle.
    sin_max: f64,
    /// 1 − cosine of the half-angle.
    one_minus_cos_max: f64,
}

impl Cone {
    /// Uniform over the directions.
    #[inline(always)]
    fn density(&self) -> f64 {
        1.0 / (TAU * self.one_minus_cos_max)
    }
}

impl Ball {
    fn area(&self) -> f64 {
        2.0 * TAU * self.radius * self.radius
    }

    /// `None` from inside the sphere, and from a point on it: rounding decides which side of the
    /// sphere that falls, and only its inside can be seen from there.
    fn cone(&self, from: &ReferencePoint) -> Option<Cone> {
        let toward = self.center - from.p.as_dvec3();
        let distance2 = toward.length_squared();
        if !self.is_clear_of(from, distance2) {
            let moved_in = offset_ray_origin(from.p, from.p_error, from.n, toward.as_vec3());
            let left = (self.center - moved_in.as_dvec3()).length_squared();
            if left <= self.radius * self.radius {
                return None;
            }
        }
        Some(self.cone_toward(toward, distance2))
    }

    /// Returns `true` if `from`, at this squared distance from the center, is outside without doubt.
    #[inline(always)]
    fn is_clear_of(&self, from: &ReferencePoint, distance2: f64) -> bool {
        // No ray's origin is farther from the point than this.
        let slack = from.p_error.element_sum() + 4.0 * f32::EPSILON * from.p.abs().element_sum();
        let near = self.radius + f64::from(slack);
        distance2 > near * near
    }

    /// Returns `true` if `from` is outside without doubt. From there the ball is [`Ball::far`].
    #[inline(always)]
    pub(crate) fn is_far_from(&self, from: &ReferencePoint) -> bool {
        let distance2 = (self.center - from.p.as_dvec3()).length_squared();
        self.is_clear_of(from, distance2)
    }

    /// The same without a branch, for points that it [is far from](Ball::is_far_from).
    #[inline(always)]
    pub(crate) fn far(&self) -> FarBall {
        FarBall(*self)
    }

    /// The cone for a point outside, by the vector to the center.
    #[inline(always)]
    fn cone_toward(&self, toward: DVec3, distance2: f64) -> Cone {
        let distance = distance2.sqrt();
        let sin_max = self.radius / distance;
        // Products instead of 1 − cos and 1 − sin²: nothing cancels for far or near spheres.
        let cos_max = ((1.0 - sin_max) * (1.0 + sin_max)).sqrt();
        Cone {
            axis: toward / distance,
            sin_max,
            one_minus_cos_max: sin_max * sin_max / (1.0 + cos_max),
        }
    }

    fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<EmitterSample> {
        if let Some(cone) = self.cone(from) {
            let pdf = cone.density() as f32;
            return is_density(pdf).then(|| self.sample_in(&cone, pdf, u));
        }
        self.point(u).seen_from(from)
    }

    /// Anywhere on it.
    fn point(&self, u: Vec2) -> AreaPoint {
        let z = 1.0 - 2.0 * f64::from(u.x);
        let rho = ((1.0 - z) * (1.0 + z)).sqrt();
        let (sin, cos) = (TAU * f64::from(u.y)).sin_cos();
        let outward = DVec3::new(rho * cos, rho * sin, z);
        AreaPoint {
            p: self.center + outward * self.radius,
            error: self.error(),
            n: self.normal(outward),
            area: self.area(),
        }
    }

    /// A point drawn evenly, with density `pdf`, from the directions of `cone`.
    ///
    /// An even point of the unit disk, at radius r, gives the direction at an angle θ from the axis with
    /// 1 − cos θ = r² (1 − cos θmax). It meets the sphere where sin β = sin θ / sin θmax is the sine of incidence,
    /// and the center sees that point at angle α = β − θ (Pharr, Jakob and Humphreys 2023, §6.2.4). All sines are
    /// kept divided by r, so that nothing needs r itself or any angle.
    #[inline(always)]
    fn sample_in(&self, cone: &Cone, pdf: f32, u: Vec2) -> EmitterSample {
        let on_square = concentric_disk(u).as_dvec2();
        let r2 = on_square.length_squared();
        // Off the disk's edge by rounding.
        let off = r2 > 1.0;
        let disk = if off {
            on_square / r2.sqrt()
        } else {
            on_square
        };
        let r2 = if off { 1.0 } else { r2 };
        let cos = 1.0 - r2 * cone.one_minus_cos_max;
        let sin_over_r = (cone.one_minus_cos_max * (1.0 + cos)).sqrt();
        let sin_beta_over_r = sin_over_r / cone.sin_max;
        let cos_beta = (1.0 - r2 * sin_beta_over_r * sin_beta_over_r)
            .max(0.0)
            .sqrt();
        let cos_alpha = cos * cos_beta + r2 * sin_over_r * sin_beta_over_r;
        let sin_alpha_over_r = sin_beta_over_r * cos - cos_beta * sin_over_r;
        let (x, y) = cone.axis.any_orthonormal_pair();
        let across = x * disk.x + y * disk.y;
        let outward = across * sin_alpha_over_r - cone.axis * cos_alpha;
        let p = (self.center + outward * self.radius).as_vec3();
        EmitterSample {
            p,
            p_error: rounded_box(self.error(), p),
            n: self.normal(outward).as_vec3(),
            wi: (across * sin_over_r + cone.axis * cos).as_vec3(),
            pdf,
        }
    }
}

/// A ball that is seen from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarBall(Ball);

impl BranchlessEmitter for FarBall {
    #[inline(always)]
    fn sample(&self, from: &ReferencePoint, u: Vec2) -> (EmitterSample, bool) {
        let toward = self.0.center - from.p.as_dvec3();
        let cone = self.0.cone_toward(toward, toward.length_squared());
        let pdf = cone.density() as f32;
        (self.0.sample_in(&cone, pdf, u), is_density(pdf))
    }
}

/// See [`Emitter::Quadric`].
#[derive(Clone, Copy, Debug)]
pub struct QuadricEmitter {
    quadric: Quadric,
    /// Area in object space times the change of volumes from there to render space.
    volume_area: f64,
    /// Area in render space.
    area: f64,
    /// Half-widths of the boxes that hold the exact points.
    error: DVec3,
}

impl QuadricEmitter {
    /// The render-space area that points are spread over as densely as around one with the unit normal `n`
    /// (render space, either side). With M the matrix, the object-space normal is Mᵀn/|Mᵀn|, so the piece of
    /// surface is |det M| / |Mᵀn| times larger than in object space ([`Quadric::area_scale`]).
    fn area_around(&self, n: DVec3) -> f64 {
        let m = DMat3::from_mat4(self.quadric.level_from_object.m);
        self.volume_area / (m.transpose() * n).length()
    }

    #[inline]
    fn point(&self, u: Vec2) -> AreaPoint {
        let p = self.quadric.form.sample(u.as_dvec2());
        let (p, n) = self.quadric.point_and_normal(p);
        AreaPoint {
            p,
            error: self.error,
            n,
            area: self.area_around(n),
        }
    }
}

#[cfg(test)]
mod tests;
