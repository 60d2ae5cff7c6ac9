//! The lens (tour to come).

pub mod focus;
pub mod paraxial;
pub mod prescription;
pub mod real;
pub mod surface;
pub mod trace;

pub use paraxial::{Cardinals, Paraxial, Pupil};
pub use prescription::{Prescription, PrescriptionError, RowNote};
pub use surface::Surface;
pub use trace::{Blocked, Cause, LensRay, LensTracer};
