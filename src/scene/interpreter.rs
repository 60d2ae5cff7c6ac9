//! The graphics-state machine: directives in, frames out.

use super::description::{Frame, InstanceEntity, ObjectDefinition, SceneDescription, ShapeEntity};
use super::dialect::{DialectChoice, Evidence};
use super::graphics_state::MaterialDirective;
use super::options::StoredOptions;
use super::scopes::{Current, Scope, Scopes};
use super::transforms::Ctm;
use crate::cameras::Compat;
use crate::handles::{FloatTextureId, MaterialId, ObjectId, SpectrumTextureId};
use crate::lights::{DiffuseSpec, LightSpec};
use crate::materials::{self, Material};
use crate::math::transform::Transform;
use crate::params::{Dialect, ParamReader, ReadContext, TextureNames};
use crate::shapes::ShapeSpec;
use crate::syntax::suggest::suggest;
use crate::syntax::{
    ActiveTransform, Diagnostic, Diagnostics, Directive, DirectiveKind, FileId, Name, ParamList, Parser, SourceMap,
    Span, Typed,
};
use crate::textures::{FloatTextureSpec, SpectrumTextureSpec};
use std::collections::HashMap;
use std::rc::Rc;

/// What the command line says about how a scene is to be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadSettings {
    /// `--dialect`.
    pub dialect: DialectChoice,
    /// `--compat`.
    pub compat: Option<Compat>,
}

/// Reads a whole scene file with its includes. Every problem goes to `diagnostics`; the scene
/// holds what could be understood, and is fit to render only where there were no errors.
pub fn read_scene(
    sources: &SourceMap,
    main: FileId,
    settings: &ReadSettings,
    diagnostics: &Diagnostics,
) -> SceneDescription {
    let first = Diagnostics::new();
    let mut interpreter = Interpreter::new(sources, main, settings, settings.dialect, &first);
    if interpreter.run(main).is_ok() {
        return interpreter.finish(diagnostics, first);
    }
    // A directive that only pbrt-v2 has turned up inside the world, after parameters had been
    // read with v3's meanings: read everything again as v2.
    let second = Diagnostics::new();
    let choice = DialectChoice::Fixed(Dialect::V2);
    let mut interpreter = Interpreter::new(sources, main, settings, choice, &second);
    let reason = "it uses `Volume`, which only pbrt-v2 has".to_string();
    interpreter.announced = Some(reason);
    // With the dialect fixed there is nothing left to restart for.
    let _ = interpreter.run(main);
    interpreter.finish(diagnostics, second)
}

/// The file turned out to speak v2 after all.
struct MustRestart;

/// What reading parameters needs, at one point of the file.
pub struct Reading<'a> {
    /// Where problems go.
    pub diagnostics: &'a Diagnostics,
    /// Whose defaults apply.
    pub dialect: Dialect,
    context: &'a ReadContext<'a>,
    textures: &'a TextureNames,
}

impl Reading<'_> {
    /// Reads a directive and reports its unused parameters.
    pub fn read<R>(&self, word: &'static str, typed: &Typed, f: impl FnOnce(&ParamReader) -> R) -> R {
        self.read_layers(word, &typed.kind, &[&typed.params], f)
    }

    /// The same with several parameter lists, the first to have a name wins.
    pub fn read_layers<R>(
        &self,
        word: &'static str,
        kind: &Name,
        layers: &[&ParamList],
        f: impl FnOnce(&ParamReader) -> R,
    ) -> R {
        let reader = ParamReader::layered(self.context, self.textures, self.dialect, word, kind, layers);
        let result = f(&reader);
        reader.finish();
        result
    }

    /// Reads a directive, or the defaults of `kind` where it was not given.
    pub fn read_or<R>(
        &self,
        word: &'static str,
        typed: Option<&Typed>,
        kind: &str,
        f: impl FnOnce(&ParamReader) -> R,
    ) -> R {
        match typed {
            Some(typed) => self.read(word, typed, f),
            None => {
                let nowhere = Span { file: FileId(0), start: 0, end: 0 };
                let name = Name { text: kind.to_string(), span: nowhere };
                self.read_layers(word, &name, &[&ParamList::EMPTY], f)
            }
        }
    }
}

