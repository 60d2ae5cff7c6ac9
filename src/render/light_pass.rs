//! The light pass: paths traced from the lights, whose vertices are joined to the lens and bring light to pixels anywhere
//! on the film.
//!
//! A pixel's light is the mean over its own camera samples plus the mean over all light paths of what they bring to it.
//! Paths are shared by all pixels; how many there are for each camera sample is what a pilot pass has found to pay. The two parts are independent: each of
//! them may have any number without a bias.
//!
//! Where the lens makes ghosts, each path has a sample of these besides ([`GhostLight`](crate::integrators::GhostLight)), whether the integrator
//! traces any light itself or not.

use super::{Progress, RenderJob};
use crate::film::{LightPathUse, LightShare, PixelBounds, SplatBuffer, Splats};
use crate::integrators::{LightJob, Splat, Workspace};
use crate::math::color::luminance;
use crate::samplers::Sampler;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Paths that one worker takes at a time. Chunks begin at multiples of it.
const CHUNK: u64 = 1 << 12;

/// Paths after which a worker looks whether its buffer is full, it is to stop, or the checkpoint is due.
const RUN: u64 = 1 << 8;

impl RenderJob {
    /// Returns `true` if paths are traced from the lights, too: not through a camera that nothing is joined to, nor if the
    /// film is looked at in pixel centers alone, which no such path meets; nor where a pilot pass has left all light to camera paths.
    pub fn traces_light(&self) -> bool {
        self.integrator.traces_light()
            && self.camera.connects()
            && self.filter.is_continuous()
            && self.light_share.0 > 0.0
    }

    /// How light paths are used; `None` if the integrator has no light pass (photon mapping, ambient occlusion).
    pub fn light_path_use(&self) -> Option<LightPathUse> {
        self.integrator.has_light_pass().then(|| LightPathUse {
            per_sample: if self.traces_light() {
                self.light_share.0
            } else {
                0.0
            },
            joined: self.integrator.joined(),
        })
    }

    /// The pixels that light paths bring light to.
    pub fn lit(&self) -> PixelBounds {
        self.film.pixel_bounds().intersection(self.sampled)
    }

    /// Returns `true` if there is a light pass: of paths from the lights, or of ghosts.
    pub fn has_splats(&self) -> bool {
        self.traces_light() || self.ghosts.is_some()
    }

    /// Light paths for each sample of a pixel, all of which share them; 0 if none are traced. Weights of multiple importance
    /// sampling are made with it whatever the real numbers are.
    pub(super) fn paths_per_sample(&self) -> f32 {
        match self.traces_light() {
            true => self.lit().area() as f32 * self.light_share.0,
            false => 0.0,
        }
    }

    /// The same where only ghosts may be traced, too, of which weights know nothing.
    fn splats_per_sample(&self) -> f32 {
        match self.has_splats() {
            true => self.lit().area() as f32 * self.splat_share().0,
            false => 0.0,
        }
    }

    /// What the light pass has for each camera sample: as many light paths as pay, or one sample of ghosts if they are all.
    pub fn splat_share(&self) -> LightShare {
        match self.traces_light() {
            true => self.light_share,
            false => LightShare(1.0),
        }
    }

    /// Number of light paths of an image with `spp` samples in every pixel; each has a sample of ghosts, if there are any.
    pub fn light_paths(&self, spp: u32) -> u64 {
        match self.has_splats() {
            true => { self.splat_share() }.paths(self.lit().area() as u64 * u64::from(spp)),
            false => 0,
        }
    }

