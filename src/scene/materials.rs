//! `Material`, `MakeNamedMaterial` and `NamedMaterial`.

use super::graphics_state::MaterialDirective;
use super::interpreter::Interpreter;
use crate::handles::MaterialId;
use crate::materials::{self, Material};
use crate::params::{ParamReader, TextureNames};
use crate::syntax::suggest::nearest;
use crate::syntax::{Diagnostic, Name, ParamGroup, ParamList, ParamValue, Span, Typed};
use std::rc::Rc;

impl Interpreter<'_> {
    /// The material of a `Material` or `MakeNamedMaterial`.
    pub(super) fn make_material(
        &mut self,
        word: &'static str,
        span: Span,
        mut typed: Typed,
    ) -> MaterialDirective {
        let names = Rc::clone(&self.current.state.textures);
        let material = self.reading(&names).read(word, span, &typed, read_material);
        let id = material.and_then(|m| self.add_material(m));
        if !materials::is_none(&typed.kind.text) && !Material::KINDS.contains(&&*typed.kind.text) {
            // What stands in its place has been said once, and not again for every shape that
            // overrides it.
            typed.kind.text = "matte".to_string();
        }
        MaterialDirective {
            typed,
            id,
            named: false,
        }
    }

    pub(super) fn add_material(&mut self, material: Material) -> Option<MaterialId> {
        let materials = &mut self.world.as_mut()?.materials;
        materials.push(material);
        Some(MaterialId(materials.len() as u32 - 1))
    }

    /// `MakeNamedMaterial "name"`.
    pub(super) fn make_named_material(&mut self, span: Span, mut typed: Typed) {
        let name = typed.kind.clone();
        let Some(kind) = named_type(&typed.params) else {
            self.diagnostics.push(
                Diagnostic::error(format!(
                    "`MakeNamedMaterial \"{}\"` needs one `string type`; ignored",
                    name.text
                ))
                .at(name.span)
                .with_help("add for example \"string type\" \"matte\""),
            );
            return;
        };
        typed.kind = kind;
        let material = MaterialDirective {
            named: true,
            ..self.make_material("MakeNamedMaterial", span, typed)
        };
        if self.current.state.define_material(&name.text, material) {
            self.warn(
                name.span,
                format!(
                    "material `{}` is defined again; later uses see this one",
                    name.text
                ),
            );
        }
    }

    /// `NamedMaterial "name"`.
    pub(super) fn use_named_material(&mut self, name: &Name) {
        match self.current.state.named_materials.get(&name.text) {
            Some(material) => self.current.state.material = Some(Rc::clone(material)),
            None => {
                let known = self
                    .current
                    .state
                    .named_materials
                    .keys()
                    .map(String::as_str);
                self.diagnostics.push(
                    Diagnostic::error(format!(
                        "there is no material `{}`; the current one stays",
                        name.text
                    ))
                    .at(name.span)
                    .with_suggestion(nearest(&name.text, known)),
                );
            }
        }
    }

    /// `matte` with its defaults, made when the first shape needs it.
    pub(super) fn default_material(&mut self) -> Option<MaterialId> {
        let known = self.world.as_ref()?.default_material;
        if known.is_some() {
            return known;
        }
        let names = TextureNames::default();
        let material = self
            .reading(&names)
            .defaults("Material", "matte", read_material)?;
        let id = self.add_material(material);
        self.world.as_mut()?.default_material = id;
        id
    }

    /// The base material where the override changed nothing, so that a million shapes with a
    /// single-valued parameter of their own still share one material.
    pub(super) fn same_or_new(
        &mut self,
        base: Option<MaterialId>,
        material: Material,
    ) -> Option<MaterialId> {
        let materials = &self.world.as_ref()?.materials;
        if base.is_some_and(|id| materials.get(id.index()) == Some(&material)) {
            return base;
        }
        if let Some(last) = materials.last()
            && *last == material
        {
            return Some(MaterialId(materials.len() as u32 - 1));
        }
        self.add_material(material)
    }
}

/// A material, or `None` for a surface without one.
pub(super) fn read_material(reader: &ParamReader) -> Option<Material> {
    if materials::is_none(reader.kind()) {
        reader.accept_all();
        return None;
    }
    Material::from_params(reader)
}

/// The value of `"string type"`.
fn named_type(params: &ParamList) -> Option<Name> {
    let param = params.get("type", ParamGroup::String)?;
    param.used.set(true);
    match &param.value {
        ParamValue::Strings(names) if names.len() == 1 => names.first().cloned(),
        _ => None,
    }
}
