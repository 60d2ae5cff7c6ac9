//! Rendering: the film is divided into tiles, tiles are distributed over threads, and each pixel sample traces a camera
//! ray.
//!
//! An image is a pure function of scene, settings and seed: every sample's dimensions are determined by (seed, pixel,
//! sample index, dimension), pixels are independent, and tiles are collected by position. Thread count and tile size do
//! not change a bit of it.

mod allocation;
mod confidence;
mod goal;
mod halves;
mod layers;
mod light_pass;
mod live;
mod mattes;
mod paired_light;
mod photon_passes;
mod pilot;
mod progress;
mod progressive;
mod shard;
mod threads;
mod work;

pub use goal::{Ended, Goal};
pub use halves::Halves;
pub use light_pass::count_paths;
pub use live::Live;
pub use mattes::Mattes;
pub use progress::{Progress, Statistics, Step};
pub use progressive::{Progressive, render_halves, render_until};
pub use shard::{Division, LightOfShard, Pass, passes, render_shard};
pub(crate) use threads::{THREADS_PER_PROCESSOR, on_threads, threads_started};

use crate::cameras::{BUNDLE, Camera, CameraRay, CameraSample};
use crate::checkpoint::Unit;
use crate::film::{Developed, DroppedSample, Film, FilmSpec, Kept, LightShare, PixelBounds, Tile};
use crate::filters::Filter;
use crate::integrators::witness::{Place, Watch};
use crate::integrators::{
    CameraEnd, CameraPath, Counts, GhostLight, Integrator, LightJob, Paired, WAVE, Workspace,
};
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::{DVec3, Rgb, UVec2, Vec2};
use crate::samplers::{Pairs as SamplePairs, SampleStream, Sampler};
use crate::world::World;
use arrayvec::ArrayVec;
use layers::{Shown, Tell};
use paired_light::{Pairing, Pairs};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use work::{Worked, work};

/// Side of a tile in pixels: small enough that all threads are busy to the end of a small image, large enough that
/// distributing tiles costs nothing.
pub const TILE_SIZE: u32 = 16;

/// Everything that is needed to render one image.
pub struct RenderJob {
    /// The geometry, materials and lights.
    pub world: World,
    /// Generates the camera rays.
    pub camera: Camera,
    /// Computes the radiance along them.
    pub integrator: Integrator,
    /// Generates the samples.
    pub sampler: Sampler,
    /// Samples per pixel that textures are filtered for: the scene's own, regardless of how many are taken. With more
    /// samples each covers a smaller part of the pixel (docs/scene-language.md §3.1), so the converged image depends on
    /// it.
    pub footprint_spp: u32,
    /// The reconstruction filter, which distributes samples in and around a pixel.
    pub filter: Filter,
    /// The film.
    pub film: FilmSpec,
    /// What Cryptomattes know things by.
    pub mattes: Mattes,
    /// When the layer `motion` begins and ends, if it is wanted and anything moves.
    pub motion_times: Option<[f32; 2]>,
    /// What takes points of render space to world space: they are added to it.
    pub world_from_render: DVec3,
    /// Pixels to sample; those outside stay black.
    pub sampled: PixelBounds,
    /// Light paths for each camera sample, where any are traced: see [`RenderJob::run_pilot_pass`].
    pub light_share: LightShare,
    /// Where the camera's lens makes ghosts: their light.
    pub ghosts: Option<GhostLight>,
}

impl RenderJob {
    /// For a thread that renders tiles: it is large, and none of it lasts from one bundle of paths to the next.
    fn workspace(&self) -> Workspace {
        self.integrator.workspace(&self.world)
    }
}

/// Renders the image on the current rayon pool, with variances of independent samples or without; if it is stopped, as much of
/// it as was done.
pub fn render(job: &RenderJob, tile_size: u32, variance: bool, progress: &Progress) -> Developed {
    let kept = if variance {
        Kept::Variance
    } else {
        Kept::Color
    };
    if job.has_splats() || job.integrator.photons(&job.world).is_some() {
        return expose(job, tile_size, progress).developed(kept);
    }
    let developed = Mutex::new(Developed::new(&job.film, kept));
    each_tile(job, tile_size, |workspace, tile, bounds| {
        let own = (workspace, None);
        let done = work_of_half(job, &job.sampler, (0, tile, bounds), own, progress);
        locked(&developed).place(&done);
    });
    unlocked(developed)
}

