//! Choosing one light out of all, with a known probability.
//!
//! Strategies change noise only (docs/scene-language.md §4.2). Every light that can contribute has a
//! positive probability everywhere.

use super::Light;
use super::lanes::{LANES, Receiver};
use super::light_bounds::magnitude;
use super::light_tree::{Candidate, LightTree};
use super::small_light_set::SmallLightSet;
use crate::handles::LightId;
use crate::math::distribution::Distribution1D;
use crate::math::sampling::BELOW_ONE;
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use std::collections::{BTreeMap, BTreeSet};

/// Share of the strategy "power" that is spread evenly over groups: a weak light may be all that a
/// point sees.
const EVEN_SHARE: f32 = 0.1;

/// Below this part of the scene's radius a light does not count as nearer: its estimate would
/// drown all others though the point sees little of it.
const MIN_DISTANCE: f32 = 1e-3;

/// How one light is chosen (`lightsamplestrategy`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelectionStrategy {
    /// All lights alike.
    Uniform,
    /// By power, wherever the point is.
    Power,
    /// By what probably arrives at the point.
    #[default]
    Spatial,
}

impl SelectionStrategy {
    /// Reads `lightsamplestrategy`; another word is reported and means "spatial".
    pub fn from_params(reader: &ParamReader) -> SelectionStrategy {
        match reader.one_of("lightsamplestrategy", &["spatial", "power", "uniform"]) {
            "uniform" => SelectionStrategy::Uniform,
            "power" => SelectionStrategy::Power,
            _ => SelectionStrategy::Spatial,
        }
    }
}

/// Chooses lights. Lights are numbered as in the slice that [`LightSelector::new`] is given.
#[derive(Clone, Debug)]
pub struct LightSelector {
    choice: Choice,
    /// See [`LightSelector::choices`].
    first_choices: u32,
}

#[derive(Clone, Debug)]
enum Choice {
    /// Of so many lights, none or more.
    Uniform(u32),
    Power(Distribution1D),
    SmallLightSet(Box<SmallLightSet>),
    Spatial(LightTree),
}

/// A light that was chosen, by a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selected {
    /// Which.
    pub light: LightId,
    /// Its probability.
    pub pmf: f32,
    /// Where that number lies in the interval that chose the light, in [0, 1); with as few digits left as that is narrow.
    pub rest: f32,
}

impl LightSelector {
    /// For `lights` in a scene with a bounding sphere of radius `scene_radius`.
    pub fn new(lights: &[Light], strategy: SelectionStrategy, scene_radius: f32) -> LightSelector {
        let choice = match (lights.len(), strategy) {
            (n @ (0 | 1), _) | (n, SelectionStrategy::Uniform) => Choice::Uniform(n as u32),
            (_, SelectionStrategy::Power) => {
                Choice::Power(power_distribution(lights, scene_radius))
            }
            (n, SelectionStrategy::Spatial) => {
                let min_distance = if scene_radius.is_finite() {
                    MIN_DISTANCE * scene_radius.abs()
                } else {
                    0.0
                };
                let candidates = candidates(lights, scene_radius);
                if n <= LANES {
                    Choice::SmallLightSet(Box::new(SmallLightSet::new(&candidates, min_distance)))
                } else {
                    Choice::Spatial(LightTree::new(candidates, lights, min_distance))
                }
            }
        };
        let is_rich = lamps(lights) > FEW_LAMPS;
        LightSelector {
            choice,
            first_choices: if is_rich { FIRST_CHOICES } else { 1 },
        }
    }

    /// Returns `true` if [`LightSelector::sample`] looks at its number.
    pub fn chooses(&self) -> bool {
        !matches!(self.choice, Choice::Uniform(0 | 1))
    }

    /// The light that is always chosen.
    #[inline]
    pub fn only(&self) -> Option<LightId> {
        matches!(self.choice, Choice::Uniform(1)).then_some(LightId(0))
    }

