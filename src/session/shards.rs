//! Shards: equal parts of a render, each in a file of its own, that `merge` makes one image of.

use super::{Frame, Prepared, Problems, RenderOptions, on_threads, rendered};
use crate::checkpoint::{
    CheckpointError, Contents, Facts, FilmFacts, GoalFacts, Identity, Journal, Keep, Plan,
    PlanError, Shard,
};
use crate::render::{self, Division, Goal, LightOfShard, Pass, Progress, Step};
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Which shards of a render a process is to make.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Shards {
    /// Each with its file.
    pub files: Vec<ShardFile>,
    /// The longest time whose work may be lost.
    pub every: Duration,
    /// With an error for a goal: what `merge` has planned, but for the first round.
    pub plan: Option<PathBuf>,
}

/// One shard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardFile {
    /// Which, from 1.
    pub number: u32,
    /// Of how many.
    pub of: u32,
    /// Its file.
    pub path: PathBuf,
}

/// Why a shard is not rendered.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// Its file is of something else, or cannot be made or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// It has no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The plan is not one for this image, or not the one that the shard has followed.
    #[error("{}: this plan is not that of the shard's earlier rounds: remove the shard's file, or plan anew", .0.display())]
    Passes(PathBuf),
    /// A time is no goal for shards.
    #[error(
        "--time cannot be divided into shards: give each as many samples (--spp), or an error (--error)"
    )]
    Time,
    /// Photons belong to all pixels.
    #[error(
        "--shard: an image by `sppm` cannot be divided, as all its pixels share their photons: render it whole, or \
         several with different seeds (--seed), whose mean has less noise"
    )]
    Photons,
}

impl ShardError {
    /// Returns `true` if it might be rendered on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            ShardError::Checkpoint(error) => error.is_failure(),
            ShardError::Plan(error) => error.is_failure(),
            ShardError::Passes(_) | ShardError::Time | ShardError::Photons => false,
        }
    }
}

impl Shards {
    /// The largest number of shards of a render.
    pub const MOST: u32 = Shard::MOST;

    /// Of these files.
    pub fn new(files: Vec<ShardFile>, every: Duration) -> Shards {
        let plan = None;
        Shards { files, every, plan }
    }

    /// The passes after the first.
    fn planned(&self, of: &Identity) -> Result<Vec<[Vec<u32>; 2]>, PlanError> {
        let of = of.of_all_shards();
        let plan = self.plan.as_ref().map(|path| Plan::read(path, &of));
        Ok(plan
            .transpose()?
            .map(|plan| plan.passes)
            .unwrap_or_default())
    }
}

/// Those of a process's shards that are not finished.
#[derive(Clone, Debug)]
pub struct Unfinished {
    files: Vec<ShardFile>,
    every: Duration,
    /// Passes after the first.
    planned: Vec<[Vec<u32>; 2]>,
}

impl Unfinished {
    /// Their files.
    pub fn files(&self) -> &[ShardFile] {
        &self.files
    }
}

impl ShardFile {
    fn shard(&self) -> Shard {
        let ShardFile { number, of, .. } = *self;
        Shard { number, of }
    }
}

impl Frame {
    /// Refuses a frame that cannot be rendered in shards with these options, as far as is known before its files are loaded.
    pub(crate) fn check_shards(mut self, options: &RenderOptions) -> Result<(), Problems> {
        let divisible = self.is_divisible(options);
        let settled = divisible.and_then(|()| self.apply_options(options));
        settled.map(drop).map_err(Problems::one)
    }

    fn is_divisible(&self, options: &RenderOptions) -> Result<(), String> {
        if options.time.is_some() {
            return Err(ShardError::Time.to_string());
        }
        match self.frame.options.integrator.spec.gathers_photons() {
            true => Err(ShardError::Photons.to_string()),
            false => Ok(()),
        }
    }

    /// The shards that are not finished. Found without loading the scene's meshes and images.
    ///
    /// # Errors
    /// A plan that cannot be used; a goal that cannot be divided.
    pub fn unfinished(
        &self,
        shards: &Shards,
        options: &RenderOptions,
    ) -> Result<Unfinished, Problems> {
        self.is_divisible(options).map_err(Problems::one)?;
        let film = options.film(&self.frame.options.film);
        let mut film = film.map_err(Problems::one)?;
        film.layers = self.frame.layers(film.layers);
        let identity = self.about.identity(&film, options)();
        let planned = shards.planned(&identity);
        let planned =
            planned.map_err(|error| Problems::one_if(error.to_string(), error.is_failure()))?;
        let passes = planned.len() as u32 + 1;
        let is_unfinished = |file: &&ShardFile| {
            let found = file
                .path
                .is_file()
                .then(|| File::open(&file.path).ok())
                .flatten();
            let found = found.and_then(|found| Contents::read(BufReader::new(found)).ok()?);
            found.is_none_or(|found| {
                let is_ours = with_shard(&identity, file.shard()) == found.identity;
                !is_ours || found.passes_done.is_none_or(|done| done < passes)
            })
        };
        Ok(Unfinished {
            files: shards.files.iter().filter(is_unfinished).cloned().collect(),
            every: shards.every,
            planned,
        })
    }
}

