//! A separable kernel over texels of a quadrilateral, and its way from face to face.

use super::axis::Axis;
use super::sum::{self, Weighted};
use crate::assets::ptex::{Border, Resolution, Sample};
use crate::math::{Rgb, Vec2};

/// Edges of a quadrilateral, counterclockwise: v = 0, u = 1, v = 1, u = 0.
pub(super) const BOTTOM: u8 = 0;
/// See [`BOTTOM`].
pub(super) const RIGHT: u8 = 1;
/// See [`BOTTOM`].
pub(super) const TOP: u8 = 2;
/// See [`BOTTOM`].
pub(super) const LEFT: u8 = 3;

/// Weights of a rectangle of texels: products of one along u and one along v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel {
    pub u: Axis,
    pub v: Axis,
    /// Quarter turns, counterclockwise, from the face that was asked for to this one.
    pub turns: u8,
}

impl Kernel {
    /// Around `uv` for a footprint of this width and height, on a face of this resolution. A subface is
    /// half of what the filter takes for a face.
    pub(super) fn new(uv: Vec2, width: Vec2, finest: Resolution, is_subface: bool) -> Kernel {
        let axis = |u, width, log2| match is_subface {
            false => Axis::new(u, width, log2),
            true => {
                let mut axis = Axis::new(0.5 * u, 0.5 * width, log2 + 1);
                axis.enter_half_face();
                axis
            }
        };
        Kernel {
            u: axis(uv.x, width.x, finest.u),
            v: axis(uv.y, width.y, finest.v),
            turns: 0,
        }
    }

    /// Sum of all weights.
    pub(super) fn weight(&self) -> f32 {
        self.u.sum() * self.v.sum()
    }

    /// Returns `true` if there are no texels.
    pub(super) fn is_empty(&self) -> bool {
        self.u.weights().is_empty() || self.v.weights().is_empty()
    }

    /// The direction that leads across an edge, and whether the edge is at its high end.
    fn across(&mut self, edge: u8) -> (&mut Axis, bool) {
        match edge & 3 {
            BOTTOM => (&mut self.v, false),
            RIGHT => (&mut self.u, true),
            TOP => (&mut self.v, true),
            _ => (&mut self.u, false),
        }
    }

    /// Returns `true` if some of it is beyond this edge.
    pub(super) fn crosses(&self, edge: u8) -> bool {
        match edge & 3 {
            BOTTOM => self.v.start < 0,
            RIGHT => self.u.end() > self.u.size(),
            TOP => self.v.end() > self.v.size(),
            _ => self.u.start < 0,
        }
    }

    /// Takes off what is beyond an edge: see [`Axis::split`].
    pub(super) fn split(&mut self, edge: u8) -> Kernel {
        let mut beyond = *self;
        let (axis, high) = self.across(edge);
        *beyond.across(edge).0 = axis.split(high);
        beyond
    }

    /// Puts what is beyond an edge without neighbor back: see [`Axis::merge`].
    pub(super) fn merge(&mut self, edge: u8, [u, v]: [Border; 2]) {
        let border = if edge & 1 == 1 { u } else { v };
        let (axis, high) = self.across(edge);
        axis.merge(high, border);
    }

    /// Counts from a face that is turned by so many quarters clockwise, so that the kernel turns
    /// counterclockwise.
    pub(super) fn rotate(&mut self, quarters: u8) {
        let quarters = quarters & 3;
        if quarters == 1 || quarters == 2 {
            self.u.flip();
        }
        if quarters == 2 || quarters == 3 {
            self.v.flip();
        }
        if quarters == 1 || quarters == 3 {
            std::mem::swap(&mut self.u, &mut self.v);
        }
        self.turns = (self.turns + quarters) & 3;
    }

    /// After a split from a whole face: counts from the first of the two subfaces beyond `edge`, or from
    /// the second. `true` where it is the first, as one comes to them counterclockwise around their face.
    pub(super) fn enter_subface(&mut self, edge: u8) -> bool {
        self.u.enter_half_face();
        self.v.enter_half_face();
        let (across, edge_is_high) = self.across(edge);
        if !edge_is_high {
            across.start -= across.size();
        }
        let (along, _) = self.across(edge + 1);
        let in_high_half = along.start >= along.size();
        if in_high_half {
            along.start -= along.size();
        }
        // Counterclockwise one comes to the high half first on the top and on the left.
        in_high_half == matches!(edge & 3, TOP | LEFT)
    }

    /// After a split from a subface: counts from the whole face beyond `edge`, of which that edge is the
    /// half that follows its low corner on the right, and so on around.
    pub(super) fn leave_subface(&mut self, edge: u8) {
        let (in_high_u, in_high_v) = match edge & 3 {
            BOTTOM => (false, true),
            RIGHT => (false, false),
            TOP => (true, false),
            _ => (true, true),
        };
        self.u.leave_half_face(in_high_u);
        self.v.leave_half_face(in_high_v);
    }

    /// As coarse as a face is, where it is finer.
    pub(super) fn coarsen(&mut self, finest: Resolution) {
        while self.u.log2 > finest.u {
            self.u.halve();
        }
        while self.v.log2 > finest.v {
            self.v.halve();
        }
    }

    /// The resolution whose texels it weighs.
    pub(super) fn resolution(&self) -> Resolution {
        Resolution {
            u: self.u.log2,
            v: self.v.log2,
        }
    }
}

impl Weighted for Kernel {
    #[inline]
    fn of<S: Sample>(&self, texels: &[S], channels: usize) -> Rgb {
        let row = self.u.size() as usize;
        let (u, v) = (self.u.start as usize, self.v.start as usize);
        let mut all = Rgb::ZERO;
        for (y, weight) in (v..).zip(self.v.weights()) {
            let mut sum = Rgb::ZERO;
            for (x, weight) in (u..).zip(self.u.weights()) {
                sum += *weight * sum::texel(texels, y * row + x, channels);
            }
            all += *weight * sum;
        }
        all
    }
}
