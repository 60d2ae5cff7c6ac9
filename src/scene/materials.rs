//! `Material`, `MakeNamedMaterial` and `NamedMaterial`.

use super::graphics_state::MaterialDirective;
use super::interpreter::Interpreter;
use super::names::MaterialName;
use crate::handles::MaterialId;
use crate::materials::{self, Material, Named, NamedMaterials};
use crate::params::{Dialect, ParamReader, TextureNames};
use crate::syntax::{Diagnostic, Name, ParamGroup, ParamList, ParamValue, Span, Typed};
use std::collections::HashMap;
use std::rc::Rc;

impl Interpreter<'_> {
    /// Handles `Material "type"`. pbrt-v2 creates the material at each shape (docs/scene-language.md §A.1), so it may
    /// name textures that are defined later: then problems are reported at the shapes.
    pub(super) fn use_material(&mut self, span: Span, typed: Typed) {
        let wait = self.dialect() == Dialect::V2
            && Material::is_modeled(&typed.kind.text, Dialect::V2)
            && texture_names(&typed.params).any(|name| !self.is_texture(name));
        let material = if wait {
            MaterialDirective {
                typed,
                id: None,
                named: false,
            }
        } else {
            self.make_material("Material", span, typed, None)
        };
        let material = Some(Rc::new(material));
        self.current.state.unnamed_material.clone_from(&material);
        self.current.state.late_material = None;
        self.current.state.material = material;
    }

    fn is_texture(&self, name: &str) -> bool {
        let names = &self.current.state.textures;
        names.float.contains_key(name) || names.spectrum.contains_key(name)
    }

    /// The named materials in scope while `defining` is being defined.
    pub(super) fn materials_in_scope<'b>(&'b self, defining: Option<&'b str>) -> InScope<'b> {
        InScope {
            named: &self.current.state.named_materials,
            materials: self.world.as_ref().map_or(&[], |world| &world.materials),
            defining,
        }
    }

    /// The material of a `Material`, or of the `MakeNamedMaterial` that is `defining` a name.
    pub(super) fn make_material(
        &mut self,
        word: &'static str,
        span: Span,
        mut typed: Typed,
        defining: Option<&str>,
    ) -> MaterialDirective {
        let names = Rc::clone(&self.current.state.textures);
        let named = self.materials_in_scope(defining);
        let reading = self.reading(&names);
        let material = reading.read(word, span, &typed, |r| read_material(r, &named));
        let kind = &typed.kind.text;
        let name = match defining {
            Some(name) => MaterialName::Given(name.to_string()),
            None => MaterialName::Made(kind.clone(), span),
        };
        let id = material.and_then(|m| self.add_material(m, name));
        if !materials::is_none(kind) && !Material::is_modeled(kind, self.dialect()) {
            // The replacement is reported once, not again for every shape that overrides it.
            typed.kind.text = "matte".to_string();
        }
        MaterialDirective {
            typed,
            id,
            named: false,
        }
    }

    fn add_material(&mut self, material: Material, name: MaterialName) -> Option<MaterialId> {
        let world = self.world.as_mut()?;
        world.materials.push(material);
        world.material_names.push(name);
        Some(MaterialId(world.materials.len() as u32 - 1))
    }

    /// Handles `MakeNamedMaterial "name"`.
    pub(super) fn make_named_material(&mut self, span: Span, mut typed: Typed) {
        let name = typed.kind.clone();
        let Some(kind) = named_type(&typed.params) else {
            self.diagnostics.push(
                Diagnostic::error(format!(
                    "`MakeNamedMaterial \"{}\"` needs one `string type`; ignored",
                    name.text
                ))
                .at(name.span)
                .recoverable()
                .with_help("add for example \"string type\" \"matte\""),
            );
            return;
        };
        typed.kind = kind;
        let material = MaterialDirective {
            named: true,
            ..self.make_material("MakeNamedMaterial", span, typed, Some(&name.text))
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

    /// Handles `NamedMaterial "name"`. An undefined name gives a warning and leaves the material unchanged: scenes of
    /// pbrt's own collection have such names. pbrt-v2 looks names up when a shape is created, and falls back to the
    /// last unnamed material then (docs/scene-language.md §A.1).
    pub(super) fn use_named_material(&mut self, name: &Name) {
        let v2 = self.dialect() == Dialect::V2;
        let state = &mut self.current.state;
        state.late_material = None;
        match state.named_materials.get(&name.text) {
            Some(material) => state.material = Some(Rc::clone(material)),
            None if v2 => state.late_material = Some(name.clone()),
            None => self.no_such_material(name),
        }
    }

    /// Completes the lookup that [`Self::use_named_material`] has deferred to the next shape.
    pub(super) fn find_late_material(&mut self) {
        let state = &mut self.current.state;
        let Some(name) = state.late_material.take() else {
            return;
        };
        match state.named_materials.get(&name.text) {
            Some(material) => state.material = Some(Rc::clone(material)),
            None => self.no_such_material(&name),
        }
    }

    fn no_such_material(&mut self, name: &Name) {
        let v2 = self.dialect() == Dialect::V2;
        let state = &mut self.current.state;
        let missing = format!("there is no material `{}`", name.text);
        let instead = if v2 {
            state.material.clone_from(&state.unnamed_material);
            "the last unnamed one is used"
        } else {
            "the current one stays, as in pbrt-v3"
        };
        let known = state.named_materials.keys().map(String::as_str);
        let warning = Diagnostic::warning(format!("{missing}; {instead}")).at(name.span);
        self.diagnostics
            .push_with_nearest(warning, &name.text, known);
    }

    /// `matte` with its defaults, created when the first shape needs it.
    pub(super) fn default_material(&mut self) -> Option<MaterialId> {
        let known = self.world.as_ref()?.default_material;
        if known.is_some() {
            return known;
        }
        let names = TextureNames::default();
        let material = self.reading(&names).defaults("Material", "matte", |r| {
            read_material(r, &self.materials_in_scope(None))
        })?;
        let id = self.add_material(material, MaterialName::Type("matte"));
        self.world.as_mut()?.default_material = id;
        id
    }

    /// The base material if the override changed nothing, so that a million shapes with their own copy of a parameter
    /// still share one material.
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
        let name = base.map_or(MaterialName::Type("none"), MaterialName::Changed);
        self.add_material(material, name)
    }
}

