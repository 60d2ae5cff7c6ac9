//! The image of a scene: rendered once for each seed, and averaged.

use crate::cli::checkpoint::listen;
use crate::cli::compare::input::{self, Input};
use crate::cli::messages::Failure;
use crate::cli::results;
use crate::film;
use crate::output;
use crate::suite::{
    Placeholder, RunError, Scene, Suite, Values, last_lines, merged, metadata, run,
};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Lines of a command's output that a message shows.
const SHOWN: usize = 6;

/// What renders: a suite, the folder of its results, and whether it is to stop.
pub(super) struct Studio<'a> {
    pub suite: &'a Suite,
    pub output: PathBuf,
    pub stop: Arc<AtomicBool>,
    /// Keeps others from the folder of results.
    _held: Option<File>,
}

impl<'a> Studio<'a> {
    /// Makes the folder of results, `output` or the suite's own, and stops on a signal from now on.
    ///
    /// # Errors
    /// A folder that cannot be made, or that another run writes to.
    pub(super) fn open(suite: &'a Suite, output: Option<&PathBuf>) -> Result<Studio<'a>, Failure> {
        let output = output.unwrap_or(&suite.output);
        let output = std::path::absolute(output).unwrap_or_else(|_| output.clone());
        // The folder that is held, and no file of a user's is in.
        let runs = output.join("runs");
        results::make(&runs)?;
        let held = output::hold(&runs, Duration::ZERO).map_err(|output::InUse| {
            let folder = output.display();
            let message = format!(
                "{folder}: another run writes its results there: give this one a folder of its own (--output)"
            );
            Failure::new(message, true)
        })?;
        check_references(suite, &output)?;
        let studio = Studio {
            suite,
            output,
            stop: Arc::default(),
            _held: held,
        };
        listen(&studio.stop);
        Ok(studio)
    }
}

/// Refuses references that what is rendered would take the place of: an image would be compared with itself.
fn check_references(suite: &Suite, output: &Path) -> Result<(), Failure> {
    let folders = ["images", "references", "runs"].map(|part| output::settled(&output.join(part)));
    for scene in &suite.scenes {
        let reference = output::settled(&scene.reference);
        if folders.iter().any(|folder| reference.starts_with(folder)) {
            let reference = scene.reference.display();
            let message = format!(
                "{reference}: this reference lies where the suite's images are written: keep `references` and `output` apart"
            );
            return Err(message.into());
        }
    }
    Ok(())
}

/// What an image is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// It is tested.
    Image,
    /// It is a new reference.
    Reference,
}

impl Kind {
    fn folder(self) -> &'static str {
        match self {
            Kind::Image => "images",
            Kind::Reference => "references",
        }
    }
}

/// A rendered image.
pub(super) struct Picture {
    pub input: Input,
    /// All runs together.
    pub time: Duration,
}

/// Why there is none.
pub(super) enum NoPicture {
    /// The suite was interrupted.
    Interrupted,
    /// In a few lines.
    Failed(String),
}

impl From<Failure> for NoPicture {
    fn from(failure: Failure) -> NoPicture {
        NoPicture::Failed(failure.text())
    }
}

/// The samples of a pixel that the command is told to take; `None` if it is told nothing.
fn samples(scene: &Scene) -> Option<u32> {
    scene.command.uses(Placeholder::Spp).then_some(scene.spp)
}

