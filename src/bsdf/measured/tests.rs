//! Tables made from formulas, against the formulas.

use super::*;
use crate::assets::brdf_file::generator::{self as list, pairs};
use crate::assets::merl_file::generator as merl;
use crate::bsdf::testing::{direction, random};
use crate::math::spectrum::rgb_from_samples;
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Rounding error of single precision.
const ROUNDING: f32 = 1e-5;

/// A diffuse surface with a broad highlight around the half vector: reciprocal and energy-conserving.
fn glossy(theta_h: f64) -> f64 {
    0.4 / PI + 0.1 * theta_h.cos().max(0.0).powi(16)
}

/// The table of [`glossy`] with these numbers of half angles, difference angles and azimuths.
pub(crate) fn glossy_table(counts: [usize; 3]) -> MeasuredTable {
    table(counts, &|h, _, _| [glossy(h); 3])
}

fn table(counts: [usize; 3], value: &dyn Fn(f64, f64, f64) -> [f64; 3]) -> MeasuredTable {
    let file = MerlFile::parse(&merl::encode(counts, value)).expect("a good file");
    MeasuredTable::from_merl(file)
}

/// [`glossy`] at pairs of `thetas` angles, in `phis` steps of azimuth.
pub(crate) fn glossy_list(thetas: usize, phis: usize) -> MeasuredTable {
    let text = list::encode(&[550.0], &pairs(thetas, phis), &|angles| {
        let (wo, wi) = directions(angles);
        let h = (wo + wi).normalize();
        // Flat spectra are reddish and above 1.
        vec![0.8 * glossy(h.z.acos())]
    });
    scattered(&text)
}

fn scattered(text: &str) -> MeasuredTable {
    MeasuredTable::from_brdf(&BrdfFile::parse(text.as_bytes()).expect("a good file"))
}

/// The directions to the viewer and to the light.
fn directions([theta_i, phi_i, theta_o, phi_o]: [f64; 4]) -> (DVec3, DVec3) {
    let at = |theta: f64, phi: f64| {
        DVec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    };
    (at(theta_o, phi_o), at(theta_i, phi_i))
}

/// A pair of directions above the surface.
fn pair(i: u64) -> (Vec3, Vec3) {
    let ((a, u), (b, _)) = (random(i), random(i + 1_000_000));
    (
        direction(88.0 * a, 360.0 * u.x),
        direction(88.0 * b, 360.0 * u.y),
    )
}

/// All results are valid numbers, whatever the table.
pub(crate) fn do_no_harm(table: &MeasuredTable) {
    let lobe = MeasuredLobe::new(table);
    for i in 0..20 {
        let (wo, wi) = pair(i);
        let wi = if i % 5 == 0 { -wi } else { wi };
        let (f, pdf) = (lobe.f(wo, wi), lobe.pdf(wo, wi));
        assert!(f.is_finite() && f.min_element() >= 0.0 && pdf.is_finite() && pdf >= 0.0);
        let (_, u) = random(i);
        if let Some(sample) = lobe.sample(wo, u) {
            assert!(sample.f.is_finite() && sample.pdf > 0.0 && sample.wi.is_normalized());
        }
    }
}

/// Half and difference angles by the two rotations of Rusinkiewicz's paper.
fn turned(wo: Vec3, wi: Vec3) -> [f64; 3] {
    let (wo, wi) = (wo.as_dvec3().normalize(), wi.as_dvec3().normalize());
    let h = (wo + wi).normalize();
    let turn = DQuat::from_rotation_y(-h.z.acos()) * DQuat::from_rotation_z(-h.y.atan2(h.x));
    let d = turn * wi;
    [h.z.acos(), d.z.acos(), d.y.atan2(d.x).rem_euclid(PI)]
}

