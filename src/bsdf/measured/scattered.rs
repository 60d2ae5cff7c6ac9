//! BRDFs known at scattered pairs of directions, interpolated as pbrt-v2 does (Pharr and Humphreys 2010, §8.6.1): pairs
//! are mapped to points in space as by Marschner et al. 1999 ("Image-Based BRDF Measurement Including Human Skin"), and
//! the measured ones around a query point are averaged.

use crate::assets::brdf_file::BrdfFile;
use crate::math::color::is_black;
use crate::math::spectrum::rgb_from_samples;
use crate::math::{Rgb, Vec3};
use glam::DVec3;
use std::f32::consts::FRAC_1_PI;

/// Square of the initial search radius.
const FIRST: f32 = 0.001;

/// Number of doublings after which all points are within: no two are farther apart than √6.
const DOUBLINGS: i32 = 13;

/// Square of the radius beyond which one measured pair is enough; within it, three are required.
const ENOUGH: f32 = 1.5;

/// The measured pairs as a k-d tree (Bentley 1975): the median of a range splits it along an axis, and axes alternate.
/// A search does not allocate and handles any number of equal points, unlike the usual crates.
#[derive(Clone, PartialEq)]
pub(super) struct Scattered {
    points: Vec<MeasuredSample>,
}

/// A measured pair.
#[derive(Clone, Copy, PartialEq)]
struct MeasuredSample {
    at: Vec3,
    /// BRDF in 1/sr.
    value: Rgb,
}

/// The result of a search.
#[derive(Default)]
struct Found {
    count: usize,
    weights: f64,
    /// Weighted sum of values.
    sum: DVec3,
}

impl Scattered {
    pub(super) fn new(file: &BrdfFile) -> Scattered {
        let weights = channel_weights(&file.wavelengths);
        let points = file
            .samples()
            .map(|([theta_i, phi_i, theta_o, phi_o], values)| {
                let color: DVec3 = weights.iter().zip(values).map(|(w, v)| *w * *v).sum();
                MeasuredSample {
                    at: place(direction(theta_o, phi_o), direction(theta_i, phi_i)),
                    value: color.as_vec3(),
                }
            });
        let mut points: Vec<MeasuredSample> = points.collect();
        arrange(&mut points, 0);
        Scattered { points }
    }

    pub(super) fn is_black(&self) -> bool {
        let black = |point: &MeasuredSample| is_black(point.value.max(Rgb::ZERO));
        self.points.iter().all(black)
    }

    /// The BRDF, in 1/sr. The same below the surface as above.
    pub(super) fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let at = place(wo, wi);
        for doubling in 0..=DOUBLINGS {
            let within = FIRST * 2f32.powi(doubling);
            let mut found = Found::default();
            visit(&self.points, 0, at, within, &mut found);
            if found.count > 2 || (found.count > 0 && within > ENOUGH) {
                return (found.sum / found.weights).as_vec3().max(Rgb::ZERO);
            }
        }
        // For NaN directions.
        Rgb::ZERO
    }
}

/// The color of a value of 1 at each wavelength and 0 at the others: the conversion is linear.
fn channel_weights(wavelengths: &[f64]) -> Vec<DVec3> {
    let mut order: Vec<usize> = (0..wavelengths.len()).collect();
    order.sort_by(|&a, &b| wavelengths[a].total_cmp(&wavelengths[b]));
    let mut pairs: Vec<(f64, f64)> = order.iter().map(|&i| (wavelengths[i], 0.0)).collect();
    let mut weights = vec![DVec3::ZERO; wavelengths.len()];
    for (rank, &i) in order.iter().enumerate() {
        pairs[rank].1 = 1.0;
        weights[i] = rgb_from_samples(&pairs).as_dvec3();
        pairs[rank].1 = 0.0;
    }
    weights
}

fn direction(theta: f64, phi: f64) -> Vec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    DVec3::new(sin * cos_phi, sin * sin_phi, cos).as_vec3()
}

/// sin θi sin θo, the difference of azimuths over π (0 to 1), cos θi cos θo. Swapping the directions does not change a
/// bit.
fn place(wo: Vec3, wi: Vec3) -> Vec3 {
    let (o, i) = (wo.truncate(), wi.truncate());
    let between = o.perp_dot(i).abs().atan2(o.dot(i));
    Vec3::new(o.length() * i.length(), between * FRAC_1_PI, wo.z * wi.z)
}

/// Builds a tree whose root splits along `axis`.
fn arrange(points: &mut [MeasuredSample], axis: usize) {
    if points.len() > 1 {
        let middle = points.len() / 2;
        let along = |a: &MeasuredSample, b: &MeasuredSample| a.at[axis].total_cmp(&b.at[axis]);
        let (low, _, high) = points.select_nth_unstable_by(middle, along);
        arrange(low, (axis + 1) % 3);
        arrange(high, (axis + 1) % 3);
    }
}

/// Adds all points nearer than the square root of `within`.
fn visit(points: &[MeasuredSample], axis: usize, at: Vec3, within: f32, found: &mut Found) {
    let middle = points.len() / 2;
    let (low, rest) = points.split_at(middle);
    let Some((point, high)) = rest.split_first() else {
        return;
    };
    let squared = point.at.distance_squared(at);
    if squared < within {
        // exp(-100 d²), scaled against underflow when all points are far; the ratios stay the same.
        let weight = f64::from(100.0 * (within - squared)).exp();
        found.count += 1;
        found.weights += weight;
        found.sum += weight * point.value.as_dvec3();
    }
    let beyond = at[axis] - point.at[axis];
    let (near, far) = if beyond < 0.0 {
        (low, high)
    } else {
        (high, low)
    };
    visit(near, (axis + 1) % 3, at, within, found);
    if beyond * beyond < within {
        visit(far, (axis + 1) % 3, at, within, found);
    }
}
