//! Materials against pbrt-v3's values, and their parameters.

use super::inputs::refractive_index;
use super::roughness::{Roughness, RoughnessMeaning};
use super::*;
use crate::bsdf::testing::{direction, flat_hit, sky_by_sampling, sky_by_value};
use crate::inputs::FloatInput;
use crate::params::testing::read;

/// No named materials.
struct NoneNamed;

impl NamedMaterials for NoneNamed {
    fn find(&self, _: &str) -> Option<Option<Named>> {
        None
    }

    fn names(&self) -> Vec<&str> {
        Vec::new()
    }

    fn defining(&self) -> Option<&str> {
        None
    }
}

const fn gray(v: f32) -> SpectrumInput {
    SpectrumInput::Constant(Rgb::splat(v))
}

const fn float(v: f32) -> FloatInput {
    FloatInput::Constant(v)
}

fn rough(r: f32, meaning: RoughnessMeaning) -> Roughness {
    let along = [float(r); 2];
    Roughness { along, meaning }
}

fn matte(kd: f32, sigma: f32) -> MaterialKind {
    MaterialKind::Matte(Matte {
        kd: gray(kd),
        sigma: float(sigma),
    })
}

fn plastic(kd: f32, ks: f32, meaning: RoughnessMeaning) -> MaterialKind {
    MaterialKind::Plastic(Plastic {
        kd: gray(kd),
        ks: gray(ks),
        roughness: rough(0.1, meaning),
    })
}

fn uber(kd: f32, ks: f32, kr: f32, kt: f32, opacity: f32) -> MaterialKind {
    MaterialKind::Uber(Uber {
        kd: gray(kd),
        ks: gray(ks),
        kr: gray(kr),
        kt: gray(kt),
        opacity: gray(opacity),
        roughness: rough(0.1, RoughnessMeaning::Remapped),
        eta: float(1.5),
        swapped: false,
    })
}

fn substrate(kd: f32, ks: f32, roughness: f32) -> MaterialKind {
    MaterialKind::Substrate(Substrate {
        kd: gray(kd),
        ks: gray(ks),
        roughness: rough(roughness, RoughnessMeaning::Remapped),
    })
}

fn translucent(kd: f32, ks: f32) -> MaterialKind {
    MaterialKind::Translucent(Translucent {
        kd: gray(kd),
        ks: gray(ks),
        reflect: gray(0.5),
        transmit: gray(0.5),
        roughness: rough(0.1, RoughnessMeaning::Remapped),
        mirrored: false,
    })
}

/// A `disney` material with its defaults.
fn disney() -> MaterialKind {
    MaterialKind::Disney(read("disney", "", Disney::from_params).value)
}

fn glass(roughness: f32) -> MaterialKind {
    MaterialKind::Glass(Glass {
        kr: gray(1.0),
        kt: gray(1.0),
        eta: float(1.5),
        roughness: rough(roughness, RoughnessMeaning::Remapped),
    })
}

// The few materials of these tests are leaked, so that their BSDFs are self-contained.
fn bsdf(kind: MaterialKind, wo: crate::math::Vec3) -> Bsdf<'static> {
    let material = Box::leak(Box::new(Material::without_textures(kind)));
    material.bsdf(
        &flat_hit(wo),
        &Footprint::default(),
        &Textures::default(),
        &[],
    )
}

/// White furnace at 0°, 60° and 80°, with values measured with pbrt-v3 (docs/scene-language.md §6.5).
#[test]
fn materials_reflect_as_much_as_pbrts() {
    let table = [
        ("matte", matte(0.5, 0.0), [0.5, 0.5, 0.5]),
        ("matte Kd 1", matte(1.0, 0.0), [1.0, 1.0, 1.0]),
        (
            "matte Kd 1 sigma 20",
            matte(1.0, 20.0),
            [0.8652, 0.9423, 0.9786],
        ),
        (
            "matte Kd 1 sigma 90",
            matte(1.0, 90.0),
            [0.5590, 0.6884, 0.7492],
        ),
        (
            "plastic",
            plastic(0.25, 0.25, RoughnessMeaning::Remapped),
            [0.2618, 0.3672, 0.4058],
        ),
        (
            "plastic Kd 0 Ks 1",
            plastic(0.0, 1.0, RoughnessMeaning::Remapped),
            [0.0473, 0.4691, 0.6233],
        ),
        (
            "plastic Kd 0 Ks 1 unmapped",
            plastic(0.0, 1.0, RoughnessMeaning::Alpha),
            [0.0425, 0.9402, 0.8751],
        ),
        (
            "uber",
            uber(0.25, 0.25, 0.0, 0.0, 1.0),
            [0.2574, 0.2616, 0.2721],
        ),
        (
            "uber Kd 0 Ks 1",
            uber(0.0, 1.0, 0.0, 0.0, 1.0),
            [0.0297, 0.0465, 0.0884],
        ),
        (
            "substrate",
            substrate(0.5, 0.5, 0.1),
            [0.5360, 0.5069, 0.4492],
        ),
        (
            "translucent",
            translucent(0.25, 0.25),
            [0.3061, 0.3032, 0.3040],
        ),
        ("disney", disney(), [0.5400, 0.5708, 0.6496]),
        ("glass", glass(0.0), [0.4667, 0.4940, 0.6598]),
        ("glass roughness 0.1", glass(0.1), [0.4487, 0.4290, 0.4302]),
    ];
    for (name, kind, expected) in table {
        for (degrees, expected) in [0.0, 60.0, 80.0].into_iter().zip(expected) {
            let wo = direction(degrees, 20.0);
            let shown = sky_by_value(&bsdf(kind.clone(), wo), wo, 500).x;
            // The table's noise: a standard deviation of at most 0.5 over √260 000 samples is
            // 0.001; three of them for 33 comparisons.
            assert!(
                (shown - expected).abs() < 0.003,
                "{name} at {degrees}°: {shown}, pbrt shows {expected}"
            );
        }
    }
}