/// The named materials in scope at one point of the file.
pub(super) struct InScope<'a> {
    named: &'a HashMap<String, Rc<MaterialDirective>>,
    materials: &'a [Material],
    defining: Option<&'a str>,
}

impl NamedMaterials for InScope<'_> {
    fn find(&self, name: &str) -> Option<Option<Named>> {
        let id = self.named.get(name)?.id;
        Some(id.and_then(|id| Some(Named::new(id, self.materials.get(id.index())?))))
    }

    fn names(&self) -> Vec<&str> {
        self.named.keys().map(String::as_str).collect()
    }

    fn defining(&self) -> Option<&str> {
        self.defining
    }
}

/// Reads a material; `None` for a surface without one.
pub(super) fn read_material(reader: &ParamReader, named: &dyn NamedMaterials) -> Option<Material> {
    if materials::is_none(reader.kind()) {
        reader.accept_all();
        return None;
    }
    Material::from_params(reader, named)
}

/// The names in parameters of type `texture`.
pub(super) fn texture_names(params: &ParamList) -> impl Iterator<Item = &str> {
    let textures = params
        .params
        .iter()
        .filter(|param| param.ty.group() == ParamGroup::Texture);
    textures.flat_map(|param| match &param.value {
        ParamValue::Strings(names) => names.iter().map(|name| name.text.as_str()).collect(),
        ParamValue::Numbers(_) | ParamValue::Bools(_) => Vec::new(),
    })
}

/// The value of `"string type"`.
pub(super) fn named_type(params: &ParamList) -> Option<Name> {
    let param = params.get("type", ParamGroup::String)?;
    param.used.set(true);
    match &param.value {
        ParamValue::Strings(names) if names.len() == 1 => names.first().cloned(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::params::Dialect;
    use crate::scene::description::{Frame, ShapeEntity};
    use crate::scene::dialect::DialectChoice;
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::SourceMap;

    fn frame(dialect: Dialect, world: &str) -> (Frame, usize, usize) {
        let sources = SourceMap::new();
        let text = format!("WorldBegin LightSource \"point\" {world} WorldEnd");
        let main = sources.add_text("test.pbrt", text);
        let settings = ReadSettings {
            dialect: DialectChoice::Fixed(dialect),
            ..ReadSettings::default()
        };
        let (mut scene, diagnostics) = read_scene(&sources, main, &settings);
        let frame = scene.frames.pop().expect("a frame");
        (frame, diagnostics.errors(), diagnostics.warnings())
    }

    /// The material of each shape.
    fn materials(frame: &Frame) -> Vec<Option<&super::Material>> {
        let of = |shape: &ShapeEntity| frame.materials.get(shape.material?.index());
        frame.shapes.iter().map(of).collect()
    }

    /// docs/scene-language.md §A.1 and §2.1: a texture redefined between `Material` and `Shape` takes effect in
    /// pbrt-v2, but not in v3.
    #[test]
    fn textures_count_at_the_shape_in_v2_only() {
        let texture = |x| format!("Texture \"a\" \"float\" \"constant\" \"float value\" {x} ");
        let world = texture(1)
            + "Material \"matte\" \"texture sigma\" \"a\" Shape \"sphere\" "
            + &texture(2)
            + "Shape \"sphere\" Shape \"sphere\"";
        for (dialect, changes) in [(Dialect::V2, true), (Dialect::V3, false)] {
            let (frame, errors, warnings) = frame(dialect, &world);
            // The warning is about the redefined texture.
            assert_eq!((errors, warnings), (0, 1));
            let made = materials(&frame);
            assert_eq!(made[0] != made[1], changes, "{dialect:?}");
            assert_eq!(made[1], made[2]);
            assert_eq!(frame.materials.len(), if changes { 2 } else { 1 });
        }
    }

    #[test]
    fn textures_may_come_after_the_material_in_v2() {
        let material = "Material \"matte\" \"texture sigma\" \"a\" ";
        let texture = "Texture \"a\" \"float\" \"constant\" ";
        let shape = "Shape \"sphere\"";
        let world = [material, texture, shape].concat();
        assert_eq!(frame(Dialect::V2, &world).1, 0);
        assert_eq!(frame(Dialect::V3, &world).1, 1);
        // Without the texture the shape reports the mistake, and several shapes report it once.
        let world = [material, shape, " ", shape].concat();
        assert_eq!(frame(Dialect::V2, &world).1, 1);
    }

    #[test]
    fn an_unknown_named_material_is_the_unnamed_one_in_v2() {
        let world = "Material \"mirror\" Shape \"sphere\"
            MakeNamedMaterial \"m\" \"string type\" \"matte\" NamedMaterial \"m\" Shape \"sphere\"
            NamedMaterial \"nope\" Shape \"sphere\"";
        let (v2, errors, warnings) = frame(Dialect::V2, world);
        assert_eq!((errors, warnings), (0, 1));
        assert_eq!(materials(&v2)[2], materials(&v2)[0]);
        let (v3, errors, warnings) = frame(Dialect::V3, world);
        assert_eq!((errors, warnings), (0, 1));
        assert_eq!(materials(&v3)[2], materials(&v3)[1]);
    }
}
