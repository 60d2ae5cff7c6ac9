//! Quadrics in place: sphere, disk, cone, cylinder, paraboloid and hyperboloid under any affine
//! transformation.
//!
//! A ray is taken to object space in double precision and solved there; the point found is put
//! back onto the surface, so that its error is a few units of double rounding whatever the
//! distance it was seen from. What single precision then loses is the rounding of the result.

use super::Form;
use super::ball::Ball;
use super::local::{LocalPoint, LocalSurface};
use super::sphere::Sphere;
use crate::math::angle::turns;
use crate::math::transform::{Transform, box_around, box_corners};
use crate::math::{DVec2, DVec3, Vec2};
use glam::DMat3;
use std::f64::consts::TAU;

/// Double-precision roundings on the way from object space to a surface point and back, with
/// room to spare: no chain here is longer than a dozen operations.
pub(super) const ROUNDINGS: f64 = 32.0;

/// A point of a surface in object space.
#[derive(Clone, Copy, Debug)]
pub struct ObjectPoint {
    /// Surface parameters.
    pub uv: DVec2,
    /// Unit normal along ∂p/∂u × ∂p/∂v.
    pub n: DVec3,
    /// ∂p/∂u.
    pub dpdu: DVec3,
    /// ∂p/∂v.
    pub dpdv: DVec3,
    /// ∂n/∂u.
    pub dndu: DVec3,
    /// ∂n/∂v.
    pub dndv: DVec3,
}

/// What is shaded with instead of the surface's own frame.
#[derive(Clone, Copy, Debug)]
pub struct ShadingFrame {
    /// Unit normal.
    pub n: DVec3,
    /// ∂p/∂v; ∂p/∂u is the surface's own.
    pub dpdv: DVec3,
}

/// What every quadric knows in its own space.
pub trait ObjectSurface {
    /// The nearest point with t > 0 on the ray `o + t d` (`d` of any length): t, and the point
    /// moved onto the surface.
    fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)>;
    /// That t alone.
    fn distance(&self, o: DVec3, d: DVec3) -> Option<f64> {
        self.intersect(o, d).map(|(t, _)| t)
    }
    /// Parameters and derivatives at a point of the surface.
    fn at(&self, p: DVec3) -> ObjectPoint;
    /// The unit normal there, alone.
    fn normal(&self, p: DVec3) -> DVec3 {
        self.at(p).n
    }
    /// The parameters of a point next to the surface, alone, for layers: with an absolute error below 2e-6, for a call of `atan2` and one of `acos` take
    /// longer than all else.
    fn approximate_uv(&self, p: DVec3) -> Vec2 {
        self.at(p).uv.as_vec2()
    }

    /// Corners of a box around the surface.
    fn bounds(&self) -> (DVec3, DVec3);
    /// A point uniform over the surface's area.
    fn sample(&self, u: DVec2) -> DVec3;
    /// Surface area.
    fn area(&self) -> f64;
    /// What is shaded with at a point of the surface, where that is not the surface itself.
    fn shading(&self, _p: DVec3) -> Option<ShadingFrame> {
        None
    }
}

/// A quadric with its place and orientation.
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    /// The surface in object space.
    pub form: Form,
    /// Object space to the space of the tree it is in (render space for the top level).
    pub level_from_object: Transform,
    /// Normals are turned: ReverseOrientation XOR a mirroring transformation (docs/scene-language.md §4.4).
    pub flip: bool,
    /// The same as a ball, if it is one.
    ball: Option<Ball>,
}

impl Quadric {
    /// Places `form`.
    pub fn new(form: Form, level_from_object: Transform, reverse_orientation: bool) -> Quadric {
        let level_from_object = level_from_object.with_translations_matched();
        let flip = reverse_orientation ^ level_from_object.swaps_handedness();
        Quadric {
            form,
            flip,
            level_from_object,
            ball: Ball::new(&form, &level_from_object, flip),
        }
    }

    /// The same quadric seen from the point `anchor`.
    pub fn relative_to(mut self, anchor: DVec3) -> Quadric {
        self.level_from_object =
            (Transform::translate(-anchor) * self.level_from_object).with_translations_matched();
        self.ball = Ball::new(&self.form, &self.level_from_object, self.flip);
        self
    }

    /// The same as a ball, if it is one.
    pub fn ball(&self) -> Option<&Ball> {
        self.ball.as_ref()
    }

