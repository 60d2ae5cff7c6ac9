//! The block of a scene file that a directive belongs in (docs/scene-language.md §2).

use crate::syntax::DirectiveKind;

/// A part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// Before `WorldBegin`, and again after `WorldEnd`.
    Options,
    /// From `WorldBegin` to `WorldEnd`.
    World,
    /// Either.
    Any,
}

/// The block in which `kind` is legal; elsewhere it is an error, and ignored.
pub fn block_of(kind: &DirectiveKind) -> Block {
    use DirectiveKind as D;
    match kind {
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
        | D::WorldBegin => Block::Options,
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
        | D::WorldEnd => Block::World,
        D::Identity
        | D::Translate(_)
        | D::Scale(_)
        | D::Rotate { .. }
        | D::LookAt { .. }
        | D::Transform(_)
        | D::ConcatTransform(_)
        | D::CoordinateSystem(_)
        | D::CoordSysTransform(_)
        | D::ActiveTransform(_)
        | D::MakeNamedMedium(_)
        | D::MediumInterface { .. } => Block::Any,
    }
}
