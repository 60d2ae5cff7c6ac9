//! What the world block builds up: textures, materials, lights, shapes, objects and instances.

use super::description::{Frame, InstanceEntity, ObjectDefinition, ShapeEntity};
use super::graphics_state::MaterialDirective;
use super::interpreter::Interpreter;
use super::options::Options;
use super::scopes::Scope;
use crate::handles::{FloatTextureId, MaterialId, ObjectId, SpectrumTextureId};
use crate::lights::{DiffuseAreaSpec, LightSpec};
use crate::materials::{self, Material};
use crate::params::{ParamReader, TextureNames};
use crate::shapes::ShapeSpec;
use crate::syntax::suggest::nearest;
use crate::syntax::{Diagnostic, Name, ParamGroup, ParamList, ParamType, ParamValue, Span, Typed};
use crate::textures::{FloatTextureSpec, SpectrumTextureSpec};
use std::collections::HashMap;
use std::rc::Rc;

/// What accumulates between `WorldBegin` and `WorldEnd`.
pub(super) struct WorldBlock {
    pub(super) opened: Span,
    float_textures: Vec<FloatTextureSpec>,
    spectrum_textures: Vec<SpectrumTextureSpec>,
    materials: Vec<Material>,
    shapes: Vec<ShapeEntity>,
    objects: Vec<ObjectDefinition>,
    object_names: HashMap<String, ObjectId>,
    pub(super) open_object: Option<(ObjectDefinition, Span)>,
    instances: Vec<InstanceEntity>,
    pub(super) lights: Vec<LightSpec>,
    pub(super) area_lights: Vec<DiffuseAreaSpec>,
    default_material: Option<MaterialId>,
}

impl WorldBlock {
    pub(super) fn new(opened: Span) -> WorldBlock {
        WorldBlock {
            opened,
            float_textures: Vec::new(),
            spectrum_textures: Vec::new(),
            materials: Vec::new(),
            shapes: Vec::new(),
            objects: Vec::new(),
            object_names: HashMap::new(),
            open_object: None,
            instances: Vec::new(),
            lights: Vec::new(),
            area_lights: Vec::new(),
            default_material: None,
        }
    }

    pub(super) fn into_frame(self, options: Options) -> Frame {
        Frame {
            options,
            float_textures: self.float_textures,
            spectrum_textures: self.spectrum_textures,
            materials: self.materials,
            shapes: self.shapes,
            objects: self.objects,
            instances: self.instances,
            lights: self.lights,
            area_lights: self.area_lights,
        }
    }
}

