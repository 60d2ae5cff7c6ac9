//! The current transformation matrices (docs/scene-language.md §2 and §2.2): one for the start and one for the end of
//! the shutter interval; `ActiveTransform` selects which of them changes.

use crate::math::motion::Motion;
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

    /// Returns `true` if anything moves. Bits are compared: a matrix that has overflowed contains NaN, which does not
    /// equal itself, but it does not move.
    pub fn is_animated(&self) -> bool {
        let bits = |t: &Transform| t.m.to_cols_array().map(f64::to_bits);
        bits(&self.start) != bits(&self.end)
    }

    /// The placement stored in a scene, with the times of `TransformTimes`.
    pub fn placement(&self, times: [f64; 2]) -> Placement {
        Placement {
            start: self.start,
            end: self.is_animated().then_some(Box::new(End {
                transform: self.end,
                times,
            })),
        }
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

/// A placement, static or moving.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// The transformation, at the start time if it changes.
    pub start: Transform,
    /// The end of the motion, if there is one.
    pub end: Option<Box<End>>,
}

/// The end of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// The transformation at the end time.
    pub transform: Transform,
    /// Start and end time (`TransformTimes`).
    pub times: [f64; 2],
}

impl Placement {
    /// Returns `true` if this is invertible at both times.
    pub fn is_invertible(&self) -> bool {
        let end = self.end.as_ref();
        self.start.is_invertible() && end.is_none_or(|end| end.transform.is_invertible())
    }

    /// The motion; `None` if nothing moves, or an end is not invertible.
    pub fn motion(&self) -> Option<Motion> {
        let End { transform, times } = self.end.as_deref()?;
        Motion::new(&self.start, transform, *times)
    }

    /// The inverse transformations.
    pub fn inverted(&self) -> Placement {
        let end = self.end.as_ref().map(|end| {
            Box::new(End {
                transform: end.transform.inverted(),
                times: end.times,
            })
        });
        Placement {
            start: self.start.inverted(),
            end,
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
