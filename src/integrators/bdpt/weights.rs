//! Multiple importance sampling over all strategies that find a path (Veach 1997, §10.2 and §10.3).
//!
//! A path x₀ … x_k from a light to the camera can be made in k + 2 ways: with s = 0 … k + 1 vertices from the light and the
//! other t = k + 1 − s from the camera. With pₛ the density of the way that has s vertices from the light, the power
//! heuristic (exponent 2) gives it the weight
//!
//! ```text
//! wₛ = pₛ² / Σ pᵢ² = 1 / (1 + L + C),    L = Σ_{i<s} (pᵢ/pₛ)²,    C = Σ_{i>s} (pᵢ/pₛ)²
//! ```
//!
//! pₛ is a product over the vertices: of each vertex's density *from the light* p⃗ for those before the connection, and *from
//! the camera* p⃖ for those behind it. So pᵢ/pₛ is a product of p⃖/p⃗ over the vertices in between, and L depends on
//! the light's side alone, C on the camera's. Seen from either end, with x₀ … x_i the vertices of that side, p⃗ the density
//! with which that side makes them and p⃖ that of the other side,
//!
//! ```text
//! A_i = Σ_{n ≤ i} o_n ∏_{j=n}^{i} (p⃖_j/p⃗_j)² = (p⃖_i/p⃗_i)² (o_i + A_{i−1})
//! ```
//!
//! where o_n is the square of how often the way with n vertices from this side is tried in a camera sample (1, or the share of camera
//! paths that are joined), and 0 where it cannot be: where x_{n−1} or x_n scatters by a delta distribution. p⃖_i and p⃖_{i−1} depend on where the path continues from x_i, all before does not: [`History`] keeps
//! that (as do Georgiev, Křivánek, Davidovič and Slusallek 2012, in the supplement, for other strategies).
//!
//! Densities are per area; at a vertex in a medium per volume, without the factor for the distance to it, which is the
//! same for weights of every strategy that matters. Deltas of perfectly specular scattering are left out on both sides: they
//! occur once in every pₛ. Two ends differ:
//! * x₀ on the light: emitter sampling (s = 1) has another density there than paths that begin at the light, which is in o₁;
//!   o₀ is 0 for lights that no path meets by chance.
//! * x₀ at the camera: N light paths are shared by all pixels, where a pixel's camera paths are its own. N per
//!   sample of a pixel is in o₁; o₀ is 0, as no path meets the lens by chance.

/// What the vertices of one side know of the strategies with fewer vertices on that side: those up to x_i, but for what depends
/// on where the path continues. In double precision: squares of densities leave the range of single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct History {
    /// p⃗_i.
    pub density: f64,
    /// Turns a density per solid angle at x_i into one per area at x_{i−1}.
    pub backward: f64,
    /// o_i, if x_i does not scatter by a delta.
    pub before: f64,
    /// (o_{i−1} + A_{i−2}) / p⃗²_{i−1}.
    pub rest: f64,
}

/// What is known before x_{i+1} is found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Onward {
    /// o_{i+1}, if x_{i+1} does not scatter by a delta.
    pub before: f64,
    /// (o_i + A_{i−1}) / p⃗²_i.
    pub rest: f64,
}

impl History {
    /// x_i that no other strategy makes: a camera path left a material there by subsurface scattering.
    pub(super) const ALONE: History = History {
        density: 1.0,
        backward: 0.0,
        before: 0.0,
        rest: 0.0,
    };

    /// Continues from x_i; `reverse` is the density per solid angle with which the other side would have continued toward
    /// x_{i−1}. At a delta both directions' densities are 1.
    pub(super) fn onward(&self, delta: bool, reverse: f64, connections: f32) -> Onward {
        let here = if delta { 0.0 } else { self.before };
        Onward {
            before: if delta {
                0.0
            } else {
                square(connections.into())
            },
            rest: (here + square(reverse * self.backward) * self.rest) / square(self.density),
        }
    }

    /// `true` if no strategy has fewer vertices on this side: then A_i is 0 wherever the path continues.
    pub(super) fn is_alone(&self) -> bool {
        self.before == 0.0 && self.rest == 0.0
    }

