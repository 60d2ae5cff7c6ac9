//! Textures read and compiled, looked up.

use super::*;
use crate::budget::Budget;
use crate::handles::{FloatTextureId, SpectrumTextureId};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::color::linear_from_srgb;
use crate::math::{Vec2, Vec3};
use crate::surface::{Footprint, TexturePoint};
use crate::syntax::FileId;
use crate::textures::combinations::{Constant, Mix, Scale};
use crate::textures::imagemap::Decoding;
use crate::textures::mipmap::{Filter, Wrap};
use crate::textures::nesting::NestingProblem;
use crate::textures::{
    Bilerp, FloatTextureSpec, Imagemap, Mapping, SpectrumTextureSpec, Texture, Uv,
};
use std::path::Path;

const UV: Mapping = Mapping::Uv {
    scale: Vec2::ONE,
    delta: Vec2::ZERO,
};

fn at(u: f32, v: f32) -> TexturePoint {
    TexturePoint {
        p: Vec3::ZERO,
        uv: Vec2::new(u, v),
        footprint: Footprint::default(),
        face: 0,
    }
}

fn float(i: u32) -> FloatInput {
    FloatInput::Texture(FloatTextureId(i))
}

fn spectrum(i: u32) -> SpectrumInput {
    SpectrumInput::Texture(SpectrumTextureId(i))
}

fn compile(f: &[FloatTextureSpec], s: &[SpectrumTextureSpec]) -> (Textures, Vec<TextureProblem>) {
    compile_specs(&TextureSpecs::of(f, s))
}

fn compile_specs(specs: &TextureSpecs) -> (Textures, Vec<TextureProblem>) {
    let usage = TextureUsage::new(specs);
    Textures::compile(specs, &usage, &Transform::IDENTITY, &Budget::unlimited())
}

fn imagemap(path: &Path, decoding: Decoding, top_first: bool) -> Imagemap {
    let filter = Filter::Ewa {
        max_anisotropy: 8.0,
    };
    let settings = ImageSettings {
        wrap: Wrap::Repeat,
        filter,
        decoding,
        top_first,
    };
    Imagemap {
        mapping: UV,
        file: Some(named(path, 0)),
        settings,
        map: 0,
    }
}

fn named(path: &Path, start: u32) -> NamedFile {
    let span = Span {
        file: FileId(0),
        start,
        end: start + 1,
    };
    NamedFile {
        path: path.into(),
        span,
    }
}

const PLAIN: Decoding = Decoding::Scaled {
    srgb: false,
    scale: 1.0,
};

/// Two rows of two texels: red and green above blue and gray.
fn quadrants(directory: &Path) -> PathBuf {
    let path = directory.join("quadrants.png");
    let texels = [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [128, 128, 128]]];
    image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(texels[y as usize][x as usize]))
        .save(&path)
        .unwrap();
    path
}

#[test]
fn scale_mix_bilerp_and_uv_combine() {
    let bilerp = Bilerp {
        mapping: UV,
        v00: 0.0,
        v01: 1.0,
        v10: 2.0,
        v11: 5.0,
    };
    let f = [
        Texture::Bilerp(bilerp),
        Texture::Scale(Scale {
            tex1: float(0),
            tex2: FloatInput::Constant(3.0),
        }),
    ];
    let s = [
        Texture::Uv(Uv { mapping: UV }),
        Texture::Mix(Mix {
            tex1: spectrum(0),
            tex2: SpectrumInput::Constant(Rgb::ONE),
            amount: FloatInput::Constant(0.25),
        }),
    ];
    let (textures, problems) = compile(&f, &s);
    assert!(problems.is_empty() && !textures.needs_footprint());
    assert_eq!(textures.float(&float(0), &at(0.0, 1.0)), 1.0);
    assert_eq!(textures.float(&float(0), &at(1.0, 0.0)), 2.0);
    assert_eq!(textures.float(&float(1), &at(0.5, 0.5)), 6.0);
    assert_eq!(
        textures.spectrum(&spectrum(0), &at(1.25, -0.5)),
        Rgb::new(0.25, 0.5, 0.0)
    );
    assert_eq!(
        textures.spectrum(&spectrum(1), &at(0.5, 0.5)),
        Rgb::new(0.625, 0.625, 0.25)
    );
}

#[test]
fn images_stand_on_their_lower_left_corner() {
    let directory = tempfile::tempdir().unwrap();
    let path = quadrants(directory.path());
    let s = [
        Texture::Imagemap(imagemap(&path, PLAIN, false)),
        Texture::Imagemap(imagemap(&path, PLAIN, true)),
    ];
    let (textures, problems) = compile(&[], &s);
    assert!(problems.is_empty() && textures.needs_footprint());
    let blue = Rgb::Z;
    assert_eq!(
        textures.spectrum(&spectrum(0), &at(0.25, 0.25)),
        blue,
        "t grows upwards"
    );
    assert_eq!(textures.spectrum(&spectrum(0), &at(0.25, 0.75)), Rgb::X);
    assert_eq!(
        textures.spectrum(&spectrum(1), &at(0.25, 0.75)),
        blue,
        "v2's .exr: t grows downwards"
    );
}

