//! The scene description as plain data, which `build` turns into a world.

use super::light_groups::LightGroups;
use super::names::MaterialName;
use super::options::Options;
use super::transforms::Placement;
use crate::film::{Layer, LayerSet};
use crate::handles::{InterfaceId, MaterialId, ObjectId};
use crate::integrators::IntegratorSpec;
use crate::lights::{DiffuseAreaSpec, LightSpec};
use crate::materials::Material;
use crate::media::{MediaSpec, MediumInterface};
use crate::params::Dialect;
use crate::shapes::ShapeSpec;
use crate::syntax::Span;
use crate::textures::TextureSpecs;

/// Everything a scene file describes: one frame for each `WorldBegin` … `WorldEnd`.
#[derive(Debug)]
pub struct SceneDescription {
    /// The frames, in the order of the file.
    pub frames: Vec<Frame>,
    /// The dialect whose defaults and meanings were used.
    pub dialect: Dialect,
}

/// One image to render: options and world.
#[derive(Debug)]
pub struct Frame {
    /// Camera, film, sampler, filter, integrator.
    pub options: Options,
    /// Textures by id.
    pub textures: TextureSpecs,
    /// Materials by id.
    pub materials: Vec<Material>,
    /// What each of them is called.
    pub material_names: Vec<MaterialName>,
    /// Shapes placed in the world.
    pub shapes: Vec<ShapeEntity>,
    /// Named objects by id, latest definition of each name.
    pub objects: Vec<ObjectDefinition>,
    /// Instances of objects.
    pub instances: Vec<InstanceEntity>,
    /// Lights other than area lights.
    pub lights: Vec<LightSpec>,
    /// The media around each of `lights`.
    pub light_media: Vec<MediumInterface>,
    /// Area lights; shapes refer to them by index.
    pub area_lights: Vec<DiffuseAreaSpec>,
    /// The groups of `lights` and `area_lights`.
    pub light_groups: LightGroups,
    /// Participating media.
    pub media: MediaSpec,
}

impl Frame {
    /// The layers that the image is to have where these are `wanted`: with those of light, of which there is one for each group of
    /// lights, or for each strategy.
    pub fn layers(&self, wanted: LayerSet) -> LayerSet {
        match self.options.integrator.spec.strategies().len() {
            0 => wanted.with_lights(1 + self.light_groups.names.len()),
            count => wanted.with(Layer::Lights).with_lights(count),
        }
    }

    /// Returns `true` if paths from the lights may bring light to pixels.
    pub fn may_trace_light(&self) -> bool {
        let spec = &self.options.integrator.spec;
        let mut materials = self.materials.iter();
        let ghosts = self.options.camera.has_ghosts() && spec.has_light_pass();
        ghosts
            || spec.traces_light()
            || spec.may_be_assisted() && materials.any(Material::may_focus)
    }

    /// Reduces quality for a quick look (`--quick`), as in pbrt: a quarter of the width and height, one sample per
    /// pixel, and fewer samples of lights and of ambient occlusion.
    pub fn make_quick(&mut self) {
        let options = &mut self.options;
        options.film.make_quick();
        options.sampler = options.sampler.clone().quick();
        match &mut options.integrator.spec {
            IntegratorSpec::AmbientOcclusion(ambient) => ambient.make_quick(),
            IntegratorSpec::Sppm(sppm) => {
                let iterations = sppm.iterations / 16;
                options.sampler = options.sampler.clone().with_spp(iterations);
            }
            _ => {}
        }
        self.lights.iter_mut().for_each(LightSpec::make_quick);
        self.area_lights
            .iter_mut()
            .for_each(DiffuseAreaSpec::make_quick);
    }
}

/// A shape with its part of the graphics state.
#[derive(Debug)]
pub struct ShapeEntity {
    /// Its type and parameters.
    pub spec: ShapeSpec,
    /// Shape to world (for shapes of an object: to the object's space).
    pub world_from_shape: Placement,
    /// `true` if `ReverseOrientation` applies.
    pub reverse_orientation: bool,
    /// Material; `None` lets rays pass through.
    pub material: Option<MaterialId>,
    /// Emission, as an index in [`Frame::area_lights`].
    pub area_light: Option<usize>,
    /// The interface it forms between two media.
    pub interface: Option<InterfaceId>,
    /// The media on its sides, whether they are the same or not.
    pub media: MediumInterface,
    /// The name of the shape's file, or else the directive: the location for problems that are found when it is loaded.
    pub span: Span,
}

/// A named object.
#[derive(Debug, Default)]
pub struct ObjectDefinition {
    /// Its name.
    pub name: String,
    /// Its shapes, in the object's own space.
    pub shapes: Vec<ShapeEntity>,
}

/// An instance of an object.
#[derive(Clone, Debug)]
pub struct InstanceEntity {
    /// The object.
    pub object: ObjectId,
    /// Object to world.
    pub world_from_object: Placement,
}
