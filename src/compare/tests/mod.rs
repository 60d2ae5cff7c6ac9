//! What comparisons say of made-up renders: how often they are wrong, and what they find.

mod calibration;
mod cases;
mod power;
mod simulate;
