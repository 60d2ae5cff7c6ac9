//! The scene as plain data: what `build` turns into a world.

use super::options::Options;
use super::transforms::Placement;
use crate::handles::{InterfaceId, MaterialId, ObjectId};
use crate::integrators::IntegratorSpec;
use crate::lights::{DiffuseAreaSpec, LightSpec};
use crate::materials::Material;
use crate::media::MediaSpec;
use crate::params::Dialect;
use crate::shapes::ShapeSpec;
use crate::syntax::Span;
use crate::textures::{FloatTextureSpec, SpectrumTextureSpec};

/// Everything a scene file describes: one frame for each `WorldBegin` … `WorldEnd`.
#[derive(Debug)]
pub struct SceneDescription {
    /// The frames, in the order of the file.
    pub frames: Vec<Frame>,
    /// Whose defaults and meanings were used.
    pub dialect: Dialect,
}

/// One image: options and world.
#[derive(Debug)]
pub struct Frame {
    /// Camera, film, sampler, filter, integrator.
    pub options: Options,
    /// Float textures by id.
    pub float_textures: Vec<FloatTextureSpec>,
    /// Spectrum textures by id.
    pub spectrum_textures: Vec<SpectrumTextureSpec>,
    /// Materials by id.
    pub materials: Vec<Material>,
    /// Shapes placed in the world.
    pub shapes: Vec<ShapeEntity>,
    /// Named objects by id, latest definition of each name.
    pub objects: Vec<ObjectDefinition>,
    /// Where objects stand.
    pub instances: Vec<InstanceEntity>,
    /// Lights other than area lights.
    pub lights: Vec<LightSpec>,
    /// Emission of shapes; a shape refers to one by position.
    pub area_lights: Vec<DiffuseAreaSpec>,
    /// Participating media.
    pub media: MediaSpec,
}

impl Frame {
    /// For a quick look (`--quick`), as pbrt: a quarter of the width and height, one sample a pixel, and fewer of lights and
    /// of ambient occlusion.
    pub fn make_quick(&mut self) {
        let options = &mut self.options;
        options.film.make_quick();
        options.sampler = options.sampler.clone().quick();
        if let IntegratorSpec::AmbientOcclusion(ambient) = &mut options.integrator.spec {
            ambient.make_quick();
        }
        self.lights.iter_mut().for_each(LightSpec::make_quick);
        self.area_lights
            .iter_mut()
            .for_each(DiffuseAreaSpec::make_quick);
    }
}

/// A shape with all that the graphics state says of it.
#[derive(Debug)]
pub struct ShapeEntity {
    /// What kind, with its parameters.
    pub spec: ShapeSpec,
    /// Shape to world (for shapes of an object: to the object's space).
    pub world_from_shape: Placement,
    /// `ReverseOrientation` was in force.
    pub reverse_orientation: bool,
    /// Scatters by this; `None` lets rays pass.
    pub material: Option<MaterialId>,
    /// Emits by this entry of [`Frame::area_lights`].
    pub area_light: Option<usize>,
    /// The border it makes between two media.
    pub interface: Option<InterfaceId>,
    /// The name of the shape's file, or else the directive: for messages about what is found out
    /// when it is loaded.
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

/// One appearance of an object.
#[derive(Clone, Debug)]
pub struct InstanceEntity {
    /// Which object.
    pub object: ObjectId,
    /// Object to world.
    pub world_from_object: Placement,
}
