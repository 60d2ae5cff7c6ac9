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

/// What a node stands for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    Light(LightId),
    /// Position of the first of two neighboring nodes.
    Halves(u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) reach: LightBounds,
    pub(super) content: Content,
}

/// A tree; nodes are known by their positions, the root is 0. Without nodes if there are no lights.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    pub(super) fn new(mut leaves: Vec<Candidate>) -> Tree {
        let mut tree = Tree {
            nodes: Vec::with_capacity((2 * leaves.len()).saturating_sub(1)),
        };
        if let Some(first) = leaves.first() {
            tree.nodes.push(Node::of(first));
            tree.build(0, &mut leaves, 0);
        }
        tree
    }

    pub(super) fn node(&self, position: usize) -> Option<&Node> {
        self.nodes.get(position)
    }

    /// Makes the node at `position`, which exists, out of these leaves, and the tree below it.
    fn build(&mut self, position: usize, leaves: &mut [Candidate], depth: u32) {
        let (Some(leaf), 2..) = (leaves.first(), leaves.len()) else {
            if let Some(leaf) = leaves.first() {
                self.nodes[position] = Node::of(leaf);
            }
            return;
        };
        let first = self.nodes.len();
        self.nodes.extend([Node::of(leaf); 2]);
        let at = cut(leaves, depth);
        let (left, right) = leaves.split_at_mut(at);
        self.build(first, left, depth + 1);
        self.build(first + 1, right, depth + 1);
        self.nodes[position] = Node {
            reach: self.nodes[first].reach.merged(&self.nodes[first + 1].reach),
            content: Content::Halves(first as u32),
        };
    }

    /// At most `room` ≥ 1 nodes that stand for all below `top`: where one estimate for a node is
    /// worst, its halves are taken instead.
    pub(super) fn cut(&self, top: usize, room: usize) -> Vec<usize> {
        // The first halves of those that can be divided, and how much that is worth.
        let halves = |node: usize| match self.nodes.get(node)? {
            Node {
                reach,
                content: Content::Halves(first),
            } => Some((reach.vagueness(), *first as usize)),
            _ => None,
        };
        let mut nodes = vec![top];
        while nodes.len() < room {
            let divisible = (0..nodes.len()).filter_map(|i| Some((i, halves(nodes[i])?)));
            let worst = divisible.max_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
            let Some((worst, (_, first))) = worst else {
                break;
            };
            nodes[worst] = first;
            nodes.push(first + 1);
        }
        nodes
    }
}

impl Node {
    fn of(leaf: &Candidate) -> Node {
        Node {
            reach: leaf.reach,
            content: Content::Light(leaf.light),
        }
    }
}

/// Sorts at least two leaves into two parts; where the second one starts.
fn cut(leaves: &mut [Candidate], depth: u32) -> usize {
    let half = leaves.len() / 2;
    let centers = leaves.iter().map(|leaf| leaf.reach.center());
    let low = centers.clone().fold(Vec3::INFINITY, Vec3::min);
    let high = centers.fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = high - low;
    let bin = |axis: usize, leaf: &Candidate| {
        let place = (leaf.reach.center()[axis] - low[axis]) / size[axis];
        ((place * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0 && depth < DEEPEST_BY_COST) {
        let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
        for leaf in leaves.iter() {
            add(&mut bins[bin(axis, leaf)], &leaf.reach);
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

fn add(sum: &mut Option<LightBounds>, reach: &LightBounds) {
    *sum = Some(sum.map_or(*reach, |sum| sum.merged(reach)));
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
    fn lights(tree: &Tree, node: usize) -> Vec<LightId> {
        match tree.node(node).map(|n| n.content) {
            None => vec![],
            Some(Content::Light(light)) => vec![light],
            Some(Content::Halves(first)) => {
                let first = first as usize;
                [lights(tree, first), lights(tree, first + 1)].concat()
            }
        }
    }

    fn leaves(count: u32, place: impl Fn(u32) -> Vec3) -> Vec<Candidate> {
        (0..count)
            .map(|i| Candidate {
                light: LightId(i),
                reach: LightBounds::point(place(i), Rgb::ONE),
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
                    let cut = tree.cut(0, room);
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
        for node in tree.cut(0, 4) {
            let lights = lights(&tree, node);
            assert_eq!(lights.len(), 100);
            assert!(lights.iter().all(|l| l.0 % 4 == lights[0].0 % 4));
        }
    }
}