    /// A light for the point `from`; `None` where there are no lights.
    pub fn sample(&self, from: &ReferencePoint, u: f32) -> Option<Selected> {
        match &self.choice {
            Choice::Uniform(n) => {
                let place = u * *n as f32;
                let light = (place as u32).min(n.checked_sub(1)?);
                Some(Selected {
                    light: LightId(light),
                    pmf: 1.0 / *n as f32,
                    rest: (place - light as f32).min(BELOW_ONE),
                })
            }
            Choice::Power(distribution) => {
                let (light, pmf, rest) = distribution.sample_discrete(u);
                Some(Selected {
                    light: LightId(light as u32),
                    pmf,
                    rest,
                })
            }
            Choice::SmallLightSet(few) => few.sample(&Receiver::new(from.p, from.n), u),
            Choice::Spatial(clusters) => clusters.sample(&Receiver::new(from.p, from.n), u),
        }
    }

    /// How many lights a path had better choose by [`LightSelector::sample`], at its first surface or at a later one, where not all of them
    /// are sampled.
    #[inline]
    pub fn choices(&self, is_first: bool) -> u32 {
        match is_first {
            true => self.first_choices,
            false => 1,
        }
    }

    /// How many lights there are, if so few that what the camera sees had better be lit by a sample of each instead of by one
    /// of one; lights are then numbered from 0 to this.
    pub fn sample_all_count(&self) -> Option<u32> {
        match &self.choice {
            Choice::SmallLightSet(few) if few.len() <= FEW_ENOUGH_FOR_ALL => Some(few.len() as u32),
            _ => None,
        }
    }

    /// Probability with which [`LightSelector::sample`] chooses `light` for the point `from`; 0 for one that it was not given.
    pub fn pmf(&self, from: &ReferencePoint, light: LightId) -> f32 {
        match &self.choice {
            Choice::Uniform(n) if light.0 < *n => 1.0 / *n as f32,
            Choice::Power(distribution) if light.index() < distribution.cells() => {
                distribution.probability(light.index())
            }
            Choice::Uniform(_) | Choice::Power(_) => 0.0,
            Choice::SmallLightSet(few) => few.pmf(&Receiver::new(from.p, from.n), light),
            Choice::Spatial(clusters) => clusters.pmf(&Receiver::new(from.p, from.n), light),
        }
    }
}

/// Lights so few that the first surface of a path had better sample all of them.
const FEW_ENOUGH_FOR_ALL: usize = 4;

/// Lights that are chosen at the first surface of a path where there are many lamps. Four bring less noise, but no more for the time that they
/// take (docs/notes/performance.md).
const FIRST_CHOICES: u32 = 3;

/// Lamps that are not many. Of so few the one that is chosen is more often one that matters, and with four lamps two choices did not pay.
const FEW_LAMPS: usize = 8;

/// The number of lamps: a lamp of many triangles is many lights.
fn lamps(lights: &[Light]) -> usize {
    let groups: BTreeSet<u32> = lights.iter().filter_map(Light::group).collect();
    let alone = lights.iter().filter(|light| light.group().is_none());
    groups.len() + alone.count()
}

/// The lights as the choice sees them. Lights without a group stand alone.
fn candidates(lights: &[Light], scene_radius: f32) -> Vec<Candidate> {
    let mut members: BTreeMap<u32, usize> = BTreeMap::new();
    let mut alone = 0;
    for light in lights {
        match light.group() {
            Some(group) => *members.entry(group).or_default() += 1,
            None => alone += 1,
        }
    }
    let groups = (members.len() + alone) as f32;
    let candidate = |(i, light): (usize, &Light)| {
        let group = light.group().and_then(|group| members.get(&group));
        Candidate {
            light: LightId(i as u32),
            bounds: light.bounds(),
            power: magnitude(light.power(scene_radius)),
            even: 1.0 / (groups * group.copied().unwrap_or(1) as f32),
        }
    };
    lights.iter().enumerate().map(candidate).collect()
}

