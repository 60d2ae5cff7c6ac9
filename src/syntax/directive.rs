//! Directives: the statements of a scene file.

use super::parameter::ParamList;
use super::source::Span;
use crate::math::DVec3;
use glam::DMat4;

/// A directive with its location.
#[derive(Clone, Debug, PartialEq)]
pub struct Directive {
    /// Location of the directive's word (`Shape`), without its arguments.
    pub span: Span,
    /// The directive itself.
    pub kind: DirectiveKind,
    /// An `Include` among its parameters whose file continues them: pbrt-v2 follows it there, pbrt-v3 stops.
    pub include_in_list: Option<Span>,
}

/// A quoted string with its location. Bytes that are not UTF-8 are replaced (U+FFFD).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The string, with escapes resolved.
    pub text: String,
    /// Location, including the quotation marks.
    pub span: Span,
}

/// A type string with its parameters: `"sphere" "float radius" 2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Typed {
    /// The type; for `MakeNamedMaterial` and `MakeNamedMedium`, the name being defined.
    pub kind: Name,
    /// The parameters.
    pub params: ParamList,
}

/// Which of the two transforms of an animated scene later transform directives change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActiveTransform {
    /// The one at the start time.
    Start,
    /// The one at the end time.
    End,
    /// Both.
    All,
}

/// The directives of pbrt-v3, and those that only pbrt-v2 had.
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
    /// Sixteen numbers in column-major order.
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
    /// pbrt-v2's name for `Integrator`.
    SurfaceIntegrator(Typed),
    /// pbrt-v2 only.
    VolumeIntegrator(Typed),
    /// pbrt-v2 only.
    Renderer(Typed),
    /// pbrt-v2 only.
    Volume(Typed),
    MakeNamedMedium(Typed),
    /// A single name in the file is used for both.
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

/// Every word that starts a directive, in the order of docs/scene-language.md §2. `Include` is handled by the parser
/// and never returned as a directive.
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
    /// The word that starts the directive.
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
