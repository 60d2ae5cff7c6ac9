//! Writes `.brdf` files from formulas, for tests of this crate and, by its path, of the program. Independent of the
//! reader.

use std::f64::consts::{FRAC_PI_2, PI};

/// Pairs of directions, as θi, φi, θo, φo: all pairs of `thetas` angles, each at `phis` differences of azimuth from 0 to π.
pub(crate) fn pairs(thetas: usize, phis: usize) -> Vec<[f64; 4]> {
    let theta = |i: usize| FRAC_PI_2 * (i as f64 + 0.5) / thetas as f64;
    let all = (0..thetas).flat_map(|i| (0..thetas).map(move |o| (i, o)));
    all.flat_map(|(i, o)| {
        // Only the difference of azimuths matters.
        let phi_o = (i + 2 * o) as f64;
        let phi = move |k: usize| phi_o + PI * k as f64 / (phis - 1) as f64;
        (0..phis).map(move |k| [theta(i), phi(k), theta(o), phi_o])
    })
    .collect()
}

/// The text of a file with these wavelengths and pairs of directions, and the formula's values there.
pub(crate) fn encode(
    wavelengths: &[f64],
    pairs: &[[f64; 4]],
    value: &dyn Fn([f64; 4]) -> Vec<f64>,
) -> String {
    let line = |numbers: &[f64]| {
        let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
        words.join(" ") + "\n"
    };
    let head = format!("# made from a formula\n{}\n", wavelengths.len());
    let samples = pairs
        .iter()
        .map(|pair| line(&[&pair[..], &value(*pair)].concat()));
    head + &line(wavelengths) + &samples.collect::<String>()
}
