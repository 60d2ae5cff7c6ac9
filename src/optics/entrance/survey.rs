//! Making the table: outlines at a few angles and distances, and more of them where they change fast.

use super::sight::{Outline, Scope};
use super::table::{Fit, Patch, Slab};
use super::{FilmWindow, Seen};
use crate::math::DVec2;
use crate::optics::lanes::SceneTracer;
use crate::optics::pupil::Region;
use std::rc::Rc;

/// Inverse distances at which slabs end, in units of the nearest's. Most of a scene is far away.
const KNOTS: [f64; 6] = [0.0, 0.0625, 0.125, 0.25, 0.5, 1.0];

/// Points at larger angles than 85° (this is the tangent of the half) see the first surface only.
const WIDEST: f64 = 0.9163;

/// Steps in which the edge of the light is sought before it is narrowed down.
const STEPS: usize = 96;

/// It is found to this part of itself.
const EDGE: f64 = 1e-5;

/// Half axes are made larger by this part: for what bends outward between the directions of outlines and between the points that were
/// looked from.
const MARGIN: f64 = 0.01;

/// Patches of a slab to begin with, and at most.
const PATCHES: [usize; 2] = [6, 40];

/// They are split until less than this part of what is drawn is lost to the region's change within them.
const WASTE: f64 = 0.02;

/// The lens and the window, ready to be looked at.
pub(super) struct Survey {
    tracer: SceneTracer<f64>,
    film_radius: f64,
    center_z: f64,
    rim: [f64; 2],
}

/// What passes from one angle and distance; `None` if nothing does.
type Node = Option<Rc<Sighted>>;

/// An outline and the ellipse around it.
struct Sighted {
    outline: Outline,
    fit: Fit,
}

/// A range of angles of a slab: nodes at its ends and in the middle, each at the slab's ends and middle.
struct Span {
    w: [f64; 2],
    nodes: [[Node; 3]; 3],
    patch: Patch,
    /// Part of what is drawn that is lost to the change within the span.
    waste: f64,
}

impl Survey {
    /// `None` without lenses.
    pub(super) fn new(lenses: &[Seen<'_>], window: FilmWindow) -> Option<Survey> {
        let (lens, pupil) = lenses.first()?;
        let front = lens.surfaces().first()?;
        let radius = front.clear_radius();
        // A pupil in front of the lens would have points of the scene beside it; one far behind sees them all at one angle.
        let entrance = lens.paraxial().entrance_pupil.map_or(0.0, |p| p.z);
        Some(Survey {
            tracer: SceneTracer::new(lens, pupil.plane_z()),
            film_radius: 1.01 * window.radius(),
            center_z: entrance.clamp(0.0, 10.0 * lens.film_z()),
            rim: [radius, front.sag(radius)],
        })
    }

    pub(super) fn center_z(&self) -> f64 {
        self.center_z
    }

    /// Points nearer to C than this are left to the first surface: the lens fills much of what they see.
    pub(super) fn near(&self) -> f64 {
        1.5 * self.center_z + 2.0 * self.rim[0]
    }

    pub(super) fn slabs(&self) -> Vec<Slab> {
        KNOTS.windows(2).map(|v| self.slab([v[0], v[1]])).collect()
    }

    fn scope(&self) -> Scope<'_> {
        Scope {
            tracer: &self.tracer,
            film_radius: self.film_radius,
            center_z: self.center_z,
            rim: self.rim,
        }
    }

    fn outline(&self, t: f64, v: f64, hint: Option<f64>) -> Option<Outline> {
        self.scope().sight(t, v / self.near()).outline(hint)
    }

