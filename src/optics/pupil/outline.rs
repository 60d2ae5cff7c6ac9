//! The outline of the exit pupil as one film point sees it, found with real rays.
//!
//! A ray's *excess* is how far beyond the worst aperture it passes, in clear radii: the largest of
//! (height / clear radius) − 1 over all surfaces. It is a smooth function of where the ray is aimed, up to
//! kinks, and the outline is where it is 0; so false position finds it in about five rays, where
//! bisection to the same precision takes seventeen.

use super::search::Search;
use super::survey::Survey;
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::optics::lanes::{Doubles, FilmTracer};

/// Rays that are traced side by side: their directions' searches need not wait for each other.
pub(in crate::optics) const LANES: usize = 16;

/// Directions in which the outline is sought, over half a turn: the other half is its mirror image. A
/// polygon around a circle with these corners is 0.14 % larger than the circle, and what [`super::ring`] adds
/// for kinks between two directions costs 0.4 %.
pub(super) const DIRECTIONS: usize = 48;

/// The lens as seen from the film point (`radius`, 0) through a plane perpendicular to the axis.
/// Points on that plane are (x, y): along and across the film point's azimuth.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    /// The lens and the plane.
    pub survey: &'a Survey,
    /// Of the film point, mm from the axis.
    pub radius: f64,
}

/// Where the outline of a neighboring film point is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hint {
    /// x of a ray that probably passes.
    pub inside: f64,
    /// About half the extent along x, mm.
    pub size: f64,
}

/// The outline of the rays that pass, on the plane of a [`View`].
#[derive(Clone, Debug)]
pub(super) struct Outline {
    /// x of the middle of the region's extent along the azimuth.
    pub center: f64,
    /// The half with y ≥ 0, in order from +x to −x, relative to the middle, each just outside;
    /// `DIRECTIONS + 1` points.
    pub points: Vec<[f64; 2]>,
    /// How far the region may bend outward between neighboring points: where it is convex it does not reach beyond
    /// the lines through the points on either side, and so not beyond where they meet. One point for each side
    /// that has such a point, relative to the middle, in order.
    pub bends: Vec<[f64; 2]>,
    /// A polygon with as many corners as `points` around every convex region through all of these.
    pub hull: Vec<[f64; 2]>,
}

impl View<'_> {
    /// Returns `true` if the ray through `p` reaches the scene.
    pub(super) fn passes(&self, p: [f64; 2]) -> bool {
        let film = [self.radius, 0.0];
        let mut tracers = self.survey.tracers.iter();
        tracers.any(|tracer| tracer.trace(&film, &p).passed)
    }

    /// How far the rays through these points pass beyond the worst aperture; infinite where they end for
    /// another reason.
    fn excess(&self, p: [Doubles<LANES>; 2]) -> [f64; LANES] {
        let film = [self.radius, 0.0].map(Doubles::splat);
        vectorize::<LANES, _>(Excess {
            tracers: &self.survey.tracers,
            film,
            p,
        })
    }

    /// The same for one.
    fn excess_of(&self, p: [f64; 2]) -> f64 {
        let film = [self.radius, 0.0];
        let tracers = self.survey.tracers.iter();
        let one = |tracer: &FilmTracer<f64>| {
            let (height2, whole) = tracer.largest_relative_height2(&film, &p);
            excess(height2, whole)
        };
        tracers.map(one).fold(f64::INFINITY, f64::min)
    }

    /// Where the line from the film point through `p` meets the plane.
    pub(super) fn on_plane(&self, p: [f64; 3]) -> [f64; 2] {
        let film_z = self.survey.film_z;
        let k = (self.survey.plane_z - film_z) / (p[2] - film_z);
        [self.radius + k * (p[0] - self.radius), k * p[1]]
    }

    /// x of a ray in the meridional plane that passes; `None` where none does. `hint` is tried first.
    pub(super) fn inside(&self, hint: Option<f64>) -> Option<f64> {
        let passes = |x: &f64| x.is_finite() && self.passes([*x, 0.0]);
        // Straight ahead is where light goes whose film all but touches the glass.
        hint.filter(passes)
            .or(Some(self.radius).filter(passes))
            .or_else(|| self.search().filter(passes))
    }

    /// The ray in the meridional plane that passes all apertures with most room, or the first
    /// found that passes at all. It need not pass: then none does.
    fn search(&self) -> Option<f64> {
        // The excess of a ray aimed at a height of the rear element: each surface's part grows on both
        // sides of its zero, so their maximum has one valley, however narrow (a stop of a micrometer).
        // One ray is aimed at the very middle: with the film at the vertex none but those near it get
        // anywhere.
        let (rear, scan) = (&self.survey.rear, 4 * LANES);
        let at = |i: usize| rear.radius() * (2.0 * i as f64 / scan as f64 - 1.0);
        let on_plane = |x: f64| self.on_plane(rear.point(x, 0.0));
        let bundles = (0..scan).step_by(LANES).flat_map(|first| {
            let points: [[f64; 2]; LANES] = std::array::from_fn(|i| on_plane(at(first + i)));
            self.excess([0, 1].map(|k| Doubles(points.map(|p| p[k]))))
        });
        let (best, value) = bundles.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        if !value.is_finite() {
            return None;
        }
        let bracket = [at(best.saturating_sub(1)), at(best), at(best + 1)];
        let x = if value < 0.0 {
            at(best)
        } else {
            valley(|x| self.excess_of(on_plane(x)), bracket)
        };
        Some(on_plane(x)[0])
    }

    /// The outline; `None` where no ray in the meridional plane passes.
    pub(super) fn outline(&self, hint: Option<Hint>) -> Option<Outline> {
        let inside = self.inside(hint.map(|h| h.inside))?;
        // Without a hint the first step is found by doubling from next to nothing.
        let size = hint.map_or(1e-9 * self.survey.rear.radius(), |h| h.size);
        let [right, left] = self.reaches(inside, [[1.0, 0.0], [-1.0, 0.0]], size);
        let (center, along) = (inside + 0.5 * (right - left), 0.5 * (right + left));
        let [across] = self.reaches(center, [[0.0, 1.0]], along);
        // Directions are spread over the ellipse with these axes, so that a thin region gets as
        // many corners at its ends as at its sides.
        let directions: [[f64; 2]; DIRECTIONS + 1] = std::array::from_fn(|i| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
            [along * cos, across * sin.max(0.0)]
        });
        let mut reaches = self.reaches(center, directions, 1.0);
        // These are known.
        reaches[0] = 1.0;
        reaches[DIRECTIONS] = 1.0;
        let points: Vec<[f64; 2]> = (0..=DIRECTIONS)
            .map(|i| directions[i].map(|x| reaches[i] * x))
            .collect();
        // An aperture of size 0 lets a ray through but no light.
        let sound =
            along * across >= f64::MIN_POSITIVE && points.iter().flatten().all(|x| x.is_finite());
        (sound && center.is_finite()).then(|| Outline::new(center, points))
    }

    /// See [`reaches`].
    fn reaches<const D: usize>(
        &self,
        center: f64,
        directions: [[f64; 2]; D],
        guess: f64,
    ) -> [f64; D] {
        reaches(|p| self.excess(p), center, directions, guess)
    }
}

