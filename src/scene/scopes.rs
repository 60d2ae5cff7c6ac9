//! Scopes: the state saved by `AttributeBegin`, `TransformBegin` and `ObjectBegin`, and restored at their ends.
//!
//! As in pbrt, attributes, objects and transforms share one stack of transformations, while only the former two also
//! save the graphics state. A transform scope that overlaps one of these therefore restores the wrong transformation
//! (docs/scene-language.md §2.1); this is reproduced, with a warning where it happens.

use super::graphics_state::{GraphicsState, SavedGraphicsState};
use super::transforms::Ctm;
use crate::syntax::{ActiveTransform, Diagnostic, Diagnostics, Span};

/// The directive that opened a scope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// `AttributeBegin`.
    Attribute,
    /// `TransformBegin`.
    Transform,
    /// `ObjectBegin`, which opens an attribute scope.
    Object,
}

impl Scope {
    /// The prefix of its directives.
    pub fn word(self) -> &'static str {
        match self {
            Scope::Attribute => "Attribute",
            Scope::Transform => "Transform",
            Scope::Object => "Object",
        }
    }
}

/// The state that a scope can change.
#[derive(Debug)]
pub struct Current {
    /// Graphics state.
    pub state: GraphicsState,
    /// Transformations.
    pub ctm: Ctm,
    /// Which of them later directives change.
    pub active: ActiveTransform,
}

impl Current {
    /// The state at the start of a file or frame.
    pub fn new() -> Current {
        Current {
            state: GraphicsState::new(),
            ctm: Ctm::IDENTITY,
            active: ActiveTransform::All,
        }
    }
}

impl Default for Current {
    fn default() -> Self {
        Current::new()
    }
}

#[derive(Debug)]
struct SavedTransform {
    ctm: Ctm,
    active: ActiveTransform,
    scope: Scope,
    opened: Span,
}

/// The open scopes: attributes and objects are on both stacks, transforms on one.
#[derive(Debug, Default)]
pub struct Scopes {
    transforms: Vec<SavedTransform>,
    states: Vec<SavedGraphicsState>,
}

impl Scopes {
    /// Opens a scope.
    pub fn open(&mut self, scope: Scope, opened: Span, current: &mut Current) {
        self.transforms.push(SavedTransform {
            ctm: current.ctm.clone(),
            active: current.active,
            scope,
            opened,
        });
        if scope != Scope::Transform {
            self.states.push(current.state.save());
        }
    }

    /// Closes a scope with an end of this kind, as pbrt-v3 does: the innermost one on the stacks that this kind uses.
    /// Attributes and objects are interchangeable there, and public scenes close either with the other's end; only
    /// overlap with a transform scope gives a warning, as it restores something unexpected. Returns `false`, and does
    /// nothing, if none is open.
    pub fn close(
        &mut self,
        scope: Scope,
        span: Span,
        current: &mut Current,
        diagnostics: &Diagnostics,
    ) -> bool {
        let with_state = scope != Scope::Transform;
        let open = !with_state || !self.states.is_empty();
        let Some(top) = self.transforms.pop_if(|_| open) else {
            return false;
        };
        if with_state != (top.scope != Scope::Transform) {
            let (ended, begun) = (scope.word(), top.scope.word());
            diagnostics.push(
                Diagnostic::warning(format!("`{ended}End` closes the scope of `{begun}Begin`"))
                    .at(span)
                    .label("restores the transformation, as in pbrt-v3")
                    .related(top.opened, "which begins here"),
            );
        }
        current.ctm = top.ctm;
        current.active = top.active;
        if let Some(state) = self.states.pop_if(|_| with_state) {
            current.state.restore(state);
        }
        true
    }

    /// Closes everything at the end of the world; an open object, whose `ObjectBegin` is at `open_object`, is reported
    /// by the caller.
    pub fn close_all(&mut self, open_object: Option<Span>, diagnostics: &Diagnostics) {
        for left in self.transforms.drain(..) {
            if left.scope != Scope::Object || Some(left.opened) != open_object {
                let message = format!("the scope of `{}Begin` is never closed", left.scope.word());
                diagnostics.push(Diagnostic::warning(message).at(left.opened));
            }
        }
        self.states.clear();
    }
}