/// As [`render`], with all that is known of every pixel.
pub fn expose(job: &RenderJob, tile_size: u32, progress: &Progress) -> Film {
    if let Some(mapper) = job.integrator.photons(&job.world) {
        return photon_passes::render(job, &mapper, tile_size, progress);
    }
    let film = Mutex::new(Film::new(&job.film));
    let mut splats = light_pass::restored(job, 0, progress);
    let pairing = Pairing::whole(job, job.sampler.spp());
    let pairs = Pairs::new(job, pairing, (0, splats.as_mut()), progress);
    each_tile(job, tile_size, |workspace, tile, bounds| {
        let own = (workspace, pairs.as_ref());
        let done = work_of_half(job, &job.sampler, (0, tile, bounds), own, progress);
        locked(&film).merge(done);
    });
    let traced = pairs.map_or(0, Pairs::traced);
    let mut film = unlocked(film);
    if let Some(mut splats) = splats {
        let all = 0..job.light_paths(job.sampler.spp());
        let paths = (std::slice::from_ref(&all), traced);
        let sampler = (0, &job.sampler);
        light_pass::trace(job, sampler, &mut splats, paths, || true, progress);
        film.add_light(&[splats]);
    }
    film
}

/// Renders an image without light paths as two halves with the samplers of these, a tile in both before the next one. Returns it,
/// and the first sample that each half dropped.
fn render_in_two(
    job: &RenderJob,
    samplers: &[Sampler; 2],
    tile_size: u32,
    progress: &Progress,
) -> (Developed, [Option<DroppedSample>; 2]) {
    let developed = Mutex::new((Developed::new(&job.film, Kept::Halves), [None; 2]));
    each_tile(job, tile_size, |workspace, tile, bounds| {
        let halves = [0, 1].map(|half| {
            let sampler = &samplers[usize::from(half)];
            let own = (&mut *workspace, None);
            work_of_half(job, sampler, (half, tile, bounds), own, progress)
        });
        let (developed, dropped) = &mut *locked(&developed);
        developed.place_halves(&halves);
        for (dropped, half) in dropped.iter_mut().zip(&halves) {
            *dropped = DroppedSample::first(*dropped, half.first_dropped());
        }
    });
    let (mut developed, dropped) = unlocked(developed);
    developed.pool();
    (developed, dropped)
}

/// Calls `render` for each tile, with its number and a workspace, on the current rayon pool.
fn each_tile(
    job: &RenderJob,
    tile_size: u32,
    render: impl Fn(&mut Workspace, u32, PixelBounds) + Sync,
) {
    let bounds = job.film.pixel_bounds().intersection(job.sampled);
    let tiles: Vec<PixelBounds> = bounds.tiles(tile_size).collect();
    let tiles = tiles.into_par_iter().enumerate();
    tiles.for_each_init(
        || job.workspace(),
        |workspace, (tile, bounds)| render(workspace, tile as u32, bounds),
    );
}

/// All samples of a tile of one half.
fn work_of_half(
    job: &RenderJob,
    sampler: &Sampler,
    (half, tile, bounds): (u8, u32, PixelBounds),
    own: (&mut Workspace, Option<&Pairs>),
    progress: &Progress,
) -> Tile {
    let unit = Unit {
        half,
        tile,
        samples: 0..sampler.spp(),
    };
    match work(job, sampler, (&unit, bounds), own, progress) {
        Worked::Finished(tile) | Worked::Stopped(tile) => tile,
    }
}

