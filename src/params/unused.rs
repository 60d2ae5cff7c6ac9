//! Parameters nobody asked for.

use super::{Dialect, ParamReader, iset3d, v4};
use crate::syntax::{Diagnostic, Param, ParamGroup, suggest};

impl ParamReader<'_> {
    /// Warns about every parameter of the directive that nobody asked for. To be called once for
    /// each directive, after all its readers (those made with [`ParamReader::layered`] count as its
    /// own) have read what they need.
    pub fn finish(&self) {
        if self.own.params.iter().all(|param| param.used.get()) {
            return;
        }
        let names = self.asked.names();
        for param in self.own.params.iter().filter(|param| !param.used.get()) {
            self.context.diagnostics.push(self.unused(param, &names));
            // Reported once, even if the directive's parameters are read again later.
            param.used.set(true);
        }
    }

    fn unused(&self, param: &Param, asked: &[String]) -> Diagnostic {
        let known = self.asked.groups(&param.name);
        let name = &param.name;
        if known.contains(&param.ty.group()) {
            // Of the right type: then a texture of the same name was preferred.
            let ty = param.ty.word();
            return Diagnostic::warning(format!(
                "`{ty} {name}` is not used: `texture {name}` comes first"
            ))
            .at(param.declaration);
        }
        if !known.is_empty() {
            let expected: Vec<&str> = known.iter().map(|group| expected_type(*group)).collect();
            let expected = alternatives(&expected);
            let found = param.ty.word();
            return Diagnostic::warning(format!(
                "`{name}` should be {expected}, found `{found}`; it is not used"
            ))
            .at(param.declaration)
            .label(format!("expected {expected}"));
        }
        let message = format!("parameter `{name}` is not used by {}", self.described());
        let warning = Diagnostic::warning(message).at(param.declaration);
        let v4 = match self.dialect() {
            Dialect::V3 => v4::parameter(self.word, name, asked),
            Dialect::V2 => None,
        };
        match v4.or_else(|| iset3d::parameter(self.word, name).map(str::to_owned)) {
            Some(note) => warning.with_note(note),
            None => {
                warning.with_suggestion(suggest::nearest(name, asked.iter().map(String::as_str)))
            }
        }
    }

    /// `Shape "sphere"`.
    pub(super) fn described(&self) -> String {
        format!("`{} \"{}\"`", self.word, self.kind())
    }
}

fn expected_type(group: ParamGroup) -> &'static str {
    match group {
        ParamGroup::Integer => "an `integer`",
        ParamGroup::Float => "a `float`",
        ParamGroup::Bool => "a `bool`",
        ParamGroup::String => "a `string`",
        ParamGroup::Texture => "a `texture`",
        ParamGroup::Point2 => "a `point2`",
        ParamGroup::Vector2 => "a `vector2`",
        ParamGroup::Point3 => "a `point3`",
        ParamGroup::Vector3 => "a `vector3`",
        ParamGroup::Normal => "a `normal`",
        ParamGroup::Spectrum => "a spectrum such as `rgb`",
    }
}

/// `a, b or c`.
fn alternatives(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}