    /// What light paths are traced for.
    pub(crate) fn light_job(&self) -> LightJob<'_> {
        LightJob {
            world: &self.world,
            camera: &self.camera,
            filter: &self.filter,
            bounds: self.lit(),
            light_paths: self.paths_per_sample(),
        }
    }

    /// Sums for the splats of light paths; `None` if none are traced.
    pub fn splats(&self) -> Option<Splats> {
        let scale = self.splat_scale()?;
        Some(Splats::new(self.lit(), scale, self.film.layers.lights()))
    }

    /// The power of two of what a path is expected to bring to the pixel that it comes to: the light of P paths, one for
    /// each pixel, where lights of power Φ shine on surfaces as large as the square of the scene's radius.
    pub fn splat_scale(&self) -> Option<i32> {
        if !self.has_splats() {
            return None;
        }
        let (_, radius) = self.world.geometry.bounds().bounding_sphere();
        let lights = self.world.sampled_lights().iter();
        let powers = lights.map(|light| f64::from(luminance(light.power(radius))));
        let power: f64 = powers.sum();
        let brought = power / f64::from(radius).powi(2) * f64::from(self.splats_per_sample());
        let is_number = brought.is_normal() && brought > 0.0;
        // The exponent as it is stored: a logarithm may differ from machine to machine.
        Some(if is_number {
            (brought.to_bits() >> 52) as i32 - 1023
        } else {
            0
        })
    }
}

/// The splats of a half that the checkpoint has; `None` if no light paths are traced.
pub(super) fn restored(job: &RenderJob, half: u8, progress: &Progress) -> Option<Splats> {
    let blank = job.splats()?;
    match progress.journal() {
        Some(journal) => { journal.restore_splats(half, blank) }.or_else(|| job.splats()),
        None => Some(blank),
    }
}

/// Traces those of a half's `paths`, no two ranges of which overlap, whose splats are not there yet, some of which
/// [`PairedLight`](super::paired_light::PairedLight) has counted. Returns `false` if it was stopped, or was no longer `in_time`: then some of them are not.
pub(super) fn trace(
    job: &RenderJob,
    (half, sampler): (u8, &Sampler),
    splats: &mut Splats,
    (paths, counted): (&[Range<u64>], u64),
    in_time: impl Fn() -> bool + Sync,
    progress: &Progress,
) -> bool {
    let missing = { paths.iter() }.flat_map(|range| splats.paths().missing(range.clone()));
    let missing: Vec<Range<u64>> = missing.collect();
    let count = count_paths(&missing);
    progress.advance(count_paths(paths) - count - counted);
    // Memory for all at once: none that depends on the number of paths but this.
    let mut chunks = Vec::with_capacity((count / CHUNK) as usize + 2 * missing.len());
    chunks.extend(missing.into_iter().flat_map(|range| cut(range, CHUNK)));
    let worker = Worker {
        job,
        sampler,
        half,
        buffers: Mutex::default(),
        pixels: splats.bounds().area(),
        splats: Mutex::new(splats),
        progress,
    };
    let buffers = (0..rayon::current_num_threads()).map(|_| worker.new_buffer());
    lock(&worker.buffers).extend(buffers);
    let is_whole = { chunks.into_par_iter() }
        .map(|chunk| worker.trace_chunk(chunk, &in_time))
        .reduce(|| true, |a, b| a && b);
    if let Some(journal) = progress.journal()
        && (progress.is_stopped() || worker.is_time_to_keep())
    {
        journal.keep_splats(half, &lock(&worker.splats));
    }
    if let Some(live) = progress.live() {
        live.light(half, &lock(&worker.splats));
    }
    is_whole
}

/// How many paths are in ranges.
pub fn count_paths(ranges: &[Range<u64>]) -> u64 {
    let counts = { ranges.iter() }.map(|range| range.end.saturating_sub(range.start));
    counts.sum()
}

/// What a thread works with.
struct Own {
    buffer: SplatBuffer,
    workspace: Workspace,
}

/// What all workers share.
struct Worker<'a> {
    job: &'a RenderJob,
    sampler: &'a Sampler,
    half: u8,
    /// One for each thread.
    buffers: Mutex<Vec<Own>>,
    splats: Mutex<&'a mut Splats>,
    /// How many the splats have.
    pixels: usize,
    progress: &'a Progress<'a>,
}