    /// The angle at which light ends at `v`, and whether it continues beyond [`WIDEST`]; 0 where there is none.
    fn edge(&self, v: f64) -> (f64, bool) {
        let mut hint = None;
        let mut lit = |t: f64| {
            let inside = self.scope().sight(t, v / self.near()).inside(hint);
            hint = inside.or(hint);
            inside.is_some()
        };
        let at = |i: usize| WIDEST * (i as f64 / STEPS as f64).powi(2);
        let Some(last) = (0..=STEPS).filter(|i| lit(at(*i))).last() else {
            return (0.0, false);
        };
        if last == STEPS {
            return (WIDEST, true);
        }
        let (mut low, mut high) = (at(last), at(last + 1));
        while high - low > EDGE * high {
            let t = 0.5 * (low + high);
            *(if lit(t) { &mut low } else { &mut high }) = t;
        }
        (high, false)
    }

    fn slab(&self, v: [f64; 2]) -> Slab {
        let middle = 0.5 * (v[0] + v[1]);
        let [(low, a), (between, b), (high, c)] = [v[0], middle, v[1]].map(|v| self.edge(v));
        let largest = low.max(between).max(high);
        // What is dark at one end is measured by the other.
        let edges = [low, high].map(|edge| if edge > 0.0 { edge } else { largest });
        let open = a || b || c;
        let mut slab = Slab {
            v,
            edges,
            ends: Vec::new(),
            patches: Vec::new(),
            open,
        };
        if largest <= 0.0 {
            return slab;
        }
        let last = (between / (0.5 * (edges[0] + edges[1]))).max(1.0) * (1.0 + 10.0 * EDGE);
        for span in self.spans(&slab, last) {
            slab.ends.push(span.w[1]);
            slab.patches.push(span.patch);
        }
        slab
    }

    /// Patches up to the relative angle `last`, by angle.
    fn spans(&self, slab: &Slab, last: f64) -> Vec<Span> {
        let [count, most] = PATCHES;
        let columns: Vec<[Node; 3]> = (0..=2 * count)
            .map(|i| self.column(slab, last * i as f64 / (2 * count) as f64, None))
            .collect();
        let mut spans: Vec<Span> = (0..count)
            .map(|i| {
                let w = [i, i + 1].map(|i| last * i as f64 / count as f64);
                Span::new(w, [0, 1, 2].map(|k| columns[2 * i + k].clone()))
            })
            .collect();
        let area = |s: &Span| s.w[1].powi(2) - s.w[0].powi(2);
        loop {
            let wasted = |s: &Span| s.waste * area(s);
            let total: f64 = spans.iter().map(wasted).sum();
            let worst =
                (0..spans.len()).max_by(|a, b| wasted(&spans[*a]).total_cmp(&wasted(&spans[*b])));
            let Some(worst) = worst.filter(|_| total > WASTE * last * last && spans.len() < most)
            else {
                spans.sort_by(|a, b| a.w[0].total_cmp(&b.w[0]));
                return spans;
            };
            let Span { w, nodes, .. } = spans.swap_remove(worst);
            let [a, b, c] = nodes;
            let half = 0.5 * (w[0] + w[1]);
            let [before, after] =
                [0.5 * (w[0] + half), 0.5 * (half + w[1])].map(|w| self.column(slab, w, Some(&b)));
            spans.push(Span::new([w[0], half], [a, before, b.clone()]));
            spans.push(Span::new([half, w[1]], [b, after, c]));
        }
    }

    /// Nodes at the relative angle `w`; those of an angle nearby are a hint.
    fn column(&self, slab: &Slab, w: f64, nearby: Option<&[Node; 3]>) -> [Node; 3] {
        [0, 1, 2].map(|k| {
            let r = 0.5 * k as f64;
            let t = w * (slab.edges[0] + r * (slab.edges[1] - slab.edges[0]));
            let v = slab.v[0] + r * (slab.v[1] - slab.v[0]);
            let hint = nearby.and_then(|nodes| nodes[k].as_ref().map(|n| n.fit[0]));
            Sighted::new(self.outline(t, v, hint)?).map(Rc::new)
        })
    }
}

impl Sighted {
    fn new(outline: Outline) -> Option<Sighted> {
        let fit = fit(&outline.points, &outline.film)?;
        Some(Sighted { outline, fit })
    }
}

