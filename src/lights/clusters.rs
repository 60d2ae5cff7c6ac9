//! Choosing a light by how strongly it arrives at the shading point.
//!
//! Lights are gathered into at most [`MOST_CLUSTERS`] clusters of neighbours. A cluster is chosen
//! by an estimate of what it brings to the point, a light within it by power: importance of the
//! kind of Conty Estevez and Kulla ("Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", 2018), over a flat list instead of a tree.
//!
//! The estimate knows nothing of shadows, so a part of the probability is shared out evenly among
//! *groups* (a lamp counts as much as a mesh of a thousand triangles), whatever the estimate says.

use super::reach::Reach;
use crate::handles::LightId;
use crate::math::Vec3;
use crate::math::distribution::Distribution1D;

/// Clusters that are looked at for every choice.
pub(super) const MOST_CLUSTERS: usize = 64;

/// Up to so many clusters, groups of several lights are split for a better estimate.
const SPLIT_CLUSTERS: usize = 32;

/// Clusters of lights without a place.
const MOST_PLACELESS: usize = 16;

/// Share of the probability that is spread evenly.
const EVEN_SHARE: f32 = 0.1;

/// One light, as it is seen here.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) light: LightId,
    pub(super) reach: Reach,
    /// Luminance of its power; ≥ 0.
    pub(super) power: f32,
    /// Its part of what is shared out evenly; all sum to 1.
    pub(super) even: f32,
}

/// Lights near each other.
#[derive(Clone, Debug)]
struct Cluster {
    members: Vec<LightId>,
    by_power: Distribution1D,
}

/// All lights.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    clusters: Vec<Cluster>,
    reaches: Box<Reaches>,
    /// For every light its cluster and its probability there.
    places: Vec<(u32, f32)>,
}

/// The clusters' reaches, one array per field, so that all are estimated together in lanes.
#[derive(Clone, Debug)]
struct Reaches {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    least_distance2: Lanes,
    intensity: Lanes,
    axis_x: Lanes,
    axis_y: Lanes,
    axis_z: Lanes,
    slope: Lanes,
    base: Lanes,
    everywhere: Lanes,
    even: Lanes,
}

type Lanes = [f32; MOST_CLUSTERS];

impl Clusters {
    /// From `groups` of lights. Distances below `least_distance` do not count as nearer.
    pub(super) fn new(groups: Vec<Vec<Candidate>>, lights: usize, least_distance: f32) -> Clusters {
        let gathered = gather(groups);
        let mut reaches = Box::new(Reaches::new());
        let mut places = vec![(0, 0.0); lights];
        let mut clusters = Vec::with_capacity(gathered.len());
        for (k, members) in gathered.into_iter().enumerate() {
            let cluster = Cluster::new(&members);
            for (i, member) in members.iter().enumerate() {
                if let Some(place) = places.get_mut(member.light.index()) {
                    *place = (k as u32, cluster.by_power.probability(i));
                }
            }
            let parts: Vec<Reach> = members.iter().map(|m| m.reach).collect();
            reaches.set(
                k,
                &Reach::merged(&parts),
                least_distance,
                members.iter().map(|m| m.even).sum(),
            );
            clusters.push(cluster);
        }
        Clusters {
            clusters,
            reaches,
            places,
        }
    }

    /// A light and its probability.
    pub(super) fn sample(&self, p: Vec3, u: f32) -> Option<(LightId, f32)> {
        let probabilities = self.reaches.probabilities(p, self.clusters.len());
        let mut left = u;
        for (k, cluster) in self.clusters.iter().enumerate() {
            let chance = probabilities[k];
            // Rounding may leave a rest beyond the last one.
            if left < chance || k + 1 == self.clusters.len() {
                let (i, within, _) = cluster
                    .by_power
                    .sample_discrete((left / chance).clamp(0.0, 1.0 - f32::EPSILON));
                return Some((cluster.members[i], chance * within));
            }
            left -= chance;
        }
        None
    }

    /// Probability with which [`Clusters::sample`] chooses `light`.
    pub(super) fn pmf(&self, p: Vec3, light: LightId) -> f32 {
        match self.places.get(light.index()) {
            Some(&(k, within)) => {
                self.reaches.probabilities(p, self.clusters.len())[k as usize] * within
            }
            None => 0.0,
        }
    }
}

impl Cluster {
    fn new(members: &[Candidate]) -> Cluster {
        let power: f32 = members.iter().map(|m| m.power).sum();
        let even: f32 = members.iter().map(|m| m.even).sum();
        let weight = |m: &Candidate| {
            let by_power = if power > 0.0 && power.is_finite() {
                m.power / power
            } else {
                0.0
            };
            (1.0 - EVEN_SHARE) * by_power + EVEN_SHARE * m.even / even
        };
        Cluster {
            members: members.iter().map(|m| m.light).collect(),
            by_power: Distribution1D::new(members.iter().map(weight)),
        }
    }
}

