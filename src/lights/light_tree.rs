//! Choosing a light by how strongly it arrives at the shading point.
//!
//! Lights are gathered in a tree whose nodes have eight parts, so that the estimates of what each
//! part brings are computed together; a few nodes side by side are its top. A light is found on the
//! way down, and its probability on the way up. Importance and tree are those of Conty Estevez and
//! Kulla ("Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018), with wide nodes
//! in place of their adaptive splitting. What was tried and was slower: `docs/light-choice.md`.
//!
//! The estimate knows nothing of shadows, so a part of the probability is shared out evenly among
//! *groups* (a light counts as much as a mesh of a thousand triangles), whatever the estimate says.

use super::Light;
use super::lanes::{LANES, Lanes, Receiver};
use super::light_bounds::LightBounds;
use super::selection::Selected;
use super::tree::{Kind, Part, Tree};
use crate::handles::LightId;
use crate::math::distribution::Distribution1D;
use crate::math::float::is_positive;

/// Nodes side by side at the top.
const TOP: usize = 4;

/// Of the parts at the top, those for lights without a place.
const MAX_PLACELESS: usize = 16;

/// Share of the probability that is spread evenly.
const EVEN_SHARE: f32 = 0.1;

/// One light, as it is seen here.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) light: LightId,
    pub(super) bounds: LightBounds,
    /// Luminance of its power; ≥ 0.
    pub(super) power: f32,
    /// Its part of what is shared out evenly; all sum to 1.
    pub(super) even: f32,
}

/// A node, or a part of one.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    node: u32,
    lane: u8,
}

#[derive(Clone, Debug)]
struct Node {
    lanes: Lanes,
    parts: [Part; LANES],
    /// The part that this node is; of the nodes at the top, nothing.
    above: Option<Place>,
}

/// All lights.
#[derive(Clone, Debug)]
pub(super) struct LightTree {
    /// The first [`LightTree::top`] nodes stand side by side.
    nodes: Vec<Node>,
    top: usize,
    /// By light.
    places: Vec<Place>,
    even: Distribution1D,
}

/// Bytes that each of many lights takes at most while a tree is made: a node of the binary tree, and as a candidate, or in a node
/// that is at least half full, whose list grows by half again, and in the tables.
pub(super) const MEMORY_OF_LIGHT: usize = {
    let candidate = size_of::<Candidate>();
    let node = 3 * size_of::<Node>() / LANES + size_of::<Place>();
    let more = if candidate > node { candidate } else { node };
    Tree::NODE + more + 4 * size_of::<f32>()
};

impl LightTree {
    /// From the candidates for all `lights`. Distances below `min_distance` do not count
    /// as nearer.
    pub(super) fn new(
        mut candidates: Vec<Candidate>,
        lights: &[Light],
        min_distance: f32,
    ) -> LightTree {
        let even = even(&candidates, lights.len());
        let is_local = |light: &Candidate| light.bounds.is_local();
        let placeless = candidates.iter().filter(|light| !is_local(light));
        let placeless = Tree::new(placeless.copied().collect());
        candidates.retain(is_local);
        let local = Tree::new(candidates);
        let first: Vec<_> = placeless.cut(placeless.root, MAX_PLACELESS);
        let second = local.cut(local.root, TOP * LANES - first.len());
        let top = (first.iter().map(|&part| (&placeless, part)))
            .chain(second.iter().map(|&part| (&local, part)))
            .filter(|&(_, part)| part != Part::NOTHING)
            .collect::<Vec<_>>();
        let mut building = Building {
            nodes: vec![Node::empty(None); top.len().div_ceil(LANES)],
            places: vec![Place::default(); lights.len()],
            lights,
            min_distance,
        };
        let count = building.nodes.len();
        for (position, (tree, part)) in top.into_iter().enumerate() {
            let place = Place {
                node: (position / LANES) as u32,
                lane: (position % LANES) as u8,
            };
            building.put(tree, part, place);
        }
        LightTree {
            nodes: building.nodes,
            top: count,
            places: building.places,
            even,
        }
    }

    /// A light and its probability.
    pub(super) fn sample(&self, to: &Receiver, u: f32) -> Option<Selected> {
        let top = self.top_estimates(to);
        let even_share = top.even_share();
        if u < even_share {
            let (light, _, rest) = self.even.sample_discrete(u / even_share);
            let light = LightId(light as u32);
            let pmf = self.probability(to, &top, light);
            return Some(Selected { light, pmf, rest });
        }
        let u = (u - even_share) / (1.0 - even_share);
        let chosen = self.descend(to, &top, u)?;
        let even = self.even.probability(chosen.light.index());
        Some(Selected {
            pmf: even_share * even + (1.0 - even_share) * chosen.pmf,
            ..chosen
        })
    }

    /// Probability with which [`LightTree::sample`] chooses `light`.
    pub(super) fn pmf(&self, to: &Receiver, light: LightId) -> f32 {
        self.probability(to, &self.top_estimates(to), light)
    }

    fn top_estimates(&self, to: &Receiver) -> Top {
        let mut top = Top {
            estimates: [[0.0; LANES]; TOP],
            sums: [0.0; TOP],
            total: 0.0,
        };
        for (k, node) in self.nodes.iter().enumerate().take(self.top.min(TOP)) {
            top.estimates[k] = node.lanes.at(to);
            top.sums[k] = sum(&top.estimates[k]);
            top.total += top.sums[k];
        }
        top
    }

