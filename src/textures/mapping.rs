//! Two-dimensional texture mappings (Pharr, Jakob and Humphreys 2016, §10.2; quirks as
//! docs/scene-language.md §3.9 lists them).

use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::TexturePoint;
use glam::{DVec2, DVec4};
use std::f32::consts::{PI, TAU};

/// A point in texture space with its change from one film sample to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureCoordinates {
    /// (s, t).
    pub st: Vec2,
    /// ∂(s,t)/∂x.
    pub dstdx: Vec2,
    /// ∂(s,t)/∂y.
    pub dstdy: Vec2,
}

/// From points to (s, t): points in world space, or, once it is placed, in render space.
#[derive(Clone, Copy, Debug)]
pub enum Mapping {
    /// Scaled and shifted surface parameters.
    Uv {
        /// `uscale`, `vscale` (1).
        scale: Vec2,
        /// `udelta`, `vdelta` (0).
        delta: Vec2,
    },
    /// s is the angle from the z axis of the texture's space over π, t the azimuth over 2π.
    Spherical(PointMap),
    /// s is the azimuth over 2π, with ½ at +x; t is z of the point *brought to unit length* (a
    /// quirk of pbrt).
    Cylindrical(PointMap),
    /// s is x and t is y of the point, mapped.
    Planar(PointMap),
}

impl Mapping {
    /// Reads `mapping` (`uv`) and its parameters. The texture's space is that of the CTM.
    pub fn from_params(reader: &ParamReader, ctm: &Transform) -> Mapping {
        let pair = |names: [&str; 2], default| names.map(|name| reader.float(name, default));
        let single = |names, default| DVec2::from_array(pair(names, default)).as_vec2();
        match reader.one_of("mapping", &["uv", "spherical", "cylindrical", "planar"]) {
            "spherical" => Mapping::Spherical(PointMap::new(&ctm.inverse)),
            "cylindrical" => Mapping::Cylindrical(PointMap::new(&ctm.inverse)),
            "planar" => Mapping::planar(
                reader.vector3("v1", DVec3::X),
                reader.vector3("v2", DVec3::Y),
                pair(["udelta", "vdelta"], 0.0),
            ),
            _ => Mapping::Uv {
                scale: single(["uscale", "vscale"], 1.0),
                delta: single(["udelta", "vdelta"], 0.0),
            },
        }
    }

    /// Projections on two vectors, shifted, in *world* space whatever the CTM (a quirk of pbrt).
    fn planar(v1: DVec3, v2: DVec3, delta: [f64; 2]) -> Mapping {
        let rows = DMat4::from_cols(
            v1.extend(delta[0]),
            v2.extend(delta[1]),
            DVec4::ZERO,
            DVec4::W,
        );
        Mapping::Planar(PointMap::new(&rows.transpose()))
    }

    /// Makes this mapping of world-space points one of points in render space.
    pub fn place(&mut self, render_from_world: &Transform) {
        match self {
            Mapping::Uv { .. } => {}
            Mapping::Spherical(map) | Mapping::Cylindrical(map) | Mapping::Planar(map) => {
                map.place(render_from_world);
            }
        }
    }

    /// (s, t) of a point.
    pub fn position(&self, at: &TexturePoint) -> Vec2 {
        match self {
            Mapping::Uv { scale, delta } => *scale * at.uv + *delta,
            Mapping::Spherical(map) => spherical(map.point(at.p)),
            Mapping::Cylindrical(map) => cylindrical(map.point(at.p)),
            Mapping::Planar(map) => map.point(at.p).truncate(),
        }
    }

    /// (s, t) of a point with their differentials.
    pub fn coordinates(&self, at: &TexturePoint) -> TextureCoordinates {
        let st = self.position(at);
        let f = &at.footprint;
        // One-sided differences a fraction of the footprint away, as pbrt's book takes them: wide
        // enough for single precision, near enough to be a derivative.
        let difference = |map: fn(Vec3) -> Vec2, m: &PointMap, dp: Vec3, step: f32, wraps: Vec2| {
            let change = map(m.point(at.p + step * dp)) - st;
            // Across the seam an azimuth jumps by 1: the short way round is meant.
            (change - wraps * change.round()) / step
        };
        let [dstdx, dstdy] = match self {
            Mapping::Uv { scale, .. } => [f.duvdx, f.duvdy].map(|duv| *scale * duv),
            Mapping::Spherical(m) => {
                [f.dpdx, f.dpdy].map(|dp| difference(spherical, m, dp, 0.1, Vec2::Y))
            }
            Mapping::Cylindrical(m) => {
                [f.dpdx, f.dpdy].map(|dp| difference(cylindrical, m, dp, 0.01, Vec2::X))
            }
            Mapping::Planar(m) => [f.dpdx, f.dpdy].map(|dp| m.vector(dp).truncate()),
        };
        TextureCoordinates { st, dstdx, dstdy }
    }
}

