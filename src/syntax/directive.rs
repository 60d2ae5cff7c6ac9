//! What a scene file says, one statement at a time.

use super::parameter::ParamList;
use super::source::Span;
use crate::math::DVec3;
use glam::DMat4;

/// One statement of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Directive {
    /// The directive's word (`Shape`), not its arguments.
    pub span: Span,
    /// What it says.
    pub kind: DirectiveKind,
    /// An `Include` among its parameters whose file goes on with them: pbrt-v2 follows it there, pbrt-v3 stops.
    pub include_in_list: Option<Span>,
}

/// A quoted string and where it stands. Bytes that are not UTF-8 were replaced (U+FFFD).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The string, its escapes resolved.
    pub text: String,
    /// Quotation marks included.
    pub span: Span,
}

/// A type string with its parameters: `"sphere" "float radius" 2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Typed {
    /// The type; for `MakeNamedMaterial` and `MakeNamedMedium` the name being defined.
    pub kind: Name,
    /// The parameters.
    pub params: ParamList,
}

/// Which of the two transforms of a moving scene later transform directives change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActiveTransform {
    /// That at the start time.
    Start,
    /// That at the end time.
    End,
    /// Both.
    All,
}

/// The statements of pbrt-v3, and those that only pbrt-v2 had.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // the words of the scene language; their arguments as named there
pub enum DirectiveKind {
    Identity,
    Translate(DVec3),
    Scale(DVec3),
    Rotate {
        degrees: f64,
        axis: DVec3,
    },
    LookAt {
        eye: DVec3,
        look: DVec3,
        up: DVec3,
    },
    /// The sixteen numbers are columns one after the other.
    Transform(Box<DMat4>),
    ConcatTransform(Box<DMat4>),
    CoordinateSystem(Name),
    CoordSysTransform(Name),
    ActiveTransform(ActiveTransform),
    /// Start and end time.
    TransformTimes(f64, f64),
    TransformBegin,
    TransformEnd,
    AttributeBegin,
    AttributeEnd,
    PixelFilter(Typed),
    Film(Typed),
    Sampler(Typed),
    Accelerator(Typed),
    Integrator(Typed),
    Camera(Typed),
    /// pbrt-v2's word for what is `Integrator` in pbrt-v3.
    SurfaceIntegrator(Typed),
    /// pbrt-v2 only.
    VolumeIntegrator(Typed),
    /// pbrt-v2 only.
    Renderer(Typed),
    /// pbrt-v2 only.
    Volume(Typed),
    MakeNamedMedium(Typed),
    /// One name in the file stands for both.
    MediumInterface {
        inside: Name,
        outside: Name,
    },
    WorldBegin,
    WorldEnd,
    Texture {
        name: Name,
        value_type: Name,
        class: Name,
        params: ParamList,
    },
    Material(Typed),
    MakeNamedMaterial(Typed),
    NamedMaterial(Name),
    LightSource(Typed),
    AreaLightSource(Typed),
    Shape(Typed),
    ReverseOrientation,
    ObjectBegin(Name),
    ObjectEnd,
    ObjectInstance(Name),
}

/// Every word that starts a statement, in the order of docs/scene-language.md §2. `Include` is
/// dealt with by the parser and never comes out as a directive.
pub const WORDS: [&str; 41] = [
    "Identity",
    "Translate",
    "Scale",
    "Rotate",
    "LookAt",
    "Transform",
    "ConcatTransform",
    "CoordinateSystem",
    "CoordSysTransform",
    "ActiveTransform",
    "TransformTimes",
    "TransformBegin",
    "TransformEnd",
    "AttributeBegin",
    "AttributeEnd",
    "PixelFilter",
    "Film",
    "Sampler",
    "Accelerator",
    "Integrator",
    "Camera",
    "SurfaceIntegrator",
    "VolumeIntegrator",
    "Renderer",
    "Volume",
    "MakeNamedMedium",
    "MediumInterface",
    "WorldBegin",
    "WorldEnd",
    "Texture",
    "Material",
    "MakeNamedMaterial",
    "NamedMaterial",
    "LightSource",
    "AreaLightSource",
    "Shape",
    "ReverseOrientation",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Include",
];

impl DirectiveKind {
    /// The word the statement starts with.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Identity => "Identity",
            Self::Translate(_) => "Translate",
            Self::Scale(_) => "Scale",
            Self::Rotate { .. } => "Rotate",
            Self::LookAt { .. } => "LookAt",
            Self::Transform(_) => "Transform",
            Self::ConcatTransform(_) => "ConcatTransform",
            Self::CoordinateSystem(_) => "CoordinateSystem",
            Self::CoordSysTransform(_) => "CoordSysTransform",
            Self::ActiveTransform(_) => "ActiveTransform",
            Self::TransformTimes(..) => "TransformTimes",
            Self::TransformBegin => "TransformBegin",
            Self::TransformEnd => "TransformEnd",
            Self::AttributeBegin => "AttributeBegin",
            Self::AttributeEnd => "AttributeEnd",
            Self::PixelFilter(_) => "PixelFilter",
            Self::Film(_) => "Film",
            Self::Sampler(_) => "Sampler",
            Self::Accelerator(_) => "Accelerator",
            Self::Integrator(_) => "Integrator",
            Self::Camera(_) => "Camera",
            Self::SurfaceIntegrator(_) => "SurfaceIntegrator",
            Self::VolumeIntegrator(_) => "VolumeIntegrator",
            Self::Renderer(_) => "Renderer",
            Self::Volume(_) => "Volume",
            Self::MakeNamedMedium(_) => "MakeNamedMedium",
            Self::MediumInterface { .. } => "MediumInterface",
            Self::WorldBegin => "WorldBegin",
            Self::WorldEnd => "WorldEnd",
            Self::Texture { .. } => "Texture",
            Self::Material(_) => "Material",
            Self::MakeNamedMaterial(_) => "MakeNamedMaterial",
            Self::NamedMaterial(_) => "NamedMaterial",
            Self::LightSource(_) => "LightSource",
            Self::AreaLightSource(_) => "AreaLightSource",
            Self::Shape(_) => "Shape",
            Self::ReverseOrientation => "ReverseOrientation",
            Self::ObjectBegin(_) => "ObjectBegin",
            Self::ObjectEnd => "ObjectEnd",
            Self::ObjectInstance(_) => "ObjectInstance",
        }
    }
}
