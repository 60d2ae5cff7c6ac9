//! FLIP: how different two images look to a viewer who flips between them, per pixel, from 0 (no difference) to 1.
//!
//! LDR-FLIP: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", HPG 2020, with its erratum (p. 10: division by 116). HDR-FLIP:
//! Andersson, Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range
//! Images", Eurographics 2021 short papers: the largest LDR-FLIP over a range of exposures.

mod color;
mod exposure;
mod filter;

#[cfg(test)]
mod tests;

pub use exposure::ExposureRange;

use crate::film::Image;
use crate::math::Rgb;
use color::{ColorSpaces, hyab};
use filter::{ContrastSensitivity, Features, Rows};
use libm::powf;
use rayon::prelude::*;

/// Pixels per degree for a 0.7 m wide screen of 3840 pixels seen from 0.7 m: 3840 · π/180, the papers' default.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Rows processed at once: enough that their surroundings, a dozen rows above and below, cost little, few enough that
/// the dozen channels stay in the cache.
const BAND: usize = 32;

/// The error of every pixel, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// 0…1 for each pixel.
    pub values: Vec<f32>,
}

impl FlipMap {
    /// The mean error, which its authors recommend as the summary.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum::<f64>() / self.values.len().max(1) as f64
    }

    /// The largest error.
    pub fn max(&self) -> f32 {
        self.values.iter().fold(0.0, |most, &v| most.max(v))
    }

    /// The value below which the fraction `share` (0…1) of all pixels lies.
    pub fn quantile(&self, share: f64) -> f32 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f32::total_cmp);
        let index = (share * sorted.len() as f64) as usize;
        sorted
            .get(index.min(sorted.len().saturating_sub(1)))
            .copied()
            .unwrap_or(0.0)
    }
}

/// LDR-FLIP of two images as displayed on a screen: linear values, clamped to 0…1. The papers' reference is `b`; the
/// metric is symmetric.
///
/// Images of different sizes have no common pixels: the map is empty.
pub fn ldr(a: &Image, b: &Image, pixels_per_degree: f64) -> FlipMap {
    Flip::new(pixels_per_degree).map(a, b, |rgb| rgb.clamp(Rgb::ZERO, Rgb::ONE))
}

/// HDR-FLIP with the given exposures (those of the reference, [`ExposureRange::of`]).
pub fn hdr(a: &Image, b: &Image, exposures: &ExposureRange, pixels_per_degree: f64) -> FlipMap {
    let flip = Flip::new(pixels_per_degree);
    let mut worst = FlipMap {
        values: vec![0.0; a.pixels.len().min(b.pixels.len())],
    };
    for stops in exposures.stops() {
        let map = flip.map(a, b, |rgb| exposure::tone_map(rgb, stops));
        for (worst, value) in worst.values.iter_mut().zip(map.values) {
            *worst = worst.max(value);
        }
    }
    worst
}

/// The metric for one viewing distance.
struct Flip {
    spaces: ColorSpaces,
    csf: ContrastSensitivity,
    features: Features,
    /// The largest possible color difference, between green and blue, to the power [`COLOR_POWER`].
    most: f32,
}

/// Large color differences are compressed (Andersson et al. 2020, §4.1.2, q_c).
const COLOR_POWER: f32 = 0.7;

/// Color differences up to this fraction of the largest map to (§4.1.3, p_c)…
const COLOR_KNEE: f32 = 0.4;

/// …this fraction of the result (p_t).
const ERROR_KNEE: f32 = 0.95;

/// Feature differences are amplified (§4.2, q_f).
const FEATURE_POWER: f32 = 0.5;

/// One image's filtered channels over a band.
struct Seen {
    /// L*a*b* with the Hunt adjustment, after the eye's blur.
    color: Vec<Rgb>,
    /// Strengths of edges and of points.
    features: Vec<[f32; 2]>,
}

impl Flip {
    fn new(pixels_per_degree: f64) -> Flip {
        let spaces = ColorSpaces::new();
        let [green, blue] = [Rgb::Y, Rgb::Z].map(|rgb| spaces.hunt_lab_from_rgb(rgb));
        // Extreme viewing distances either way: the kernels only need it to be finite.
        let pixels_per_degree = pixels_per_degree.clamp(1.0, 1000.0);
        Flip {
            spaces,
            csf: ContrastSensitivity::new(pixels_per_degree),
            features: Features::new(pixels_per_degree),
            most: powf(hyab(green, blue), COLOR_POWER),
        }
    }