/// (polar angle / π, azimuth / 2π in [0, 1)) of a point about the origin; (0, 0) at the origin.
fn spherical(p: Vec3) -> Vec2 {
    let q = p.normalize_or_zero();
    let azimuth = q.y.atan2(q.x);
    let turned = if azimuth < 0.0 { TAU } else { 0.0 };
    Vec2::new(q.z.clamp(-1.0, 1.0).acos() / PI, (azimuth + turned) / TAU)
}

/// (½ + azimuth / 2π, z of the point at unit length).
fn cylindrical(p: Vec3) -> Vec2 {
    let q = p.normalize_or_zero();
    Vec2::new((PI + q.y.atan2(q.x)) / TAU, q.z)
}

/// A 4×4 matrix applied to points in single precision, composed in double.
#[derive(Clone, Copy, Debug)]
pub struct PointMap {
    exact: DMat4,
    /// Columns' x y z, and the row that makes w.
    columns: [Vec3; 4],
    w: [f32; 4],
    projective: bool,
}

impl PointMap {
    /// From a matrix of column vectors.
    pub fn new(m: &DMat4) -> PointMap {
        let columns = [m.x_axis, m.y_axis, m.z_axis, m.w_axis].map(|c| c.truncate().as_vec3());
        let w = [m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w];
        PointMap {
            exact: *m,
            columns,
            w: w.map(|w| w as f32),
            projective: w != [0.0, 0.0, 0.0, 1.0],
        }
    }

    /// Makes this map of world-space points one of points in render space.
    pub fn place(&mut self, render_from_world: &Transform) {
        *self = PointMap::new(&(self.exact * render_from_world.inverse));
    }

    /// Where `p` goes, divided by w where that is not 1.
    pub fn point(&self, p: Vec3) -> Vec3 {
        let [x, y, z, o] = self.columns;
        let q = x * p.x + y * p.y + z * p.z + o;
        if self.projective {
            let [wx, wy, wz, wo] = self.w;
            q / (wx * p.x + wy * p.y + wz * p.z + wo)
        } else {
            q
        }
    }

    /// Where a small step `v` goes; no division, as for all vectors of the scene language.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        let [x, y, z, _] = self.columns;
        x * v.x + y * v.y + z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Footprint;

    fn at(p: Vec3, footprint: Footprint) -> TexturePoint {
        TexturePoint {
            p,
            uv: Vec2::new(0.25, 0.5),
            footprint,
            face: 0,
        }
    }

    fn close(a: Vec2, b: Vec2, tolerance: f32) {
        assert!((a - b).length() <= tolerance, "{a} against {b}");
    }

    #[test]
    fn uv_is_scaled_then_shifted() {
        let scale = Vec2::new(2.0, 3.0);
        let mapping = Mapping::Uv {
            scale,
            delta: Vec2::new(10.0, 20.0),
        };
        let footprint = Footprint {
            duvdx: Vec2::new(0.1, 0.0),
            duvdy: Vec2::new(0.0, 0.2),
            ..Footprint::default()
        };
        let c = mapping.coordinates(&at(Vec3::ZERO, footprint));
        assert_eq!(c.st, Vec2::new(10.5, 21.5));
        assert_eq!(
            (c.dstdx, c.dstdy),
            (Vec2::new(0.2, 0.0), scale * Vec2::new(0.0, 0.2))
        );
    }

