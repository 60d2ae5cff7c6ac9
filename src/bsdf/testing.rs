//! Statistical tests that every BSDF has to pass.