#[test]
fn texels_are_decoded_before_or_after_as_the_dialect_says() {
    let directory = tempfile::tempdir().unwrap();
    let path = quadrants(directory.path());
    let gray = 128.0 / 255.0;
    for (decoding, expected) in [
        (
            Decoding::Scaled {
                srgb: true,
                scale: 2.0,
            },
            2.0 * linear_from_srgb(gray),
        ),
        (
            Decoding::Scaled {
                srgb: false,
                scale: 2.0,
            },
            2.0 * gray,
        ),
        // A PNG.
        (
            Decoding::ScaledAsFile { scale: 2.0 },
            2.0 * linear_from_srgb(gray),
        ),
        (
            Decoding::Power {
                scale: 2.0,
                gamma: 2.2,
            },
            (2.0 * gray).powf(2.2),
        ),
    ] {
        let (textures, _) = compile(
            &[Texture::Imagemap(imagemap(&path, decoding, false))],
            &[Texture::Imagemap(imagemap(&path, decoding, false))],
        );
        let v = textures.spectrum(&spectrum(0), &at(0.75, 0.25));
        assert!(
            (v - expected).abs().max_element() < 1e-5,
            "{decoding:?}: {v}"
        );
        assert!((textures.float(&float(0), &at(0.75, 0.25)) - expected).abs() < 1e-5);
    }
    // A float texture decodes the luminance of the encoded color, not the colors.
    let (textures, _) = compile(
        &[Texture::Imagemap(imagemap(
            &path,
            Decoding::Scaled {
                srgb: true,
                scale: 1.0,
            },
            false,
        ))],
        &[],
    );
    let red = textures.float(&float(0), &at(0.25, 0.75));
    assert!((red - linear_from_srgb(0.212671)).abs() < 1e-6, "{red}");
}

#[test]
fn textures_share_filtered_images() {
    let directory = tempfile::tempdir().unwrap();
    let path = quadrants(directory.path());
    let other = Decoding::Scaled {
        srgb: true,
        scale: 1.0,
    };
    let s = [PLAIN, other, PLAIN].map(|d| Texture::Imagemap(imagemap(&path, d, false)));
    let (textures, _) = compile(&[], &s);
    assert_eq!(textures.spectrum_maps.len(), 2);
    for i in [0, 2] {
        assert_eq!(
            textures.spectrum(&spectrum(i), &at(0.75, 0.25)),
            Rgb::splat(128.0 / 255.0)
        );
    }
}

#[test]
fn a_missing_image_is_gray_and_reported_once() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("missing.png");
    let spec = imagemap(
        &path,
        Decoding::Scaled {
            srgb: true,
            scale: 2.0,
        },
        false,
    );
    let (textures, problems) = compile(
        &[Texture::Imagemap(spec.clone())],
        &[Texture::Imagemap(spec)],
    );
    assert_eq!(problems.len(), 1);
    assert!(problems[0].error.to_string().contains("missing.png"));
    let expected = 2.0 * linear_from_srgb(0.5);
    assert_eq!(textures.float(&float(0), &at(0.1, 3.7)), expected);
    assert_eq!(
        textures.spectrum(&spectrum(0), &at(0.1, 3.7)),
        Rgb::splat(expected)
    );
}

/// One report for a file, at a texture that matters if there is one.
#[test]
fn a_broken_image_is_reported_where_it_is_used() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("broken.png");
    std::fs::write(&path, [0x89, b'P', b'N', b'G']).unwrap();
    let specs: Vec<SpectrumTextureSpec> = (0..4)
        .map(|start| {
            Texture::Imagemap(Imagemap {
                file: Some(named(&path, start)),
                ..imagemap(&path, PLAIN, false)
            })
        })
        .collect();
    let specs = TextureSpecs::of(&[], &specs);
    for (users, expected) in [
        (&[][..], (0, false)),
        (&[2, 3], (2, true)),
        (&[0], (0, true)),
    ] {
        let mut usage = TextureUsage::new(&specs);
        for &user in users {
            usage.add(spectrum(user).texture());
        }
        let (_, problems) =
            Textures::compile(&specs, &usage, &Transform::IDENTITY, &Budget::unlimited());
        let [TextureProblem { span, used, .. }] = &problems[..] else {
            panic!("{problems:?}");
        };
        assert_eq!((span.start, *used), expected, "{users:?}");
    }
}

#[test]
fn texels_that_are_not_finite_are_told() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.pfm");
    let texels = [f32::INFINITY, 0.5].map(f32::to_le_bytes).concat();
    std::fs::write(&path, [b"Pf\n2 1\n-1\n", &texels[..]].concat()).unwrap();
    let image = || vec![Texture::Imagemap(imagemap(&path, PLAIN, false))];
    let (_, problems) = compile(&image(), &[]);
    let [problem] = &problems[..] else {
        panic!("{problems:?}");
    };
    assert!(
        problem.is_usable && problem.error.to_string().contains("1 texel is not finite"),
        "{problem:?}"
    );
}

#[test]
fn long_chains_and_wrong_references_are_refused() {
    let link = |i: u32| {
        Texture::Scale(Scale {
            tex1: float(i),
            tex2: FloatInput::Constant(1.0),
        })
    };
    let one = || Texture::Constant(Constant { value: 1.0 });
    let mut specs = TextureSpecs::of(&[one()], &[]);
    let added = (0..100_000).map(|i| specs.add_float(link(i)).1);
    let problems: Vec<_> = added.collect();
    // Number 0 is no link. The chain starts afresh from each refused link.
    assert!(problems[..255].iter().all(Option::is_none));
    assert_eq!(problems[255], Some(NestingProblem::TooDeep));
    let (textures, _) = compile_specs(&specs);
    assert_eq!(textures.float(&float(255), &at(0.0, 0.0)), 1.0);
    assert_eq!(textures.float(&float(100_000), &at(0.0, 0.0)), 0.5);

    let mut specs = TextureSpecs::default();
    for i in [0, 5] {
        let problem = specs.add_float(link(i)).1;
        assert_eq!(problem, Some(NestingProblem::NotYetDefined));
    }
    let (textures, _) = compile_specs(&specs);
    assert_eq!(textures.float(&float(0), &at(0.0, 0.0)), 0.5);
    assert_eq!(textures.float(&float(77), &at(0.0, 0.0)), 0.0);
}
