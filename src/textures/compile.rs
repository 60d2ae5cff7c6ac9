//! From texture descriptions to textures ready for look-ups.

use super::imagemap::ImageSettings;
use super::mipmap::Mipmap;
use super::{
    Constant, FloatTextureSpec, MAX_DEPTH, SpectrumTextureSpec, Texture, TextureSpec, TextureUsage,
    TextureValue,
};
use crate::assets::image_data::{ImageData, ImageFileError};
use crate::assets::ptex::PtexFile;
use crate::budget::Budget;
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
    /// `None` for those that cannot be used.
    pub(super) ptex: Vec<Option<PtexFile>>,
}

/// What went wrong with a texture; the scene renders without it.
#[derive(Debug, thiserror::Error)]
pub enum TextureProblem {
    /// An image cannot be used; a gray of 0.5 stands in for it.
    #[error("{error}: a gray of 0.5 is used")]
    ImageData {
        /// What is wrong with it.
        error: ImageFileError,
        /// Where it is named: by the first texture that something uses, if any.
        span: Span,
        /// Does anything use a texture of this image?
        used: bool,
    },
    /// A Ptex file cannot be used; black stands in for it.
    #[error("{error}: black is used")]
    Ptex {
        /// What is wrong with it.
        error: ImageFileError,
        /// Where it is named: by the first texture that something uses, if any.
        span: Span,
        /// Does anything use a texture of this file?
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
    /// Loads every image once (in parallel) and moves all mappings to render space.
    /// `float[i]` is the texture of `FloatTextureId(i)`, `spectrum[i]` of `SpectrumTextureId(i)`.
    /// Images that `budget` has no memory for are problems.
    /// `usage` only tells problems that matter from those that do not.
    /// Problems come in the order of the textures that have them: first those of nesting, then of images,
    /// then of Ptex files.
    pub fn compile(
        float: &[FloatTextureSpec],
        spectrum: &[SpectrumTextureSpec],
        usage: &TextureUsage,
        render_from_world: &Transform,
        budget: &Budget,
    ) -> (Textures, Vec<TextureProblem>) {
        let mut problems = Vec::new();
        let mut wanted = MapRequest::default();
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
        (textures.float_maps, textures.spectrum_maps) = wanted.load_maps(&mut problems, budget);
        textures.ptex = wanted.load_ptex(&mut problems, budget);
        (textures, problems)
    }

    /// Does any texture ask which face of a mesh a point is on? Where none does, meshes need not know.
    pub fn need_faces(&self) -> bool {
        !self.ptex.is_empty()
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
    wanted: &mut MapRequest,
    list: fn(&mut MapRequest) -> &mut Vec<PendingMap>,
) -> Vec<Texture<V>> {
    let compile = |(index, (spec, depth)): (usize, (&TextureSpec<V>, &Option<usize>))| match depth {
        None => Texture::Constant(Constant {
            value: V::splat(0.5),
        }),
        Some(_) => spec.compile(&mut Compiler {
            render_from_world,
            used: used.get(index) == Some(&true),
            wanted,
            list,
        }),
    };
    specs.iter().zip(depths).enumerate().map(compile).collect()
}

/// What a texture is compiled with.
pub(super) struct Compiler<'a> {
    pub(super) render_from_world: &'a Transform,
    /// Does anything use the texture?
    used: bool,
    wanted: &'a mut MapRequest,
    /// The maps for values of its kind.
    list: fn(&mut MapRequest) -> &mut Vec<PendingMap>,
}

impl Compiler<'_> {
    /// Where the filtered image of `file` will be; that of a gray texel without one.
    pub(super) fn map(&mut self, file: Option<&NamedFile>, settings: ImageSettings) -> usize {
        let file = self.wanted.images.index(file, self.used);
        position_or_push((self.list)(self.wanted), PendingMap { file, settings })
    }

    /// Where the Ptex file will be.
    pub(super) fn ptex(&mut self, file: Option<&NamedFile>) -> Option<usize> {
        self.wanted.ptex.index(file, self.used)
    }
}

/// The images and Ptex files a scene's textures ask for.
#[derive(Default)]
struct MapRequest {
    images: Files,
    ptex: Files,
    float: Vec<PendingMap>,
    spectrum: Vec<PendingMap>,
}

/// Files, each once.
#[derive(Default)]
struct Files {
    list: Vec<PendingFile>,
    /// Positions in `list`.
    known: BTreeMap<PathBuf, usize>,
}

struct PendingFile {
    name: NamedFile,
    used: bool,
}

#[derive(Clone, Copy, PartialEq)]
struct PendingMap {
    /// Index into the files; `None` for the gray that stands in for a missing one.
    file: Option<usize>,
    settings: ImageSettings,
}

impl Files {
    fn index(&mut self, file: Option<&NamedFile>, used: bool) -> Option<usize> {
        let name = file?.clone();
        let next = self.list.len();
        let index = *self.known.entry(name.path.clone()).or_insert(next);
        match self.list.get_mut(index) {
            None => self.list.push(PendingFile { name, used }),
            Some(known) if used && !known.used => *known = PendingFile { name, used },
            Some(_) => {}
        }
        Some(index)
    }
}

impl MapRequest {
    /// All Ptex files.
    fn load_ptex(
        &self,
        problems: &mut Vec<TextureProblem>,
        budget: &Budget,
    ) -> Vec<Option<PtexFile>> {
        let files = self.ptex.list.par_iter();
        let loaded: Vec<_> = files
            .map(|file| PtexFile::load(&file.name.path, budget))
            .collect();
        let mut usable = |(file, result): (&PendingFile, Result<PtexFile, ImageFileError>)| {
            let problem = |error| TextureProblem::Ptex {
                error,
                span: file.name.span,
                used: file.used,
            };
            result.map_err(|error| problems.push(problem(error))).ok()
        };
        let files = self.ptex.list.iter().zip(loaded);
        files.map(&mut usable).collect()
    }

    /// All filtered images. Each file's image is let go once its maps are made.
    fn load_maps(
        &self,
        problems: &mut Vec<TextureProblem>,
        budget: &Budget,
    ) -> (Vec<Mipmap<f32>>, Vec<Mipmap<Rgb>>) {
        let files = self.images.list.par_iter().enumerate().map(|(i, file)| {
            let image = ImageData::load(&file.name.path, budget);
            let usable = image.as_ref().ok();
            (
                self.maps(Some(i), &self.float, usable),
                self.maps(Some(i), &self.spectrum, usable),
                image.err().map(|error| TextureProblem::ImageData {
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
        wanted: &[PendingMap],
        image: Option<&ImageData>,
    ) -> Vec<(usize, Mipmap<V>)> {
        let of_file = wanted
            .iter()
            .enumerate()
            .filter(|(_, map)| map.file == file);
        of_file
            .map(|(i, map)| (i, map.settings.mipmap(image)))
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
mod tests;