    #[test]
    fn spherical_takes_latitude_first() {
        let m = Mapping::Spherical(PointMap::new(&Transform::translate(-DVec3::X).m));
        let st = |p: Vec3| m.position(&at(p + Vec3::X, Footprint::default()));
        // One rounding of an inverse trigonometric function.
        close(st(Vec3::Z), Vec2::new(0.0, 0.0), 1e-6);
        close(st(2.0 * Vec3::Y), Vec2::new(0.5, 0.25), 1e-6);
        close(st(-Vec3::Y), Vec2::new(0.5, 0.75), 1e-6);
        close(st(-Vec3::Z), Vec2::new(1.0, 0.0), 1e-6);
        assert_eq!(st(Vec3::ZERO), Vec2::new(0.5, 0.0));
    }

    #[test]
    fn cylindrical_takes_z_of_the_unit_vector() {
        let m = Mapping::Cylindrical(PointMap::new(&DMat4::IDENTITY));
        let st = |p: Vec3| m.position(&at(p, Footprint::default()));
        close(st(Vec3::X), Vec2::new(0.5, 0.0), 1e-6);
        close(st(-Vec3::Y), Vec2::new(0.25, 0.0), 1e-6);
        close(st(Vec3::new(3.0, 0.0, 4.0)), Vec2::new(0.5, 0.8), 1e-6);
    }

    #[test]
    fn planar_ignores_the_ctm_and_survives_the_move_to_render_space() {
        let mut m = Mapping::planar(DVec3::new(2.0, 0.0, 0.0), DVec3::Z, [0.5, 0.0]);
        let camera = DVec3::new(100.0, -50.0, 30.0);
        m.place(&Transform::translate(-camera));
        let world = DVec3::new(101.0, -49.0, 33.0);
        let c = m.coordinates(&at(
            (world - camera).as_vec3(),
            Footprint {
                dpdx: Vec3::X,
                ..Footprint::default()
            },
        ));
        assert_eq!(c.st, Vec2::new(202.5, 33.0));
        assert_eq!((c.dstdx, c.dstdy), (Vec2::new(2.0, 0.0), Vec2::ZERO));
    }

    #[test]
    fn render_space_changes_nothing() {
        let ctm = Transform::rotate(40.0, DVec3::new(1.0, 2.0, 0.5))
            * Transform::scale(DVec3::new(1.0, 2.0, 3.0));
        let camera = DVec3::new(3.0, 4.0, -5.0);
        let footprint = Footprint {
            dpdx: Vec3::X * 0.01,
            dpdy: Vec3::Y * 0.01,
            ..Footprint::default()
        };
        for world in [
            Mapping::Spherical(PointMap::new(&ctm.inverse)),
            Mapping::Cylindrical(PointMap::new(&ctm.inverse)),
            Mapping::planar(DVec3::ONE, DVec3::Y, [0.1, 0.2]),
        ] {
            let mut render = world;
            render.place(&Transform::translate(-camera));
            for p in [DVec3::new(1.0, 0.3, 0.2), DVec3::new(-2.0, 1.0, 5.0)] {
                let a = world.coordinates(&at(p.as_vec3(), footprint));
                let b = render.coordinates(&at((p - camera).as_vec3(), footprint));
                // Rounding of coordinates up to 10; differences divide it by the step's 1/100.
                close(a.st, b.st, 3e-6);
                close(a.dstdx, b.dstdx, 3e-4);
                close(a.dstdy, b.dstdy, 3e-4);
            }
        }
    }

    #[test]
    fn differentials_do_not_jump_at_the_seam() {
        let footprint = Footprint {
            dpdx: Vec3::Y * 0.02,
            ..Footprint::default()
        };
        let map = PointMap::new(&DMat4::IDENTITY);
        for (m, seam, pick) in [
            (Mapping::Spherical(map), Vec3::X, Vec2::Y),
            (Mapping::Cylindrical(map), -Vec3::X, Vec2::X),
        ] {
            let c = m.coordinates(&at(seam - Vec3::Y * 1e-4 * seam.x, footprint));
            // A step of 0.02 along the unit circle is 0.02/2π of a turn.
            assert!(
                (c.dstdx.dot(pick).abs() - 0.02 / TAU).abs() < 1e-4,
                "{m:?}: {}",
                c.dstdx
            );
        }
    }

    #[test]
    fn a_projective_matrix_divides_by_w() {
        let mut m = DMat4::IDENTITY;
        m.z_axis.w = 1.0;
        m.w_axis.w = 0.0;
        assert_eq!(
            PointMap::new(&m).point(Vec3::new(2.0, 4.0, 2.0)),
            Vec3::new(1.0, 2.0, 1.0)
        );
    }
}
