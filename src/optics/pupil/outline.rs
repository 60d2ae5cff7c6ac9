//! The outline of the exit pupil as one film point sees it, found with real rays.
//!
//! A ray's *excess* is how far beyond the worst aperture it passes, in clear radii: the largest of
//! (height / clear radius) − 1 over all surfaces. It is a smooth function of where the ray is aimed, up to
//! kinks, and the outline is where it is 0; so false position finds it in about five rays, where
//! bisection to the same precision takes seventeen.

use super::rear::Rear;
use crate::optics::lens::Lens;

/// Directions in which the outline is sought, over half a turn: the other half is its mirror image. A
/// polygon around a circle with these corners is 0.14 % larger than the circle, and what [`super::ring`] adds
/// for kinks between two directions costs 0.4 %.
pub const DIRECTIONS: usize = 48;

/// The outline is found to this part of its distance from the middle.
const TOLERANCE: f64 = 1e-5;

/// The lens as seen from the film point (`radius`, 0) through a plane perpendicular to the axis.
/// Points on that plane are (x, y): along and across the film point's azimuth.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub lens: &'a Lens,
    /// Of the film point, mm from the axis.
    pub radius: f64,
    /// z of the plane.
    pub plane_z: f64,
}

/// The outline of the rays that pass, on the plane of a [`View`].
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// x of the middle of the region's extent along the azimuth.
    pub center: f64,
    /// The half with y ≥ 0, in order from +x to −x, relative to the middle, each just outside;
    /// `DIRECTIONS + 1` points.
    pub points: Vec<[f64; 2]>,
    /// How far the region may bend outward between neighbouring points: where it is convex it does not reach beyond
    /// the lines through the points on either side, and so not beyond where they meet. One point for each side
    /// that has such a point, relative to the middle, in order.
    pub bends: Vec<[f64; 2]>,
    /// A polygon with as many corners as `points` around every convex region through all of these.
    pub hull: Vec<[f64; 2]>,
}

impl View<'_> {
    /// Does the ray through `p` reach the scene?
    pub fn passes(&self, p: [f64; 2]) -> bool {
        let point = [p[0], p[1], self.plane_z];
        self.lens.trace_from_film([self.radius, 0.0], point).is_ok()
    }

    /// How far the ray through the point `p` in space passes beyond the worst aperture; infinite
    /// where it ends for another reason.
    fn excess(&self, p: [f64; 3]) -> f64 {
        let ray = self.lens.film_ray([self.radius, 0.0], p);
        let height = self.lens.tracer().largest_relative_height(&ray);
        height.map_or(f64::INFINITY, |h| h - 1.0)
    }

    /// Where the line from the film point through `p` meets the plane.
    pub fn on_plane(&self, p: [f64; 3]) -> [f64; 2] {
        let film_z = self.lens.film_z();
        let k = (self.plane_z - film_z) / (p[2] - film_z);
        [self.radius + k * (p[0] - self.radius), k * p[1]]
    }

    /// x of a ray in the meridional plane that passes; `None` where none does. `hint` is tried first.
    pub fn inside(&self, rear: &Rear, hint: Option<f64>) -> Option<f64> {
        let passes = |x: &f64| x.is_finite() && self.passes([*x, 0.0]);
        hint.filter(passes)
            .or_else(|| self.search(rear).filter(passes))
    }

    /// The ray in the meridional plane that passes all apertures with most room, or the first
    /// found that passes at all. It need not pass: then none does.
    fn search(&self, rear: &Rear) -> Option<f64> {
        // The excess of a ray aimed at a height of the rear element: each surface's part grows on both
        // sides of its zero, so their maximum has one valley, however narrow (a stop of a micrometre).
        let excess = |x: f64| self.excess(rear.point(x, 0.0));
        let scan = 64;
        let at = |i: usize| rear.radius() * (2.0 * i as f64 / scan as f64 - 1.0);
        let (best, value) = (0..=scan)
            .map(|i| (i, excess(at(i))))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        if !value.is_finite() {
            return None;
        }
        let bracket = [
            at(best.saturating_sub(1)),
            at(best),
            at((best + 1).min(scan)),
        ];
        let x = if value < 0.0 {
            at(best)
        } else {
            valley(excess, bracket)
        };
        Some(self.on_plane(rear.point(x, 0.0))[0])
    }

    /// The outline; `None` where no ray in the meridional plane passes. `hint` is an x that
    /// probably passes.
    pub fn outline(&self, rear: &Rear, hint: Option<f64>) -> Option<Outline> {
        let inside = self.inside(rear, hint)?;
        let from = |center: f64, direction: [f64; 2], guess: f64| {
            let at = |t: f64| {
                [
                    center + t * direction[0],
                    t * direction[1].max(0.0),
                    self.plane_z,
                ]
            };
            first_outside(|t| self.excess(at(t)), guess)
        };
        // The first step is found by doubling from next to nothing.
        let small = 1e-9 * rear.radius();
        let right = from(inside, [1.0, 0.0], small);
        let left = from(inside, [-1.0, 0.0], right);
        let (center, along) = (inside + 0.5 * (right - left), 0.5 * (right + left));
        let across = from(center, [0.0, 1.0], along);
        // Directions are spread over the ellipse with these axes, so that a thin region gets as
        // many corners at its ends as at its sides.
        let mut t = 1.0;
        let points: Vec<[f64; 2]> = (0..=DIRECTIONS)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
                let direction = [along * cos, across * sin.max(0.0)];
                t = match i {
                    0 | DIRECTIONS => 1.0,
                    _ => from(center, direction, t),
                };
                direction.map(|x| t * x)
            })
            .collect();
        // An aperture of size 0 lets a ray through but no light.
        let sound =
            along * across >= f64::MIN_POSITIVE && points.iter().flatten().all(|x| x.is_finite());
        (sound && center.is_finite()).then(|| Outline::new(center, points))
    }
}