/// Locked for a tile.
fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unlocked<T>(shared: Mutex<T>) -> T {
    shared.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// Renders a range of the sampler's samples in every pixel of a tile, a bundle of camera rays at a time.
///
/// Never inlined: rayon divides the tiles by a recursion, each level of which would have the arrays of a wave on the stack. A thread that
/// waits for another takes up other work on top, so that with many threads there are many levels.
#[inline(never)]
fn sample_tile(
    job: &RenderJob,
    sampler: &Sampler,
    samples_of_pixel: Range<u32>,
    (tile, bounds): (&mut Tile, PixelBounds),
    (workspace, mut watch, paired): (&mut Workspace, Option<&mut Watch>, Option<&Pairs>),
) {
    let all = OfAll::new(job, sampler, paired.map(|pairs| &pairs.pairing));
    let light = paired.and_then(|pairs| Some((pairs.light.as_ref()?, &pairs.pairing)));
    let light_job = light.map(|(light, _)| light.begin(workspace));
    let want_differentials = job.world.needs_footprint();
    let mut waiting = ArrayVec::<SampleState, WAVE>::new();
    let mut samples = ArrayVec::<CameraSample, WAVE>::new();
    let mut rays = [const { None }; WAVE];
    let has_layers = tile.has_layers();
    let mut looks = Vec::new();
    if has_layers && watch.is_none() {
        looks.resize_with(WAVE, Watch::default);
        looks
            .iter_mut()
            .for_each(|watch| watch.look(job.film.layers));
    }
    let mut indices = bounds.pixels().flat_map(|pixel| {
        let of_pixel = sampler.of_pixel(pixel.as_ivec2());
        let indices = samples_of_pixel.clone();
        indices.map(move |index| SampleState::undrawn(of_pixel.stream(index), (pixel, index)))
    });
    let mut pairs = Box::<SamplePairs<WAVE>>::default();
    loop {
        waiting.extend(indices.by_ref().take(WAVE));
        let on_film = film_samples(&mut pairs, &mut waiting);
        samples.extend(
            { waiting.iter_mut().zip(on_film) }
                .map(|(waiting, on_film)| waiting.draw(job, &all.draws, on_film)),
        );
        if samples.is_empty() {
            tile.close();
            if let Some((light, _)) = light {
                light.empty(workspace);
            }
            return;
        }
        let rays = &mut rays[..samples.len()];
        for (samples, rays) in samples.chunks(BUNDLE).zip(rays.chunks_mut(BUNDLE)) {
            job.camera.rays(samples, want_differentials, rays);
        }
        let shown = (job, &all);
        if let Some(watch) = watch.as_deref_mut() {
            let camera = (samples.as_slice(), &*rays);
            let own = (&mut *workspace, watch);
            one_by_one(shown, sampler, &mut waiting, camera, own, tile);
        } else {
            let camera = (samples.as_slice(), &*rays);
            let own = (&mut *workspace, looks.as_mut_slice());
            let radiances = radiances(shown, camera, &mut waiting, own, light_job);
            let radiances = radiances.as_slice();
            let samples = (waiting.as_slice(), &*rays);
            if let Some((light, pairing)) = light {
                light.take(workspace, samples, (pairing, sampler));
            }
            if has_layers {
                vectorize::<WIDEST, _>(Tell {
                    shown,
                    sampler,
                    samples,
                    radiances,
                    looks: &mut looks,
                    tile: &mut *tile,
                });
            }
            vectorize::<WIDEST, _>(Finish {
                samples,
                radiances,
                tile: &mut *tile,
            });
        }
        waiting.clear();
        samples.clear();
    }
}

/// The film samples of a wave.
fn film_samples(
    pairs: &mut SamplePairs<WAVE>,
    waiting: &mut [SampleState],
) -> ArrayVec<Vec2, WAVE> {
    pairs.clear();
    let mut drawn = ArrayVec::<_, WAVE>::new();
    for (i, waiting) in waiting.iter_mut().enumerate() {
        drawn.push(pairs.ask(&mut waiting.stream, i).unwrap_or_default());
    }
    pairs.compute();
    for asked in 0..pairs.asked() {
        let i = pairs.whose(asked);
        drawn[i] = pairs.answer(asked, &mut waiting[i].stream);
    }
    drawn
}

/// Traces the paths one at a time, and reports each to what watches it.
fn one_by_one(
    shown: (&RenderJob, &OfAll),
    sampler: &Sampler,
    waiting: &mut [SampleState],
    (samples, rays): (&[CameraSample], &[Option<CameraRay>]),
    (workspace, watch): (&mut Workspace, &mut Watch),
    tile: &mut Tile,
) {
    let has_layers = tile.has_layers();
    for ((waiting, sample), ray) in waiting.iter_mut().zip(samples).zip(rays) {
        let ray = ray.as_ref();
        let own = (&mut *workspace, &mut *watch);
        let radiance = waiting.trace(shown, sample, ray, own, has_layers);
        if has_layers {
            layers::add(shown, waiting, (ray, radiance), (sampler, watch), tile);
        }
        waiting.finish(ray, radiance, tile);
    }
}

/// The radiance along each of these rays, at which `looks` look, if any do.
fn radiances(
    (job, all): (&RenderJob, &OfAll),
    (samples, rays): (&[CameraSample], &[Option<CameraRay>]),
    waiting: &mut [SampleState],
    (workspace, looks): (&mut Workspace, &mut [Watch]),
    light_job: Option<&LightJob>,
) -> ArrayVec<Rgb, WAVE> {
    let mut watches = looks.iter_mut();
    let all_paths = waiting.iter_mut().zip(samples).zip(rays);
    let path = |((waiting, sample), ray)| {
        let (waiting, ray): (&mut SampleState, &Option<CameraRay>) = (waiting, ray);
        let watch = watches.next();
        let ray = ray.as_ref()?;
        Some(CameraPath {
            end: waiting.camera_end(job, sample, ray, all),
            differentials: ray.scaled_differentials(all.spacing),
            stream: &mut waiting.stream,
            watch,
        })
    };
    // Not collected, which would move all of them.
    let mut paths = ArrayVec::<CameraPath, WAVE>::new();
    paths.extend(all_paths.filter_map(path));
    let (integrator, world) = (&job.integrator, &job.world);
    integrator.radiances(world, &mut paths, workspace, light_job)
}

/// The end of a wave: what its samples bring is added to the tile.
struct Finish<'a> {
    samples: (&'a [SampleState], &'a [Option<CameraRay>]),
    /// Of those that have a ray.
    radiances: &'a [Rgb],
    tile: &'a mut Tile,
}