    /// Distance to the nearest point along the ray, in units of `d`'s length.
    #[inline]
    pub fn distance(&self, o: DVec3, d: DVec3) -> Option<f64> {
        match &self.ball {
            Some(ball) => ball.distance(o, d),
            None => {
                let (o, d) = self.object_ray(o, d);
                self.form.distance(o, d)
            }
        }
    }

    /// Returns `true` if the ray is known at little cost to meet it nowhere before `t_max`.
    #[inline]
    pub(crate) fn is_beyond(&self, o: DVec3, d: DVec3, t_max: f64) -> bool {
        let ball = self.ball.as_ref();
        ball.is_some_and(|ball| ball.is_beyond(o, d, t_max))
    }

    /// That point, in object space.
    pub fn object_point(&self, o: DVec3, d: DVec3) -> Option<DVec3> {
        let (Some(ball), Form::Sphere(sphere)) = (&self.ball, &self.form) else {
            return self.intersect(o, d).map(|(_, p)| p);
        };
        Some(self.on_sphere(sphere, ball.meet(o, d)?.p))
    }

    /// `p`, a point of the ball that is this sphere in place, in object space.
    fn on_sphere(&self, sphere: &Sphere, p: DVec3) -> DVec3 {
        let p = self.level_from_object.inverse.transform_point3(p);
        p.normalize_or(DVec3::Z) * sphere.radius
    }

    /// That point, with its normals.
    pub fn local_point(&self, o: DVec3, d: DVec3) -> Option<LocalPoint> {
        match &self.ball {
            Some(ball) => ball.meet(o, d),
            None => Some(self.point_of(self.intersect(o, d)?.1)),
        }
    }

    /// That point, with its normals, and its [parameters](ObjectSurface::approximate_uv).
    pub fn parametric_point(&self, o: DVec3, d: DVec3) -> Option<(LocalPoint, Vec2)> {
        let (point, p) = match &self.ball {
            Some(ball) => {
                let point = ball.meet(o, d)?;
                (
                    point,
                    self.level_from_object.inverse.transform_point3(point.p),
                )
            }
            None => {
                let (_, p) = self.intersect(o, d)?;
                (self.point_of(p), p)
            }
        };
        Some((point, self.form.approximate_uv(p)))
    }

    /// `p`, a point of it in object space, with its normals.
    fn point_of(&self, p: DVec3) -> LocalPoint {
        let (at, n) = self.point_and_normal(p);
        let side = if self.flip { -1.0 } else { 1.0 };
        let shading_n = self.form.shading(p).map_or(n, |frame| {
            self.level_from_object.normal(frame.n).normalize() * side
        });
        LocalPoint {
            p: at,
            p_error: self.position_error(p),
            n,
            shading_n,
        }
    }

    /// Distance to the nearest point along the ray, in units of `d`'s length, and that point in
    /// object space.
    pub fn intersect(&self, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
        let (o, d) = self.object_ray(o, d);
        self.form.intersect(o, d)
    }

    /// Origin and direction of a ray in object space.
    #[inline(always)]
    fn object_ray(&self, o: DVec3, d: DVec3) -> (DVec3, DVec3) {
        let inverse = &self.level_from_object.inverse;
        (inverse.transform_point3(o), inverse.transform_vector3(d))
    }

    /// The surface at `p`, a point of it in object space.
    pub fn surface(&self, p: DVec3) -> LocalSurface {
        let at = self.form.at(p);
        let m = &self.level_from_object.m;
        let point = self.point_of(p);
        let side = if self.flip { -1.0 } else { 1.0 };
        let scale = side / self.level_from_object.normal(at.n).length();
        // The derivative of a normalized vector is perpendicular to it.
        let change = |dn: DVec3| {
            let dn = self.level_from_object.normal(dn) * scale;
            dn - point.n * point.n.dot(dn)
        };
        let dpdu = m.transform_vector3(at.dpdu);
        let dpdv = m.transform_vector3(at.dpdv);
        let shading = self.form.shading(p);
        LocalSurface {
            point,
            uv: at.uv.as_vec2(),
            dpdu,
            dpdv,
            shading_dpdu: dpdu,
            shading_dpdv: shading.map_or(dpdv, |frame| m.transform_vector3(frame.dpdv)),
            dndu: change(at.dndu),
            dndv: change(at.dndv),
            face: 0,
        }
    }

    /// The point and the unit normal of [`Quadric::surface`], alone.
    pub fn point_and_normal(&self, p: DVec3) -> (DVec3, DVec3) {
        let normal = self.level_from_object.normal(self.form.normal(p));
        let side = if self.flip { -1.0 } else { 1.0 };
        let point = self.level_from_object.m.transform_point3(p);
        (point, normal / normal.length() * side)
    }

