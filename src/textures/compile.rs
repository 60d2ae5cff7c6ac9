//! From texture descriptions to textures ready for look-ups.

use super::imagemap::PictureSettings;
use super::mipmap::Mipmap;
use super::{
    Constant, FloatTextureSpec, MAX_DEPTH, SpectrumTextureSpec, Texture, TextureSpec, TextureUsage,
    TextureValue,
};
use crate::assets::picture::{Picture, PictureError};
use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::NamedFile;
use crate::syntax::Span;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// All textures of a scene.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    pub(super) float: Vec<Texture<f32>>,
    pub(super) spectrum: Vec<Texture<Rgb>>,
    pub(super) float_maps: Vec<Mipmap<f32>>,
    pub(super) spectrum_maps: Vec<Mipmap<Rgb>>,
}

/// What went wrong with a texture; the scene renders without it.
#[derive(Debug, thiserror::Error)]
pub enum TextureProblem {
    /// A picture cannot be used; a grey of 0.5 stands in for it.
    #[error("{error}: a grey of 0.5 is used")]
    Picture {
        /// What is wrong with it.
        error: PictureError,
        /// Where it is named: by the first texture that something uses, if any.
        span: Span,
        /// Does anything use a texture of this picture?
        used: bool,
    },
    /// A texture nests others too deeply; it is 0.5 everywhere.
    #[error(
        "{kind} texture number {index} nests textures more than {MAX_DEPTH} deep: a constant 0.5 is used"
    )]
    TooDeep {
        /// "float" or "spectrum".
        kind: &'static str,
        /// Its position among the scene's textures of that kind, from 0.
        index: usize,
    },
    /// A texture refers to one that does not come before it; it is 0.5 everywhere.
    #[error(
        "{kind} texture number {index} uses a texture that is not declared before it: a constant 0.5 is used"
    )]
    NotYetDeclared {
        /// "float" or "spectrum".
        kind: &'static str,
        /// Its position among the scene's textures of that kind, from 0.
        index: usize,
    },
}

impl Textures {
    /// Loads every picture once (in parallel) and moves all mappings to render space.
    /// `float[i]` is the texture of `FloatTextureId(i)`, `spectrum[i]` of `SpectrumTextureId(i)`.
    /// `usage` only tells problems that matter from those that do not.
    /// Problems come in the order of the textures that have them.
    pub fn compile(
        float: &[FloatTextureSpec],
        spectrum: &[SpectrumTextureSpec],
        usage: &TextureUsage,
        render_from_world: &Transform,
    ) -> (Textures, Vec<TextureProblem>) {
        let mut problems = Vec::new();
        let mut wanted = Wanted::default();
        let float_depths = depths("float", float, &[], &mut problems);
        let spectrum_depths = depths("spectrum", spectrum, &float_depths, &mut problems);
        let mut textures = Textures {
            float: compile_all(
                float,
                &float_depths,
                &usage.float,
                render_from_world,
                &mut wanted,
                |w| &mut w.float,
            ),
            spectrum: compile_all(
                spectrum,
                &spectrum_depths,
                &usage.spectrum,
                render_from_world,
                &mut wanted,
                |w| &mut w.spectrum,
            ),
            ..Textures::default()
        };
        (textures.float_maps, textures.spectrum_maps) = wanted.load(&mut problems);
        (textures, problems)
    }

    /// Does any texture use ray differentials? Where none does, cameras need not make them.
    pub fn needs_footprint(&self) -> bool {
        self.float.iter().any(Texture::needs_footprint)
            || self.spectrum.iter().any(Texture::needs_footprint)
    }
}

