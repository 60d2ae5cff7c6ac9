//! Two-dimensional texture mappings (Pharr, Jakob and Humphreys 2016, §10.2; quirks as
//! docs/scene-language.md §3.9 lists them).

use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::TexturePoint;
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

/// A mapping as the scene file says it, in world space.
#[derive(Clone, Copy, Debug)]
pub enum MappingSpec {
    /// Scaled and shifted surface parameters.
    Uv {
        /// `uscale`, `vscale` (1).
        scale: Vec2,
        /// `udelta`, `vdelta` (0).
        delta: Vec2,
    },
    /// s is the angle from the texture's z axis over π, t the azimuth over 2π.
    Spherical {
        /// The CTM of the `Texture` directive.
        world_from_texture: Transform,
    },
    /// s is the azimuth over 2π, with ½ at +x; t is z of the point *brought to unit length* (a
    /// quirk of pbrt).
    Cylindrical {
        /// The CTM of the `Texture` directive.
        world_from_texture: Transform,
    },
    /// Projections on two vectors, in *world* space whatever the CTM (a quirk of pbrt).
    Planar {
        /// `v1` (1, 0, 0): s for a unit step along it.
        v1: DVec3,
        /// `v2` (0, 1, 0).
        v2: DVec3,
        /// `udelta`, `vdelta` (0).
        delta: [f64; 2],
    },
}

impl MappingSpec {
    /// Reads `mapping` (`uv`) and its parameters.
    pub fn from_params(reader: &ParamReader, ctm: &Transform) -> MappingSpec {
        match reader.one_of("mapping", &["uv", "spherical", "cylindrical", "planar"]) {
            "spherical" => MappingSpec::Spherical {
                world_from_texture: *ctm,
            },
            "cylindrical" => MappingSpec::Cylindrical {
                world_from_texture: *ctm,
            },
            "planar" => MappingSpec::Planar {
                v1: reader.vector3("v1", DVec3::X),
                v2: reader.vector3("v2", DVec3::Y),
                delta: [reader.float("udelta", 0.0), reader.float("vdelta", 0.0)],
            },
            _ => MappingSpec::Uv {
                scale: Vec2::new(
                    reader.float("uscale", 1.0) as f32,
                    reader.float("vscale", 1.0) as f32,
                ),
                delta: Vec2::new(
                    reader.float("udelta", 0.0) as f32,
                    reader.float("vdelta", 0.0) as f32,
                ),
            },
        }
    }

    /// For points in render space.
    pub fn compile(&self, render_from_world: &Transform) -> Mapping {
        let from_render = |t: &Transform| PointMap::new(&t.inverse).from_render(render_from_world);
        match *self {
            MappingSpec::Uv { scale, delta } => Mapping::Uv { scale, delta },
            MappingSpec::Spherical { world_from_texture } => {
                Mapping::Spherical(from_render(&world_from_texture))
            }
            MappingSpec::Cylindrical { world_from_texture } => {
                Mapping::Cylindrical(from_render(&world_from_texture))
            }
            MappingSpec::Planar { v1, v2, delta } => {
                // s = v1·world + δ = v1·(M render + o) + δ, with M and o those of world-from-render.
                let world_from_render = render_from_world.inverted();
                let transposed = |v: DVec3| {
                    let m = world_from_render.m;
                    DVec3::new(
                        m.x_axis.truncate().dot(v),
                        m.y_axis.truncate().dot(v),
                        m.z_axis.truncate().dot(v),
                    )
                };
                let origin = world_from_render.point(DVec3::ZERO);
                Mapping::Planar {
                    v1: transposed(v1).as_vec3(),
                    v2: transposed(v2).as_vec3(),
                    delta: Vec2::new(
                        (v1.dot(origin) + delta[0]) as f32,
                        (v2.dot(origin) + delta[1]) as f32,
                    ),
                }
            }
        }
    }
}

/// A mapping from points in render space.
#[derive(Clone, Copy, Debug)]
pub enum Mapping {
    /// See [`MappingSpec::Uv`].
    Uv {
        /// Factors of u and v.
        scale: Vec2,
        /// Added afterwards.
        delta: Vec2,
    },
    /// See [`MappingSpec::Spherical`].
    Spherical(PointMap),
    /// See [`MappingSpec::Cylindrical`].
    Cylindrical(PointMap),
    /// See [`MappingSpec::Planar`].
    Planar {
        /// s for a unit step along it.
        v1: Vec3,
        /// t for a unit step along it.
        v2: Vec3,
        /// (s, t) of the render-space origin.
        delta: Vec2,
    },
}