struct Interpreter<'a> {
    sources: &'a SourceMap,
    diagnostics: &'a Diagnostics,
    context: ReadContext<'a>,
    settings: &'a ReadSettings,
    choice: DialectChoice,
    dialect: Dialect,
    evidence: Evidence,
    announced: Option<String>,
    frames: Vec<Frame>,

    current: Current,
    scopes: Scopes,
    coordinate_systems: HashMap<String, Ctm>,
    options: StoredOptions,
    world: Option<WorldBlock>,
}

/// What accumulates between `WorldBegin` and `WorldEnd`.
#[derive(Default)]
struct WorldBlock {
    float_textures: Vec<FloatTextureSpec>,
    spectrum_textures: Vec<SpectrumTextureSpec>,
    materials: Vec<Material>,
    shapes: Vec<ShapeEntity>,
    objects: Vec<ObjectDefinition>,
    object_names: HashMap<String, ObjectId>,
    open_object: Option<(ObjectDefinition, Span)>,
    instances: Vec<InstanceEntity>,
    lights: Vec<LightSpec>,
    area_lights: Vec<DiffuseSpec>,
    default_material: Option<MaterialId>,
    opened: Option<Span>,
}

impl<'a> Interpreter<'a> {
    fn new(
        sources: &'a SourceMap,
        main: FileId,
        settings: &'a ReadSettings,
        choice: DialectChoice,
        diagnostics: &'a Diagnostics,
    ) -> Interpreter<'a> {
        Interpreter {
            sources,
            diagnostics,
            context: ReadContext::new(sources.directory(main), diagnostics),
            settings,
            choice,
            dialect: Dialect::V3,
            evidence: Evidence::default(),
            announced: None,
            frames: Vec::new(),
            current: Current::new(),
            scopes: Scopes::default(),
            coordinate_systems: HashMap::new(),
            options: StoredOptions::default(),
            world: None,
        }
    }

    fn run(&mut self, main: FileId) -> Result<(), MustRestart> {
        let (sources, diagnostics) = (self.sources, self.diagnostics);
        for directive in Parser::new(sources, main, diagnostics) {
            self.directive(directive)?;
        }
        Ok(())
    }

    /// Closes the reading: what is left open is reported, and all messages are handed over.
    fn finish(mut self, diagnostics: &Diagnostics, own: Diagnostics) -> SceneDescription {
        if let Some(world) = self.world.take() {
            let mut problem = Diagnostic::error("the file ends inside the world block; nothing is rendered")
                .with_help("add `WorldEnd` at the end");
            if let Some(span) = world.opened {
                problem = problem.at(span).label("the block begins here");
            }
            self.diagnostics.push(problem);
        } else if self.frames.is_empty() {
            self.diagnostics.push(
                Diagnostic::error("the file describes no picture: there is no `WorldBegin` … `WorldEnd`"),
            );
        }
        if let Some(reason) = &self.announced {
            let message = format!("read as a pbrt-v2 scene: {reason} (--dialect v3 overrides)");
            diagnostics.push(Diagnostic::note(message));
        }
        let scene = SceneDescription { frames: std::mem::take(&mut self.frames), dialect: self.dialect };
        drop(self);
        diagnostics.append(own);
        scene
    }

    fn error(&self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(message).at(span));
    }

    fn warn(&self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::warning(message).at(span));
    }

    fn reading<'b>(&'b self, textures: &'b TextureNames) -> Reading<'b> {
        Reading { diagnostics: self.diagnostics, dialect: self.dialect, context: &self.context, textures }
    }

    fn directive(&mut self, directive: Directive) -> Result<(), MustRestart> {
        let Directive { span, kind } = directive;
        if !self.allowed_here(&kind, span) {
            return Ok(());
        }
        self.note_evidence(&kind, span)?;
        use DirectiveKind as D;
        match kind {
            D::Identity => self.transform(|_| Transform::IDENTITY),
            D::Translate(t) => self.transform(|m| *m * Transform::translate(t)),
            D::Scale(s) => {
                if s.x * s.y * s.z == 0.0 {
                    self.warn(span, "scaling by zero flattens everything that follows; such shapes are left out");
                }
                self.transform(|m| *m * Transform::scale(s));
            }
            D::Rotate { degrees, axis } => self.transform(|m| *m * Transform::rotate(degrees, axis)),
            D::LookAt { eye, look, up } => match Transform::look_at(eye, look, up) {
                Some(look_at) => self.transform(|m| *m * look_at),
                None => self.error(
                    span,
                    "`LookAt` has no direction: eye and look coincide, or up is parallel to the view; ignored",
                ),
            },
            D::Transform(m) => self.transform(|_| Transform::from_matrix(*m)),
            D::ConcatTransform(m) => self.transform(|ctm| *ctm * Transform::from_matrix(*m)),
            D::CoordinateSystem(name) => {
                self.coordinate_systems.insert(name.text, self.current.ctm.clone());
            }
            D::CoordSysTransform(name) => self.restore_coordinate_system(&name),
            D::ActiveTransform(which) => self.current.active = which,
            D::TransformTimes(..) => {}
            D::TransformBegin => self.scopes.open(Scope::Transform, span, &self.current),
            D::TransformEnd => self.scopes.close(Scope::Transform, span, &mut self.current, self.diagnostics),
            D::AttributeBegin => self.scopes.open(Scope::Attribute, span, &self.current),
            D::AttributeEnd => self.scopes.close(Scope::Attribute, span, &mut self.current, self.diagnostics),
            D::PixelFilter(typed) => self.options.filter = Some(typed),
            D::Film(typed) => self.options.film = Some(typed),
            D::Sampler(typed) => self.options.sampler = Some(typed),
            D::Accelerator(typed) => self.options.accelerator = Some(typed),
            D::Integrator(typed) | D::SurfaceIntegrator(typed) => self.options.integrator = Some(typed),
            D::Renderer(typed) => self.options.renderer = Some(typed),
            D::VolumeIntegrator(_) => {}
            D::Volume(typed) => {
                self.warn(typed.kind.span, "volumes are not modelled yet; left out");
            }
            D::MakeNamedMedium(typed) => {
                self.warn(typed.kind.span, "participating media are not modelled yet; left out");
            }
            D::MediumInterface { .. } => {}
            D::Camera(typed) => {
                let camera_to_world = Ctm { start: self.current.ctm.start.inverted(), end: self.current.ctm.end.inverted() };
                self.coordinate_systems.insert("camera".to_string(), camera_to_world);
                self.options.camera = Some((typed, self.current.ctm.clone()));
            }
            D::WorldBegin => self.begin_world(span),
            D::WorldEnd => self.end_world(span),
            D::Texture { name, value_type, class, params } => self.texture(&name, &value_type, class, params),
            D::Material(typed) => {
                let material = self.make_material("Material", typed);
                self.current.state.material = Some(Rc::new(material));
            }
            D::MakeNamedMaterial(typed) => self.make_named_material(typed),
            D::NamedMaterial(name) => self.use_named_material(&name),
            D::LightSource(typed) => self.light_source(&typed),
            D::AreaLightSource(typed) => {
                self.current.state.area_light = (!typed.kind.text.is_empty()).then(|| Rc::new(typed));
            }
            D::Shape(typed) => self.shape(span, &typed),
            D::ReverseOrientation => self.current.state.reverse_orientation = !self.current.state.reverse_orientation,
            D::ObjectBegin(name) => self.begin_object(span, name),
            D::ObjectEnd => self.end_object(span),
            D::ObjectInstance(name) => self.instance(&name),
        }
        Ok(())
    }

    /// Reports a directive in the wrong block (scene-language 2); it is ignored then.
    fn allowed_here(&self, kind: &DirectiveKind, span: Span) -> bool {
        use DirectiveKind as D;
        let options_only = matches!(
            kind,
            D::TransformTimes(..)
                | D::PixelFilter(_)
                | D::Film(_)
                | D::Sampler(_)
                | D::Accelerator(_)
                | D::Integrator(_)
                | D::SurfaceIntegrator(_)
                | D::VolumeIntegrator(_)
                | D::Renderer(_)
                | D::Camera(_)
                | D::WorldBegin
        );
        let world_only = matches!(
            kind,
            D::TransformBegin
                | D::TransformEnd
                | D::AttributeBegin
                | D::AttributeEnd
                | D::Texture { .. }
                | D::Material(_)
                | D::MakeNamedMaterial(_)
                | D::NamedMaterial(_)
                | D::LightSource(_)
                | D::AreaLightSource(_)
                | D::Shape(_)
                | D::ReverseOrientation
                | D::ObjectBegin(_)
                | D::ObjectEnd
                | D::ObjectInstance(_)
                | D::Volume(_)
                | D::WorldEnd
        );
        let word = kind.word();
        if options_only && self.world.is_some() {
            self.error(span, format!("`{word}` belongs before `WorldBegin`; ignored"));
            return false;
        }
        if world_only && self.world.is_none() {
            self.error(span, format!("`{word}` belongs between `WorldBegin` and `WorldEnd`; ignored"));
            return false;
        }
        true
    }

    /// Collects what tells the dialect; inside the world it is too late to be told.
    fn note_evidence(&mut self, kind: &DirectiveKind, span: Span) -> Result<(), MustRestart> {
        use DirectiveKind as D;
        match kind {
            D::Integrator(_) => self.evidence.v3_integrator = true,
            D::SurfaceIntegrator(_) | D::VolumeIntegrator(_) | D::Renderer(_) => {
                self.evidence.v2_directive = self.evidence.v2_directive.or(Some(kind.word()));
            }
            D::Volume(_) if self.dialect == Dialect::V3 && self.choice == DialectChoice::Auto => {
                return Err(MustRestart);
            }
            D::WorldBegin => self.settle_dialect(),
            _ => {}
        }
        let v2_word =
            matches!(kind, D::SurfaceIntegrator(_) | D::VolumeIntegrator(_) | D::Renderer(_) | D::Volume(_));
        if v2_word && self.choice == DialectChoice::Fixed(Dialect::V3) {
            self.warn(span, format!("`{}` is pbrt-v2's; read with v3's meanings as --dialect asks", kind.word()));
        }
        Ok(())
    }

    fn settle_dialect(&mut self) {
        self.evidence.course_camera = self.options.has_course_camera();
        self.dialect = match self.choice {
            DialectChoice::Fixed(dialect) => dialect,
            DialectChoice::Auto => {
                let (dialect, reason) = self.evidence.verdict();
                if self.announced.is_none() {
                    self.announced = reason;
                }
                dialect
            }
        };
    }

    fn transform(&mut self, f: impl Fn(&Transform) -> Transform) {
        self.current.ctm.change(self.current.active, f);
    }

    fn restore_coordinate_system(&mut self, name: &Name) {
        match self.coordinate_systems.get(&name.text) {
            Some(ctm) => self.current.ctm = ctm.clone(),
            None => {
                let known = self.coordinate_systems.keys().map(String::as_str);
                self.diagnostics.push(
                    Diagnostic::warning(format!("there is no coordinate system `{}`; ignored", name.text))
                        .at(name.span)
                        .with_suggestion(suggest(&name.text, known)),
                );
            }
        }
    }

    fn begin_world(&mut self, span: Span) {
        self.current.ctm = Ctm::IDENTITY;
        self.current.active = ActiveTransform::All;
        self.coordinate_systems.insert("world".to_string(), Ctm::IDENTITY);
        self.world = Some(WorldBlock { opened: Some(span), ..WorldBlock::default() });
    }

    fn end_world(&mut self, span: Span) {
        let Some(mut world) = self.world.take() else { return };
        self.scopes.close_all(self.diagnostics);
        if let Some((_, opened)) = world.open_object.take() {
            self.error(opened, "`ObjectBegin` without `ObjectEnd`: the object is dropped");
        }
        let names = TextureNames::default();
        let mut options = self.options.read(&self.reading(&names));
        if let (Some(options), Some(compat)) = (&mut options, self.settings.compat) {
            options.camera.set_compat(compat);
        }
        if world.lights.is_empty() && world.area_lights.is_empty() {
            self.warn(span, "the scene has no lights: the picture will be black");
        }
        if let Some(options) = options {
            self.frames.push(Frame {
                options,
                float_textures: world.float_textures,
                spectrum_textures: world.spectrum_textures,
                materials: world.materials,
                shapes: world.shapes,
                objects: world.objects,
                instances: world.instances,
                lights: world.lights,
                area_lights: world.area_lights,
            });
        }
        // pbrt-v2 keeps the options for the next frame, v3 forgets them (scene-language A.1).
        if self.dialect == Dialect::V3 {
            self.options = StoredOptions::default();
            self.evidence = Evidence::default();
        }
        self.current = Current::new();
        self.coordinate_systems.clear();
    }

    fn texture(&mut self, name: &Name, value_type: &Name, class: Name, params: ParamList) {
        let typed = Typed { kind: class, params };
        let ctm = self.current.ctm.start;
        let names = Rc::clone(&self.current.state.textures);
        let reading = self.reading(&names);
        let redefined = match value_type.text.as_str() {
            "float" => {
                let spec = reading.read("Texture", &typed, |r| crate::textures::from_params_float(r, &ctm));
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else { return };
                world.float_textures.push(spec);
                let id = FloatTextureId(world.float_textures.len() as u32 - 1);
                self.current.state.define_float_texture(&name.text, id)
            }
            "color" | "spectrum" => {
                let spec = reading.read("Texture", &typed, |r| crate::textures::from_params_spectrum(r, &ctm));
                let Some((spec, world)) = spec.zip(self.world.as_mut()) else { return };
                world.spectrum_textures.push(spec);
                let id = SpectrumTextureId(world.spectrum_textures.len() as u32 - 1);
                self.current.state.define_spectrum_texture(&name.text, id)
            }
            other => {
                self.diagnostics.push(
                    Diagnostic::error(format!("textures are `float` or `spectrum`, not `{other}`; ignored"))
                        .at(value_type.span)
                        .with_suggestion(suggest(other, ["float", "spectrum", "color"].into_iter())),
                );
                return;
            }
        };
        if redefined {
            self.warn(name.span, format!("texture `{}` is defined again; later uses see this one", name.text));
        }
    }

    fn make_material(&mut self, word: &'static str, typed: Typed) -> MaterialDirective {
        let textures = Rc::clone(&self.current.state.textures);
        let material = self.reading(&textures).read(word, &typed, read_material);
        let id = material.and_then(|m| self.add_material(m));
        MaterialDirective { typed, id, textures }
    }

    fn add_material(&mut self, material: Material) -> Option<MaterialId> {
        let materials = &mut self.world.as_mut()?.materials;
        materials.push(material);
        Some(MaterialId(materials.len() as u32 - 1))
    }

    fn make_named_material(&mut self, mut typed: Typed) {
        let name = typed.kind.clone();
        let Some(kind) = named_type(&typed.params) else {
            self.diagnostics.push(
                Diagnostic::error(format!("`MakeNamedMaterial \"{}\"` does not say its type; ignored", name.text))
                    .at(name.span)
                    .with_help("add for example \"string type\" \"matte\""),
            );
            return;
        };
        typed.kind = kind;
        let material = self.make_material("MakeNamedMaterial", typed);
        if self.current.state.define_material(&name.text, material) {
            self.warn(name.span, format!("material `{}` is defined again; later uses see this one", name.text));
        }
    }

    fn use_named_material(&mut self, name: &Name) {
        match self.current.state.named_materials.get(&name.text) {
            Some(material) => self.current.state.material = Some(Rc::clone(material)),
            None => {
                let known = self.current.state.named_materials.keys().map(String::as_str);
                self.diagnostics.push(
                    Diagnostic::error(format!("there is no material `{}`; the current one stays", name.text))
                        .at(name.span)
                        .with_suggestion(suggest(&name.text, known)),
                );
            }
        }
    }

    fn light_source(&mut self, typed: &Typed) {
        let ctm = self.current.ctm.start;
        if self.current.ctm.is_animated() {
            self.warn(typed.kind.span, "a moving light is held at its start, as in pbrt-v3");
        }
        let names = Rc::clone(&self.current.state.textures);
        let light = self.reading(&names).read("LightSource", typed, |r| LightSpec::from_params(r, &ctm));
        if let Some((light, world)) = light.zip(self.world.as_mut()) {
            world.lights.push(light);
        }
    }

    fn shape(&mut self, span: Span, typed: &Typed) {
        if self.current.ctm.is_animated() {
            self.warn(span, "a moving shape is held at its start: motion blur is not supported yet");
        }
        let (material, spec) = self.read_shape(typed);
        let Some(spec) = spec else { return };
        let area_light = self.area_light(span);
        let entity = ShapeEntity {
            spec,
            world_from_shape: self.current.ctm.start,
            reverse_orientation: self.current.state.reverse_orientation,
            material,
            area_light,
            span,
        };
        let Some(world) = self.world.as_mut() else { return };
        match &mut world.open_object {
            Some((object, _)) => object.shapes.push(entity),
            None => world.shapes.push(entity),
        }
    }

    /// The shape, and the material it gets: the current one, or a fresh one where the shape's own
    /// parameters override the material's (scene-language 2.4).
    fn read_shape(&mut self, typed: &Typed) -> (Option<MaterialId>, Option<ShapeSpec>) {
        let current = self.current.state.material.clone();
        let names = Rc::clone(&self.current.state.textures);
        let reading = self.reading(&names);
        let mut overridden = None;
        let spec = reading.read("Shape", typed, |reader| {
            let spec = ShapeSpec::from_params(reader);
            if spec.is_none() && !ShapeSpec::is_known(reader.kind()) {
                reader.unknown_kind("shape", reader.kind(), &ShapeSpec::KINDS, "left out");
            }
            if may_set_material(&typed.params) {
                overridden = Some(read_overridden(&reading, reader, current.as_deref(), &typed.params));
            }
            spec
        });
        let base = match &current {
            Some(material) => material.id,
            None => self.default_material(),
        };
        let material = match overridden {
            None => base,
            Some(None) => None,
            Some(Some(material)) => self.same_or_new(base, material),
        };
        (material, spec)
    }

    /// The base material where the override changed nothing, so that a million shapes with a
    /// single-valued parameter of their own still share one material.
    fn same_or_new(&mut self, base: Option<MaterialId>, material: Material) -> Option<MaterialId> {
        let materials = &self.world.as_ref()?.materials;
        if base.is_some_and(|id| materials[id.index()] == material) {
            return base;
        }
        if let Some(last) = materials.last()
            && *last == material
        {
            return Some(MaterialId(materials.len() as u32 - 1));
        }
        self.add_material(material)
    }

    /// `matte` with its defaults, made when the first shape needs it.
    fn default_material(&mut self) -> Option<MaterialId> {
        let known = self.world.as_ref()?.default_material;
        if known.is_some() {
            return known;
        }
        let names = TextureNames::default();
        let material = self.reading(&names).read_or("Material", None, "matte", read_material)?;
        let id = self.add_material(material);
        self.world.as_mut()?.default_material = id;
        id
    }

    fn area_light(&mut self, shape: Span) -> Option<usize> {
        let typed = self.current.state.area_light.clone()?;
        if self.current.ctm.is_animated() {
            self.warn(shape, "a moving shape cannot be an area light; it does not emit");
            return None;
        }
        let names = Rc::clone(&self.current.state.textures);
        let spec = self.reading(&names).read("AreaLightSource", &typed, DiffuseSpec::from_params)?;
        let world = self.world.as_mut()?;
        if world.open_object.is_some() {
            self.diagnostics.push(
                Diagnostic::warning("an emitter inside an object glows but lights nothing, as in pbrt-v3").at(shape),
            );
        }
        let world = self.world.as_mut()?;
        if world.area_lights.last() != Some(&spec) {
            world.area_lights.push(spec);
        }
        Some(world.area_lights.len() - 1)
    }

    fn begin_object(&mut self, span: Span, name: Name) {
        let Some(world) = self.world.as_ref() else { return };
        if let Some((open, opened)) = &world.open_object {
            self.diagnostics.push(
                Diagnostic::error(format!("`ObjectBegin` inside the object `{}`; ignored", open.name))
                    .at(span)
                    .related(*opened, "which begins here"),
            );
            return;
        }
        self.scopes.open(Scope::Object, span, &self.current);
        let object = ObjectDefinition { name: name.text, shapes: Vec::new() };
        if let Some(world) = self.world.as_mut() {
            world.open_object = Some((object, span));
        }
    }

    fn end_object(&mut self, span: Span) {
        let object = self.world.as_mut().and_then(|w| w.open_object.take());
        let Some((object, _)) = object else {
            self.error(span, "`ObjectEnd` without `ObjectBegin`; ignored");
            return;
        };
        self.scopes.close_object(&mut self.current, self.diagnostics);
        let Some(world) = self.world.as_mut() else { return };
        let id = ObjectId(world.objects.len() as u32);
        world.object_names.insert(object.name.clone(), id);
        world.objects.push(object);
    }

    fn instance(&mut self, name: &Name) {
        let Some(world) = self.world.as_ref() else { return };
        if world.open_object.is_some() {
            self.error(name.span, "`ObjectInstance` inside an object definition; ignored");
            return;
        }
        let Some(&object) = world.object_names.get(&name.text) else {
            let known = world.object_names.keys().map(String::as_str);
            self.diagnostics.push(
                Diagnostic::error(format!("there is no object `{}`; ignored", name.text))
                    .at(name.span)
                    .with_suggestion(suggest(&name.text, known)),
            );
            return;
        };
        if self.current.ctm.is_animated() {
            self.warn(name.span, "a moving instance is held at its start: motion blur is not supported yet");
        }
        let world_from_object = self.current.ctm.start;
        if let Some(world) = self.world.as_mut() {
            world.instances.push(InstanceEntity { object, world_from_object });
        }
    }
}

