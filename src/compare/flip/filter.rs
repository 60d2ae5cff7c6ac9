//! The blurs and edge detectors of FLIP, all made of Gaussians and therefore separable.

/// Filter weights along one axis, from −radius to +radius.
#[derive(Clone, Debug)]
pub(super) struct Kernel(Vec<f32>);

impl Kernel {
    fn of(radius: i32, weight: impl Fn(f64) -> f64) -> Kernel {
        Kernel(
            (-radius..=radius)
                .map(|i| weight(f64::from(i)) as f32)
                .collect(),
        )
    }

    /// exp(−x² · `falloff`), normalized to sum to 1, and the sum before.
    fn gaussian(radius: i32, falloff: f64) -> (Kernel, f64) {
        let weight = |x: f64| (-falloff * x * x).exp();
        let sum: f64 = (-radius..=radius).map(|i| weight(f64::from(i))).sum();
        (Kernel::of(radius, |x| weight(x) / sum), sum)
    }

    /// Positive weights scaled to sum to 1, negative ones to −1.
    fn balanced(radius: i32, weight: impl Fn(f64) -> f64) -> Kernel {
        let sum_of = |sign: f64| -> f64 {
            let weights = (-radius..=radius).map(|i| weight(f64::from(i)));
            weights.map(|w| (sign * w).max(0.0)).sum()
        };
        let (positive, negative) = (sum_of(1.0), sum_of(-1.0));
        Kernel::of(radius, |x| {
            let w = weight(x);
            w / if w > 0.0 { positive } else { negative }
        })
    }

    /// Number of weights to either side of the center.
    pub(super) fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

/// The eye's contrast sensitivity functions: one Gaussian each for luminance and red–green, two for blue–yellow
/// (Andersson et al. 2020, §4.1.1 and table 1, after Mullen 1985 and others, as fitted by Johnson and Fairchild 2003).
#[derive(Clone, Debug)]
pub(super) struct ContrastSensitivity {
    pub luminance: Kernel,
    pub red_green: Kernel,
    /// Kernels with their weights.
    pub blue_yellow: [(Kernel, f32); 2],
}

impl ContrastSensitivity {
    /// The functions for `pixels_per_degree` pixels per degree of the visual field.
    pub(super) fn new(pixels_per_degree: f64) -> ContrastSensitivity {
        /// Width parameters of the three channels, in squared degrees.
        const LUMINANCE: f64 = 0.0047;
        const RED_GREEN: f64 = 0.0053;
        /// (weight, width) of both parts.
        const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
        use std::f64::consts::PI;
        // Three standard deviations of the widest kernel.
        let widest = BLUE_YELLOW[0].1;
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
        let radius = (radius as i32).max(1);
        let gaussian = |width: f64| {
            Kernel::gaussian(
                radius,
                PI * PI / (width * pixels_per_degree * pixels_per_degree),
            )
        };
        let parts = BLUE_YELLOW.map(|(weight, width)| {
            let (kernel, sum) = gaussian(width);
            (kernel, weight * (PI / width).sqrt() * sum * sum)
        });
        let whole: f64 = parts.iter().map(|(_, share)| share).sum();
        ContrastSensitivity {
            luminance: gaussian(LUMINANCE).0,
            red_green: gaussian(RED_GREEN).0,
            blue_yellow: parts.map(|(kernel, share)| (kernel, (share / whole) as f32)),
        }
    }
}

/// Detectors of edges and points: first and second derivatives of a Gaussian as wide as the eye's (§4.2).
#[derive(Clone, Debug)]
pub(super) struct Features {
    pub smooth: Kernel,
    pub edge: Kernel,
    pub point: Kernel,
}

impl Features {
    pub(super) fn new(pixels_per_degree: f64) -> Features {
        /// Width of the eye's edge detector in degrees (§4.2, after Marr and Hildreth).
        const WIDTH: f64 = 0.082;
        let sigma = 0.5 * WIDTH * pixels_per_degree;
        let radius = ((3.0 * sigma).ceil() as i32).max(1);
        let falloff = 0.5 / (sigma * sigma);
        let gaussian = move |x: f64| (-falloff * x * x).exp();
        Features {
            smooth: Kernel::gaussian(radius, falloff).0,
            edge: Kernel::balanced(radius, |x| -x * gaussian(x)),
            point: Kernel::balanced(radius, |x| (x * x / (sigma * sigma) - 1.0) * gaussian(x)),
        }
    }
}

/// A range of rows of one channel.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub width: usize,
    /// Index in the image of the first row.
    pub first: usize,
    pub values: Vec<f32>,
}

