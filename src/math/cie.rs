//! The CIE 1931 2° standard observer.

use std::sync::LazyLock;

/// Wavelength in nm of the first row of [`COLOR_MATCHING`]; rows follow at 1 nm steps.
pub const FIRST_WAVELENGTH: u32 = 360;

/// Color matching functions x̄, ȳ, z̄ of the CIE 1931 2° standard observer, 360 to 830 nm at 1 nm. The file names their
/// source.
pub static COLOR_MATCHING: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let lines = include_str!("cie_1931.csv").lines();
    lines.filter_map(row).collect()
});

/// x̄, ȳ and z̄ of a line; `None` for a comment.
fn row(line: &str) -> Option<[f64; 3]> {
    let (_wavelength, functions) = line.split_once(',')?;
    let functions: Result<Vec<f64>, _> = functions.split(',').map(str::parse).collect();
    functions.ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bell curve with different widths to the left and right of its peak.
    fn lobe(wavelength: f64, top: f64, left: f64, right: f64) -> f64 {
        let t = (wavelength - top) * if wavelength < top { left } else { right };
        (-0.5 * t * t).exp()
    }

    /// The multi-lobe fit of Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE
    /// XYZ Color Matching Functions", JCGT 2(2), 2013, equation 4.
    fn fit(w: f64) -> [f64; 3] {
        [
            1.056 * lobe(w, 599.8, 0.0264, 0.0323) + 0.362 * lobe(w, 442.0, 0.0624, 0.0374)
                - 0.065 * lobe(w, 501.1, 0.0490, 0.0382),
            0.821 * lobe(w, 568.8, 0.0213, 0.0247) + 0.286 * lobe(w, 530.9, 0.0613, 0.0322),
            1.217 * lobe(w, 437.0, 0.0845, 0.0278) + 0.681 * lobe(w, 459.0, 0.0385, 0.0725),
        ]
    }

    #[test]
    fn every_row_is_read() {
        assert_eq!(COLOR_MATCHING.len(), 471);
        for (wavelength, line) in
            (FIRST_WAVELENGTH..).zip(include_str!("cie_1931.csv").lines().skip(4))
        {
            assert!(line.starts_with(&format!("{wavelength},")), "{line}");
        }
    }

    #[test]
    fn table_follows_the_published_fit() {
        for (i, row) in COLOR_MATCHING.iter().enumerate() {
            let w = (FIRST_WAVELENGTH + i as u32) as f64;
            // Just above the fit's own worst errors (0.0140, 0.0080, 0.0222); a table shifted by
            // one row misses it by at least 0.0278, 0.0221 and 0.0758.
            for ((table, fit), tolerance) in row.iter().zip(fit(w)).zip([0.015, 0.009, 0.023]) {
                assert!(
                    (table - fit).abs() < tolerance,
                    "{w} nm: {table} but fitted {fit}"
                );
            }
        }
    }

    #[test]
    fn rows_change_smoothly() {
        // A wrong digit would stand out against its neighbors. The largest second differences are 0.0014, 0.0010 and
        // 0.0068, all where the curves bend most.
        for w in COLOR_MATCHING.windows(3) {
            for (k, tolerance) in [0.0015, 0.0011, 0.0070].into_iter().enumerate() {
                assert!(
                    (w[0][k] - 2.0 * w[1][k] + w[2][k]).abs() < tolerance,
                    "{w:?}"
                );
            }
        }
    }

    #[test]
    fn sums_are_the_published_ones() {
        let sum = |k: usize| COLOR_MATCHING.iter().map(|row| row[k]).sum::<f64>();
        // The three sums are nearly equal by the definition of the equal-energy white; pbrt-v3
        // publishes 106.856895 for ȳ from values rounded to single precision.
        assert!((sum(1) - 106.856_895).abs() < 5e-5);
        assert!((sum(0) - 106.865_469).abs() < 5e-5);
        assert!((sum(2) - 106.892_251).abs() < 5e-5);
        let largest = COLOR_MATCHING.iter().map(|r| r[1]).fold(0.0, f64::max);
        assert_eq!(largest, 1.0, "ȳ peaks at 1 by definition");
        assert_eq!(COLOR_MATCHING[555 - FIRST_WAVELENGTH as usize][1], 1.0);
    }
}
