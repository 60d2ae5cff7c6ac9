//! What a camera sample tells the image's layers.

use super::{OfAll, RenderJob, SampleState};
use crate::cameras::{CameraRay, DepthAndBlur, Depths};
use crate::film::{CameraSample, Layer, LayerSample, LayerSet, RenderSpace, SurfaceSample, Tile};
use crate::integrators::witness::Watch;
use crate::integrators::{FirstSurfaces, LightParts, first_surfaces};
use crate::math::instruction_set::{Instructions, Kernel};
use crate::math::{DVec3, Rgb, Vec2};
use crate::samplers::{SampleStream, Sampler};
use arrayvec::ArrayVec;

/// What all samples of an image have in common for its layers.
pub(super) struct Shown<'a> {
    /// Layers that tell of surfaces are among them.
    surfaces: bool,
    space: RenderSpace,
    /// Where depth or circles of confusion are wanted, and each sample has to tell them.
    depths: Option<Depths<'a>>,
    /// When [`Layer::Motion`] begins and ends, if it is wanted and anything moves.
    motion: Option<[f32; 2]>,
}

impl Shown<'_> {
    /// Of these layers.
    pub(super) fn new(job: &RenderJob) -> Shown<'_> {
        let layers = job.film.layers;
        let has_depths = layers.contains(Layer::Depth) || layers.contains(Layer::Coc);
        let depths = has_depths.then(|| job.camera.depths());
        let of_mean = depths.as_ref().and_then(Depths::of_mean);
        Shown {
            surfaces: layers.with_lights(0) != LayerSet::NONE.with(Layer::Lights),
            space: RenderSpace {
                origin: job.world_from_render.extend(0.0),
                depth: of_mean.unwrap_or_default(),
            },
            depths: depths.filter(|_| of_mean.is_none()),
            motion: job.motion_times,
        }
    }

    /// Returns `true` if there is nothing that each sample has to tell of how the camera sees it.
    fn is_still(&self) -> bool {
        self.depths.is_none() && self.motion.is_none()
    }
}

/// The end of a wave: what its samples show is added to the tile's layers.
pub(super) struct Tell<'a> {
    pub shown: (&'a RenderJob, &'a OfAll<'a>),
    pub sampler: &'a Sampler,
    pub samples: (&'a [SampleState], &'a [Option<CameraRay>]),
    /// Of those that have a ray.
    pub radiances: &'a [Rgb],
    /// One for each sample. They are reset for the next wave while they are in the L1 cache.
    pub looks: &'a mut [Watch],
    pub tile: &'a mut Tile,
}

impl Kernel for Tell<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let ((job, all), tile) = (self.shown, self.tile);
        let (mut waiting, mut rays) = self.samples;
        let (mut looks, mut radiances) = (self.looks, self.radiances);
        let may_be_plain = all.shown.surfaces && tile.lights() == 0;
        while let ([next, ..], [ray, ..], [watch, ..]) = (waiting, rays, &*looks) {
            let plain = if may_be_plain {
                alike(waiting, looks)
            } else {
                None
            };
            let (count, paths) = if let Some((found, count)) = plain {
                let what = (job.mattes.of(found.thing), &all.shown.space);
                let (pixel, weight) = (next.pixel, next.filter_weight);
                let rays = rays.get(..count).unwrap_or_default();
                let samples = looks.get(..count).unwrap_or_default().iter().zip(rays);
                match all.shown.is_still() {
                    true => tile.add_run_of_layers(pixel, weight, what, Still(samples)),
                    false => {
                        let shown = self.shown;
                        tile.add_run_of_layers(pixel, weight, what, Moving { shown, samples });
                    }
                }
                (count, count)
            } else if may_be_plain && (ray.is_none() || watch.is_empty()) {
                let nothing = ray.is_some().then_some(None);
                tile.add_layers(next.pixel, next.filter_weight, nothing, &[]);
                (1, usize::from(ray.is_some()))
            } else {
                let radiance = radiances.first().copied().unwrap_or_default();
                let sample = (ray.as_ref(), radiance);
                add(self.shown, next, sample, (self.sampler, watch), tile);
                (1, usize::from(ray.is_some()))
            };
            waiting = waiting.get(count..).unwrap_or_default();
            rays = rays.get(count..).unwrap_or_default();
            let (told, others) = looks.split_at_mut(count);
            told.iter_mut()
                .for_each(|watch| watch.look(job.film.layers));
            looks = others;
            radiances = radiances.get(paths..).unwrap_or_default();
        }
    }
}

/// Samples of which the camera tells nothing more.
struct Still<I>(I);

impl<'a, I: Iterator<Item = Looked<'a>>> Iterator for Still<I> {
    type Item = (&'a SurfaceSample, Option<CameraSample>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let (watch, _) = self.0.next()?;
        Some((&watch.first().surface, None))
    }
}

/// Samples of which it does. Not a closure, which is not always inlined.
struct Moving<'a, I> {
    shown: (&'a RenderJob, &'a OfAll<'a>),
    samples: I,
}