/// How deep each texture nests (1: uses no other); `None` for one that cannot be used.
fn depths<V: TextureValue>(
    kind: &'static str,
    specs: &[TextureSpec<V>],
    floats: &[Option<usize>],
    problems: &mut Vec<TextureProblem>,
) -> Vec<Option<usize>> {
    let mut depths: Vec<Option<usize>> = Vec::with_capacity(specs.len());
    for (index, spec) in specs.iter().enumerate() {
        let operands = spec.operands();
        // A float texture's amount is a float texture before it, like its other operands.
        let amounts = if kind == "float" { &depths } else { floats };
        let own = operands
            .own
            .iter()
            .filter_map(|&o| V::texture_index(o))
            .map(|i| depths.get(i));
        let amount = operands
            .amount
            .and_then(f32::texture_index)
            .map(|i| amounts.get(i));
        let below: Option<Vec<usize>> = own
            .chain(amount)
            .map(|d| d.map(|d| d.unwrap_or(0)))
            .collect();
        let depth = match below {
            None => {
                problems.push(TextureProblem::NotYetDeclared { kind, index });
                None
            }
            Some(below) => {
                let depth = 1 + below.into_iter().max().unwrap_or(0);
                if depth > MAX_DEPTH {
                    problems.push(TextureProblem::TooDeep { kind, index });
                    None
                } else {
                    Some(depth)
                }
            }
        };
        depths.push(depth);
    }
    depths
}

fn compile_all<V: TextureValue>(
    specs: &[TextureSpec<V>],
    depths: &[Option<usize>],
    used: &[bool],
    render_from_world: &Transform,
    wanted: &mut Wanted,
    list: fn(&mut Wanted) -> &mut Vec<WantedMap>,
) -> Vec<Texture<V>> {
    let compile = |(index, (spec, depth)): (usize, (&TextureSpec<V>, &Option<usize>))| {
        if depth.is_none() {
            return Texture::Constant(Constant {
                value: V::splat(0.5),
            });
        }
        match spec {
            TextureSpec::Constant(t) => Texture::Constant(*t),
            TextureSpec::Scale(t) => Texture::Scale(*t),
            TextureSpec::Mix(t) => Texture::Mix(*t),
            TextureSpec::Bilerp(t) => Texture::Bilerp(t.compile(render_from_world)),
            TextureSpec::Uv(t) => Texture::Uv(t.compile(render_from_world)),
            TextureSpec::Checkerboard(t) => Texture::Checkerboard(t.compile(render_from_world)),
            TextureSpec::Dots(t) => Texture::Dots(t.compile(render_from_world)),
            TextureSpec::Fbm(t) => Texture::Fbm(t.compile(render_from_world)),
            TextureSpec::Wrinkled(t) => Texture::Wrinkled(t.compile(render_from_world)),
            TextureSpec::Windy(t) => Texture::Windy(t.compile(render_from_world)),
            TextureSpec::Marble(t) => Texture::Marble(t.compile(render_from_world)),
            TextureSpec::Imagemap(t) => {
                let file = wanted.file_index(t.file.as_ref(), used.get(index) == Some(&true));
                let map = position_or_push(
                    list(wanted),
                    WantedMap {
                        file,
                        settings: t.settings,
                    },
                );
                Texture::Imagemap(t.compile(render_from_world, map))
            }
        }
    };
    specs.iter().zip(depths).enumerate().map(compile).collect()
}

/// The pictures a scene's textures ask for.
#[derive(Default)]
struct Wanted {
    files: Vec<WantedFile>,
    /// Positions in `files`.
    known: BTreeMap<PathBuf, usize>,
    float: Vec<WantedMap>,
    spectrum: Vec<WantedMap>,
}

struct WantedFile {
    name: NamedFile,
    used: bool,
}

#[derive(Clone, Copy, PartialEq)]
struct WantedMap {
    /// Index into the files; `None` for the grey that stands in for a missing one.
    file: Option<usize>,
    settings: PictureSettings,
}

impl Wanted {
    fn file_index(&mut self, file: Option<&NamedFile>, used: bool) -> Option<usize> {
        let name = file?.clone();
        let next = self.files.len();
        let index = *self.known.entry(name.path.clone()).or_insert(next);
        match self.files.get_mut(index) {
            None => self.files.push(WantedFile { name, used }),
            Some(known) if used && !known.used => *known = WantedFile { name, used },
            Some(_) => {}
        }
        Some(index)
    }

    /// All filtered pictures. Each file's picture is let go once its maps are made.
    fn load(self, problems: &mut Vec<TextureProblem>) -> (Vec<Mipmap<f32>>, Vec<Mipmap<Rgb>>) {
        let files = self.files.par_iter().enumerate().map(|(i, file)| {
            let picture = Picture::load(&file.name.path);
            let usable = picture.as_ref().ok();
            (
                self.maps(Some(i), &self.float, usable),
                self.maps(Some(i), &self.spectrum, usable),
                picture.err().map(|error| TextureProblem::Picture {
                    error,
                    span: file.name.span,
                    used: file.used,
                }),
            )
        });
        let mut loaded: Vec<_> = files.collect();
        loaded.push((
            self.maps(None, &self.float, None),
            self.maps(None, &self.spectrum, None),
            None,
        ));
        let (mut float, mut spectrum) = (Vec::new(), Vec::new());
        for (floats, spectra, error) in loaded {
            float.extend(floats);
            spectrum.extend(spectra);
            problems.extend(error);
        }
        (in_order(float), in_order(spectrum))
    }

