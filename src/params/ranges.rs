//! Numbers that mean something in a range only.

use super::ParamReader;
use crate::syntax::Diagnostic;
use std::ops::RangeInclusive;

impl ParamReader<'_> {
    /// One number of type `integer`, or the default; what lies outside `range` is warned of, and
    /// the nearer end of the range is used.
    pub fn integer_within(&self, name: &str, default: i64, range: RangeInclusive<i64>) -> i64 {
        let usual = || self.default_of(name, default as f64) as i64;
        self.find_integer_within(name, range).unwrap_or_else(usual)
    }

    /// As [`ParamReader::integer_within`]; `None` where there is none.
    pub fn find_integer_within(&self, name: &str, range: RangeInclusive<i64>) -> Option<i64> {
        let given = self.find_integer(name)?;
        let used = given.clamp(*range.start(), *range.end());
        if used != given {
            let side = if given < used { "below" } else { "above" };
            self.warn(
                name,
                format!("`{name}` is {given}, {side} {used}: {used} is used"),
            );
        }
        Some(used)
    }

    /// Reports a warning under one number, counted from 0, of the parameter `name`.
    pub fn warn_item(&self, name: &str, item: usize, message: impl Into<String>) {
        let warning = Diagnostic::warning(message);
        self.context
            .diagnostics
            .push(self.under_item(warning, name, item));
    }

    /// Reports an error under one number, counted from 0, of the parameter `name`.
    pub fn error_item(&self, name: &str, item: usize, message: impl Into<String>) {
        let error = self.new_error(message);
        self.context
            .diagnostics
            .push(self.under_item(error, name, item));
    }

    fn under_item(&self, diagnostic: Diagnostic, name: &str, item: usize) -> Diagnostic {
        match self.layers().find_map(|layer| layer.named(name)) {
            Some(param) => diagnostic.at_item(param.value_span, item),
            None => diagnostic.at(self.kind_span),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::params::testing::read;

    #[test]
    fn what_is_out_of_range_is_moved_to_its_end_with_a_warning() {
        for (given, used, warnings) in [(-1, 0, 1), (0, 0, 0), (7, 7, 0), (8, 7, 1)] {
            let outcome = read("path", &format!("\"integer x\" {given}"), |p| {
                p.integer_within("x", 3, 0..=7)
            });
            assert_eq!((outcome.value, outcome.warnings), (used, warnings));
        }
        let outcome = read("path", "", |p| p.integer_within("x", 3, 0..=7));
        assert_eq!((outcome.value, outcome.warnings), (3, 0));
    }

    #[test]
    fn the_caret_stands_under_the_item() {
        let params = "\"integer x\" [ 10 11 # a comment\n 12 ]";
        let outcome = read("path", params, |p| p.warn_item("x", 2, "twelve"));
        assert!(outcome.text.contains("test.pbrt:2:2"), "{}", outcome.text);
        let outcome = read("path", params, |p| p.error_item("x", 0, "ten"));
        assert!(outcome.text.contains("test.pbrt:1:28"), "{}", outcome.text);
        // Without brackets, and beyond the last.
        for item in [0, 1] {
            let outcome = read("path", "\"integer x\" 10", |p| {
                p.warn_item("x", item, "odd")
            });
            assert!(outcome.text.contains("test.pbrt:1:26"), "{}", outcome.text);
        }
    }
}