/// Probabilities by power, a part of them even.
pub(super) fn power_distribution(lights: &[Light], scene_radius: f32) -> Distribution1D {
    let all = candidates(lights, scene_radius);
    let total: f32 = all.iter().map(|c| c.power).sum();
    let by_power = if total > 0.0 && total.is_finite() {
        (1.0 - EVEN_SHARE) / total
    } else {
        0.0
    };
    Distribution1D::new(all.iter().map(|c| by_power * c.power + EVEN_SHARE * c.even))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::diffuse::triangle_emitter;
    use crate::lights::{
        DiffuseAreaLight, DiffuseAreaSpec, DistantLight, DistantSpec, InfiniteLight, InfiniteSpec,
        PointLight, PointSpec, SpotLight, SpotSpec,
    };
    use crate::math::hash::{mix2, unit_float};
    use crate::math::transform::Transform;
    use crate::math::{DVec3, Rgb, Vec2, Vec3};

    const STRATEGIES: [SelectionStrategy; 3] = [
        SelectionStrategy::Uniform,
        SelectionStrategy::Power,
        SelectionStrategy::Spatial,
    ];

    fn at(p: Vec3) -> ReferencePoint {
        ReferencePoint {
            p,
            n: Vec3::Y,
            ..Default::default()
        }
    }

    fn point_light(position: DVec3, intensity: f32) -> Light {
        let spec = PointSpec {
            position,
            intensity: Rgb::splat(intensity),
        };
        Light::Point(Box::new(PointLight::new(&spec, None, &Transform::IDENTITY)))
    }

    fn sky() -> Light {
        let spec = InfiniteSpec {
            light_to_world: Transform::IDENTITY,
            radiance: Rgb::splat(0.2),
            samples: 1,
        };
        Light::Infinite(Box::new(InfiniteLight::new(
            &spec,
            None,
            &Transform::IDENTITY,
        )))
    }

    fn sun() -> Light {
        let spec = DistantSpec {
            toward: DVec3::Y,
            irradiance: Rgb::ONE,
        };
        Light::Distant(Box::new(DistantLight::new(
            &spec,
            None,
            &Transform::IDENTITY,
        )))
    }

    fn spot() -> Light {
        let spec = SpotSpec {
            light_to_world: Transform::IDENTITY,
            from: DVec3::new(0.0, 5.0, 0.0),
            to: DVec3::ZERO,
            intensity: Rgb::splat(9.0),
            cone_angle: 20.0,
            cone_delta_angle: 0.0,
        };
        Light::Spot(Box::new(SpotLight::new(&spec, None, &Transform::IDENTITY)))
    }

    /// A strip of triangles facing up.
    fn mesh(triangles: usize, group: u32) -> Vec<Light> {
        let spec = DiffuseAreaSpec {
            radiance: Rgb::splat(0.5),
            two_sided: false,
            samples: 1,
            one_light: false,
        };
        (0..triangles)
            .map(|i| {
                let x = i as f32 * 0.1;
                let corners = [
                    Vec3::new(x, 0.0, 0.0),
                    Vec3::new(x, 0.0, 0.2),
                    Vec3::new(x + 0.1, 0.0, 0.0),
                ];
                Light::DiffuseArea(DiffuseAreaLight::new(
                    &spec,
                    triangle_emitter(corners),
                    group,
                ))
            })
            .collect()
    }

    fn scenes() -> Vec<Vec<Light>> {
        let mixed = [
            vec![sky(), point_light(DVec3::ONE, 1.0), sun(), spot()],
            mesh(7, 3),
        ]
        .concat();
        let many = [
            vec![sky()],
            (0..300)
                .map(|i| point_light(DVec3::new(f64::from(i), 1.0, -2.0), 0.1))
                .collect(),
            mesh(900, 1),
        ]
        .concat();
        let few = vec![sky(), point_light(DVec3::ONE, 1.0), spot()];
        let dark = vec![point_light(DVec3::ZERO, 0.0), point_light(DVec3::X, 0.0)];
        let suns = (0..40).map(|_| sun()).collect();
        vec![mixed, many, few, dark, suns, mesh(2, 0)]
    }

    #[test]
    fn probabilities_sum_to_one_and_none_is_zero() {
        for lights in scenes() {
            for strategy in STRATEGIES {
                for radius in [0.0, 10.0, 1e20, f32::INFINITY] {
                    let selector = LightSelector::new(&lights, strategy, radius);
                    for p in [
                        Vec3::ZERO,
                        Vec3::ONE,
                        Vec3::new(-40.0, 3.0, 1e5),
                        Vec3::NAN,
                        Vec3::splat(1e30),
                    ] {
                        let pmfs =
                            (0..lights.len()).map(|i| selector.pmf(&at(p), LightId(i as u32)));
                        let (mut sum, mut least) = (0.0, f32::INFINITY);
                        for pmf in pmfs {
                            sum += f64::from(pmf);
                            least = least.min(pmf);
                        }
                        // A thousand single-precision probabilities.
                        assert!(
                            (sum - 1.0).abs() < 1e-4 && least > 0.0,
                            "{strategy:?} {radius} {p}: {sum} {least}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn more_are_chosen_at_first_surfaces_under_many_lamps() {
        let alone = |count: usize| (0..count).map(|_| sun()).collect::<Vec<Light>>();
        for (lights, first) in [
            (alone(0), 1),
            (alone(1), 1),
            (alone(8), 1),
            (alone(9), 3),
            (mesh(900, 1), 1),
            ([mesh(7, 0), mesh(9, 1)].concat(), 1),
            ([mesh(7, 0), alone(8)].concat(), 3),
        ] {
            for strategy in STRATEGIES {
                let selector = LightSelector::new(&lights, strategy, 30.0);
                assert_eq!(selector.choices(true), first);
                assert_eq!(selector.choices(false), 1);
            }
        }
    }

    #[test]
    fn lights_are_chosen_with_the_stated_probability() {
        for lights in scenes() {
            for strategy in STRATEGIES {
                let selector = LightSelector::new(&lights, strategy, 30.0);
                let from = at(Vec3::new(0.7, 1.5, 0.2));
                let n = 1 << 17;
                let mut counts = vec![0u32; lights.len()];
                let mut rests = vec![0.0; lights.len()];
                for i in 0..n {
                    let selected = selector.sample(&from, (i as f32 + 0.5) / n as f32).unwrap();
                    let (light, rest) = (selected.light, selected.rest);
                    assert!((selector.pmf(&from, light) / selected.pmf - 1.0).abs() < 1e-5);
                    assert!((0.0..1.0).contains(&rest), "{rest}");
                    counts[light.index()] += 1;
                    rests[light.index()] += f64::from(rest);
                }
                for (i, (count, rest)) in counts.into_iter().zip(rests).enumerate() {
                    let expected = selector.pmf(&from, LightId(i as u32)) * n as f32;
                    // Equally spaced numbers: each light owns up to two intervals, off by one at each
                    // end, and single-precision sums move the ends by another few.
                    assert!(
                        (count as f32 - expected).abs() < 8.0,
                        "{strategy:?} {i}: {count} but {expected}"
                    );
                    // For the same reason: so few of the places are missing, at one end.
                    let missing = rest - 0.5 * f64::from(count);
                    assert!(missing.abs() < 4.0, "{i}: {missing} of {count}");
                }
            }
        }
    }

    /// Light from all lights, estimated from one, is that from all: nothing is lost or doubled.
    #[test]
    fn one_light_stands_for_all() {
        let lights: Vec<Light> = (0..3000)
            .map(|i| {
                let r = |k| f64::from(unit_float(mix2(i, k)));
                point_light(
                    DVec3::new(40.0 * r(1), 40.0 * r(2), 5.0 * r(3)),
                    r(4) as f32,
                )
            })
            .collect();
        let from = at(Vec3::new(12.0, 7.0, 2.0));
        let brings = |light: &Light| {
            light
                .sample(&from, Vec2::ZERO)
                .map_or(0.0, |s| s.radiance.x)
        };
        let all: f64 = lights.iter().map(|l| f64::from(brings(l))).sum();
        for strategy in STRATEGIES {
            let selector = LightSelector::new(&lights, strategy, 30.0);
            let n = 200_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..n {
                let u = unit_float(mix2(i, 77));
                let selected = selector.sample(&from, u).unwrap();
                let value = f64::from(brings(&lights[selected.light.index()]) / selected.pmf);
                sum += value;
                squares += value * value;
            }
            let mean = sum / n as f64;
            let error = ((squares / n as f64 - mean * mean) / n as f64).sqrt();
            // Four standard errors: one false alarm in 15,000. Random numbers of 24 bits choose a
            // light of probability 1/3000 to 1 part in 5000.
            assert!(
                (mean - all).abs() < 4.0 * error + 2e-4 * all,
                "{strategy:?}: {mean} ± {error}, {all}"
            );
        }
    }

    #[test]
    fn choices_by_what_arrives_are_much_better() {
        let lights = mesh(2000, 0);
        let from = ReferencePoint {
            n: Vec3::NEG_Y,
            ..at(Vec3::new(3.0, 0.5, 0.1))
        };
        // Second moment of the estimate of what all bring, relative to the square of that.
        let moment = |strategy| {
            let selector = LightSelector::new(&lights, strategy, 200.0);
            let (mut all, mut squares) = (0.0, 0.0);
            for (i, light) in lights.iter().enumerate() {
                let value = light.sample(&from, Vec2::splat(0.5)).map_or(0.0, |s| {
                    f64::from(s.radiance.x * s.wi.dot(from.n).abs() / s.pdf)
                });
                let pmf = selector.pmf(&from, LightId(i as u32));
                all += value;
                squares += value * value / f64::from(pmf);
            }
            squares / (all * all)
        };
        let (uniform, spatial) = (
            moment(SelectionStrategy::Uniform),
            moment(SelectionStrategy::Spatial),
        );
        // 1 is perfect; the even share alone costs a ninth.
        assert!(spatial < 1.6 && uniform > 30.0, "{spatial} {uniform}");
    }

    #[test]
    fn a_near_lamp_is_found_in_a_huge_scene() {
        let lights = vec![
            sky(),
            sun(),
            point_light(DVec3::ZERO, 1.0),
            point_light(DVec3::X * 1e5, 1e4),
        ];
        let selector = LightSelector::new(&lights, SelectionStrategy::Spatial, 1e5);
        // Within the least distance of 100 units the light still beats its far, stronger like.
        let near = at(Vec3::Y);
        assert!(selector.pmf(&near, LightId(2)) > selector.pmf(&near, LightId(3)));
        let selector = LightSelector::new(&lights, SelectionStrategy::Spatial, 100.0);
        assert!(selector.pmf(&at(Vec3::Y * 0.2), LightId(2)) > 0.8);
        // Power alone would give it next to nothing.
        let power = LightSelector::new(&lights, SelectionStrategy::Power, 1e5);
        assert!(power.pmf(&near, LightId(2)) > 0.024);
    }

    #[test]
    fn a_lamp_counts_as_much_as_a_mesh_in_the_even_share() {
        let lights = [
            mesh(5000, 8),
            vec![point_light(DVec3::new(0.0, -50.0, 0.0), 1e-3)],
        ]
        .concat();
        for strategy in [SelectionStrategy::Power, SelectionStrategy::Spatial] {
            let selector = LightSelector::new(&lights, strategy, 300.0);
            let pmf = selector.pmf(&at(Vec3::new(3.0, 0.1, 0.1)), LightId(5000));
            assert!(pmf > 0.049, "{pmf}");
        }
    }

    #[test]
    fn dark_sides_and_cones_lower_the_chance() {
        let lights = [mesh(1, 0), vec![point_light(DVec3::Y * 3.0, 0.02)]].concat();
        let selector = LightSelector::new(&lights, SelectionStrategy::Spatial, 5.0);
        let (above, below) = (at(Vec3::Y), at(-Vec3::Y));
        assert!(selector.pmf(&above, LightId(0)) > 2.0 * selector.pmf(&below, LightId(0)));
        let even = 0.5 * crate::lights::small_light_set::EVEN_SHARE;
        assert!((selector.pmf(&below, LightId(0)) - even).abs() < 1e-6);

        let lights = vec![spot(), sky()];
        let selector = LightSelector::new(&lights, SelectionStrategy::Spatial, 5.0);
        assert!(selector.pmf(&at(Vec3::ZERO), LightId(0)) > 0.3);
        assert!((selector.pmf(&at(Vec3::X * 4.0), LightId(0)) - even).abs() < 1e-6);
    }

    #[test]
    fn one_light_is_certain_and_none_is_none() {
        for strategy in STRATEGIES {
            let one = LightSelector::new(&[sun()], strategy, 1.0);
            let selected = one.sample(&at(Vec3::ZERO), 0.7).unwrap();
            assert_eq!((selected.light, selected.pmf), (LightId(0), 1.0));
            assert_eq!(one.pmf(&at(Vec3::ZERO), LightId(0)), 1.0);
            assert!(
                LightSelector::new(&[], strategy, 1.0)
                    .sample(&at(Vec3::ZERO), 0.7)
                    .is_none()
            );
        }
    }
}