impl Outline {
    fn new(center: f64, points: Vec<[f64; 2]>) -> Outline {
        let bends: Vec<(usize, [f64; 2])> = bends_of_sides(&points).collect();
        let mut factors = vec![1.0f64; points.len()];
        for (i, bend) in &bends {
            let factor = reach(points[*i], points[i + 1], *bend);
            for f in &mut factors[*i..=i + 1] {
                *f = f.max(factor);
            }
        }
        let hull = points.iter().zip(factors);
        let hull = hull.map(|(p, f)| p.map(|x| f * x)).collect();
        Outline {
            center,
            hull,
            bends: bends.into_iter().map(|(_, bend)| bend).collect(),
            points,
        }
    }

    /// In mm², of the whole region.
    pub fn area(&self) -> f64 {
        self.points.windows(2).map(|p| cross(p[0], p[1])).sum()
    }

    /// The points with the middle added.
    pub fn absolute(&self) -> impl Iterator<Item = [f64; 2]> {
        self.points.iter().map(|p| [self.center + p[0], p[1]])
    }
}

/// For each side between neighbouring `points` that has a bend (see [`Outline::bends`]) its number and that point.
fn bends_of_sides(points: &[[f64; 2]]) -> impl Iterator<Item = (usize, [f64; 2])> {
    let last = points.len() - 1;
    let mirrored = |p: [f64; 2]| [p[0], -p[1]];
    (0..last).filter_map(move |i| {
        let before = if i == 0 {
            mirrored(points[1])
        } else {
            points[i - 1]
        };
        let after = if i + 1 == last {
            mirrored(points[last - 1])
        } else {
            points[i + 2]
        };
        bend(before, points[i], points[i + 1], after).map(|bend| (i, bend))
    })
}