/// A material, or `None` for a surface without one.
fn read_material(reader: &ParamReader) -> Option<Material> {
    if materials::is_none(reader.kind()) {
        reader.accept_all();
        return None;
    }
    Material::from_params(reader)
}

/// The material of a shape whose own parameters come before the material's.
fn read_overridden(
    reading: &Reading,
    shape_reader: &ParamReader,
    current: Option<&MaterialDirective>,
    shape_params: &ParamList,
) -> Option<Material> {
    let matte = Name { text: "matte".to_string(), span: shape_reader.span() };
    let (kind, params) = match current {
        Some(directive) => (&directive.typed.kind, &directive.typed.params),
        None => (&matte, &ParamList::EMPTY),
    };
    let material = shape_reader.with_layers(reading.textures, kind, &[shape_params, params], read_material);
    material
}

/// pbrt's test whether a shape's parameters might be meant for its material (scene-language 2.4).
fn may_set_material(params: &ParamList) -> bool {
    use crate::syntax::ParamType as T;
    params.params.iter().any(|p| {
        let name = p.name.as_str();
        match p.ty {
            T::Texture => !matches!(name, "alpha" | "shadowalpha"),
            T::Float => p.values() == 1 && name != "radius",
            T::String => p.values() == 1 && !matches!(name, "filename" | "type" | "scheme"),
            _ => p.values() == 1,
        }
    })
}

/// The value of `"string type"`.
fn named_type(params: &ParamList) -> Option<Name> {
    use crate::syntax::{ParamGroup, ParamValue};
    let param = params.get("type", ParamGroup::String)?;
    param.used.set(true);
    match &param.value {
        ParamValue::Strings(names) => names.first().cloned(),
        _ => None,
    }
}
