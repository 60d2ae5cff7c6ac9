//! Reading a directive's parameters: typed look-ups with defaults, unused ones reported.
//!
//! A type's `from_params` gets a [`ParamReader`] and asks it for what it knows, by name and type.
//! What nobody asked for is reported by [`ParamReader::finish`], with what was probably meant.
//! The rules are pbrt-v3's (docs/scene-language.md §1.3 and §1.4): of several parameters with the same name
//! and group of types the last one counts; nothing is converted between groups; a parameter that
//! should have one value and has several is ignored as a whole.
//!
//! ```
//! use fstop::params::{Dialect, ParamContext, ParamReader, SpectrumFiles, TextureNames};
//! use fstop::syntax::{Diagnostics, DirectiveKind, Parser, SourceMap};
//!
//! let (sources, diagnostics) = (SourceMap::new(), Diagnostics::new());
//! let (spectra, textures) = (SpectrumFiles::new(), TextureNames::default());
//! let file = sources.add_text("ball.pbrt", "Shape \"sphere\" \"float radius\" 2 \"float heigth\" 3");
//! let mut parser = Parser::new(&sources, file, &diagnostics);
//! let directive = parser.next().unwrap();
//! let DirectiveKind::Shape(shape) = &directive.kind else { unreachable!() };
//!
//! let context = ParamContext {
//!     search: &sources.search_folder(file),
//!     dialect: Dialect::V3,
//!     diagnostics: &diagnostics,
//!     spectra: &spectra,
//!     textures: &textures,
//! };
//! let reader = ParamReader::new(&context, "Shape", directive.span, &shape.kind, &shape.params);
//! assert_eq!(reader.float("radius", 1.0), 2.0);
//! assert_eq!(reader.float("height", 1.0), 1.0);
//! reader.finish(); // "parameter `heigth` is not used: did you mean `height`?"
//! assert_eq!(diagnostics.warnings(), 1);
//! ```

mod accept;
mod inputs;
mod iset3d;
mod kinds;
mod layers;
mod named_file;
mod param_use;
mod ranges;
mod reader;
mod spectrum;
#[cfg(test)]
pub mod testing;
#[cfg(test)]
mod tests;
mod unused;
mod v2;
mod v4;

pub use layers::may_change_material;
pub use named_file::NamedFile;
pub use reader::{ParamContext, ParamReader};
pub use spectrum::SpectrumFiles;
#[cfg(any(test, feature = "internals"))]
pub use v2::{DIRECTIVES as V2_DIRECTIVES, V2, rows as v2_rows};

use crate::handles::{FloatTextureId, SpectrumTextureId};
use std::collections::HashMap;

/// Whose defaults and meanings a file gets (docs/scene-language.md §A).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// pbrt-v2, and the course kit built on it.
    V2,
    /// pbrt-v3.
    V3,
}

/// The textures in scope, by name; the two kinds have name spaces of their own.
#[derive(Clone, Debug, Default)]
pub struct TextureNames {
    /// Defined with the value type `float`.
    pub float: HashMap<String, FloatTextureId>,
    /// Defined with the value type `spectrum` or `color`.
    pub spectrum: HashMap<String, SpectrumTextureId>,
}
