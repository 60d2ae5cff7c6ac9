//! The current transformation matrices (scene-language 2 and 2.2): one for the start and one for
//! the end of the shutter interval, with `ActiveTransform` saying which of them changes.

use crate::math::transform::Transform;
use crate::syntax::ActiveTransform;

/// The pair of current transformation matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Ctm {
    /// At the start time.
    pub start: Transform,
    /// At the end time.
    pub end: Transform,
}

impl Ctm {
    /// Identity at both times.
    pub const IDENTITY: Ctm = Ctm {
        start: Transform::IDENTITY,
        end: Transform::IDENTITY,
    };

    /// True where something moves.
    pub fn is_animated(&self) -> bool {
        self.start != self.end
    }

    /// CTM := f(CTM) for the active matrices.
    pub fn change(&mut self, active: ActiveTransform, f: impl Fn(&Transform) -> Transform) {
        if active != ActiveTransform::End {
            self.start = f(&self.start);
        }
        if active != ActiveTransform::Start {
            self.end = f(&self.end);
        }
    }
}
