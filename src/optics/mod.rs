//! The lens (tour to come).

pub mod focus;
pub mod lens;
pub mod paraxial;
pub mod prescription;
pub mod pupil;
pub mod real;
pub mod surface;
pub mod trace;

pub use lens::{Lens, LensError};
pub use paraxial::{Cardinals, Paraxial, Pupil};
pub use prescription::{Prescription, PrescriptionError, RowNote};
pub use pupil::{ExitPupil, PupilSample};
pub use surface::Surface;
pub use trace::{Blocked, Cause, LensRay, LensTracer};
