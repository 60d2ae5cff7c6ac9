//! The light pass (t = 1): vertices of light paths are joined to the lens, and what they bring goes to the pixels around the film
//! point where it lands. Connections are collected, so that a lens traces many of them side by side.

use super::flats::Flats;
use super::light_path::{LightTracer, LightVertex};
use super::light_wave::{Known, Visitor, trace_all};
use super::strategies::layer;
use super::weights::{History, square, weight};
use crate::cameras::{Aim, BUNDLE, Landing, LensSample};
use crate::handles::{LightId, MediumId};
use crate::integrators::landing::{for_pixels, reaches_film};
use crate::integrators::volpath::{dimmed, ended, transmittance};
use crate::integrators::{LightJob, Splat};
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2, color::is_black};
use crate::samplers::SampleStream;
use arrayvec::ArrayVec;

/// A connection before it is known where on the film it lands.
struct Pending {
    /// The number of its path.
    path: u64,
    /// The light that it begins at.
    begins_at: LightId,
    /// What the path brings in the direction of the lens.
    light: Rgb,
    /// Density per solid angle of the direction from which the path came, for paths from the camera.
    reverse: f32,
    /// The cosine at the vertex.
    cosine: f32,
    history: History,
    /// Scattering events of the path.
    depth: u32,
    /// The medium between vertex and lens.
    medium: Option<MediumId>,
    /// Numbers for the transmittance of media; the path's own go on from here as well, for other contributions.
    stream: SampleStream,
}

/// Connections that wait for each other.
struct Waiting<'c, 'a, S> {
    tracer: &'c LightTracer<'c, 'a>,
    job: &'c LightJob<'c>,
    splat: &'c mut S,
    pending: ArrayVec<Pending, BUNDLE>,
    aims: ArrayVec<Aim, BUNDLE>,
}

/// Traces light paths onto the film.
pub(super) fn splat_paths(
    tracer: &LightTracer,
    job: &LightJob,
    paths: impl Iterator<Item = (u64, SampleStream)>,
    flats: &mut Flats,
    splat: &mut impl FnMut(Splat),
) {
    let mut waiting = Waiting {
        tracer,
        job,
        splat,
        pending: ArrayVec::new(),
        aims: ArrayVec::new(),
    };
    let paths = paths.map(|(path, mut stream)| {
        let (time, wavelength) = skip_camera(job, &mut stream);
        let known = Known {
            path,
            time,
            wavelength,
        };
        (known, stream)
    });
    trace_all(tracer, paths, flats, &mut waiting);
    waiting.land();
}

impl<'a, S: FnMut(Splat)> Visitor<'a> for Waiting<'_, 'a, S> {
    fn visit(
        &mut self,
        known: &Known,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    ) {
        let lens = match self.job.camera.has_lens() {
            true => stream.next_2d(),
            false => Vec2::splat(0.5),
        };
        let wavelength = known.wavelength;
        let at = LensSample { lens, wavelength };
        // No connection where none can be made.
        let _ = self.join((known.path, light), &vertex, &at, stream);
        if self.pending.is_full() {
            self.land();
        }
    }
}

/// The first numbers of a path are the camera's: time, if that matters, and wavelength.
pub(super) fn skip_camera(job: &LightJob, stream: &mut SampleStream) -> (f32, f32) {
    let moves = job.world.moves() || job.camera.moves();
    let time = job.camera.shutter().time(stream.next_1d_if(moves));
    (time, stream.next_1d_if(job.camera.disperses()))
}

impl<S: FnMut(Splat)> Waiting<'_, '_, S> {
    /// Joins a vertex to the lens.
    fn join(
        &mut self,
        (path, begins_at): (u64, LightId),
        end: &LightVertex,
        at: &LensSample,
        stream: &SampleStream,
    ) -> Option<()> {
        let aim = self.job.camera.aim(&end.vertex.reference_point(), at)?;
        let scattered = end.vertex.importance(aim.wi)?;
        self.pending.push(Pending {
            path,
            begins_at,
            light: end.throughput * scattered.value,
            reverse: scattered.reverse,
            cosine: end.vertex.cosine(aim.wi),
            history: end.history,
            depth: end.depth + 1,
            medium: end.vertex.medium_toward(self.tracer.world, aim.wi),
            stream: *stream,
        });
        self.aims.push(aim);
        Some(())
    }

