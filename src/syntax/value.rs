//! Parses parameter lists: declarations and their values.

use super::diagnostic::Diagnostic;
use super::directive::Name;
use super::number::{number, plain_numbers};
use super::parameter::{Param, ParamList, ParamType, ParamValue};
use super::parser::{Abandoned, Parsed, Parser, directive_word};
use super::source::Span;
use super::suggest::nearest;
use super::token::{Token, TokenKind};
use std::cell::Cell;

/// The items after a declaration, before they are checked against its type.
#[derive(Debug, Default)]
struct Items {
    numbers: Vec<f64>,
    strings: Vec<Name>,
    bools: Vec<bool>,
    /// An item could not be parsed, and was reported.
    spoilt: bool,
    /// A number is unlikely to be what was intended, and was reported.
    doubtful: bool,
    /// Numbers are separated by commas, which was reported.
    has_commas: bool,
}

impl Parser<'_> {
    /// Parses everything up to the first token that is not a quoted string. Unusable parameters are reported and
    /// dropped; the rest of the list is still parsed.
    pub(super) fn parameters(&mut self) -> Parsed<ParamList> {
        let mut params = Vec::new();
        loop {
            let include = self.follow_includes()?;
            let next = self.peek().kind;
            if matches!(next, TokenKind::Quoted | TokenKind::Unterminated) {
                self.include_in_list = self.include_in_list.or(include);
            }
            match next {
                TokenKind::Quoted => {
                    let declaration = self.bump();
                    if let Some(param) = self.parameter(&declaration)? {
                        params.push(param);
                    }
                }
                TokenKind::Unterminated => {
                    let span = self.peek().span;
                    let error = Diagnostic::error("a string does not end on its line").at(span);
                    self.report(error.label("the closing quotation mark is missing"));
                    return Err(Abandoned);
                }
                _ => return Ok(ParamList { params }),
            }
        }
    }

    fn parameter(&mut self, declaration: &Token) -> Parsed<Option<Param>> {
        let declared = self.declaration(declaration);
        let include = self.follow_includes()?;
        self.include_in_list = self.include_in_list.or(include);
        if declared.is_none() && self.statement_ends() {
            // An invalid declaration has been reported; there is no value to skip.
            return Ok(None);
        }
        if let Some((ty, name)) = &declared
            && self.value_is_missing(*ty)
        {
            if self.peek().kind == TokenKind::Unterminated {
                // The caller that parses the list reports what is wrong with it.
                return Ok(None);
            }
            let next = self.peek().description();
            let message = format!("parameter `{name}` has no value, found {next}");
            let label = format!("expected {} behind this", expected_items(*ty));
            self.report(Diagnostic::error(message).at(declaration.span).label(label));
            return Ok(None);
        }
        let (items, value_span) = self.items()?;
        let Some((ty, name)) = declared else {
            return Ok(None);
        };
        let value = self.typed_value(ty, &name, items, value_span);
        let used = Cell::new(false);
        Ok(value.map(|value| Param {
            ty,
            name,
            value,
            declaration: declaration.span,
            value_span,
            used,
        }))
    }

    /// Parses type and name. pbrt-v3 ignores anything after the name.
    fn declaration(&self, token: &Token) -> Option<(ParamType, String)> {
        let Name { text, span } = self.quoted(token);
        let mut words = text.split([' ', '\t']).filter(|word| !word.is_empty());
        let (Some(ty), Some(name)) = (words.next(), words.next()) else {
            let message = format!("expected a parameter's type and name, found \"{text}\"");
            let error = Diagnostic::error(message).at(span);
            self.report(error.label("like \"float radius\""));
            return None;
        };
        if words.next().is_some() {
            let message = "a parameter's declaration has words behind the name; they are ignored";
            self.report(Diagnostic::warning(message).at(span));
        }
        let known = ParamType::from_word(ty);
        if known.is_none() {
            self.report(
                Diagnostic::error(format!("unknown parameter type `{ty}`"))
                    .at(span)
                    .recoverable()
                    .label(format!("parameter `{name}` is ignored"))
                    .with_suggestion(meant_type(ty)),
            );
        }
        Some((known?, name.to_owned()))
    }

    /// Returns `true` if the next token cannot start a parameter's value.
    fn statement_ends(&mut self) -> bool {
        let next = self.peek();
        match next.kind {
            TokenKind::End | TokenKind::Close | TokenKind::Unterminated => true,
            TokenKind::Bare => directive_word(next.text()).is_some(),
            TokenKind::Open | TokenKind::Quoted => false,
        }
    }

    /// Returns `true` if the next token cannot be a value, or more likely is the next declaration.
    fn value_is_missing(&mut self, ty: ParamType) -> bool {
        let takes_strings = matches!(
            ty,
            ParamType::String | ParamType::Texture | ParamType::Spectrum
        );
        let next = self.peek();
        if next.kind == TokenKind::Quoted {
            return !takes_strings && ParamType::declares(&next.string().0);
        }
        self.statement_ends()
    }

    /// Parses one item, or a list of them in brackets.
    fn items(&mut self) -> Parsed<(Items, Span)> {
        let first = self.bump();
        let mut items = Items::default();
        if first.kind != TokenKind::Open {
            if matches!(
                first.kind,
                TokenKind::End | TokenKind::Close | TokenKind::Unterminated
            ) {
                let found = first.description();
                let message = format!("expected a parameter's value, found {found}");
                self.report(Diagnostic::error(message).at(first.span));
                return Err(Abandoned);
            }
            self.item(&first, &mut items);
            return Ok((items, first.span));
        }
        let end = self.list(&first, &mut items)?;
        // Growing by doubling leaves up to half of a large list unused.
        if items.numbers.capacity() > 64 && items.numbers.capacity() / 4 * 3 > items.numbers.len() {
            items.numbers.shrink_to_fit();
        }
        Ok((items, first.span.to(end)))
    }

    /// Parses everything up to the closing bracket, whose location is returned.
    fn list(&mut self, opening: &Token, items: &mut Items) -> Parsed<Span> {
        let files = self.open.len();
        loop {
            // A list ends in the file it begins in or in one that it includes, so no lookahead token is pending.
            if let Some(open) = self.open.last_mut() {
                let rest = plain_numbers(
                    open.bytes.get(open.at..).unwrap_or_default(),
                    &mut items.numbers,
                );
                open.at = open.bytes.len() - rest.len();
            }
            let before = self.open.last().map_or(0, |open| open.at);
            let token = self.token_of_file();
            if token.is_word("Include") {
                self.include(token.span)?;
                self.include_in_list = self.include_in_list.or(Some(token.span));
                continue;
            }
            let ends_here = match token.kind {
                TokenKind::End if self.open.len() > files => {
                    self.leave();
                    continue;
                }
                TokenKind::Close => return Ok(token.span),
                TokenKind::End => true,
                TokenKind::Bare => directive_word(token.text()).is_some(),
                TokenKind::Open | TokenKind::Unterminated => {
                    let message = format!("expected a value or `]`, found {}", token.description());
                    let error = Diagnostic::error(message).at(token.span);
                    self.report(error.related(opening.span, "the list starts here"));
                    return Err(Abandoned);
                }
                TokenKind::Quoted => false,
            };
            if ends_here {
                if let Some(open) = self.open.last_mut() {
                    open.at = before;
                }
                let message = format!("a list is not closed, found {}", token.description());
                let error = Diagnostic::error(message).at(opening.span);
                let error = error.related(token.span, "expected `]` before this");
                self.report(error.label("this `[` has no `]`"));
                let start = token.span.start;
                return Ok(token.span.file.span(start..start));
            }
            self.item(&token, items);
        }
    }

    fn item(&mut self, token: &Token, items: &mut Items) {
        match (token.kind, token.text()) {
            (TokenKind::Quoted, _) => items.strings.push(self.quoted(token)),
            (_, b"true") => items.bools.push(true),
            (_, b"false") => items.bools.push(false),
            (_, text) if self.commas_separate && text.contains(&b',') => {
                self.numbers_between_commas(token, items);
            }
            _ => match self.checked_number(token) {
                Some(value) => {
                    items.doubtful |= number(token.text()).is_some_and(|(value, _)| value.is_nan());
                    items.numbers.push(value);
                }
                None => {
                    items.spoilt = true;
                    let message = format!("expected a value, found {}", token.description());
                    let error = Diagnostic::error(message).at(token.span);
                    self.report(error.label("neither a number nor a string in quotes"));
                }
            },
        }
    }

    /// The numbers in a bare word.
    fn numbers_between_commas(&mut self, token: &Token, items: &mut Items) {
        if !std::mem::replace(&mut items.has_commas, true) {
            let warning = Diagnostic::warning("numbers are separated by commas").at(token.span);
            self.report(warning.label("read as blanks, as pbrt-v2 does"));
        }
        for part in token.text().split(|&byte| byte == b',') {
            match number(part) {
                Some((value, used)) if used == part.len() && value.is_finite() => {
                    items.numbers.push(value);
                }
                None if part.is_empty() => {}
                _ => {
                    items.spoilt = true;
                    let error = Diagnostic::error("expected numbers between commas").at(token.span);
                    self.report(error.recoverable());
                    return;
                }
            }
        }
    }

    /// The number in a bare word, after reporting problems with it; `None` if there is none.
    pub(super) fn checked_number(&mut self, token: &Token) -> Option<f64> {
        let (value, used) = number(token.text())?;
        let tail = token.text().get(used..).unwrap_or_default();
        let tail_span = Span {
            start: token.span.start + used as u32,
            ..token.span
        };
        if !tail.is_empty() {
            let diagnostic = Diagnostic::warning("a number is followed by something else")
                .at(tail_span)
                .label("ignored, as pbrt-v3 does");
            self.report(match tail.first() {
                Some(b'#') => diagnostic.with_help("a comment needs a blank before its `#`"),
                Some(b',' | b';' | b':') => diagnostic.with_help("numbers are separated by blanks"),
                _ => diagnostic,
            });
        }
        if value.is_nan() {
            let error = Diagnostic::error("not a number").at(token.span);
            self.report(error.recoverable().label("expected a finite number"));
            return Some(0.0);
        }
        Some(value)
    }

    /// Checks the items against the declared type.
    fn typed_value(
        &self,
        ty: ParamType,
        name: &str,
        items: Items,
        span: Span,
    ) -> Option<ParamValue> {
        // Instead of one number that is none the default counts, without more to say of it.
        if items.spoilt || items.doubtful && items.numbers.len() == 1 {
            return None;
        }
        let kinds = [
            (items.numbers.is_empty(), "numbers"),
            (items.strings.is_empty(), "strings"),
            (items.bools.is_empty(), "`true` or `false`"),
        ];
        let found = kinds.into_iter().filter(|(is_missing, _)| !is_missing);
        let found: Vec<&str> = found.map(|(_, kind)| kind).collect();
        let fits = match (ty, found.as_slice()) {
            (ParamType::String | ParamType::Texture, given) => given == ["strings"],
            (ParamType::Bool, given) => given == ["strings"] || given == ["`true` or `false`"],
            (_, [] | ["numbers"]) => true,
            (ParamType::Spectrum, given) => given == ["strings"],
            _ => false,
        };
        if !fits {
            let given = match found.as_slice() {
                [] => "an empty list".to_owned(),
                kinds => kinds.join(" mixed with "),
            };
            let error = Diagnostic::error(format!(
                "`{} {name}` needs {}, found {given}",
                ty.word(),
                expected_items(ty)
            ))
            .at(span)
            .label("this parameter is ignored");
            // pbrt-v3 stops at a list of both; otherwise it ignores the parameter.
            self.report(if found.len() > 1 {
                error
            } else {
                error.recoverable()
            });
            return None;
        }
        Some(match ty {
            ParamType::Bool if !items.bools.is_empty() => ParamValue::Bools(items.bools),
            ParamType::Bool => {
                ParamValue::Bools(items.strings.iter().map(|s| self.boolean(s)).collect())
            }
            _ if items.strings.is_empty() => {
                ParamValue::Numbers(self.whole_values(ty, name, items, span)?)
            }
            _ => ParamValue::Strings(items.strings),
        })
    }

    fn boolean(&self, string: &Name) -> bool {
        if !matches!(string.text.as_str(), "true" | "false") {
            let message = format!("\"{}\" is neither \"true\" nor \"false\"", string.text);
            let warning = Diagnostic::warning(message).at(string.span);
            self.report(warning.label("taken for \"false\""));
        }
        string.text == "true"
    }

    /// Drops numbers that do not form a complete value; `None` if nothing is left. If one of them was reported already,
    /// their count says nothing new.
    fn whole_values(
        &self,
        ty: ParamType,
        name: &str,
        items: Items,
        span: Span,
    ) -> Option<Vec<f64>> {
        let mut numbers = items.numbers;
        let count = numbers.len();
        let (word, each) = (ty.word(), ty.items());
        let surplus = count % each;
        if surplus > 0 && !items.doubtful {
            let (wanted, label) = match (surplus == count, surplus) {
                (true, _) => ("numbers", "this parameter is ignored"),
                (_, 1) => ("numbers for each value", "the last one is ignored"),
                _ => ("numbers for each value", "the last two are ignored"),
            };
            let message = format!("`{word} {name}` takes {each} {wanted}, found {count}");
            let warning = Diagnostic::warning(message).at(span).label(label);
            self.report(match (ty, numbers.as_slice()) {
                (ParamType::Blackbody, [kelvin]) => warning.with_help(format!(
                    "a temperature alone is pbrt-v4's form; write [{kelvin} 1], with a factor"
                )),
                _ => warning,
            });
        }
        numbers.truncate(count - surplus);
        // An empty list may be what was meant.
        (count == 0 || !numbers.is_empty()).then_some(numbers)
    }
}

fn expected_items(ty: ParamType) -> &'static str {
    match ty {
        ParamType::Bool => "\"true\" or \"false\"",
        ParamType::String => "strings in quotes",
        ParamType::Texture => "the name of a texture in quotes",
        ParamType::Spectrum => "numbers or the names of .spd files",
        _ => "numbers",
    }
}

/// The intended type for those of other languages and other versions of pbrt, and for misspellings.
fn meant_type(word: &str) -> Option<&'static str> {
    match word {
        "int" => Some("integer"),
        "double" => Some("float"),
        "normal3" => Some("normal"),
        "color3" => Some("color"),
        "filename" | "str" => Some("string"),
        "boolean" => Some("bool"),
        _ => nearest(word, ParamType::WORDS.map(|(word, _)| word)),
    }
}
