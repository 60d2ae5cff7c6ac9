//! `ptex`.

mod axis;
mod kernel;
mod quads;
mod sum;
mod triangles;

use super::{Compiler, TextureClass, TextureValue, Textures};
use crate::assets::ptex::{MeshKind, PtexFile};
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec2};
use crate::params::{NamedFile, ParamReader};
use crate::surface::{Footprint, TexturePoint};

/// An image of its own for every face of a mesh, filtered across the faces' edges by a cubic B-spline
/// on quadrilaterals and by a Gaussian on triangles (Burley and Lacewell 2008, "Ptex: Per-Face Texture
/// Mapping for Production Rendering", EGSR; the rules at edges, corners and between sizes of faces are
/// those of its authors' library). The face is what the mesh says (`faceIndices`, or `face_indices` of
/// a PLY file), the place on it the surface's (u, v).
///
/// Parameters: string `filename`; float `gamma` 2.2: numbers between 0 and 1 are raised to that power
/// after filtering, others stay as they are. A float texture of a colored file is the mean of the
/// three results. A face that the file does not have, and all of a file that cannot be read, is black.
#[derive(Clone, Debug, PartialEq)]
pub struct Ptex {
    /// The file; `None` where none was given or found.
    pub file: Option<NamedFile>,
    /// Exponent.
    pub gamma: f32,
    /// Position of the file's contents, once it is prepared.
    index: Option<usize>,
}

impl<V: TextureValue> TextureClass<V> for Ptex {
    fn from_params(reader: &ParamReader, _ctm: &Transform) -> Ptex {
        if !reader.has("filename") {
            reader.error(
                "filename",
                "a ptex texture needs a \"string filename\": black is used",
            );
        }
        Ptex {
            file: reader.named_file("filename"),
            gamma: reader.float("gamma", 2.2) as f32,
            index: None,
        }
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.index = compiler.ptex(self.file.as_ref());
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        let Some(file) = self.index.and_then(|i| textures.ptex.get(i)?.as_ref()) else {
            return V::default();
        };
        let filtered = filtered(file, at.face, at.uv, &at.footprint);
        let decoded = filtered.to_array().map(|v| decode(v, self.gamma));
        match file.channels {
            1 => V::splat(decoded[0]),
            _ => V::from_ptex(decoded.into()),
        }
    }
}

/// A filtered number to the power `gamma`: what is beyond 0 and 1 is no encoded color, and stays.
fn decode(v: f32, gamma: f32) -> f32 {
    match gamma != 1.0 && (0.0..=1.0).contains(&v) {
        true => v.powf(gamma),
        false => v,
    }
}

// Apart, so that kernels take no room on the stack of textures of other classes, which call one another.
/// The filtered value at `uv` of face `face`; of a file with one channel the first number alone.
#[inline(never)]
fn filtered(file: &PtexFile, face: u32, uv: Vec2, footprint: &Footprint) -> Rgb {
    let Some(here) = file.face(face) else {
        return Rgb::ZERO;
    };
    // What is not a number is nowhere in particular. Footprints beyond some faces are as wide as can be.
    let number = |v: f32| if v.is_finite() { v } else { 0.0 };
    let widths = [footprint.duvdx, footprint.duvdy].map(|duv| {
        Vec2::new(number(duv.x), number(duv.y)).clamp(Vec2::splat(-WIDEST), Vec2::splat(WIDEST))
    });
    let uv = Vec2::new(number(uv.x), number(uv.y));
    if here.is_constant_around() {
        return sum::constant(file, here);
    }
    match file.mesh {
        MeshKind::Quads => quads::filtered(file, (face, here), uv, widths),
        MeshKind::Triangles => triangles::filtered(file, here, uv, widths),
    }
}

/// Widest footprint, in faces: filters reach one face far, and squares of it stay small numbers.
const WIDEST: f32 = 1e4;

#[cfg(test)]
mod tests;
