//! Paths from the camera (t ≥ 2): they meet a light (s = 0), are joined to a point of one (s = 1), or to a vertex of a path from
//! one (s ≥ 2).

use super::Bdpt;
use super::joins::Gain;
use super::kept::LightPath;
use super::light_end::Lit;
use super::strategies::layer;
use super::vertex::{FlatVertex, Vertex};
use super::walk::{Branches, Carries, Met, Spread, Turn, Walk, surface_bsdf};
use super::weights::{History, square, weight};
use crate::accel::GeometryHit;
use crate::bsdf::{Boundary, Bsdf};
use crate::handles::LightId;
use crate::integrators::context::Context;
use crate::integrators::shadows::Shadows;
use crate::integrators::subsurface::find_exit;
use crate::integrators::vertex::MediumVertex;
use crate::integrators::vertices::Next;
use crate::integrators::witness;
use crate::integrators::{BOTH_WAYS, Sight};
use crate::lights::LightEnd;
use crate::materials::Material;
use crate::math::color::is_black;
use crate::math::ray::RayDifferentials;
use crate::math::{Rgb, Vec3};
use crate::samplers::SampleStream;
use crate::surface::ReferencePoint;

/// What a path from the camera has come to.
#[derive(Default)]
pub(super) struct Trail {
    pub walk: Walk,
    /// Light collected so far, but for that of joined paths.
    pub radiance: Rgb,
    /// Light by s ≥ 2.
    pub joined: Rgb,
    /// Ways that are left. The last one is taken first.
    branches: Branches,
}

impl Trail {
    /// Begins along the camera ray.
    #[inline(always)]
    pub(super) fn begin(&mut self, context: &Context) {
        let ray = context.ray();
        let from = ReferencePoint {
            p: ray.o,
            time: ray.time,
            ..ReferencePoint::default()
        };
        let medium = context.world.media.camera;
        self.walk
            .begin(ray, medium, (&from, Spread::Camera), Rgb::ONE);
        self.radiance = Rgb::ZERO;
        self.joined = Rgb::ZERO;
        self.branches.clear();
    }

    /// Takes the last of the ways that are left, if there is one.
    pub(super) fn turn_back(&mut self, stream: &mut SampleStream) -> Option<()> {
        self.branches.pop()?.take(&mut self.walk, stream);
        Some(())
    }
}

/// A path from the camera while it is traced. Methods return `None` where it ends.
pub(super) struct CameraPath<'c, 'a> {
    pub bdpt: &'c Bdpt,
    pub context: &'c mut Context<'a>,
    pub trail: &'c mut Trail,
    /// Those of the camera ray, up to its hit.
    pub differentials: Option<&'a RayDifferentials>,
    /// What it is joined to.
    pub light_path: LightPath<'c, 'a>,
    /// Where shadow rays wait for others, and the number of the path there; else they are traced at once.
    pub waiting: Option<(&'c mut Shadows<Gain>, u32)>,
}

impl<'c, 'a> CameraPath<'c, 'a> {
    /// Extends the path by a vertex.
    pub(super) fn extend(&mut self) -> Option<()> {
        let hit = self.context.world.intersect(&self.trail.walk.ray);
        let met = self.advance(hit.as_ref().map(|hit| hit.t))?;
        self.arrive_at(&met, hit.as_ref())
    }

    /// Takes the last of the ways that are left, if there is one.
    pub(super) fn turn_back(&mut self) -> Option<()> {
        self.trail.turn_back(self.context.stream)
    }

    /// To the next surface, if the ray hits one, at distance `t`, or to what scatters before it.
    pub(super) fn advance(&mut self, t: Option<f32>) -> Option<Met> {
        let walk = &mut self.trail.walk;
        let met = walk.advance(self.context.world, t, self.context.stream);
        if !walk.throughput.is_finite() {
            // The sample is dropped, and counted.
            self.trail.radiance += walk.throughput;
            return None;
        }
        met
    }

    /// Extends the path by a vertex where it has come to; `hit`: the surface that its ray hits, which matters in a medium only where layers look
    /// at the path.
    pub(super) fn arrive_at(&mut self, met: &Met, hit: Option<&GeometryHit>) -> Option<()> {
        match (met, hit) {
            (Met::Medium(at), _) => self.meet_particle(at, hit),
            (Met::Surface, Some(hit)) => self.meet(hit),
            (Met::Surface | Met::Background, _) => {
                self.arrive(witness::Met::Background);
                self.context.look(Sight::escape);
                self.add_escaped();
                None
            }
        }
    }