impl Studio<'_> {
    /// Renders a scene with each of the seeds, into a folder of the results. The mean is an EXR; a single run is kept as it is, with
    /// the extension of the renderer's images.
    pub(super) fn picture(
        &self,
        scene: &Scene,
        seeds: &[u64],
        kind: Kind,
    ) -> Result<Picture, NoPicture> {
        let file = &self.file(scene, seeds, kind);
        results::make(file.parent().unwrap_or(file))?;
        let (mut runs, mut files, mut time) = (Vec::new(), Vec::new(), Duration::ZERO);
        for &seed in seeds {
            let (input, took) = self.one(scene, seed, kind)?;
            time += took;
            files.push(input.path.clone());
            runs.push(input);
        }
        let input = match <[Input; 1]>::try_from(runs) {
            Ok([only]) => only.renamed(file)?,
            Err(runs) => {
                let mean = merged(runs.into_iter().map(|run| run.loaded).collect());
                let mean = mean.map_err(|e| NoPicture::Failed(e.to_string()))?;
                let seed = seeds.first().copied().unwrap_or_default();
                let noted = metadata(&mean, &scene.file, seed);
                let written = film::write(file, &mean.image, &noted);
                written.map_err(|e| NoPicture::Failed(e.to_string()))?;
                for run in files {
                    // What is left of a mean is of no use, and does no harm.
                    let _ = std::fs::remove_file(run);
                }
                Input::of(file, mean)
            }
        };
        Ok(Picture { input, time })
    }

    /// Where a scene's image is once it has been rendered.
    fn file(&self, scene: &Scene, seeds: &[u64], kind: Kind) -> PathBuf {
        let ending = match seeds.len() {
            1 => scene.extension.as_str(),
            _ => ".exr",
        };
        let folder = self.output.join(kind.folder());
        folder.join(format!("{}{ending}", scene.name))
    }

    /// Where the image is that is tested.
    pub(super) fn image_of(&self, scene: &Scene) -> PathBuf {
        self.file(scene, &scene.seeds, Kind::Image)
    }

    /// One run.
    fn one(&self, scene: &Scene, seed: u64, kind: Kind) -> Result<(Input, Duration), NoPicture> {
        let with = |ending: &str| {
            let name = format!("runs/{}/{}.seed{seed}{ending}", kind.folder(), scene.name);
            self.output.join(name)
        };
        let (image, log) = (with(&scene.extension), with(".log"));
        results::make(image.parent().unwrap_or(&image))?;
        // What an earlier run has left is not what this one writes.
        let _ = std::fs::remove_file(&image);
        let values = Values {
            scene: &scene.file,
            output: &image,
            seed,
            spp: scene.spp,
        };
        let command = scene.command.filled(&values);
        let ran = run(
            &command,
            &self.suite.folder,
            &log,
            scene.timeout,
            &self.stop,
        );
        let said = || match last_lines(&log, SHOWN) {
            lines if lines.is_empty() => {
                format!("it printed nothing; all of it: {}", log.display())
            }
            lines => format!("{lines}\nall of its output: {}", log.display()),
        };
        let time = ran.map_err(|error| match error {
            RunError::Interrupted => NoPicture::Interrupted,
            RunError::Start { .. } => NoPicture::Failed(error.to_string()),
            _ => NoPicture::Failed(format!("{error}\n{}", said())),
        })?;
        if !image.is_file() {
            let place = image.display();
            return Err(NoPicture::Failed(format!(
                "the command ended well, but wrote no image to {place}\n{}",
                said()
            )));
        }
        let read = input::read(&image);
        let mut input = read
            .map_err(|e| NoPicture::Failed(format!("the command wrote no image: {}", e.text())))?
            .plain();
        if input.srgb {
            return Err(NoPicture::Failed(
                "the command wrote an image for a screen (8 or 16 bits, sRGB), which has no noise to compare: have it write \
                 linear light as an EXR"
                    .to_owned(),
            ));
        }
        input.loaded.spp = input.loaded.spp.or(samples(scene));
        Ok((input, time))
    }

    /// The image that is tested, read anew.
    pub(super) fn again(&self, scene: &Scene) -> Result<Input, Failure> {
        let mut input = input::read(&self.image_of(scene))?.plain();
        if scene.seeds.len() == 1 {
            input.loaded.spp = input.loaded.spp.or(samples(scene));
        }
        Ok(input)
    }
}
