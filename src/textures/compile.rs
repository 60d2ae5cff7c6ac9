//! From texture descriptions to textures ready for look-ups.

use super::imagemap::ImageSettings;
use super::mipmap::Mipmap;
use super::nesting::NestedTexture;
use super::{Texture, TextureSpecs, TextureUsage, TextureValue};
use crate::assets::image_data::ImageData;
use crate::assets::ptex::PtexFile;
use crate::budget::Budget;
use crate::files::FileError;
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

/// A file that a texture cannot use. The scene renders without it: a gray of 0.5 stands in for an image, black for a
/// Ptex file.
#[derive(Debug)]
pub struct TextureProblem {
    /// What is wrong with it.
    pub error: FileError,
    /// Where it is named: by the first texture that something uses, if any.
    pub span: Span,
    /// `true` if anything uses a texture of this file.
    pub used: bool,
    /// `true` if the file is used as it is.
    pub is_usable: bool,
}

/// A file that textures need.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its place.
    pub path: PathBuf,
    /// `true` if it is a Ptex file.
    pub is_ptex: bool,
    /// Number of filtered images of floats.
    pub floats: usize,
    /// Number of filtered images of colors.
    pub spectra: usize,
}

impl Textures {
    /// Loads every image once (in parallel) and moves all mappings to render space.
    /// Images that `budget` has no memory for are problems.
    /// `usage` only tells problems that matter from those that do not.
    /// Problems come in the order of the textures that have them: first those of images, then of Ptex files.
    pub fn compile(
        specs: &TextureSpecs,
        usage: &TextureUsage,
        render_from_world: &Transform,
        budget: &Budget,
    ) -> (Textures, Vec<TextureProblem>) {
        let mut compiler = Compiler {
            render_from_world,
            used: false,
            images: Files::default(),
            ptex: Files::default(),
            maps: Vec::new(),
        };
        let (float, float_maps) = compiler.all(&specs.float, &usage.float);
        let (spectrum, spectrum_maps) = compiler.all(&specs.spectrum, &usage.spectrum);
        let mut problems = Vec::new();
        let (images, wanted) = (&compiler.images.list, [&*float_maps, &*spectrum_maps]);
        let (float_maps, spectrum_maps) = load_maps(images, wanted, &mut problems, budget);
        let ptex = load_ptex(&compiler.ptex.list, &mut problems, budget);
        let textures = Textures {
            float,
            spectrum,
            float_maps,
            spectrum_maps,
            ptex,
        };
        (textures, problems)
    }

    /// The files that textures need, each once, with the number of filtered images that are made of it.
    pub fn wanted(specs: &TextureSpecs) -> Vec<Wanted> {
        let mut compiler = Compiler {
            render_from_world: &Transform::IDENTITY,
            used: false,
            images: Files::default(),
            ptex: Files::default(),
            maps: Vec::new(),
        };
        let (_, floats) = compiler.all(&specs.float, &[]);
        let (_, spectra) = compiler.all(&specs.spectrum, &[]);
        let count = |maps: &[PendingMap], i| maps.iter().filter(|m| m.file == Some(i)).count();
        let images = { compiler.images.list.iter().enumerate() }.map(|(i, file)| Wanted {
            path: file.name.path.clone(),
            is_ptex: false,
            floats: count(&floats, i),
            spectra: count(&spectra, i),
        });
        let ptex = compiler.ptex.list.iter().map(|file| Wanted {
            path: file.name.path.clone(),
            is_ptex: true,
            floats: 0,
            spectra: 0,
        });
        images.chain(ptex).collect()
    }

    /// Returns `true` if any texture asks which face of a mesh a point is on. Where none does, meshes need not know.
    pub fn need_faces(&self) -> bool {
        !self.ptex.is_empty()
    }

    /// Returns `true` if any texture uses ray differentials. Where none does, cameras need not make them.
    pub fn needs_footprint(&self) -> bool {
        self.float.iter().any(Texture::needs_footprint)
            || self.spectrum.iter().any(Texture::needs_footprint)
    }
}

/// What a texture is compiled with, and the images and Ptex files that are asked for.
pub(super) struct Compiler<'a> {
    pub(super) render_from_world: &'a Transform,
    /// `true` if anything uses the texture.
    used: bool,
    images: Files,
    ptex: Files,
    /// Of one kind of textures.
    maps: Vec<PendingMap>,
}