    /// The error of every pixel, for images displayed through `show`.
    fn map(&self, a: &Image, b: &Image, show: impl Fn(Rgb) -> Rgb + Sync) -> FlipMap {
        let size = a.bounds.size();
        let (width, height) = (size.x as usize, size.y as usize);
        let whole = |image: &Image| image.pixels.len() == width * height;
        if width == 0 || height == 0 || !whole(a) || !whole(b) {
            return FlipMap { values: Vec::new() };
        }
        let bands: Vec<Vec<f32>> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                let (first, end) = (band * BAND, ((band + 1) * BAND).min(height));
                let [a, b] = [a, b].map(|image| self.see(&image.pixels, width, first, end, &show));
                self.differences(&a, &b)
            })
            .collect();
        FlipMap {
            values: bands.concat(),
        }
    }

    /// Filters the rows `first..end`.
    fn see(
        &self,
        pixels: &[Rgb],
        width: usize,
        first: usize,
        end: usize,
        show: impl Fn(Rgb) -> Rgb,
    ) -> Seen {
        let reach = self.csf.luminance.radius().max(self.features.edge.radius());
        let top = first.saturating_sub(reach);
        let bottom = (end + reach).min(pixels.len() / width);
        let shown: Vec<Rgb> = pixels[top * width..bottom * width]
            .iter()
            .map(|&rgb| self.spaces.ycxcz_from_rgb(show(rgb)))
            .collect();
        let channel = |of: &dyn Fn(&Rgb) -> f32| Rows {
            width,
            first: top,
            values: shown.iter().map(of).collect(),
        };
        let blur = |rows: &Rows, kernel| rows.across(kernel).down(kernel, first, end).values;
        let luminance = blur(&channel(&|c| c.x), &self.csf.luminance);
        let red_green = blur(&channel(&|c| c.y), &self.csf.red_green);
        let yellow = channel(&|c| c.z);
        let [(wide, wide_share), (narrow, narrow_share)] = &self.csf.blue_yellow;
        let [wide, narrow] = [wide, narrow].map(|kernel| blur(&yellow, kernel));
        let color = (0..luminance.len()).map(|i| {
            let blue_yellow = wide_share * wide[i] + narrow_share * narrow[i];
            let blurred = Rgb::new(luminance[i], red_green[i], blue_yellow);
            let rgb = self.spaces.rgb_from_ycxcz(blurred);
            self.spaces
                .hunt_lab_from_rgb(rgb.clamp(Rgb::ZERO, Rgb::ONE))
        });
        Seen {
            color: color.collect(),
            features: self.find_features(&channel(&|c| (c.x + 16.0) / 116.0), first, end),
        }
    }

    /// Magnitudes of the luminance's first and second derivatives.
    fn find_features(&self, luminance: &Rows, first: usize, end: usize) -> Vec<[f32; 2]> {
        let Features {
            smooth,
            edge,
            point,
        } = &self.features;
        let smoothed = luminance.across(smooth);
        let derivatives = |kernel| {
            let x = luminance.across(kernel).down(smooth, first, end).values;
            let y = smoothed.down(kernel, first, end).values;
            (x, y)
        };
        let ((edge_x, edge_y), (point_x, point_y)) = (derivatives(edge), derivatives(point));
        (0..edge_x.len())
            .map(|i| [edge_x[i].hypot(edge_y[i]), point_x[i].hypot(point_y[i])])
            .collect()
    }

    fn differences(&self, a: &Seen, b: &Seen) -> Vec<f32> {
        (0..a.color.len())
            .map(|i| {
                let color = self.color_difference(a.color[i], b.color[i]);
                let [edge, point] = [0, 1].map(|k| (a.features[i][k] - b.features[i][k]).abs());
                let features = edge.max(point) * std::f32::consts::FRAC_1_SQRT_2;
                powf(color, 1.0 - powf(features, FEATURE_POWER).min(1.0))
            })
            .collect()
    }

    /// 0…1: [`ERROR_KNEE`] at [`COLOR_KNEE`] of the largest difference, linear on both sides.
    fn color_difference(&self, p: Rgb, q: Rgb) -> f32 {
        let difference = powf(hyab(p, q), COLOR_POWER);
        let knee = COLOR_KNEE * self.most;
        let error = if difference < knee {
            ERROR_KNEE * difference / knee
        } else {
            ERROR_KNEE + (difference - knee) / (self.most - knee) * (1.0 - ERROR_KNEE)
        };
        error.clamp(0.0, 1.0)
    }
}