    /// The maps wanted of one file, each with its position.
    fn maps<V: TextureValue>(
        &self,
        file: Option<usize>,
        wanted: &[WantedMap],
        picture: Option<&Picture>,
    ) -> Vec<(usize, Mipmap<V>)> {
        let of_file = wanted
            .iter()
            .enumerate()
            .filter(|(_, map)| map.file == file);
        of_file
            .map(|(i, map)| (i, map.settings.mipmap(picture)))
            .collect()
    }
}

fn in_order<T>(mut indexed: Vec<(usize, T)>) -> Vec<T> {
    indexed.sort_by_key(|(i, _)| *i);
    indexed.into_iter().map(|(_, value)| value).collect()
}

/// Where `value` stands in `list`; added at its end where it does not.
fn position_or_push<T: PartialEq>(list: &mut Vec<T>, value: T) -> usize {
    if let Some(i) = list.iter().position(|v| *v == value) {
        return i;
    }
    list.push(value);
    list.len() - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handles::{FloatTextureId, SpectrumTextureId};
    use crate::math::color::linear_from_srgb;
    use crate::math::{Vec2, Vec3};
    use crate::params::{FloatInput, SpectrumInput};
    use crate::surface::{Footprint, TexturePoint};
    use crate::syntax::FileId;
    use crate::textures::imagemap::{Decoding, ImagemapSpec};
    use crate::textures::{Bilerp, Filter, MappingSpec, Mix, Scale, Uv, Wrap};
    use std::path::Path;

    const UV: MappingSpec = MappingSpec::Uv {
        scale: Vec2::ONE,
        delta: Vec2::ZERO,
    };

    fn at(u: f32, v: f32) -> TexturePoint {
        TexturePoint {
            p: Vec3::ZERO,
            uv: Vec2::new(u, v),
            footprint: Footprint::default(),
        }
    }

    fn float(i: u32) -> FloatInput {
        FloatInput::Texture(FloatTextureId(i))
    }

    fn spectrum(i: u32) -> SpectrumInput {
        SpectrumInput::Texture(SpectrumTextureId(i))
    }

    fn compile(
        f: &[FloatTextureSpec],
        s: &[SpectrumTextureSpec],
    ) -> (Textures, Vec<TextureProblem>) {
        let usage = TextureUsage::new(f.len(), s.len());
        Textures::compile(f, s, &usage, &Transform::IDENTITY)
    }

    fn imagemap(path: &Path, decoding: Decoding, top_first: bool) -> ImagemapSpec {
        let filter = Filter::Ewa {
            max_anisotropy: 8.0,
        };
        let settings = PictureSettings {
            wrap: Wrap::Repeat,
            filter,
            decoding,
            top_first,
        };
        ImagemapSpec {
            mapping: UV,
            file: Some(named(path, 0)),
            settings,
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

    /// Two rows of two texels: red and green above blue and grey.
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
            TextureSpec::Bilerp(bilerp),
            TextureSpec::Scale(Scale {
                tex1: float(0),
                tex2: FloatInput::Constant(3.0),
            }),
        ];
        let s = [
            TextureSpec::Uv(Uv { mapping: UV }),
            TextureSpec::Mix(Mix {
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
    fn pictures_stand_on_their_lower_left_corner() {
        let directory = tempfile::tempdir().unwrap();
        let path = quadrants(directory.path());
        let s = [
            TextureSpec::Imagemap(imagemap(&path, PLAIN, false)),
            TextureSpec::Imagemap(imagemap(&path, PLAIN, true)),
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
        let grey = 128.0 / 255.0;
        for (decoding, expected) in [
            (
                Decoding::Scaled {
                    srgb: true,
                    scale: 2.0,
                },
                2.0 * linear_from_srgb(grey),
            ),
            (
                Decoding::Scaled {
                    srgb: false,
                    scale: 2.0,
                },
                2.0 * grey,
            ),
            (
                Decoding::Power {
                    scale: 2.0,
                    gamma: 2.2,
                },
                (2.0 * grey).powf(2.2),
            ),
        ] {
            let (textures, _) = compile(
                &[TextureSpec::Imagemap(imagemap(&path, decoding, false))],
                &[TextureSpec::Imagemap(imagemap(&path, decoding, false))],
            );
            let v = textures.spectrum(&spectrum(0), &at(0.75, 0.25));
            assert!(
                (v - expected).abs().max_element() < 1e-5,
                "{decoding:?}: {v}"
            );
            assert!((textures.float(&float(0), &at(0.75, 0.25)) - expected).abs() < 1e-5);
        }
        // A float texture decodes the luminance of the encoded colour, not the colours.
        let (textures, _) = compile(
            &[TextureSpec::Imagemap(imagemap(
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
    fn textures_share_filtered_pictures() {
        let directory = tempfile::tempdir().unwrap();
        let path = quadrants(directory.path());
        let other = Decoding::Scaled {
            srgb: true,
            scale: 1.0,
        };
        let s = [PLAIN, other, PLAIN].map(|d| TextureSpec::Imagemap(imagemap(&path, d, false)));
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
    fn a_missing_picture_is_grey_and_reported_once() {
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
            &[TextureSpec::Imagemap(spec.clone())],
            &[TextureSpec::Imagemap(spec)],
        );
        assert_eq!(problems.len(), 1);
        assert!(problems[0].to_string().contains("missing.png"));
        let expected = 2.0 * linear_from_srgb(0.5);
        assert_eq!(textures.float(&float(0), &at(0.1, 3.7)), expected);
        assert_eq!(
            textures.spectrum(&spectrum(0), &at(0.1, 3.7)),
            Rgb::splat(expected)
        );
    }

    /// One report for a file, at a texture that matters if there is one.
    #[test]
    fn a_broken_picture_is_reported_where_it_is_used() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("broken.png");
        std::fs::write(&path, [0x89, b'P', b'N', b'G']).unwrap();
        let specs: Vec<SpectrumTextureSpec> = (0..4)
            .map(|start| {
                TextureSpec::Imagemap(ImagemapSpec {
                    file: Some(named(&path, start)),
                    ..imagemap(&path, PLAIN, false)
                })
            })
            .collect();
        for (users, expected) in [
            (&[][..], (0, false)),
            (&[2, 3], (2, true)),
            (&[0], (0, true)),
        ] {
            let mut usage = TextureUsage::new(0, specs.len());
            for &user in users {
                usage.spectrum(spectrum(user));
            }
            let (_, problems) = Textures::compile(&[], &specs, &usage, &Transform::IDENTITY);
            let [TextureProblem::Picture { span, used, .. }] = &problems[..] else {
                panic!("{problems:?}");
            };
            assert_eq!((span.start, *used), expected, "{users:?}");
        }
    }

    #[test]
    fn long_chains_and_wrong_references_are_refused() {
        let link = |i: u32| {
            TextureSpec::Scale(Scale {
                tex1: float(i),
                tex2: FloatInput::Constant(1.0),
            })
        };
        let mut f: Vec<FloatTextureSpec> = vec![TextureSpec::Constant(Constant { value: 1.0 })];
        f.extend((0..100_000).map(link));
        let (textures, problems) = compile(&f, &[]);
        // The chain starts afresh from each refused link.
        assert!(matches!(
            problems[0],
            TextureProblem::TooDeep {
                kind: "float",
                index: 256
            }
        ));
        assert_eq!(textures.float(&float(255), &at(0.0, 0.0)), 1.0);
        assert_eq!(textures.float(&float(100_000), &at(0.0, 0.0)), 0.5);

        let (textures, problems) = compile(&[link(0), link(5)], &[]);
        assert_eq!(problems.len(), 2);
        assert!(
            problems
                .iter()
                .all(|p| matches!(p, TextureProblem::NotYetDeclared { .. }))
        );
        assert_eq!(textures.float(&float(0), &at(0.0, 0.0)), 0.5);
        assert_eq!(textures.float(&float(77), &at(0.0, 0.0)), 0.0);
    }
}
