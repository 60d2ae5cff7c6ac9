//! Bump mapping (Blinn 1978; Pharr, Jakob and Humphreys 2016, §9.3; scene-language 4.6).

use crate::math::{Vec2, Vec3};
use crate::params::{FloatInput, ParamReader};
use crate::surface::{ShadingGeometry, SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// Step in u and v where the footprint is unknown, as in pbrt.
const DEFAULT_STEP: f32 = 0.0005;

/// A displacement along the shading normal, in scene units, that tilts the normal without moving
/// the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// The displacement.
    pub displacement: FloatInput,
}

impl Bump {
    /// Reads `bumpmap`; `None` where it is not given.
    pub fn from_params(reader: &ParamReader) -> Option<Bump> {
        reader
            .find_float_input("bumpmap")
            .map(|displacement| Bump { displacement })
    }

    /// The shading geometry of the displaced surface, its normal on the side of the geometric one.
    pub fn shading_geometry(
        &self,
        hit: &SurfaceHit,
        at: &TexturePoint,
        textures: &Textures,
    ) -> ShadingGeometry {
        let s = &hit.shading;
        let f = &at.footprint;
        let step = |x: f32, y: f32| {
            let mean = 0.5 * (x.abs() + y.abs());
            if mean > 0.0 { mean } else { DEFAULT_STEP }
        };
        let du = step(f.duvdx.x, f.duvdy.x);
        let dv = step(f.duvdx.y, f.duvdy.y);
        let displacement = |dp: Vec3, duv: Vec2| {
            textures.float(
                &self.displacement,
                &TexturePoint {
                    p: at.p + dp,
                    uv: at.uv + duv,
                    ..*at
                },
            )
        };
        let here = displacement(Vec3::ZERO, Vec2::ZERO);
        let along_u = displacement(du * s.dpdu, Vec2::new(du, 0.0));
        let along_v = displacement(dv * s.dpdv, Vec2::new(0.0, dv));
        let dpdu = s.dpdu + (along_u - here) / du * s.n + here * s.dndu;
        let dpdv = s.dpdv + (along_v - here) / dv * s.n + here * s.dndv;
        let Some(n) = dpdu.cross(dpdv).try_normalize() else {
            return *s;
        };
        ShadingGeometry {
            n: if n.dot(hit.n) < 0.0 { -n } else { n },
            dpdu,
            dpdv,
            ..*s
        }
    }
}
