//! Named objects and where they stand.

use super::description::{InstanceEntity, ObjectDefinition};
use super::interpreter::Interpreter;
use super::scopes::Scope;
use crate::handles::ObjectId;
use crate::syntax::{Diagnostic, Name, Span};

impl Interpreter<'_> {
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
                .passable()
                .related(*opened, "which begins here"),
            );
            return;
        }
        self.scopes.open(Scope::Object, span, &mut self.current);
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
            let error = Diagnostic::error(format!("there is no object `{}`; ignored", name.text));
            self.diagnostics
                .push_with_nearest(error.at(name.span).passable(), &name.text, known);
            return;
        };
        let world_from_object = self.placement();
        if let Some(world) = self.world.as_mut() {
            world.instances.push(InstanceEntity {
                object,
                world_from_object,
            });
        }
    }
}