/// Where the lines `a`–`b` and `d`–`c` meet beyond the side `b`–`c`; `None` where they do not.
fn bend(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> Option<[f64; 2]> {
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let (ab, dc, bc) = (minus(b, a), minus(c, d), minus(c, b));
    let s = cross(bc, dc) / cross(ab, dc);
    let apex = [b[0] + s * ab[0], b[1] + s * ab[1]];
    // Nearly parallel lines meet far off. A true corner reaches 1.2 times as far as its neighbours only
    // if it is much sharper than a right angle.
    let factor = reach(b, c, apex);
    (s > 0.0 && factor > 1.0 && factor < 1.2).then_some(apex)
}

/// How far out `p` lies, relative to the line `a`–`b` in the same direction from 0.
pub(super) fn reach(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (cross(p, b) + cross(a, p)) / cross(a, b)
}

/// Twice the area of the triangle 0, `a`, `b`; positive where `b` is counterclockwise of `a`.
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The smallest t, to [`TOLERANCE`] and not below, where `excess` becomes positive; it is not at
/// t = 0. Brackets it from `guess` by steps that double each time, then narrows the bracket by false
/// position (the Illinois form: Dowell and Jarratt, BIT 11, 1971), with the estimate moved to
/// the far side by half the tolerance so that both ends close in.
fn first_outside(excess: impl Fn(f64) -> f64, guess: f64) -> f64 {
    let (mut low, mut high) = bracket(&excess, guess);
    let mut last_side = 0;
    // False position needs a handful of steps; every fourth is a bisection, so that none takes
    // more than 4·17.
    for step in 1..80 {
        let width = high.t - low.t;
        let tolerance = TOLERANCE * high.t;
        // Also where there is nothing to narrow: no end inside, or none outside.
        if !(width > tolerance && high.t.is_finite()) {
            break;
        }
        let t = if step % 4 == 0 || !high.value.is_finite() || !low.value.is_finite() {
            low.t + 0.5 * width
        } else {
            let t = low.t + width * low.value / (low.value - high.value);
            let toward = if t - low.t < high.t - t { 0.45 } else { -0.45 };
            let t = t + toward * tolerance;
            t.max(low.t + 0.4 * tolerance).min(high.t - 0.4 * tolerance)
        };
        let value = excess(t);
        let side = if value > 0.0 || value.is_nan() { 1 } else { -1 };
        if side > 0 {
            high = End { t, value };
        } else {
            low = End { t, value };
        }
        if side == last_side {
            // The end that stays is given half its weight.
            let stays = if side > 0 { &mut low } else { &mut high };
            stays.value *= 0.5;
        }
        last_side = side;
    }
    high.t
}

/// One end of a bracket.
#[derive(Clone, Copy)]
struct End {
    t: f64,
    value: f64,
}

/// An end inside and one outside, next to each other around the first change.
fn bracket(excess: &impl Fn(f64) -> f64, guess: f64) -> (End, End) {
    let at = |t: f64| End {
        t,
        value: excess(t),
    };
    let outside = |e: &End| e.value > 0.0 || e.value.is_nan();
    let start = at(guess);
    let (mut low, mut high) = (start, start);
    let mut factor: f64 = 1.0 / 64.0;
    // Factors 1 + 2^k/64 leave the range of f64 within 60 steps either way.
    if outside(&start) {
        for _ in 0..60 {
            low = at(high.t / (1.0 + factor));
            if !outside(&low) {
                break;
            }
            (high, factor) = (low, 2.0 * factor);
        }
    } else {
        for _ in 0..60 {
            high = at(low.t * (1.0 + factor));
            if outside(&high) {
                break;
            }
            (low, factor) = (high, 2.0 * factor);
        }
    }
    (low, high)
}

/// The lowest point of `f` between `a` and `c`, where `b` between them is lower than both ends, or the
/// first point found where it is negative: golden section (Press et al., *Numerical Recipes*, §10.2),
/// with infinite values allowed.
fn valley(f: impl Fn(f64) -> f64, [mut a, mut b, mut c]: [f64; 3]) -> f64 {
    const GOLDEN: f64 = 0.381_966_011_250_105;
    let mut lowest = f(b);
    // 60 steps narrow the bracket by 3e-13.
    for _ in 0..60 {
        if lowest < 0.0 {
            break;
        }
        let right = c - b > b - a;
        let x = if right {
            b + GOLDEN * (c - b)
        } else {
            b - GOLDEN * (b - a)
        };
        let value = f(x);
        match (value < lowest, right) {
            (true, true) => (a, b) = (b, x),
            (true, false) => (c, b) = (b, x),
            (false, true) => c = x,
            (false, false) => a = x,
        }
        lowest = lowest.min(value);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_change_is_found_in_few_steps() {
        for (edge, guess) in [(1.0, 1.0), (1.0, 1.3), (7.0, 6.9), (1e-6, 1.0), (3.0, 1e-9)] {
            // A kink just inside, as where two apertures meet.
            let excess = |t: f64| {
                let x: f64 = t / edge - 1.0;
                if x > -0.01 {
                    x
                } else {
                    0.3 * (x + 0.01) - 0.01
                }
            };
            let calls = std::cell::Cell::new(0);
            let found = first_outside(
                |t| {
                    calls.set(calls.get() + 1);
                    excess(t)
                },
                guess,
            );
            assert!(excess(found) > 0.0 && excess(found * (1.0 - TOLERANCE)) <= 0.0);
            // Doubling over nine powers of ten takes 30 steps, the rest is false position.
            let limit = if guess / edge > 0.5 && guess / edge < 2.0 {
                16
            } else {
                50
            };
            assert!(calls.get() <= limit, "{edge} {guess}: {}", calls.get());
        }
        // Where rays end without a height, bisection does.
        let wall = |t: f64| if t > 2.5 { f64::INFINITY } else { -1.0 };
        let found = first_outside(wall, 2.0);
        assert!(found > 2.5 && found < 2.5 * (1.0 + TOLERANCE));
        // Nothing outside, nothing inside, nothing at all: it ends.
        assert!(first_outside(|_| -1.0, 1.0) > 1e100);
        assert!(first_outside(|_| 1.0, 1.0) < 1e-100);
        first_outside(|_| f64::NAN, 1.0);
    }
}
