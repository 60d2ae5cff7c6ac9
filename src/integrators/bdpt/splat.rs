//! The light pass (t = 1): vertices of light paths are joined to the lens, and what they bring goes to the pixels around the film
//! point where it lands. Connections are collected, so that a lens traces many of them side by side.

use super::flats::Flats;
use super::light_path::{LightTracer, LightVertex};
use super::light_wave::{PathStart, Visitor, trace_all};
use super::strategies::layer;
use super::weights::{History, square, weight};
use crate::cameras::{Aim, BUNDLE, Camera, Landing, LensSample};
use crate::handles::{LightId, MediumId};
use crate::integrators::landing::{for_pixels, reaches_film};
use crate::integrators::shadows::unblocked;
use crate::integrators::volpath::{dimmed_along, shadow_segment};
use crate::integrators::{LightJob, Splat};
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec2, color::is_black};
use crate::samplers::SampleStream;
use crate::world::World;
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
pub(super) struct Waiting<'c, 'a, S> {
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
    let mut waiting = Waiting::new(tracer, job, splat);
    let paths = paths.map(|(path, stream)| start((job.world, job.camera), (path, 0), stream));
    trace_all(tracer, paths, flats, &mut waiting);
    waiting.land();
}

impl<'a, S: FnMut(Splat)> Visitor<'a> for Waiting<'_, 'a, S> {
    fn visit(
        &mut self,
        start: &PathStart,
        light: LightId,
        vertex: LightVertex<'_, 'a>,
        stream: &mut SampleStream,
    ) {
        let lens = match self.job.camera.has_lens() {
            true => stream.next_2d(),
            false => Vec2::splat(0.5),
        };
        let wavelength = start.wavelength;
        let at = LensSample { lens, wavelength };
        // No connection where none can be made.
        let _ = self.join((start.path, light), &vertex, &at, stream);
        if self.pending.is_full() {
            self.land();
        }
    }
}

/// How a path of the light pass starts. Its first numbers are the camera's: time, if that matters, and wavelength.
pub(super) fn start(
    (world, camera): (&World, &Camera),
    (path, place): (u64, u32),
    mut stream: SampleStream,
) -> (PathStart, SampleStream) {
    let moves = world.moves() || camera.moves();
    let start = PathStart {
        path,
        place,
        time: camera.shutter().time(stream.next_1d_if(moves)),
        wavelength: stream.next_1d_if(camera.disperses()),
    };
    (start, stream)
}

/// Where the connection of a vertex takes numbers: they are left out where it is not made.
pub(super) fn skip_lens(camera: &Camera, stream: &mut SampleStream) {
    if camera.has_lens() {
        stream.skip_2d();
    }
}

impl<'c, 'a, S: FnMut(Splat)> Waiting<'c, 'a, S> {
    pub(super) fn new(
        tracer: &'c LightTracer<'c, 'a>,
        job: &'c LightJob<'c>,
        splat: &'c mut S,
    ) -> Self {
        Waiting {
            tracer,
            job,
            splat,
            pending: ArrayVec::new(),
            aims: ArrayVec::new(),
        }
    }

    /// Joins a vertex to the lens.
    fn join(
        &mut self,
        (path, begins_at): (u64, LightId),
        end: &LightVertex,
        at: &LensSample,
        stream: &SampleStream,
    ) -> Option<()> {
        let aim = self.job.camera.aim(&end.vertex.reference_point(), at)?;
        let scattered = end.importance(aim.wi)?;
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
    pub(super) fn land(&mut self) {
        let (world, job) = (self.tracer.world, self.job);
        let mut landings = ArrayVec::new();
        job.camera.land_all(&self.aims, &mut landings);
        // Where they are, as they are large: those that may bring light, and what that is if nothing dims it.
        let mut landed = ArrayVec::<(usize, Landing, Rgb), BUNDLE>::new();
        let mut shadows = ArrayVec::<Ray, BUNDLE>::new();
        for (i, landing) in landings.into_iter().enumerate() {
            let Some(landing) = landing else { continue };
            let light = self.pending[i].light * landing.importance;
            if !is_black(light) && reaches_film(job, landing.raster) {
                landed.push((i, landing, light));
                shadows.push(shadow_segment(
                    world,
                    &self.aims[i].shadow,
                    self.pending[i].medium,
                ));
            }
        }
        unblocked::<BUNDLE>(world, &shadows, &mut [None; BUNDLE], |i, passage| {
            let (of, landing, light) = &landed[i];
            let pending = &mut self.pending[*of];
            let (stream, medium) = (&mut pending.stream, pending.medium);
            let left = dimmed_along(world, stream, medium, &shadows[i], passage);
            if !is_black(left) {
                let arriving = (*light, left);
                bring(self.tracer, job, (pending, landing), arriving, self.splat);
            }
        });
        self.pending.clear();
        self.aims.clear();
    }
}

/// Hands the light of a connection, of which so much is `left`, to the pixels around the point where it lands.
fn bring(
    tracer: &LightTracer,
    job: &LightJob,
    (pending, landing): (&Pending, &Landing),
    (light, left): (Rgb, Rgb),
    splat: &mut impl FnMut(Splat),
) {
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
