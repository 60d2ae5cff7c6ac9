//! The charts of the lens report.

use super::chart::{self, Canvas, Chart, Curve, Failure, PALETTE, Stroke, round_up};
use crate::optics::analysis::{Color, FieldPoint, LateralColor, LensAnalysis, MTF_FREQUENCIES};
use plotters::prelude::SeriesLabelPosition;
use std::fmt::Write;
use std::ops::Range;

/// Size of a chart as shown, pixels.
const SIZE: (u32, u32) = (620, 400);

/// A chart over film heights from 0 to the edge of the image.
fn over_field(analysis: &LensAnalysis, y_label: &str, y: Range<f64>, curves: Vec<Curve>) -> Chart {
    Chart {
        title: String::new(),
        x_label: "film height (mm)".to_string(),
        y_label: y_label.to_string(),
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
    Curve {
        name: name.to_string(),
        color: PALETTE[color],
        stroke,
        points: analysis
            .fields
            .iter()
            .filter_map(|f| Some((f.height, value(f)?)))
            .collect(),
    }
}

/// Distortion against film height.
pub(super) fn distortion(analysis: &LensAnalysis) -> Result<String, Failure> {
    let near_object = analysis
        .fields
        .iter()
        .all(|f| f.f_theta_distortion.is_none());
    let tangent = curve(
        analysis,
        if near_object {
            "against a straight line"
        } else {
            "against f tan θ (straight lines stay straight)"
        },
        0,
        Stroke::Solid,
        |f| f.distortion,
    );
    let mut curves = vec![tangent];
    let largest = |c: &Curve| c.points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
    // The angle's curve is of interest for fisheyes; for other lenses it would squeeze the first one flat.
    if largest(&curves[0]) > 15.0 {
        curves.push(curve(
            analysis,
            "against f θ (equidistant fisheye)",
            1,
            Stroke::Dashed,
            |f| f.f_theta_distortion,
        ));
    }
    let values = || curves.iter().flat_map(|c| &c.points).map(|p| p.1);
    let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
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
    let percent = |x: f64| Some(100.0 * x);
    let curves = vec![
        curve(analysis, "this lens", 0, Stroke::Solid, |f| {
            percent(f.relative_illumination)
        }),
        curve(
            analysis,
            "cos⁴ of the field angle",
            1,
            Stroke::Dashed,
            |f| percent(f.cos4_field),
        ),
        curve(
            analysis,
            "cos⁴ of the angle at the film",
            2,
            Stroke::Dotted,
            |f| percent(f.cos4_film),
        ),
    ];
    let top = curves
        .iter()
        .flat_map(|c| &c.points)
        .map(|p| p.1)
        .fold(100.0, f64::max);
    over_field(
        analysis,
        "illumination (% of the center)",
        0.0..top * 1.05,
        curves,
    )
    .svg(SIZE)
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
            curves.push(curve(analysis, &name, i, stroke, |f| {
                f.mtf.map(|m| m[i][axis])
            }));
        }
    }
    over_field(analysis, "contrast", 0.0..1.0, curves).svg((SIZE.0, 460))
}

/// Lateral color against film height.
pub(super) fn lateral_color(analysis: &LensAnalysis, color: &Color) -> Result<String, Failure> {
    let curve = |name: &str, stroke_color, value: fn(&LateralColor) -> f64| Curve {
        name: name.to_string(),
        color: stroke_color,
        stroke: Stroke::Solid,
        points: color
            .lateral
            .iter()
            .map(|p| (p.height, 1e3 * value(p)))
            .collect(),
    };
    let curves = vec![
        curve("F (486 nm)", PALETTE[0], |p| p.blue),
        curve("C (656 nm)", PALETTE[1], |p| p.red),
    ];
    let values = curves.iter().flat_map(|c| &c.points).map(|p| p.1.abs());
    let limit = round_up(values.fold(0.1, f64::max));
    over_field(analysis, "lateral color (µm)", -limit..limit, curves).svg(SIZE)
}

