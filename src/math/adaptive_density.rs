//! A piecewise-constant density on the unit square, fine where much was found: the square is halved, alternately along u
//! and v, as often as samples are worth it (the directional tree of Müller, Gross and Novák 2017, §3.1, with two
//! branches instead of four). A half has at least the share that one sample would give it, though there is none: rarely sampled, what is found
//! there after all would be as bright as it is rare. If one half after the other has none, what was missed is more likely in the larger ones.

use super::Vec2;
use super::sampling::BELOW_ONE;
use arrayvec::ArrayVec;

/// Halvings of a cell at most: sides of 1/4096. A sun's disk is as wide as the scene, and what gathers its light may be small.
const MAX_DEPTH: u32 = 24;

/// Samples of a cell that is halved: with fewer, its halves would show noise.
const SPLIT_SAMPLES: usize = 16;

/// Share of the whole that is worth a cell of its own.
const SPLIT_SHARE: f64 = 1.0 / 1024.0;

/// A sample of the function f that the density shall follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Where, in [0, 1)².
    pub at: Vec2,
    /// f² over the density with which `at` was chosen.
    pub square: f64,
}

/// Halvings, and so cells along a side, from where the nodes of a fine density are looked up.
const TABLE_DEPTH: u32 = 12;
const TABLE_SIDE: usize = 1 << (TABLE_DEPTH / 2);

/// With fewer nodes than these a table pays for nothing.
const TABLE_NODES: usize = 256;

/// See above.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveDensity {
    nodes: Vec<Node>,
    /// The node of each cell of [`TABLE_DEPTH`], or the larger cell that it is in, by rows of v; empty where there are few nodes.
    table: Vec<u32>,
    /// ∫ √⟨f²⟩, with the mean ⟨f²⟩ in each cell.
    total: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Probability of the lower half; of a cell its density.
    low: f32,
    /// Index of the lower half's node, which the upper's follows; 0 for a cell.
    halves: u32,
}

impl Node {
    /// One without halves, before it has a density.
    const CELL: Node = Node {
        low: 0.5,
        halves: 0,
    };

    /// The shares of its halves, which for a cell are the same.
    fn shares(self) -> [f32; 2] {
        let low = if self.halves == 0 { 0.5 } else { self.low };
        [low, 1.0 - low]
    }
}

/// A node of a density, and the probability that it is to have: in double precision, as it may be a product of 24 small shares.
#[derive(Clone, Copy)]
struct Mass<'d> {
    of: &'d AdaptiveDensity,
    node: usize,
    mass: f64,
}

impl<'d> Mass<'d> {
    fn of(of: &'d AdaptiveDensity, mass: f64) -> Mass<'d> {
        Mass { of, node: 0, mass }
    }

    /// Its lower or upper half: of a cell the same cell, and half of its mass.
    fn half(self, half: usize) -> Mass<'d> {
        let node = self.of.nodes[self.node];
        Mass {
            node: match node.halves {
                0 => self.node,
                halves => halves as usize + half,
            },
            mass: self.mass * f64::from(node.shares()[half]),
            ..self
        }
    }

    fn is_cell(self) -> bool {
        self.of.nodes[self.node].halves == 0
    }
}

impl AdaptiveDensity {
    /// The density that samples f with the least variance, ∝ √⟨f²⟩, from so many samples of which `found` are those that are not
    /// zero. `None` if there are none.
    pub fn new(found: &mut [Found], samples: usize) -> Option<AdaptiveDensity> {
        let all: f64 = found.iter().map(|found| found.square).sum();
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let root = |all: f64, area: f64| (all * area).sqrt();
        let mut density = AdaptiveDensity::filled(found, all, root);
        density.total /= (samples as f64).sqrt();
        Some(density)
    }

    /// The density that follows `points`. `None` if there are none.
    pub fn of_points(points: &[Vec2]) -> Option<AdaptiveDensity> {
        let found = |&at: &Vec2| Found { at, square: 1.0 };
        let mut found: Vec<Found> = points.iter().map(found).collect();
        let all = found.len() as f64;
        (all > 0.0).then(|| AdaptiveDensity::filled(&mut found, all, |all, _| all))
    }

