//! A binary tree of lights: neighbors that shine the same way are near each other in it.
//!
//! Built from the root by halving, where Conty Estevez and Kulla's cost ("Importance Sampling of
//! Many Lights with Adaptive Tree Splitting", 2018) is least among a few planes.

use super::light_bounds::LightBounds;
use super::light_tree::Candidate;
use crate::handles::LightId;
use crate::math::Vec3;

/// Places where a box is tried to be cut, along each axis.
const BINS: usize = 12;

/// Below this depth boxes are cut so that both halves have as many lights.
const DEEPEST_BY_COST: u32 = 64;

/// A light, a node, or nothing; in four bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part(u32);

/// What a [`Part`] is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Nothing,
    Light(LightId),
    /// With this position.
    Node(u32),
}

impl Part {
    const IS_NODE: u32 = 1 << 31;
    pub(super) const NOTHING: Part = Part(u32::MAX);

    pub(super) fn light(light: LightId) -> Part {
        Part(light.0)
    }

    pub(super) fn node(position: u32) -> Part {
        Part(position | Part::IS_NODE)
    }

    #[inline]
    pub(super) fn kind(self) -> Kind {
        match self {
            Part::NOTHING => Kind::Nothing,
            Part(node) if node & Part::IS_NODE != 0 => Kind::Node(node & !Part::IS_NODE),
            Part(light) => Kind::Light(LightId(light)),
        }
    }
}

/// Two halves.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LightBounds,
    halves: [Part; 2],
}

/// A tree.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    pub(super) root: Part,
}

impl Tree {
    /// Memory of a node, of which there is one for each light but one.
    pub(super) const NODE: usize = size_of::<Node>();

    pub(super) fn new(mut leaves: Vec<Candidate>) -> Tree {
        let mut tree = Tree {
            nodes: Vec::with_capacity(leaves.len().saturating_sub(1)),
            root: Part::NOTHING,
        };
        if !leaves.is_empty() {
            tree.root = tree.build(&mut leaves, 0).0;
        }
        tree
    }

    /// How what is below a node arrives; `None` for a single light, which knows itself.
    pub(super) fn bounds(&self, part: Part) -> Option<&LightBounds> {
        self.node(part).map(|node| &node.bounds)
    }

    fn node(&self, part: Part) -> Option<&Node> {
        match part.kind() {
            Kind::Node(position) => self.nodes.get(position as usize),
            _ => None,
        }
    }

    /// Makes a tree out of these leaves, of which there is at least one.
    fn build(&mut self, leaves: &mut [Candidate], depth: u32) -> (Part, LightBounds) {
        if let [leaf] = leaves {
            return (Part::light(leaf.light), leaf.bounds);
        }
        let position = self.nodes.len();
        self.nodes.push(Node {
            bounds: leaves[0].bounds,
            halves: [Part::NOTHING; 2],
        });
        let at = cut(leaves, depth);
        let (left, right) = leaves.split_at_mut(at);
        let (first, left) = self.build(left, depth + 1);
        let (second, right) = self.build(right, depth + 1);
        let bounds = left.merged(&right);
        self.nodes[position] = Node {
            bounds,
            halves: [first, second],
        };
        (Part::node(position as u32), bounds)
    }

    /// At most `room` ≥ 1 parts that represent all below `top`: where one estimate for a node is
    /// worst, its halves are taken instead.
    pub(super) fn cut(&self, top: Part, room: usize) -> Vec<Part> {
        let mut parts = vec![top];
        while parts.len() < room {
            let nodes = parts.iter().map(|&part| self.node(part)).enumerate();
            let divisible = nodes.filter_map(|(i, node)| Some((i, node?)));
            let vagueness = divisible.map(|(i, node)| (i, node.bounds.vagueness(), node.halves));
            let worst = vagueness.max_by(|(_, a, _), (_, b, _)| a.total_cmp(b));
            let Some((worst, _, [first, second])) = worst else {
                break;
            };
            parts[worst] = first;
            parts.push(second);
        }
        parts
    }
}