    /// A_i where the other side makes x_i with the density `other`, and from there continues toward x_{i−1} with the
    /// density `reverse` per solid angle.
    pub(super) fn earlier(&self, other: f64, reverse: f64) -> f64 {
        let ratio = square(other / self.density);
        ratio * (self.before + square(reverse * self.backward) * self.rest)
    }

    /// C where x_i, the last vertex, lies on a light (s = 0). Emitter sampling would have found it there with the density
    /// `direct` (0 where it could not), and a path that begins there with `emitted`, to come to x_{i−1} with `onward`.
    pub(super) fn at_light(&self, direct: f64, emitted: f64, onward: f64) -> f64 {
        let sampled = square(direct / self.density);
        let begun = square(emitted / self.density) * square(onward) * self.rest;
        sampled + begun
    }
}

/// The weight of a joint (s ≥ 2 and t ≥ 2) where a share `connections` of camera paths is joined to light paths: L and C are the
/// densities of the others over that of the joint if all were joined.
pub(super) fn weight_of_joint(light: f64, camera: f64, connections: f32) -> f32 {
    let share = square(connections.into());
    weight(light / share, camera / share)
}

/// The weight of a strategy, from L and C. What is not a number, 0 times infinity of densities out of all bounds, counts as 0.
pub(super) fn weight(light: f64, camera: f64) -> f32 {
    let weight = 1.0 / (1.0 + light + camera);
    if weight.is_nan() { 0.0 } else { weight as f32 }
}

