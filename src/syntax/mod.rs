//! The pbrt-v3 scene language: bytes to directives, each with its location.
//!
//! ```text
//! source ──▶ lexer ──▶ parser ──▶ Directive { kind, span }
//! files      tokens    Include,   typed parameter lists
//!                      recovery
//!                 └──▶ diagnostic: what is wrong, where, and what was probably meant
//! ```
//!
//! Nothing here depends on rendering. The language is that of pbrt-v3 (Pharr, Jakob, Humphreys, *Physically Based
//! Rendering*, 3rd edition, and the pbrt-v3 input file format page), with the directives that only pbrt-v2 had. A file
//! that pbrt-v3 reads keeps its meaning; where pbrt-v3 would stop or silently drop something, this parser reports it
//! and continues, so that one run reports all problems of a file and of what it includes. The decisions are listed in
//! [`parser`].
//!
//! ```
//! use fstop::syntax::{Diagnostics, DirectiveKind, Parser, SourceMap};
//!
//! let sources = SourceMap::new();
//! let diagnostics = Diagnostics::new();
//! let file = sources.add_text("ball.pbrt", "Shape \"sphere\" \"float radius\" [ 2.5 ]");
//! let directives: Vec<_> = Parser::new(&sources, file, &diagnostics).collect();
//! assert!(diagnostics.is_empty());
//! match &directives[0].kind {
//!     DirectiveKind::Shape(shape) => assert_eq!(shape.kind.text, "sphere"),
//!     other => panic!("not a shape: {other:?}"),
//! }
//! ```

pub mod diagnostic;
pub mod directive;
mod excerpt;
mod files;
mod grammar;
mod groups;
pub mod lexer;
pub mod number;
pub mod parameter;
pub mod parser;
pub mod source;
pub mod suggest;
mod token;
mod value;

pub use diagnostic::{Diagnostic, Diagnostics, Severity, Style};
pub use directive::{ActiveTransform, Directive, DirectiveKind, Name, Typed};
pub use files::SearchFolder;
pub use parameter::{Param, ParamGroup, ParamList, ParamType, ParamValue};
pub use parser::Parser;
pub use source::{FileId, SourceError, SourceMap, Span};
