//! Places shapes, creates emitters and builds the trees.

use crate::accel::{Geometry, GeometryBuilder, GeometryError, PrimitiveAttributes};
use crate::budget::Budget;
use crate::handles::{LightId, LightLayer};
use crate::lights::{DiffuseAreaLight, DiffuseAreaSpec, Light};
use crate::math::DVec3;
use crate::math::transform::Transform;
use crate::media::MediumInterface;
use crate::scene::description::{InstanceEntity, ObjectDefinition, ShapeEntity};
use crate::scene::{Frame, LightGroups};
use crate::shapes::emitter::Emitter;
use crate::shapes::{CompiledShape, ShapeError, Site};
use crate::syntax::{Diagnostic, Diagnostics};
use rayon::prelude::*;

/// The shapes of a frame.
pub(super) struct Shapes {
    /// Shapes in the world.
    pub placed: Vec<ShapeEntity>,
    /// Named objects.
    pub objects: Vec<ObjectDefinition>,
    /// Instances of objects.
    pub instances: Vec<InstanceEntity>,
    /// Area lights that shapes refer to.
    pub area_lights: Vec<DiffuseAreaSpec>,
    /// The media around the lights that are no shapes.
    pub light_media: Vec<MediumInterface>,
    /// The layers of light of both, where any are wanted.
    pub light_groups: Option<LightGroups>,
    /// `true` if a texture needs face indices (Ptex).
    pub need_faces: bool,
    /// By material: nothing asks for surface parameters there.
    pub bare: Vec<bool>,
    /// Rays are traced many at a time.
    pub many_rays: bool,
}

/// Geometry with the lights that its shapes form.
pub(super) struct PlacedGeometry {
    /// The surfaces.
    pub geometry: Geometry,
    /// All lights: those given, then the emissive shapes.
    pub lights: Vec<Light>,
    /// How many of `lights`, from the front, are sampled; emitters inside objects are not.
    pub sampled_lights: usize,
    /// The media around each of `lights`.
    pub light_media: Vec<MediumInterface>,
    /// The layer of each of `lights`, where layers of light are wanted.
    pub light_layers: Vec<LightLayer>,
}

/// Compiles all shapes (meshes are loaded in parallel) and builds the trees. Shapes that cannot be loaded are reported
/// and left out.
pub(super) fn build(
    shapes: Shapes,
    lights: Vec<Light>,
    render_from_world: &Transform,
    diagnostics: &Diagnostics,
    budget: &Budget,
) -> Option<PlacedGeometry> {
    let mut adder = Adder {
        budget,
        area_lights: &shapes.area_lights,
        need_faces: shapes.need_faces,
        bare: &shapes.bare,
        lights,
        light_media: shapes.light_media,
        light_groups: shapes.light_groups,
        groups: 0,
        diagnostics,
    };
    let mut top = GeometryBuilder::of_world(shapes.many_rays);
    adder.add_shapes(shapes.placed, render_from_world, &mut top);
    let sampled_lights = adder.lights.len();
    let object = |object: ObjectDefinition| {
        let mut builder = GeometryBuilder::of_object();
        adder.add_shapes(object.shapes, &Transform::IDENTITY, &mut builder);
        builder
    };
    let objects = shapes.objects.into_iter().map(object).collect();
    for instance in &shapes.instances {
        add_instance(instance, render_from_world, &mut top);
    }
    let (lights, light_media) = (adder.lights, adder.light_media);
    let light_layers = adder
        .light_groups
        .map_or_else(Vec::new, |groups| groups.of_lights);
    let built = top.build(objects);
    let report = |error: GeometryError| diagnostics.push(Diagnostic::error(error.to_string()));
    let geometry = built.map_err(report).ok()?;
    let skipped = geometry.statistics().skipped;
    if skipped > 0 {
        let message = format!(
            "triangles without area, or with corners that are no places, are left out: {skipped}"
        );
        diagnostics.push(Diagnostic::note(message));
    }
    Some(PlacedGeometry {
        geometry,
        lights,
        sampled_lights,
        light_media,
        light_layers,
    })
}

fn add_instance(
    instance: &InstanceEntity,
    render_from_world: &Transform,
    top: &mut GeometryBuilder,
) {
    let place = &instance.world_from_object;
    match place.motion() {
        Some(motion) => {
            let motion = motion.shifted(render_from_world.point(DVec3::ZERO));
            top.add_moving_instance(instance.object, motion);
        }
        // A singular transformation at the end was warned about, and the shape is left out with both.
        None if place.end.is_some() => top.skip_instance(),
        None => top.add_instance(instance.object, &(*render_from_world * place.start)),
    }
}

/// Loads all shapes and discards them, only to report their problems.
pub(super) fn check(frame: &Frame, diagnostics: &Diagnostics, budget: &Budget) {
    let objects = frame.objects.iter().flat_map(|object| &object.shapes);
    let shapes: Vec<&ShapeEntity> = frame.shapes.iter().chain(objects).collect();
    // The camera's position does not affect what is wrong with a shape.
    let of_shape = |shape| problems(shape, &compile(shape, &Transform::IDENTITY, budget));
    let found: Vec<_> = shapes.into_par_iter().flat_map_iter(of_shape).collect();
    for problem in found {
        diagnostics.push(problem);
    }
}