    /// Finds out where the connections land, and what they bring there.
    fn land(&mut self) {
        let (world, job) = (self.tracer.world, self.job);
        let splat = &mut *self.splat;
        let mut landings = ArrayVec::new();
        job.camera.land_all(&self.aims, &mut landings);
        let all = self.pending.drain(..).zip(self.aims.drain(..));
        let landed = |((pending, aim), landing)| Landed::of(job, pending, &aim, landing?);
        let mut landed: ArrayVec<Landed, BUNDLE> = all
            .zip(landings)
            .filter_map(|(known, landing)| landed((known, landing)))
            .collect();
        if world.has_recoverable_surfaces() {
            for landed in &mut landed {
                let Pending { stream, medium, .. } = &mut landed.pending;
                let left = transmittance(world, stream, &landed.shadow, *medium);
                bring(self.tracer, job, landed, left, splat);
            }
            return;
        }
        let shadows: ArrayVec<Ray, BUNDLE> = landed
            .iter()
            .map(|landed| ended(world, &landed.shadow, landed.pending.medium))
            .collect();
        let mut found = [None; BUNDLE];
        world.occluders(&shadows, &mut found[..shadows.len()]);
        for ((landed, shadow), found) in landed.iter_mut().zip(&shadows).zip(&found) {
            if found.is_none() {
                let Pending { stream, medium, .. } = &mut landed.pending;
                let left = dimmed(world, stream, *medium, shadow, shadow.t_max);
                bring(self.tracer, job, landed, left, splat);
            }
        }
    }
}

/// A connection that may bring light to the film, if nothing is in its way.
struct Landed {
    pending: Pending,
    shadow: Ray,
    landing: Landing,
    /// What the path brings if nothing dims it.
    light: Rgb,
}

impl Landed {
    fn of(job: &LightJob, pending: Pending, aim: &Aim, landing: Landing) -> Option<Landed> {
        let light = pending.light * landing.importance;
        let is_seen = !is_black(light) && reaches_film(job, landing.raster);
        is_seen.then_some(Landed {
            pending,
            shadow: aim.shadow,
            landing,
            light,
        })
    }
}

/// Hands the light of a connection, of which so much is `left`, to the pixels around the point where it lands.
fn bring(
    tracer: &LightTracer,
    job: &LightJob,
    landed: &Landed,
    left: Rgb,
    splat: &mut impl FnMut(Splat),
) {
    if is_black(left) {
        return;
    }
    let Landed {
        pending,
        landing,
        light,
        ..
    } = landed;
    let light = *light;
    // The camera's own samples come here with this density, in a pixel where those of the film have density 1.
    let camera = f64::from(landing.density) * f64::from(pending.cosine);
    let camera = camera / f64::from(job.light_paths);
    let earlier = pending.history.earlier(camera, pending.reverse.into());
    let mut bring_to = |raster: Vec2| {
        for_pixels(job, raster, |pixel, value, density| {
            let others = earlier * square(density.into());
            let weight = weight(others, 0.0);
            let strategy = layer(pending.depth, pending.depth + 1);
            let weighted = light * left * (value * weight);
            let shown = tracer.bdpt.shown.map(|shown| {
                let alone = light * left * value;
                (strategy, shown.of(alone, weighted))
            });
            splat(Splat {
                path: pending.path,
                light: pending.begins_at,
                pixel,
                value: weighted,
                shown,
                by_camera: others.sqrt(),
            });
        });
    };
    bring_to(landing.raster);
    let reach = job.filter.radius().max_element();
    for copy in job.camera.raster_copies(landing.raster, reach) {
        bring_to(copy);
    }
}