#[test]
fn each_pair_of_directions_finds_its_cell() {
    let counts = [18, 10, 12];
    // A color that identifies the cell.
    let value = |h: f64, d: f64, phi: f64| [0.1 + h, 0.1 + d, 0.1 + phi];
    let table = table(counts, &value);
    let lobe = MeasuredLobe::new(&table);
    let mut checked = 0;
    for i in 0..5000 {
        let (wo, wi) = pair(i);
        let [h, d, phi] = turned(wo, wi);
        let at = [
            (h / FRAC_PI_2).sqrt() * 18.0,
            d / FRAC_PI_2 * 10.0,
            phi / PI * 12.0,
        ];
        // Near the boundary of a cell, rounding decides.
        if at.iter().any(|x| (x - x.round()).abs() < 1e-3) {
            continue;
        }
        let [h, d, phi] = at.map(|x| x.floor() + 0.5);
        let expected = value(
            FRAC_PI_2 * (h / 18.0).powi(2),
            FRAC_PI_2 * d / 10.0,
            PI * phi / 12.0,
        );
        let expected = Rgb::from(expected.map(|x| x as f32));
        for f in [lobe.f(wo, wi), lobe.f(wi, wo), lobe.f(-wo, -wi)] {
            assert!(
                (f - expected).abs().max_element() < ROUNDING,
                "{wo} {wi}: {f} {expected}"
            );
        }
        checked += 1;
    }
    assert!(checked > 4900, "{checked}");
}

/// The innermost cells of the database are 0.011°, 0.033°, 0.056° … wide: half angles of single-precision directions
/// can be told apart.
#[test]
fn the_narrowest_cells_are_told_apart() {
    let table = table([90, 2, 2], &|h, _, _| [h * 1000.0; 3]);
    for i in 1..30 {
        let h = FRAC_PI_2 * ((f64::from(i) + 0.5) / 90.0).powi(2);
        // Wide apart, with the half vector tilted by h.
        let at = |theta: f64| DVec3::new(theta.sin(), 0.0, theta.cos()).as_vec3();
        let f = MeasuredLobe::new(&table).f(at(0.7 + h), at(h - 0.7));
        assert!((f64::from(f.x) - h * 1000.0).abs() < 1e-4, "{i}: {f}");
    }
}

#[test]
fn a_fine_table_is_its_formula() {
    let table = glossy_table([90, 4, 4]);
    for i in 0..2000 {
        let (wo, wi) = pair(i);
        let expected = glossy(turned(wo, wi)[0]);
        let f = f64::from(MeasuredLobe::new(&table).f(wo, wi).x);
        // Half a cell is up to 0.0174 of θh, and the highlight falls by up to 0.246 per radian.
        assert!((f - expected).abs() < 0.0174 * 0.25, "{f} {expected}");
    }
}

#[test]
fn equal_samples_are_that_value_everywhere() {
    let (wavelengths, values) = ([450.0, 520.0, 640.0], vec![0.1, 0.3, 0.2]);
    let text = list::encode(&wavelengths, &pairs(5, 4), &|_| values.clone());
    let table = scattered(&text);
    let samples: Vec<_> = wavelengths.into_iter().zip(values.clone()).collect();
    let expected = rgb_from_samples(&samples);
    for i in 0..200 {
        let (wo, wi) = pair(i);
        let f = MeasuredLobe::new(&table).f(wo, wi);
        assert!(
            (f - expected).abs().max_element() < ROUNDING,
            "{f} {expected}"
        );
    }
    // Wavelengths may come in any order.
    let turned = list::encode(&[640.0, 450.0, 520.0], &pairs(1, 2), &|_| {
        vec![0.2, 0.1, 0.3]
    });
    let f = MeasuredLobe::new(&scattered(&turned)).f(Vec3::Z, Vec3::Z);
    assert!(
        (f - expected).abs().max_element() < ROUNDING,
        "{f} {expected}"
    );
}

