//! `Shape` and `AreaLightSource`: shapes with their part of the graphics state.

use super::description::ShapeEntity;
use super::graphics_state::MaterialDirective;
use super::interpreter::Interpreter;
use super::light_groups::LightGroups;
use super::materials::{read_material, texture_names};
use crate::handles::MaterialId;
use crate::lights::DiffuseAreaSpec;
use crate::materials::{Material, NamedMaterials};
use crate::params::{Dialect, ParamReader, may_change_material};
use crate::shapes::ShapeSpec;
use crate::syntax::{Diagnostic, ParamGroup, ParamList, Span, Typed};
use std::rc::Rc;

impl Interpreter<'_> {
    /// Handles `AreaLightSource "type"`: emission of the shapes after it; the type `""` ends it.
    pub(super) fn area_light_source(&mut self, span: Span, typed: &Typed) {
        let names = Rc::clone(&self.current.state.textures);
        let reading = self.reading(&names);
        let read = reading.read("AreaLightSource", span, typed, |r| {
            let group = LightGroups::name(r);
            DiffuseAreaSpec::from_params(r).map(|spec| (spec, group))
        });
        self.current.state.area_light = read.and_then(|(spec, group)| {
            let layer = self.layer_of_group(span, group);
            Some(self.world.as_mut()?.add_area_light(spec, layer))
        });
    }

    /// Handles `Shape "type"`.
    pub(super) fn shape(&mut self, span: Span, typed: &Typed) {
        self.find_late_material();
        let (material, spec) = self.read_shape(span, typed);
        let Some(spec) = spec else { return };
        let entity = ShapeEntity {
            area_light: self.area_light_of_shape(span, &spec),
            spec,
            world_from_shape: self.placement(),
            reverse_orientation: self.current.state.reverse_orientation,
            material,
            interface: self.interface_of_shape(),
            media: self.current_media(),
            span: file_name_span(typed).unwrap_or(span),
        };
        if let Some(world) = self.world.as_mut() {
            world.add_shape(entity);
        }
    }

    /// The shape and its material: the current one, or a new one if the shape's own parameters override the material's
    /// (docs/scene-language.md §2.4).
    fn read_shape(&mut self, span: Span, typed: &Typed) -> (Option<MaterialId>, Option<ShapeSpec>) {
        let current = self.current.state.material.clone();
        let names = Rc::clone(&self.current.state.textures);
        // pbrt-v2 (appendix A.1): named materials are complete once defined; others are created here, with the current
        // meaning of texture names.
        let v2 = self.dialect() == Dialect::V2;
        let fixed = v2 && current.as_ref().is_some_and(|m| m.named);
        let textured = |m: &Rc<MaterialDirective>| texture_names(&m.typed.params).next().is_some();
        let made_here = v2 && current.as_ref().is_some_and(textured);
        let overrides = !fixed && (made_here || may_change_material(&typed.params));
        let mut overridden = None;
        let named = self.materials_in_scope(None);
        let spec = self.reading(&names).read("Shape", span, typed, |reader| {
            let spec = ShapeSpec::from_params(reader);
            if overrides {
                overridden = Some(read_overridden(reader, current.as_deref(), &named));
            }
            spec
        });
        let base = match &current {
            Some(material) => material.id,
            None => self.default_material(),
        };
        let material = match overridden {
            None => base,
            Some(None) => None,
            Some(Some(material)) => self.same_or_new(base, material),
        };
        (material, spec)
    }

    fn area_light_of_shape(&mut self, shape: Span, spec: &ShapeSpec) -> Option<usize> {
        let area_light = self.current.state.area_light?;
        if !spec.can_emit() {
            let error = Diagnostic::error("a curve cannot be an area light (pbrt-v3 aborts here)");
            let hint = "end the light before it with AttributeEnd, or give the curve's place to thin cylinders";
            self.diagnostics.push(error.at(shape).with_help(hint));
            return None;
        }
        if self.current.ctm.is_animated() {
            self.warn(
                shape,
                "a moving shape cannot be an area light; it does not emit",
            );
            return None;
        }
        if self.world.as_ref()?.open_object.is_some() {
            self.diagnostics.push(
                Diagnostic::warning(
                    "an emitter inside an object glows but lights nothing, as in pbrt-v3",
                )
                .at(shape),
            );
        }
        Some(area_light)
    }
}

/// The location of the shape's file name, where problems with the file are shown.
fn file_name_span(shape: &Typed) -> Option<Span> {
    let name = shape.params.get("filename", ParamGroup::String)?;
    Some(name.value_span)
}

/// The material of a shape whose own parameters come before the material's.
fn read_overridden(
    shape: &ParamReader,
    current: Option<&MaterialDirective>,
    named: &dyn NamedMaterials,
) -> Option<Material> {
    let layered = match current {
        Some(MaterialDirective { typed, .. }) => shape.layered(&typed.kind.text, &typed.params),
        None => shape.layered("matte", const { &ParamList::EMPTY }),
    };
    read_material(&layered, named)
}
