//! Scopes: what `AttributeBegin`, `TransformBegin` and `ObjectBegin` save and their ends restore.
//!
//! As in pbrt, attributes, objects and transforms share one stack of transformations while only the
//! former two also save the graphics state. A transform crossed with one of these therefore restores
//! the wrong transformation (docs/scene-language.md §2.1); it is followed, with a warning where it happens.

use super::graphics_state::{GraphicsState, SavedGraphicsState};
use super::transforms::Ctm;
use crate::syntax::{ActiveTransform, Diagnostic, Diagnostics, Span};

/// Which directive opened a scope.
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
    /// What its directives begin with.
    pub fn word(self) -> &'static str {
        match self {
            Scope::Attribute => "Attribute",
            Scope::Transform => "Transform",
            Scope::Object => "Object",
        }
    }
}

/// All that a scope can change.
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
    /// At the start of a file or frame.
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

    /// Closes a scope at an end of this kind, as pbrt-v3 does: whichever was opened last, on the
    /// stacks that this kind is on. Attributes and objects are all one there, and public scenes
    /// close either with the other's end; only a crossing with a transform is warned of, which
    /// restores something else than it seems. False, and nothing done, where none is open.
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

    /// Closes everything at the end of the world; an object left open, whose `ObjectBegin` is at
    /// `open_object`, is the caller's to report.
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
