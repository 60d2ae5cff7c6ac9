//! Scopes: what `AttributeBegin`, `TransformBegin` and `ObjectBegin` save and their ends restore.
//!
//! As in pbrt, attributes and transforms share one stack of transformations while only the former
//! also save the graphics state. Crossed nesting therefore restores the wrong transformation
//! (docs/scene-language.md §2.1); it is followed, with a warning where it happens.

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
    /// `ObjectBegin`, which implies an attribute scope.
    Object,
}

impl Scope {
    fn word(self) -> &'static str {
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

#[derive(Debug)]
struct SavedState {
    state: SavedGraphicsState,
    scope: Scope,
}

/// The open scopes: attributes and objects are on both stacks, transforms on one.
#[derive(Debug, Default)]
pub struct Scopes {
    transforms: Vec<SavedTransform>,
    states: Vec<SavedState>,
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
            let state = current.state.save();
            self.states.push(SavedState { state, scope });
        }
    }

    /// Closes a scope: `AttributeEnd` or `TransformEnd`. An object's own scope stays closed to
    /// both, and `AttributeEnd` needs an `AttributeBegin` somewhere.
    pub fn close(
        &mut self,
        scope: Scope,
        span: Span,
        current: &mut Current,
        diagnostics: &Diagnostics,
    ) {
        let state_is_there = || {
            self.states
                .last()
                .is_some_and(|top| top.scope == Scope::Attribute)
        };
        let matched = scope == Scope::Transform || state_is_there();
        let top = self
            .transforms
            .pop_if(|top| matched && top.scope != Scope::Object);
        let Some(top) = top else {
            let word = scope.word();
            let message = format!("`{word}End` without a matching `{word}Begin`; ignored");
            diagnostics.push(Diagnostic::error(message).at(span).passable());
            return;
        };
        if top.scope != scope {
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
        if scope == Scope::Attribute
            && let Some(saved) = self.states.pop()
        {
            current.state.restore(saved.state);
        }
    }

    /// Closes an object's scope and whatever was left open inside it.
    pub fn close_object(&mut self, current: &mut Current, diagnostics: &Diagnostics) {
        while let Some(top) = self.transforms.pop() {
            current.ctm = top.ctm.clone();
            current.active = top.active;
            if top.scope == Scope::Object {
                break;
            }
            never_closed(&top, diagnostics);
        }
        while let Some(top) = self.states.pop() {
            current.state.restore(top.state);
            if top.scope == Scope::Object {
                break;
            }
        }
    }

    /// Closes everything at the end of the world; an object left open is the caller's to report.
    pub fn close_all(&mut self, diagnostics: &Diagnostics) {
        for left in self.transforms.drain(..) {
            if left.scope != Scope::Object {
                never_closed(&left, diagnostics);
            }
        }
        self.states.clear();
    }
}

fn never_closed(scope: &SavedTransform, diagnostics: &Diagnostics) {
    let message = format!("`{}Begin` is never closed", scope.scope.word());
    diagnostics.push(Diagnostic::warning(message).at(scope.opened));
}