pub(super) fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A path as Veach describes it: every density and which vertices scatter by a delta.
    #[derive(Clone, Debug)]
    struct Whole {
        /// From the light, per area; [0] as emission has it.
        light: Vec<f64>,
        /// From the camera; the camera's own vertex, the last, counts 1.
        camera: Vec<f64>,
        delta: Vec<bool>,
        /// Of emitter sampling, at [0].
        direct: f64,
        hittable: bool,
        /// Light paths per camera sample of a pixel.
        paths: f64,
        /// The share of camera paths that are joined to light paths.
        joined: f32,
    }

    impl Whole {
        /// The density of the strategy with `s` vertices from the light; 0 where there is none.
        fn strategy(&self, s: usize) -> f64 {
            let k = self.light.len() - 1;
            let t = k + 1 - s;
            let connected = s == 0 || t == 0 || (!self.delta[s - 1] && !self.delta[s]);
            if t == 0 || !connected || (s == 0 && !self.hittable) || (s == 1 && t == 1) {
                return 0.0;
            }
            let first = if s == 1 { self.direct } else { self.light[0] };
            let from_light: f64 = (1..s).map(|i| self.light[i]).product();
            let from_camera: f64 = (s..k).map(|i| self.camera[i]).product();
            let light = if s == 0 { 1.0 } else { first * from_light };
            let often = match (s, t) {
                (_, 1) => self.paths,
                (2.., 2..) => self.joined.into(),
                _ => 1.0,
            };
            light * from_camera * often
        }

        /// Weights by the definition.
        fn expected(&self, s: usize) -> f64 {
            let squares = (0..=self.light.len()).map(|i| square(self.strategy(i)));
            square(self.strategy(s)) / squares.sum::<f64>()
        }

        /// The light's side up to its vertex `last` ≥ 1. Densities are per area all along: `backward` is 1.
        fn from_light(&self, last: usize) -> History {
            let mut history = History {
                density: self.light[1],
                backward: 1.0,
                before: square(self.direct / self.light[0]),
                rest: f64::from(u8::from(self.hittable)) / square(self.light[0]),
            };
            for i in 1..last {
                let onward = history.onward(self.delta[i], self.camera[i - 1], self.joined);
                history = self.arrived(onward, self.light[i + 1]);
            }
            history
        }

        /// The camera's side to the vertex with index `last` ≤ k − 1.
        fn from_camera(&self, last: usize) -> History {
            let k = self.light.len() - 1;
            let mut history = History {
                density: self.camera[k - 1],
                backward: 0.0,
                before: square(self.paths),
                rest: 0.0,
            };
            for i in (last + 1..k).rev() {
                let toward = if i + 1 == k { 0.0 } else { self.light[i + 1] };
                let onward = history.onward(self.delta[i], toward, self.joined);
                history = self.arrived(onward, self.camera[i - 1]);
            }
            history
        }

        fn arrived(&self, onward: Onward, density: f64) -> History {
            History {
                density,
                backward: 1.0,
                before: onward.before,
                rest: onward.rest,
            }
        }

        /// The weight as the integrator puts it together.
        fn found(&self, s: usize) -> f32 {
            let k = self.light.len() - 1;
            let t = k + 1 - s;
            if s == 0 {
                let direct = match t {
                    2 => 0.0,
                    _ if self.delta[1] => 0.0,
                    _ => self.direct,
                };
                let camera = self.from_camera(0);
                return weight(0.0, camera.at_light(direct, self.light[0], self.light[1]));
            }
            let after = |i: usize| if i >= k { 0.0 } else { self.light[i] };
            if s == 1 {
                let hit = if self.hittable {
                    self.camera[0] / self.direct
                } else {
                    0.0
                };
                let from_here = self.light[1] * self.light[0] / self.direct;
                let camera = self.from_camera(1).earlier(from_here, after(2));
                return weight(square(hit), camera);
            }
            let other = if t == 1 { 1.0 / self.paths } else { 1.0 } * self.camera[s - 1];
            let light = self.from_light(s - 1).earlier(other, self.camera[s - 2]);
            if t == 1 {
                return weight(light, 0.0);
            }
            let camera = self.from_camera(s).earlier(self.light[s], after(s + 1));
            weight_of_joint(light, camera, self.joined)
        }
    }

    fn paths() -> impl Strategy<Value = Whole> {
        (3usize..9).prop_flat_map(|n| {
            let densities = || prop::collection::vec(1e-3f64..1e3, n);
            let deltas = prop::collection::vec(any::<bool>(), n);
            (
                densities(),
                densities(),
                deltas,
                1e-3f64..1e3,
                any::<bool>(),
                // None where the light pass is left out.
                prop_oneof![Just(0.0), 1.0f64..1e6],
                // As a pilot pass chooses, and any.
                prop_oneof![Just(0.0f32), Just(1.0), Just(1.0 / 32.0), 1e-3f32..1.0],
            )
                .prop_map(
                    move |(light, camera, mut delta, direct, hittable, paths, joined)| {
                        // The ends do not scatter.
                        (delta[0], delta[n - 1]) = (false, false);
                        Whole {
                            light,
                            camera,
                            delta,
                            direct,
                            hittable,
                            paths,
                            joined,
                        }
                    },
                )
        })
    }

    proptest! {
        /// Each weight is Veach's, and those of all strategies that find a path sum to 1.
        #[test]
        fn weights_are_the_power_heuristics_and_sum_to_one(path in paths()) {
            let k = path.light.len() - 1;
            let mut sum = 0.0;
            for s in 0..=k {
                if path.strategy(s) == 0.0 {
                    continue;
                }
                let (found, expected) = (f64::from(path.found(s)), path.expected(s));
                // Double precision, returned in single.
                prop_assert!((found - expected).abs() < 2e-7, "{s}: {found} but {expected}, {path:?}");
                sum += found;
            }
            prop_assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-6, "{sum}");
        }
    }

    #[test]
    fn densities_out_of_all_bounds_leave_weights_between_0_and_1() {
        let extremes = [0.0, 1e-300, 1e-30, 1.0, 1e30, 1e300, f64::INFINITY];
        for density in extremes {
            for other in extremes {
                for rest in extremes {
                    let history = History {
                        density,
                        backward: other,
                        before: 1.0,
                        rest,
                    };
                    let earlier = history.earlier(other, density);
                    let weight = weight(earlier, history.at_light(other, density, rest));
                    assert!((0.0..=1.0).contains(&weight), "{density} {other} {rest}");
                }
            }
        }
    }
}
