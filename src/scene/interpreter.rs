//! The scene interpreter, a state machine: turns directives into frames.

use super::blocks::{Block, block_of};
use super::description::{Frame, SceneDescription};
use super::dialect::{DialectChoice, Evidence, INCLUDE_IN_LIST, is_v2_only};
use super::media::NamedMedia;
use super::names::Names;
use super::options::{Options, StoredDirective, StoredOptions};
use super::reading::Reading;
use super::scopes::{Current, Scope, Scopes};
use super::transforms::{Ctm, Placement};
use super::unused_transforms::UnusedTransform;
use super::world_block::WorldBlock;
use crate::cameras::{CameraChoices, Compat};
use crate::integrators::IntegratorSettings;
use crate::math::DVec3;
use crate::math::transform::Transform;
use crate::optics::models::ModelKind;
use crate::params::{Dialect, SpectrumFiles, TextureNames};
use crate::syntax::{
    Diagnostic, Diagnostics, Directive, DirectiveKind, FileId, Name, Parser, SearchFolder,
    SourceMap, Span, Typed,
};
use std::collections::HashMap;

/// Command-line settings for reading a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadSettings {
    /// `--dialect`.
    pub dialect: DialectChoice,
    /// `--compat`.
    pub compat: Option<Compat>,
    /// `--lens-model`.
    pub lens_model: Option<ModelKind>,
    /// `--f-number` and `--focus-point`.
    pub camera: CameraChoices,
    /// `check --verbose`: also report what only affects noise.
    pub details: bool,
    /// `--max-memory`, in bytes.
    pub max_memory: Option<u64>,
}

/// Reads a whole scene file with its includes. The scene contains everything that could be understood, and can be
/// rendered only if there are no errors among the diagnostics.
pub fn read_scene(
    sources: &SourceMap,
    main: FileId,
    settings: &ReadSettings,
) -> (SceneDescription, Diagnostics) {
    let diagnostics = Diagnostics::new();
    let mut interpreter = Interpreter::new(sources, main, settings, &diagnostics);
    let Err(MustRestart { reason }) = interpreter.run(main) else {
        let scene = interpreter.finish();
        return (scene, diagnostics);
    };
    // A directive that only pbrt-v2 has appeared inside the world, after parameters had been read as pbrt-v3: read
    // everything again as v2.
    let diagnostics = Diagnostics::new();
    let settings = ReadSettings {
        dialect: DialectChoice::Fixed(Dialect::V2),
        ..*settings
    };
    let mut interpreter = Interpreter::new(sources, main, &settings, &diagnostics);
    interpreter.announce(&reason);
    // With a fixed dialect there is no reason to restart.
    let _ = interpreter.run(main);
    let scene = interpreter.finish();
    (scene, diagnostics)
}

/// Signals that the file turned out to be pbrt-v2.
pub(super) struct MustRestart {
    /// The reason.
    reason: String,
}

/// The interpreter's state and results so far.
pub(super) struct Interpreter<'a> {
    sources: &'a SourceMap,
    pub(super) diagnostics: &'a Diagnostics,
    search: SearchFolder,
    spectra: SpectrumFiles,
    settings: ReadSettings,
    dialect: Dialect,
    evidence: Evidence,
    announced: bool,
    frames: Vec<Frame>,
    pub(super) current: Current,
    pub(super) scopes: Scopes,
    coordinate_systems: HashMap<String, Ctm>,
    pub(super) options: StoredOptions,
    pub(super) unused_transform: UnusedTransform,
    pub(super) media: NamedMedia,
    pub(super) world: Option<WorldBlock>,
    /// `true` if a world block has been closed, valid or not.
    had_world: bool,
}