    /// With halves in proportion to their `mass`, by the sum of the squares in a cell, which in the whole are `all`, and its area.
    fn filled(found: &mut [Found], all: f64, mass: fn(f64, f64) -> f64) -> AdaptiveDensity {
        let mut density = AdaptiveDensity {
            nodes: vec![Node::CELL],
            table: Vec::new(),
            total: 0.0,
        };
        // In the order of cells, however small.
        found.sort_by_cached_key(|found| Halves::of(found.at).all());
        density.total = density.fill(0, found, (0, 0), (all * SPLIT_SHARE, mass));
        density.finish();
        density
    }

    /// Gives cells their densities, where all halves have their shares.
    fn finish(&mut self) {
        self.multiply(0, 1.0);
        if self.nodes.len() >= TABLE_NODES {
            let places = (0..TABLE_SIDE * TABLE_SIDE).map(|i| (i % TABLE_SIDE, i / TABLE_SIDE));
            let middle =
                |(x, y): (usize, usize)| (Vec2::new(x as f32, y as f32) + 0.5) / TABLE_SIDE as f32;
            let node = |place| self.node_at(Halves::of(middle(place)), 0, TABLE_DEPTH);
            self.table = places.map(|place| node(place) as u32).collect();
        }
    }

    /// This density with a `share` of `other`, and the total of this.
    pub fn mixed(&self, other: &AdaptiveDensity, share: f32) -> AdaptiveDensity {
        let mut mixed = AdaptiveDensity {
            nodes: vec![Node::CELL],
            table: Vec::new(),
            total: self.total,
        };
        let masses = [(self, 1.0 - share), (other, share)];
        mixed.mix(0, masses.map(|(of, mass)| Mass::of(of, mass.into())));
        mixed.finish();
        mixed
    }

    /// Makes the node of those of two densities.
    fn mix(&mut self, node: usize, parts: [Mass; 2]) {
        if parts.iter().all(|part| part.is_cell()) {
            return;
        }
        let halves = self.nodes.len();
        self.nodes.extend([Node::CELL; 2]);
        let [low, high] = [0, 1].map(|half| parts.map(|part| part.half(half)));
        let mass = |parts: [Mass; 2]| parts[0].mass + parts[1].mass;
        self.nodes[node] = Node {
            low: (mass(low) / (mass(low) + mass(high))) as f32,
            halves: halves as u32,
        };
        self.mix(halves, low);
        self.mix(halves + 1, high);
    }

    /// Gives the cells of a node with this density theirs.
    fn multiply(&mut self, node: usize, density: f32) {
        let Node { low, halves } = self.nodes[node];
        if halves == 0 {
            self.nodes[node].low = density;
            return;
        }
        for (half, share) in [low, 1.0 - low].into_iter().enumerate() {
            self.multiply(halves as usize + half, density * (2.0 * share));
        }
    }

    /// Makes the node of `found`, which is not halved if their squares are less than `least`; returns its mass. As many of the last halvings left
    /// nothing in one half as are `alone`.
    fn fill(
        &mut self,
        node: usize,
        found: &[Found],
        (depth, alone): (u32, i32),
        (least, mass): (f64, fn(f64, f64) -> f64),
    ) -> f64 {
        let all: f64 = found.iter().map(|found| found.square).sum();
        let area = 0.5f64.powi(depth as i32);
        if found.len() < SPLIT_SAMPLES || depth == MAX_DEPTH || all < least {
            return mass(all, area);
        }
        let halves = self.nodes.len();
        self.nodes.extend([Node::CELL; 2]);
        let bit = |found: &Found| Halves::of(found.at).after(depth) == 1;
        let (low, high) = found.split_at(found.partition_point(|found| !bit(found)));
        let further = match low.is_empty() || high.is_empty() {
            true => alone + 1,
            false => 0,
        };
        let masses = [(halves, low), (halves + 1, high)]
            .map(|(node, part)| self.fill(node, part, (depth + 1, further), (least, mass)));
        let sum: f64 = masses.iter().sum();
        let low = if sum > 0.0 {
            (masses[0] / sum) as f32
        } else {
            0.5
        };
        // What is in a half may be rare, and missed: of n + 1 samples like these, one in it would give it this share, unless it is in one of the larger
        // halves that had none.
        let of_one = 0.5f32.powi(alone) / (1.0 + (found.len() as f32).sqrt());
        self.nodes[node] = Node {
            low: low.clamp(of_one, 1.0 - of_one),
            halves: halves as u32,
        };
        sum
    }