impl Kernel for Finish<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let mut radiances = self.radiances.iter();
        for (waiting, ray) in self.samples.0.iter().zip(self.samples.1) {
            let ray = ray.as_ref();
            let radiance = ray.and_then(|_| radiances.next());
            let radiance = radiance.copied().unwrap_or_default();
            waiting.finish(ray, radiance, self.tile);
        }
    }
}

/// Where a dropped sample failed on its path, in an image of one set of samples.
pub fn locate_in_one_set(job: &RenderJob, dropped: DroppedSample) -> Option<Place> {
    let pairing = Pairing::whole(job, job.sampler.spp());
    locate(job, (&job.sampler, pairing.as_ref()), dropped)
}

/// Repeats a dropped sample of `sampler` and returns where on its path it failed; `None` if there was no path. Samples
/// are pure functions of their dimensions, so nothing needs to be recorded for this.
fn locate(
    job: &RenderJob,
    (sampler, pairing): (&Sampler, Option<&Pairing>),
    dropped: DroppedSample,
) -> Option<Place> {
    let (sample, mut waiting) =
        SampleState::new(job, sampler, dropped.pixel, dropped.sample as u32);
    let mut rays = [None];
    let want_differentials = job.world.needs_footprint();
    job.camera.rays(&[sample], want_differentials, &mut rays);
    let camera_ray: &CameraRay = rays[0].as_ref()?;
    let mut watch = Watch::searching();
    let all = OfAll::new(job, sampler, pairing);
    job.integrator.radiance(
        &job.world,
        &waiting.camera_end(job, &sample, camera_ray, &all),
        camera_ray.scaled_differentials(all.spacing).as_ref(),
        &mut waiting.stream,
        &mut Workspace::default(),
        Some(&mut watch),
    );
    watch.offender()
}

/// What all samples of an image have in common.
struct OfAll<'a> {
    /// Spacing of a pixel's samples, in pixels: see [`RenderJob::footprint_spp`].
    spacing: f32,
    /// See [`RenderJob::paths_per_sample`].
    light_paths: f32,
    pairing: Option<(&'a Sampler, &'a Pairing)>,
    shown: Shown<'a>,
    draws: Draws,
}

impl<'a> OfAll<'a> {
    /// Of an image, a half, or a pass of one, with these samples and perhaps these pairs.
    fn new(job: &'a RenderJob, sampler: &'a Sampler, pairing: Option<&'a Pairing>) -> OfAll<'a> {
        OfAll {
            pairing: pairing.map(|pairing| (sampler, pairing)),
            shown: Shown::new(job),
            spacing: 1.0 / (job.footprint_spp.max(1) as f32).sqrt(),
            light_paths: job.paths_per_sample(),
            draws: Draws::new(job),
        }
    }
}

/// Which of a sample's numbers an image needs.
struct Draws {
    time: bool,
    lens: bool,
    wavelength: bool,
    /// [`SampleState::film_density`] is one of them.
    film_density: bool,
}

impl Draws {
    fn new(job: &RenderJob) -> Draws {
        Draws {
            time: job.world.moves() || job.camera.moves(),
            lens: job.camera.has_lens(),
            wavelength: job.camera.disperses(),
            film_density: job.integrator.traces_light(),
        }
    }
}

/// A sample of a pixel, from its first number until its radiance is in the tile.
struct SampleState {
    pixel: UVec2,
    index: u32,
    stream: SampleStream,
    filter_weight: f32,
    film_density: f32,
}

impl SampleState {
    /// Sample `index` of a pixel.
    fn new(
        job: &RenderJob,
        sampler: &Sampler,
        pixel: UVec2,
        index: u32,
    ) -> (CameraSample, SampleState) {
        let stream = sampler.stream(pixel.as_ivec2(), index);
        let mut waiting = SampleState::undrawn(stream, (pixel, index));
        let on_film = waiting.stream.next_2d();
        (waiting.draw(job, &Draws::new(job), on_film), waiting)
    }

