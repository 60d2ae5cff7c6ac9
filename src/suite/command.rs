//! A renderer's command line, with places for what differs from render to render.

use crate::syntax::suggest::nearest;
use std::ffi::OsString;
use std::path::Path;

/// A command line with placeholders. It is run without a shell: each word is one argument, whatever the names that are put
/// into it contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    words: Vec<Vec<Piece>>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Placeholder(Placeholder),
}

/// What is put into a command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placeholder {
    /// The scene file, as the suite names it.
    Scene,
    /// The image to write.
    Output,
    /// The seed.
    Seed,
    /// Samples per pixel.
    Spp,
    /// This program.
    Fstop,
}

const PLACEHOLDERS: [(&str, Placeholder); 5] = [
    ("scene", Placeholder::Scene),
    ("output", Placeholder::Output),
    ("seed", Placeholder::Seed),
    ("spp", Placeholder::Spp),
    ("fstop", Placeholder::Fstop),
];

/// Why a text is no command line; `help` may say what was meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemplateError {
    /// One line, without a final period.
    pub message: String,
    /// Advice.
    pub help: Option<String>,
}

/// One render.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// The scene file.
    pub scene: &'a str,
    /// The image to write.
    pub output: &'a Path,
    /// The seed.
    pub seed: u64,
    /// Samples per pixel.
    pub spp: u32,
}

impl Template {
    /// Of a line: blanks divide it into words, except between quotes of either kind; a backslash between double quotes, or
    /// outside, takes the next character as it is.
    ///
    /// # Errors
    /// No words, an open quote, a placeholder that does not exist, or none for the image.
    pub fn of_line(line: &str) -> Result<Template, TemplateError> {
        Template::of_words(&words(line)?)
    }

    /// Of the words themselves.
    ///
    /// # Errors
    /// As [`Template::of_line`].
    pub fn of_words<S: AsRef<str>>(words: &[S]) -> Result<Template, TemplateError> {
        let pieces = { words.iter() }.map(|word| pieces(word.as_ref()));
        let words = pieces.collect::<Result<Vec<_>, _>>()?;
        if words.first().is_none_or(Vec::is_empty) {
            return Err(error("there is no command"));
        }
        let template = Template { words };
        if !template.uses(Placeholder::Output) {
            return Err(TemplateError {
                help: Some("such as `{fstop} render {scene} -o {output} --seed {seed} --spp {spp} --variance`".to_owned()),
                ..error("the command does not say where its image goes: it has no {output}")
            });
        }
        Ok(template)
    }

    /// Returns `true` if this has an influence on what is run.
    pub fn uses(&self, placeholder: Placeholder) -> bool {
        let mut pieces = self.words.iter().flatten();
        pieces.any(|piece| *piece == Piece::Placeholder(placeholder))
    }

    /// The program and its arguments.
    pub fn filled(&self, values: &Values) -> Vec<OsString> {
        let fill = |word: &Vec<Piece>| {
            let mut text = OsString::new();
            for piece in word {
                match piece {
                    Piece::Text(words) => text.push(words),
                    Piece::Placeholder(Placeholder::Scene) => text.push(values.scene),
                    Piece::Placeholder(Placeholder::Output) => text.push(values.output),
                    Piece::Placeholder(Placeholder::Seed) => text.push(values.seed.to_string()),
                    Piece::Placeholder(Placeholder::Spp) => text.push(values.spp.to_string()),
                    Piece::Placeholder(Placeholder::Fstop) => {
                        // Where that is not known, the one that is found by its name.
                        text.push(std::env::current_exe().unwrap_or_else(|_| "fstop".into()));
                    }
                }
            }
            text
        };
        self.words.iter().map(fill).collect()
    }
}

fn error(message: impl Into<String>) -> TemplateError {
    TemplateError {
        message: message.into(),
        help: None,
    }
}