    /// Returns `true` if it is the same everywhere: nothing was found, or too little to tell where.
    pub fn is_even(&self) -> bool {
        self.nodes.len() == 1
    }

    /// ∫ √⟨f²⟩: what importance of the whole square is in a choice among several.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// One of [`AdaptiveDensity::sample_all`].
    #[cfg(test)]
    pub fn sample(&self, u: Vec2) -> Sampled {
        let mut descent = Descent::new(self, u);
        while descent.halve(0) && descent.halve(1) {}
        descent.end()
    }

    /// Points, each from two numbers in [0, 1), side by side: a step waits for the one before it, but not for those of others. Each is handed over
    /// with what came with its density and numbers.
    pub fn sample_all<'d, T>(
        wanted: impl IntoIterator<Item = (&'d AdaptiveDensity, Vec2, T)>,
        mut found: impl FnMut(T, Sampled),
    ) {
        let mut wanted = wanted.into_iter();
        loop {
            let some = wanted.by_ref().take(SIDE_BY_SIDE);
            let mut descents: ArrayVec<(Descent, T), SIDE_BY_SIDE> = some
                .map(|(density, u, with)| (Descent::new(density, u), with))
                .collect();
            if descents.is_empty() {
                return;
            }
            let mut step = |axis| {
                descents
                    .iter_mut()
                    .fold(false, |any, (descent, _)| descent.halve(axis) | any)
            };
            while step(0) && step(1) {}
            for (descent, with) in descents {
                found(with, descent.end());
            }
        }
    }

    /// The density at a point of [0, 1)².
    pub fn at(&self, at: Vec2) -> f32 {
        let mut halves = Halves::of(at);
        let place = halves.place();
        let node = match self.table.get(place) {
            Some(&node) => {
                halves.skip(TABLE_DEPTH);
                node as usize
            }
            None => 0,
        };
        self.nodes[self.node_at(halves, node, MAX_DEPTH)].low
    }

    /// The node that a point is in after so many halvings from `node` at most.
    fn node_at(&self, mut halves: Halves, mut node: usize, most: u32) -> usize {
        for _ in 0..most {
            let below = self.nodes[node].halves as usize;
            if below == 0 {
                break;
            }
            node = below + halves.next();
        }
        node
    }
}

/// A point, and the density there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// In [0, 1)².
    pub at: Vec2,
    /// See above.
    pub density: f32,
}

/// Descents side by side: what hides the time that a step takes.
const SIDE_BY_SIDE: usize = 8;

/// On the way to a cell.
struct Descent<'d> {
    nodes: &'d [Node],
    node: Node,
    sides: [Side; 2],
}

impl<'d> Descent<'d> {
    fn new(density: &'d AdaptiveDensity, u: Vec2) -> Descent<'d> {
        Descent {
            nodes: &density.nodes,
            node: density.nodes[0],
            sides: [u.x, u.y].map(Side::from),
        }
    }

    /// Comes to a half along `axis`: 0 for u, 1 for v. Returns `true` if that has halves itself.
    #[inline(always)]
    fn halve(&mut self, axis: usize) -> bool {
        if self.node.halves != 0 {
            let half = self.sides[axis].halve(self.node.low);
            self.node = self.nodes[self.node.halves as usize + half];
        }
        self.node.halves != 0
    }

    fn end(&self) -> Sampled {
        let [x, y] = &self.sides;
        Sampled {
            at: Vec2::new(x.point(), y.point()),
            density: self.node.low,
        }
    }
}

/// A cell along u or v, and a number in [0, 1) that chooses a point in it.
struct Side {
    min: f32,
    length: f32,
    u: f32,
}

impl From<f32> for Side {
    fn from(u: f32) -> Side {
        let (min, length) = (0.0, 1.0);
        Side { min, length, u }
    }
}

impl Side {
    /// Chooses the upper half (1) or the lower one, which has the probability `low`.
    #[inline(always)]
    fn halve(&mut self, low: f32) -> usize {
        self.length *= 0.5;
        let is_high = self.u >= low;
        let (share, rest, skipped) = match is_high {
            true => (1.0 - low, self.u - low, self.length),
            false => (low, self.u, 0.0),
        };
        self.u = (rest / share).clamp(0.0, BELOW_ONE);
        self.min += skipped;
        usize::from(is_high)
    }