    /// From the top to a light by `u` in [0, 1), with the probability of that way.
    fn descend(&self, to: &Receiver, top: &Top, u: f32) -> Option<Selected> {
        let (k, mut u) = pick(&top.sums, u * top.total);
        let mut node = self.nodes.get(k)?;
        let mut chances = Chances {
            estimates: top.estimates[k],
            total: top.sums[k],
        };
        let mut pmf = top.sums[k] / top.total;
        loop {
            let (lane, rest) = pick(&chances.estimates, u * chances.total);
            u = rest;
            pmf *= chances.of(lane);
            match node.parts[lane].kind() {
                Kind::Light(light) => return Some(Selected { light, pmf, rest }),
                Kind::Node(below) => node = self.nodes.get(below as usize)?,
                Kind::Nothing => return None,
            }
            chances = Chances::new(node.lanes.at(to), &node.parts);
        }
    }

    fn probability(&self, to: &Receiver, top: &Top, light: LightId) -> f32 {
        let Some(&place) = self.places.get(light.index()) else {
            return 0.0;
        };
        let even_share = top.even_share();
        let even = even_share * self.even.probability(light.index());
        if even_share == 1.0 {
            return even;
        }
        even + (1.0 - even_share) * self.climb(to, top, place)
    }

    /// The probability of the way down to this part.
    fn climb(&self, to: &Receiver, top: &Top, mut place: Place) -> f32 {
        let mut probability = 1.0;
        // Nodes come after those above them: the way ends.
        while let Some(node) = self.nodes.get(place.node as usize) {
            let Some(above) = node.above else {
                let estimates = top.estimates.get(place.node as usize);
                let estimate = estimates.and_then(|e| e.get(usize::from(place.lane)));
                return probability * estimate.copied().unwrap_or(0.0) / top.total;
            };
            let chances = Chances::new(node.lanes.at(to), &node.parts);
            probability *= chances.of(usize::from(place.lane));
            place = above;
        }
        0.0
    }
}

/// Estimates of all parts at the top.
struct Top {
    estimates: [[f32; LANES]; TOP],
    /// Of each node.
    sums: [f32; TOP],
    total: f32,
}

impl Top {
    /// How much of the probability is shared out evenly: all of it where nothing arrives or the
    /// point is not finite.
    fn even_share(&self) -> f32 {
        if is_positive(self.total) {
            EVEN_SHARE
        } else {
            1.0
        }
    }
}

/// The chances of a node's parts.
struct Chances {
    estimates: [f32; LANES],
    total: f32,
}

impl Chances {
    /// By estimates; evenly where these do not say anything.
    fn new(estimates: [f32; LANES], parts: &[Part; LANES]) -> Chances {
        let total = sum(&estimates);
        if is_positive(total) {
            return Chances { estimates, total };
        }
        let estimates = parts.map(|part| f32::from(u8::from(part != Part::NOTHING)));
        Chances {
            total: sum(&estimates),
            estimates,
        }
    }

    fn of(&self, lane: usize) -> f32 {
        self.estimates.get(lane).copied().unwrap_or(0.0) / self.total
    }
}

/// The position of the value that `left`, from 0 up to the values' sum, falls on when they lie side by
/// side, and where in it, in [0, 1). What has no width is never met, whatever is lost to rounding.
pub(super) fn pick(values: &[f32], mut left: f32) -> (usize, f32) {
    let mut chosen = 0;
    let (mut inside, mut width) = (0.0, 1.0);
    for (position, &value) in values.iter().enumerate() {
        if value > 0.0 {
            (chosen, inside, width) = (position, left, value);
            if left < value {
                break;
            }
            left -= value;
        }
    }
    (chosen, (inside / width).clamp(0.0, 1.0 - f32::EPSILON))
}

/// In an order of its own: the same bits whatever the processor's lanes.
pub(super) fn sum(e: &[f32; LANES]) -> f32 {
    ((e[0] + e[1]) + (e[2] + e[3])) + ((e[4] + e[5]) + (e[6] + e[7]))
}

impl Node {
    fn empty(above: Option<Place>) -> Node {
        Node {
            lanes: Lanes::empty(),
            parts: [Part::NOTHING; LANES],
            above,
        }
    }
}

struct Building<'a> {
    nodes: Vec<Node>,
    places: Vec<Place>,
    lights: &'a [Light],
    min_distance: f32,
}

impl Building<'_> {
    /// Makes the binary tree's `part` the part at `place`, and all below it.
    fn put(&mut self, tree: &Tree, part: Part, place: Place) {
        // As deep as the binary tree at most, which is bounded by the lights' number and range; on
        // the heap, as it is a list to work through.
        let mut waiting = vec![(part, place)];
        while let Some((found, place)) = waiting.pop() {
            let (part, bounds) = match found.kind() {
                Kind::Nothing => continue,
                Kind::Light(light) => {
                    if let Some(known) = self.places.get_mut(light.index()) {
                        *known = place;
                    }
                    (found, self.lights.get(light.index()).map(Light::bounds))
                }
                Kind::Node(_) => {
                    let below = self.nodes.len() as u32;
                    self.nodes.push(Node::empty(Some(place)));
                    let parts = tree.cut(found, LANES).into_iter().zip(0..);
                    waiting.extend(parts.map(|(part, lane)| (part, Place { node: below, lane })));
                    (Part::node(below), tree.bounds(found).copied())
                }
            };
            if let (Some(above), Some(bounds)) = (self.nodes.get_mut(place.node as usize), bounds) {
                let lane = usize::from(place.lane);
                above.lanes.set(lane, &bounds, self.min_distance);
                above.parts[lane] = part;
            }
        }
    }
}

fn even(candidates: &[Candidate], lights: usize) -> Distribution1D {
    let mut shares = vec![0.0; lights];
    for candidate in candidates {
        if let Some(share) = shares.get_mut(candidate.light.index()) {
            *share = candidate.even;
        }
    }
    Distribution1D::new(shares)
}
