//! The lights as paths begin at them.

use crate::handles::LightId;
use crate::lights::{
    Emission, EmissionDensity, EmissionGuide, EmitterChoice, RayNumbers, SceneSphere, place_of_ray,
};
use crate::math::adaptive_density::{AdaptiveDensity, Found, Sampled};
use crate::math::sampling::BELOW_ONE;
use crate::math::{Vec2, Vec3};
use crate::samplers::SampleStream;
use crate::samplers::choice::MIN_SHARED;
use crate::world::World;

/// What paths need that begin at a light.
#[derive(Debug)]
pub(super) struct Emitters {
    /// Where they begin.
    pub choice: EmitterChoice,
    /// Where they would begin by what is known of the lights alone.
    unguided: EmitterChoice,
    /// The scene that lights at infinity shine on.
    pub scene: SceneSphere,
    /// Of each light, where it sends light from which some may gather; none before it was looked for.
    aims: Vec<Option<AdaptiveDensity>>,
    /// Of each light, where one was learned.
    guides: Vec<Option<EmissionGuide>>,
}

/// The light that a path begins at, and what its ray there is chosen by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    /// The light.
    pub id: LightId,
    /// Its probability.
    pub pmf: f32,
    u: RayNumbers,
    /// Where a guide has led.
    guided: Option<Sampled>,
}

/// Points that paths are aimed at: of each light, of all lights, and of each where there are many; lights that would have fewer aim at none.
const POINTS: usize = 1 << 13;
const MAX_POINTS: usize = 1 << 16;
const MIN_POINTS: usize = 1 << 6;

/// Numbers of sample streams are multiples of this.
const RESOLUTION: f32 = 1.0 / (1u32 << 23) as f32;

impl Emitters {
    /// For all lights of the world that are sampled.
    pub(super) fn new(world: &World) -> Emitters {
        let (center, radius) = world.geometry.bounds().bounding_sphere();
        let choice = EmitterChoice::new(world.sampled_lights(), radius);
        Emitters {
            unguided: choice.clone(),
            choice,
            scene: SceneSphere { center, radius },
            aims: Vec::new(),
            guides: Vec::new(),
        }
    }

    /// For those of them that camera paths may meet.
    pub(super) fn of_lights_that_are_met(world: &World) -> Emitters {
        let all = Emitters::new(world);
        let met = world.sampled_lights().iter().enumerate();
        let masses: Vec<f64> = met
            .map(|(i, light)| match light.is_delta() {
                true => 0.0,
                false => all.choice.pmf(LightId(i as u32)).into(),
            })
            .collect();
        let choice = all.choice.mixed(&masses, 1.0);
        Emitters {
            unguided: choice.clone(),
            choice,
            ..all
        }
    }

    /// Chooses a light, and draws the numbers of a ray. The number of its direction chooses the light as well, so that the rays of
    /// each light are stratified as if it were the only one.
    pub(super) fn choose(&self, stream: &mut SampleStream) -> Option<Chosen> {
        let chooses = self.choice.chooses();
        let more = stream.next_1d_if(chooses);
        let (position, mut direction) = (stream.next_2d(), stream.next_2d());
        let (id, pmf, rest) = self.choice.sample(direction.x)?;
        if chooses {
            // With the digits that the choice has used up.
            direction.x = match pmf >= MIN_SHARED {
                true => (rest + more * RESOLUTION / pmf).min(BELOW_ONE),
                false => more,
            };
        }
        Some(Chosen {
            id,
            pmf,
            u: RayNumbers {
                position,
                direction,
            },
            guided: None,
        })
    }

