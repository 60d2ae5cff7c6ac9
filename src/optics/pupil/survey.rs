//! Making the regions: outlines at a few film radii, and more of them where the pupil changes fast.

use super::draft::Draft;
use super::outline::{Hint, Outline, View};
use super::rear::Rear;
use super::region::Region;
use super::ring::Ring;
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::optics::lanes::{Doubles, FilmTracer};
use crate::optics::lens::Lens;

/// Rings are split until less than this part of the samples, averaged over the film, is lost to the pupil's
/// change within a ring ...
const WASTE: f64 = 0.005;

/// ... or there are this many.
const MAX_RINGS: usize = 96;

/// The film radius where light ends is found to this part of the largest.
const EDGE: f64 = 1e-7;

/// Rays that look for light just outside the region of a ring.
const PROBES_AROUND: usize = 96;

/// Rays that look for light anywhere else on the rear element. Most end at the first surfaces.
const PROBES_BEYOND: usize = 512;

/// Rays that look for all light of a ring whose outline cannot be trusted.
const PROBES_ASTRAY: usize = 4096;

/// Rays that are traced side by side.
const LANES: usize = 16;

/// The lens and the plane on which its pupil is surveyed.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// Of the lens, aimed at the plane: from its film, or from several planes that a film lies between which is tilted. What passes from
    /// any of them is held.
    pub tracers: Vec<FilmTracer<f64>>,
    /// Of the film, or of the middle of these planes.
    pub film_z: f64,
    /// Of the first and the last of them.
    pub film_ends: [f64; 2],
    pub plane_z: f64,
    pub rear: Rear,
    /// Largest film radius, mm.
    pub reach: f64,
}

/// The part of the film between two radii at which the outline is known.
struct Span {
    radii: [f64; 2],
    ends: [Outline; 2],
    /// At a quarter, half and three quarters of the way; `None` where one of them is missing.
    inside: Option<[Outline; 3]>,
    /// The polygon that holds all five outlines; `None` where an outline is missing or it is no star.
    draft: Option<Draft>,
    /// Part of the samples that are lost to the pupil's change.
    waste: f64,
}

impl Survey {
    /// Of `lens` on the plane at `plane_z`, for film points up to `max_radius` mm from the axis.
    pub(super) fn new(lens: &Lens, plane_z: f64, max_radius: f64) -> Survey {
        Survey {
            tracers: vec![FilmTracer::new(lens, plane_z)],
            film_z: lens.film_z(),
            film_ends: [lens.film_z(); 2],
            plane_z,
            rear: Rear::new(lens),
            reach: max_radius.max(f64::MIN_POSITIVE),
        }
    }

    /// For film points on any of the planes from `film_ends[0]` to `film_ends[1]`.
    pub(super) fn of_slab(
        lens: &Lens,
        plane_z: f64,
        film_ends: [f64; 2],
        max_radius: f64,
    ) -> Survey {
        /// Planes that are looked from: the outline moves evenly between them, but for a corner where two rims cross.
        const PLANES: usize = 3;
        let [near, far] = film_ends;
        let at = |i: usize| near + (far - near) * i as f64 / (PLANES - 1) as f64;
        let tracer = |i: usize| FilmTracer::from_plane(lens, at(i), plane_z);
        Survey {
            tracers: (0..PLANES).map(tracer).collect(),
            film_z: 0.5 * (near + far),
            film_ends,
            ..Survey::new(lens, plane_z, max_radius)
        }
    }

    /// A circle on the plane around all that the rear element lets through to a film radius; see [`Rear::region`].
    pub(super) fn rear_region(&self, radius: f64) -> Option<Region> {
        let [near, far] = self.film_ends;
        let nearest = self.rear.region(radius, self.plane_z, near)?;
        if near == far {
            return Some(nearest);
        }
        // Its ends along the film point's azimuth run one way from the one plane to the other.
        let farthest = self.rear.region(radius, self.plane_z, far)?;
        let low = (nearest.center - nearest.along).min(farthest.center - farthest.along);
        let high = (nearest.center + nearest.along).max(farthest.center + farthest.along);
        let radius = 0.5 * (high - low);
        Some(Region::ellipse(low + radius, radius, radius))
    }