impl Worker<'_> {
    /// Returns `false` if some of the chunk's paths are left. Never inlined, as [`super::sample_tile`].
    #[inline(never)]
    fn trace_chunk(&self, chunk: Range<u64>, in_time: impl Fn() -> bool) -> bool {
        // There are as many as threads: one is left.
        let own = lock(&self.buffers).pop();
        let mut own = own.unwrap_or_else(|| self.new_buffer());
        let is_whole = self.trace_into(&mut own, chunk, in_time);
        lock(&self.buffers).push(own);
        is_whole
    }

    fn new_buffer(&self) -> Own {
        Own {
            buffer: new_buffer(self.job),
            workspace: Workspace::default(),
        }
    }

    fn trace_into(
        &self,
        Own { buffer, workspace }: &mut Own,
        chunk: Range<u64>,
        in_time: impl Fn() -> bool,
    ) -> bool {
        buffer.begin(chunk.start);
        for run in cut(chunk, RUN) {
            if self.progress.is_stopped() || !in_time() {
                self.empty(buffer);
                return false;
            }
            let count = run.end - run.start;
            trace_run(self.job, self.sampler, run, (buffer, workspace));
            self.progress.advance(count);
            if buffer.is_full() || self.is_time_to_keep() {
                self.empty(buffer);
            }
        }
        self.empty(buffer);
        true
    }

    /// Adds what is in the buffer to the sums.
    fn empty(&self, buffer: &mut SplatBuffer) {
        let mut splats = lock(&self.splats);
        splats.add(buffer);
        pass_on_now_and_then(self.half, &splats, self.progress);
    }

    fn is_time_to_keep(&self) -> bool {
        is_time_to_keep(self.pixels, self.progress)
    }
}

/// Keeps the sums in the checkpoint and shows them, if it is due: they are of whole paths.
pub(super) fn pass_on_now_and_then(half: u8, splats: &Splats, progress: &Progress) {
    if let Some(journal) = progress.journal()
        && is_time_to_keep(splats.bounds().area(), progress)
    {
        journal.keep_splats(half, splats);
    }
    if let Some(live) = progress.live() {
        live.light_now_and_then(half, splats);
    }
}

fn is_time_to_keep(pixels: usize, progress: &Progress) -> bool {
    let journal = progress.journal();
    journal.is_some_and(|journal| journal.is_time_for_splats(pixels))
}

/// For what a thread's paths bring.
pub(super) fn new_buffer(job: &RenderJob) -> SplatBuffer {
    let most = job.film.max_sample_luminance * job.splats_per_sample();
    let has_layers = job.film.layers.lights() > 0;
    SplatBuffer::new(job.lit(), most, has_layers)
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Traces paths one after the other.
fn trace_run(
    job: &RenderJob,
    sampler: &Sampler,
    run: Range<u64>,
    (buffer, workspace): (&mut SplatBuffer, &mut Workspace),
) {
    let (end, ghosts) = (run.end, run.clone());
    let paths = run.map(|path| (path, sampler.light_stream(path)));
    let splat = &mut |splat: Splat| splat.add_to(buffer, &job.world);
    let light_job = job.light_job();
    if job.traces_light() {
        let integrator = &job.integrator;
        integrator.light_paths(&light_job, paths, workspace, splat);
    }
    splat_ghosts(job, &light_job, (ghosts, sampler), splat);
    buffer.reach(end);
}

/// Traces the samples of ghosts that belong to these paths, if the lens makes any.
pub(super) fn splat_ghosts(
    job: &RenderJob,
    light_job: &LightJob,
    (paths, sampler): (impl Iterator<Item = u64>, &Sampler),
    splat: &mut impl FnMut(Splat),
) {
    if let Some(light) = &job.ghosts {
        for path in paths {
            light.splat(light_job, path, &mut sampler.ghost_stream(path), splat);
        }
    }
}

/// The parts of `range` between multiples of `length`.
fn cut(range: Range<u64>, length: u64) -> impl Iterator<Item = Range<u64>> {
    let Range { start, end } = range;
    let first = start / length;
    (first..end.div_ceil(length).max(first))
        .map(move |i| (i * length).max(start)..((i + 1) * length).min(end))
}