/// A line's words.
fn words(line: &str) -> Result<Vec<String>, TemplateError> {
    let (mut words, mut word) = (Vec::new(), None::<String>);
    let (mut quote, mut letters) = (None, line.chars());
    while let Some(letter) = letters.next() {
        match (quote, letter) {
            (Some(open), _) if letter == open => quote = None,
            (None, '"' | '\'') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None | Some('"'), '\\') => word.get_or_insert_default().extend(letters.next()),
            (None, _) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    if let Some(quote) = quote {
        return Err(error(format!(
            "the quote {quote} in the command is not closed"
        )));
    }
    words.extend(word);
    Ok(words)
}

/// A word with its placeholders; `{{` and `}}` are braces.
fn pieces(word: &str) -> Result<Vec<Piece>, TemplateError> {
    let (mut pieces, mut text, mut rest) = (Vec::new(), String::new(), word);
    while let Some(at) = rest.find(['{', '}']) {
        let (before, from) = rest.split_at(at);
        text += before;
        if let Some(after) = from.strip_prefix("{{").or(from.strip_prefix("}}")) {
            text += &from[..1];
            rest = after;
            continue;
        }
        let name = from.strip_prefix('{').and_then(|from| from.split_once('}'));
        let Some((name, after)) = name else {
            return Err(error(format!(
                "a brace without its partner in `{word}`: {{{{ and }}}} stand for braces"
            )));
        };
        let found = PLACEHOLDERS.iter().find(|(known, _)| *known == name);
        let Some((_, placeholder)) = found else {
            return Err(unknown(name));
        };
        pieces.extend((!text.is_empty()).then(|| Piece::Text(std::mem::take(&mut text))));
        pieces.push(Piece::Placeholder(*placeholder));
        rest = after;
    }
    text += rest;
    pieces.extend((!text.is_empty()).then_some(Piece::Text(text)));
    Ok(pieces)
}

fn unknown(name: &str) -> TemplateError {
    let known = PLACEHOLDERS.map(|(known, _)| known);
    let all = known.map(|known| format!("{{{known}}}")).join(", ");
    TemplateError {
        message: format!("there is no placeholder {{{name}}}"),
        help: Some(match nearest(name, known) {
            Some(meant) => format!("did you mean {{{meant}}}?"),
            None => format!("there are {all}; {{{{ and }}}} stand for braces"),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(line: &str) -> Vec<String> {
        let values = Values {
            scene: "a b.pbrt",
            output: Path::new("out 1.exr"),
            seed: 7,
            spp: 64,
        };
        let template = Template::of_line(line).unwrap_or_else(|e| panic!("{}", e.message));
        let words = template.filled(&values).into_iter();
        words
            .map(|word| word.to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn names_stay_one_argument() {
        assert_eq!(
            filled("pbrt  --outfile={output} {scene}"),
            ["pbrt", "--outfile=out 1.exr", "a b.pbrt"]
        );
        assert_eq!(
            filled(r#"sh -c 'echo "$1" > {output}' "" a\ b {seed}{spp} {{x}}"#),
            [
                "sh",
                "-c",
                "echo \"$1\" > out 1.exr",
                "",
                "a b",
                "764",
                "{x}"
            ]
        );
    }

    #[test]
    fn mistakes_are_told() {
        for (line, message) in [
            ("", "there is no command"),
            (
                "pbrt {scene}",
                "the command does not say where its image goes: it has no {output}",
            ),
            ("pbrt '{output}", "the quote ' in the command is not closed"),
            ("pbrt {output} {sede}", "there is no placeholder {sede}"),
            (
                "pbrt {output} }",
                "a brace without its partner in `}`: {{ and }} stand for braces",
            ),
            (
                "pbrt {output} {",
                "a brace without its partner in `{`: {{ and }} stand for braces",
            ),
        ] {
            assert_eq!(Template::of_line(line).expect_err(line).message, message);
        }
        let error = Template::of_line("{output} {sede}").expect_err("a mistake");
        assert_eq!(error.help.as_deref(), Some("did you mean {seed}?"));
    }
}