    pub(super) fn view(&self, radius: f64) -> View<'_> {
        View {
            survey: self,
            radius,
        }
    }

    fn outline(&self, radius: f64, hint: Option<Hint>) -> Option<Outline> {
        self.view(radius).outline(hint)
    }

    /// The regions of all rings, by film radius; starts with `count` rings. Film radii up to
    /// [`Survey::reach`] that are in none are dark.
    pub(super) fn rings(&self, count: usize) -> Vec<Ring> {
        let mut known: Vec<(f64, Option<Outline>)> = Vec::with_capacity(count + 3);
        let mut hint = None;
        for radius in self.radii(count) {
            let outline = self.outline(radius, hint);
            hint = outline.as_ref().map(Outline::hint);
            let changes = |(_, last): &&(f64, Option<Outline>)| last.is_some() != outline.is_some();
            let last = known.last().filter(changes);
            let edge = last.map(|last| self.edge(last, &(radius, outline.clone())));
            known.extend(edge.into_iter().flatten());
            known.push((radius, outline));
        }
        let mut spans = Vec::new();
        let mut rings = Vec::new();
        for pair in known.windows(2) {
            match (&pair[0], &pair[1]) {
                ((a, _), (b, _)) if b <= a => {}
                ((a, Some(inner)), (b, Some(outer))) => {
                    let middle = self.between([*a, *b], inner, outer);
                    spans.push(self.span([*a, *b], [inner.clone(), outer.clone()], middle));
                }
                // Between the last film radius with light and the first without, or the other
                // way: next to nothing.
                ((a, Some(one)), (b, None)) | ((a, None), (b, Some(one)))
                    if b - a <= 2.0 * EDGE * self.reach =>
                {
                    rings.extend(Draft::between([one, one], [].into_iter()).finish([*a, *b]));
                }
                // Dark at both ends, so dark unless a probe finds light.
                ((a, _), (b, _)) => {
                    let radii = [*a, *b];
                    let probes = self.probes(radii, PROBES_BEYOND).collect();
                    let lit = !self.passing(probes).is_empty();
                    rings.extend(lit.then(|| self.stray(radii)).flatten());
                }
            }
        }
        self.refine(&mut spans);
        rings.extend(spans.iter().filter_map(|span| self.ring(span)));
        rings.sort_by(|a, b| a.radii[0].total_cmp(&b.radii[0]));
        rings
    }

    /// Film radii to begin with, from 0 to the reach: `count` equal parts of it, or, where light ends within it for
    /// good, of what is lit.
    fn radii(&self, count: usize) -> Vec<f64> {
        let whole = |i: usize| self.reach * i as f64 / count as f64;
        let mut radii: Vec<f64> = (0..=count).map(whole).collect();
        let mut hint = None;
        let lit: Vec<bool> = radii
            .iter()
            .map(|radius| {
                hint = self.view(*radius).inside(hint);
                hint.is_some()
            })
            .collect();
        let first_dark = lit.iter().position(|lit| !lit).unwrap_or(0);
        if first_dark > 0 && lit[first_dark..].iter().all(|lit| !lit) {
            let mut hint = None;
            let around = [radii[first_dark - 1], radii[first_dark]];
            let ends = self.bisected(around, |radius| {
                let inside = self.view(radius).inside(hint);
                hint = inside.or(hint);
                usize::from(inside.is_none())
            });
            let lit = (0..count).map(|i| ends[0] * i as f64 / count as f64);
            radii = lit.chain(ends).chain(radii.split_off(first_dark)).collect();
        }
        radii
    }

    /// The film radii on either side of where light ends between `a` and `b`, of which one is dark.
    fn edge(
        &self,
        a: &(f64, Option<Outline>),
        b: &(f64, Option<Outline>),
    ) -> [(f64, Option<Outline>); 2] {
        let mut ends = [a.clone(), b.clone()];
        let lit = if a.1.is_some() { 0 } else { 1 };
        let mut hint = ends[lit].1.as_ref().map(Outline::hint);
        // One ray that passes tells lit from dark; the outline is found where the search ends.
        let radii = self.bisected([a.0, b.0], |radius| {
            let inside = self.view(radius).inside(hint.map(|h| h.inside));
            if let (Some(hint), Some(inside)) = (&mut hint, inside) {
                hint.inside = inside;
            }
            if inside.is_some() { lit } else { 1 - lit }
        });
        let outline = self.outline(radii[lit], hint);
        if outline.is_some() {
            ends = radii.map(|radius| (radius, None));
            ends[lit].1 = outline;
            return ends;
        }
        // So near the edge the pupil may be too small to outline. Then the edge is where outlines end.
        self.bisected([a.0, b.0], |radius| {
            let hint = ends[lit].1.as_ref().map(Outline::hint);
            let outline = self.outline(radius, hint);
            let side = if outline.is_some() { lit } else { 1 - lit };
            ends[side] = (radius, outline);
            side
        });
        ends
    }

    /// Narrows the film radii to [`EDGE`], by asking on which side a radius between them belongs.
    fn bisected(&self, mut radii: [f64; 2], mut side: impl FnMut(f64) -> usize) -> [f64; 2] {
        while radii[1] - radii[0] > EDGE * self.reach {
            let radius = 0.5 * (radii[0] + radii[1]);
            radii[side(radius)] = radius;
        }
        radii
    }

    /// The outline half-way.
    fn between(&self, radii: [f64; 2], inner: &Outline, outer: &Outline) -> Option<Outline> {
        let (a, b) = (inner.hint(), outer.hint());
        let hint = Hint {
            inside: 0.5 * (a.inside + b.inside),
            size: 0.5 * (a.size + b.size),
        };
        self.outline(0.5 * (radii[0] + radii[1]), Some(hint))
    }

    fn span(&self, radii: [f64; 2], ends: [Outline; 2], middle: Option<Outline>) -> Span {
        let half = 0.5 * (radii[0] + radii[1]);
        let inside = middle.and_then(|middle| {
            let before = self.between([radii[0], half], &ends[0], &middle)?;
            let after = self.between([half, radii[1]], &middle, &ends[1])?;
            Some([before, middle, after])
        });
        let mut span = Span {
            radii,
            ends,
            inside,
            draft: None,
            waste: 1.0,
        };
        span.draft = span.draft();
        if let (Some([_, middle, _]), Some(draft)) = (&span.inside, &span.draft) {
            let plain = middle.area();
            // What any ring wastes, however narrow, is no reason to split it.
            let least = span.min_waste(middle);
            span.waste = (1.0 - plain / draft.area(0.5) - least).max(0.0);
        }
        span
    }

    /// Splits the spans that waste most of the film's samples.
    fn refine(&self, spans: &mut Vec<Span>) {
        let lit: f64 = spans.iter().map(Span::film_area).sum();
        loop {
            let wasted = |s: &Span| s.waste * s.film_area();
            let total: f64 = spans.iter().map(wasted).sum();
            let worst =
                (0..spans.len()).max_by(|a, b| wasted(&spans[*a]).total_cmp(&wasted(&spans[*b])));
            let (Some(worst), true) = (worst, total > WASTE * lit && spans.len() < MAX_RINGS)
            else {
                return;
            };
            let span = spans.swap_remove(worst);
            let [a, b] = span.radii;
            let half = 0.5 * (a + b);
            match span.inside {
                Some([before, middle, after]) if a < half && half < b => {
                    let [inner, outer] = span.ends;
                    spans.push(self.span([a, half], [inner, middle.clone()], Some(before)));
                    spans.push(self.span([half, b], [middle, outer], Some(after)));
                }
                // Nothing to split at: its bounding shape will have to do.
                inside => spans.push(Span {
                    waste: 0.0,
                    inside,
                    ..span
                }),
            }
        }
    }

    /// The region of a span: its polygon if that holds all light, else a shape around all light found,
    /// else everything the rear element lets through.
    fn ring(&self, span: &Span) -> Option<Ring> {
        let draft = span.draft.clone();
        let polygon = draft.and_then(|draft| self.probed(span.radii, draft));
        polygon.or_else(|| self.stray(span.radii))
    }

    /// The draft, a little larger where probes just outside it pass; `None` where light is far outside.
    fn probed(&self, radii: [f64; 2], mut draft: Draft) -> Option<Ring> {
        let radius = |t: f64| radii[0] + t * (radii[1] - radii[0]);
        for round in 0..4 {
            let aims = (0..PROBES_AROUND).map(|i| {
                let t = spread(i + round * PROBES_AROUND);
                (radius(t), just_outside(&draft, t, i))
            });
            let found = self.passing(aims.collect());
            if found.is_empty() {
                break;
            }
            for (at, p) in found {
                let t = (at - radii[0]) / (radii[1] - radii[0]);
                let (side, beyond) = draft.beyond(t, p);
                draft.push_side(side, (2.0 * beyond).max(0.0));
            }
        }
        let outside = |(at, p): &(f64, [f64; 2])| {
            let t = (at - radii[0]) / (radii[1] - radii[0]);
            draft.beyond(t, *p).1 > 0.0
        };
        let probes = self.probes(radii, PROBES_BEYOND).filter(outside);
        if !self.passing(probes.collect()).is_empty() {
            return None;
        }
        draft.finish(radii)
    }

    /// Rays from between two film radii to all over the rear element: film radius, and where they meet the plane.
    fn probes(&self, radii: [f64; 2], count: usize) -> impl Iterator<Item = (f64, [f64; 2])> {
        self.rear.probes(count).enumerate().map(move |(i, p)| {
            let view = self.view(radii[0] + spread(i) * (radii[1] - radii[0]));
            (view.radius, view.on_plane(p))
        })
    }

    /// Those of the rays, each from a film radius through a point of the plane, that reach the scene.
    fn passing(&self, mut aims: Vec<(f64, [f64; 2])>) -> Vec<(f64, [f64; 2])> {
        let mut passes = Vec::with_capacity(aims.len());
        for bundle in aims.chunks(LANES) {
            let at = |i: usize| bundle[i.min(bundle.len() - 1)];
            let lane = |f: &dyn Fn((f64, [f64; 2])) -> f64| {
                Doubles(std::array::from_fn::<f64, LANES, _>(|i| f(at(i))))
            };
            let rays = Rays {
                tracers: &self.tracers,
                film: [lane(&|(radius, _)| radius), Doubles([0.0; LANES])],
                p: [lane(&|(_, p)| p[0]), lane(&|(_, p)| p[1])],
            };
            passes.extend(vectorize::<LANES, _>(rays).into_iter().take(bundle.len()));
        }
        let mut passes = passes.into_iter();
        aims.retain(|_| passes.next().unwrap_or(false));
        aims
    }

    /// A shape around all light between two film radii, wherever it is; `None` where there is none.
    fn stray(&self, radii: [f64; 2]) -> Option<Ring> {
        let count = PROBES_ASTRAY;
        let found: Vec<[f64; 2]> = self
            .passing(self.probes(radii, count).collect())
            .into_iter()
            .map(|(_, p)| [p[0], p[1].abs()])
            .collect();
        if found.is_empty() {
            return None;
        }
        let (inner, outer) = (self.rear_region(radii[0])?, self.rear_region(radii[1])?);
        let whole = Draft::of_ellipses(&inner, &outer);
        // Probes lie this far apart, relative to the element.
        let spacing = (4.0 / count as f64).sqrt() * inner.along.max(outer.along);
        let around = Region::around(&found);
        let around = around
            .map(|e| Region::ellipse(e.center, e.along + 2.0 * spacing, e.across + 2.0 * spacing));
        let draft = match around {
            Some(e) if e.along * e.across < inner.along * inner.across => {
                Draft::of_ellipses(&e, &e)
            }
            _ => whole,
        };
        draft.finish(radii)
    }
}

