//! The context for reading parameters at one point of the file.

use super::options::StoredDirective;
use crate::params::{Dialect, ParamContext, ParamReader, SpectrumFiles, TextureNames};
use crate::syntax::{Diagnostics, FileId, Name, ParamList, SearchFolder, Span, Typed};

/// Creates parameter readers for directives.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    context: ParamContext<'a>,
}

impl<'a> Reading<'a> {
    /// A context in which file names are looked up by `search`, with the textures in scope.
    pub fn new(
        search: &'a SearchFolder,
        dialect: Dialect,
        diagnostics: &'a Diagnostics,
        spectra: &'a SpectrumFiles,
        textures: &'a TextureNames,
    ) -> Reading<'a> {
        Reading {
            context: ParamContext {
                search,
                dialect,
                diagnostics,
                spectra,
                textures,
            },
        }
    }

    /// The dialect whose defaults apply.
    pub fn dialect(&self) -> Dialect {
        self.context.dialect
    }

    /// The collector of diagnostics.
    pub fn diagnostics(&self) -> &'a Diagnostics {
        self.context.diagnostics
    }

    /// Reads a directive and reports its unused parameters.
    pub fn read<R>(
        &self,
        word: &'static str,
        span: Span,
        typed: &Typed,
        f: impl FnOnce(&ParamReader) -> R,
    ) -> R {
        let reader = ParamReader::new(&self.context, word, span, &typed.kind, &typed.params);
        let result = f(&reader);
        reader.finish();
        result
    }

    /// Reads something of a stored directive that is read again.
    pub fn look<R>(&self, stored: &StoredDirective, f: impl FnOnce(&ParamReader) -> R) -> R {
        let Typed { kind, params } = &stored.typed;
        let (word, span) = (stored.word, stored.span);
        f(&ParamReader::new(&self.context, word, span, kind, params))
    }

    /// Reads a stored directive.
    pub fn read_stored<R>(&self, stored: &StoredDirective, f: impl FnOnce(&ParamReader) -> R) -> R {
        self.read(stored.word, stored.span, &stored.typed, f)
    }

    /// The defaults of a directive of this type.
    pub fn defaults<R>(
        &self,
        word: &'static str,
        kind: &str,
        f: impl FnOnce(&ParamReader) -> R,
    ) -> R {
        let nowhere = Span {
            file: FileId(0),
            start: 0,
            end: 0,
        };
        let name = Name {
            text: kind.to_string(),
            span: nowhere,
        };
        f(&ParamReader::new(
            &self.context,
            word,
            nowhere,
            &name,
            &ParamList::EMPTY,
        ))
    }

    /// Reads a directive, or the defaults of `kind` if it was not given.
    pub fn read_or<R>(
        &self,
        word: &'static str,
        given: Option<&StoredDirective>,
        kind: &str,
        f: impl FnOnce(&ParamReader) -> R,
    ) -> R {
        match given {
            Some(stored) => self.read_stored(stored, f),
            None => self.defaults(word, kind, f),
        }
    }
}
