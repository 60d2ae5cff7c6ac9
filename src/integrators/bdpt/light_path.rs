//! Paths from the lights, vertex by vertex.

use super::Bdpt;
use super::light_end::{Lit, end_as_hit};
use super::vertex::{FlatVertex, Scattered, Vertex};
use super::walk::{Branches, Carries, Met, Spread, Turn, Walk, boundary_receiver, surface_bsdf};
use super::weights::{History, Onward, square};
use crate::accel::GeometryHit;
use crate::bsdf::{Boundary, Bsdf, BsdfSample, Lobe};
use crate::bssrdf::Bssrdf;
use crate::handles::LightId;
use crate::integrators::context::Lights;
use crate::integrators::emitters::Chosen;
use crate::integrators::subsurface::find_exit;
use crate::integrators::vertices::Next;
use crate::integrators::{BOTH_WAYS, Beginning};
use crate::lights::{Emission, LightEnd};
use crate::math::{Rgb, Vec3, color::is_black};
use crate::samplers::SampleStream;
use crate::surface::ReferencePoint;
use crate::world::World;

/// A vertex that other subpaths can be joined to.
#[derive(Clone, Copy)]
pub(super) struct LightVertex<'v, 'a> {
    pub vertex: Vertex<'v, 'a>,
    pub throughput: Rgb,
    pub history: History,
    /// Scattering events before it.
    pub depth: u32,
}

impl LightVertex<'_, '_> {
    /// [`Vertex::importance`]; through a surface below which light is scattered that of the light itself alone, and no path
    /// continues there.
    pub(super) fn importance(&self, wi: Vec3) -> Option<Scattered> {
        let through = self.vertex.ends_toward(wi);
        if through && self.depth > 0 {
            return None;
        }
        let scattered = self.vertex.importance(wi)?;
        let forward = if through { 0.0 } else { scattered.forward };
        Some(Scattered {
            forward,
            ..scattered
        })
    }
}

/// Where a light path begins.
#[derive(Default)]
pub(super) struct Begun {
    pub light: LightId,
    /// The light's probability.
    pmf: f32,
    emission: Emission,
}

/// What light paths are traced through.
#[derive(Clone, Copy)]
pub(super) struct LightTracer<'c, 'a> {
    pub bdpt: &'c Bdpt,
    pub world: &'a World,
    pub lights: &'c Lights,
    /// The most scattering events of a path, that at its last vertex included.
    pub max_depth: u32,
}

