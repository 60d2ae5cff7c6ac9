//! Mathematics for rendering: vectors come from `glam`, everything else is here.
//!
//! Geometry uses [`glam::Vec3`] and [`glam::DVec3`], never `Vec3A`, whose cross product rounds differently depending on
//! the instruction set it was compiled for.

pub mod adaptive_density;
pub(crate) mod angle;
pub mod cie;
pub mod color;
pub mod distribution;
pub mod float;
pub mod frame;
pub mod hash;
pub mod instruction_set;
pub mod motion;
pub mod ray;
pub(crate) mod rows;
pub mod sampling;
pub mod spectrum;
pub mod spline;
pub mod stepped;
pub mod transform;

pub use glam::{DMat4, DVec2, DVec3, DVec4, IVec2, UVec2, UVec3, Vec2, Vec3, Vec4};

/// Linear RGB with sRGB (Rec. 709) primaries; also reflectances and other per-channel factors.
pub type Rgb = Vec3;
