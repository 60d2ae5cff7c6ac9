//! Comparisons of simulated renders: their false-alarm rate and their power.

mod calibration;
mod cases;
mod power;
mod simulate;