impl Interpreter<'_> {
    /// `Texture "name" "type" "class"`.
    pub(super) fn texture(&mut self, span: Span, name: &Name, value_type: &Name, typed: Typed) {
        let ctm = self.current.ctm.start;
        let names = Rc::clone(&self.current.state.textures);
        let reading = self.reading(&names);
        let redefined = match value_type.text.as_str() {
            "float" => {
                let spec = reading.read("Texture", span, &typed, |r| {
                    crate::textures::from_params_float(r, &ctm)
                });
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else {
                    return;
                };
                world.float_textures.push(spec);
                let id = FloatTextureId(world.float_textures.len() as u32 - 1);
                self.current.state.define_float_texture(&name.text, id)
            }
            "color" | "spectrum" => {
                let spec = reading.read("Texture", span, &typed, |r| {
                    crate::textures::from_params_spectrum(r, &ctm)
                });
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else {
                    return;
                };
                world.spectrum_textures.push(spec);
                let id = SpectrumTextureId(world.spectrum_textures.len() as u32 - 1);
                self.current.state.define_spectrum_texture(&name.text, id)
            }
            other => {
                self.diagnostics.push(
                    Diagnostic::error(format!(
                        "textures are `float` or `spectrum`, not `{other}`; ignored"
                    ))
                    .at(value_type.span)
                    .with_suggestion(nearest(other, ["float", "spectrum", "color"])),
                );
                return;
            }
        };
        if redefined {
            self.warn(
                name.span,
                format!(
                    "texture `{}` is defined again; later uses see this one",
                    name.text
                ),
            );
        }
    }

    /// The material of a `Material` or `MakeNamedMaterial`.
    pub(super) fn make_material(
        &mut self,
        word: &'static str,
        span: Span,
        typed: Typed,
    ) -> MaterialDirective {
        let names = Rc::clone(&self.current.state.textures);
        let material = self.reading(&names).read(word, span, &typed, read_material);
        let id = material.and_then(|m| self.add_material(m));
        MaterialDirective { typed, id }
    }

    fn add_material(&mut self, material: Material) -> Option<MaterialId> {
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
                    "`MakeNamedMaterial \"{}\"` does not say its type; ignored",
                    name.text
                ))
                .at(name.span)
                .with_help("add for example \"string type\" \"matte\""),
            );
            return;
        };
        typed.kind = kind;
        let material = self.make_material("MakeNamedMaterial", span, typed);
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

    /// `LightSource "type"`.
    pub(super) fn light_source(&mut self, span: Span, typed: &Typed) {
        let ctm = self.current.ctm.start;
        if self.current.ctm.is_animated() {
            self.warn(
                typed.kind.span,
                "a moving light is held at its start, as in pbrt-v3",
            );
        }
        let names = Rc::clone(&self.current.state.textures);
        let light = self.reading(&names).read("LightSource", span, typed, |r| {
            LightSpec::from_params(r, &ctm)
        });
        if let Some((light, world)) = light.zip(self.world.as_mut()) {
            world.lights.push(light);
        }
    }

    /// A shape, with all that the graphics state says of it.
    pub(super) fn shape(&mut self, span: Span, typed: &Typed) {
        if self.current.ctm.is_animated() {
            self.warn(
                span,
                "a moving shape is held at its start: motion blur is not supported yet",
            );
        }
        let (material, spec) = self.read_shape(span, typed);
        let Some(spec) = spec else { return };
        let entity = ShapeEntity {
            spec,
            world_from_shape: self.current.ctm.start,
            reverse_orientation: self.current.state.reverse_orientation,
            material,
            area_light: self.area_light(span),
            span,
        };
        let Some(world) = self.world.as_mut() else {
            return;
        };
        match &mut world.open_object {
            Some((object, _)) => object.shapes.push(entity),
            None => world.shapes.push(entity),
        }
    }

    /// The shape, and the material it gets: the current one, or a fresh one where the shape's own
    /// parameters override the material's (scene-language 2.4).
    fn read_shape(&mut self, span: Span, typed: &Typed) -> (Option<MaterialId>, Option<ShapeSpec>) {
        let current = self.current.state.material.clone();
        let names = Rc::clone(&self.current.state.textures);
        let mut overridden = None;
        let spec = self.reading(&names).read("Shape", span, typed, |reader| {
            let spec = ShapeSpec::from_params(reader);
            if may_set_material(&typed.params) {
                overridden = Some(read_overridden(reader, current.as_deref()));
            }
            spec
        });
        let material = match overridden {
            None => match &current {
                Some(material) => material.id,
                None => self.default_material(),
            },
            Some(None) => None,
            Some(Some(material)) => {
                let base = match &current {
                    Some(material) => material.id,
                    None => self.default_material(),
                };
                self.same_or_new(base, material)
            }
        };
        (material, spec)
    }

    /// The base material where the override changed nothing, so that a million shapes with a
    /// single-valued parameter of their own still share one material.
    fn same_or_new(&mut self, base: Option<MaterialId>, material: Material) -> Option<MaterialId> {
        let materials = &self.world.as_ref()?.materials;
        if base.is_some_and(|id| materials[id.index()] == material) {
            return base;
        }
        if let Some(last) = materials.last()
            && *last == material
        {
            return Some(MaterialId(materials.len() as u32 - 1));
        }
        self.add_material(material)
    }

    /// `matte` with its defaults, made when the first shape needs it.
    fn default_material(&mut self) -> Option<MaterialId> {
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

    fn area_light(&mut self, shape: Span) -> Option<usize> {
        let typed = self.current.state.area_light.clone()?;
        if self.current.ctm.is_animated() {
            self.warn(
                shape,
                "a moving shape cannot be an area light; it does not emit",
            );
            return None;
        }
        let names = Rc::clone(&self.current.state.textures);
        let spec = self.reading(&names).read(
            "AreaLightSource",
            typed.1,
            &typed.0,
            DiffuseAreaSpec::from_params,
        )?;
        let world = self.world.as_mut()?;
        if world.open_object.is_some() {
            self.diagnostics.push(
                Diagnostic::warning(
                    "an emitter inside an object glows but lights nothing, as in pbrt-v3",
                )
                .at(shape),
            );
        }
        let world = self.world.as_mut()?;
        if world.area_lights.last() != Some(&spec) {
            world.area_lights.push(spec);
        }
        Some(world.area_lights.len() - 1)
    }

    /// `ObjectBegin "name"`.
    pub(super) fn begin_object(&mut self, span: Span, name: Name) {
        let Some(world) = self.world.as_ref() else {
            return;
        };
        if let Some((open, opened)) = &world.open_object {
            self.diagnostics.push(
                Diagnostic::error(format!(
                    "`ObjectBegin` inside the object `{}`; ignored",
                    open.name
                ))
                .at(span)
                .related(*opened, "which begins here"),
            );
            return;
        }
        self.scopes.open(Scope::Object, span, &self.current);
        let object = ObjectDefinition {
            name: name.text,
            shapes: Vec::new(),
        };
        if let Some(world) = self.world.as_mut() {
            world.open_object = Some((object, span));
        }
    }

    /// `ObjectEnd`.
    pub(super) fn end_object(&mut self, span: Span) {
        let object = self.world.as_mut().and_then(|w| w.open_object.take());
        let Some((object, _)) = object else {
            self.error(span, "`ObjectEnd` without `ObjectBegin`; ignored");
            return;
        };
        self.scopes
            .close_object(&mut self.current, self.diagnostics);
        let Some(world) = self.world.as_mut() else {
            return;
        };
        let id = ObjectId(world.objects.len() as u32);
        world.object_names.insert(object.name.clone(), id);
        world.objects.push(object);
    }

    /// `ObjectInstance "name"`.
    pub(super) fn instance(&mut self, name: &Name) {
        let Some(world) = self.world.as_ref() else {
            return;
        };
        if world.open_object.is_some() {
            self.error(
                name.span,
                "`ObjectInstance` inside an object definition; ignored",
            );
            return;
        }
        let Some(&object) = world.object_names.get(&name.text) else {
            let known = world.object_names.keys().map(String::as_str);
            self.diagnostics.push(
                Diagnostic::error(format!("there is no object `{}`; ignored", name.text))
                    .at(name.span)
                    .with_suggestion(nearest(&name.text, known)),
            );
            return;
        };
        if self.current.ctm.is_animated() {
            self.warn(
                name.span,
                "a moving instance is held at its start: motion blur is not supported yet",
            );
        }
        let world_from_object = self.current.ctm.start;
        if let Some(world) = self.world.as_mut() {
            world.instances.push(InstanceEntity {
                object,
                world_from_object,
            });
        }
    }
}

