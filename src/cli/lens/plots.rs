//! The charts of the lens report.

use super::chart::{self, Canvas, Chart, Curve, Failure, Stroke, round_up};
use crate::optics::analysis::{
    Color, FieldPoint, LateralColor, LensAnalysis, MTF_FREQUENCIES, PassFractions, Spot,
};
use plotters::prelude::SeriesLabelPosition;
use std::fmt::Write;
use std::ops::Range;

/// Size of a chart as shown, pixels.
const SIZE: (u32, u32) = (620, 400);

/// A chart over film heights from 0 to the edge of the image.
fn over_field(
    analysis: &LensAnalysis,
    y_label: &'static str,
    y: Range<f64>,
    curves: Vec<Curve>,
) -> Chart {
    Chart {
        title: String::new(),
        x_label: "film height (mm)",
        y_label,
        x: 0.0..analysis.image_radius,
        y,
        curves,
        legend: Some(SeriesLabelPosition::LowerLeft),
    }
}

/// A curve through the values that field points have.
fn curve(
    analysis: &LensAnalysis,
    name: &str,
    color: usize,
    stroke: Stroke,
    value: impl Fn(&FieldPoint) -> Option<f64>,
) -> Curve {
    let fields = analysis.fields.iter();
    let points = fields.filter_map(|f| Some((f.height, value(f)?)));
    Curve::new(name, color, stroke, points)
}

/// The values of all curves.
fn values(curves: &[Curve]) -> impl Iterator<Item = f64> {
    curves.iter().flat_map(|c| &c.points).map(|p| p.1)
}

/// Distortion against film height.
pub(super) fn distortion(analysis: &LensAnalysis) -> Result<String, Failure> {
    let mut fields = analysis.fields.iter();
    let near_object = fields.all(|f| f.f_theta_distortion.is_none());
    let name = if near_object {
        "against a straight line"
    } else {
        "against f tan θ (straight lines stay straight)"
    };
    let mut curves = vec![curve(analysis, name, 0, Stroke::Solid, |f| f.distortion)];
    // The angle's curve is of interest for fisheyes; for other lenses it would squeeze the first one flat.
    if values(&curves).any(|value| value.abs() > 15.0) {
        let name = "against f θ (equidistant fisheye)";
        let value = |f: &FieldPoint| f.f_theta_distortion;
        curves.push(curve(analysis, name, 1, Stroke::Dashed, value));
    }
    let low = values(&curves).fold(0.0, f64::min);
    let high = values(&curves).fold(0.0, f64::max);
    let limit = round_up(low.abs().max(high).max(0.1));
    // Both sides of zero are shown, but not an empty half.
    let side = |x: f64| {
        if x < 0.05 * limit {
            0.1 * limit
        } else {
            round_up(x)
        }
    };
    let range = -side(-low)..side(high);
    over_field(analysis, "distortion (%)", range, curves).svg(SIZE)
}

/// Relative illumination, with the law of the fourth power.
pub(super) fn illumination(analysis: &LensAnalysis) -> Result<String, Failure> {
    let curve = |name, color, stroke, share: fn(&FieldPoint) -> f64| {
        curve(analysis, name, color, stroke, |f| Some(100.0 * share(f)))
    };
    let law = "cos⁴ of the field angle";
    let at_film = "cos⁴ of the angle at the film";
    let curves = vec![
        curve("this lens", 0, Stroke::Solid, |f| f.relative_illumination),
        curve(law, 1, Stroke::Dashed, |f| f.cos4_field),
        curve(at_film, 2, Stroke::Dotted, |f| f.cos4_film),
    ];
    let top = values(&curves).fold(100.0, f64::max);
    let label = "illumination (% of the center)";
    over_field(analysis, label, 0.0..top * 1.05, curves).svg(SIZE)
}

/// Geometric MTF against film height.
pub(super) fn mtf(analysis: &LensAnalysis) -> Result<String, Failure> {
    let mut curves = Vec::new();
    for (i, frequency) in MTF_FREQUENCIES.iter().enumerate() {
        for (axis, stroke, which) in [
            (0, Stroke::Solid, "sagittal"),
            (1, Stroke::Dashed, "tangential"),
        ] {
            let name = format!("{frequency} lp/mm {which}");
            let value = |f: &FieldPoint| f.mtf.map(|m| m[i][axis]);
            curves.push(curve(analysis, &name, i, stroke, value));
        }
    }
    over_field(analysis, "contrast", 0.0..1.0, curves).svg((SIZE.0, 460))
}

/// Lateral color against film height.
pub(super) fn lateral_color(analysis: &LensAnalysis, color: &Color) -> Result<String, Failure> {
    let curve = |name, color_of_curve, value: fn(&LateralColor) -> f64| {
        let points = color.lateral.iter().map(|p| (p.height, 1e3 * value(p)));
        Curve::new(name, color_of_curve, Stroke::Solid, points)
    };
    let curves = vec![
        curve("F (486 nm)", 0, |p| p.blue),
        curve("C (656 nm)", 1, |p| p.red),
    ];
    let limit = round_up(values(&curves).map(f64::abs).fold(0.1, f64::max));
    over_field(analysis, "lateral color (µm)", -limit..limit, curves).svg(SIZE)
}