impl Compiler<'_> {
    /// Where the filtered image of `file` will be; that of a gray texel without one.
    pub(super) fn map(&mut self, file: Option<&NamedFile>, settings: ImageSettings) -> usize {
        let file = self.images.index(file, self.used);
        position_or_push(&mut self.maps, PendingMap { file, settings })
    }

    /// Where the Ptex file will be.
    pub(super) fn ptex(&mut self, file: Option<&NamedFile>) -> Option<usize> {
        self.ptex.index(file, self.used)
    }

    /// All textures of a kind, and the filtered images that they want.
    fn all<V: TextureValue>(
        &mut self,
        textures: &[NestedTexture<V>],
        used: &[bool],
    ) -> (Vec<Texture<V>>, Vec<PendingMap>) {
        let compile = |(index, texture): (usize, &NestedTexture<V>)| {
            self.used = used.get(index) == Some(&true);
            let mut texture = texture.spec.clone();
            texture.prepare(self);
            texture
        };
        let textures = textures.iter().enumerate().map(compile).collect();
        (textures, std::mem::take(&mut self.maps))
    }
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

impl PendingFile {
    fn problem(&self, error: FileError) -> TextureProblem {
        TextureProblem {
            error,
            span: self.name.span,
            used: self.used,
            is_usable: false,
        }
    }

    /// What is odd about an image.
    fn oddity(&self, image: &ImageData) -> Option<TextureProblem> {
        let odd = image.texels().iter().filter(|texel| !texel.is_finite());
        let are = match odd.count() {
            0 => return None,
            1 => "1 texel is".to_string(),
            count => format!("{count} texels are"),
        };
        let name = self.name.path.display();
        let message = format!("'{name}': {are} not finite, nor is what is filtered with them");
        Some(TextureProblem {
            is_usable: true,
            ..self.problem(FileError::from(message))
        })
    }
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

/// All Ptex files.
fn load_ptex(
    files: &[PendingFile],
    problems: &mut Vec<TextureProblem>,
    budget: &Budget,
) -> Vec<Option<PtexFile>> {
    let loaded = files
        .par_iter()
        .map(|file| PtexFile::load(&file.name.path, budget).map_err(|error| file.problem(error)));
    let loaded: Vec<_> = loaded.collect();
    let mut usable = |result: Result<PtexFile, _>| result.map_err(|p| problems.push(p)).ok();
    loaded.into_iter().map(&mut usable).collect()
}

/// All filtered images, of floats and of spectra. Each file's image is let go once its maps are made.
fn load_maps(
    files: &[PendingFile],
    [float, spectrum]: [&[PendingMap]; 2],
    problems: &mut Vec<TextureProblem>,
    budget: &Budget,
) -> (Vec<Mipmap<f32>>, Vec<Mipmap<Rgb>>) {
    let loaded = files.par_iter().enumerate().map(|(i, file)| {
        let image = ImageData::load(&file.name.path, budget);
        let (i, usable) = (Some(i), image.as_ref().ok());
        let maps = (maps(i, float, usable), maps(i, spectrum, usable));
        let problem = match &image {
            Ok(image) => file.oddity(image),
            Err(error) => Some(file.problem(error.clone())),
        };
        (maps, problem)
    });
    let mut loaded: Vec<_> = loaded.collect();
    loaded.push(((maps(None, float, None), maps(None, spectrum, None)), None));
    let (mut float, mut spectrum) = (Vec::new(), Vec::new());
    for ((floats, spectra), problem) in loaded {
        float.extend(floats);
        spectrum.extend(spectra);
        problems.extend(problem);
    }
    (in_order(float), in_order(spectrum))
}

/// The maps wanted of one file, each with its position.
fn maps<V: TextureValue>(
    file: Option<usize>,
    wanted: &[PendingMap],
    image: Option<&ImageData>,
) -> Vec<(usize, Mipmap<V>)> {
    let wanted = wanted.iter().enumerate();
    let of_file = wanted.filter(|(_, map)| map.file == file);
    of_file
        .map(|(i, map)| (i, map.settings.mipmap(image)))
        .collect()
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