    /// Finds where guides lead.
    pub(super) fn guide<'c>(
        &self,
        world: &World,
        chosen: impl IntoIterator<Item = &'c mut Chosen>,
    ) {
        if self.guides.is_empty() {
            return;
        }
        let wanted = chosen.into_iter().filter_map(|chosen| {
            let (density, u) = self
                .guide_of(chosen.id)?
                .guided(world.light(chosen.id), chosen.u)?;
            Some((density, u, &mut chosen.guided))
        });
        AdaptiveDensity::sample_all(wanted, |guided, sampled| *guided = Some(sampled));
    }

    /// The ray that was chosen.
    pub(super) fn emit(&self, world: &World, chosen: &Chosen) -> Option<Emission> {
        let (light, u) = (world.light(chosen.id), chosen.u);
        match self.guide_of(chosen.id) {
            Some(guide) => guide.emit(light, &self.scene, u, chosen.guided),
            None => light.emit(&self.scene, u.position, u.direction),
        }
    }

    /// What a guide is to know of a path that begins like this.
    pub(super) fn beginning(
        &self,
        world: &World,
        id: LightId,
        pmf: f32,
        emission: &Emission,
    ) -> Beginning {
        let (light, Emission { p, d, .. }) = (world.light(id), *emission);
        Beginning {
            light: id,
            at: place_of_ray(light, &self.scene, p, d),
            density: pmf * EmissionGuide::density_on_square(light, &self.scene, emission.density),
        }
    }

    /// Aims so many paths at what light may gather from, before it is known where they pay.
    pub(super) fn aim(&mut self, world: &World, paths: usize) {
        let points = world.points_of_caustics(POINTS);
        if points.is_empty() {
            return;
        }
        let lights = world.sampled_lights();
        // Each costs as much as the beginning of a path.
        let enough = POINTS.max(MIN_POINTS * lights.len());
        let most = paths.max(enough).min(MAX_POINTS);
        let step = (points.len() * lights.len()).div_ceil(most);
        if points.len() < step * MIN_POINTS {
            return;
        }
        let toward = |(i, light)| {
            let points = points.iter().copied().skip(i % step).step_by(step);
            EmissionGuide::toward(light, &self.scene, points)
        };
        self.aims = lights.iter().enumerate().map(toward).collect();
        let guide = |aim: &Option<AdaptiveDensity>| EmissionGuide::new(aim.clone()?);
        self.guides = self.aims.iter().map(guide).collect();
    }

    /// Begins paths where it pays, by what was `learned` from so many `paths`.
    pub(super) fn learn(&mut self, learned: &[Learned], paths: usize) {
        let mut of_lights = vec![Vec::new(); self.unguided.cells()];
        for &Learned { beginning, brought } in learned {
            if let Some(found) = of_lights.get_mut(beginning.light.index()) {
                found.push(Found {
                    at: beginning.at,
                    square: brought * f64::from(beginning.density),
                });
            }
        }
        let densities = of_lights
            .iter_mut()
            .map(|found| AdaptiveDensity::new(found, paths));
        let densities: Vec<_> = densities.collect();
        let mass = |density: &Option<AdaptiveDensity>| {
            density.as_ref().map_or(0.0, AdaptiveDensity::total)
        };
        let masses: Vec<f64> = densities.iter().map(mass).collect();
        self.choice = self.unguided.mixed(&masses, 1.0 - EmissionGuide::UNGUIDED);
        let aims = self.aims.iter().map(Option::as_ref);
        let aims = aims.chain(std::iter::repeat(None));
        let lights = densities.into_iter().zip(&of_lights).zip(aims);
        self.guides = lights
            .map(|((learned, found), aim)| EmissionGuide::new(aimed(learned, found.len(), aim)?))
            .collect();
    }

    fn guide_of(&self, id: LightId) -> Option<&EmissionGuide> {
        self.guides.get(id.index())?.as_ref()
    }

    /// The densities with which [`Emitters::emit`] chooses the ray through `p` in unit direction `d`, from a point with the
    /// normal `n` of a light that has an area.
    pub(super) fn density(
        &self,
        world: &World,
        id: LightId,
        n: Vec3,
        p: Vec3,
        d: Vec3,
    ) -> EmissionDensity {
        let light = world.light(id);
        let alone = light.emission_density(&self.scene, n, d);
        match self.guide_of(id) {
            Some(guide) => guide.mixed(light, &self.scene, alone, p, d),
            None => alone,
        }
    }
}

