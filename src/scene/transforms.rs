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

    /// True where something moves. Bits are compared: a matrix that has overflowed holds numbers
    /// that are not equal to themselves, and still does not move.
    pub fn is_animated(&self) -> bool {
        let bits = |t: &Transform| t.m.to_cols_array().map(f64::to_bits);
        bits(&self.start) != bits(&self.end)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    #[test]
    fn what_cannot_be_inverted_does_not_move_for_that() {
        let mut ctm = Ctm::IDENTITY;
        ctm.change(ActiveTransform::All, |m| {
            *m * Transform::scale(DVec3::new(1.0, 0.0, f64::MAX))
        });
        ctm.change(ActiveTransform::All, |m| {
            *m * Transform::scale(DVec3::splat(f64::MAX))
        });
        assert!(!ctm.is_animated());
        ctm.change(ActiveTransform::End, |m| {
            *m * Transform::translate(DVec3::X)
        });
        assert!(ctm.is_animated());
    }
}
