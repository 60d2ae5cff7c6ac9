//! The filter on triangles: a Gaussian over an ellipse, cut along edges, its pieces weighed on the
//! neighbors.
//!
//! A place on a triangle has three heights, one over each edge in units of the triangle's: v over the edge
//! v = 0, w = 1 − u − v over the edge w = 0, and u over the edge u = 0. They add up to 1. The file's
//! square of texels holds the triangles of corners (i, j), (i + 1, j), (i, j + 1) below its diagonal, and
//! above it, turned about the square's center line, those of (i + 1, j + 1), (i, j + 1), (i + 1, j).

use super::sum::{self, Weighted};
use crate::assets::ptex::{Face, PtexFile, Resolution, Sample};
use crate::math::{Rgb, Vec2};
use std::cell::Cell;

/// Half-widths of the ellipse for a footprint's: three and a half standard deviations of the Gaussian. Below
/// three its end would show.
const KERNEL_WIDTH: f32 = 3.5;

/// Longest ellipses, as length by breadth.
const MAX_ECCENTRIC: f32 = 15.0;

/// Edges one may have to cross: six triangles are around a corner of a regular mesh, and an ellipse is no
/// wider than twice a triangle. Each piece is smaller than what it is of, so that this is never reached.
const MAX_CROSSED: u8 = 8;

/// Positions of heights in arrays: edge by edge.
const V: usize = 0;
const W: usize = 1;
const U: usize = 2;

/// The filtered value at `uv` of a face, of footprint [∂(u,v)/∂x, ∂(u,v)/∂y].
pub(super) fn filtered(file: &PtexFile, face: &Face, uv: Vec2, footprint: [Vec2; 2]) -> Rgb {
    let uv = uv.clamp(Vec2::ZERO, Vec2::ONE);
    let (ellipse, log2) = Ellipse::new(uv, footprint, face.resolution.u);
    let mut gathering = Gathering {
        file,
        log2,
        sum: Rgb::ZERO,
        weight: 0.0,
    };
    gathering.add_across(ellipse, face, 0);
    // Without weight, no texel's center is in the ellipse.
    sum::weighted_mean(file, face, gathering.sum, gathering.weight)
}

/// An ellipse, or a part of it: within heights, and where a quadratic form of the differences to the
/// center's heights is below 1.
#[derive(Clone, Copy, Debug)]
struct Ellipse {
    center: [f32; 3],
    low: [f32; 3],
    high: [f32; 3],
    /// Factors of the squared differences. As these add up to 0, every quadratic form is such a sum.
    form: [f32; 3],
}

impl Ellipse {
    /// Around `uv`, with the logarithm of the resolution to take. In the plane of an equilateral triangle it
    /// is no smaller than a texel and no longer than [`MAX_ECCENTRIC`] times its breadth.
    fn new(uv: Vec2, [x, y]: [Vec2; 2], finest: u8) -> (Ellipse, u8) {
        let root3 = 3.0f32.sqrt();
        // a du² + b du dv + c dv² = ac − b²/4 on its border (Heckbert 1989, §3.2).
        let a = 0.25 * (x.y * x.y + y.y * y.y);
        let b = -0.5 * (x.x * x.y + y.x * y.y);
        let c = 0.25 * (x.x * x.x + y.x * y.x);
        // The same for the equilateral triangle.
        let (mut ac, bc, mut cc) = (0.75 * a, 0.5 * root3 * (b - a), 0.25 * a - 0.5 * b + c);
        let spread = ((ac - cc) * (ac - cc) + bc * bc).sqrt();
        let squared = MAX_ECCENTRIC * MAX_ECCENTRIC;
        let for_length = 0.5 * ((squared + 1.0) / (squared - 1.0) * spread - (ac + cc));
        let texel = 0.5 / (1u32 << finest) as f32;
        let widening = for_length.max(texel * texel);
        ac += widening;
        cc += widening;
        let breadth = (2.0 * (ac * cc - 0.25 * bc * bc) / (ac + cc + spread)).sqrt();
        // The coarsest resolution with texels no wider than the ellipse: see `Axis::new`.
        let log2 = 127 - ((2.0 * breadth).to_bits() >> 23) as i32;
        let a = 4.0 / 3.0 * ac;
        let b = 2.0 / root3 * bc + a;
        let c = -0.25 * a + 0.5 * b + cc;
        let squared = KERNEL_WIDTH * KERNEL_WIDTH;
        let [a, b, c] = [a, b, c].map(|x| x * squared);
        let center = [uv.y, 1.0 - uv.x - uv.y, uv.x];
        // How far it reaches over each edge; no farther than a triangle.
        let reach = [a, a - b + c, c].map(|x| x.max(0.0).sqrt().min(1.0));
        let end = a * c - 0.25 * b * b;
        let ellipse = Ellipse {
            center,
            low: std::array::from_fn(|i| center[i] - reach[i]),
            high: std::array::from_fn(|i| center[i] + reach[i]),
            form: [c - 0.5 * b, 0.5 * b, a - 0.5 * b].map(|x| x / end),
        };
        (ellipse, log2.clamp(0, i32::from(finest)) as u8)
    }