impl Span {
    /// The polygon that holds all five outlines, and what bends outward between them; `None`
    /// where an outline is missing or the polygon is no star.
    fn draft(&self) -> Option<Draft> {
        let inside = self.inside.as_ref()?;
        let inside = [0.25, 0.5, 0.75].into_iter().zip(inside);
        let draft = Draft::between([&self.ends[0], &self.ends[1]], inside);
        draft.finish(self.radii).map(|_| draft)
    }

    /// What the margins alone waste.
    fn min_waste(&self, middle: &Outline) -> f64 {
        let draft = Draft::between([middle, middle], [].into_iter());
        1.0 - middle.area() / draft.area(0.5)
    }

    /// Over π, mm².
    fn film_area(&self) -> f64 {
        self.radii[1].powi(2) - self.radii[0].powi(2)
    }
}

/// A bundle of rays of which is asked whether they pass.
struct Rays<'a> {
    tracers: &'a [FilmTracer<f64>],
    film: [Doubles<LANES>; 2],
    p: [Doubles<LANES>; 2],
}

impl Kernel for Rays<'_> {
    type Output = [bool; LANES];
    #[inline(always)]
    fn run(self, _: impl Instructions) -> [bool; LANES] {
        let mut passes = [false; LANES];
        for tracer in self.tracers {
            let passed = tracer.trace(&self.film, &self.p).passed;
            for (i, passes) in passes.iter_mut().enumerate() {
                *passes |= passed.at(i);
            }
        }
        passes
    }
}

/// Well-spread numbers from 0 to 1 (Kronecker's sequence of the golden ratio).
fn spread(i: usize) -> f64 {
    (0.5 + i as f64 * 0.618_033_988_749_895).fract()
}

/// A point just outside the draft at `t`.
fn just_outside(draft: &Draft, t: f64, i: usize) -> [f64; 2] {
    let sides = draft.corners.len() - 1;
    let along = sides as f64 * (0.5 + i as f64 * 0.754_877_666_246_692_8).fract();
    let side = (along as usize).min(sides - 1);
    let (a, b) = (draft.corners[side].at(t), draft.corners[side + 1].at(t));
    let s = along - side as f64;
    // Alternately at the rim and 2 % beyond it.
    let scale = if i.is_multiple_of(2) { 1.0005 } else { 1.02 };
    [
        draft.center.at(t) + scale * (a[0] + s * (b[0] - a[0])),
        scale * (a[1] + s * (b[1] - a[1])),
    ]
}