    fn point(&self) -> f32 {
        (self.min + self.u * self.length).min(BELOW_ONE)
    }
}

/// Which half of its cell a point of [0, 1)² is in after each halving: bits of its coordinates in turn.
struct Halves([u32; 2]);

impl Halves {
    fn of(at: Vec2) -> Halves {
        const CELLS: f32 = (1u32 << (MAX_DEPTH / 2)) as f32;
        // The first bit that is asked for is the highest.
        Halves([at.x, at.y].map(|x| ((x * CELLS) as u32) << (32 - MAX_DEPTH / 2)))
    }

    /// The index in a table.
    fn place(&self) -> usize {
        let [x, y] = self.0.map(|bits| (bits >> (32 - TABLE_DEPTH / 2)) as usize);
        y * TABLE_SIDE + x
    }

    /// An even number of halvings.
    fn skip(&mut self, depth: u32) {
        self.0 = self.0.map(|bits| bits << (depth / 2));
    }

    /// The bits of all halvings, the first being the highest.
    fn all(mut self) -> u32 {
        (0..MAX_DEPTH).fold(0, |all, _| all << 1 | self.next() as u32)
    }

    /// After so many halvings.
    fn after(self, depth: u32) -> usize {
        let Halves(axes) = self;
        let bits = axes[depth as usize % 2] << (depth / 2);
        (bits >> 31) as usize
    }

