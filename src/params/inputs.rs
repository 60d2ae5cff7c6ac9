//! Inputs that may be textures: `"float roughness" .1` or `"texture roughness" "scratches"`.

use super::{ParamReader, spectrum};
use crate::inputs::{FloatInput, SpectrumInput, TextureRead, TexturesRead};
use crate::math::Rgb;
use crate::syntax::{Diagnostic, Name, Param, ParamGroup, ParamValue};

impl<'a> ParamReader<'a> {
    /// The layer and value that count where a texture or a number may be given: in each layer the
    /// texture comes before the number, and only a layer with neither lets the next one speak.
    fn find_input(&self, name: &str, group: ParamGroup) -> Option<&'a Param> {
        if !self.offers(name) {
            return None;
        }
        self.asked.record(name, ParamGroup::Texture);
        self.asked.record(name, group);
        let mut counts = None;
        for layer in self.layers() {
            let texture = self.in_layer(layer, name, ParamGroup::Texture);
            // Beside a texture the number stays unused, and is reported so.
            let here = if texture.is_some() {
                texture
            } else {
                self.in_layer(layer, name, group)
            };
            counts = counts.or(here);
        }
        counts
    }

    /// A float or a float texture. `None` where neither is given, or where the texture named does
    /// not exist (then already reported as an error).
    pub fn find_float_input(&self, name: &str) -> Option<FloatInput> {
        let param = self.find_input(name, ParamGroup::Float)?;
        match &param.value {
            ParamValue::Numbers(numbers) => {
                self.takes_first(param, numbers.len());
                Some(FloatInput::Constant(*numbers.first()? as f32))
            }
            ParamValue::Strings(names) => {
                let textures = self.context.textures;
                let id = textures.float.get(&self.texture_name(param, names)?.text);
                if id.is_none() {
                    let other = textures.spectrum.contains_key(&names.first()?.text);
                    self.no_such_texture(names.first()?, "float", other, textures.float.keys());
                }
                let id = *id?;
                self.asked.record_texture(TextureRead::Float(id));
                Some(FloatInput::Texture(id))
            }
            ParamValue::Bools(_) => None,
        }
    }

    /// A float or a float texture, or the default.
    pub fn float_input(&self, name: &str, default: f32) -> FloatInput {
        self.find_float_input(name)
            .unwrap_or(FloatInput::Constant(default))
    }

    /// A spectrum or a spectrum texture. `None` where neither is given, or where the texture named
    /// does not exist (then already reported as an error).
    pub fn find_spectrum_input(&self, name: &str) -> Option<SpectrumInput> {
        let param = self.find_input(name, ParamGroup::Spectrum)?;
        match &param.value {
            ParamValue::Strings(names) if param.ty.group() == ParamGroup::Texture => {
                let textures = self.context.textures;
                let id = textures
                    .spectrum
                    .get(&self.texture_name(param, names)?.text);
                if id.is_none() {
                    let other = textures.float.contains_key(&names.first()?.text);
                    self.no_such_texture(
                        names.first()?,
                        "spectrum",
                        other,
                        textures.spectrum.keys(),
                    );
                }
                let id = *id?;
                self.asked.record_texture(TextureRead::Spectrum(id));
                Some(SpectrumInput::Texture(id))
            }
            _ => {
                let (rgb, values) = spectrum::first_value(self, param).or_else(|| {
                    self.takes_first(param, 0);
                    None
                })?;
                self.takes_first(param, values);
                Some(SpectrumInput::Constant(rgb))
            }
        }
    }

    /// A spectrum or a spectrum texture, or the default.
    pub fn spectrum_input(&self, name: &str, default: Rgb) -> SpectrumInput {
        self.find_spectrum_input(name)
            .unwrap_or(SpectrumInput::Constant(default))
    }

    /// How many textures its parameters have named so far.
    pub fn textures_read(&self) -> usize {
        self.asked.textures()
    }

    /// The textures that its parameters named after the first `count`.
    pub fn textures_since(&self, count: usize) -> TexturesRead {
        self.asked.textures_since(count)
    }

    /// The exception from "ignored as a whole": inputs that may be textures take the first of
    /// several values (docs/scene-language.md §1.3).
    fn takes_first(&self, param: &Param, values: usize) {
        match values {
            0 => drop(self.is_single(param, 0)),
            1 => {}
            _ => self.context.diagnostics.push(
                Diagnostic::warning(format!("`{}` takes one value, found {values}", param.name))
                    .at(param.value_span)
                    .label("the first one is used"),
            ),
        }
    }

    fn texture_name(&self, param: &Param, names: &'a [Name]) -> Option<&'a Name> {
        if names.len() > 1 {
            self.context.diagnostics.push(
                self.new_error(format!(
                    "`texture {}` takes the name of one texture",
                    param.name
                ))
                .at(param.value_span),
            );
            return None;
        }
        names.first()
    }

    fn no_such_texture<'n>(
        &self,
        name: &Name,
        wanted: &str,
        other_exists: bool,
        known: impl Iterator<Item = &'n String>,
    ) {
        let diagnostic = self
            .new_error(format!(
                "there is no {wanted} texture named `{}`",
                name.text
            ))
            .at(name.span);
        if other_exists {
            let found = if wanted == "float" {
                "spectrum"
            } else {
                "float"
            };
            let note = format!("a {found} texture has this name; the two kinds are apart");
            self.context.diagnostics.push(diagnostic.with_note(note));
        } else {
            let known = known.map(String::as_str);
            self.context
                .diagnostics
                .push_with_nearest(diagnostic, &name.text, known);
        }
    }
}
