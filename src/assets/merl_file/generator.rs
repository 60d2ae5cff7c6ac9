//! Writes MERL tables from formulas, for tests of this crate and, by its path, of the program. Independent of the
//! reader.

use std::f64::consts::{FRAC_PI_2, PI};

/// The bytes of a file with these numbers of θh, θd and φd, and the BRDF's red, green and blue in 1/sr at the center of
/// each cell.
pub(crate) fn encode(counts: [usize; 3], value: &dyn Fn(f64, f64, f64) -> [f64; 3]) -> Vec<u8> {
    let mut planes = <[Vec<u8>; 3]>::default();
    let middle = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    for h in 0..counts[0] {
        for d in 0..counts[1] {
            for phi in 0..counts[2] {
                let (theta_h, theta_d) = (middle(h, counts[0]).powi(2), middle(d, counts[1]));
                let phi_d = PI * middle(phi, counts[2]);
                let color = value(FRAC_PI_2 * theta_h, FRAC_PI_2 * theta_d, phi_d);
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let stored = color[channel] * [1500.0, 1500.0 / 1.15, 1500.0 / 1.66][channel];
                    plane.extend(stored.to_le_bytes());
                }
            }
        }
    }
    let header = counts
        .iter()
        .flat_map(|&count| (count as i32).to_le_bytes());
    header.chain(planes.concat()).collect()
}