/// What was `learned` from so many paths that were `found`, with the share of its `aim` that one more might have.
fn aimed(
    learned: Option<AdaptiveDensity>,
    found: usize,
    aim: Option<&AdaptiveDensity>,
) -> Option<AdaptiveDensity> {
    match (learned, aim) {
        (Some(learned), Some(aim)) => {
            let share = 1.0 / (1.0 + (found as f32).sqrt());
            Some(learned.mixed(aim, share))
        }
        (learned, aim) => learned.or(aim.cloned()),
    }
}

/// Where a light path begins, as a guide sees it.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    /// The light.
    light: LightId,
    /// The ray: see [`place_of_ray`].
    at: Vec2,
    /// The density of both.
    density: f32,
}

/// What a path told.
#[derive(Clone, Copy, Debug)]
pub struct Learned {
    /// Where it began.
    pub beginning: Beginning,
    /// The square of what it brought.
    pub brought: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::testing::job;

    /// Of lights of all powers, each is chosen as often as its probability says, and the numbers that are left for its rays are uniform.
    #[test]
    fn a_choice_leaves_uniform_numbers() {
        let light = |i: i32| {
            let power = 4f32.powi(-(i % 7));
            format!("LightSource \"point\" \"rgb I\" [ {power} {power} {power} ]\n")
        };
        let lights: String = (0..60).map(light).collect();
        let text = format!("Integrator \"bdpt\"\nWorldBegin\n{lights}Shape \"sphere\"\nWorldEnd");
        let job = job(&text);
        let emitters = Emitters::new(&job.world);
        let n = 1 << 18;
        let mut found = vec![Vec::new(); 60];
        for i in 0..n {
            let chosen = emitters.choose(&mut job.sampler.light_stream(i)).unwrap();
            let RayNumbers {
                position,
                direction,
            } = chosen.u;
            for u in [position, direction] {
                assert!(u.min_element() >= 0.0 && u.max_element() < 1.0);
            }
            found[chosen.id.index()].push(direction.x);
        }
        let (mut shared, mut alone) = (0, 0);
        for (i, numbers) in found.iter_mut().enumerate() {
            let pmf = emitters.choice.pmf(LightId(i as u32));
            if pmf >= MIN_SHARED {
                shared += 1;
            } else {
                alone += 1;
            }
            let expected = pmf * n as f32;
            assert!(
                (numbers.len() as f32 / expected - 1.0).abs() < 0.02,
                "{i}: {} of {expected}",
                numbers.len()
            );
            // The distance of Kolmogorov and Smirnov; independent numbers would have a larger one once in 10⁵.
            numbers.sort_by(f32::total_cmp);
            let count = numbers.len() as f32;
            let distance = |(k, x): (usize, &f32)| (x - k as f32 / count).abs();
            let largest = numbers.iter().enumerate().map(distance).fold(0.0, f32::max);
            assert!(largest < 2.5 / count.sqrt(), "{i}: {largest} of {count}");
        }
        assert!(shared > 10 && alone > 10, "{shared} {alone}");
    }