/// A material, or `None` for a surface without one.
fn read_material(reader: &ParamReader) -> Option<Material> {
    if materials::is_none(reader.kind()) {
        reader.accept_all();
        return None;
    }
    Material::from_params(reader)
}

/// The material of a shape whose own parameters come before the material's.
fn read_overridden(shape: &ParamReader, current: Option<&MaterialDirective>) -> Option<Material> {
    match current {
        Some(MaterialDirective { typed, .. }) => {
            read_material(&shape.layered(&typed.kind.text, &typed.params))
        }
        None => read_material(&shape.layered("matte", const { &ParamList::EMPTY })),
    }
}

/// pbrt's test whether a shape's parameters might be meant for its material (scene-language 2.4).
fn may_set_material(params: &ParamList) -> bool {
    use ParamType as T;
    params.params.iter().any(|p| {
        let name = p.name.as_str();
        match p.ty {
            T::Texture => !matches!(name, "alpha" | "shadowalpha"),
            T::Float => single(&p.value, p.ty) && name != "radius",
            T::String => single(&p.value, p.ty) && !matches!(name, "filename" | "type" | "scheme"),
            _ => single(&p.value, p.ty),
        }
    })
}

/// The value of `"string type"`.
fn named_type(params: &ParamList) -> Option<Name> {
    let param = params.get("type", ParamGroup::String)?;
    param.used.set(true);
    match &param.value {
        ParamValue::Strings(names) => names.first().cloned(),
        _ => None,
    }
}

/// Does the parameter hold exactly one value of its type?
fn single(value: &ParamValue, ty: ParamType) -> bool {
    match value {
        ParamValue::Numbers(numbers) => numbers.len() == ty.items() || ty == ParamType::Spectrum,
        ParamValue::Strings(names) => names.len() == 1,
        ParamValue::Bools(bools) => bools.len() == 1,
    }
}