    /// Corners of the box around the surface in object space.
    fn corners(&self) -> [DVec3; 8] {
        let (low, high) = self.form.bounds();
        box_corners(low, high)
    }

    /// No [`Quadric::position_error`] of its points is larger: that is convex, so it is largest at a corner.
    pub(super) fn largest_position_error(&self) -> DVec3 {
        let errors = self.corners().map(|corner| self.position_error(corner));
        errors.into_iter().fold(DVec3::ZERO, DVec3::max)
    }

    /// Bound on what double precision loses when `p` (object space) is moved to level space and a
    /// ray that starts there is moved back: the largest product's magnitude times the roundings.
    /// The largest over all axes: a rotation's entries and a sum of translations may come out
    /// next to nothing (the sine of 180°), and are then as wrong as what they were made from.
    pub(super) fn position_error(&self, p: DVec3) -> DVec3 {
        let Transform { m, inverse } = &self.level_from_object;
        let [abs_m, abs_inverse] = [m, inverse].map(|m| DMat3::from_mat4(*m).abs());
        let level = m.transform_point3(p);
        let back = abs_inverse * level.abs() + inverse.w_axis.truncate().abs();
        let magnitude = abs_m * (p.abs() + back) + m.w_axis.truncate().abs();
        DVec3::splat(magnitude.max_element() * (ROUNDINGS * f64::EPSILON))
    }

    /// Corners of a box around the surface, level space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        box_around(self.corners().into_iter().flat_map(|corner| {
            let error = self.position_error(corner);
            let corner = self.level_from_object.m.transform_point3(corner);
            [corner - error, corner + error]
        }))
    }

    /// How much larger a volume is in level space.
    pub(super) fn volume_scale(&self) -> f64 {
        DMat3::from_mat4(self.level_from_object.m)
            .determinant()
            .abs()
    }

    /// How much larger a small piece of surface with unit object-space normal `n` is in level
    /// space: |M a × M b| / |a × b| for any a, b that span it, which is |det M| |M⁻ᵀ n|.
    pub fn area_scale(&self, n: DVec3) -> f64 {
        self.volume_scale() * self.level_from_object.normal(n).length()
    }

    /// Surface area in level space.
    pub fn area(&self) -> f64 {
        // Midpoint rule over the uniform sampling; the integrand is constant for disks and under
        // similarity transformations, else smooth: 64 × 64 points leave an error below 1e-3 of
        // the area up to axis ratios of 100. The area only weighs lights against each other.
        const GRID: usize = 64;
        let mut sum = 0.0;
        for i in 0..GRID * GRID {
            let u = DVec2::new((i % GRID) as f64 + 0.5, (i / GRID) as f64 + 0.5) / GRID as f64;
            sum += self.area_scale(self.form.at(self.form.sample(u)).n);
        }
        self.form.area() * sum / (GRID * GRID) as f64
    }
}

/// The part that a shape has of a surface of revolution about the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swept {
    /// Lower end, object units.
    pub z_min: f64,
    /// Upper end.
    pub z_max: f64,
    /// Angle swept from +x toward +y, radians.
    pub phi_max: f64,
}

impl Swept {
    /// The part between two heights, in either order, that is swept by `degrees`, clamped to a full turn.
    pub(super) fn new(z0: f64, z1: f64, degrees: f64) -> Swept {
        Swept {
            z_min: z0.min(z1),
            z_max: z0.max(z1),
            phi_max: degrees.clamp(0.0, 360.0).to_radians(),
        }
    }

    pub(super) fn height(&self) -> f64 {
        self.z_max - self.z_min
    }

    /// The point of the axis at half height.
    pub(super) fn center(&self) -> DVec3 {
        DVec3::new(0.0, 0.0, 0.5 * (self.z_min + self.z_max))
    }

    /// Returns `true` if a point of the whole surface of revolution is in this part.
    pub(super) fn contains(&self, p: DVec3) -> bool {
        p.z >= self.z_min && p.z <= self.z_max && self.sweeps(|| azimuth(p))
    }

    /// Returns `true` if a ray from the height `z` that rises by `dz` never comes to this part.
    #[inline(always)]
    pub(super) fn is_left_by(&self, z: f64, dz: f64) -> bool {
        (z > self.z_max && dz >= 0.0) || (z < self.z_min && dz <= 0.0)
    }