/// The ellipse around points of the plane and the circle around points of the film, both given by half of them.
fn fit(points: &[[f64; 2]], film: &[[f64; 2]]) -> Option<Fit> {
    let e = Region::around(points)?;
    let heights = film.iter().map(|p| p[0]);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    let high = heights.fold(f64::NEG_INFINITY, f64::max);
    let height = 0.5 * (low + high);
    let farthest = |r: f64, p: &[f64; 2]| r.max((p[0] - height).hypot(p[1]));
    let radius = film.iter().fold(0.0, farthest);
    let fit = [e.center, e.along, e.across, height, radius];
    fit.iter().all(|x| x.is_finite()).then_some(fit)
}

impl Span {
    fn new(w: [f64; 2], nodes: [[Node; 3]; 3]) -> Span {
        let (patch, waste) = patch(&nodes);
        Span {
            w,
            nodes,
            patch,
            waste,
        }
    }
}

/// The patch that holds what all nodes see, and the part of what is drawn in its middle that another would not lose.
fn patch(nodes: &[[Node; 3]; 3]) -> (Patch, f64) {
    let lit: Vec<&Rc<Sighted>> = nodes.iter().flatten().flatten().collect();
    if lit.is_empty() {
        return (Patch::Dark, 0.0);
    }
    let corner = |i: usize, k: usize| nodes[i][k].as_ref().map(|n| n.fit);
    let fits = match (corner(0, 0), corner(0, 2), corner(2, 0), corner(2, 2)) {
        (Some(a), Some(b), Some(c), Some(d)) if lit.len() == 9 => [[a, b], [c, d]],
        _ => {
            // Light ends somewhere within: one ellipse around all.
            let points: Vec<[f64; 2]> = lit.iter().flat_map(|n| n.outline.points.clone()).collect();
            let film: Vec<[f64; 2]> = lit.iter().flat_map(|n| n.outline.film.clone()).collect();
            match fit(&points, &film) {
                Some(fit) => [[fit; 2]; 2],
                None => return (Patch::Astray, 0.0),
            }
        }
    };
    let mut patch = Patch::Ellipses {
        fits,
        grown: 1.0 + MARGIN,
        image_grown: 0.0,
    };
    let mut drawn = 0.0;
    for (i, column) in nodes.iter().enumerate() {
        for (k, node) in column.iter().enumerate() {
            let (s, r) = (0.5 * i as f64, 0.5 * k as f64);
            if let Some(node) = node {
                patch.hold(s, r, &node.outline, MARGIN);
            }
        }
    }
    for i in 0..3 {
        for k in 0..3 {
            drawn += patch.area(0.5 * i as f64, 0.5 * k as f64);
        }
    }
    let needed: f64 = lit
        .iter()
        .map(|n| n.fit[1] * n.fit[2] * std::f64::consts::PI * (1.0 + MARGIN).powi(2))
        .sum();
    (patch, (1.0 - needed / drawn).max(0.0))
}

impl Patch {
    /// Grows until what is seen at these fractions of the way lies inside, with a margin.
    fn hold(&mut self, s: f64, r: f64, outline: &Outline, margin: f64) {
        let Some((super::Region::Ellipse(e), Some(image))) = self.at(s, r) else {
            return;
        };
        let Patch::Ellipses {
            grown, image_grown, ..
        } = self
        else {
            return;
        };
        let farthest = |far: f64, p: &[f64; 2]| far.max(e.radius2(DVec2::from(*p)));
        let radius = outline.points.iter().fold(0.0, farthest).sqrt();
        if radius * (1.0 + margin) > 1.0 {
            *grown *= radius * (1.0 + margin);
        }
        let beyond = |far: f64, p: &[f64; 2]| far.max((p[0] - image.height).hypot(p[1]));
        let farthest = outline.film.iter().fold(0.0, beyond);
        *image_grown += (farthest - image.radius).max(0.0);
    }

    /// Of the ellipse there, mm².
    fn area(&self, s: f64, r: f64) -> f64 {
        match self.at(s, r) {
            Some((super::Region::Ellipse(e), _)) => e.area(),
            _ => 0.0,
        }
    }
}
