//! Lenses, films, distances and rays at the ends of what can be written down: each gives a right answer, measured
//! against a closed form or 32 digits, or a clear error; never a panic, a hang or a NaN.
//!
//! * [`cases`]: the lenses; [`neighborhood`]: what counts as right; [`exact_optics`]: the truth;
//! * [`rays`]: the tracers; [`first_order`]: focal length, pupils, focus; [`light`]: exit pupil and camera;
//! * [`program`]: `fstop lens` and its report.

mod cases;
mod exact_optics;
mod first_order;
mod light;
mod neighborhood;
mod program;
mod rays;
