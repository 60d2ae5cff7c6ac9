//! Ray differentials after a perfect mirror or a smooth refraction (Igehy 1999, §3.2; Pharr, Jakob
//! and Humphreys 2016, §10.1.3): the neighboring film points' rays, so that textures seen in
//! mirrors and through glass are filtered as widely as they are shrunk.

use crate::bsdf::{Bsdf, BsdfSample};
use crate::math::Vec3;
use crate::math::ray::RayDifferentials;
use crate::surface::SurfaceHit;

/// The differentials of the ray that leaves `surface` by a specular `sample`, from those of the ray
/// that came. Changes are of first order; directions are not of unit length.
pub fn scattered(
    arriving: &RayDifferentials,
    surface: &SurfaceHit,
    bsdf: &Bsdf,
    sample: &BsdfSample,
) -> RayDifferentials {
    let footprint = surface.footprint(Some(arriving));
    let bend = Bend::new(surface, bsdf, sample);
    let shading = &surface.shading;
    let turn = |d: Vec3, uv: crate::math::Vec2| {
        let dwo = -d - surface.wo;
        let dn = shading.dndu * uv.x + shading.dndv * uv.y;
        bend.direction(dwo, dn)
    };
    RayDifferentials {
        rx_o: surface.p + footprint.dpdx,
        rx_d: turn(arriving.rx_d, footprint.duvdx),
        ry_o: surface.p + footprint.dpdy,
        ry_d: turn(arriving.ry_d, footprint.duvdy),
    }
}

/// How a surface turns one ray.
struct Bend {
    wo: Vec3,
    wi: Vec3,
    n: Vec3,
    /// Refractive index on the side of `wo` over that on the side of `wi`; `None` for reflection.
    eta: Option<f32>,
    /// −1 where the shading normal had to be turned to the side of `wo`.
    side: f32,
}

impl Bend {
    fn new(surface: &SurfaceHit, bsdf: &Bsdf, sample: &BsdfSample) -> Bend {
        let n = bsdf.shading_normal();
        let side = if n.dot(surface.wo) < 0.0 { -1.0 } else { 1.0 };
        Bend {
            wo: surface.wo,
            wi: sample.wi,
            n: side * n,
            eta: sample.transmission.then_some(1.0 / sample.eta),
            side,
        }
    }

    /// The direction that leaves where `wo` and the normal have changed by this much.
    fn direction(&self, dwo: Vec3, dn: Vec3) -> Vec3 {
        let (wo, wi, n, dn) = (self.wo, self.wi, self.n, self.side * dn);
        let cos = wo.dot(n);
        let dcos = dwo.dot(n) + wo.dot(dn);
        match self.eta {
            // wi = −wo + 2 cos n
            None => wi - dwo + 2.0 * (cos * dn + dcos * n),
            // wi = −η wo + µ n, µ = η cos − cos′
            Some(eta) => {
                let cos_i = wi.dot(n).abs();
                let mu = eta * cos - cos_i;
                let dmu = (eta - eta * eta * cos / cos_i) * dcos;
                wi - eta * dwo + (mu * dn + dmu * n)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::ray::Ray;
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::SourceMap;
    use crate::world::World;

    fn world(text: &str) -> World {
        let sources = SourceMap::new();
        let text = format!("WorldBegin {text} WorldEnd");
        let main = sources.add_text("test.pbrt", text);
        let (mut scene, _) = read_scene(&sources, main, &ReadSettings::default());
        let (built, diagnostics) = crate::build::build(scene.frames.pop().unwrap(), 0);
        assert!(!diagnostics.has_errors());
        built.unwrap().job.world
    }

    /// Where a ray goes on.
    fn leave<'a>(
        world: &'a World,
        ray: &Ray,
        transmit: bool,
    ) -> Option<(SurfaceHit, Bsdf<'a>, BsdfSample)> {
        let hit = world.intersect(ray)?;
        let bsdf = world.bsdf(world.material(hit.material)?, &hit.surface, None);
        let sample = bsdf.sample_specular(hit.surface.wo, transmit, 0.5)?;
        Some((hit.surface, bsdf, sample))
    }

    /// Against the neighboring rays themselves, traced to the same surface. False where nothing
    /// is transmitted: total reflection.
    fn check(name: &str, world: &World, o: Vec3, target: Vec3, transmit: bool) -> bool {
        // Large enough for single-precision hits, small enough for the first order.
        const STEP: f32 = 2e-3;
        let d = (target - o).normalize();
        let (sx, sy) = crate::math::frame::coordinate_system(d);
        let ray = Ray::new(o, d, 0.0);
        let neighbors =
            [sx, sy].map(|s| Ray::new(o + s * (0.5 * STEP), (d + s * STEP).normalize(), 0.0));
        let arriving = RayDifferentials {
            rx_o: neighbors[0].o,
            rx_d: neighbors[0].d,
            ry_o: neighbors[1].o,
            ry_d: neighbors[1].d,
        };
        let Some((surface, bsdf, sample)) = leave(world, &ray, transmit) else {
            return false;
        };
        let found = scattered(&arriving, &surface, &bsdf, &sample);
        for (neighbor, o, d) in [
            (&neighbors[0], found.rx_o, found.rx_d),
            (&neighbors[1], found.ry_o, found.ry_d),
        ] {
            let (at, _, traced) = leave(world, neighbor, transmit).expect("a hit");
            let turned = traced.wi - sample.wi;
            let said = d - sample.wi;
            // What the second order leaves of so small a step: a few hundredths of the change on a
            // ball as large as the distance; 1e-6 of rounding.
            assert!(
                (said - turned).length() < 0.03 * turned.length() + 5e-6,
                "{name}: {said} but traced {turned}"
            );
            // The point is taken on the tangent plane, the ray's own is on the surface.
            let moved = at.p - surface.p;
            let said = o - surface.p;
            assert!(
                (said - moved).length() < 0.03 * moved.length() + 5e-6,
                "{name}: {said} but {moved}"
            );
        }
        true
    }

    #[test]
    fn directions_change_as_those_of_neighboring_rays() {
        let shapes = [
            ("ball", "Shape \"sphere\" \"float radius\" 1"),
            ("flattened ball", "Scale 1 .6 1.3 Shape \"sphere\""),
            ("turned inside out", "ReverseOrientation Shape \"sphere\""),
            ("plane", "Shape \"disk\" \"float radius\" 9"),
        ];
        let mut checked = 0;
        for (shape, text) in shapes {
            for (material, sides) in [
                ("\"mirror\"", &[false][..]),
                ("\"glass\" \"float eta\" 1.5", &[false, true]),
            ] {
                let world = world(&format!("Material {material} {text}"));
                for &transmit in sides {
                    for (o, target) in [
                        (Vec3::new(0.3, -3.0, 2.0), Vec3::new(0.1, 0.2, 0.1)),
                        (Vec3::new(2.0, 1.0, -2.5), Vec3::new(0.2, 0.1, 0.0)),
                        // From inside, where the shape has one.
                        (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.4, 0.3, -0.9)),
                    ] {
                        let name = format!("{shape}, {material}, {transmit}, from {o}");
                        checked += u32::from(check(&name, &world, o, target, transmit));
                    }
                }
            }
        }
        // Of 36, those that are totally reflected inside.
        assert!(checked >= 32, "{checked}");
    }
}