/// The problems of a shape.
fn problems(shape: &ShapeEntity, result: &Result<CompiledShape, ShapeError>) -> Vec<Diagnostic> {
    let problems = match result {
        // A flattened shape is invisible in pbrt too.
        Err(error @ ShapeError::Singular) => {
            vec![Diagnostic::warning(format!("{error}; left out"))]
        }
        Err(error @ ShapeError::TooLarge(_)) => vec![Diagnostic::error(error.to_string())],
        Err(ShapeError::File(error)) => {
            let diagnostic = Diagnostic::error(error.to_string()).recoverable();
            vec![diagnostic.failed_if(error.is_failure)]
        }
        Ok(compiled) => compiled
            .warnings()
            .iter()
            .map(Diagnostic::warning)
            .collect(),
    };
    problems.into_iter().map(|p| p.at(shape.span)).collect()
}

/// Compiles a shape for a level, or in its own space if it moves within the level.
fn compile(
    shape: &ShapeEntity,
    level_from_world: &Transform,
    budget: &Budget,
) -> Result<CompiledShape, ShapeError> {
    let place = &shape.world_from_shape;
    let level_from_shape = match place.end {
        None => *level_from_world * place.start,
        Some(_) if place.motion().is_none() => return Err(ShapeError::Singular),
        Some(_) => Transform::IDENTITY,
    };
    shape.spec.compile(&Site {
        level_from_object: &level_from_shape,
        reverse_orientation: shape.reverse_orientation,
        budget,
    })
}

/// Turns shapes into primitives with attributes, collecting the lights they form.
struct Adder<'a> {
    area_lights: &'a [DiffuseAreaSpec],
    need_faces: bool,
    bare: &'a [bool],
    lights: Vec<Light>,
    light_media: Vec<MediumInterface>,
    light_groups: Option<LightGroups>,
    groups: u32,
    diagnostics: &'a Diagnostics,
    budget: &'a Budget,
}

impl Adder<'_> {
    /// Compiles shapes and adds them to their level, whose space is the world's, or a translation of it.
    fn add_shapes(
        &mut self,
        shapes: Vec<ShapeEntity>,
        level_from_world: &Transform,
        level: &mut GeometryBuilder,
    ) {
        let compiled = shapes.into_par_iter().map(|shape| {
            let result = compile(&shape, level_from_world, self.budget);
            (shape, result)
        });
        let compiled: Vec<_> = compiled.collect();
        for (number, (shape, result)) in (0..).zip(compiled) {
            for problem in problems(&shape, &result) {
                self.diagnostics.push(problem);
            }
            let Ok(mut compiled) = result else { continue };
            if let (CompiledShape::Mesh(mesh), false) = (&mut compiled, self.need_faces) {
                mesh.data.face_ids = Vec::new();
            }
            let attributes = PrimitiveAttributes {
                shape: number,
                ..self.attributes(&shape, &compiled)
            };
            match shape.world_from_shape.motion() {
                None => level.add(compiled, attributes),
                Some(motion) => {
                    let motion = motion.shifted(level_from_world.point(DVec3::ZERO));
                    level.add_moving(compiled, attributes, motion);
                }
            }
        }
    }

    fn attributes(&mut self, shape: &ShapeEntity, compiled: &CompiledShape) -> PrimitiveAttributes {
        let (light, paired_lights) = match shape.area_light {
            Some(light) => self.add_lights(compiled, light, shape.media),
            None => (None, false),
        };
        PrimitiveAttributes {
            material: shape.material,
            light,
            paired_lights,
            // A surface without material has no use for them either.
            bare: shape.material.is_none_or(|id| self.bare[id.index()]),
            alpha: shape.spec.alpha,
            shadow_alpha: shape.spec.shadow_alpha,
            interface: shape.interface,
            shape: 0,
        }
    }

    /// Adds one light for each piece of the shape; all pieces form one group. Returns the first, and whether every two
    /// triangles are one light.
    fn add_lights(
        &mut self,
        shape: &CompiledShape,
        area_light: usize,
        media: MediumInterface,
    ) -> (Option<LightId>, bool) {
        let first = LightId(self.lights.len() as u32);
        let (spec, group) = (&self.area_lights[area_light], self.groups);
        let mut emitters = shape.emitters().peekable();
        let paired = emitters.peek().is_some_and(Emitter::is_pair);
        let light = |emitter| Light::DiffuseArea(DiffuseAreaLight::new(spec, emitter, group));
        self.lights.extend(emitters.map(light));
        // A scene without media has no list of them.
        if media != MediumInterface::default() {
            self.light_media
                .resize(first.index(), MediumInterface::default());
            self.light_media.resize(self.lights.len(), media);
        }
        if let Some(groups) = &mut self.light_groups {
            let layer = groups.of_area_lights.get(area_light).copied();
            groups
                .of_lights
                .resize(self.lights.len(), layer.unwrap_or_default());
        }
        self.groups += 1;
        (Some(first), paired)
    }
}