/// Part of the sampled rays that get through, against film height.
pub(super) fn pass_fractions(analysis: &LensAnalysis) -> Result<String, Failure> {
    let curve = |name, color, stroke, share: fn(&PassFractions) -> Option<f64>| {
        let heights = analysis.pass_fractions.iter();
        let points = heights.filter_map(|p| Some((p.height, 100.0 * share(p)?)));
        Curve::new(name, color, stroke, points)
    };
    let v3_box = "box per film radius (pbrt-v3)";
    let disk = "disk of the rear element";
    let curves = vec![
        curve("fstop", 0, Stroke::Solid, |p| Some(p.fstop)),
        curve(v3_box, 1, Stroke::Dashed, |p| Some(p.bounding_box)),
        curve("paraxial exit pupil", 2, Stroke::Dotted, |p| p.exit_pupil),
        curve(disk, 3, Stroke::Dashed, |p| Some(p.rear_element)),
    ];
    over_field(analysis, "rays that get through (%)", 0.0..105.0, curves).svg(SIZE)
}

/// Spot diagrams side by side, on one scale.
pub(super) fn spots(analysis: &LensAnalysis) -> Result<String, Failure> {
    // In µm, about the centroid.
    let centered = |spot: &Spot| -> Vec<(f64, f64)> {
        let c = spot.centroid();
        let points = spot.points.iter();
        points
            .map(|p| (1e3 * (p[0] - c[0]), 1e3 * (p[1] - c[1])))
            .collect()
    };
    let spots: Vec<_> = analysis.spots.iter().map(centered).collect();
    let reach = spots.iter().flatten().map(|p| p.0.abs().max(p.1.abs()));
    let limit = 1.12 * round_up(reach.fold(0.1, f64::max));
    let mut dots = String::new();
    let image = panels(spots.len(), 1, (200, 186), |canvas, i, _| {
        let first = i == 0;
        let (height, rms) = (analysis.spots[i].height, 1e3 * rms_radius(analysis, i));
        let chart = Chart {
            title: format!("{height:.1} mm, rms {rms:.1} µm"),
            x_label: if first { "µm" } else { "" },
            y_label: if first { "µm, away from the axis" } else { "" },
            x: -limit..limit,
            y: -limit..limit,
            curves: Vec::new(),
            legend: None,
        };
        for (x, y) in chart.draw_and_locate(canvas, spots[i].iter().copied())? {
            // Writing to a string cannot fail.
            let _ = write!(dots, "M{x} {y}h0");
        }
        Ok(())
    })?;
    // One path of round dots: a twentieth of the size of as many circles.
    let path = format!(
        "<path d=\"{dots}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"{}\" stroke-linecap=\"round\"/>\n</svg>",
        1.3 * f64::from(chart::FINE)
    );
    Ok(image.replacen("</svg>", &path, 1))
}

/// The rms radius over all rays where the field points have it, which is better than that of the rays drawn.
fn rms_radius(analysis: &LensAnalysis, i: usize) -> f64 {
    let spot = &analysis.spots[i];
    let mut fields = analysis.fields.iter();
    let same = fields.find(|f| (f.height - spot.height).abs() < 1e-6 && f.spot_rms.is_some());
    same.and_then(|f| f.spot_rms)
        .unwrap_or_else(|| spot.rms_radius())
}

/// Ray aberration curves: tangential above, sagittal below, on one scale.
pub(super) fn fans(analysis: &LensAnalysis) -> Result<String, Failure> {
    let fans = analysis.fans.iter();
    let errors = fans.flat_map(|f| f.tangential.iter().chain(&f.sagittal));
    let reach = errors.map(|p| p[1].abs()).fold(1e-4, f64::max);
    let limit = 1.05 * round_up(1e3 * reach);
    panels(analysis.fans.len(), 2, (200, 200), |canvas, i, row| {
        let fan = &analysis.fans[i];
        let (points, title, what) = match row {
            0 => (
                &fan.tangential,
                format!("{:.1} mm", fan.height),
                "tangential: y error (µm)",
            ),
            _ => (&fan.sagittal, String::new(), "sagittal: x error (µm)"),
        };
        let points = points.iter().map(|p| (p[0], 1e3 * p[1]));
        let chart = Chart {
            title,
            x_label: if row == 1 { "pupil" } else { "" },
            y_label: if i == 0 { what } else { "" },
            x: -1.1..1.1,
            y: -limit..limit,
            curves: vec![Curve::new("", row, Stroke::Solid, points)],
            legend: None,
        };
        chart.draw(canvas)
    })
}

/// An image of equal panels: `draw` gets each with its column and row.
fn panels(
    columns: usize,
    rows: usize,
    size: (u32, u32),
    mut draw: impl FnMut(&Canvas, usize, usize) -> Result<(), Failure>,
) -> Result<String, Failure> {
    let whole = (size.0 * columns.max(1) as u32, size.1 * rows as u32);
    chart::svg(whole, |canvas| {
        let parts = canvas.split_evenly((rows, columns.max(1)));
        for (k, part) in parts.iter().enumerate().take(rows * columns) {
            draw(part, k % columns, k / columns)?;
        }
        Ok(())
    })
}