impl<'a, I: Iterator<Item = Looked<'a>>> Iterator for Moving<'a, I> {
    type Item = (&'a SurfaceSample, Option<CameraSample>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let (watch, ray) = self.samples.next()?;
        let (found, ray) = (watch.first(), ray.as_ref()?);
        let camera = of_camera(self.shown, ray.ray.time, found);
        Some((&found.surface, Some(camera)))
    }
}

/// What has looked at a sample's path, and its ray.
type Looked<'a> = (&'a Watch, &'a Option<CameraRay>);

/// What the next sample's path has met, where it has told all, and how many samples from there on are of the same pixel, of the same weight and have met
/// the same: most are of this kind. All of them have a ray.
#[inline(always)]
fn alike<'a>(waiting: &[SampleState], looks: &'a [Watch]) -> Option<(&'a FirstSurfaces, usize)> {
    let (first, found) = (waiting.first()?, looks.first()?.found()?);
    let is_alike = |(next, watch): &(&SampleState, &Watch)| {
        { watch.found() }.is_some_and(|other| other.thing == found.thing)
            && next.pixel == first.pixel
            && next.filter_weight == first.filter_weight
    };
    let count = waiting.iter().zip(looks).take_while(is_alike).count();
    // The first one is like itself, whatever its weight.
    Some((found, count.max(1)))
}

/// Adds to the layers of `tile` what a sample of `sampler` shows, whose path has brought this `radiance` while `watch` looked at it; without a
/// ray it has not left the lens.
#[inline(never)]
pub(super) fn add(
    shown: (&RenderJob, &OfAll),
    waiting: &SampleState,
    (ray, radiance): (Option<&CameraRay>, Rgb),
    (sampler, watch): (&Sampler, &Watch),
    tile: &mut Tile,
) {
    let lights = match (ray, &watch.parts) {
        (Some(ray), Some(parts)) => lights(parts, (waiting.weight(ray), radiance), tile),
        _ => ArrayVec::new(),
    };
    let (job, all) = shown;
    let known = watch.sight.known();
    let found = match (ray, known) {
        (Some(_), Some(known)) if all.shown.surfaces => known.copied(),
        (Some(ray), None) if all.shown.surfaces => {
            traced(shown, ray, waiting.stream_again(job, sampler))
        }
        _ => None,
    };
    let sample = ray.map(|ray| {
        found.as_ref().map(|found| LayerSample {
            surface: &found.surface,
            space: &all.shown.space,
            camera: of_camera(shown, ray.ray.time, found),
            mattes: job.mattes.of(found.thing),
        })
    });
    let sample = sample.as_ref().map(Option::as_ref);
    tile.add_layers(waiting.pixel, waiting.filter_weight, sample, &lights);
}

/// What a path brings, of this radiance, by layers of light.
#[inline(never)]
fn lights(
    parts: &LightParts,
    (weight, radiance): (Rgb, Rgb),
    tile: &Tile,
) -> ArrayVec<Rgb, { LayerSet::MAX_LIGHTS }> {
    let factor = tile.factor_of_parts(radiance, weight);
    parts.scaled(factor, tile.lights()).collect()
}

/// By a ray for the layers alone.
#[inline(never)]
fn traced(
    (job, all): (&RenderJob, &OfAll),
    camera_ray: &CameraRay,
    stream: SampleStream,
) -> Option<FirstSurfaces> {
    let differentials = camera_ray.scaled_differentials(all.spacing);
    let wants_uv = job.film.layers.contains(Layer::Uv);
    let ray = &camera_ray.ray;
    first_surfaces(&job.world, ray, differentials.as_ref(), stream, wants_uv)
}

/// How the camera sees at this time what has been met: what [`RenderSpace::depth`] does not tell.
#[inline(always)]
fn of_camera((job, all): (&RenderJob, &OfAll), time: f32, found: &FirstSurfaces) -> CameraSample {
    // Not by `map`, whose function is not always inlined.
    let at = match &all.shown.depths {
        Some(depths) => depths.at(found.surface.p(), time),
        None => DepthAndBlur::default(),
    };
    let motion = match all.shown.motion {
        Some(times) => motion(job, time, found, times),
        None => Vec2::ZERO,
    };
    CameraSample::new(at.depth, at.coc, motion)
}

/// See [`Layer::Motion`], of what is met at this time; none where the camera does not see both ends of the way.
#[inline(never)]
fn motion(job: &RenderJob, time: f32, found: &FirstSurfaces, times: [f32; 2]) -> Vec2 {
    let p = found.surface.p().as_dvec3();
    let geometry = &job.world.geometry;
    let moved = { found.moving }.and_then(|found| geometry.moved(&found, p, time, times));
    if moved.is_none() && !job.camera.moves() {
        return Vec2::ZERO;
    }
    let ends = moved.unwrap_or([p; 2]).map(|end: DVec3| end.as_vec3());
    let shift = job.camera.shift(ends, times).unwrap_or(Vec2::ZERO);
    Vec2::new(shift.x, -shift.y)
}
