//! The look-ups.

use super::param_use::ParamUse;
use super::v2::{self, Row};
use super::{Dialect, SpectrumFiles, TextureNames, spectrum};
use crate::files::FileProblem;
use crate::math::{DVec3, Rgb};
use crate::syntax::{
    Diagnostic, Diagnostics, Name, Param, ParamGroup, ParamList, ParamValue, SearchFolder, Span,
    suggest,
};
use std::path::PathBuf;
use std::rc::Rc;

/// What all look-ups at one place of a scene share.
#[derive(Clone, Copy, Debug)]
pub struct ParamContext<'a> {
    /// Where file names start: the folder of the main scene file.
    pub search: &'a SearchFolder,
    /// Whose defaults apply.
    pub dialect: Dialect,
    /// Where problems go.
    pub diagnostics: &'a Diagnostics,
    /// The `.spd` files read so far.
    pub spectra: &'a SpectrumFiles,
    /// The textures in scope.
    pub textures: &'a TextureNames,
}

/// Typed look-ups in the parameters of one directive. Look-ups take `&self`; every name asked for
/// counts as used, wrong types and counts are reported to the diagnostics as they are met.
///
/// A reader has one list of parameters or two: a shape's parameters override those of its
/// material, see [`ParamReader::layered`].
#[derive(Debug)]
pub struct ParamReader<'a> {
    pub(super) context: ParamContext<'a>,
    /// `Shape`
    pub(super) word: &'static str,
    /// Of the word.
    span: Span,
    kind: &'a str,
    pub(super) kind_span: Span,
    /// The directive's parameters.
    pub(super) own: &'a ParamList,
    /// Those that count where the directive has none of the name.
    below: &'a ParamList,
    /// What pbrt-v2 reads otherwise.
    pub(super) rows: &'static [Row],
    pub(super) asked: Rc<ParamUse>,
}

impl<'a> ParamReader<'a> {
    /// A reader for the parameters of the directive `word` at `span`.
    pub fn new(
        context: &ParamContext<'a>,
        word: &'static str,
        span: Span,
        kind: &'a Name,
        params: &'a ParamList,
    ) -> Self {
        Self {
            context: *context,
            word,
            span,
            kind: &kind.text,
            kind_span: kind.span,
            own: params,
            below: const { &ParamList::EMPTY },
            rows: v2::rows(word),
            asked: Rc::default(),
        }
    }

    /// These parameters first, then those of `below`: a material of type `kind` as overridden by
    /// the parameters of a shape (docs/scene-language.md §2.4). Look-ups count for `self`.
    pub fn layered(&self, kind: &'a str, below: &'a ParamList) -> Self {
        Self {
            kind,
            below,
            rows: v2::rows("Material"),
            asked: Rc::clone(&self.asked),
            ..*self
        }
    }