    /// Extends the path by a vertex in a medium.
    fn meet_particle(&mut self, at: &MediumVertex, hit: Option<&GeometryHit>) -> Option<()> {
        self.arrive(witness::Met::Medium);
        if self.context.is_looked_at() {
            self.look_beyond(hit);
        }
        let history = self.history(at.p, 1.0);
        if self.trail.walk.depth >= self.bdpt.max_depth {
            return None;
        }
        self.join(Vertex::Medium(at), &history);
        if self.is_spent() {
            return None;
        }
        let (walk, stream) = (&mut self.trail.walk, &mut *self.context.stream);
        walk.scatter_in_medium(at, &history, self.bdpt.connections, stream);
        self.differentials = None;
        walk.russian_roulette(Rgb::ONE, stream)
    }

    /// Extends the path by a vertex on a surface.
    fn meet(&mut self, hit: &GeometryHit) -> Option<()> {
        let world = self.context.world;
        self.arrive(witness::Met::Surface(hit.material));
        let cosine = hit.surface.n.dot(hit.surface.wo).abs();
        let history = self.history(hit.surface.p, cosine);
        self.add_emission(hit, &history);
        let differentials = self.differentials.take();
        let boundary = world.even_boundary(hit.material);
        if let Some(boundary) = boundary.filter(|_| !self.context.is_looked_at()) {
            return self.cross((hit, boundary), &history);
        }
        let mut bsdf = Bsdf::empty();
        if surface_bsdf(world, hit, differentials, Carries::Radiance, &mut bsdf).is_none() {
            return self.trail.walk.pass(world, hit);
        }
        if self.context.is_looked_at() {
            self.look_at(hit, &bsdf, differentials);
            if let Some(boundary) = boundary {
                return self.cross((hit, boundary), &history);
            }
        }
        if self.trail.walk.depth >= self.bdpt.max_depth {
            return None;
        }
        let bsdf = &bsdf;
        let below = world.scatters_below(hit, bsdf, differentials);
        let vertex = Vertex::Surface {
            hit,
            bsdf,
            medium: self.trail.walk.medium,
            below,
        };
        if vertex.connects() {
            self.join(vertex, &history);
        }
        if self.is_spent() {
            return None;
        }
        self.scatter((hit, bsdf, below), &history, differentials)
    }

    /// Extends the path by a vertex on a smooth boundary. Early in the path it takes both ways, so that neither is noisy for the choice.
    fn cross(&mut self, at: (&GeometryHit, &Boundary), history: &History) -> Option<()> {
        if self.trail.walk.depth >= self.bdpt.max_depth || self.is_spent() {
            return None;
        }
        let how = (Carries::Radiance, self.bdpt.connections);
        let Context { world, stream, .. } = &mut *self.context;
        let walk = &mut self.trail.walk;
        if walk.depth >= BOTH_WAYS {
            return walk.cross(world, at, how, history, stream);
        }
        let (first, other) = walk.cross_both_ways(world, at, how, history, stream);
        self.trail.branches.extend(other);
        first
    }

    /// Collects the light at a vertex on a flat triangle. Returns what the path is to know if it continues.
    pub(super) fn meet_flat(&mut self, at: &FlatVertex) -> Option<History> {
        let history = self.history(at.from.p, at.cosine);
        self.join(Vertex::Flat(at), &history);
        (!self.is_spent()).then_some(history)
    }

    /// Continues from a flat triangle in a direction that was chosen.
    pub(super) fn leave_flat(
        &mut self,
        at: &FlatVertex,
        (next, weight): (&Next, Rgb),
        history: &History,
    ) -> Option<()> {
        let walk = &mut self.trail.walk;
        walk.throughput = next.throughput;
        let link = (history, self.bdpt.connections);
        walk.scatter_at_flat(at, next, at.reverse(next.d), link);
        walk.russian_roulette(weight, self.context.stream)
    }

    /// Returns `true` if nothing can come after the vertex: the next could only be on a light, and there is none to be met.
    /// Where light leaves a material again is a vertex after the same scattering event.
    fn is_spent(&self) -> bool {
        let world = self.context.world;
        self.trail.walk.depth + 1 >= self.bdpt.max_depth
            && !world.has_visible_lights()
            && !world.has_interiors()
    }

    /// The densities at a vertex. The first is where the light pass would join a light path to the lens.
    fn history(&mut self, p: Vec3, cosine: f32) -> History {
        if let Spread::Camera = self.trail.walk.spread {
            let by_connection = self.context.end.connection_density(p);
            self.trail.walk.onward.before = square(by_connection.into());
        }
        self.trail.walk.arrive(p, cosine)
    }

