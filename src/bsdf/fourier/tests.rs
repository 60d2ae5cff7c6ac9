//! Tables made from formulas, against the formulas.

use super::*;
use crate::assets::bsdf_file::generator::{Analytic, encode};
use crate::bsdf::testing::{
    check_sampling, direction, flat_hit, random, sky_by_sampling, sky_by_value,
};
use crate::bsdf::{Bsdf, Lobe};

fn table(analytic: &Analytic) -> FourierTable {
    FourierTable::new(BsdfFile::parse(&encode(analytic)).expect("a good file"))
}

fn bsdf(table: &FourierTable) -> Bsdf<'_> {
    let hit = flat_hit(Vec3::Z);
    let mut bsdf = Bsdf::new(hit.n, &hit.shading);
    bsdf.add(Lobe::Fourier(FourierLobe::new(table)));
    bsdf
}

/// The table of `value` with `cosines` cosines.
fn tabulated(
    channels: usize,
    cosines: usize,
    terms: usize,
    eta: f32,
    value: &dyn Fn(f64, f64, f64) -> [f64; 3],
) -> FourierTable {
    table(&Analytic {
        eta,
        channels,
        cosines,
        terms,
        value,
    })
}

fn lambert(mu_i: f64, mu_o: f64, _: f64) -> [f64; 3] {
    if mu_i * mu_o < 0.0 {
        [0.2, 0.5, 0.8]
    } else {
        [0.0; 3]
    }
}

/// A Henyey–Greenstein lobe with mean cosine 0.5 about the mirror direction (or, if `through`, the forward direction):
/// smooth, and not constant in azimuth.
fn glossy(through: bool) -> impl Fn(f64, f64, f64) -> [f64; 3] {
    move |mu_i, mu_o, phi| {
        if (mu_i * mu_o > 0.0) != through {
            return [0.0; 3];
        }
        let across = ((1.0 - mu_i * mu_i) * (1.0 - mu_o * mu_o)).max(0.0).sqrt();
        let cos = (mu_i * mu_o).abs() + across * phi.cos();
        let hg = 0.25 * 0.75 / (1.25 - cos).powf(1.5);
        [hg, 0.5 * hg, 0.7 * hg]
    }
}