#[test]
fn opacity_lets_the_rest_straight_through() {
    // With reflectance 1, the surface and its holes together return exactly a white sky.
    let wo = direction(35.0, 0.0);
    let half = bsdf(uber(1.0, 0.0, 0.0, 0.0, 0.3), wo);
    assert!((sky_by_value(&half, wo, 200).x - 1.0).abs() < 1e-4);
    // Some of the 16² strata of the number that chooses hold the border of two lobes.
    assert!((sky_by_sampling(&half, wo, 16).x - 1.0).abs() < 2e-3);
    let through = half.sample_specular(wo, true, 0.5).unwrap();
    assert!((through.wi + wo).length() < 1e-6 && through.eta == 1.0);
}

fn metal(roughness: f32) -> MaterialKind {
    MaterialKind::Metal(Metal {
        eta: gray(0.2),
        k: gray(4.0),
        roughness: rough(roughness, RoughnessMeaning::Remapped),
    })
}

#[test]
fn materials_keep_energy() {
    for kind in [
        matte(1.0, 45.0),
        uber(0.0, 1.0, 0.0, 0.0, 1.0),
        uber(0.0, 0.0, 1.0, 1.0, 1.0),
        glass(0.3),
        metal(0.2),
    ] {
        for degrees in [0.0, 45.0, 85.0] {
            let wo = direction(degrees, 0.0);
            let shown = sky_by_sampling(&bsdf(kind.clone(), wo), wo, 40).x;
            // Standard error of 40³ stratified samples.
            assert!(shown <= 1.005, "{kind:?} at {degrees}° shows {shown}");
        }
    }
}

#[test]
fn black_and_negative_reflectances_leave_no_lobe() {
    let wo = direction(10.0, 0.0);
    assert!(bsdf(matte(-1.0, 0.0), wo).is_black());
    assert!(bsdf(uber(0.0, 0.0, 0.0, 0.0, 1.0), wo).is_black());
    assert!(bsdf(MaterialKind::Mirror(Mirror { kr: gray(0.0) }), wo).is_black());
}

#[test]
fn a_mirror_reflects_its_kr_at_every_angle() {
    for degrees in [0.0, 60.0, 89.0] {
        let wo = direction(degrees, 5.0);
        let shown = sky_by_sampling(
            &bsdf(MaterialKind::Mirror(Mirror { kr: gray(0.9) }), wo),
            wo,
            2,
        )
        .x;
        assert!((shown - 0.9).abs() < 1e-5);
    }
}

#[test]
fn numbers_out_of_range_are_replaced_with_a_warning() {
    for kind in ["glass", "uber"] {
        for (index, used, warnings) in [
            ("0", 1.5, 1),
            ("-1", 1.5, 1),
            ("inf", 1.5, 1),
            ("1", 1.0, 0),
        ] {
            for name in ["eta", "index"] {
                let params = format!("\"float {name}\" {index}");
                let outcome = read(kind, &params, refractive_index);
                assert_eq!((outcome.value, outcome.warnings), (float(used), warnings));
            }
        }
    }
    for (kind, name) in [
        ("plastic", "roughness"),
        ("glass", "uroughness"),
        ("uber", "vroughness"),
    ] {
        let params = format!("\"float {name}\" -1");
        let outcome = read(kind, &params, |r| Material::from_params(r, &NoneNamed));
        assert_eq!(outcome.warnings, 1, "{}", outcome.text);
        let least = read(kind, &params.replace("-1", ".001"), |r| {
            Material::from_params(r, &NoneNamed)
        });
        assert_eq!((outcome.value, least.warnings), (least.value, 0));
    }
}
