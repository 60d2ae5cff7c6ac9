//! Light paths that are traced once for two strategies: where every camera path is joined to a light path, that is one of the light pass
//! ([`light_pass`](super::light_pass)), and is joined to the lens as well while tiles are rendered. The light pass leaves it out then. Which path
//! it is depends on the camera sample and on the samples of its pass, and what it brings on its number alone: the image has the same bits
//! whether a tile or the light pass traces it.

use super::light_pass::{new_buffer, pass_on_now_and_then, splat_ghosts};
use super::{Progress, RenderJob, SampleState, TILE_SIZE, locked};
use crate::cameras::CameraRay;
use crate::film::{LightShare, PixelBounds, Splats};
use crate::integrators::{LightJob, Splat, Workspace};
use crate::math::UVec2;
use crate::samplers::Sampler;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

impl RenderJob {
    /// Returns `true` if each camera path is joined to a path of the light pass.
    pub fn pairs_paths(&self) -> bool {
        self.traces_light()
            && self.light_share.0 >= 1.0
            && self.integrator.joined() >= 1.0
            && self.may_pair_paths()
    }

    /// Not where anything moves: the two have one time.
    pub(super) fn may_pair_paths(&self) -> bool {
        !self.world.moves() && !self.camera.moves()
    }
}

/// Which path of the light pass each camera path of a pass is joined to.
pub(super) struct Pairing {
    pixels: PixelBounds,
    columns: u32,
    /// By tile of [`TILE_SIZE`]: its first path, and the samples of each pixel.
    tiles: Vec<(u64, Range<u32>)>,
    /// Below which they are.
    end: u64,
}

impl Pairing {
    /// Of an image, or a half, with so many samples in each pixel; `None` if camera paths are joined to other paths, or not all of them.
    pub(super) fn whole(job: &RenderJob, spp: u32) -> Option<Pairing> {
        Pairing::of_pass(job, std::iter::repeat(0..spp))
    }

    /// Of a pass with these samples of each tile: its paths are those after the last pass's.
    pub(super) fn of_pass(
        job: &RenderJob,
        samples: impl Iterator<Item = Range<u32>>,
    ) -> Option<Pairing> {
        { job.pairs_paths() }.then(|| Pairing::new(job.lit(), job.light_share, samples))
    }

    /// Of a pass with these samples of each tile of `pixels`, where there is at least one light path for each sample.
    pub(super) fn new(
        pixels: PixelBounds,
        share: LightShare,
        samples: impl Iterator<Item = Range<u32>>,
    ) -> Pairing {
        let areas = pixels.tiles(TILE_SIZE).map(|tile| tile.area() as u64);
        let tiles: Vec<_> = areas.zip(samples).collect();
        let before = { tiles.iter() }.map(|(area, samples)| area * u64::from(samples.start));
        let mut next = share.paths(before.sum());
        let with_first = |(area, samples): (u64, Range<u32>)| {
            let first = next;
            next += area * samples.len() as u64;
            (first, samples)
        };
        let tiles = tiles.into_iter().map(with_first).collect();
        Pairing {
            pixels,
            columns: pixels.size().x.div_ceil(TILE_SIZE),
            tiles,
            end: next,
        }
    }

    /// The number after the last path's.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    /// Adds the paths for these samples of some pixels to `ranges`.
    pub(super) fn add_paths_of(
        &self,
        (pixels, samples): (PixelBounds, &Range<u32>),
        ranges: &mut Vec<Range<u64>>,
    ) {
        for pixel in pixels.pixels() {
            let first = self.path(pixel, samples.start);
            let end = first + samples.len() as u64;
            match ranges.last_mut() {
                Some(last) if last.end == first => last.end = end,
                _ => ranges.push(first..end),
            }
        }
    }

    /// The number of the path for this sample. Those of a pixel are one after the other, and so well distributed.
    pub(super) fn path(&self, pixel: UVec2, sample: u32) -> u64 {
        let at = pixel - self.pixels.min;
        let (tile, within) = (at / TILE_SIZE, at % TILE_SIZE);
        let width = TILE_SIZE.min(self.pixels.size().x - tile.x * TILE_SIZE);
        let Some((first, samples)) = self.tiles.get((tile.y * self.columns + tile.x) as usize)
        else {
            return 0;
        };
        let place = u64::from(within.y * width + within.x);
        first + place * samples.len() as u64 + u64::from(sample.saturating_sub(samples.start))
    }
}