    fn next(&mut self) -> usize {
        let Halves([x, y]) = *self;
        self.0 = [y, x << 1];
        (x >> 31) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    fn number(i: u64, k: u64) -> f32 {
        unit_float(mix2(i, k))
    }

    fn point(i: u64) -> Vec2 {
        Vec2::new(number(i, 0), number(i, 1))
    }

    /// A bright spot on faint ground: f² = 100 in a square of side 0.1, 1 elsewhere.
    fn square(at: Vec2) -> f64 {
        let inside = (at - Vec2::new(0.3, 0.7)).abs().max_element() < 0.05;
        if inside { 100.0 } else { 1.0 }
    }

    fn learned(n: u64) -> AdaptiveDensity {
        let at = (0..n).map(point);
        let mut found: Vec<Found> = {
            at.map(|at| Found {
                at,
                square: square(at),
            })
        }
        .collect();
        AdaptiveDensity::new(&mut found, n as usize).unwrap()
    }

    #[test]
    fn points_follow_the_density_and_it_integrates_to_1() {
        let density = learned(20_000);
        // No cell has sides of less than 1/256, with so few samples of a function that varies so little: the grid has a point in each.
        let grid =
            (0..1 << 16).map(|i| Vec2::new((i >> 8) as f32 + 0.5, (i & 255) as f32 + 0.5) / 256.0);
        let sum: f64 = grid.map(|at| f64::from(density.at(at))).sum();
        assert!((sum / 65536.0 - 1.0).abs() < 1e-5, "{sum}");
        let n = 100_000;
        let (mut inside, mut inverse) = (0.0, 0.0);
        for i in 0..n {
            let sampled = density.sample(Vec2::new(number(i, 2), number(i, 3)));
            let (at, value) = (sampled.at, sampled.density);
            assert!(at.min_element() >= 0.0 && at.max_element() < 1.0);
            // Rounding may bring a point to the edge of the next cell.
            assert!(value == density.at(at) || value == density.at(at - 1e-7));
            inside += f64::from(u8::from(square(at) > 1.0)) / n as f64;
            inverse += 1.0 / f64::from(value) / n as f64;
        }
        // The mean of 1/p over p is the area.
        assert!((inverse - 1.0).abs() < 0.02, "{inverse}");
        // √f² is 10 on 0.01 and 1 on 0.99: the spot has 0.0917 of the integral; cells at its edge blur it.
        assert!(inside > 0.08 && inside < 0.0917, "{inside}");
    }

    #[test]
    fn points_are_the_same_side_by_side() {
        let densities = [learned(20_000), learned(100), learned(1)];
        let mut count = 0;
        let wanted = (0..101).map(|i| (&densities[i as usize % 3], point(i), i));
        AdaptiveDensity::sample_all(wanted, |i, sampled| {
            assert_eq!(sampled, densities[i as usize % 3].sample(point(i)));
            count += 1;
        });
        assert_eq!(count, 101);
    }

    #[test]
    fn a_table_finds_the_same_cells() {
        let density = learned(50_000);
        assert!(!density.table.is_empty());
        let plain = AdaptiveDensity {
            table: Vec::new(),
            ..density.clone()
        };
        for i in 0..100_000 {
            assert_eq!(density.at(point(i)), plain.at(point(i)));
        }
    }

    /// The share of a half where n samples have met nothing is 1/(1 + √n) at least: what one more might have met.
    #[test]
    fn nothing_is_left_out_where_few_samples_were() {
        for n in [16, 100, 1000] {
            let mut found: Vec<Found> = (0..n)
                .map(|i| Found {
                    at: Vec2::new(0.5 * number(i, 0), number(i, 1)),
                    square: 1.0,
                })
                .collect();
            let density = AdaptiveDensity::new(&mut found, n as usize).unwrap();
            let share = 1.0 / (1.0 + (n as f32).sqrt());
            let missed = density.at(Vec2::new(0.75, 0.5));
            assert!(missed >= 1.99 * share && missed < 0.5, "{n}: {missed}");
        }
    }

    /// Points all in one small square: the density there is high, that elsewhere not 0.
    #[test]
    fn the_density_of_points_follows_them() {
        assert!(AdaptiveDensity::of_points(&[]).is_none());
        let corner = Vec2::new(0.5, 0.25);
        let points: Vec<Vec2> = (0..4096).map(|i| corner + point(i) / 16.0).collect();
        let density = AdaptiveDensity::of_points(&points).unwrap();
        let n = 20_000;
        let samples = (0..n).map(|i| density.sample(point(i)).at);
        let inside =
            samples.filter(|&at| (at - corner - 1.0 / 32.0).abs().max_element() <= 1.0 / 32.0);
        // The first of eight halvings leaves 1/(1 + √4096) to the empty half, each after it half of that.
        let expected: f64 = (0..8).map(|i| 1.0 - 0.5f64.powi(i) / 65.0).product();
        let share = inside.count() as f64 / n as f64;
        assert!((share - expected).abs() < 0.01, "{share} {expected}");
        assert!(density.at(Vec2::ZERO) > 0.0);
    }

    /// As a sum of the two, wherever their cells end.
    #[test]
    fn a_mixture_is_the_sum() {
        let points: Vec<Vec2> = (0..3000).map(|i| point(i).powf(4.0)).collect();
        let densities = [
            learned(20_000),
            learned(1),
            AdaptiveDensity::of_points(&points).unwrap(),
        ];
        for (a, b) in [(0, 2), (2, 0), (1, 2), (2, 1), (0, 0), (1, 1)] {
            let [a, b] = [&densities[a], &densities[b]];
            for share in [0.0, 0.01, 0.3, 1.0] {
                let mixed = a.mixed(b, share);
                assert_eq!(mixed.total(), a.total());
                for i in 0..2000 {
                    let at = point(i);
                    let expected = (1.0 - share) * a.at(at) + share * b.at(at);
                    // Products of 24 rounded shares.
                    let found = mixed.at(at);
                    assert!(
                        (found - expected).abs() <= 1e-4 * expected,
                        "{at} {share}: {found} {expected}"
                    );
                    let sampled = mixed.sample(at);
                    assert!(sampled.density > 0.0);
                }
            }
        }
    }

    #[test]
    fn the_total_is_the_integral_of_the_root() {
        let total = learned(50_000).total();
        // 0.1 + 0.99, and more by what cells at the edge average: √ is concave.
        assert!(total > 1.09 && total < 1.15, "{total}");
    }

    #[test]
    fn odd_samples_do_no_harm() {
        assert!(AdaptiveDensity::new(&mut [], 10).is_none());
        let at = Vec2::splat(BELOW_ONE);
        for square in [0.0, f64::NAN, f64::INFINITY] {
            assert!(AdaptiveDensity::new(&mut [Found { at, square }], 10).is_none());
        }
        // All at one point: cells end at their smallest.
        let mut found = vec![Found { at, square: 1e-30 }; 1000];
        let density = AdaptiveDensity::new(&mut found, 1000).unwrap();
        // The first of 24 halvings leaves 1/(1 + √1000) to the other half, each after it half of that.
        assert!(density.at(at) > 16_777_216.0 * 0.93 && density.at(Vec2::ZERO) > 0.0);
        for u in [Vec2::ZERO, at, Vec2::new(0.5, 0.0)] {
            let Sampled { at, density } = density.sample(u);
            assert!(at.max_element() < 1.0 && density > 0.0);
        }
    }
}