impl Mapping {
    /// (s, t) of a point.
    pub fn position(&self, at: &TexturePoint) -> Vec2 {
        match self {
            Mapping::Uv { scale, delta } => *scale * at.uv + *delta,
            Mapping::Spherical(map) => spherical(map.point(at.p)),
            Mapping::Cylindrical(map) => cylindrical(map.point(at.p)),
            Mapping::Planar { v1, v2, delta } => Vec2::new(at.p.dot(*v1), at.p.dot(*v2)) + *delta,
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
        let (dstdx, dstdy) = match self {
            Mapping::Uv { scale, .. } => (*scale * f.duvdx, *scale * f.duvdy),
            Mapping::Spherical(m) => {
                let d = |dp| difference(spherical, m, dp, 0.1, Vec2::Y);
                (d(f.dpdx), d(f.dpdy))
            }
            Mapping::Cylindrical(m) => {
                let d = |dp| difference(cylindrical, m, dp, 0.01, Vec2::X);
                (d(f.dpdx), d(f.dpdy))
            }
            Mapping::Planar { v1, v2, .. } => (
                Vec2::new(f.dpdx.dot(*v1), f.dpdx.dot(*v2)),
                Vec2::new(f.dpdy.dot(*v1), f.dpdy.dot(*v2)),
            ),
        };
        TextureCoordinates { st, dstdx, dstdy }
    }
}

/// (polar angle / π, azimuth / 2π in [0, 1)) of a point about the origin; (0, 0) at the origin.
fn spherical(p: Vec3) -> Vec2 {
    let q = p.normalize_or_zero();
    let azimuth = q.y.atan2(q.x);
    Vec2::new(
        q.z.clamp(-1.0, 1.0).acos() / PI,
        if azimuth < 0.0 {
            azimuth + TAU
        } else {
            azimuth
        } / TAU,
    )
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

    /// This map of world-space points for points in render space.
    pub fn from_render(&self, render_from_world: &Transform) -> PointMap {
        PointMap::new(&(self.exact * render_from_world.inverse))
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
        let mapping = MappingSpec::Uv {
            scale,
            delta: Vec2::new(10.0, 20.0),
        }
        .compile(&Transform::IDENTITY);
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
        let m = MappingSpec::Spherical {
            world_from_texture: Transform::translate(DVec3::X),
        };
        let m = m.compile(&Transform::IDENTITY);
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
        let m = MappingSpec::Cylindrical {
            world_from_texture: Transform::IDENTITY,
        }
        .compile(&Transform::IDENTITY);
        let st = |p: Vec3| m.position(&at(p, Footprint::default()));
        close(st(Vec3::X), Vec2::new(0.5, 0.0), 1e-6);
        close(st(-Vec3::Y), Vec2::new(0.25, 0.0), 1e-6);
        close(st(Vec3::new(3.0, 0.0, 4.0)), Vec2::new(0.5, 0.8), 1e-6);
    }

    #[test]
    fn planar_ignores_the_ctm_and_survives_the_move_to_render_space() {
        let spec = MappingSpec::Planar {
            v1: DVec3::new(2.0, 0.0, 0.0),
            v2: DVec3::Z,
            delta: [0.5, 0.0],
        };
        let camera = DVec3::new(100.0, -50.0, 30.0);
        let m = spec.compile(&Transform::translate(-camera));
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
        for spec in [
            MappingSpec::Spherical {
                world_from_texture: ctm,
            },
            MappingSpec::Cylindrical {
                world_from_texture: ctm,
            },
            MappingSpec::Planar {
                v1: DVec3::ONE,
                v2: DVec3::Y,
                delta: [0.1, 0.2],
            },
        ] {
            let world = spec.compile(&Transform::IDENTITY);
            let render = spec.compile(&Transform::translate(-camera));
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
        for (spec, seam, pick) in [
            (
                MappingSpec::Spherical {
                    world_from_texture: Transform::IDENTITY,
                },
                Vec3::X,
                Vec2::Y,
            ),
            (
                MappingSpec::Cylindrical {
                    world_from_texture: Transform::IDENTITY,
                },
                -Vec3::X,
                Vec2::X,
            ),
        ] {
            let m = spec.compile(&Transform::IDENTITY);
            let c = m.coordinates(&at(seam - Vec3::Y * 1e-4 * seam.x, footprint));
            // A step of 0.02 along the unit circle is 0.02/2π of a turn.
            assert!(
                (c.dstdx.dot(pick).abs() - 0.02 / TAU).abs() < 1e-4,
                "{spec:?}: {}",
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
