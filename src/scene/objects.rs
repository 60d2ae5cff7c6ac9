//! Named objects and their instances.

use super::description::{InstanceEntity, ObjectDefinition};
use super::interpreter::Interpreter;
use super::scopes::Scope;
use super::world_block::WorldBlock;
use crate::syntax::{Diagnostic, Name, Span};

impl Interpreter<'_> {
    /// Handles `ObjectBegin "name"`. Inside another object it ends that one, as in pbrt-v3, and leaves its scope open.
    pub(super) fn begin_object(&mut self, span: Span, name: Name) {
        if let Some((open, opened)) = self.world.as_ref().and_then(|w| w.open_object.as_ref()) {
            let message = format!(
                "`ObjectBegin` inside the object `{}`, which ends here",
                open.name
            );
            self.diagnostics.push(
                Diagnostic::error(message)
                    .at(span)
                    .recoverable()
                    .related(*opened, "which begins here"),
            );
        }
        self.scopes.open(Scope::Object, span, &mut self.current);
        let object = ObjectDefinition {
            name: name.text,
            shapes: Vec::new(),
        };
        if let Some(world) = self.world.as_mut() {
            world.finish_object();
            world.open_object = Some((object, span));
        }
    }

    /// Handles `ObjectEnd`: ends the object, and closes the innermost scope, whatever opened it.
    pub(super) fn end_object(&mut self, span: Span) {
        let opened = self.world.as_mut().and_then(WorldBlock::finish_object);
        let closed = self.close_scope(Scope::Object, span);
        match (opened, closed) {
            (Some(_), true) => {}
            (Some(opened), false) => self.diagnostics.push(
                Diagnostic::error("`ObjectEnd` finds no open scope to close")
                    .at(span)
                    .recoverable()
                    .related(opened, "an end since then has closed this one's"),
            ),
            (None, true) => self.error(
                span,
                "`ObjectEnd` without `ObjectBegin`: it only closes a scope, as in pbrt-v3",
            ),
            (None, false) => self.error(span, "`ObjectEnd` without `ObjectBegin`; ignored"),
        }
    }

    /// Handles `ObjectInstance "name"`.
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
            self.diagnostics.push_with_nearest(
                error.at(name.span).recoverable(),
                &name.text,
                known,
            );
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