impl Prepared {
    /// Renders what the file of a shard does not have yet. `progress` is called now and then, by any of the threads.
    /// Returns `false` if it was stopped.
    ///
    /// # Errors
    /// A file of something else, or one that cannot be written: what is in it stays, and is continued another time.
    pub fn render_shard(
        &self,
        file: &ShardFile,
        rest: &Unfinished,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<bool, ShardError> {
        let render = || self.shard(file, rest, progress);
        on_threads(self.options.threads, render).unwrap_or_else(|_| render())
    }

    fn shard(
        &self,
        file: &ShardFile,
        rest: &Unfinished,
        report: &(dyn Fn(Step) + Sync),
    ) -> Result<bool, ShardError> {
        let shard = file.shard();
        let job = &self.scene.job;
        let bounds = job.film.pixel_bounds().intersection(job.sampled);
        let goal = self.options.goal();
        let spp = goal.is_none().then(|| job.sampler.spp());
        let division = Division::new(bounds, spp, shard.of);
        let unfit = || ShardError::Passes(file.path.clone());
        let passes = match &goal {
            Some(goal) if goal.time.is_some() => return Err(ShardError::Time),
            Some(goal) => render::passes(bounds, goal, &rest.planned).ok_or_else(unfit)?,
            None => vec![division.whole(&counts(job.sampler.spp(), self.is_halved()))],
        };
        let journal = self.journal_of(file, rest.every, goal.as_ref())?;
        for (number, counts) in (1..).zip(&rest.planned) {
            match journal.plan(number) {
                None => journal.planned(number, counts),
                Some(followed) if followed == counts => {}
                Some(_) => return Err(unfit()),
            }
        }
        let samples = |pass: &Pass| -> u64 {
            let pieces = division.pieces_by(shard, pass);
            pieces
                .map(|p| p.bounds.area() as u64 * p.unit.samples.len() as u64)
                .sum()
        };
        let paths = |pass: &Pass| -> u64 {
            let how = (job.splat_share(), job.pairs_paths());
            let halves = (0..pass.len()).filter(|_| job.has_splats());
            let of_half = |half| render::count_paths(&division.light(shard, (half, pass), how));
            halves.map(of_half).sum()
        };
        let all = passes.iter().map(|pass| samples(pass) + paths(pass)).sum();
        let stop = self.options.stop.as_deref();
        let progress = Progress::new(all, report).kept(Some(&journal), stop);
        let halves = passes.first().map_or(0, Vec::len);
        let mut light = LightOfShard::restored(job, halves, &progress);
        let render =
            |pass| render::render_shard(job, &division, shard, pass, &mut light, &progress);
        let is_whole = passes.iter().all(render);
        light.keep(&journal);
        if is_whole {
            journal.done(passes.len() as u32);
        }
        match journal.flush() {
            (_, Some(error)) => Err(error.into()),
            (_, None) => Ok(is_whole),
        }
    }

    fn is_halved(&self) -> bool {
        self.options.variance && self.scene.job.sampler.is_halved()
    }

    fn journal_of(
        &self,
        file: &ShardFile,
        every: Duration,
        goal: Option<&Goal>,
    ) -> Result<Journal, CheckpointError> {
        let shard = file.shard();
        let job = &self.scene.job;
        let of_all = Arc::clone(&self.identity);
        let identity: Arc<dyn Fn() -> Identity + Send + Sync> =
            Arc::new(move || with_shard(&of_all(), shard));
        let facts = Facts {
            shard,
            film: FilmFacts::of(&job.film),
            sampled: [job.sampled.min, job.sampled.max],
            metadata: rendered::metadata(&self.scene, &self.name, &self.options),
            spp: job.sampler.spp(),
            goal: goal.map(|goal| GoalFacts {
                error: goal.error.unwrap_or_default(),
                confidence: goal.confidence,
                max_spp: goal.max_spp,
            }),
            halved: goal.is_none() && self.is_halved(),
            are_dependent: job.sampler.is_dependent(),
            splats: { job.splat_scale() }.map(|scale| (scale, job.splat_share())),
            are_paired: job.pairs_paths(),
        };
        Journal::open(&Keep {
            path: &file.path,
            identity: &identity,
            facts: Some(&facts),
            after: Duration::ZERO,
            every,
        })
    }
}

/// Samples of a pixel in the one set, or in each half.
pub(super) fn counts(spp: u32, halved: bool) -> Vec<u32> {
    match halved {
        true => vec![spp.div_ceil(2), spp / 2],
        false => vec![spp],
    }
}

fn with_shard(identity: &Identity, shard: Shard) -> Identity {
    let mut identity = identity.of_all_shards();
    let key = Identity::SHARD.to_string();
    identity.settings.insert(key, shard.to_string());
    identity
}
