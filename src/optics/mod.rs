//! The lens: from a prescription to exact rays. This folder stands alone; it can be read, tested
//! and used without the renderer.
//!
//! A tour, in the order data goes:
//!
//! 1. [`prescription`] reads lens files into [`Surface`]s ([`surface`]), scene to film.
//! 2. [`lens`] puts a film behind them: a [`Lens`] answers everything below.
//! 3. [`trace`] follows a ray through every surface, from the film or from the scene, and says where and
//!    why it ends if it does. It is generic over the number type ([`real`]): f64 is the truth, f32 the fast path, dual
//!    numbers carry the derivatives that texture footprints need.
//! 4. [`paraxial`] has the focal length, principal planes and pupils; [`focus`] moves the film, [`depth_of_field`]
//!    says how much is sharp then.
//! 5. [`f_number`] sets the stop by f-number or T-number; [`stops`] finds which aperture limits the light, [`stop_shape`] gives it another than a round shape; [`pupil`] says where rays from a film point should be
//!    aimed so that few are lost and no light is; [`entrance`] says the same for points of the scene.
//! 6. [`lanes`] trace bundles of rays side by side in single precision: the fast path.
//! 7. [`models`] are the three of textbooks: the exact, the thick and the thin lens.
//! 8. [`ghosts`] follows the light that surfaces reflect, by what their [`coating`]s let through.
//! 9. [`report`] prints it all; [`breathing`] how the view changes with focus.
//!
//! Coordinates throughout: millimeters, origin at the vertex of the first (scene-side) surface, **z toward the
//! film**; the film lies at `length + film_distance`. Indices of refraction are at the d line, 587.56 nm.
//!
//! ```
//! use fstop::glam::Vec2;
//! use fstop::optics::pupil::RINGS;
//! use fstop::optics::{ExitPupil, Lens, Prescription};
//!
//! // A biconvex lens with a stop behind it, focused at a meter from the film.
//! let mut prescription = Prescription::parse("50 5 1.5168 20\n-50 2 1 20\n0 0 0 10\n")?;
//! prescription.set_stops(8.0);
//! let lens = Lens::new(&prescription, Lens::focused(&prescription, 1000.0)?)?;
//! let focal_length = lens.paraxial().cardinals.map(|c| c.focal_length);
//! assert!((focal_length.unwrap_or(0.0) - 49.2).abs() < 0.1);
//!
//! // A ray from a film point 10 mm off the axis, through a sample of the exit pupil.
//! let pupil = ExitPupil::new(&lens, 21.6, RINGS);
//! let film = [10.0, 0.0];
//! let sample = pupil.sample(film, Vec2::new(0.3, 0.6)).ok_or("dark")?;
//! let ray = lens.trace_from_film(film, sample.point).map_err(|blocked| blocked.to_string())?;
//! assert!(ray.d[2] < 0.0 && ray.d[0] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analysis;
pub mod asphere;
pub mod best_focus;
mod bisection;
pub mod breathing;
pub mod catalogue_formula;
pub mod coating;
pub mod depth_of_field;
pub mod dispersion;
mod element;
pub mod entrance;
pub mod f_number;
pub mod focus;
pub mod ghosts;
pub mod lanes;
pub mod lens;
pub mod models;
pub mod paraxial;
pub mod prescription;
pub mod pupil;
pub mod real;
pub mod report;
pub mod stop_shape;
pub mod stops;
pub mod surface;
pub mod trace;
#[cfg(test)]
mod trace_tests;

pub use focus::FocusError;
pub use lens::{Lens, LensError};
pub use paraxial::{Cardinals, Paraxial, Pupil};
pub use prescription::{Prescription, PrescriptionError, RowNote};
pub use pupil::{ExitPupil, PupilSample};
pub use report::LensReport;
pub use stop_shape::StopShape;
pub use surface::Surface;
pub use trace::{Blocked, Cause, LensRay, LensTracer};
