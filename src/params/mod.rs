//! Reading a directive's parameters: typed look-ups with defaults, unused ones reported.
//! (Stub: the signatures are the contract; the bodies are being written.)

use crate::handles::{FloatTextureId, SpectrumTextureId};
use crate::math::{DVec3, Rgb};
use std::path::PathBuf;

/// A float that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// The same everywhere.
    Constant(f32),
    /// Looked up in a texture.
    Texture(FloatTextureId),
}

/// A colour or per-channel factor that may vary over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectrumInput {
    /// The same everywhere.
    Constant(Rgb),
    /// Looked up in a texture.
    Texture(SpectrumTextureId),
}

/// Whose defaults and meanings a file gets (scene-language appendix A).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// pbrt-v2, and the course kit built on it.
    V2,
    /// pbrt-v3.
    V3,
}

/// Typed look-ups in the parameters of one directive. Look-ups take `&self`; every name asked for
/// counts as used, wrong types and counts are reported to the diagnostics as they are met.
pub struct ParamReader<'a> {
    _a: std::marker::PhantomData<&'a ()>,
}

#[allow(unused_variables, clippy::todo)]
impl<'a> ParamReader<'a> {
    /// The directive's type string: `sphere` in `Shape "sphere"`.
    pub fn kind(&self) -> &str {
        todo!()
    }
    /// Whose defaults apply.
    pub fn dialect(&self) -> Dialect {
        todo!()
    }
    /// Was a parameter of this name given, whatever its type? Does not count as a use.
    pub fn has(&self, name: &str) -> bool {
        todo!()
    }
    pub fn find_float(&self, name: &str) -> Option<f64> {
        todo!()
    }
    pub fn float(&self, name: &str, default: f64) -> f64 {
        self.find_float(name).unwrap_or(default)
    }
    pub fn find_integer(&self, name: &str) -> Option<i64> {
        todo!()
    }
    pub fn integer(&self, name: &str, default: i64) -> i64 {
        self.find_integer(name).unwrap_or(default)
    }
    pub fn find_boolean(&self, name: &str) -> Option<bool> {
        todo!()
    }
    pub fn boolean(&self, name: &str, default: bool) -> bool {
        self.find_boolean(name).unwrap_or(default)
    }
    pub fn find_string(&self, name: &str) -> Option<&'a str> {
        todo!()
    }
    pub fn string(&self, name: &str, default: &'static str) -> &'a str {
        self.find_string(name).unwrap_or(default)
    }
    /// A string out of `choices` (first one is the default); any other is reported with
    /// "did you mean" and the default is used.
    pub fn choice(&self, name: &str, choices: &[&'static str]) -> &'static str {
        todo!()
    }
    /// All numbers of a `float` parameter.
    pub fn floats(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    /// All numbers of an `integer` parameter, as written (truncation is the caller's).
    pub fn integers(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    /// Flat x y z triples of a `point3`/`point` parameter.
    pub fn points3(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    /// Flat x y z triples of a `vector3`/`vector` parameter.
    pub fn vectors3(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    /// Flat x y z triples of a `normal` parameter.
    pub fn normals(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    /// Flat pairs of a `point2` or a `float` parameter (`uv`).
    pub fn points2(&self, name: &str) -> Option<&'a [f64]> {
        todo!()
    }
    pub fn find_point3(&self, name: &str) -> Option<DVec3> {
        todo!()
    }
    pub fn point3(&self, name: &str, default: DVec3) -> DVec3 {
        self.find_point3(name).unwrap_or(default)
    }
    pub fn find_vector3(&self, name: &str) -> Option<DVec3> {
        todo!()
    }
    pub fn vector3(&self, name: &str, default: DVec3) -> DVec3 {
        self.find_vector3(name).unwrap_or(default)
    }
    /// A constant spectrum: rgb/color, xyz, blackbody, spectrum (inline or .spd).
    pub fn find_spectrum(&self, name: &str) -> Option<Rgb> {
        todo!()
    }
    pub fn spectrum(&self, name: &str, default: Rgb) -> Rgb {
        self.find_spectrum(name).unwrap_or(default)
    }
    /// A float or a float texture.
    pub fn find_float_input(&self, name: &str) -> Option<FloatInput> {
        todo!()
    }
    pub fn float_input(&self, name: &str, default: f32) -> FloatInput {
        self.find_float_input(name).unwrap_or(FloatInput::Constant(default))
    }
    /// A spectrum or a spectrum texture.
    pub fn find_spectrum_input(&self, name: &str) -> Option<SpectrumInput> {
        todo!()
    }
    pub fn spectrum_input(&self, name: &str, default: Rgb) -> SpectrumInput {
        self.find_spectrum_input(name).unwrap_or(SpectrumInput::Constant(default))
    }
    /// A `string` parameter naming a file, resolved against the search directory. `None` where it
    /// is not given, or where no such file exists (then already reported as an error).
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        todo!()
    }
    /// Reports a warning under the parameter `name` (under the directive where it is not given).
    pub fn warn(&self, name: &str, message: impl Into<String>) {
        todo!()
    }
    /// Reports an error under the parameter `name` (under the directive where it is not given).
    pub fn error(&self, name: &str, message: impl Into<String>) {
        todo!()
    }
}