    /// Takes off what is beyond an edge, and counts it from the neighbor whose edge `theirs` it is. The
    /// height over that edge changes its sign; the edges that follow it, counterclockwise, face those that
    /// follow this one, and heights over both add up to 1.
    fn split(&mut self, edge: usize, theirs: usize) -> Ellipse {
        let mut beyond = *self;
        beyond.high[edge] = 0.0;
        self.low[edge] = 0.0;
        let mut turned = beyond;
        for i in 0..3 {
            let (from, to) = ((edge + i) % 3, (theirs + i) % 3);
            let one = if i == 0 { 0.0 } else { 1.0 };
            turned.center[to] = one - beyond.center[from];
            turned.low[to] = one - beyond.high[from];
            turned.high[to] = one - beyond.low[from];
            turned.form[to] = beyond.form[from];
        }
        turned
    }

    /// Returns `true` if there is no place with such heights.
    fn is_empty(&self) -> bool {
        self.low.iter().sum::<f32>() >= 1.0 || self.high.iter().sum::<f32>() <= 1.0
    }

    /// The part within the triangle.
    fn clipped(&self) -> Ellipse {
        let low = self.low.map(|x| x.max(0.0));
        let sum: f32 = low.iter().sum();
        Ellipse {
            low,
            // What the two other heights leave.
            high: std::array::from_fn(|i| self.high[i].min(1.0 - (sum - low[i]))),
            ..*self
        }
    }

    /// Seen from the square's other half: u and 1 − v change places, and w changes its sign.
    fn turned(&self) -> Ellipse {
        let turn = |[v, w, u]: [f32; 3]| [1.0 - u, -w, 1.0 - v];
        Ellipse {
            center: turn(self.center),
            low: turn(self.high),
            high: turn(self.low),
            form: [self.form[U], self.form[W], self.form[V]],
        }
    }
}

/// A sum of weighted texels over faces.
struct Gathering<'a> {
    file: &'a PtexFile,
    /// Logarithm of the resolution to take.
    log2: u8,
    /// In units of the file's numbers.
    sum: Rgb,
    /// Of all texels.
    weight: f32,
}

impl Gathering<'_> {
    /// Adds what is on a face and beyond its edges. What is beyond an edge without neighbor is left out.
    fn add_across(&mut self, mut ellipse: Ellipse, face: &Face, crossed: u8) {
        if ellipse.is_empty() {
            return;
        }
        for edge in [U, V, W] {
            if ellipse.low[edge] >= 0.0 || crossed == MAX_CROSSED {
                continue;
            }
            if let Some(neighbor) = face.neighbor(edge as u8)
                && let Some(beside) = self.file.face(neighbor.face)
            {
                let beyond = ellipse.split(edge, usize::from(neighbor.edge));
                self.add_across(beyond, beside, crossed + 1);
            }
        }
        self.add(&ellipse.clipped(), face);
    }

    /// Adds the texels of a face, as coarse as it has them.
    fn add(&mut self, ellipse: &Ellipse, face: &Face) {
        let log2 = self.log2.min(face.resolution.u);
        let at = Resolution { u: log2, v: log2 };
        for part in [*ellipse, ellipse.turned()] {
            let texels = Half::new(&part, log2);
            let sum = match face.is_constant() {
                true => {
                    texels.for_each(|_, _| {});
                    texels.weight.get() * sum::mean(self.file, face)
                }
                false => sum::weighted(self.file, face, at, &texels),
            };
            self.sum += sum;
            self.weight += texels.weight.get();
        }
    }
}

/// The texels of an ellipse in one half of a square.
struct Half<'a> {
    ellipse: &'a Ellipse,
    /// Texels along an edge.
    side: i32,
    /// Bounds of their numbers over each edge: at least, and below.
    low: [i32; 3],
    high: [i32; 3],
    /// Of all texels, once they have been gone through.
    weight: Cell<f32>,
}

impl Half<'_> {
    fn new(ellipse: &Ellipse, log2: u8) -> Half<'_> {
        let side = 1 << log2;
        // A texel's center is a third of it over its edges.
        let number = |height: f32| (height * side as f32 - 1.0 / 3.0).ceil() as i32;
        Half {
            ellipse,
            side,
            low: ellipse.low.map(number),
            high: ellipse.high.map(number),
            weight: Cell::new(0.0),
        }
    }

    /// Calls `add` with the place in the square and the weight of every texel, and counts the weights.
    #[inline]
    fn for_each(&self, mut add: impl FnMut(usize, f32)) {
        let (side, ellipse) = (self.side, self.ellipse);
        let texel = 1.0 / side as f32;
        let height = |number: i32| (number as f32 + 1.0 / 3.0) * texel;
        let square = |height: f32, edge: usize| {
            let off = height - ellipse.center[edge];
            ellipse.form[edge] * off * off
        };
        let mut weights = 0.0;
        for v in self.low[V].max(0)..self.high[V].min(side) {
            // Numbers over the three edges add up to one less than there are texels along an edge.
            let from = self.low[U].max(side - v - self.high[W]).max(0);
            let to = self.high[U].min(side - v - self.low[W]).min(side);
            for u in from..to {
                let w = side - 1 - v - u;
                let form = square(height(v), V) + square(height(w), W) + square(height(u), U);
                if form < 1.0 {
                    let weight = (-0.5 * KERNEL_WIDTH * KERNEL_WIDTH * form).exp() * texel * texel;
                    weights += weight;
                    add((v * side + u) as usize, weight);
                }
            }
        }
        self.weight.set(weights);
    }
}

impl Weighted for Half<'_> {
    #[inline]
    fn of<S: Sample>(&self, texels: &[S], channels: usize) -> Rgb {
        let mut sum = Rgb::ZERO;
        self.for_each(|place, weight| sum += weight * sum::texel(texels, place, channels));
        sum
    }
}