/// Checks that the table's lobe matches the formula away from grazing angles, where a spline cannot follow the step
/// from one side to the other.
fn check_against(
    name: &str,
    table: &FourierTable,
    value: &dyn Fn(f64, f64, f64) -> [f64; 3],
    tolerance: f32,
) {
    let bsdf = bsdf(table);
    let (count, mut sum) = (3000, 0.0);
    for i in 0..count {
        let ((a, u), (b, _)) = (random(i), random(i + 1_000_000));
        let side = if i % 2 == 0 { 80.0 } else { -80.0 };
        let wo = direction(a * 80.0, u.x * 360.0);
        let wi = direction(b * side, u.y * 360.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let cos_phi = f64::from(cos_azimuth(-wi, wo));
        let exact =
            value(f64::from(-wi.z), f64::from(wo.z), cos_phi.acos()).map(|v| (v / PI) as f32);
        let exact = match table.file.channels {
            // Luminance, with the generator's weights.
            1 => Rgb::splat((exact[1] + 0.100913 * exact[2] + 0.297375 * exact[0]) / 1.39829),
            _ => Rgb::from_array(exact),
        };
        let medium = if wi.z * wo.z < 0.0 {
            table.eta(wo.z).powi(-2)
        } else {
            1.0
        };
        let found = bsdf.f(wo, wi);
        let error = (found - exact * medium).abs().max_element();
        assert!(
            error <= tolerance,
            "{name}: {found} for {exact} × {medium} at {wo} {wi}"
        );
        sum += error / count as f32;
    }
    assert!(sum < 0.1 * tolerance, "{name}: {sum} off in the mean");
}

#[test]
fn a_table_is_the_formula_it_was_made_from() {
    for channels in [1, 3] {
        // Linear in |μi| on either side: nothing is lost except at the step between the sides, whose effect at 80° is
        // below a thousandth.
        let flat = tabulated(channels, 24, 1, 1.0, &lambert);
        check_against("Lambert", &flat, &lambert, 1e-3);
        for (through, eta) in [(false, 1.5), (true, 1.5)] {
            let value = glossy(through);
            let table = tabulated(channels, 48, 32, eta, &value);
            // Odd coefficients are proportional to sin θ = √(1 − μ²), which no spline follows at the pole: in the last
            // interval, from sin θ = 0.1 to 0, the error is up to 0.024, and the slope of these lobes with sin θ is up
            // to 0.6. A hundredth of the pairs lie there.
            check_against("glossy", &table, &value, 2e-2);
        }
    }
}

#[test]
fn samples_follow_the_density() {
    for through in [false, true] {
        let value = glossy(through);
        let table = tabulated(3, 24, 16, 1.3, &value);
        for degrees in [0.0, 35.0, 70.0, 140.0] {
            let name = format!("glossy, through {through}, {degrees}°");
            check_sampling(&name, &bsdf(&table), direction(degrees, 25.0));
        }
    }
    check_sampling(
        "Lambert",
        &bsdf(&tabulated(1, 16, 1, 1.0, &lambert)),
        direction(50.0, 0.0),
    );
}

/// At grazing angles, where the tables hold the cosine 0 twice, directions are sampled on either side of it and never
/// in between.
#[test]
fn samples_at_grazing_angles_follow_the_density() {
    for through in [false, true] {
        let value = glossy(through);
        let table = tabulated(3, 24, 16, 1.3, &value);
        let zeros = |t: &FourierTable| t.file.cosines.iter().filter(|&&mu| mu == 0.0).count();
        assert_eq!(zeros(&table), 2);
        // Within the first interval on either side. (Exactly along the surface it is black.)
        for z in [1e-2, 1e-7, -1e-4] {
            let wo = Vec3::new(1.0, 0.0, z).normalize();
            check_sampling(&format!("through {through}, cosine {z}"), &bsdf(&table), wo);
        }
        do_no_harm(&table);
    }
}

#[test]
fn sampling_and_value_agree_on_a_white_sky() {
    for through in [false, true] {
        let value = glossy(through);
        let table = tabulated(3, 24, 16, 1.3, &value);
        for degrees in [20.0, 60.0, 120.0] {
            let (bsdf, wo) = (bsdf(&table), direction(degrees, 10.0));
            let (a, b) = (sky_by_value(&bsdf, wo, 300), sky_by_sampling(&bsdf, wo, 32));
            // Standard error of 32³ stratified samples.
            let error = (a - b).abs().max_element();
            assert!(error < 2e-3, "through {through}, {degrees}°: {a} and {b}");
        }
    }
}

#[test]
fn a_lambertian_table_reflects_its_albedo() {
    let table = tabulated(3, 32, 1, 1.0, &lambert);
    for degrees in [0.0, 40.0, 70.0, 160.0] {
        let shown = sky_by_value(&bsdf(&table), direction(degrees, 0.0), 200);
        // The effect of the step between the sides.
        let error = (shown - Rgb::new(0.2, 0.5, 0.8)).abs().max_element();
        assert!(error < 2e-3, "{degrees}°: {shown}");
    }
}

#[test]
fn symmetric_tables_are_reciprocal() {
    let value = glossy(false);
    let table = tabulated(3, 64, 32, 1.3, &value);
    let exact = bsdf(&table);
    for i in 0..500 {
        let ((a, u), (b, _)) = (random(i), random(i + 1_000_000));
        let (wo, wi) = (
            direction(a * 75.0, u.x * 360.0),
            direction(b * 75.0, u.y * 360.0),
        );
        // The table holds f |μi|, which is not symmetric: reciprocity holds up to the splines' error.
        assert!((exact.f(wo, wi) - exact.f(wi, wo)).abs().max_element() < 5e-3);
    }
}

/// Poisson's kernel 1 + 2 Σ rᵏ cos kφ = (1 − r²)/(1 − 2r cos φ + r²) has an elementary integral:
/// the u-quantile of 0…π has tan(φ/2) = (1 − r)/(1 + r) tan(πu/2).
#[test]
fn azimuths_follow_series_of_any_length() {
    for (r, count) in [(0.5, 60), (0.97, 900), (0.99, MIXED + 1000)] {
        let series: Vec<f32> = (0..count)
            .map(|k| {
                if k == 0 {
                    1.0
                } else {
                    2.0 * f64::powi(r, k as i32) as f32
                }
            })
            .collect();
        // In two halves, like an interpolated series.
        let terms: Terms = [(0.25, &series[..]), (0.75, &series[..])]
            .into_iter()
            .collect();
        for k in 0..40 {
            let u = (k as f64 + 0.5) / 40.0;
            let (half, mirrored) = if u < 0.5 {
                (2.0 * u, false)
            } else {
                (2.0 * u - 1.0, true)
            };
            let exact = 2.0 * ((1.0 - r) / (1.0 + r) * (PI * half / 2.0).tan()).atan();
            let exact = if mirrored { 2.0 * PI - exact } else { exact };
            let phi = f64::from(sample_azimuth(&terms, u as f32).unwrap());
            // Single precision of coefficients and cosines; what is cut off is below 1e-9.
            assert!((phi - exact).abs() < 1e-4, "{r} at {u}: {phi} for {exact}");
        }
    }
}

#[test]
fn nothing_comes_of_empty_and_negative_tables() {
    let black = tabulated(3, 8, 1, 1.0, &|_, _, _| [0.0; 3]);
    assert!(black.is_black());
    let wo = direction(30.0, 0.0);
    assert!(bsdf(&black).sample(wo, 0.5, Vec2::splat(0.5)).is_none());
    let negative = tabulated(1, 8, 1, 1.0, &|_, _, _| [-1.0; 3]);
    assert!(negative.is_black());
    assert!(bsdf(&negative).sample(wo, 0.5, Vec2::splat(0.5)).is_none());
    assert_eq!(bsdf(&negative).f(wo, wo), Rgb::ZERO);
}

/// Extreme directions neither panic nor yield invalid densities, whatever the table holds.
pub(crate) fn do_no_harm(table: &FourierTable) {
    let lobe = FourierLobe::new(table);
    let grazing = Vec3::new(1.0, 0.0, 1e-7);
    for wo in [
        Vec3::Z,
        -Vec3::Z,
        Vec3::X,
        grazing,
        direction(40.0, 10.0),
        Vec3::NAN,
    ] {
        for u in [0.0, 0.3, 1.0 - f32::EPSILON / 2.0] {
            if let Some(s) = lobe.sample(wo, Vec2::new(u, 1.0 - f32::EPSILON - u * 0.9)) {
                assert!(s.pdf > 0.0 && s.wi.is_normalized());
            }
        }
        for wi in [Vec3::Z, Vec3::X, -grazing, direction(170.0, 0.0), Vec3::NAN] {
            assert!(lobe.pdf(wo, wi) >= 0.0);
            let _ = lobe.f(wo, wi);
        }
    }
}

#[test]
fn wild_directions_do_no_harm() {
    do_no_harm(&tabulated(3, 8, 4, 1.3, &glossy(true)));
}
