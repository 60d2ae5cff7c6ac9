//! The lights as paths begin at them.

use crate::handles::LightId;
use crate::lights::{
    Emission, EmissionDensity, EmissionGuide, EmitterChoice, SceneSphere, place_of_ray,
};
use crate::math::adaptive_density::{AdaptiveDensity, Found};
use crate::math::{Vec2, Vec3};
use crate::samplers::SampleStream;
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
    /// Of each light, where one was learned.
    guides: Vec<Option<EmissionGuide>>,
}

impl Emitters {
    /// For all lights of the world that are sampled.
    pub(super) fn new(world: &World) -> Emitters {
        let (center, radius) = world.geometry.bounds().bounding_sphere();
        let choice = EmitterChoice::new(world.sampled_lights(), radius);
        Emitters {
            unguided: choice.clone(),
            choice,
            scene: SceneSphere { center, radius },
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

    /// Chooses a light and a ray of it; also returns the light's probability.
    pub(super) fn begin(
        &self,
        world: &World,
        stream: &mut SampleStream,
    ) -> Option<(LightId, f32, Emission)> {
        let choice = stream.next_1d_if(self.choice.chooses());
        let (id, pmf, _) = self.choice.sample(choice)?;
        let (at, toward) = (stream.next_2d(), stream.next_2d());
        Some((id, pmf, self.emit(world, id, at, toward)?))
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
        self.guides = densities
            .into_iter()
            .map(|density| density.map(EmissionGuide::new))
            .collect();
    }

    fn guide_of(&self, id: LightId) -> Option<&EmissionGuide> {
        self.guides.get(id.index())?.as_ref()
    }

    /// A ray of light `id`, from numbers in [0, 1)².
    pub(super) fn emit(
        &self,
        world: &World,
        id: LightId,
        u_position: Vec2,
        u_direction: Vec2,
    ) -> Option<Emission> {
        let light = world.light(id);
        match self.guide_of(id) {
            Some(guide) => guide.emit(light, &self.scene, u_position, u_direction),
            None => light.emit(&self.scene, u_position, u_direction),
        }
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