/// pbrt-v2's search, reimplemented without a tree and in double precision.
#[test]
fn samples_around_are_weighted_as_by_pbrt_v2() {
    let value = |[ti, pi, to, po]: [f64; 4]| vec![0.2 + 0.1 * (ti * to).sin() + 0.05 * (pi - po)];
    for (thetas, phis) in [(10, 8), (3, 2), (1, 2)] {
        let angles = pairs(thetas, phis);
        let table = scattered(&list::encode(&[500.0], &angles, &value));
        let flat = rgb_from_samples(&[(500.0, 1.0)]);
        let place = |[ti, pi, to, po]: [f64; 4]| {
            let turn = (pi - po).rem_euclid(2.0 * PI);
            let turn = if turn > PI { 2.0 * PI - turn } else { turn };
            DVec3::new(ti.sin() * to.sin(), turn / PI, ti.cos() * to.cos())
        };
        for i in 0..500 {
            let ((a, u), (b, _)) = (random(i), random(i + 1_000_000));
            let asked = [1.5 * a, 6.0 * u.x, 1.5 * b, 6.0 * u.y].map(f64::from);
            let distances = angles
                .iter()
                .map(|angles| place(*angles).distance_squared(place(asked)));
            let distances: Vec<f64> = distances.collect();
            let enough = |within: f64| distances.iter().filter(|d| **d < within).count() > 2;
            let mut within = 0.001;
            while !enough(within) && within <= 1.5 {
                within *= 2.0;
            }
            // Near the boundary of the search radius, rounding decides.
            if distances
                .iter()
                .any(|d| (d / within - 1.0).abs() < 1e-4 || (2.0 * d / within - 1.0).abs() < 1e-4)
            {
                continue;
            }
            let (mut sum, mut weights) = (0.0, 0.0);
            for (angles, d) in angles.iter().zip(&distances).filter(|(_, d)| **d < within) {
                let weight = (-100.0 * d).exp();
                sum += weight * value(*angles)[0];
                weights += weight;
            }
            let expected = flat * (sum / weights) as f32;
            let (wo, wi) = directions(asked);
            let f = MeasuredLobe::new(&table).f(wo.as_vec3(), wi.as_vec3());
            // Weights magnify the rounding of squared distances by 100.
            assert!((f - expected).abs().max_element() < 1e-4, "{f} {expected}");
        }
    }
}

#[test]
fn many_samples_are_their_formula() {
    let table = glossy_list(24, 24);
    let scale = rgb_from_samples(&[(550.0, 1.0)]) * 0.8;
    for i in 0..500 {
        let (wo, wi) = pair(i);
        let expected = glossy(turned(wo, wi)[0]) as f32 * scale.x;
        let f = MeasuredLobe::new(&table).f(wo, wi).x;
        // Cosines and sines within the first radius of 0.03 belong to half angles within 0.12, over which the highlight
        // falls by a quarter of its 0.1.
        assert!((f - expected).abs() < 0.025, "{wo} {wi}: {f} {expected}");
    }
}

/// A highlight of 5° is sampled nearly as well as possible when f cos / pdf is almost constant: its variance is a small
/// fraction of that of cosine-distributed directions, which pbrt-v2 samples.
#[test]
fn highlights_are_sampled_by_their_half_angle() {
    let table = table([90, 4, 4], &|h, _, _| [0.05 + 20.0 * h.cos().powi(700); 3]);
    let lobe = MeasuredLobe::new(&table);
    let wo = direction(40.0, 10.0);
    let spread = |draw: &dyn Fn(u64) -> f64| {
        let values: Vec<f64> = (0..20_000).map(draw).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        (mean, squares / values.len() as f64)
    };
    let (mean, variance) = spread(&|i| {
        let (_, u) = random(i);
        lobe.sample(wo, u)
            .map_or(0.0, |s| f64::from(s.f.x * s.wi.z / s.pdf))
    });
    let (cosine_mean, cosine_variance) = spread(&|i| {
        let wi = cosine_hemisphere(random(i).1);
        PI * f64::from(lobe.f(wo, wi).x)
    });
    // Four standard errors of the noisier one.
    let error = 4.0 * (cosine_variance / 20_000.0).sqrt();
    assert!((mean - cosine_mean).abs() < error, "{mean} {cosine_mean}");
    assert!(
        variance < 0.1 * cosine_variance,
        "{variance} {cosine_variance}"
    );
}