/// Sorts at least two leaves into two parts; where the second one starts.
fn cut(leaves: &mut [Candidate], depth: u32) -> usize {
    let half = leaves.len() / 2;
    let centers = leaves.iter().map(|leaf| leaf.bounds.center());
    let low = centers.clone().fold(Vec3::INFINITY, Vec3::min);
    let high = centers.fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = high - low;
    let bin = |axis: usize, leaf: &Candidate| {
        let place = (leaf.bounds.center()[axis] - low[axis]) / size[axis];
        ((place * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0 && depth < DEEPEST_BY_COST) {
        let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
        for leaf in leaves.iter() {
            add(&mut bins[bin(axis, leaf)], &leaf.bounds);
        }
        // Long boxes are to be cut across.
        let stretch = size.max_element() / size[axis];
        for (at, cost) in costs(&bins) {
            let cost = stretch * cost;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, at));
            }
        }
    }
    match best {
        Some((_, axis, at)) => {
            // Stable, so that the order of equals is that of the scene.
            leaves.sort_by_key(|leaf| bin(axis, leaf) >= at);
            let first = leaves.iter().position(|leaf| bin(axis, leaf) >= at);
            first.filter(|&first| first > 0).unwrap_or(half)
        }
        None => half,
    }
}

fn add(sum: &mut Option<LightBounds>, bounds: &LightBounds) {
    *sum = Some(sum.map_or(*bounds, |sum| sum.merged(bounds)));
}

/// The cost of cutting before each bin that has bins with lights on both sides.
fn costs(bins: &[Option<LightBounds>; BINS]) -> impl Iterator<Item = (usize, f32)> {
    let mut above = [None; BINS];
    let mut sum = None;
    for (i, bin) in bins.iter().enumerate().rev() {
        if let Some(bin) = bin {
            add(&mut sum, bin);
        }
        above[i] = sum;
    }
    let mut below = None;
    (1..BINS).filter_map(move |at| {
        if let Some(bin) = &bins[at - 1] {
            add(&mut below, bin);
        }
        let cost = below?.vagueness() + above[at]?.vagueness();
        Some((at, cost))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::math::hash::{mix2, unit_float};

    /// All lights below a node.
    fn lights(tree: &Tree, part: Part) -> Vec<LightId> {
        match (part.kind(), tree.node(part)) {
            (Kind::Light(light), _) => vec![light],
            (_, Some(node)) => node.halves.map(|half| lights(tree, half)).concat(),
            _ => vec![],
        }
    }

    fn leaves(count: u32, place: impl Fn(u32) -> Vec3) -> Vec<Candidate> {
        (0..count)
            .map(|i| Candidate {
                light: LightId(i),
                bounds: LightBounds::point(place(i), Rgb::ONE),
                power: 1.0,
                even: 0.0,
            })
            .collect()
    }

    fn random(i: u32) -> Vec3 {
        Vec3::from_array([1, 2, 3].map(|k| unit_float(mix2(i.into(), k))))
    }

    #[test]
    fn every_light_is_in_every_cut_once() {
        let places: [fn(u32) -> Vec3; 5] = [
            random,
            // On a line, ever denser; all at one place; unequal in size by 40 powers of ten; lost.
            |i| Vec3::X * 0.7f32.powi(i as i32),
            |_| Vec3::ONE,
            |i| random(i) * 10f32.powi(i as i32 % 77 - 38),
            |i| Vec3::X / (i as f32 - 5.0),
        ];
        for place in places {
            for count in [0, 1, 2, 3, 700] {
                let tree = Tree::new(leaves(count, place));
                for room in [1, 8, 100] {
                    let cut = tree.cut(tree.root, room);
                    assert!(cut.len() <= room);
                    let mut found: Vec<u32> = cut
                        .iter()
                        .flat_map(|&n| lights(&tree, n))
                        .map(|l| l.0)
                        .collect();
                    found.sort_unstable();
                    assert!(found.into_iter().eq(0..count));
                }
            }
        }
    }

    #[test]
    fn heaps_apart_are_told_apart() {
        let heap = |i: u32| random(i) + Vec3::X * 50.0 * (i % 4) as f32;
        let tree = Tree::new(leaves(400, heap));
        for node in tree.cut(tree.root, 4) {
            let lights = lights(&tree, node);
            assert_eq!(lights.len(), 100);
            assert!(lights.iter().all(|l| l.0 % 4 == lights[0].0 % 4));
        }
    }
}
