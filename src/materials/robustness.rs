//! Robustness: no parameter, however extreme, constant or textured, leads to NaN or infinity.

use super::{Material, Named, NamedMaterials};
use crate::bsdf::testing::{direction, flat_hit, random};
use crate::bsdf::{Bsdf, BsdfSample};
use crate::handles::{FloatTextureId, MaterialId, SpectrumTextureId};
use crate::inputs::TextureRead;
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::testing::{Surroundings, read_in};
use crate::params::{Dialect, TextureNames};
use crate::surface::Footprint;
use crate::textures::{Constant, Texture, TextureSpecs, TextureUsage, Textures};
use proptest::prelude::*;

/// Extreme values that break formulas.
const WILD: [f32; 18] = [
    0.0,
    -0.0,
    1e-30,
    1e-7,
    0.5,
    1.0,
    1.000_000_1,
    0.999_999_9,
    1.5,
    -1.0,
    -1e30,
    90.0,
    1e6,
    1e30,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Every kind of material with its float and its spectrum parameters.
const KINDS: [(&str, &[&str], &[&str]); 13] = [
    (
        "subsurface",
        &["eta", "uroughness", "vroughness"],
        &["Kr", "Kt", "sigma_a", "sigma_s"],
    ),
    (
        "kdsubsurface",
        &["eta", "uroughness", "vroughness"],
        &["Kd", "mfp", "Kr", "Kt"],
    ),
    ("matte", &["sigma"], &["Kd"]),
    ("mirror", &[], &["Kr"]),
    ("glass", &["eta", "uroughness", "vroughness"], &["Kr", "Kt"]),
    ("plastic", &["roughness"], &["Kd", "Ks"]),
    (
        "metal",
        &["roughness", "uroughness", "vroughness"],
        &["eta", "k"],
    ),
    (
        "uber",
        &["eta", "roughness", "uroughness", "vroughness"],
        &["Kd", "Ks", "Kr", "Kt", "opacity"],
    ),
    ("substrate", &["uroughness", "vroughness"], &["Kd", "Ks"]),
    (
        "translucent",
        &["roughness"],
        &["Kd", "Ks", "reflect", "transmit"],
    ),
    (
        "disney",
        &[
            "metallic",
            "eta",
            "roughness",
            "speculartint",
            "anisotropic",
            "sheen",
            "sheentint",
            "clearcoat",
            "clearcoatgloss",
            "spectrans",
            "flatness",
            "difftrans",
        ],
        &["color", "scatterdistance"],
    ),
    (
        "hair",
        &[
            "eta",
            "beta_m",
            "beta_n",
            "alpha",
            "eumelanin",
            "pheomelanin",
        ],
        &["sigma_a", "color"],
    ),
    ("shinymetal", &["roughness"], &["Ks", "Kr"]),
];

/// Two materials for a mix.
struct Two([Option<Named>; 2]);

impl NamedMaterials for Two {
    fn find(&self, name: &str) -> Option<Option<Named>> {
        let i = ["a", "b"].iter().position(|n| *n == name)?;
        Some(self.0[i])
    }

    fn names(&self) -> Vec<&str> {
        vec!["a", "b"]
    }

    fn defining(&self) -> Option<&str> {
        None
    }
}

/// A float and a spectrum texture for each extreme value, and their names.
fn textures() -> (Textures, TextureNames) {
    let floats = WILD.map(|value| Texture::Constant(Constant { value }));
    let spectra = WILD.map(|value| {
        let value = Rgb::new(value, 0.5, -value);
        Texture::Constant(Constant { value })
    });
    let mut names = TextureNames::default();
    let specs = TextureSpecs::of(&floats, &spectra);
    let mut usage = TextureUsage::new(&specs);
    for i in 0..WILD.len() {
        let (float, spectrum) = (FloatTextureId(i as u32), SpectrumTextureId(i as u32));
        names.float.insert(format!("t{i}"), float);
        names.spectrum.insert(format!("t{i}"), spectrum);
        usage.add([TextureRead::Float(float), TextureRead::Spectrum(spectrum)]);
    }
    let (textures, problems) = Textures::compile(
        &specs,
        &usage,
        &Transform::IDENTITY,
        &crate::budget::Budget::unlimited(),
    );
    assert!(problems.is_empty());
    (textures, names)
}

/// Some of a kind's parameters, each an extreme constant or a texture of one.
fn params(kind: usize) -> impl Strategy<Value = String> {
    let (_, floats, spectra) = KINDS[kind];
    let names = floats.iter().map(|name| (true, *name));
    let names: Vec<_> = names
        .chain(spectra.iter().map(|name| (false, *name)))
        .collect();
    let choices = proptest::collection::vec((0..3u8, 0..WILD.len()), names.len());
    let bump = 0..WILD.len();
    (choices, any::<bool>(), any::<bool>(), bump).prop_map(move |(choices, thin, remap, bump)| {
        let mut text =
            format!("\"bool remaproughness\" \"{remap}\" \"texture bumpmap\" \"t{bump}\"");
        if KINDS[kind].0 == "disney" {
            text += &format!(" \"bool thin\" \"{thin}\"");
        }
        for ((is_float, name), (how, i)) in names.iter().zip(choices) {
            let value = WILD[i];
            text += &match (how, is_float) {
                (0, _) => String::new(),
                (1, true) if value.is_finite() => format!(" \"float {name}\" {value:e}"),
                (1, false) if value.is_finite() => format!(" \"rgb {name}\" [{value:e} .5 1]"),
                _ => format!(" \"texture {name}\" \"t{i}\""),
            };
        }
        text
    })
}

fn kind_and_params() -> impl Strategy<Value = (usize, String)> {
    (0..KINDS.len()).prop_flat_map(|kind| (Just(kind), params(kind)))
}

fn check_sample(sample: &BsdfSample, what: &str) {
    let BsdfSample { f, wi, pdf, .. } = *sample;
    let sound = !f.is_nan() && pdf > 0.0 && wi.is_finite() && (wi.length() - 1.0).abs() < 1e-3;
    assert!(sound, "{what}: {sample:?}");
}

fn check(bsdf: &Bsdf, seed: u64, what: &str) {
    let mut directions = vec![
        Vec3::X,
        Vec3::Z,
        -Vec3::Z,
        direction(89.9999, 0.0),
        direction(90.0001, 3.0),
    ];
    for i in 0..6 {
        let (z, u) = random(seed.wrapping_add(i));
        directions.push(direction(180.0 * z, 360.0 * u.x));
    }
    for (i, &wo) in directions.iter().enumerate() {
        for &wi in &directions {
            let (f, pdf) = (bsdf.f(wo, wi), bsdf.pdf(wo, wi));
            assert!(!f.is_nan() && !pdf.is_nan(), "{what}: {wo} {wi}: {f} {pdf}");
        }
        let (uc, u) = random(seed.wrapping_add(100 + i as u64));
        for u in [u, Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON / 2.0)] {
            let samples = [
                bsdf.sample(wo, uc, u),
                bsdf.sample_specular(wo, true, uc),
                bsdf.sample_specular(wo, false, uc),
            ];
            samples.iter().flatten().for_each(|s| check_sample(s, what));
        }
    }
}

