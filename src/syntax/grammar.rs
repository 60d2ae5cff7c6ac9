//! The arguments of each directive.

use super::diagnostic::Diagnostic;
use super::directive::{ActiveTransform, DirectiveKind, Name, Typed};
use super::parser::{Abandoned, Parsed, Parser};
use super::suggest::nearest;
use super::token::{Token, TokenKind};
use crate::math::DVec3;
use glam::DMat4;

impl Parser<'_> {
    /// Parses the arguments after `word`, which has been consumed.
    pub(super) fn statement(&mut self, word: &'static str) -> Parsed<DirectiveKind> {
        use DirectiveKind as Kind;
        Ok(match word {
            "Identity" => Kind::Identity,
            "Translate" => Kind::Translate(self.vector(word)?),
            "Scale" => Kind::Scale(self.vector(word)?),
            "Rotate" => {
                let [degrees, x, y, z] =
                    self.numbers(word, "an angle in degrees and an axis x y z")?;
                Kind::Rotate {
                    degrees,
                    axis: DVec3::new(x, y, z),
                }
            }
            "LookAt" => {
                let n: [f64; 9] = self.numbers(word, "three points: eye, look and up")?;
                let point = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
                Kind::LookAt {
                    eye: point(0),
                    look: point(3),
                    up: point(6),
                }
            }
            "Transform" => Kind::Transform(self.matrix(word)?),
            "ConcatTransform" => Kind::ConcatTransform(self.matrix(word)?),
            "CoordinateSystem" => Kind::CoordinateSystem(self.name(word, "a name")?),
            "CoordSysTransform" => {
                Kind::CoordSysTransform(self.name(word, "the name of a coordinate system")?)
            }
            "ActiveTransform" => Kind::ActiveTransform(self.active_transform()?),
            "TransformTimes" => {
                let [start, end] = self.numbers(word, "a start and an end time")?;
                Kind::TransformTimes(start, end)
            }
            "TransformBegin" => Kind::TransformBegin,
            "TransformEnd" => Kind::TransformEnd,
            "AttributeBegin" => Kind::AttributeBegin,
            "AttributeEnd" => Kind::AttributeEnd,
            "PixelFilter" => Kind::PixelFilter(self.typed(word)?),
            "Film" => Kind::Film(self.typed(word)?),
            "Sampler" => Kind::Sampler(self.typed(word)?),
            "Accelerator" => Kind::Accelerator(self.typed(word)?),
            "Integrator" => Kind::Integrator(self.typed(word)?),
            "Camera" => Kind::Camera(self.typed(word)?),
            "SurfaceIntegrator" => Kind::SurfaceIntegrator(self.typed(word)?),
            "VolumeIntegrator" => Kind::VolumeIntegrator(self.typed(word)?),
            "Renderer" => Kind::Renderer(self.typed(word)?),
            "Volume" => Kind::Volume(self.typed(word)?),
            "MakeNamedMedium" => Kind::MakeNamedMedium(self.typed(word)?),
            "MediumInterface" => {
                let inside = self.name(word, "the name of a medium")?;
                let both = self.peek().kind != TokenKind::Quoted;
                let outside = match both {
                    true => inside.clone(),
                    false => self.name(word, "the name of a medium")?,
                };
                Kind::MediumInterface { inside, outside }
            }
            "WorldBegin" => Kind::WorldBegin,
            "WorldEnd" => Kind::WorldEnd,
            "Texture" => Kind::Texture {
                name: self.name(word, "the texture's name")?,
                value_type: self.name(word, "\"float\" or \"spectrum\"")?,
                class: self.name(word, "the kind of texture")?,
                params: self.parameters()?,
            },
            "Material" => Kind::Material(self.typed(word)?),
            "MakeNamedMaterial" => Kind::MakeNamedMaterial(self.typed(word)?),
            "NamedMaterial" => Kind::NamedMaterial(self.name(word, "the name of a material")?),
            "LightSource" => Kind::LightSource(self.typed(word)?),
            "AreaLightSource" => Kind::AreaLightSource(self.typed(word)?),
            "Shape" => Kind::Shape(self.typed(word)?),
            "ReverseOrientation" => Kind::ReverseOrientation,
            "ObjectBegin" => Kind::ObjectBegin(self.name(word, "the object's name")?),
            "ObjectEnd" => Kind::ObjectEnd,
            "ObjectInstance" => Kind::ObjectInstance(self.name(word, "the name of an object")?),
            // A test keeps `WORDS` and this table in agreement.
            _ => return Err(Abandoned),
        })
    }

    fn typed(&mut self, word: &'static str) -> Parsed<Typed> {
        let expected = match word.starts_with("MakeNamed") {
            true => "a name",
            false => "a type",
        };
        Ok(Typed {
            kind: self.name(word, expected)?,
            params: self.parameters()?,
        })
    }

    /// Parses one quoted string.
    pub(super) fn name(&mut self, word: &'static str, expected: &str) -> Parsed<Name> {
        if self.peek().kind != TokenKind::Quoted {
            return Err(self.expected(&format!("{expected} in quotes"), word));
        }
        let token = self.bump();
        Ok(self.quoted(&token))
    }

    /// The string in a token.
    pub(super) fn quoted(&self, token: &Token) -> Name {
        let (text, stray_backslash) = token.string();
        if stray_backslash {
            let help = "in file names, write `/` instead of `\\`: it works on every system";
            let warning = Diagnostic::warning("a backslash in a string should be doubled");
            self.report(warning.at(token.span).with_help(help));
        }
        let span = token.span;
        Name { text, span }
    }

    /// Reports that the next token is not the expected one; it is not consumed.
    fn expected(&mut self, expected: &str, word: &'static str) -> Abandoned {
        let next = self.peek().clone();
        let message = format!("`{word}` needs {expected}, found {}", next.description());
        let mut diagnostic = Diagnostic::error(message).at(next.span);
        if !self.on_the_statements_line(&next) {
            diagnostic = diagnostic.related(self.statement, format!("`{word}` stands here"));
        }
        self.report(match next.kind {
            TokenKind::Unterminated => diagnostic.label("this string does not end on its line"),
            _ => diagnostic.label(format!("expected {expected}")),
        });
        Abandoned
    }

    /// Returns `true` if the token is on the line of the directive's word.
    fn on_the_statements_line(&self, token: &Token) -> bool {
        let between = self.statement.end as usize..token.span.start as usize;
        self.statement.file == token.span.file
            && token
                .bytes
                .get(between)
                .is_some_and(|bytes| !bytes.contains(&b'\n') && !bytes.contains(&b'\r'))
    }

    fn vector(&mut self, word: &'static str) -> Parsed<DVec3> {
        Ok(DVec3::from_array(
            self.numbers(word, "three numbers: x y z")?,
        ))
    }

    fn matrix(&mut self, word: &'static str) -> Parsed<Box<DMat4>> {
        let opening = self.peek().clone();
        if opening.kind == TokenKind::Bare {
            let message = format!("the numbers of `{word}` belong in brackets");
            let warning = Diagnostic::warning(message).at(opening.span);
            self.report(warning.with_note("pbrt-v3 refuses them without"));
        }
        let columns =
            self.finite_numbers(word, "sixteen numbers in brackets, column by column", true)?;
        Ok(Box::new(DMat4::from_cols_array(&columns)))
    }

    fn numbers<const N: usize>(&mut self, word: &'static str, expected: &str) -> Parsed<[f64; N]> {
        self.finite_numbers(word, expected, false)
    }

    /// Parses `N` numbers. Brackets around them are skipped, with a warning if they do not belong there.
    fn finite_numbers<const N: usize>(
        &mut self,
        word: &'static str,
        expected: &str,
        brackets_belong: bool,
    ) -> Parsed<[f64; N]> {
        let mut numbers = [0.0; N];
        let mut read = 0;
        let mut depth = 0_usize;
        while read < N || depth > 0 {
            match self.peek().kind {
                TokenKind::Open if read < N && depth == 0 => {
                    let bracket = self.bump();
                    depth += 1;
                    if !brackets_belong {
                        let message = format!("the numbers of `{word}` stand without brackets");
                        let warning = Diagnostic::warning(message).at(bracket.span);
                        self.report(warning.with_note("pbrt-v3 refuses them with brackets"));
                    }
                }
                TokenKind::Close if depth > 0 => {
                    self.bump();
                    depth -= 1;
                }
                TokenKind::Bare if read < N => {
                    let token = self.peek().clone();
                    numbers[read] = self
                        .finite(&token)
                        .ok_or_else(|| self.expected(expected, word))?;
                    self.bump();
                    read += 1;
                }
                _ if read == N => return Err(self.expected("a closing `]`", word)),
                _ => return Err(self.expected(expected, word)),
            }
        }
        Ok(numbers)
    }

    /// A number for a transform; `None` if the token is not a number. A non-finite one is reported and replaced, so
    /// that the rest of the directive can be read.
    fn finite(&mut self, token: &Token) -> Option<f64> {
        let number = self.checked_number(token)?;
        if number.is_finite() {
            return Some(number);
        }
        self.report(Diagnostic::error("a transform needs finite numbers").at(token.span));
        Some(1.0)
    }

    fn active_transform(&mut self) -> Parsed<ActiveTransform> {
        const CHOICES: [&str; 3] = ["StartTime", "EndTime", "All"];
        let next = self.peek().clone();
        let active = match next.text() {
            b"StartTime" => ActiveTransform::Start,
            b"EndTime" => ActiveTransform::End,
            b"All" => ActiveTransform::All,
            text => {
                let text = String::from_utf8_lossy(text).into_owned();
                let found = next.description();
                let message = format!(
                    "`ActiveTransform` needs `StartTime`, `EndTime` or `All`, found {found}"
                );
                let error = Diagnostic::error(message).at(next.span);
                self.report(error.with_suggestion(nearest(&text, CHOICES)));
                return Err(Abandoned);
            }
        };
        self.bump();
        Ok(active)
    }
}