    /// Looks at what is behind the point where the path scatters in a medium, for layers.
    fn look_beyond(&mut self, hit: Option<&GeometryHit>) {
        let (world, ray, differentials) =
            (self.context.world, self.trail.walk.ray, self.differentials);
        if let Some((sight, numbers)) = self.context.sight() {
            sight.follow(world, (&ray, hit), differentials, numbers);
        }
    }

    /// Looks at a surface, and what may be seen by it, for layers: the path may end there. By glass as it is, of which the path chooses the ways
    /// otherwise ([`Bsdf::even_out`]).
    fn look_at(
        &mut self,
        hit: &GeometryHit,
        bsdf: &Bsdf,
        differentials: Option<&RayDifferentials>,
    ) {
        let (world, ray) = (self.context.world, self.trail.walk.ray);
        let material = world.material(hit.material);
        let scattering = (bsdf, material.is_some_and(Material::has_interior));
        if let Some((sight, numbers)) = self.context.sight() {
            match bsdf.has_specular() {
                true => sight.follow(world, (&ray, Some(hit)), differentials, numbers),
                false => sight.meet_alone(world, (&ray, hit), scattering, numbers),
            }
        }
    }

    /// Reports the vertex just reached, for the search for samples that are not finite.
    fn arrive(&mut self, met: witness::Met) {
        let collected = self.trail.radiance + self.trail.joined;
        self.context.arrive(self.trail.walk.depth, met, collected);
    }

    /// s = 0: the surface emits.
    fn add_emission(&mut self, hit: &GeometryHit, history: &History) {
        let Some(id) = hit.light else { return };
        let world = self.context.world;
        let light = world.light(id);
        let radiance = light.emitted(&hit.surface);
        if is_black(radiance) {
            return;
        }
        let pdf = light.pdf(
            &self.trail.walk.from,
            self.trail.walk.ray.d,
            Some(&hit.surface),
        );
        let end = LightEnd {
            p: hit.surface.p,
            n: hit.surface.n,
        };
        let weight = self.weight_of_hit(id, end, pdf, history);
        let depth = self.trail.walk.depth;
        self.gain_from(
            (id, depth, 0),
            self.trail.walk.throughput * radiance,
            weight,
        );
    }

    /// Adds what a light has brought, by a path of so many scattering events and s vertices from the light.
    fn gain_from(&mut self, (id, depth, s): (LightId, u32, u32), light: Rgb, weight: f32) {
        let weighted = light * weight;
        self.show(Some(id), (depth, s), light, weighted);
        self.trail.radiance += weighted;
    }

    /// Tells the layers of light, or those of strategies, if there are any.
    #[inline(always)]
    pub(super) fn show(
        &mut self,
        id: Option<LightId>,
        (depth, s): (u32, u32),
        light: Rgb,
        weighted: Rgb,
    ) {
        match self.bdpt.shown {
            None => self.context.part(id, weighted),
            Some(shown) => {
                let value = shown.of(light, weighted);
                self.context.part_of_layer(layer(depth, s), value);
            }
        }
    }

    /// s = 0: the ray leaves the scene; the infinite lights.
    fn add_escaped(&mut self) {
        let world = self.context.world;
        let history = match self.trail.walk.spread {
            Spread::FromPoint { pdf, cosine } => History {
                density: pdf.into(),
                backward: cosine.into(),
                before: self.trail.walk.onward.before,
                rest: self.trail.walk.onward.rest,
            },
            Spread::Beam { .. } | Spread::Camera => History {
                density: 1.0,
                backward: 0.0,
                before: 0.0,
                rest: 0.0,
            },
        };
        for &id in &world.infinite_lights {
            let (radiance, pdf) = world
                .light(id)
                .escaped_and_pdf(&self.trail.walk.from, self.trail.walk.ray.d);
            if !is_black(radiance) {
                let end = LightEnd {
                    p: Vec3::ZERO,
                    n: Vec3::ZERO,
                };
                let weight = self.weight_of_hit(id, end, pdf, &history);
                let depth = self.trail.walk.depth;
                self.gain_from(
                    (id, depth, 0),
                    self.trail.walk.throughput * radiance,
                    weight,
                );
            }
        }
    }