impl Reaches {
    fn new() -> Reaches {
        let zero = [0.0; MOST_CLUSTERS];
        Reaches {
            x: zero,
            y: zero,
            z: zero,
            least_distance2: [1.0; MOST_CLUSTERS],
            intensity: zero,
            axis_x: zero,
            axis_y: zero,
            axis_z: zero,
            slope: zero,
            base: zero,
            everywhere: zero,
            even: zero,
        }
    }

    fn set(&mut self, k: usize, reach: &Reach, least_distance: f32, even: f32) {
        let least = reach.radius.max(least_distance);
        (self.x[k], self.y[k], self.z[k]) = reach.center.into();
        (self.axis_x[k], self.axis_y[k], self.axis_z[k]) = reach.axis.into();
        self.least_distance2[k] = (least * least).max(f32::MIN_POSITIVE);
        self.intensity[k] = reach.intensity;
        self.slope[k] = reach.slope;
        self.base[k] = reach.base;
        self.everywhere[k] = reach.everywhere;
        self.even[k] = even;
    }

    /// Probabilities of the first `n` clusters at `p`.
    fn probabilities(&self, p: Vec3, n: usize) -> Lanes {
        let mut estimates = [0.0; MOST_CLUSTERS];
        for (k, estimate) in estimates.iter_mut().enumerate().take(n) {
            let (x, y, z) = (p.x - self.x[k], p.y - self.y[k], p.z - self.z[k]);
            let distance2 = (x * x + y * y + z * z).max(self.least_distance2[k]);
            let cos =
                (x * self.axis_x[k] + y * self.axis_y[k] + z * self.axis_z[k]) / distance2.sqrt();
            let share = (self.slope[k] * cos + self.base[k]).clamp(0.0, 1.0);
            *estimate = self.everywhere[k] + self.intensity[k] * share / distance2;
        }
        let total: f32 = estimates[..n].iter().sum();
        let (even_share, factor) = if total > 0.0 && total.is_finite() {
            (EVEN_SHARE, (1.0 - EVEN_SHARE) / total)
        } else {
            (1.0, 0.0)
        };
        for (estimate, even) in estimates.iter_mut().zip(&self.even).take(n) {
            // A point that is not finite gives estimates that are not: then evenly.
            let by_estimate = if factor > 0.0 {
                *estimate * factor
            } else {
                0.0
            };
            *estimate = by_estimate + even * even_share;
        }
        estimates
    }
}

/// At most [`MOST_CLUSTERS`] clusters of all candidates.
fn gather(groups: Vec<Vec<Candidate>>) -> Vec<Vec<Candidate>> {
    let (local, placeless): (Vec<_>, Vec<_>) = groups
        .into_iter()
        .filter(|g| !g.is_empty())
        .partition(|g| g.iter().all(|c| c.reach.is_local()));
    let mut clusters = if placeless.len() <= MOST_PLACELESS {
        placeless
    } else {
        vec![placeless.concat()]
    };
    let room = MOST_CLUSTERS - clusters.len();
    if local.len() > room {
        split(
            local.into_iter().map(Bunch::new).collect(),
            room,
            &mut clusters,
        );
        return clusters;
    }
    // Every group has a cluster; the larger ones get more of what is left to split into.
    let spare = SPLIT_CLUSTERS.saturating_sub(clusters.len() + local.len());
    let divisible: usize = local.iter().map(|g| g.len() - 1).sum();
    for group in local {
        let parts = 1 + spare * (group.len() - 1) / divisible.max(1);
        split(
            group.into_iter().map(|c| Bunch::new(vec![c])).collect(),
            parts,
            &mut clusters,
        );
    }
    clusters
}

/// Lights that stay together, and where.
struct Bunch {
    lights: Vec<Candidate>,
    center: Vec3,
}

impl Bunch {
    fn new(lights: Vec<Candidate>) -> Bunch {
        let center = lights.iter().map(|c| c.reach.center).sum::<Vec3>() / lights.len() as f32;
        Bunch { lights, center }
    }
}

/// Splits `bunches` into `parts` ≥ 1 neighbourhoods with about as many of them each, halving along
/// the longest extent of their centres.
fn split(mut bunches: Vec<Bunch>, parts: usize, clusters: &mut Vec<Vec<Candidate>>) {
    if parts <= 1 || bunches.len() <= 1 {
        clusters.push(bunches.into_iter().flat_map(|b| b.lights).collect());
        return;
    }
    let low = bunches
        .iter()
        .fold(Vec3::INFINITY, |low, b| low.min(b.center));
    let high = bunches
        .iter()
        .fold(Vec3::NEG_INFINITY, |high, b| high.max(b.center));
    let axis = (high - low).max_position();
    bunches.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let left_parts = parts / 2;
    let right = bunches.split_off((bunches.len() * left_parts / parts).max(1));
    split(bunches, left_parts, clusters);
    split(right, parts - left_parts, clusters);
}
