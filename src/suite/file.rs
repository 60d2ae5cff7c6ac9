//! Suite files: TOML, every mistake with its line.

use super::command::{Placeholder, Template, TemplateError};
use super::references::is_hash;
use super::tables::{FileTable, RendererTable, SceneTable, SuiteTable};
use crate::compare::{Correction, Noise, Options};
use crate::files;
use crate::session::{Policy, Problems};
use crate::syntax::suggest::nearest;
use crate::syntax::{Diagnostic, Diagnostics, FileId, SourceMap, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;
use toml::{Spanned, Value};

/// A suite, with all defaults filled in.
#[derive(Clone, Debug)]
pub struct Suite {
    /// For people.
    pub name: String,
    /// The file it was read from.
    pub file: PathBuf,
    /// The folder of that file: names in it are relative to this, and commands run here.
    pub folder: PathBuf,
    /// Where images and reports go.
    pub output: PathBuf,
    /// Where the references are.
    pub references: PathBuf,
    /// The file that counts the commits, if the false-alarm rate is shared among them.
    pub commits: Option<PathBuf>,
    /// How images are compared; `alpha` is that of all together.
    pub options: Options,
    /// In the file's order.
    pub scenes: Vec<Scene>,
}

/// What is rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The image's name, with `/` between folders and without an extension.
    pub name: String,
    /// The scene's file, as the suite names it.
    pub file: String,
    /// The renderer's command line.
    pub command: Template,
    /// Of the images, with its dot.
    pub extension: String,
    /// Samples per pixel.
    pub spp: u32,
    /// One render each for the image that is tested.
    pub seeds: Vec<u64>,
    /// One render each for the reference that `--update` makes.
    pub baseline_seeds: Vec<u64>,
    /// The longest that one render may take.
    pub timeout: Duration,
    /// The reference's file.
    pub reference: PathBuf,
    /// The hash that the suite file says the reference has, and its place there.
    pub sha256: Option<(String, Range<usize>)>,
}

/// A suite file is text of people: one beyond this is something else.
const LARGEST: u64 = 16 << 20;

/// Seeds of a reference unless the suite says otherwise: four halve its standard error, and the variance of a difference from one image is
/// then 5/8 of what it would be with one seed.
const BASELINE_RUNS: u64 = 4;

impl Suite {
    /// Reads a suite file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line.
    pub fn read(path: &Path) -> Result<Suite, Problems> {
        let (sources, problems) = (SourceMap::new(), Diagnostics::new());
        let bytes = files::read(path, LARGEST).map_err(|problem| {
            let message = format!("cannot read `{}`: {problem}", path.display());
            problems.push(Diagnostic::error(message).failed_if(problem.is_failure()));
            Problems::new(&problems, &sources, Policy::Errors)
        })?;
        let file = sources.add_text(&path.display().to_string(), bytes.clone());
        let reader = Reader {
            file,
            problems: &problems,
            path,
        };
        let suite = reader.text(&bytes).and_then(|text| reader.suite(text));
        match suite.filter(|_| !problems.has_errors()) {
            Some(suite) => Ok(suite),
            None => Err(Problems::new(&problems, &sources, Policy::Errors)),
        }
    }

    /// A path of the suite file.
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.join(name)
    }
}

/// Reads, and collects what is wrong.
struct Reader<'a> {
    file: FileId,
    problems: &'a Diagnostics,
    path: &'a Path,
}

