//! Lights as a scene counts them. In pbrt-v3 every triangle of an emissive mesh is a light of its own; in pbrt-v2 the
//! mesh is one, whose triangles are chosen by area (its `ShapeSet`). That decides what `directlighting` and `whitted`
//! sample at each point, and so their cost and noise; the expectation is the same.

use super::Light;
use super::selection::Selected;
use crate::handles::LightId;
use crate::math::distribution::Distribution1D;

/// The sampled lights of a world, grouped.
#[derive(Clone, Debug, Default)]
pub struct LightGroups {
    groups: Vec<LightGroup>,
}

impl LightGroups {
    /// From all sampled lights, in the order of their handles.
    pub fn new(lights: &[Light]) -> LightGroups {
        let whole_shape = |light: &Light| match light {
            Light::DiffuseArea(l) if l.is_part() => light.group(),
            _ => None,
        };
        let mut groups = Vec::new();
        let mut first = 0;
        while first < lights.len() {
            let shape = whole_shape(&lights[first]);
            let rest = lights[first + 1..].iter();
            let more = rest.take_while(|light| shape.is_some() && whole_shape(light) == shape);
            let len = 1 + more.count();
            groups.push(LightGroup::new(first, &lights[first..first + len]));
            first += len;
        }
        LightGroups { groups }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &LightGroup> {
        self.groups.iter()
    }

    /// One of them, all alike, by `u` in [0, 1), and its probability. `None` where there are none.
    pub fn choose(&self, u: f32) -> Option<(&LightGroup, f32)> {
        let count = self.groups.len();
        let chosen = (u * count as f32) as usize;
        let group = self.groups.get(chosen.min(count.checked_sub(1)?))?;
        Some((group, 1.0 / count as f32))
    }
}

/// A light of one piece, or of many that stand next to each other among the lights.
#[derive(Clone, Debug)]
pub struct LightGroup {
    first: LightId,
    samples: u32,
    /// Where there are several pieces: by area, which is by power, as they shine alike.
    pieces: Option<Distribution1D>,
}

impl LightGroup {
    /// Of `pieces`, at least one, the first of which has the handle `first`.
    fn new(first: usize, pieces: &[Light]) -> LightGroup {
        let area = |light: &Light| match light {
            Light::DiffuseArea(l) => l.area() as f32,
            _ => 0.0,
        };
        LightGroup {
            first: LightId(first as u32),
            samples: pieces.first().map_or(1, Light::sample_count),
            pieces: (pieces.len() > 1).then(|| Distribution1D::new(pieces.iter().map(area))),
        }
    }

    /// The first of its pieces.
    pub fn first(&self) -> LightId {
        self.first
    }

    /// Samples that `directlighting` takes under its strategy "all".
    pub fn sample_count(&self) -> u32 {
        self.samples
    }

    /// Returns `true` if [`LightGroup::piece`] looks at its number.
    pub fn chooses(&self) -> bool {
        self.pieces.is_some()
    }

    /// One of the pieces, by `u` in [0, 1).
    pub fn piece(&self, u: f32) -> Selected {
        let (piece, pmf, rest) = match &self.pieces {
            None => (0, 1.0, u),
            Some(pieces) => pieces.sample_discrete(u),
        };
        Selected {
            light: LightId(self.first.0 + piece as u32),
            pmf,
            rest,
        }
    }

    /// Probability with which [`LightGroup::piece`] gives `light`; 0 for one of another group.
    pub fn pmf(&self, light: LightId) -> f32 {
        let piece = light.index().checked_sub(self.first.index());
        match (piece, &self.pieces) {
            (Some(0), None) => 1.0,
            (Some(piece), Some(pieces)) if piece < pieces.cells() => pieces.probability(piece),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::diffuse::triangle_emitter;
    use crate::lights::{DiffuseAreaLight, DiffuseAreaSpec, PointLight, PointSpec};
    use crate::math::transform::Transform;
    use crate::math::{DVec3, Rgb, Vec3};

    fn point() -> Light {
        let spec = PointSpec {
            position: DVec3::ONE,
            intensity: Rgb::ONE,
        };
        Light::Point(Box::new(PointLight::new(&spec, None, &Transform::IDENTITY)))
    }

    /// Triangles whose areas grow from the first, which has none.
    fn mesh(one_light: bool, group: u32) -> Vec<Light> {
        let spec = DiffuseAreaSpec {
            radiance: Rgb::ONE,
            two_sided: false,
            samples: 7,
            one_light,
        };
        (0..5)
            .map(|i| {
                let corners = [Vec3::ZERO, Vec3::X, i as f32 * Vec3::Y];
                Light::DiffuseArea(DiffuseAreaLight::new(
                    &spec,
                    triangle_emitter(corners),
                    group,
                ))
            })
            .collect()
    }

    #[test]
    fn a_mesh_is_one_light_or_as_many_as_it_has_triangles() {
        for (one_light, count) in [(true, 4), (false, 12)] {
            let lights = [
                vec![point()],
                mesh(one_light, 0),
                mesh(one_light, 1),
                vec![point()],
            ]
            .concat();
            let groups = LightGroups::new(&lights);
            assert_eq!(groups.iter().count(), count);
            let mut chosen = vec![0.0; lights.len()];
            let n = 5000;
            for i in 0..n * count {
                let (group, pmf) = groups
                    .choose((i as f32 + 0.5) / (n * count) as f32)
                    .unwrap();
                assert_eq!(pmf, 1.0 / count as f32);
                let Selected {
                    light,
                    pmf: piece,
                    rest,
                } = group.piece((i % n) as f32 / n as f32);
                assert_eq!(group.pmf(light), piece);
                assert!((0.0..1.0).contains(&rest));
                assert!(groups.iter().filter(|g| g.pmf(light) > 0.0).count() == 1);
                chosen[light.index()] += f64::from(pmf) / n as f64;
            }
            let expected = |i: usize| match (one_light, i) {
                (true, 1..=10) => ((i - 1) % 5) as f64 / 10.0,
                _ => 1.0,
            };
            for (i, chosen) in chosen.into_iter().enumerate() {
                // Midpoints of 5000 cells, and single-precision borders of them.
                let error = (chosen * count as f64 - expected(i)).abs();
                assert!(error < 1e-2, "light {i}: {chosen} for {}", expected(i));
            }
            let samples: Vec<u32> = groups.iter().map(LightGroup::sample_count).collect();
            assert_eq!((samples[0], samples[1]), (1, 7));
        }
        assert!(LightGroups::new(&[]).choose(0.5).is_none());
    }
}