    /// The directive's type string: `sphere` in `Shape "sphere"`.
    pub fn kind(&self) -> &'a str {
        self.kind
    }

    /// The directive's word: `Shape`.
    pub fn word(&self) -> &'static str {
        self.word
    }

    /// Where the directive's word stands.
    pub fn span(&self) -> Span {
        self.span
    }

    /// Where the directive's type string stands.
    pub fn kind_span(&self) -> Span {
        self.kind_span
    }

    /// Whose defaults apply.
    pub fn dialect(&self) -> Dialect {
        self.context.dialect
    }

    /// Returns `true` if a parameter of this name was given, whatever its type. Does not count as a use.
    pub fn has(&self, name: &str) -> bool {
        self.layers().any(|layer| layer.named(name).is_some())
    }

    pub(super) fn layers(&self) -> impl Iterator<Item = &'a ParamList> + use<'a> {
        [self.own, self.below].into_iter()
    }

    /// The parameter that counts in one layer; it and the ones it replaces are used by this.
    pub(super) fn in_layer(
        &self,
        layer: &'a ParamList,
        name: &str,
        group: ParamGroup,
    ) -> Option<&'a Param> {
        let mut found = None;
        for param in &layer.params {
            if param.ty.group() == group && param.name == name {
                param.used.set(true);
                found = Some(param);
            }
        }
        found
    }

    fn find(&self, name: &str, group: ParamGroup) -> Option<&'a Param> {
        if !self.offers(name) {
            return None;
        }
        self.asked.record(name, group);
        let [own, below] = [self.own, self.below].map(|layer| self.in_layer(layer, name, group));
        own.or(below)
    }

    /// The numbers of a parameter that should have one value, `items` of them.
    fn one_value(&self, name: &str, group: ParamGroup, items: usize) -> Option<&'a [f64]> {
        let param = self.find(name, group)?;
        let ParamValue::Numbers(numbers) = &param.value else {
            return None;
        };
        self.check_finite(param, numbers);
        self.is_single(param, numbers.len() / items)
            .then_some(numbers)
    }

    /// Reports a parameter with several values, or none, where one is wanted.
    pub(super) fn is_single(&self, param: &Param, values: usize) -> bool {
        if values == 1 {
            return true;
        }
        let (ty, name) = (param.ty.word(), &param.name);
        self.context.diagnostics.push(
            Diagnostic::warning(format!(
                "`{ty} {name}` takes one value, found {values}; it is ignored"
            ))
            .at(param.value_span)
            .label("ignored as a whole, as pbrt-v3 does"),
        );
        false
    }

    fn numbers(&self, name: &str, group: ParamGroup) -> Option<&'a [f64]> {
        let param = self.find(name, group)?;
        match &param.value {
            ParamValue::Numbers(numbers) => {
                self.check_finite(param, numbers);
                Some(numbers)
            }
            ParamValue::Strings(_) | ParamValue::Bools(_) => None,
        }
    }

    /// Reports what has no place in single precision among points, directions and colors.
    pub(super) fn check_finite(&self, param: &Param, numbers: &[f64]) {
        let may_be_infinite = matches!(param.ty.group(), ParamGroup::Float | ParamGroup::Integer);
        let outside = |x: &f64| !(*x as f32).is_finite();
        let position = || numbers.iter().position(outside);
        if !may_be_infinite
            && let Some((item, number)) = position().and_then(|i| Some((i, numbers.get(i)?)))
        {
            let (ty, name) = (param.ty.word(), &param.name);
            let message = format!("`{ty} {name}` needs finite numbers, found {number:e}");
            let error = self.new_error(message).at_item(param.value_span, item);
            self.context.diagnostics.push(error);
        }
    }

    /// One number of type `float`.
    pub fn find_float(&self, name: &str) -> Option<f64> {
        self.one_value(name, ParamGroup::Float, 1)?.first().copied()
    }

    /// One number of type `float`, or the default.
    pub fn float(&self, name: &str, default: f64) -> f64 {
        let usual = || self.default_of(name, default);
        self.find_float(name).unwrap_or_else(usual)
    }

    /// One number of type `integer`. A fraction is cut off, as in pbrt-v3, but with a warning;
    /// what is beyond the range of `i64` becomes the nearest end of it.
    pub fn find_integer(&self, name: &str) -> Option<i64> {
        let number = *self.one_value(name, ParamGroup::Integer, 1)?.first()?;
        if number != number.trunc() {
            self.warn(
                name,
                format!(
                    "`integer {name}` is not a whole number: {} is used",
                    number.trunc()
                ),
            );
        }
        Some(number as i64)
    }

    /// One number of type `integer`, or the default.
    pub fn integer(&self, name: &str, default: i64) -> i64 {
        let usual = || self.default_of(name, default as f64) as i64;
        self.find_integer(name).unwrap_or_else(usual)
    }

    /// One `bool`.
    pub fn find_boolean(&self, name: &str) -> Option<bool> {
        let param = self.find(name, ParamGroup::Bool)?;
        let ParamValue::Bools(values) = &param.value else {
            return None;
        };
        self.is_single(param, values.len())
            .then(|| values.first().copied())
            .flatten()
    }

    /// One `bool`, or the default.
    pub fn boolean(&self, name: &str, default: bool) -> bool {
        self.find_boolean(name).unwrap_or(default)
    }

    fn find_name(&self, name: &str) -> Option<&'a Name> {
        let param = self.find(name, ParamGroup::String)?;
        let ParamValue::Strings(values) = &param.value else {
            return None;
        };
        self.is_single(param, values.len())
            .then(|| values.first())
            .flatten()
    }

    /// One `string`.
    pub fn find_string(&self, name: &str) -> Option<&'a str> {
        self.find_name(name).map(|string| string.text.as_str())
    }

    /// One `string`, or the default.
    pub fn string(&self, name: &str, default: &'static str) -> &'a str {
        self.find_string(name).unwrap_or(default)
    }

    /// All strings of a `string` parameter.
    pub fn strings(&self, name: &str) -> Option<&'a [Name]> {
        match &self.find(name, ParamGroup::String)?.value {
            ParamValue::Strings(values) => Some(values),
            ParamValue::Numbers(_) | ParamValue::Bools(_) => None,
        }
    }

    /// A string out of `choices`, the first of which is the default and what replaces any other
    /// word, as in pbrt-v3; such a word is warned of, with "did you mean".
    pub fn one_of(&self, name: &str, choices: &[&'static str]) -> &'static str {
        let default = choices.first().copied().unwrap_or_default();
        let Some(given) = self.find_name(name) else {
            return default;
        };
        if let Some(choice) = choices.iter().find(|choice| **choice == given.text) {
            return choice;
        }
        let quoted: Vec<String> = choices
            .iter()
            .map(|choice| format!("\"{choice}\""))
            .collect();
        self.context.diagnostics.push(
            Diagnostic::warning(format!(
                "`{name}` is one of {}, found \"{}\"",
                quoted.join(", "),
                given.text
            ))
            .at(given.span)
            .label(format!("\"{default}\" is used instead"))
            .with_suggestion(suggest::nearest(&given.text, choices.iter().copied())),
        );
        default
    }

    /// All numbers of a `float` parameter.
    pub fn floats(&self, name: &str) -> Option<&'a [f64]> {
        self.numbers(name, ParamGroup::Float)
    }

    /// All numbers of an `integer` parameter, as written: truncation is the caller's, the warning
    /// about fractions is given here.
    pub fn integers(&self, name: &str) -> Option<&'a [f64]> {
        let numbers = self.numbers(name, ParamGroup::Integer)?;
        if let Some(item) = numbers.iter().position(|x| *x != x.trunc()) {
            let number = numbers.get(item).copied().unwrap_or_default();
            let used = number.trunc();
            self.warn_item(
                name,
                item,
                format!("`integer {name}` holds {number}, not a whole number: {used} is used"),
            );
        }
        Some(numbers)
    }

    /// Flat x y z triples of a `point3`/`point` parameter.
    pub fn points3(&self, name: &str) -> Option<&'a [f64]> {
        self.numbers(name, ParamGroup::Point3)
    }

    /// Flat x y z triples of a `vector3`/`vector` parameter.
    pub fn vectors3(&self, name: &str) -> Option<&'a [f64]> {
        self.numbers(name, ParamGroup::Vector3)
    }

    /// Flat x y z triples of a `normal` parameter.
    pub fn normals(&self, name: &str) -> Option<&'a [f64]> {
        self.numbers(name, ParamGroup::Normal)
    }

    /// Flat pairs of a `point2` or a `float` parameter (`uv`); the former counts where both are
    /// given. A last number without a partner is dropped with a warning.
    pub fn points2(&self, name: &str) -> Option<&'a [f64]> {
        let points = self.numbers(name, ParamGroup::Point2);
        let floats = self.numbers(name, ParamGroup::Float);
        let numbers = points.or(floats)?;
        let (pairs, rest) = numbers.as_chunks::<2>();
        if !rest.is_empty() {
            self.warn_item(
                name,
                numbers.len() - 1,
                format!(
                    "`{name}` takes pairs, found {} numbers; the last one is ignored",
                    numbers.len()
                ),
            );
        }
        Some(pairs.as_flattened())
    }

    /// One `point3`/`point`.
    pub fn find_point3(&self, name: &str) -> Option<DVec3> {
        Some(DVec3::from_slice(
            self.one_value(name, ParamGroup::Point3, 3)?.get(..3)?,
        ))
    }

    /// One `point3`/`point`, or the default.
    pub fn point3(&self, name: &str, default: DVec3) -> DVec3 {
        self.find_point3(name).unwrap_or(default)
    }

    /// One `vector3`/`vector`.
    pub fn find_vector3(&self, name: &str) -> Option<DVec3> {
        Some(DVec3::from_slice(
            self.one_value(name, ParamGroup::Vector3, 3)?.get(..3)?,
        ))
    }

    /// One `vector3`/`vector`, or the default.
    pub fn vector3(&self, name: &str, default: DVec3) -> DVec3 {
        self.find_vector3(name).unwrap_or(default)
    }

    /// A constant spectrum: rgb/color, xyz, blackbody, spectrum (inline or .spd).
    pub fn find_spectrum(&self, name: &str) -> Option<Rgb> {
        let param = self.find(name, ParamGroup::Spectrum)?;
        match spectrum::first_value(self, param) {
            Some((rgb, values)) => self.is_single(param, values).then_some(rgb),
            None => self.is_single(param, 0).then_some(Rgb::ZERO),
        }
    }

    /// A constant spectrum, or the default.
    pub fn spectrum(&self, name: &str, default: Rgb) -> Rgb {
        self.find_spectrum(name).unwrap_or(default)
    }

    /// A `string` parameter naming a file, resolved against the search directory. `None` where it
    /// is not given, or where it names no regular file (then already reported as an error).
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        let given = self.find_name(name)?;
        self.context
            .search
            .regular(&given.text)
            .map_err(|problem| self.no_file(given, problem))
            .ok()
    }

    fn no_file(&self, given: &Name, problem: FileProblem) {
        let directory = self.context.search.directory.display().to_string();
        let place = if directory.is_empty() {
            "the working directory".to_owned()
        } else {
            format!("`{directory}`")
        };
        let what = format!("{} needs `{}`, and {problem}", self.described(), given.text);
        let diagnostic = Diagnostic::error(what).at(given.span).recoverable();
        let diagnostic = diagnostic.failed_if(problem.is_failure());
        self.context.diagnostics.push(match problem {
            FileProblem::Missing => diagnostic
                .label(format!("not found in {place}"))
                .missing(&given.text),
            FileProblem::Folder => diagnostic.label("the name of a file is needed"),
            FileProblem::NotRegular => {
                diagnostic.label("pipes and devices are not read: they may never end")
            }
            _ => diagnostic,
        });
    }

    /// Reports a warning under the parameter `name` (under the directive where it is not given).
    pub fn warn(&self, name: &str, message: impl Into<String>) {
        self.context
            .diagnostics
            .push(Diagnostic::warning(message).at(self.place(name)));
    }

    /// Reports an error under the parameter `name` (under the directive where it is not given).
    pub fn error(&self, name: &str, message: impl Into<String>) {
        self.context
            .diagnostics
            .push(self.new_error(message).at(self.place(name)));
    }

    /// As [`ParamReader::error`], of the file that the parameter names.
    pub fn file_error(&self, name: &str, message: impl Into<String>, is_failure: bool) {
        let error = self.new_error(message).failed_if(is_failure);
        self.context.diagnostics.push(error.at(self.place(name)));
    }

    /// As [`ParamReader::error`], of a parameter that pbrt-v3 reports and continues without.
    pub fn ignored(&self, name: &str, message: impl Into<String>) {
        let error = self.new_error(message).recoverable();
        self.context.diagnostics.push(error.at(self.place(name)));
    }

    /// As [`ParamReader::error`], with "did you mean" where there is a suggestion.
    pub fn error_with_suggestion(
        &self,
        name: &str,
        message: impl Into<String>,
        suggestion: Option<&str>,
    ) {
        let error = self.new_error(message).at(self.place(name));
        self.context
            .diagnostics
            .push(error.with_suggestion(suggestion));
    }

    /// An error of this directive. Without a light, a shape or a texture there is still an image; with
    /// a wrong camera or film there is none, or another one.
    pub(super) fn new_error(&self, message: impl Into<String>) -> Diagnostic {
        const OF_THE_PICTURE: [&str; 7] = [
            "Camera",
            "Film",
            "PixelFilter",
            "Sampler",
            "Integrator",
            "SurfaceIntegrator",
            "Renderer",
        ];
        let error = Diagnostic::error(message);
        if OF_THE_PICTURE.contains(&self.word) {
            error
        } else {
            error.recoverable()
        }
    }

    /// Where the parameter `name` is given; the directive where it is not.
    pub fn place(&self, name: &str) -> Span {
        let param = self.layers().find_map(|layer| layer.named(name));
        param.map_or(self.kind_span, |param| {
            param.declaration.to(param.value_span)
        })
    }
}