impl<'a> Interpreter<'a> {
    fn new(
        sources: &'a SourceMap,
        main: FileId,
        settings: &ReadSettings,
        diagnostics: &'a Diagnostics,
    ) -> Interpreter<'a> {
        Interpreter {
            sources,
            diagnostics,
            search: sources.search_folder(main),
            spectra: SpectrumFiles::default(),
            settings: *settings,
            dialect: match settings.dialect {
                DialectChoice::Fixed(dialect) => dialect,
                DialectChoice::Auto => Dialect::V3,
            },
            evidence: Evidence::default(),
            announced: false,
            frames: Vec::new(),
            current: Current::new(),
            scopes: Scopes::default(),
            coordinate_systems: HashMap::new(),
            options: StoredOptions::default(),
            unused_transform: UnusedTransform::default(),
            media: NamedMedia::default(),
            world: None,
            had_world: false,
        }
    }

    /// Reports, once, that the file is read as pbrt-v2 and why.
    fn announce(&mut self, reason: &str) {
        if !self.announced {
            let message = format!("read as a pbrt-v2 scene: {reason} (--dialect v3 overrides)");
            self.diagnostics.push(Diagnostic::note(message));
            self.announced = true;
        }
    }

    fn run(&mut self, main: FileId) -> Result<(), MustRestart> {
        let (sources, diagnostics) = (self.sources, self.diagnostics);
        let mut parser = Parser::new(sources, main, diagnostics);
        loop {
            parser.commas_separate = self.dialect == Dialect::V2;
            let Some(directive) = parser.next() else {
                return Ok(());
            };
            self.directive(directive)?;
        }
    }

    /// Finishes reading: open blocks are reported, and checked all the same.
    fn finish(mut self) -> SceneDescription {
        if let Some(world) = &self.world {
            let assumed = world.assumed;
            if assumed {
                self.diagnostics.push(Diagnostic::error(
                    "no `WorldBegin` follows: nothing is rendered",
                ));
            } else {
                self.diagnostics.push(
                    Diagnostic::error("the file ends inside the world block; nothing is rendered")
                        .at(world.opened)
                        .label("the block begins here")
                        .with_help("add `WorldEnd` at the end (pbrt-v4's scenes have none)"),
                );
                self.diagnostics.looks_like_v4();
            }
            // Its contents are checked like any other; errors keep it from being rendered.
            let frame = self.close_world().filter(|_| !assumed);
            self.frames.extend(frame);
        } else if !self.had_world {
            drop(self.read_options());
            if self.diagnostics.errors() == self.diagnostics.recoverable_errors() {
                let message = "the file describes no image: there is no `WorldBegin` … `WorldEnd`";
                self.diagnostics.push(Diagnostic::error(message));
            }
        }
        SceneDescription {
            frames: self.frames,
            dialect: self.dialect,
        }
    }

    pub(super) fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Reports a recoverable error, after which pbrt-v3 continues too.
    pub(super) fn error(&self, span: Span, message: impl Into<String>) {
        self.diagnostics
            .push(Diagnostic::error(message).at(span).recoverable());
    }

    pub(super) fn warn(&self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::warning(message).at(span));
    }

    /// A context for reading parameters with the given textures in scope.
    pub(super) fn reading<'b>(&'b self, textures: &'b TextureNames) -> Reading<'b> {
        Reading::new(
            &self.search,
            self.dialect,
            self.diagnostics,
            &self.spectra,
            textures,
        )
    }

    fn directive(&mut self, directive: Directive) -> Result<(), MustRestart> {
        let Directive {
            span,
            kind,
            include_in_list,
        } = directive;
        if !self.allowed_here(&kind, span) {
            return Ok(());
        }
        self.learn_dialect(&kind, span)?;
        if let Some(include) = include_in_list {
            self.learn_from_include(include)?;
        }
        if self.world.is_none() {
            self.unused_transform.note(&kind, span);
        }
        let word = kind.word();
        let stored = |typed| Some(StoredDirective { word, span, typed });
        use DirectiveKind as D;
        match kind {
            D::Identity => self.transform(|_| Transform::IDENTITY),
            D::Translate(t) => self.transform(|m| *m * Transform::translate(t)),
            D::Scale(s) => self.flattening_transform(span, |m| *m * Transform::scale(s)),
            D::Rotate { degrees, axis } => self.rotate(span, degrees, axis),
            D::LookAt { eye, look, up } => self.look_at(span, eye, look, up),
            D::Transform(m) => self.flattening_transform(span, |_| Transform::from_matrix(*m)),
            D::ConcatTransform(m) => {
                self.flattening_transform(span, |ctm| *ctm * Transform::from_matrix(*m));
            }
            D::CoordinateSystem(name) => {
                self.coordinate_systems
                    .insert(name.text, self.current.ctm.clone());
            }
            D::CoordSysTransform(name) => self.restore_coordinate_system(&name),
            D::ActiveTransform(which) => self.current.active = which,
            D::TransformTimes(start, end) => self.options.transform_times = [start, end],
            D::TransformBegin => self.scopes.open(Scope::Transform, span, &mut self.current),
            D::TransformEnd => self.end_scope(Scope::Transform, span),
            D::AttributeBegin => self.scopes.open(Scope::Attribute, span, &mut self.current),
            D::AttributeEnd => self.end_scope(Scope::Attribute, span),
            D::PixelFilter(typed) => self.options.filter = stored(typed),
            D::Film(typed) => self.options.film = stored(typed),
            D::Sampler(typed) => self.options.sampler = stored(typed),
            D::Accelerator(typed) => self.options.accelerator = stored(typed),
            D::Integrator(typed) | D::SurfaceIntegrator(typed) => {
                self.options.integrator = stored(typed);
            }
            D::Renderer(typed) => self.options.renderer = stored(typed),
            D::Camera(typed) => {
                let camera_to_world = Ctm {
                    start: self.current.ctm.start.inverted(),
                    end: self.current.ctm.end.inverted(),
                };
                let name = "camera".to_string();
                self.coordinate_systems.insert(name, camera_to_world);
                self.options.camera = stored(typed);
                self.options.camera_ctm = self.current.ctm.clone();
            }
            D::VolumeIntegrator(typed) => self.options.volume_integrator = stored(typed),
            D::Volume(typed) => self.volume(span, &typed),
            D::MakeNamedMedium(typed) => self.make_named_medium(span, typed),
            D::MediumInterface { inside, outside } => self.use_media(inside, outside),
            D::WorldBegin => self.begin_world(span),
            D::WorldEnd => self.end_world(span),
            D::Texture {
                name,
                value_type,
                class,
                params,
            } => self.texture(
                span,
                &name,
                &value_type,
                Typed {
                    kind: class,
                    params,
                },
            ),
            D::Material(typed) => self.use_material(span, typed),
            D::MakeNamedMaterial(typed) => self.make_named_material(span, typed),
            D::NamedMaterial(name) => self.use_named_material(&name),
            D::LightSource(typed) => self.light_source(span, &typed),
            D::AreaLightSource(typed) => self.area_light_source(span, &typed),
            D::Shape(typed) => self.shape(span, &typed),
            D::ReverseOrientation => {
                self.current.state.reverse_orientation = !self.current.state.reverse_orientation
            }
            D::ObjectBegin(name) => self.begin_object(span, name),
            D::ObjectEnd => self.end_object(span),
            D::ObjectInstance(name) => self.instance(&name),
        }
        Ok(())
    }

    /// Reports a directive in the wrong block. Returns `false` if it is to be ignored.
    fn allowed_here(&mut self, kind: &DirectiveKind, span: Span) -> bool {
        use DirectiveKind as D;
        let word = kind.word();
        match (block_of(kind), &self.world) {
            // Whether these are misplaced is unknown, since no block has really begun.
            (Block::Options, Some(world)) if world.assumed => true,
            (Block::Options, Some(world)) => {
                let problem = match kind {
                    D::WorldBegin => {
                        Diagnostic::error("`WorldBegin` inside the world block; ignored")
                            .with_help("is a `WorldEnd` missing before it?")
                    }
                    _ => {
                        Diagnostic::error(format!("`{word}` belongs before `WorldBegin`; ignored"))
                    }
                };
                self.diagnostics.push(
                    problem
                        .at(span)
                        .recoverable()
                        .related(world.opened, "the world block begins here"),
                );
                false
            }
            (Block::World, None) => match kind {
                D::WorldEnd | D::AttributeEnd | D::TransformEnd | D::ObjectEnd => {
                    self.error(span, format!("`{word}` without `WorldBegin`; ignored"));
                    false
                }
                // The image before is whole: pbrt-v3 reports these, too, and continues.
                _ if self.had_world => {
                    let message = format!("`{word}` after `WorldEnd`; ignored");
                    let error = Diagnostic::error(message).at(span).recoverable();
                    let help = "is a `WorldBegin` missing before it?";
                    self.diagnostics.push(error.with_help(help));
                    false
                }
                _ => {
                    self.assume_world(word, span);
                    true
                }
            },
            _ => true,
        }
    }

    /// Reports a directive before `WorldBegin`, and continues as if the block had begun: one missing or misspelled word
    /// should not hide other problems.
    fn assume_world(&mut self, word: &str, span: Span) {
        let message = format!("`{word}` belongs between `WorldBegin` and `WorldEnd`");
        self.diagnostics.push(
            Diagnostic::error(message)
                .at(span)
                .recoverable()
                .with_help("is a `WorldBegin` missing before it?"),
        );
        self.settle_dialect();
        let mut world = WorldBlock::new(span);
        world.assumed = true;
        self.world = Some(world);
    }

    /// Handles `AttributeEnd` or `TransformEnd`.
    fn end_scope(&mut self, scope: Scope, span: Span) {
        if !self.close_scope(scope, span) {
            let word = scope.word();
            let message = format!("`{word}End` without a matching `{word}Begin`; ignored");
            self.error(span, message);
        }
    }

    /// Closes a scope; returns `false` if none is open. In an assumed world its transformations persist: pbrt-v3
    /// ignores scopes there, and the camera may be inside one.
    pub(super) fn close_scope(&mut self, scope: Scope, span: Span) -> bool {
        let assumed = self.world.as_ref().is_some_and(|world| world.assumed);
        let before = assumed.then(|| (self.current.ctm.clone(), self.current.active));
        let closed = self
            .scopes
            .close(scope, span, &mut self.current, self.diagnostics);
        if let Some((ctm, active)) = before {
            self.current.ctm = ctm;
            self.current.active = active;
        }
        closed
    }

    /// Collects evidence of the dialect. Once the world has begun, a change requires a restart.
    fn learn_dialect(&mut self, kind: &DirectiveKind, span: Span) -> Result<(), MustRestart> {
        let auto = self.settings.dialect == DialectChoice::Auto;
        if matches!(kind, DirectiveKind::WorldBegin) {
            self.settle_dialect();
        } else if self.world.is_none() {
            self.evidence.note(kind);
        } else if auto && self.dialect == Dialect::V3 && is_v2_only(kind) {
            let reason = format!("it uses `{}`, which only pbrt-v2 has", kind.word());
            return Err(MustRestart { reason });
        }
        if is_v2_only(kind) && self.settings.dialect == DialectChoice::Fixed(Dialect::V3) {
            let word = kind.word();
            let message = format!("`{word}` is pbrt-v2's; the file is read as pbrt-v3 as asked");
            self.warn(span, message);
        }
        Ok(())
    }

    /// An `Include` among parameters is evidence too, unless there was evidence of v3 before.
    fn learn_from_include(&mut self, include: Span) -> Result<(), MustRestart> {
        self.evidence.include_in_list = true;
        let may_be_v2 =
            self.settings.dialect == DialectChoice::Auto && !self.evidence.v3_integrator;
        match self.dialect {
            Dialect::V2 => {}
            Dialect::V3 if may_be_v2 && self.world.is_none() => {}
            Dialect::V3 if may_be_v2 => {
                let reason = INCLUDE_IN_LIST.to_string();
                return Err(MustRestart { reason });
            }
            Dialect::V3 => {
                let message =
                    "`Include` among parameters: pbrt-v3 stops here, only pbrt-v2 follows it";
                self.diagnostics
                    .push(Diagnostic::error(message).at(include).with_help(
                    "let the file hold whole directives, or read this scene with `--dialect v2`",
                ));
            }
        }
        Ok(())
    }

    fn settle_dialect(&mut self) {
        self.evidence.course_camera = self.options.has_course_camera();
        if self.settings.dialect == DialectChoice::Auto {
            let (dialect, reason) = self.evidence.verdict();
            self.dialect = dialect;
            if let Some(reason) = reason {
                self.announce(&reason);
            }
        }
    }

    fn transform(&mut self, f: impl Fn(&Transform) -> Transform) {
        self.current.ctm.change(self.current.active, f);
    }

    /// The current placement, static or moving.
    pub(super) fn placement(&self) -> Placement {
        self.current.ctm.placement(self.options.transform_times)
    }

    fn rotate(&mut self, span: Span, degrees: f64, axis: DVec3) {
        if axis.try_normalize().is_none() {
            self.error(span, "`Rotate` about an axis of no length; ignored");
        }
        self.transform(|m| *m * Transform::rotate(degrees, axis));
    }

    fn look_at(&mut self, span: Span, eye: DVec3, look: DVec3, up: DVec3) {
        match Transform::look_at(eye, look, up) {
            Some(look_at) => self.transform(|m| *m * look_at),
            None if eye == look => {
                self.error(span, "`LookAt` looks from a point at itself; ignored");
            }
            None => {
                self.error(span, "`LookAt` has an up vector along the view; ignored");
            }
        }
    }

    /// CTM := f(CTM), with a warning if this step makes it singular: rays cannot be transformed into a flattened space.
    fn flattening_transform(&mut self, span: Span, f: impl Fn(&Transform) -> Transform) {
        let invertible = |Ctm { start, end }: &Ctm| start.is_invertible() && end.is_invertible();
        let before = invertible(&self.current.ctm);
        self.transform(f);
        if before && !invertible(&self.current.ctm) {
            self.warn(
                span,
                "the transformation flattens space from here on; quadrics, curves and instances \
                 under it are left out, and so is what moves",
            );
        }
    }

    fn restore_coordinate_system(&mut self, name: &Name) {
        match self.coordinate_systems.get(&name.text) {
            Some(ctm) => self.current.ctm = ctm.clone(),
            None => {
                let known = self.coordinate_systems.keys().map(String::as_str);
                let message = format!("there is no coordinate system `{}`; ignored", name.text);
                let warning = Diagnostic::warning(message).at(name.span);
                self.diagnostics
                    .push_with_nearest(warning, &name.text, known);
            }
        }
    }

    fn begin_world(&mut self, span: Span) {
        self.check_transforms();
        // Discard an assumed world: its scopes have been reported, and the materials and lights of its state are gone
        // with it.
        self.scopes = Scopes::default();
        let media = self.current.state.medium_interface.take();
        self.current = Current::new();
        // The only part of the graphics state that the options block can set, and it persists (docs/scene-language.md
        // §2.3).
        self.current.state.medium_interface = media;
        self.coordinate_systems
            .insert("world".to_string(), Ctm::IDENTITY);
        self.world = Some(WorldBlock::new(span));
    }

    fn end_world(&mut self, span: Span) {
        if let Some(world) = self.world.as_ref().filter(|world| world.assumed) {
            // pbrt-v3 renders nothing here: this is more than a misplaced word.
            self.diagnostics.push(
                Diagnostic::error("`WorldEnd` without `WorldBegin`: nothing is rendered")
                    .at(span)
                    .related(world.opened, "taken for the beginning of the world"),
            );
        }
        let lit = self.media.shines();
        if self
            .world
            .as_ref()
            .is_some_and(|world| !lit && !world.has_lights())
        {
            self.warn(span, "the scene has no lights: the image will be black");
        }
        let frame = self.close_world();
        self.frames.extend(frame);
    }

    /// Closes the world block and resets everything that is not carried over to the next frame.
    fn close_world(&mut self) -> Option<Frame> {
        let mut world = self.world.take()?;
        self.had_world = true;
        let open_object = world.open_object.take().map(|(_, opened)| opened);
        self.scopes.close_all(open_object, self.diagnostics);
        if let Some(opened) = open_object {
            let message = "`ObjectBegin` without `ObjectEnd`: the object is dropped";
            self.error(opened, message);
        }
        let media = self.take_media();
        let mut options = self.read_options();
        if media.has_volumes() {
            let IntegratorSettings { spec, .. } = &mut options.integrator;
            *spec = spec.clone().through_volumes(options.media_seen);
        }
        self.check_media(&media, &options);
        // pbrt-v2 keeps the options for the next frame, v3 resets them (docs/scene-language.md §A.1).
        if self.dialect == Dialect::V3 {
            self.options = StoredOptions::default();
            self.evidence = Evidence::default();
        }
        self.current = Current::new();
        self.coordinate_systems.clear();
        let mut frame = world.into_frame(options, media);
        self.find_focus_target(&mut frame);
        Some(frame)
    }

    /// Finds what the camera is to focus on, if that has a name.
    fn find_focus_target(&self, frame: &mut Frame) {
        let Some((name, place)) = frame.options.camera.focus_object() else {
            return;
        };
        let names = Names::of(frame, self.sources);
        let target = names.target(name);
        if target.is_none() {
            let message = format!(
                "no object, shape or material is called `{name}`{}",
                names.some()
            );
            let error = Diagnostic {
                span: place,
                ..Diagnostic::error(message)
            };
            let known = names
                .all()
                .map(|known| known.split('#').next().unwrap_or(known));
            self.diagnostics.push_with_nearest(error, name, known);
        }
        frame.options.focus_target = target;
    }

    /// The location of the integrator's type.
    pub(super) fn integrator_span(&self) -> Option<Span> {
        let integrator = self.options.integrator.as_ref();
        integrator.map(|stored| stored.typed.kind.span)
    }

    fn read_options(&self) -> Options {
        let names = TextureNames::default();
        let reading = self.reading(&names);
        let settings = &self.settings;
        let mut options = self
            .options
            .read(&reading, settings.details, &settings.camera);
        if let Some(compat) = self.settings.compat {
            options.camera.set_compat(compat);
        }
        if let Some(model) = self.settings.lens_model {
            options.camera.set_model(model);
        }
        options.max_memory = self.settings.max_memory;
        options
    }
}
