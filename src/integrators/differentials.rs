//! Ray differentials after a perfect mirror or a smooth refraction (Igehy 1999, §3.2; Pharr, Jakob
//! and Humphreys 2016, §10.1.3): the neighboring film points' rays, so that textures in reflections and
//! behind glass are filtered over their footprint.

use crate::bsdf::{Bsdf, BsdfSample};
use crate::math::ray::RayDifferentials;
use crate::math::{Vec2, Vec3};
use crate::surface::SurfaceHit;

/// The differentials of the ray that leaves `surface` by a specular `sample`, from those of the ray
/// that arrived. Changes are of first order; directions are not of unit length.
pub(super) fn scattered(
    arriving: &RayDifferentials,
    surface: &SurfaceHit,
    bsdf: &Bsdf,
    sample: &BsdfSample,
) -> RayDifferentials {
    let (footprint, shading) = (surface.footprint(Some(arriving)), &surface.shading);
    let (wo, wi, n) = (surface.wo, sample.wi, bsdf.shading_normal());
    // The normal on the side of `wo`.
    let side = if n.dot(wo) < 0.0 { -1.0 } else { 1.0 };
    let n = side * n;
    let cos = wo.dot(n);
    let direction = |d: Vec3, uv: Vec2| {
        let dwo = -d - wo;
        let dn = side * (shading.dndu * uv.x + shading.dndv * uv.y);
        let dcos = dwo.dot(n) + wo.dot(dn);
        if !sample.transmission {
            // wi = −wo + 2 cos n
            return wi - dwo + 2.0 * (cos * dn + dcos * n);
        }
        // wi = −η wo + µ n, µ = η cos − cos′
        let eta = 1.0 / sample.eta;
        let cos_i = wi.dot(n).abs();
        let mu = eta * cos - cos_i;
        let dmu = (eta - eta * eta * cos / cos_i) * dcos;
        wi - eta * dwo + (mu * dn + dmu * n)
    };
    RayDifferentials {
        rx_o: surface.p + footprint.dpdx,
        rx_d: direction(arriving.rx_d, footprint.duvdx),
        ry_o: surface.p + footprint.dpdy,
        ry_d: direction(arriving.ry_d, footprint.duvdy),
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
        world_of("whitted", text)
    }

    /// Under this integrator.
    fn world_of(integrator: &str, text: &str) -> World {
        let sources = SourceMap::new();
        // A texture that is filtered: without one hits have no derivatives.
        let filtered = "Texture \"t\" \"color\" \"checkerboard\" MakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\"";
        let text = format!("Integrator \"{integrator}\" WorldBegin {filtered} {text} WorldEnd");
        let main = sources.add_text("test.pbrt", text);
        let (mut scene, said) = read_scene(&sources, main, &ReadSettings::default());
        assert!(!said.has_errors());
        let (built, diagnostics) = crate::build::build(scene.frames.pop().unwrap(), 0);
        assert!(!diagnostics.has_errors());
        built.unwrap().job.world
    }

    #[test]
    fn smooth_surfaces_have_derivatives_where_they_are_used() {
        for (integrator, uses) in [
            ("whitted", true),
            ("directlighting", true),
            ("path", false),
            ("volpath", false),
            ("bdpt", false),
            ("sppm", false),
        ] {
            let world = world_of(integrator, "Material \"glass\" Shape \"sphere\"");
            let ray = Ray::new(Vec3::new(0.2, 0.1, -5.0), Vec3::Z, 0.0);
            let surface = world.intersect(&ray).expect("a hit").surface;
            let derivatives = [surface.dpdu, surface.shading.dndu];
            assert!(
                derivatives.iter().all(|d| (*d != Vec3::ZERO) == uses),
                "{integrator}: {derivatives:?}"
            );
        }
    }

    /// The specular ray that leaves the hit of `ray`.
    fn leave<'a>(
        world: &'a World,
        ray: &Ray,
        transmit: bool,
    ) -> Option<(SurfaceHit, Bsdf<'a>, BsdfSample)> {
        let hit = world.intersect(ray)?;
        let mut bsdf = Bsdf::empty();
        world.fill_bsdf(world.material(hit.material)?, &hit.surface, None, &mut bsdf);
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
