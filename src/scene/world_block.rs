//! The world block: its contents so far, and the directives that define textures and lights.

use super::description::{Frame, InstanceEntity, ObjectDefinition, ShapeEntity};
use super::interpreter::Interpreter;
use super::light_groups::LightGroups;
use super::names::MaterialName;
use super::options::Options;
use crate::handles::{LightLayer, MaterialId, ObjectId};
use crate::lights::{DiffuseAreaSpec, LightSpec};
use crate::materials::Material;
use crate::media::{MediaSpec, MediumInterface};
use crate::syntax::suggest::nearest;
use crate::syntax::{Diagnostic, Name, Span, Typed};
use crate::textures::{FloatTextureSpec, SpectrumTextureSpec, TextureSpecs};
use std::collections::HashMap;
use std::rc::Rc;

/// The contents of the block between `WorldBegin` and `WorldEnd` so far.
pub(super) struct WorldBlock {
    pub(super) opened: Span,
    /// There was no `WorldBegin`: a directive of the world block came first.
    pub(super) assumed: bool,
    textures: TextureSpecs,
    pub(super) materials: Vec<Material>,
    pub(super) material_names: Vec<MaterialName>,
    shapes: Vec<ShapeEntity>,
    pub(super) objects: Vec<ObjectDefinition>,
    pub(super) object_names: HashMap<String, ObjectId>,
    pub(super) open_object: Option<(ObjectDefinition, Span)>,
    pub(super) instances: Vec<InstanceEntity>,
    lights: Vec<LightSpec>,
    light_media: Vec<MediumInterface>,
    area_lights: Vec<DiffuseAreaSpec>,
    pub(super) light_groups: LightGroups,
    pub(super) default_material: Option<MaterialId>,
}

impl WorldBlock {
    pub(super) fn new(opened: Span) -> WorldBlock {
        WorldBlock {
            opened,
            assumed: false,
            textures: TextureSpecs::default(),
            materials: Vec::new(),
            material_names: Vec::new(),
            shapes: Vec::new(),
            objects: Vec::new(),
            object_names: HashMap::new(),
            open_object: None,
            instances: Vec::new(),
            lights: Vec::new(),
            light_media: Vec::new(),
            area_lights: Vec::new(),
            light_groups: LightGroups::default(),
            default_material: None,
        }
    }

    pub(super) fn add_area_light(&mut self, spec: DiffuseAreaSpec, layer: LightLayer) -> usize {
        self.area_lights.push(spec);
        self.light_groups.of_area_lights.push(layer);
        self.area_lights.len() - 1
    }

    /// Adds a shape to the open object, or to the world.
    pub(super) fn add_shape(&mut self, shape: ShapeEntity) {
        match &mut self.open_object {
            Some((object, _)) => object.shapes.push(shape),
            None => self.shapes.push(shape),
        }
    }

    /// Ends the open object, if there is one, and returns where it began.
    pub(super) fn finish_object(&mut self) -> Option<Span> {
        let (object, opened) = self.open_object.take()?;
        let id = ObjectId(self.objects.len() as u32);
        self.object_names.insert(object.name.clone(), id);
        self.objects.push(object);
        Some(opened)
    }

    /// Returns `true` if anything emits light.
    pub(super) fn has_lights(&self) -> bool {
        let objects = self.objects.iter().flat_map(|object| &object.shapes);
        let mut shapes = self.shapes.iter().chain(objects);
        !self.lights.is_empty() || shapes.any(|shape| shape.area_light.is_some())
    }

    pub(super) fn into_frame(self, options: Options, media: MediaSpec) -> Frame {
        Frame {
            options,
            textures: self.textures,
            materials: self.materials,
            material_names: self.material_names,
            shapes: self.shapes,
            objects: self.objects,
            instances: self.instances,
            lights: self.lights,
            light_media: self.light_media,
            area_lights: self.area_lights,
            light_groups: self.light_groups,
            media,
        }
    }
}

impl Interpreter<'_> {
    /// Handles `Texture "name" "type" "class"`.
    pub(super) fn texture(&mut self, span: Span, name: &Name, value_type: &Name, typed: Typed) {
        let ctm = self.current.ctm.start;
        let names = Rc::clone(&self.current.state.textures);
        let reading = self.reading(&names);
        let (redefined, problem) = match value_type.text.as_str() {
            "float" => {
                let spec = reading.read("Texture", span, &typed, |r| {
                    FloatTextureSpec::from_params(r, &ctm)
                });
                // A table that is still shared would be copied for every texture defined.
                drop(names);
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else {
                    return;
                };
                let (id, problem) = world.textures.add_float(spec);
                let state = &mut self.current.state;
                (state.define_float_texture(&name.text, id), problem)
            }
            "color" | "spectrum" => {
                let spec = reading.read("Texture", span, &typed, |r| {
                    SpectrumTextureSpec::from_params(r, &ctm)
                });
                drop(names);
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else {
                    return;
                };
                let (id, problem) = world.textures.add_spectrum(spec);
                let state = &mut self.current.state;
                (state.define_spectrum_texture(&name.text, id), problem)
            }
            other => {
                self.diagnostics.push(
                    Diagnostic::error(format!(
                        "textures are `float` or `spectrum`, not `{other}`; ignored"
                    ))
                    .at(value_type.span)
                    .recoverable()
                    .with_suggestion(nearest(other, ["float", "spectrum", "color"])),
                );
                return;
            }
        };
        if let Some(problem) = problem {
            self.diagnostics.push(
                Diagnostic::error(format!("texture `{}` {problem}", name.text))
                    .at(name.span)
                    .recoverable()
                    .label("a constant 0.5 is used to read on"),
            );
        }
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

    /// Handles `LightSource "type"`.
    pub(super) fn light_source(&mut self, span: Span, typed: &Typed) {
        let ctm = self.current.ctm.start;
        if self.current.ctm.is_animated() {
            self.warn(
                typed.kind.span,
                "a moving light is held at its start, as in pbrt-v3",
            );
        }
        let names = Rc::clone(&self.current.state.textures);
        let read = self.reading(&names).read("LightSource", span, typed, |r| {
            let group = LightGroups::name(r);
            LightSpec::from_params(r, &ctm).map(|light| (light, group))
        });
        let Some((light, group)) = read else { return };
        let layer = self.layer_of_group(span, group);
        let media = self.current_media();
        if let Some(world) = self.world.as_mut() {
            world.light_groups.of_lights.push(layer);
            world.lights.push(light);
            world.light_media.push(media);
        }
    }
}
