use super::fresnel::Fresnel;
use super::lambertian::LambertianReflection;
use super::microfacet::MicrofacetReflection;
use super::specular::{FresnelSpecular, SpecularReflection, SpecularTransmission};
use super::testing::*;
use super::trowbridge_reitz::TrowbridgeReitz;
use super::*;

fn bsdf(lobes: &[Lobe<'static>]) -> Bsdf<'static> {
    let hit = flat_hit(Vec3::Z);
    let mut bsdf = Bsdf::new(hit.n, &hit.shading);
    lobes.iter().for_each(|&l| bsdf.add(l));
    bsdf
}

const LAMBERT: Lobe = Lobe::LambertianReflection(LambertianReflection {
    reflectance: Rgb::ONE,
});
const MIRROR: Lobe = Lobe::SpecularReflection(SpecularReflection {
    reflectance: Rgb::ONE,
    fresnel: Fresnel::NoOp,
});
const GLASS: Lobe = Lobe::FresnelSpecular(FresnelSpecular {
    reflectance: Rgb::ONE,
    transmittance: Rgb::ONE,
    eta_a: 1.0,
    eta_b: 1.5,
    evenness: 0.0,
});

#[test]
fn lossless_lobes_pass_the_white_furnace() {
    for degrees in [0.0, 30.0, 70.0, 89.0] {
        let wo = direction(degrees, 70.0);
        for lobe in [LAMBERT, MIRROR] {
            // Only rounding error.
            assert!((sky_by_sampling(&bsdf(&[lobe]), wo, 8).x - 1.0).abs() < 1e-5);
        }
        // Smooth glass loses nothing either, once the radiance's 1/η² is undone.
        let glass = bsdf(&[GLASS]);
        for wo in [wo, -wo] {
            let mut sum = 0.0;
            for i in 0..1000 {
                let s = glass
                    .sample(wo, 0.5, Vec2::new((i as f32 + 0.5) / 1000.0, 0.5))
                    .unwrap();
                assert!(s.specular && s.transmission == (s.wi.z * wo.z < 0.0));
                sum += s.f.x * s.wi.z.abs() / s.pdf * s.eta * s.eta / 1000.0;
            }
            assert!((sum - 1.0).abs() < 1e-4, "glass at {degrees}° keeps {sum}");
        }
    }
}

#[test]
fn refraction_follows_snells_law_both_ways() {
    for degrees in [5.0f32, 30.0, 60.0, 85.0] {
        let wo = direction(degrees, 33.0);
        let inward = bsdf(&[GLASS]).sample_specular(wo, true, 0.5).unwrap();
        let sin = inward.wi.truncate().length();
        assert!((1.5 * sin - degrees.to_radians().sin()).abs() < 1e-5 && inward.eta == 1.5);
        let outward = bsdf(&[GLASS])
            .sample_specular(inward.wi, true, 0.5)
            .unwrap();
        assert!(
            (outward.wi - wo).length() < 1e-4,
            "back along the way it came"
        );
        assert!((outward.eta - 1.0 / 1.5).abs() < 1e-6);
    }
    assert!(
        bsdf(&[GLASS])
            .sample_specular(-direction(60.0, 0.0), true, 0.5)
            .is_none(),
        "total reflection"
    );
}

#[test]
fn what_is_prepared_changes_nothing_and_is_forgotten_with_the_lobes() {
    let rough = Lobe::MicrofacetReflection(MicrofacetReflection {
        reflectance: Rgb::splat(0.3),
        distribution: TrowbridgeReitz::new(0.2, 0.2),
        fresnel: Fresnel::Dielectric {
            eta_i: 1.0,
            eta_t: 1.5,
        },
    });
    let plain = bsdf(&[LAMBERT, rough]);
    let (wo, other) = (direction(50.0, 20.0), direction(70.0, 80.0));
    let mut prepared = plain.clone();
    prepared.prepare(wo);
    let same = |a: &Bsdf, b: &Bsdf, wo: Vec3| {
        let wi = direction(30.0, 200.0);
        assert_eq!(a.f_and_pdf(wo, wi), b.f_and_pdf(wo, wi));
        for u in [0.1, 0.4, 0.9].map(|u| Vec2::new(u, 0.3)) {
            let [a, b] = [a, b].map(|bsdf| bsdf.sample(wo, 0.5, u).expect("a sample"));
            assert_eq!((a.wi, a.pdf, a.f), (b.wi, b.pdf, b.f));
        }
    };
    for wo in [wo, other] {
        same(&plain, &prepared, wo);
    }
    prepared.scale_from(0, Rgb::new(0.1, 0.2, 0.3));
    let mut scaled = plain.clone();
    scaled.scale_from(0, Rgb::new(0.1, 0.2, 0.3));
    same(&scaled, &prepared, wo);
    prepared.prepare(wo);
    prepared.add(LAMBERT);
    scaled.add(LAMBERT);
    same(&scaled, &prepared, wo);
    assert_ne!(
        scaled.sample(wo, 0.5, Vec2::splat(0.5)).map(|s| s.pdf),
        None
    );
}

#[test]
fn specular_lobes_of_one_side_share_the_choice() {
    let straight = |transmittance| {
        Lobe::SpecularTransmission(SpecularTransmission {
            transmittance,
            eta_a: 1.0,
            eta_b: 1.0,
        })
    };
    let two = bsdf(&[LAMBERT, straight(Rgb::X), MIRROR, straight(Rgb::Y)]);
    let wo = direction(50.0, 0.0);
    let (a, b) = (
        two.sample_specular(wo, true, 0.2).unwrap(),
        two.sample_specular(wo, true, 0.7).unwrap(),
    );
    assert!(a.f.x > 0.0 && b.f.y > 0.0 && a.pdf == 0.5 && b.pdf == 0.5);
    assert!(
        (a.wi + wo).length() < 1e-6,
        "equal indices pass light straight on"
    );
    assert_eq!(two.sample_specular(wo, false, 0.9).unwrap().pdf, 1.0);
}

#[test]
fn geometric_normal_decides_between_reflection_and_transmission() {
    // A shading normal tilted by 40°: a direction above the shading plane may be below the
    // surface, where a reflection has no value.
    let mut hit = flat_hit(Vec3::Z);
    hit.shading.n = direction(40.0, 0.0);
    let mut tilted = Bsdf::new(hit.n, &hit.shading);
    tilted.add(LAMBERT);
    let wo = direction(10.0, 0.0);
    assert_eq!(tilted.f(wo, direction(110.0, 0.0)), Rgb::ZERO);
    assert!(
        tilted.f(wo, direction(80.0, 180.0)).x > 0.0,
        "above the surface, below the shading plane"
    );
    assert_eq!(tilted.f(direction(130.0, 0.0), wo), Rgb::ZERO);
}

#[test]
fn value_and_density_together_are_those_apart() {
    let rough = Lobe::MicrofacetReflection(MicrofacetReflection {
        reflectance: Rgb::new(0.3, 0.2, 0.1),
        distribution: TrowbridgeReitz::new(0.2, 0.5),
        fresnel: Fresnel::Dielectric {
            eta_i: 1.0,
            eta_t: 1.5,
        },
    });
    let hit = flat_hit(Vec3::Z);
    for lobes in [
        &[][..],
        &[LAMBERT],
        &[rough],
        &[MIRROR],
        &[LAMBERT, rough, GLASS],
    ] {
        let mut bsdf = Bsdf::new(hit.n, &hit.shading);
        lobes.iter().for_each(|&l| bsdf.add(l));
        for i in 0..200 {
            let angles = [5.0f32, 60.0, 85.0, 100.0, 175.0];
            let wo = direction(angles[i % 5], 40.0);
            let wi = direction(i as f32 * 0.9, i as f32 * 37.0);
            let (f, pdf) = bsdf.f_and_pdf(wo, wi);
            // The same factors, multiplied in another order.
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-5 * b.abs();
            let expected = bsdf.f(wo, wi);
            assert!(near(pdf, bsdf.pdf(wo, wi)) && near(f.x, expected.x));
            assert!(near(f.y, expected.y) && near(f.z, expected.z));
            // The sample of a single lobe has that lobe's own value and density.
            let u = Vec2::new(i as f32 / 200.0, (i as f32 * 0.618).fract());
            let Some(s) = bsdf.sample(wo, u.y, u).filter(|s| !s.specular) else {
                continue;
            };
            // Directions are rounded when transformed to the world and back, and the lobe's slope magnifies that.
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * b.abs();
            let (f, pdf) = bsdf.f_and_pdf(wo, s.wi);
            assert!(near(s.f.x, f.x) && near(s.pdf, pdf), "{s:?} {f} {pdf}");
        }
    }
}

#[test]
fn without_lobes_nothing_is_scattered() {
    let empty = bsdf(&[]);
    assert!(empty.sample(Vec3::Z, 0.5, Vec2::ZERO).is_none() && empty.pdf(Vec3::Z, Vec3::Z) == 0.0);
}