/// For each direction how far from (`center`, 0) rays pass, in units of its length; `guess` is about as far. `excess` tells how far rays
/// through these points pass beyond the worst aperture.
pub(in crate::optics) fn reaches<const D: usize>(
    excess: impl Fn([Doubles<LANES>; 2]) -> [f64; LANES],
    center: f64,
    directions: [[f64; 2]; D],
    guess: f64,
) -> [f64; D] {
    let mut found = [guess; D];
    let mut searches: Vec<(usize, Search)> = Vec::with_capacity(LANES);
    let (mut next, mut guess) = (0, guess);
    loop {
        while next < D && searches.len() < LANES {
            searches.push((next, Search::new(guess)));
            next += 1;
        }
        let mut p = [Doubles([center; LANES]), Doubles([0.0; LANES])];
        for (lane, (i, search)) in searches.iter().enumerate() {
            p[0].0[lane] = center + search.wanted() * directions[*i][0];
            p[1].0[lane] = search.wanted() * directions[*i][1];
        }
        if searches.is_empty() {
            return found;
        }
        let excess = excess(p);
        for ((_, search), excess) in searches.iter_mut().zip(excess) {
            search.learn(excess);
        }
        searches.retain(|(i, search)| {
            if let Some(t) = search.found() {
                (found[*i], guess) = (t, t);
            }
            search.found().is_none()
        });
    }
}

/// How far beyond the worst aperture a ray passes whose largest relative height is known, in clear radii.
pub(in crate::optics) fn excess(height2: f64, whole: bool) -> f64 {
    if whole {
        height2.sqrt() - 1.0
    } else {
        f64::INFINITY
    }
}

/// A bundle of [`View::excess`].
struct Excess<'a> {
    /// The ray that passes best counts.
    tracers: &'a [FilmTracer<f64>],
    film: [Doubles<LANES>; 2],
    p: [Doubles<LANES>; 2],
}

impl Kernel for Excess<'_> {
    type Output = [f64; LANES];
    #[inline(always)]
    fn run(self, _: impl Instructions) -> [f64; LANES] {
        let mut least = [f64::INFINITY; LANES];
        for tracer in self.tracers {
            let (height2, whole) = tracer.largest_relative_height2(&self.film, &self.p);
            for (i, least) in least.iter_mut().enumerate() {
                *least = least.min(excess(height2.0[i], whole.at(i)));
            }
        }
        least
    }
}

impl Outline {
    /// For film points nearby.
    pub(super) fn hint(&self) -> Hint {
        Hint {
            inside: self.center,
            size: self.points[0][0],
        }
    }

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
    pub(super) fn area(&self) -> f64 {
        self.points.windows(2).map(|p| cross(p[0], p[1])).sum()
    }

    /// The points with the middle added.
    pub(super) fn absolute(&self) -> impl Iterator<Item = [f64; 2]> {
        self.points.iter().map(|p| [self.center + p[0], p[1]])
    }
}

/// For each side between neighboring `points` that has a bend (see [`Outline::bends`]) its number and that point.
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
    // Nearly parallel lines meet far off. A true corner reaches 1.2 times as far as its neighbors only
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

/// The lowest point of `f` between `a` and `c`, where `b` between them is lower than both ends, or the
/// first point found where it is negative: golden section (Press et al., *Numerical Recipes*, §10.2),
/// with infinite values allowed.
pub(in crate::optics) fn valley(f: impl Fn(f64) -> f64, [mut a, mut b, mut c]: [f64; 3]) -> f64 {
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