/// The pairs of a pass, and what takes up what their light paths bring.
pub(super) struct Pairs<'a> {
    pub(super) pairing: Pairing,
    /// `None` where they are traced once more.
    pub(super) light: Option<PairedLight<'a>>,
}

impl<'a> Pairs<'a> {
    /// With what takes it up for a half's `splats`; `None` without a `pairing`.
    pub(super) fn new(
        job: &'a RenderJob,
        pairing: Option<Pairing>,
        splats: (u8, Option<&'a mut Splats>),
        progress: &'a Progress,
    ) -> Option<Pairs<'a>> {
        let (half, splats) = splats;
        Some(Pairs {
            pairing: pairing?,
            light: splats.map(|splats| PairedLight {
                job,
                light_job: job.light_job(),
                half,
                splats: Mutex::new(splats),
                traced: AtomicU64::new(0),
                progress,
            }),
        })
    }

    /// How many light paths there were that are not traced again.
    pub(super) fn traced(self) -> u64 {
        self.light.map_or(0, |light| light.traced.into_inner())
    }
}

/// The light pass while tiles are rendered: the paths that camera paths are joined to are joined to the lens as well, and not
/// traced again.
pub(super) struct PairedLight<'a> {
    job: &'a RenderJob,
    light_job: LightJob<'a>,
    half: u8,
    splats: Mutex<&'a mut Splats>,
    traced: AtomicU64,
    progress: &'a Progress<'a>,
}