    /// A sample of which nothing has been drawn from `stream` yet.
    #[inline(always)]
    fn undrawn(stream: SampleStream, (pixel, index): (UVec2, u32)) -> SampleState {
        SampleState {
            pixel,
            index,
            stream,
            filter_weight: 1.0,
            film_density: 1.0,
        }
    }

    /// Draws what the camera needs, of which the place `on_film` has been drawn. Dimensions are used in the order film, time, lens (if the camera has
    /// one), wavelength (if it disperses), path.
    #[inline]
    fn draw(&mut self, job: &RenderJob, draws: &Draws, on_film: Vec2) -> CameraSample {
        let on_film = job.filter.sample(on_film);
        self.filter_weight = on_film.weight;
        if draws.film_density {
            self.film_density = job.filter.at(on_film.offset).0;
        }
        let stream = &mut self.stream;
        CameraSample {
            raster: self.pixel.as_vec2() + Vec2::splat(0.5) + on_film.offset,
            time: stream.next_1d_if(draws.time),
            lens: if draws.lens {
                stream.next_2d()
            } else {
                Vec2::splat(0.5)
            },
            wavelength: if draws.wavelength {
                stream.next_1d()
            } else {
                0.5
            },
        }
    }

    /// What its path has drawn from, as it was before: samples are pure functions of their numbers.
    #[inline(never)]
    fn stream_again(&self, job: &RenderJob, sampler: &Sampler) -> SampleStream {
        let (_, again) = SampleState::new(job, sampler, self.pixel, self.index);
        again.stream
    }

    fn camera_end<'a>(
        &self,
        job: &'a RenderJob,
        sample: &'a CameraSample,
        ray: &'a CameraRay,
        all: &OfAll<'a>,
    ) -> CameraEnd<'a> {
        CameraEnd {
            camera: &job.camera,
            sample,
            ray,
            film_density: self.film_density,
            light_paths: all.light_paths,
            paired: all.pairing.map(|(sampler, pairing)| Paired {
                sampler,
                number: pairing.path(self.pixel, self.index),
            }),
        }
    }

    /// Follows the path by itself, unless it ends in the camera: its radiance.
    fn trace(
        &mut self,
        (job, all): (&RenderJob, &OfAll),
        sample: &CameraSample,
        ray: Option<&CameraRay>,
        (workspace, watch): (&mut Workspace, &mut Watch),
        has_layers: bool,
    ) -> Rgb {
        let Some(camera_ray) = ray else {
            watch.count(|counts| counts.blocked += 1);
            return Rgb::ZERO;
        };
        let differentials = camera_ray.scaled_differentials(all.spacing);
        let end = self.camera_end(job, sample, camera_ray, all);
        if has_layers {
            watch.look(job.film.layers);
        }
        let radiance = job.integrator.radiance(
            &job.world,
            &end,
            differentials.as_ref(),
            &mut self.stream,
            workspace,
            Some(watch),
        );
        watch.count(Counts::end_path);
        radiance
    }

    /// What multiplies the radiance along a ray on its way to the pixel.
    #[inline(always)]
    fn weight(&self, ray: &CameraRay) -> Rgb {
        ray.tint * (ray.weight * self.filter_weight)
    }

    /// Adds what the path has brought.
    #[inline(always)]
    fn finish(&self, ray: Option<&CameraRay>, radiance: Rgb, tile: &mut Tile) {
        match ray {
            Some(ray) => tile.add_colored_sample(self.pixel, radiance, self.weight(ray)),
            None => tile.add_sample(self.pixel, Rgb::ZERO, 0.0),
        };
    }
}