impl Rows {
    /// Filters along the rows, repeating the last value beyond their ends.
    pub(super) fn across(&self, kernel: &Kernel) -> Rows {
        let radius = kernel.radius();
        let mut padded = vec![0.0; self.width + 2 * radius];
        let mut values = vec![0.0; self.values.len()];
        for (row, out) in self
            .values
            .chunks_exact(self.width)
            .zip(values.chunks_exact_mut(self.width))
        {
            padded[..radius].fill(row[0]);
            padded[radius..radius + self.width].copy_from_slice(row);
            padded[radius + self.width..].fill(row[self.width - 1]);
            for (offset, &weight) in kernel.0.iter().enumerate() {
                for (o, &v) in out.iter_mut().zip(&padded[offset..]) {
                    *o += weight * v;
                }
            }
        }
        Rows { values, ..*self }
    }

    /// Filters along the columns, for the image's rows `first..end`. Rows beyond those available repeat the outermost,
    /// as is right at the image's edges; elsewhere as many rows are available as the kernel reaches.
    pub(super) fn down(&self, kernel: &Kernel, first: usize, end: usize) -> Rows {
        let rows: Vec<&[f32]> = self.values.chunks_exact(self.width).collect();
        let mut values = vec![0.0; (end - first) * self.width];
        for (y, out) in (first..end).zip(values.chunks_exact_mut(self.width)) {
            for (offset, &weight) in kernel.0.iter().enumerate() {
                let from = (y + offset).saturating_sub(kernel.radius() + self.first);
                let row = rows[from.min(rows.len() - 1)];
                for (o, &v) in out.iter_mut().zip(row) {
                    *o += weight * v;
                }
            }
        }
        Rows {
            width: self.width,
            first,
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kernel: &Kernel) -> f32 {
        kernel.0.iter().sum()
    }

    #[test]
    fn blurs_keep_and_detectors_cancel_what_is_flat() {
        let csf = ContrastSensitivity::new(67.0);
        let features = Features::new(67.0);
        for kernel in [
            &csf.luminance,
            &csf.red_green,
            &csf.blue_yellow[0].0,
            &features.smooth,
        ] {
            assert!((sum(kernel) - 1.0).abs() < 1e-6);
        }
        assert!((csf.blue_yellow[0].1 + csf.blue_yellow[1].1 - 1.0).abs() < 1e-6);
        for kernel in [&features.edge, &features.point] {
            assert!(sum(kernel).abs() < 1e-6);
            let positive: f32 = kernel.0.iter().filter(|w| **w > 0.0).sum();
            assert!((positive - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn edges_repeat() {
        let rows = Rows {
            width: 3,
            first: 0,
            values: vec![1.0, 1.0, 1.0, 5.0, 5.0, 5.0],
        };
        let kernel = Kernel(vec![0.25, 0.5, 0.25]);
        assert_eq!(rows.across(&kernel).values, rows.values);
        assert_eq!(
            rows.down(&kernel, 0, 2).values,
            [2.0, 2.0, 2.0, 4.0, 4.0, 4.0]
        );
        assert_eq!(rows.down(&kernel, 1, 2).values, [4.0, 4.0, 4.0]);
    }

    /// Bands must be invisible: rows filtered with their surroundings give the same result as the whole image.
    #[test]
    fn bands_agree_with_the_whole() {
        let values: Vec<f32> = (0..9 * 40).map(|i| ((i * i) % 101) as f32).collect();
        let whole = Rows {
            width: 9,
            first: 0,
            values,
        };
        let kernel = Features::new(67.0).edge;
        let expected = whole.down(&kernel, 15, 20);
        let (first, end) = (15 - kernel.radius(), 20 + kernel.radius());
        let part = Rows {
            width: 9,
            first,
            values: whole.values[first * 9..end * 9].to_vec(),
        };
        assert_eq!(part.down(&kernel, 15, 20).values, expected.values);
    }
}