proptest! {
    // As many as take about a second; PROPTEST_CASES sets more.
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(4000)))]
    #[test]
    fn nothing_is_ever_not_a_number(
        (a, first) in kind_and_params(),
        (b, second) in kind_and_params(),
        amount in 0..WILD.len(),
        v in prop_oneof![Just(0.0f32), Just(1.0), Just(0.5), Just(-3.0), Just(f32::NAN), 0.0f32..1.0],
        seed in any::<u64>(),
    ) {
        let (textures, names) = textures();
        let surroundings = Surroundings { dialect: Dialect::V3, textures: names, ..Surroundings::default() };
        let make = |kind: usize, params: &str, named: &Two| {
            let kind = KINDS[kind].0;
            let dialect = if kind == "shinymetal" { Dialect::V2 } else { Dialect::V3 };
            let surroundings = Surroundings { dialect, ..surroundings.clone() };
            read_in(&surroundings, kind, params, |r| Material::from_params(r, named)).value.unwrap()
        };
        let none = Two([None, None]);
        let materials = [make(a, &first, &none), make(b, &second, &none)];
        let text = format!("\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"texture amount\" \"t{amount}\"");
        let two = Two([0, 1].map(|i| Some(Named::new(MaterialId(i), &materials[i as usize]))));
        let mix = read_in(&surroundings, "mix", &text, |r| Material::from_params(r, &two)).value.unwrap();
        let mut hit = flat_hit(Vec3::Z);
        hit.uv = Vec2::new(0.5, v);
        for material in materials.iter().chain([&mix]) {
            let bsdf = material.bsdf(&hit, &Footprint::default(), &textures, &materials);
            check(&bsdf, seed, &format!("{} {first}\n{} {second}\n{text}", KINDS[a].0, KINDS[b].0));
        }
    }
}
