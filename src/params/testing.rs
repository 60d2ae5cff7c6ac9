//! For the unit tests of other rooms: parameters from a string.

use super::{Dialect, ParamContext, ParamReader, SpectrumFiles, TextureNames};
use crate::syntax::{Diagnostics, DirectiveKind, Parser, SearchFolder, SourceMap, Style};

/// What reading gave.
#[derive(Debug)]
pub struct Outcome<T> {
    /// The closure's result.
    pub value: T,
    /// Errors reported.
    pub errors: usize,
    /// Warnings reported, unused parameters included.
    pub warnings: usize,
    /// All messages, without their excerpts.
    pub messages: Vec<String>,
    /// All messages as they would be printed.
    pub text: String,
}

/// What there is besides the parameters.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Where files are looked up.
    pub search: SearchFolder,
    /// Whose defaults apply.
    pub dialect: Dialect,
    /// The directive that is read.
    pub word: &'static str,
    /// The textures in scope.
    pub textures: TextureNames,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            search: SearchFolder::default(),
            dialect: Dialect::V3,
            word: "Shape",
            textures: TextureNames::default(),
        }
    }
}

/// Hands `read` a reader for `kind` with the parameters as written in `params`:
///
/// ```ignore
/// let sphere = testing::read("sphere", r#""float radius" 2"#, |params| Sphere::from_params(params));
/// assert!(sphere.messages.is_empty());
/// ```
pub fn read<T>(kind: &str, params: &str, read: impl FnOnce(&ParamReader<'_>) -> T) -> Outcome<T> {
    read_in(&Surroundings::default(), kind, params, read)
}

/// As [`read`], with textures, a search directory or the dialect of pbrt-v2.
pub fn read_in<T>(
    surroundings: &Surroundings,
    kind: &str,
    params: &str,
    read: impl FnOnce(&ParamReader<'_>) -> T,
) -> Outcome<T> {
    let (mut value, mut read) = (None, Some(read));
    let said = said_in(surroundings, kind, params, &mut |params| {
        value = read.take().map(|read| read(params));
    });
    Outcome {
        value: value.expect("said_in has called it"),
        errors: said.errors,
        warnings: said.warnings,
        messages: said.messages,
        text: said.text,
    }
}

/// What does not depend on `T`: compiled once, not for every test.
fn said_in(
    surroundings: &Surroundings,
    kind: &str,
    params: &str,
    read: &mut dyn FnMut(&ParamReader<'_>),
) -> Outcome<()> {
    let (sources, diagnostics, spectra) =
        (SourceMap::new(), Diagnostics::new(), SpectrumFiles::new());
    let file = sources.add_text("test.pbrt", format!("Shape \"{kind}\" {params}\n"));
    let directive = Parser::new(&sources, file, &diagnostics)
        .next()
        .expect("a directive");
    let DirectiveKind::Shape(shape) = &directive.kind else {
        panic!("more than one directive")
    };
    let context = ParamContext {
        search: &surroundings.search,
        dialect: surroundings.dialect,
        diagnostics: &diagnostics,
        spectra: &spectra,
        textures: &surroundings.textures,
    };
    let reader = ParamReader::new(
        &context,
        surroundings.word,
        directive.span,
        &shape.kind,
        &shape.params,
    );
    read(&reader);
    reader.finish();
    Outcome {
        value: (),
        errors: diagnostics.errors(),
        warnings: diagnostics.warnings(),
        messages: diagnostics.kept().into_iter().map(|d| d.message).collect(),
        text: diagnostics.render(&sources, Style::Plain),
    }
}