/// Part of the sampled rays that get through, against film height.
pub(super) fn pass_fractions(analysis: &LensAnalysis) -> Result<String, Failure> {
    let curve =
        |name: &str,
         color: usize,
         stroke,
         value: &dyn Fn(&crate::optics::analysis::PassFractions) -> Option<f64>| Curve {
            name: name.to_string(),
            color: PALETTE[color],
            stroke,
            points: analysis
                .pass_fractions
                .iter()
                .filter_map(|p| Some((p.height, 100.0 * value(p)?)))
                .collect(),
        };
    let curves = vec![
        curve("fstop", 0, Stroke::Solid, &|p| Some(p.fstop)),
        curve("box per film radius (pbrt-v3)", 1, Stroke::Dashed, &|p| {
            Some(p.bounding_box)
        }),
        curve("paraxial exit pupil", 2, Stroke::Dotted, &|p| p.exit_pupil),
        curve("disk of the rear element", 3, Stroke::Dashed, &|p| {
            Some(p.rear_element)
        }),
    ];
    over_field(analysis, "rays that get through (%)", 0.0..105.0, curves).svg(SIZE)
}

/// Spot diagrams side by side, on one scale.
pub(super) fn spots(analysis: &LensAnalysis) -> Result<String, Failure> {
    let reach = analysis
        .spots
        .iter()
        .flat_map(|s| {
            let c = s.centroid();
            s.points
                .iter()
                .map(move |p| (p[0] - c[0]).abs().max((p[1] - c[1]).abs()))
        })
        .fold(1e-4, f64::max);
    let limit = round_up(1e3 * reach);
    let mut dots = String::new();
    let image = panels(analysis.spots.len(), 1, (200, 186), |canvas, i, _| {
        let spot = &analysis.spots[i];
        let c = spot.centroid();
        let title = format!(
            "{:.1} mm, rms {:.1} µm",
            spot.height,
            1e3 * rms_radius(analysis, i)
        );
        let chart = Chart {
            title,
            x_label: if i == 0 { "µm" } else { "" }.to_string(),
            y_label: if i == 0 {
                "µm, away from the axis"
            } else {
                ""
            }
            .to_string(),
            x: -1.12 * limit..1.12 * limit,
            y: -1.12 * limit..1.12 * limit,
            curves: Vec::new(),
            legend: None,
        };
        for at in chart.draw_and_locate(
            canvas,
            spot.points
                .iter()
                .map(|p| (1e3 * (p[0] - c[0]), 1e3 * (p[1] - c[1]))),
        )? {
            // Writing to a string cannot fail.
            let _ = write!(dots, "M{} {}h0", at.0, at.1);
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
    analysis
        .fields
        .iter()
        .filter(|f| (f.height - spot.height).abs() < 1e-6)
        .find_map(|f| f.spot_rms)
        .unwrap_or_else(|| spot.rms_radius())
}

/// Ray aberration curves: tangential above, sagittal below, on one scale.
pub(super) fn fans(analysis: &LensAnalysis) -> Result<String, Failure> {
    let reach = analysis
        .fans
        .iter()
        .flat_map(|f| f.tangential.iter().chain(&f.sagittal))
        .map(|p| p[1].abs())
        .fold(1e-4, f64::max);
    let limit = round_up(1e3 * reach);
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
        let chart = Chart {
            title,
            x_label: if row == 1 {
                "pupil".to_string()
            } else {
                String::new()
            },
            y_label: if i == 0 {
                what.to_string()
            } else {
                String::new()
            },
            x: -1.1..1.1,
            y: -1.05 * limit..1.05 * limit,
            curves: vec![Curve {
                name: String::new(),
                color: PALETTE[row],
                stroke: Stroke::Solid,
                points: points.iter().map(|p| (p[0], 1e3 * p[1])).collect(),
            }],
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
        for (k, part) in canvas
            .split_evenly((rows, columns.max(1)))
            .iter()
            .enumerate()
        {
            if columns > 0 {
                draw(part, k % columns, k / columns)?;
            }
        }
        Ok(())
    })
}