    /// The weight of s = 0 where the path meets light `id`, which emitter sampling at the last vertex would have found with the
    /// density `pdf` per solid angle.
    fn weight_of_hit(&self, id: LightId, end: LightEnd, pdf: f32, history: &History) -> f32 {
        let (world, lights) = (self.context.world, self.context.lights);
        if let Spread::Camera = self.trail.walk.spread {
            return 1.0;
        }
        let pmf = lights.selector.pmf(&self.trail.walk.from, id);
        if pmf == 0.0 {
            // A light that is never chosen (an instanced emitter) glows but lights nothing, as in pbrt-v3.
            return f32::from(u8::from(self.trail.walk.after_delta));
        }
        let cosine = match self.trail.walk.spread {
            Spread::FromPoint { cosine, .. } => cosine,
            Spread::Beam { .. } | Spread::Camera => 1.0,
        };
        let lit = Lit {
            id,
            end,
            from: &self.trail.walk.from,
            cosine,
            wi: self.trail.walk.ray.d,
            pdf,
        };
        let light = lit.densities(world, lights, pmf);
        let direct = if self.trail.walk.after_delta {
            0.0
        } else {
            light.direct
        };
        weight(0.0, history.at_light(direct, light.emitted, light.onward))
    }

    /// Continues from a surface.
    fn scatter(
        &mut self,
        (hit, bsdf, below): (&GeometryHit, &Bsdf<'a>, bool),
        history: &History,
        differentials: Option<&RayDifferentials>,
    ) -> Option<()> {
        let world = self.context.world;
        let turn = Turn::sample(hit, bsdf, Carries::Radiance, self.context.stream)?;
        let sample = &turn.sample;
        self.trail.walk.throughput *= turn.factor;
        // No light path continues from below to here.
        let reverse = match below && sample.transmission {
            true => 0.0,
            false => turn.reverse,
        };
        let follow = |walk: &mut Walk| {
            let link = (history, self.bdpt.connections);
            walk.scatter_at_surface(world, (hit, bsdf), sample, reverse, link);
        };
        if !sample.transmission {
            follow(&mut self.trail.walk);
            return self
                .trail
                .walk
                .russian_roulette(turn.judged, self.context.stream);
        }
        let stream = &mut *self.context.stream;
        let transport = world.subsurface_transport(
            hit.material,
            &hit.surface,
            (bsdf, sample),
            differentials,
            || stream.next_1d(),
        );
        self.trail.walk.throughput *= transport.share;
        let Some(bssrdf) = transport.bssrdf else {
            follow(&mut self.trail.walk);
            return self
                .trail
                .walk
                .russian_roulette(turn.judged * transport.share, self.context.stream);
        };
        if !sample.specular {
            let mut straight = self.trail.walk;
            follow(&mut straight);
            self.look_along(straight);
        }
        let exit = find_exit(world, self.context.stream, &bssrdf, hit)?;
        self.trail.walk.throughput *= exit.weight;
        let (hit, bsdf) = (&exit.hit, &exit.bsdf);
        let vertex = Vertex::Surface {
            hit,
            bsdf,
            medium: self.trail.walk.medium,
            below: false,
        };
        self.join(vertex, &History::ALONE);
        let next = Turn::sample(hit, bsdf, Carries::Radiance, self.context.stream)?;
        self.trail.walk.throughput *= next.factor;
        let link = (&History::ALONE, self.bdpt.connections);
        self.trail
            .walk
            .scatter_at_surface(world, (hit, bsdf), &next.sample, next.reverse, link);
        let judged = turn.judged * transport.share * exit.weight * next.judged;
        self.trail
            .walk
            .russian_roulette(judged, self.context.stream)
    }

    /// Emission along a direction in which the path does not continue: the counterpart of emitter sampling at a rough boundary
    /// below which light is scattered, as in pbrt-v3.
    fn look_along(&mut self, along: Walk) {
        let world = self.context.world;
        let walk = std::mem::replace(&mut self.trail.walk, along);
        loop {
            let hit = world.intersect(&self.trail.walk.ray);
            let t = hit.as_ref().map(|hit| hit.t);
            let walk = &mut self.trail.walk;
            let met = walk.advance(world, t, self.context.stream);
            let (Some(Met::Surface), Some(hit)) = (&met, &hit) else {
                if let Some(Met::Background) = met {
                    self.add_escaped();
                }
                break;
            };
            let cosine = hit.surface.n.dot(hit.surface.wo).abs();
            let history = self.trail.walk.arrive(hit.surface.p, cosine);
            self.add_emission(hit, &history);
            if hit.material.is_some() || self.trail.walk.pass(world, hit).is_none() {
                break;
            }
        }
        self.trail.walk = walk;
    }
}