    /// A ball of glass, one far away, two triangles, and a ball of an object that is placed three times, once moving; a matte floor is not wanted.
    #[test]
    fn points_are_where_the_surfaces_are_and_as_many_for_each() {
        let ball = "Shape \"sphere\" \"float radius\" .01";
        let text = format!(
            "Integrator \"bdpt\" WorldBegin Material \"matte\" Shape \"disk\" \"float radius\" 50 Material \"glass\" {ball} \
             AttributeBegin Translate 100 0 0 {ball} AttributeEnd \
             AttributeBegin Rotate 90 1 0 0 Shape \"trianglemesh\" \"integer indices\" [0 1 2 2 1 3] \"point P\" [0 5 0 1 5 0 0 6 0 9 9 0] AttributeEnd \
             ObjectBegin \"o\" {ball} ObjectEnd Translate 0 7 0 ObjectInstance \"o\" Translate 0 7 0 ObjectInstance \"o\" \
             Translate 0 7 0 ActiveTransform EndTime Translate 0 0 8 ActiveTransform All ObjectInstance \"o\" WorldEnd"
        );
        let world = job(&text).world;
        let points = world.points_of_caustics(1200);
        assert_eq!(points.len(), 600);
        let near = |at: Vec3, to: Vec3| (to - at).abs().max_element() <= 0.0101;
        let count = |at: [f32; 3]| points.iter().filter(|&&p| near(at.into(), p)).count();
        for at in [
            [0.0; 3],
            [100.0, 0.0, 0.0],
            [0.0, 7.0, 0.0],
            [0.0, 14.0, 0.0],
        ] {
            assert_eq!(count(at), 100, "{at:?}");
        }
        let moving = |p: &&Vec3| (p.y - 21.0).abs() < 0.02 && (-0.02..8.02).contains(&p.z);
        assert_eq!(points.iter().filter(moving).count(), 100);
        let in_mesh = |p: &&Vec3| p.y.abs() < 1e-5 && p.z >= 5.0 && p.x + p.z >= 5.0;
        let in_mesh: Vec<&Vec3> = points.iter().filter(in_mesh).collect();
        assert_eq!(in_mesh.len(), 100);
        // By area: the triangles have 0.5 and 3 of it, less what chance does to a hundred.
        let small = in_mesh.iter().filter(|p| p.x + p.z < 6.0).count();
        assert!((5..30).contains(&small), "{small}");
    }

    #[test]
    fn there_are_none_where_all_is_diffuse_or_nothing() {
        for shapes in ["", "Shape \"sphere\""] {
            let world = job(&format!("WorldBegin {shapes} WorldEnd")).world;
            assert!(world.points_of_caustics(100).is_empty());
        }
    }

    /// Some of very many parts are taken, from all over.
    #[test]
    fn of_many_parts_some_get_a_point() {
        let balls: String = (0..1000)
            .map(|i| format!("AttributeBegin Translate {i} 0 0 Shape \"sphere\" \"float radius\" .1 AttributeEnd\n"))
            .collect();
        let world = job(&format!("WorldBegin Material \"mirror\" {balls} WorldEnd")).world;
        let points = world.points_of_caustics(20);
        let expected = (0..10).map(|i| i as f32 * 100.0);
        for (p, x) in points.iter().zip(expected) {
            assert!((p.x - x).abs() < 0.11, "{p} {x}");
        }
        assert_eq!(points.len(), 10);
    }

    /// Light that is aimed meets what is small and far away; where nothing gathers light, none is aimed.
    #[test]
    fn paths_are_aimed_at_what_gathers_light() {
        let lights = [
            "LightSource \"point\" \"point from\" [0 5 0]",
            "LightSource \"distant\"",
            "AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .1",
        ];
        let text = |light: &str, material: &str| {
            format!(
                "Integrator \"bdpt\" WorldBegin AttributeBegin {light} AttributeEnd Material \"{material}\" \
                 Translate 30 0 0 Shape \"sphere\" \"float radius\" .05 Material \"matte\" Shape \"disk\" \"float radius\" 60 WorldEnd"
            )
        };
        for light in lights {
            let hits = |material: &str| {
                let job = job(&text(light, material));
                let mut emitters = Emitters::new(&job.world);
                emitters.aim(&job.world, MAX_POINTS);
                let n = 4096;
                let hit = (0..n).filter(|&i| {
                    let mut chosen = emitters.choose(&mut job.sampler.light_stream(i)).unwrap();
                    emitters.guide(&job.world, [&mut chosen]);
                    let Some(Emission { p, d, .. }) = emitters.emit(&job.world, &chosen) else {
                        return false;
                    };
                    let from_ball = Vec3::new(30.0, 0.0, 0.0) - p;
                    from_ball.dot(d) > 0.0 && from_ball.reject_from(d).length() < 0.05
                });
                hit.count() as f64 / n as f64
            };
            // Three quarters are aimed at the box around the ball, but each from another place of a lamp: 3 % of these meet it, and half of others. By
            // chance one in 10⁶ would.
            let (aimed, not) = (hits("mirror"), hits("matte"));
            assert!(aimed > 0.02 && not < 0.001, "{light}: {aimed} {not}");
        }
    }
}