impl Reader<'_> {
    fn at(&self, bytes: Range<usize>) -> Span {
        let place = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        self.file.span(place(bytes.start)..place(bytes.end))
    }

    fn error(&self, at: Range<usize>, message: impl Into<String>) {
        let error = Diagnostic::error(message).at(self.at(at));
        self.problems.push(error);
    }

    fn text<'b>(&self, bytes: &'b [u8]) -> Option<&'b str> {
        let checked = std::str::from_utf8(bytes);
        if let Err(error) = checked {
            let at = error.valid_up_to();
            self.error(at..at + 1, "this is not UTF-8 text");
        }
        checked.ok()
    }

    fn suite(&self, text: &str) -> Option<Suite> {
        let refuse = |error: &_| self.refuse(text, error);
        let tables = FileTable::parse(text, self.problems, refuse)?;
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        // Commands are told where to write wherever they run.
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        let settings = &tables.suite;
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let options = self.options(settings);
        let commands = self.commands(&tables.renderer);
        // Of each suite its own: the hashes there are of this one's scenes.
        let references = format!("{stem}-references");
        let references = settings.references.as_ref().unwrap_or(&references);
        let mut suite = Suite {
            name: settings.name.clone().unwrap_or_else(|| stem.to_string()),
            file: self.path.to_owned(),
            output: match &settings.output {
                Some(output) => folder.join(output),
                None => folder.join(format!("{stem}-results")),
            },
            references: folder.join(references),
            commits: settings.commits.as_ref().map(|file| folder.join(file)),
            folder,
            options,
            scenes: Vec::new(),
        };
        if tables.scene.is_empty() && tables.is_complete {
            let help = "[[scene]]\nfile = \"scene.pbrt\"";
            let error = Diagnostic::error("the suite has no scenes").with_help(help);
            self.problems.push(error.at(self.at(0..0)));
        }
        let mut names = BTreeSet::new();
        for table in &tables.scene {
            let scene = self.scene(table, &tables, &commands, &suite);
            let Some(scene) = scene else { continue };
            // Names of files that differ in case only are one on some systems.
            if !names.insert(scene.name.to_lowercase()) {
                let place = { table.get_ref().name.as_ref() }
                    .map_or_else(|| table.get_ref().file.span(), Spanned::span);
                let message = format!("there are two scenes named `{}`", scene.name);
                let error = Diagnostic::error(message).at(self.at(place));
                self.problems
                    .push(error.with_help("give one of them a `name`"));
            }
            suite.scenes.push(scene);
        }
        Some(suite)
    }

    /// What TOML itself, or the shape of the tables, forbids.
    fn refuse(&self, text: &str, error: &toml::de::Error) {
        let at = error.span().unwrap_or(text.len()..text.len());
        let message = error.message().lines().next().unwrap_or("this is no TOML");
        let diagnostic = Diagnostic::error(message.to_owned()).at(self.at(at));
        let mut words = message.split('`').skip(1).step_by(2);
        let wrong = words
            .next()
            .filter(|_| message.starts_with("unknown field"));
        let meant = wrong.and_then(|wrong| nearest(wrong, words));
        self.problems.push(diagnostic.with_suggestion(meant));
    }

    fn options(&self, table: &SuiteTable) -> Options {
        let mut options = Options {
            alpha: 0.01,
            ..Options::default()
        };
        let in_range = |value: &Option<Spanned<f64>>, range: fn(f64) -> bool, expected: &str| {
            let value = value.as_ref()?;
            let is_right = range(*value.get_ref());
            if !is_right {
                self.error(value.span(), format!("expected {expected}"));
            }
            is_right.then_some(*value.get_ref())
        };
        let probability = "a probability above 0 and below 1";
        if let Some(alpha) = in_range(&table.alpha, |p| p > 0.0 && p < 1.0, probability) {
            options.alpha = alpha;
        }
        let fraction = "a fraction from 0 to 1";
        if let Some(tolerance) = in_range(&table.tolerance, |x| (0.0..=1.0).contains(&x), fraction)
        {
            options.relative_tolerance = tolerance;
        }
        let corrections = [("holm", Correction::Holm), ("sidak", Correction::Sidak)];
        options.correction = self.one_of(&table.correction, corrections, options.correction);
        let noises = [
            ("auto", Noise::Auto),
            ("stored", Noise::Stored),
            ("spatial", Noise::Spatial),
            ("none", Noise::None),
        ];
        options.noise = self.one_of(&table.noise, noises, options.noise);
        if let Some(blocks) = &table.blocks {
            if blocks.get_ref().iter().any(|&side| side < 2) {
                self.error(blocks.span(), "sides of blocks are 2 pixels or more");
            }
            options.blocks = [1].iter().chain(blocks.get_ref()).copied().collect();
        }
        options.cell = self.positive(table.cell.as_ref()).unwrap_or(options.cell);
        options
    }

    fn one_of<T: Copy, const N: usize>(
        &self,
        word: &Option<Spanned<String>>,
        known: [(&str, T); N],
        default: T,
    ) -> T {
        let Some(word) = word else { return default };
        let found = known.iter().find(|(name, _)| name == word.get_ref());
        if found.is_none() {
            let names = known.map(|(name, _)| name);
            let message = format!("`{}` is none of {}", word.get_ref(), names.join(", "));
            let error = Diagnostic::error(message).at(self.at(word.span()));
            self.problems
                .push_with_nearest(error, word.get_ref(), names);
        }
        found.map_or(default, |(_, value)| *value)
    }

    fn positive(&self, number: Option<&Spanned<u32>>) -> Option<u32> {
        let number = number?;
        if *number.get_ref() == 0 {
            self.error(number.span(), "expected 1 or more");
        }
        Some(*number.get_ref().max(&1))
    }

    /// The renderers that can be understood, and the names of all.
    fn commands(
        &self,
        tables: &BTreeMap<String, RendererTable>,
    ) -> BTreeMap<String, Option<(Template, String)>> {
        let read = |table: &RendererTable| {
            let (value, at) = (table.command.get_ref(), table.command.span());
            let words = |words: &Vec<Value>| -> Option<Vec<String>> {
                { words.iter() }
                    .map(|word| Some(word.as_str()?.to_owned()))
                    .collect()
            };
            let template = match value {
                Value::String(line) => Template::of_line(line),
                Value::Array(array) if words(array).is_some() => {
                    Template::of_words(&words(array).unwrap_or_default())
                }
                _ => Err(TemplateError {
                    message: "expected a command line, or a list of its words".to_owned(),
                    help: None,
                }),
            };
            let extension = self.extension(table.extension.as_ref());
            match template {
                Ok(template) => Some((template, extension)),
                Err(TemplateError { message, help }) => {
                    let mut error = Diagnostic::error(message).at(self.at(at));
                    error.help.extend(help);
                    self.problems.push(error);
                    None
                }
            }
        };
        { tables.iter() }
            .map(|(name, table)| (name.clone(), read(table)))
            .collect()
    }

    fn extension(&self, given: Option<&Spanned<String>>) -> String {
        const KNOWN: [&str; 3] = [".exr", ".pfm", ".hdr"];
        let Some(given) = given else {
            return ".exr".to_owned();
        };
        let dotted = format!(".{}", given.get_ref().trim_start_matches('.'));
        if !KNOWN.contains(&dotted.as_str()) {
            let all = KNOWN.join(", ");
            self.error(given.span(), format!("images of linear light end in {all}"));
        }
        dotted
    }

    fn scene(
        &self,
        table: &Spanned<SceneTable>,
        tables: &FileTable,
        commands: &BTreeMap<String, Option<(Template, String)>>,
        suite: &Suite,
    ) -> Option<Scene> {
        let (settings, own, place) = (&tables.suite, table.get_ref(), table.span());
        let file = own.file.get_ref().clone();
        if !suite.path(&file).is_file() {
            let message = format!("there is no file `{file}` beside the suite");
            self.error(own.file.span(), message);
        }
        let name = match &own.name {
            Some(name) => self.name(name.get_ref().clone(), name.span()),
            None => self.name(name_of(&file), own.file.span()),
        };
        let renderer = own.renderer.as_ref().or(settings.renderer.as_ref());
        let found = self.renderer(renderer, place, commands, tables.is_complete);
        let renderer = found.cloned().flatten();
        let sha256 = own.sha256.as_ref().map(|sum| self.sum(sum));
        let spp = self.positive(own.spp.as_ref().or(settings.spp.as_ref()));
        let timeout = self.timeout(own.timeout.as_ref().or(settings.timeout.as_ref()));
        // What is wrong with the other fields has been said above.
        let (name, (command, extension)) = name.zip(renderer)?;
        let seeds = own.seeds.as_ref().or(settings.seeds.as_ref());
        let baseline = own
            .baseline_seeds
            .as_ref()
            .or(settings.baseline_seeds.as_ref());
        let (seeds, baseline_seeds) = self.seeds(&command, seeds, baseline);
        let reference = match &own.reference {
            Some(reference) => suite.path(reference),
            None => suite.references.join(format!("{name}.exr")),
        };
        Some(Scene {
            reference,
            sha256,
            spp: spp.unwrap_or(64),
            timeout,
            name,
            file,
            command,
            extension,
            seeds,
            baseline_seeds,
        })
    }

    /// The name of an image: of files below one folder, on every system.
    fn name(&self, name: String, at: Range<usize>) -> Option<String> {
        let is_plain = |part: &str| {
            let is_bad = |c: char| c.is_control() || "<>:\"|?*\\".contains(c);
            !part.is_empty() && !part.contains(is_bad) && ![".", ".."].contains(&part)
        };
        let is_good = name.split('/').all(is_plain);
        if !is_good {
            let message = format!("`{}` cannot name an image's files", name.escape_debug());
            let error = Diagnostic::error(message).at(self.at(at));
            let help = "give the scene a `name` such as `glass/prism`, without an extension";
            self.problems.push(error.with_help(help));
        }
        is_good.then_some(name)
    }

    fn renderer<'b>(
        &self,
        name: Option<&Spanned<String>>,
        place: Range<usize>,
        commands: &'b BTreeMap<String, Option<(Template, String)>>,
        is_complete: bool,
    ) -> Option<&'b Option<(Template, String)>> {
        if let Some(name) = name {
            let found = commands.get(name.get_ref());
            if found.is_none() && is_complete {
                let message = format!("there is no renderer `{}`", name.get_ref());
                let error = Diagnostic::error(message).at(self.at(name.span()));
                let known = commands.keys().map(String::as_str);
                self.problems
                    .push_with_nearest(error, name.get_ref(), known);
            }
            return found;
        }
        let mut all = commands.values();
        match (all.next(), all.next()) {
            (Some(only), None) => Some(only),
            (None, _) if !is_complete => None,
            (None, _) => {
                let error = Diagnostic::error("the suite has no renderer").at(self.at(place));
                let help = "[renderer.fstop]\ncommand = \"{fstop} render {scene} -o {output} --seed {seed} --spp {spp} --variance\"";
                self.problems.push(error.with_help(help));
                None
            }
            _ => {
                let message =
                    "there are several renderers: say which one renders the scene (`renderer = …`)";
                self.error(place, message);
                None
            }
        }
    }

    /// Seeds of the image and of its reference, which must not share their noise.
    fn seeds(
        &self,
        command: &Template,
        seeds: Option<&Spanned<Vec<u64>>>,
        baseline: Option<&Spanned<Vec<u64>>>,
    ) -> (Vec<u64>, Vec<u64>) {
        for given in [seeds, baseline].into_iter().flatten() {
            let unique: BTreeSet<&u64> = given.get_ref().iter().collect();
            if given.get_ref().is_empty() {
                self.error(given.span(), "expected at least one seed");
            } else if unique.len() < given.get_ref().len() {
                self.error(
                    given.span(),
                    "a seed is there twice: both runs would be the same image",
                );
            } else if unique.len() > 1 && !command.uses(Placeholder::Seed) {
                self.error(
                    given.span(),
                    "the command has no {seed}: all runs would be the same image",
                );
            }
        }
        let own = seeds.map_or_else(|| vec![1], |seeds| seeds.get_ref().clone());
        let first = own.iter().max().map_or(1, |most| most.saturating_add(1));
        let made = match command.uses(Placeholder::Seed) {
            true => (first..first.saturating_add(BASELINE_RUNS)).collect(),
            false => own.clone(),
        };
        let theirs = baseline.map_or(made, |baseline| baseline.get_ref().clone());
        let shared = theirs.iter().find(|seed| own.contains(seed));
        if let (Some(seed), Some(place), true) =
            (shared, baseline.or(seeds), command.uses(Placeholder::Seed))
        {
            let message =
                format!("image and reference share the seed {seed}: their noise would be the same");
            self.error(place.span(), message);
        }
        (own, theirs)
    }

    fn timeout(&self, seconds: Option<&Spanned<f64>>) -> Duration {
        let default = Duration::from_secs(3600);
        let Some(seconds) = seconds else {
            return default;
        };
        let time = Duration::try_from_secs_f64(*seconds.get_ref()).ok();
        let time = time.filter(|time| !time.is_zero());
        if time.is_none() {
            self.error(seconds.span(), "expected a positive number of seconds");
        }
        time.unwrap_or(default)
    }

    fn sum(&self, sum: &Spanned<String>) -> (String, Range<usize>) {
        if !is_hash(sum.get_ref()) {
            self.error(
                sum.span(),
                "a SHA-256 has 64 hexadecimal digits (`sha256sum FILE`)",
            );
        }
        (sum.get_ref().to_ascii_lowercase(), sum.span())
    }
}

/// A scene's name by its file: without an extension, and without what leads out of the suite's folder.
fn name_of(file: &str) -> String {
    let path = Path::new(file).with_extension("");
    let normal = path.components().filter_map(|part| match part {
        Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
        _ => None,
    });
    normal.collect::<Vec<_>>().join("/")
}
