//! Bump mapping (Blinn 1978; Pharr, Jakob and Humphreys 2016, §9.3; docs/scene-language.md §4.6).

use crate::inputs::FloatInput;
use crate::math::{Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::{ShadingGeometry, SurfaceHit, TexturePoint};
use crate::textures::Textures;

/// Step in u and v if the footprint is unknown, as in pbrt.
const DEFAULT_STEP: f32 = 0.0005;

/// A displacement along the shading normal, in scene units, that tilts the normal without moving
/// the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// The displacement.
    pub displacement: FloatInput,
}

impl Bump {
    /// Reads `bumpmap`; `None` if it is not given.
    pub fn from_params(reader: &ParamReader) -> Option<Bump> {
        reader
            .find_float_input("bumpmap")
            .map(|displacement| Bump { displacement })
    }

    /// The shading geometry of the displaced surface, with its normal on the side of the geometric one.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::flat_hit;
    use crate::handles::FloatTextureId;
    use crate::math::transform::Transform;
    use crate::surface::Footprint;
    use crate::textures::{Bilerp, Mapping, Texture, TextureSpecs, TextureUsage};

    /// Displacement 0.75 u − 0.5 v.
    fn slope() -> (Bump, Textures) {
        let mapping = Mapping::Uv {
            scale: Vec2::ONE,
            delta: Vec2::ZERO,
        };
        let bilerp = Texture::Bilerp(Bilerp {
            mapping,
            v00: 0.0,
            v01: -0.5,
            v10: 0.75,
            v11: 0.25,
        });
        let specs = TextureSpecs::of(&[bilerp], &[]);
        let (textures, _) = Textures::compile(
            &specs,
            &TextureUsage::new(&specs),
            &Transform::IDENTITY,
            &crate::budget::Budget::unlimited(),
        );
        (
            Bump {
                displacement: FloatInput::Texture(FloatTextureId(0)),
            },
            textures,
        )
    }

    #[test]
    fn a_linear_displacement_tilts_the_normal_by_its_slope() {
        let (bump, textures) = slope();
        let expected = Vec3::new(-0.75, 0.5, 1.0).normalize();
        for duv in [0.0, 0.01] {
            let footprint = Footprint {
                duvdx: Vec2::new(duv, 0.0),
                duvdy: Vec2::new(0.0, duv),
                ..Default::default()
            };
            let mut hit = flat_hit(Vec3::Z);
            let at = hit.texture_point(&footprint);
            let n = bump.shading_geometry(&hit, &at, &textures).n;
            // The default step of 0.0005 magnifies the displacement's rounding by 2000.
            assert!((n - expected).length() < 3e-4, "{n}");
            // With reversed orientation the tilted normal stays on the geometric normal's side.
            hit.n = -Vec3::Z;
            hit.shading.n = -Vec3::Z;
            let n = bump.shading_geometry(&hit, &at, &textures).n;
            assert!(
                (n - Vec3::new(-0.75, 0.5, -1.0).normalize()).length() < 3e-4,
                "{n}"
            );
        }
    }

    #[test]
    fn a_constant_displacement_changes_nothing_on_a_plane() {
        let hit = flat_hit(Vec3::Z);
        let at = hit.texture_point(&Footprint::default());
        let bump = Bump {
            displacement: FloatInput::Constant(3.0),
        };
        assert_eq!(
            bump.shading_geometry(&hit, &at, &Textures::default()).n,
            Vec3::Z
        );
    }
}