impl<'a> PairedLight<'a> {
    /// What the paths are traced for; there is room for what they bring.
    pub(super) fn begin(&self, workspace: &mut Workspace) -> &LightJob<'a> {
        workspace.splats.get_or_insert_with(|| new_buffer(self.job));
        &self.light_job
    }

    /// Notes the light paths of these camera samples, and traces the samples of ghosts that belong to them. Those of samples whose ray a lens has blocked are traced here: left to the light pass, each would
    /// be a gap between the ranges of path numbers, of which there may be millions then.
    pub(super) fn take(
        &self,
        workspace: &mut Workspace,
        (samples, rays): (&[SampleState], &[Option<CameraRay>]),
        (pairing, sampler): (&Pairing, &Sampler),
    ) {
        let Some(mut buffer) = workspace.splats.take() else {
            return;
        };
        let path = |sample: &SampleState| pairing.path(sample.pixel, sample.index);
        let alone = { samples.iter().zip(rays) }
            .filter(|(_, ray)| ray.is_none())
            .map(|(sample, _)| (path(sample), sampler.light_stream(path(sample))));
        let splat = &mut |splat: Splat| splat.add_to(&mut buffer, &self.job.world);
        let integrator = &self.job.integrator;
        if rays.iter().any(Option::is_none) {
            integrator.light_paths(&self.light_job, alone, workspace, splat);
        }
        let paths = samples.iter().map(path);
        splat_ghosts(self.job, &self.light_job, (paths.clone(), sampler), splat);
        paths.for_each(|path| buffer.add_path(path));
        let is_full = buffer.is_full();
        workspace.splats = Some(buffer);
        if is_full {
            self.empty(workspace);
        }
    }

    /// Adds what is in the buffer to the sums.
    pub(super) fn empty(&self, workspace: &mut Workspace) {
        if let Some(buffer) = &mut workspace.splats {
            let mut splats = locked(&self.splats);
            let before = splats.paths().count();
            splats.add(buffer);
            let traced = splats.paths().count() - before;
            self.traced.fetch_add(traced, Ordering::Relaxed);
            self.progress.advance(traced);
            pass_on_now_and_then(self.half, &splats, self.progress);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::build;
    use crate::film::Film;
    use crate::render::light_pass::trace;
    use crate::render::{each_tile, expose, unlocked, work_of_half};
    use crate::scene::{ReadSettings, read_scene};
    use crate::syntax::SourceMap;

    const LENS: &str =
        r#""perspective" "float fov" 50 "float lensradius" .1 "float focaldistance" 6"#;

    /// It loses rays.
    const STAR: &str = r#""realistic" "string lensfile" "lenses/dgauss.50mm.dat" "float aperturediameter" 8
        "float focusdistance" 6 "string aperture" "star""#;

    const GHOSTS: &str = r#""realistic" "string lensfile" "lenses/dgauss.50mm.dat" "float aperturediameter" 8
        "float focusdistance" 6 "bool ghosts" "true""#;

    /// A lamp in fog above a floor, through a lens onto a wide filter.
    fn fog(camera: &str) -> RenderJob {
        let text = r#"
            MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .3 .2 .1 ]
            LookAt 0 1 -6  0 0 0  0 1 0
            MediumInterface "" "fog"
            Camera CAMERA
            Film "image" "integer xresolution" 20 "integer yresolution" 18
            PixelFilter "gaussian"
            Sampler "halton" "integer pixelsamples" 6
            Integrator "bdpt"
            WorldBegin
            MediumInterface "fog" "fog"
            LightSource "point" "point from" [ 0 2 0 ] "rgb I" [ 5 6 7 ]
            Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -4 -1 -4  4 -1 -4  4 -1 4  -4 -1 4 ]
            Shape "sphere" "float radius" .5
            WorldEnd"#;
        let sources = SourceMap::new();
        let file = sources.add_text("fog.pbrt", text.replace("CAMERA", camera));
        let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
        assert!(!diagnostics.has_errors());
        let frame = scene.frames.into_iter().next().expect("one frame");
        build(frame, 0).0.expect("it can be built").job
    }

    /// The image's camera samples, whose light paths bring light to `splats`, if there are any.
    fn tiles(job: &RenderJob, splats: Option<&mut Splats>) -> (Film, u64) {
        let hidden = Progress::hidden();
        let pairs = Pairs::new(job, Pairing::whole(job, 6), (0, splats), &hidden);
        let film = Mutex::new(Film::new(&job.film));
        each_tile(job, 8, |workspace, tile, bounds| {
            let (own, of) = ((workspace, pairs.as_ref()), (0, tile, bounds));
            let done = work_of_half(job, &job.sampler, of, own, &hidden);
            locked(&film).merge(done);
        });
        (unlocked(film), pairs.map_or(0, Pairs::traced))
    }

    /// The image has the same bits whether tiles trace them, the light pass, or each a part, as after an interruption.
    #[test]
    fn paired_paths_bring_the_same_as_in_a_pass_of_their_own() {
        for camera in [LENS, STAR, GHOSTS] {
            let job = fog(camera);
            assert_eq!(job.ghosts.is_some(), camera == GHOSTS);
            check(&job);
        }
    }

    fn check(job: &RenderJob) {
        assert!(job.pairs_paths());
        let (all, hidden) = (job.light_paths(6), Progress::hidden());
        let pass = |splats: &mut Splats, paths: Range<u64>| {
            let paths = (std::slice::from_ref(&paths), 0);
            trace(job, (0, &job.sampler), splats, paths, || true, &hidden);
        };
        let mut expected = job.splats().expect("light paths");
        pass(&mut expected, 0..all);
        let camera = tiles(job, None).0.develop();
        for known in [0..0, 0..all, 100..1000] {
            let mut splats = job.splats().expect("light paths");
            pass(&mut splats, known.clone());
            let (film, traced) = tiles(job, Some(&mut splats));
            if known.is_empty() {
                assert_eq!(traced, 20 * 18 * 6);
                // Without a gap, whatever rays the lens lost.
                assert_eq!(splats.paths().ranges().len(), 1);
            }
            assert_eq!(film.develop().pixels, camera.pixels);
            pass(&mut splats, 0..all);
            assert_eq!(splats, expected, "{known:?}");
        }
        let (mut whole, _) = tiles(job, None);
        whole.add_light(&[expected]);
        let exposed = expose(job, 16, &hidden).develop();
        assert_eq!(exposed.pixels, whole.develop().pixels);
    }

    /// Those of a pass are all of its first paths, each once; and those of a pixel one after the other.
    #[test]
    fn each_sample_has_a_path_of_its_own() {
        let job = fog(LENS);
        let tiles = job.lit().tiles(TILE_SIZE).count() as u32;
        let ranges = || (0..tiles).map(|i| i..3 * i + 2);
        let pairing = Pairing::of_pass(&job, ranges()).expect("pairs");
        let (mut found, mut before) = (Vec::new(), 0);
        for (tile, samples) in job.lit().tiles(TILE_SIZE).zip(ranges()) {
            before += tile.area() as u64 * u64::from(samples.start);
            for pixel in tile.pixels() {
                found.extend(samples.clone().map(|sample| pairing.path(pixel, sample)));
            }
        }
        let first = job.light_share.paths(before);
        let expected: Vec<u64> = (first..first + found.len() as u64).collect();
        assert_eq!(found, expected);
    }
}