    /// Returns `true` if `angle`, in [0, 2π), is within the sweep; it is computed only for partial sweeps.
    pub(super) fn sweeps(&self, angle: impl FnOnce() -> f64) -> bool {
        self.phi_max >= TAU || angle() <= self.phi_max
    }

    /// The fraction of the angle at `p`, and that of the height.
    pub(super) fn uv(&self, p: DVec3) -> DVec2 {
        DVec2::new(
            azimuth(p) / self.phi_max,
            (p.z - self.z_min) / self.height(),
        )
    }

    /// The same for [`ObjectSurface::approximate_uv`].
    pub(super) fn approximate_uv(&self, p: DVec3) -> Vec2 {
        // Not too large or small for single precision.
        let scale = 1.0 / p.x.abs().max(p.y.abs());
        let [x, y] = [p.x, p.y].map(|x| if scale.is_finite() { x * scale } else { 0.0 });
        let u = turns(x as f32, y as f32) * (TAU / self.phi_max) as f32;
        let v = (p.z - self.z_min) / self.height();
        Vec2::new(u, v as f32)
    }

    /// ∂p/∂u where u is the fraction of the angle.
    pub(super) fn dpdu(&self, p: DVec3) -> DVec3 {
        self.phi_max * DVec3::new(-p.y, p.x, 0.0)
    }

    /// The point at the distance `rho` from the axis, the fraction `u` of the angle and the height `z`.
    pub(super) fn point(&self, rho: f64, u: f64, z: f64) -> DVec3 {
        let (sin, cos) = (u * self.phi_max).sin_cos();
        DVec3::new(rho * cos, rho * sin, z)
    }

    /// Corners of the box around the part, whose points are at most `rho` away from the axis.
    pub(super) fn bounds(&self, rho: f64) -> (DVec3, DVec3) {
        let low = DVec3::new(-rho, -rho, self.z_min);
        (low, DVec3::new(rho, rho, self.z_max))
    }
}

/// The angle of (x, y) from +x toward +y, in [0, 2π).
pub(super) fn azimuth(p: DVec3) -> f64 {
    full_turn(p.y.atan2(p.x))
}

/// An angle from −π to π as one in [0, 2π).
pub(super) fn full_turn(phi: f64) -> f64 {
    if phi < 0.0 { phi + TAU } else { phi }
}

/// Distance from the axis, and the unit direction away from it; any on the axis.
pub(super) fn outward(p: DVec3) -> (f64, DVec2) {
    let rho = p.x.hypot(p.y);
    let direction = if rho > 0.0 {
        p.truncate() / rho
    } else {
        DVec2::X
    };
    (rho, direction)
}

/// Real roots of a t² + 2 b t + c, ascending, without cancellation between them
/// (Higham 2002, §1.8). `discriminant` is b² − a c, computed as precisely as the caller can.
/// Where a = 0 both are the root of the linear equation.
pub(super) fn roots(a: f64, b: f64, c: f64, discriminant: f64) -> Option<[f64; 2]> {
    if discriminant.is_nan() || discriminant < 0.0 {
        return None;
    }
    if a == 0.0 {
        let t = c / larger_term(b, discriminant);
        return t.is_finite().then_some([t, t]);
    }
    Some(roots_if_any(a, b, c, discriminant))
}

/// The same without a branch, for rays side by side, where a is not 0: NaN if there are none.
#[inline(always)]
pub(super) fn roots_if_any(a: f64, b: f64, c: f64, discriminant: f64) -> [f64; 2] {
    let q = larger_term(b, discriminant);
    // q = 0 means b = 0 and discriminant = 0: a double root at 0.
    let (s, t) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    if s < t { [s, t] } else { [t, s] }
}

/// −b ± √discriminant with the sign that does not cancel.
#[inline(always)]
fn larger_term(b: f64, discriminant: f64) -> f64 {
    -(b + discriminant.sqrt().copysign(b))
}

/// Where the line `o + t d` is nearest to `center`: t, and the point. Seen from there the
/// coefficients of a quadric are of its own size, however far away the ray begins, and what
/// cancels in them is no more than double precision has (Haines et al., Ray Tracing Gems 2019, ch. 7).
pub(super) fn nearest_approach(o: DVec3, d: DVec3, center: DVec3) -> (f64, DVec3) {
    let t = (center - o).dot(d) / d.length_squared();
    (t, o + d * t)
}

#[cfg(test)]
pub(super) mod tests;
