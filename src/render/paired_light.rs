//! Light paths that are traced once for two strategies: where every camera path is joined to a light path, that is one of the light pass
//! ([`light_pass`](super::light_pass)), and is joined to the lens as well while tiles are rendered. The light pass leaves it out then. Which path
//! it is depends on the camera sample alone, so that it does not matter for the image who traces it.

use super::light_pass::{keep_now_and_then, new_buffer};
use super::{OfAll, PendingSample, Progress, RenderJob, locked};
use crate::cameras::CameraRay;
use crate::film::{PixelBounds, Splats};
use crate::integrators::{LightJob, Paired, Workspace};
use crate::math::UVec2;
use crate::samplers::Sampler;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

impl RenderJob {
    /// Returns `true` if each camera path is joined to a path of the light pass.
    fn pairs_paths(&self) -> bool {
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

/// Which path of the light pass each camera path is joined to.
pub(super) struct Pairing<'a> {
    sampler: &'a Sampler,
    pixels: PixelBounds,
}

impl<'a> Pairing<'a> {
    /// Of an image, or a half, with these samples; `None` if camera paths are joined to other paths, or not all of them.
    pub(super) fn new(job: &RenderJob, sampler: &'a Sampler) -> Option<Pairing<'a>> {
        let pixels = job.lit();
        job.pairs_paths().then_some(Pairing { sampler, pixels })
    }

    /// The path for this sample: those of a pixel are one after the other, and so well distributed.
    pub(super) fn of(&self, pixel: UVec2, sample: u32) -> Paired<'a> {
        let place = self.pixels.index(pixel).unwrap_or_default() as u64;
        Paired {
            sampler: self.sampler,
            number: place * u64::from(self.sampler.spp()) + u64::from(sample),
        }
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
    /// `None` where there are no such paths, or something else belongs to each.
    pub(super) fn new(
        job: &'a RenderJob,
        (half, splats): (u8, &'a mut Splats),
        progress: &'a Progress,
    ) -> Option<PairedLight<'a>> {
        (job.pairs_paths() && job.ghosts.is_none()).then(|| PairedLight {
            job,
            light_job: job.light_job(),
            half,
            splats: Mutex::new(splats),
            traced: AtomicU64::new(0),
            progress,
        })
    }

    /// What the paths are traced for; there is room for what they bring.
    pub(super) fn begin(&self, workspace: &mut Workspace) -> &LightJob<'a> {
        workspace.splats.get_or_insert_with(|| new_buffer(self.job));
        &self.light_job
    }

    /// These camera samples have been taken, each that has a ray with its light path.
    pub(super) fn take(
        &self,
        workspace: &mut Workspace,
        (samples, rays): (&[PendingSample], &[Option<CameraRay>]),
        all: &OfAll,
    ) {
        let (Some(pairing), Some(buffer)) = (&all.pairing, &mut workspace.splats) else {
            return;
        };
        let with_ray = samples.iter().zip(rays).filter(|(_, ray)| ray.is_some());
        for (sample, _) in with_ray {
            buffer.took(pairing.of(sample.pixel, sample.index).number);
        }
        if buffer.is_full() {
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
            keep_now_and_then(self.half, &splats, self.progress);
        }
    }

    /// How many paths there were.
    pub(super) fn traced(self) -> u64 {
        self.traced.into_inner()
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

    /// A lamp in fog above a floor, through a lens onto a wide filter.
    fn fog() -> RenderJob {
        let text = r#"
            MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .3 .2 .1 ]
            LookAt 0 1 -6  0 0 0  0 1 0
            MediumInterface "" "fog"
            Camera "perspective" "float fov" 50 "float lensradius" .1 "float focaldistance" 6
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
        let file = sources.add_text("fog.pbrt", text.to_string());
        let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
        assert!(!diagnostics.has_errors());
        let frame = scene.frames.into_iter().next().expect("one frame");
        build(frame, 0).0.expect("it can be built").job
    }

    /// The image's camera samples, with `light` beside them.
    fn tiles(job: &RenderJob, light: Option<&PairedLight>) -> Film {
        let film = Mutex::new(Film::new(&job.film));
        each_tile(job, 8, |workspace, tile, bounds| {
            let (own, of) = ((workspace, light), (0, tile, bounds));
            let done = work_of_half(job, &job.sampler, of, own, &Progress::hidden());
            locked(&film).merge(done);
        });
        unlocked(film)
    }

    /// Bits, whoever traces them: the tiles, the light pass, or both some of them, as where a checkpoint has those of some tiles.
    #[test]
    fn paired_paths_bring_the_same_as_in_a_pass_of_their_own() {
        let job = fog();
        assert!(job.pairs_paths());
        let (all, hidden) = (job.light_paths(6), Progress::hidden());
        let pass = |splats: &mut Splats, paths| {
            trace(
                &job,
                (0, &job.sampler),
                splats,
                (paths, 0),
                || true,
                &hidden,
            );
        };
        let mut expected = job.splats().expect("light paths");
        pass(&mut expected, 0..all);
        let camera = tiles(&job, None).develop();
        for known in [0..0, 0..all, 100..1000] {
            let mut splats = job.splats().expect("light paths");
            pass(&mut splats, known.clone());
            let light = PairedLight::new(&job, (0, &mut splats), &hidden).expect("pairs");
            let film = tiles(&job, Some(&light));
            // A lens lets all rays pass.
            let traced = light.traced();
            assert!(traced == 20 * 18 * 6 || !known.is_empty(), "{traced}");
            assert_eq!(film.develop().pixels, camera.pixels);
            pass(&mut splats, 0..all);
            assert_eq!(splats, expected, "{known:?}");
        }
        let mut whole = tiles(&job, None);
        whole.add_light(&[expected]);
        let exposed = expose(&job, 16, &hidden).develop();
        assert_eq!(exposed.pixels, whole.develop().pixels);
    }
}