impl<'a> LightTracer<'_, 'a> {
    /// Traces a path at `time` and hands over the light that it begins at with each vertex that can be joined to others.
    pub(super) fn trace(
        &self,
        time: f32,
        stream: &mut SampleStream,
        mut visit: impl FnMut(LightId, LightVertex<'_, 'a>, &mut SampleStream),
    ) {
        let (mut begun, mut walk) = (Begun::default(), Walk::default());
        let began = self
            .choose_one(stream)
            .and_then(|chosen| self.begin(time, &chosen, (&mut begun, &mut walk)));
        if began.is_none() || self.max_depth == 0 {
            return;
        }
        let mut visit = |vertex: LightVertex<'_, 'a>, stream: &mut SampleStream| {
            visit(begun.light, vertex, stream);
        };
        let mut branches = Branches::new();
        loop {
            let hit = self.world.intersect(&walk.ray);
            let met = walk.advance(self.world, hit.as_ref().map(|hit| hit.t), stream);
            let extended = met.and_then(|met| {
                let at = (&mut walk, (met, hit.as_ref()));
                self.extend(&begun, at, stream, &mut branches, &mut visit)
            });
            if extended.is_none() || walk.depth >= self.max_depth {
                match branches.pop() {
                    Some(branch) => branch.take(&mut walk, stream),
                    None => return,
                }
            }
        }
    }

    /// Where a path begins.
    pub(super) fn beginning(&self, stream: &mut SampleStream) -> Option<Beginning> {
        let emitters = self.lights.emitters.as_ref()?;
        let chosen = self.choose_one(stream)?;
        let emission = emitters.emit(self.world, &chosen)?;
        Some(emitters.beginning(self.world, chosen.id, chosen.pmf, &emission))
    }

    /// Chooses a light, and draws the numbers of a ray: see [`LightTracer::guide`].
    pub(super) fn choose(&self, stream: &mut SampleStream) -> Option<Chosen> {
        self.lights.emitters.as_ref()?.choose(stream)
    }

    /// Finds where guides lead, before paths begin.
    pub(super) fn guide<'c>(&self, chosen: impl IntoIterator<Item = &'c mut Chosen>) {
        if let Some(emitters) = &self.lights.emitters {
            emitters.guide(self.world, chosen);
        }
    }

    fn choose_one(&self, stream: &mut SampleStream) -> Option<Chosen> {
        let mut chosen = self.choose(stream)?;
        self.guide([&mut chosen]);
        Some(chosen)
    }

    /// Begins with the light and the ray that were chosen.
    #[inline(always)]
    pub(super) fn begin(
        &self,
        time: f32,
        chosen: &Chosen,
        (begun, walk): (&mut Begun, &mut Walk),
    ) -> Option<()> {
        let emission = self.lights.emitters.as_ref()?.emit(self.world, chosen)?;
        let (id, pmf) = (chosen.id, chosen.pmf);
        let light = self.world.light(id);
        let from = ReferencePoint {
            p: emission.p,
            p_error: emission.p_error,
            n: emission.n,
            time,
            ..Default::default()
        };
        let density = emission.density;
        let spread = match light.is_at_infinity() {
            true => Spread::Beam {
                pdf: density.position,
            },
            false => Spread::FromPoint {
                pdf: density.direction,
                cosine: emission.cosine(),
            },
        };
        let media = &self.world.media;
        let medium = match light.is_at_infinity() {
            true => media.at_infinity(),
            false => media.at_light(id, emission.n, emission.d),
        };
        let flux = emission.flux() / pmf;
        walk.begin(&emission.ray(time), medium, (&from, spread), flux);
        begun.light = id;
        begun.pmf = pmf;
        begun.emission = emission;
        (!is_black(flux)).then_some(())
    }

    /// Extends a path by a vertex where it has come to, perhaps the surface that its ray hits; `None` where it ends.
    pub(super) fn extend(
        &self,
        begun: &Begun,
        (walk, (met, hit)): (&mut Walk, (Met, Option<&GeometryHit>)),
        stream: &mut SampleStream,
        branches: &mut Branches,
        visit: &mut impl FnMut(LightVertex<'_, 'a>, &mut SampleStream),
    ) -> Option<()> {
        let world = self.world;
        if let (Met::Surface, Some(hit)) = (&met, hit)
            && let Some(boundary) = world.even_boundary(hit.material)
        {
            return self.cross(begun, walk, (hit, boundary), stream, branches);
        }
        let mut bsdf = Bsdf::empty();
        let vertex = match (&met, hit) {
            (Met::Medium(at), _) => Vertex::Medium(at),
            (Met::Background, _) | (Met::Surface, None) => return None,
            (Met::Surface, Some(hit)) => {
                if surface_bsdf(world, hit, None, Carries::Importance, &mut bsdf).is_none() {
                    return walk.pass(world, hit);
                }
                Vertex::Surface {
                    hit,
                    bsdf: &bsdf,
                    medium: walk.medium,
                    below: world.scatters_below(hit, &bsdf, None),
                }
            }
        };
        let from = vertex.reference_point();
        if walk.depth == 0 {
            let cosine = vertex.cosine(-walk.ray.d);
            walk.onward = self.first_onward(begun, cosine, &from, walk);
        }
        let history = walk.arrive(from.p, vertex.cosine(walk.ray.d));
        let found = LightVertex {
            vertex,
            throughput: walk.throughput,
            history,
            depth: walk.depth,
        };
        let scattered = self.scatter(walk, vertex, &history, stream, visit);
        if vertex.connects() {
            visit(found, stream);
        }
        scattered
    }

    /// Extends a path by a vertex on a smooth boundary.
    fn cross(
        &self,
        begun: &Begun,
        walk: &mut Walk,
        (hit, boundary): (&GeometryHit, &Boundary),
        stream: &mut SampleStream,
        branches: &mut Branches,
    ) -> Option<()> {
        let surface = &hit.surface;
        let cosine = surface.n.dot(walk.ray.d).abs();
        if walk.depth == 0 {
            let from = boundary_receiver(surface);
            walk.onward = self.first_onward(begun, cosine, &from, walk);
        }
        let history = walk.arrive(surface.p, cosine);
        if self.is_last(walk) || !walk.throughput.is_finite() {
            return None;
        }
        let how = (Carries::Importance, self.bdpt.connections);
        let at = (hit, boundary);
        if walk.depth >= BOTH_WAYS {
            return walk.cross(self.world, at, how, &history, stream);
        }
        let (first, other) = walk.cross_both_ways(self.world, at, how, &history, stream);
        branches.extend(other);
        first.or_else(|| {
            branches.pop()?.take(walk, stream);
            Some(())
        })
    }

    /// Extends a path by a vertex on a flat triangle. Returns what the path is to know if it continues.
    pub(super) fn meet_flat(&self, begun: &Begun, walk: &mut Walk, at: &FlatVertex) -> History {
        if walk.depth == 0 {
            walk.onward = self.first_onward(begun, at.cosine, &at.from, walk);
        }
        walk.arrive(at.from.p, at.cosine)
    }

    /// Returns `true` if no path has another vertex after this one. Where light leaves a material again is a vertex after the same
    /// scattering event.
    pub(super) fn is_last(&self, walk: &Walk) -> bool {
        walk.depth + 1 >= self.max_depth && !self.world.has_interiors()
    }

    /// Continues from a flat triangle in a direction that was chosen.
    pub(super) fn leave_flat(
        &self,
        walk: &mut Walk,
        at: &FlatVertex,
        next: &Next,
        history: &History,
        stream: &mut SampleStream,
    ) -> Option<()> {
        let (factor, reverse) = at.importance_factor(next.d, next.pdf);
        if is_black(factor) {
            return None;
        }
        walk.throughput *= factor;
        walk.scatter_at_flat(at, next, reverse, (history, self.bdpt.connections));
        walk.russian_roulette(factor, stream)
    }

    /// What is known of the strategies that have no vertex from the light (s = 0: the light is met by chance) or only
    /// that on the light (s = 1: emitter sampling) once the first surface is known, and the cosine there.
    fn first_onward(
        &self,
        begun: &Begun,
        cosine: f32,
        from: &ReferencePoint,
        walk: &Walk,
    ) -> Onward {
        let (id, emission) = (begun.light, &begun.emission);
        let (light, wi) = (self.world.light(id), -walk.ray.d);
        let end = LightEnd {
            p: emission.p,
            n: emission.n,
        };
        let pmf = self.lights.selector.pmf(from, id);
        let pdf = match light.is_delta() {
            true => 1.0,
            false => light.pdf(from, wi, Some(&end_as_hit(&end, -wi, walk.ray.time))),
        };
        let lit = Lit {
            id,
            end,
            from,
            cosine,
            wi,
            pdf,
        };
        let densities = lit.densities_of(light, pmf, begun.pmf, emission.density);
        let hittable = f64::from(u8::from(!light.is_delta()));
        Onward {
            before: square(densities.direct / densities.emitted),
            rest: hittable / square(densities.emitted),
        }
    }

    /// Goes on from a vertex, if the path may have another.
    fn scatter(
        &self,
        walk: &mut Walk,
        vertex: Vertex,
        history: &History,
        stream: &mut SampleStream,
        visit: &mut impl FnMut(LightVertex<'_, 'a>, &mut SampleStream),
    ) -> Option<()> {
        let connections = self.bdpt.connections;
        // What is not finite comes to one vertex, and is counted where that is joined to others.
        if self.is_last(walk) || !walk.throughput.is_finite() {
            return None;
        }
        let (hit, bsdf) = match vertex {
            Vertex::Surface { hit, bsdf, .. } => (hit, bsdf),
            // From there they continue side by side.
            Vertex::Flat(_) => return None,
            Vertex::Medium(at) => {
                walk.scatter_in_medium(at, history, connections, stream);
                return walk.russian_roulette(Rgb::ONE, stream);
            }
        };
        let turn = Turn::sample(hit, bsdf, Carries::Importance, stream)?;
        if turn.sample.transmission {
            let scattered = (bsdf, &turn.sample);
            let choice = || stream.next_1d();
            let surface = &hit.surface;
            let transport =
                self.world
                    .subsurface_transport(hit.material, surface, scattered, None, choice);
            walk.throughput *= transport.share;
            if let Some(bssrdf) = &transport.bssrdf {
                // What camera paths find is left to them: their subsurface scattering has no densities.
                if !history.is_alone() || !turn.sample.specular {
                    return None;
                }
                walk.throughput *= entering(hit, bsdf, &turn.sample);
                return self.scatter_below(walk, bssrdf, hit, stream, visit);
            }
        }
        walk.throughput *= turn.factor;
        let link = (history, connections);
        walk.scatter_at_surface(self.world, (hit, bsdf), &turn.sample, turn.reverse, link);
        walk.russian_roulette(turn.judged, stream)
    }

    /// Subsurface scattering of light that came straight from a light without area by smooth glass or mirrors alone, which no camera
    /// path finds below the surface.
    fn scatter_below(
        &self,
        walk: &mut Walk,
        bssrdf: &Bssrdf,
        entry: &GeometryHit,
        stream: &mut SampleStream,
        visit: &mut impl FnMut(LightVertex<'_, 'a>, &mut SampleStream),
    ) -> Option<()> {
        let exit = find_exit(self.world, stream, bssrdf, entry)?;
        let mut hit = exit.hit;
        let surface = &mut hit.surface;
        // As if light came along the geometric normal: what `importance_cosine` takes from shading normals then is this cosine.
        let cosine = surface.n.dot(surface.shading.n);
        surface.wo = surface.n * 1.0f32.copysign(cosine);
        walk.throughput *= exit.weight / cosine.abs();
        let mut bsdf = Bsdf::new(surface.n, &surface.shading);
        bsdf.add(Lobe::SubsurfaceExit(bssrdf.exit().emerging()));
        let turn = Turn::sample(&hit, &bsdf, Carries::Importance, stream);
        let mut next = *walk;
        let scattered = turn.and_then(|turn| {
            next.throughput *= turn.factor;
            let link = (&History::ALONE, self.bdpt.connections);
            next.scatter_at_surface(self.world, (&hit, &bsdf), &turn.sample, turn.reverse, link);
            next.russian_roulette(turn.judged * exit.weight, stream)
        });
        let found = LightVertex {
            vertex: Vertex::Surface {
                hit: &hit,
                bsdf: &bsdf,
                medium: walk.medium,
                below: false,
            },
            throughput: walk.throughput,
            history: History::ALONE,
            depth: walk.depth,
        };
        visit(found, stream);
        *walk = next;
        scattered
    }
}

/// The factor of the flux that enters a surface by a specular `sample` from its `wo`.
fn entering(hit: &GeometryHit, bsdf: &Bsdf, sample: &BsdfSample) -> Rgb {
    let (n, shading_n, wo) = (hit.surface.n, bsdf.shading_normal(), hit.surface.wo);
    // Refraction scales radiance, not importance.
    let eta2 = sample.eta * sample.eta;
    let transmitted = sample.f * (eta2 * shading_n.dot(sample.wi).abs() / sample.pdf);
    transmitted * (shading_n.dot(wo) / n.dot(wo)).abs()
}
