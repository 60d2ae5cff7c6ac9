//! Writes `.bsdf` files from formulas, for tests of this crate and, by its path, of the program. Independent of the
//! reader.

use std::f64::consts::PI;

/// A BSDF in closed form, with the resolution of its table.
pub(crate) struct Analytic<'a> {
    /// Refractive index of the inside over that of the outside.
    pub eta: f32,
    /// 1 or 3.
    pub channels: usize,
    /// Number of cosines, even: 0 occurs twice, as layerlab writes it, once for either side.
    pub cosines: usize,
    /// Number of terms in the longest series.
    pub terms: usize,
    /// π times the BSDF in red, green and blue (before the scaling of radiance between media), from the cosines of the
    /// incoming light's direction of travel and of the outgoing direction, which have opposite signs for reflection,
    /// and the difference of their azimuths.
    pub value: &'a dyn Fn(f64, f64, f64) -> [f64; 3],
}

/// The file's bytes.
pub(crate) fn encode(analytic: &Analytic) -> Vec<u8> {
    let mu = cosines(analytic.cosines);
    let (mut series, mut coefficients) = (Vec::new(), Vec::<f32>::new());
    for &mu_o in &mu {
        for &mu_i in &mu {
            let terms = project(analytic, mu_i, mu_o);
            series.extend([coefficients.len() as u32, terms[0].len() as u32]);
            for channel in &terms {
                coefficients.extend(channel.iter().map(|&a| a as f32));
            }
        }
    }
    let mut bytes = b"SCATFUN\x01".to_vec();
    let longest = series.chunks(2).map(|s| s[1]).max().unwrap_or(0);
    let (n, count) = (mu.len() as u32, coefficients.len() as u32);
    for word in [1, n, count, longest, analytic.channels as u32, 1, 0, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(analytic.eta.to_le_bytes());
    bytes.extend([0; 16]);
    let mut floats = |values: &[f32]| values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    floats(&mu.iter().map(|&mu| written(mu)).collect::<Vec<_>>());
    // The running integrals are not used.
    floats(&vec![0.0; mu.len() * mu.len()]);
    series
        .iter()
        .for_each(|word| bytes.extend(word.to_le_bytes()));
    coefficients
        .iter()
        .for_each(|a| bytes.extend(a.to_le_bytes()));
    bytes
}

/// Used for the cosine 0 on either side, so that a formula sees which side it is.
const GRAZING: f64 = 1e-9;

/// A cosine as stored in the file.
fn written(mu: f64) -> f32 {
    if mu.abs() > GRAZING { mu as f32 } else { 0.0 }
}

/// Cosines from -1 to 1, dense around 0 and at the ends of both halves.
fn cosines(count: usize) -> Vec<f64> {
    let half = count / 2;
    let inner = |i: usize| {
        let t = i as f64 / (half - 1) as f64;
        (0.5 * (1.0 - (PI * t).cos())).max(GRAZING)
    };
    let upper: Vec<f64> = (0..half).map(inner).collect();
    upper
        .iter()
        .rev()
        .map(|mu| -mu)
        .chain(upper.iter().copied())
        .collect()
}

/// The coefficients of one pair of cosines: luminance alone, or luminance, red and blue. Trailing terms that are 0 in
/// single precision are dropped.
fn project(analytic: &Analytic, mu_i: f64, mu_o: f64) -> Vec<Vec<f64>> {
    let steps = 4 * analytic.terms.max(8);
    let mut terms = vec![vec![0.0; analytic.terms]; analytic.channels];
    for step in 0..steps {
        let phi = PI * (step as f64 + 0.5) / steps as f64;
        let [r, g, b] = (analytic.value)(mu_i, mu_o, phi);
        // The weights by which the reader computes green from the other three.
        let luminance = (g + 0.100913 * b + 0.297375 * r) / 1.39829;
        for (channel, value) in terms.iter_mut().zip([luminance, r, b]) {
            for (k, a) in channel.iter_mut().enumerate() {
                let norm = if k == 0 { 1.0 } else { 2.0 } / steps as f64;
                *a += norm * value * mu_i.abs() / PI * (k as f64 * phi).cos();
            }
        }
    }
    let counts = |channel: &Vec<f64>| channel.iter().rposition(|a| a.abs() > 1e-8);
    let length = terms
        .iter()
        .filter_map(counts)
        .max()
        .map_or(0, |last| last + 1);
    terms
        .iter_mut()
        .for_each(|channel| channel.truncate(length));
    terms
}
