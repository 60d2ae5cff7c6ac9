//! The charts of the lens report.

use super::chart::{self, Canvas, Chart, Curve, Failure, Stroke, round_up};
use crate::optics::analysis::mtf::{LARGEST_FREQUENCY, MtfCurves};
use crate::optics::analysis::{
    Color, DistortionGrid, Fan, FieldFocus, FieldPoint, LateralColor, LensAnalysis,
    MTF_FREQUENCIES, Spot,
};
use plotters::style::RGBColor;
use std::fmt::Write;
use std::ops::Range;

/// Size of a chart as shown, pixels.
const SIZE: (u32, u32) = (470, 340);
/// Of one with a long legend.
const TALL: (u32, u32) = (470, 400);
/// Of one panel of several.
const PANEL: (u32, u32) = (184, 190);

/// Colors of the chart's palette for the lines C, d and F.
const OF_LINES: [usize; 3] = [1, 2, 0];
const LINES: [&str; 3] = ["C (656 nm)", "d (588 nm)", "F (486 nm)"];

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
        legend: true,
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
    let range = lowest(values(&curves))..1.0;
    over_field(analysis, "contrast", range, curves).svg(TALL)
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

/// The lower end of an axis of contrast: 0, or below what is negative.
fn lowest(values: impl Iterator<Item = f64>) -> f64 {
    let least = values.fold(0.0, f64::min);
    if least < -0.01 {
        (10.0 * least).floor() / 10.0
    } else {
        0.0
    }
}

/// Sagittal and tangential curves of each field point.
fn over_points(
    analysis: &LensAnalysis,
    points: impl Fn(&MtfCurves, usize) -> Vec<(f64, f64)>,
) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (i, mtf) in analysis.mtf.iter().enumerate() {
        let name = format!("{:.1} mm", mtf.height);
        curves.push(Curve::new(
            &name,
            i,
            Stroke::Solid,
            points(mtf, 0).into_iter(),
        ));
        curves.push(Curve::new(
            "",
            i,
            Stroke::Dashed,
            points(mtf, 1).into_iter(),
        ));
    }
    curves
}

/// A chart of contrast; `None` without curves.
fn contrast(x_label: &'static str, x: Range<f64>, curves: Vec<Curve>) -> Option<Chart> {
    let some = values(&curves).next().is_some();
    some.then(|| Chart {
        title: String::new(),
        x_label,
        y_label: "contrast",
        x,
        y: lowest(values(&curves))..1.0,
        curves,
        legend: true,
    })
}

/// Contrast against frequency: by rays, and by waves.
pub(super) fn mtf_by_frequency(analysis: &LensAnalysis) -> Result<Vec<String>, Failure> {
    let rays =
        |m: &MtfCurves, axis: usize| m.geometric.iter().map(|c| (c[0], c[1 + axis])).collect();
    let waves = |m: &MtfCurves, axis: usize| {
        let points = [&m.wave_sagittal, &m.wave_tangential][axis];
        inside(points, LARGEST_FREQUENCY)
    };
    let charts = [
        ("by rays: line pairs per mm", over_points(analysis, rays)),
        ("by waves: line pairs per mm", over_points(analysis, waves)),
    ];
    let charts = charts
        .into_iter()
        .filter_map(|(label, curves)| contrast(label, 0.0..LARGEST_FREQUENCY, curves));
    charts.map(|chart| chart.svg(SIZE)).collect()
}

/// The points up to `end`, the last of them between two where the curve continues.
fn inside(points: &[[f64; 2]], end: f64) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for &[x, y] in points {
        match kept.last() {
            Some(&(x0, y0)) if x > end => {
                kept.push((end, y0 + (y - y0) * (end - x0) / (x - x0)));
                break;
            }
            _ => kept.push((x, y)),
        }
    }
    kept
}

/// Contrast through focus.
pub(super) fn through_focus(analysis: &LensAnalysis) -> Result<Vec<String>, Failure> {
    let points = |m: &MtfCurves, axis: usize| {
        m.through_focus
            .iter()
            .map(|c| (c[0], c[1 + axis]))
            .collect()
    };
    let curves = over_points(analysis, points);
    let shifts = analysis
        .mtf
        .iter()
        .flat_map(|m| &m.through_focus)
        .map(|c| c[0]);
    let reach = shifts.fold(1e-6, f64::max);
    let chart = contrast("film moved back (mm)", -reach..reach, curves);
    chart.into_iter().map(|chart| chart.svg(SIZE)).collect()
}

/// Sagittal and tangential focus, the field upward.
pub(super) fn field_curves(analysis: &LensAnalysis) -> Result<String, Failure> {
    let curve = |name, color, stroke, focus: fn(&FieldFocus) -> Option<f64>| {
        let points = analysis.field_curves.iter();
        Curve::new(
            name,
            color,
            stroke,
            points.filter_map(|p| Some((focus(p)?, p.height))),
        )
    };
    let curves = vec![
        curve("sagittal", 0, Stroke::Solid, |p| p.sagittal),
        curve("tangential", 1, Stroke::Dashed, |p| p.tangential),
        curve("Petzval", 2, Stroke::Dotted, |p| p.petzval),
    ];
    along_the_axis(curves, "film height (mm)", analysis.image_radius)
}

/// Where the rays of the axial beam cross the axis.
pub(super) fn longitudinal(analysis: &LensAnalysis) -> Result<String, Failure> {
    let all = &analysis.longitudinal;
    // One color alone is the d line.
    let first = if all.len() == 1 { 1 } else { 0 };
    let curve = |(i, of): (usize, &crate::optics::analysis::Longitudinal)| {
        let points = of.crossings.iter().map(|c| (c[1], c[0]));
        Curve::new(LINES[first + i], OF_LINES[first + i], Stroke::Solid, points)
    };
    let curves = all.iter().enumerate().map(curve).collect();
    along_the_axis(curves, "height in the pupil", 1.0)
}

/// A chart of distances behind the film, from left to right; far ones, of the field's edge, are cut off.
fn along_the_axis(curves: Vec<Curve>, y_label: &'static str, top: f64) -> Result<String, Failure> {
    let mut all: Vec<f64> = curves
        .iter()
        .flat_map(|c| &c.points)
        .map(|p| p.0.abs())
        .collect();
    all.sort_by(f64::total_cmp);
    // Nine tenths of the points, and as much again.
    let most = all.get(all.len() * 9 / 10).copied().unwrap_or(0.0);
    let limit = round_up(all.last().copied().unwrap_or(1.0).min(2.0 * most).max(1e-4));
    let curves = curves.into_iter().map(|curve| Curve {
        points: curve
            .points
            .into_iter()
            .filter(|p| p.0.abs() <= limit)
            .collect(),
        ..curve
    });
    let chart = Chart {
        title: String::new(),
        x_label: "behind the film (mm)",
        y_label,
        x: -limit..limit,
        y: 0.0..top,
        curves: curves.collect(),
        legend: true,
    };
    chart.svg(SIZE)
}

/// Focus near the axis against wavelength.
pub(super) fn focal_shift(color: &Color) -> Result<String, Failure> {
    let points = color
        .focal_shift
        .iter()
        .map(|s| (1e3 * s.wavelength, s.shift));
    let curves = vec![Curve::new("", 0, Stroke::Solid, points)];
    let limit = round_up(values(&curves).map(f64::abs).fold(1e-4, f64::max));
    let low = values(&curves).fold(0.0, f64::min);
    let chart = Chart {
        title: String::new(),
        x_label: "wavelength (nm)",
        y_label: "focus behind that of d (mm)",
        x: 400.0..700.0,
        y: if low < -0.02 * limit {
            -limit..limit
        } else {
            -0.1 * limit..limit
        },
        curves,
        legend: false,
    };
    chart.svg(SIZE)
}

/// The part of the stop that each beam goes through, with the stop's rim.
pub(super) fn footprints(analysis: &LensAnalysis) -> Result<String, Failure> {
    let closed = |points: &[[f64; 2]]| -> Vec<(f64, f64)> {
        points
            .iter()
            .chain(points.first())
            .map(|p| (p[0], p[1]))
            .collect()
    };
    let curve = |(i, foot): (usize, &crate::optics::analysis::Footprint)| {
        let name = format!("{:.1} mm", foot.height);
        Curve::new(&name, i, Stroke::Solid, closed(&foot.outline).into_iter())
    };
    let reach = analysis
        .footprints
        .iter()
        .flat_map(|f| &f.outline)
        .flatten();
    let limit = 1.08 * reach.fold(1.0, |most: f64, x| most.max(x.abs()));
    let chart = Chart {
        title: String::new(),
        x_label: "across the meridional plane (radii of the stop)",
        y_label: "in it",
        x: -limit..limit,
        y: -limit..limit,
        curves: analysis.footprints.iter().enumerate().map(curve).collect(),
        legend: true,
    };
    // The axes are squares with this much around them.
    chart.svg((380, 404))
}

/// A square grid as the film has it.
pub(super) fn grid(grid: &DistortionGrid) -> Result<String, Failure> {
    let [columns, rows] = grid.size;
    let lines: Vec<Vec<usize>> = (0..rows)
        .map(|r| (0..columns).map(|c| r * columns + c).collect())
        .chain((0..columns).map(|c| (0..rows).map(|r| r * columns + c).collect()))
        .collect();
    let mut curves = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let point = |p: [f64; 2]| (p[0], p[1]);
        let ideal = line.iter().map(|i| point(grid.points[*i].ideal));
        let real = line.iter().filter_map(|i| grid.points[*i].real.map(point));
        let named = |name: &'static str| if k == 0 { name } else { "" };
        curves.push(Curve {
            color: RGBColor(150, 150, 150),
            ..Curve::new(named("without distortion"), 0, Stroke::Dotted, ideal)
        });
        curves.push(Curve::new(named("this lens"), 0, Stroke::Solid, real));
    }
    let half = |axis: fn(&(f64, f64)) -> f64| {
        let all = curves.iter().flat_map(|c| &c.points).map(|p| axis(p).abs());
        1.06 * all.fold(1e-3, f64::max)
    };
    let (x, y) = (half(|p| p.0), half(|p| p.1));
    // The axes of a chart of this size are 1.46 times as wide as high.
    let (x, y) = (x.max(1.46 * y), y.max(x / 1.46));
    let chart = Chart {
        title: String::new(),
        x_label: "mm",
        y_label: "mm",
        x: -x..x,
        y: -y..y,
        curves,
        legend: true,
    };
    chart.svg(SIZE)
}

/// Spot diagrams, each on a scale of its own, with Airy's disc.
pub(super) fn spots(analysis: &LensAnalysis) -> Result<Vec<String>, Failure> {
    (0..analysis.spots.len())
        .map(|i| spot(analysis, i))
        .collect()
}

fn spot(analysis: &LensAnalysis, i: usize) -> Result<String, Failure> {
    let yellow = &analysis.spots[i];
    let middle = yellow.centroid();
    // In µm, about the centroid of the d line.
    let centered = |spot: &Spot| -> Vec<(f64, f64)> {
        let points = spot.points.iter();
        points
            .map(|p| (1e3 * (p[0] - middle[0]), 1e3 * (p[1] - middle[1])))
            .collect()
    };
    let colors = analysis.color.as_ref().and_then(|c| c.points.get(i));
    let spots: Vec<(usize, Vec<(f64, f64)>)> = match colors {
        Some(c) => [&c.spots[0], yellow, &c.spots[1]]
            .into_iter()
            .map(centered)
            .enumerate()
            .collect(),
        None => vec![(1, centered(yellow))],
    };
    let airy = yellow.airy.unwrap_or([0.0; 2]).map(|r| 1e3 * r);
    let reach = spots
        .iter()
        .flat_map(|s| &s.1)
        .map(|p| p.0.abs().max(p.1.abs()));
    let limit = 1.12 * round_up(reach.fold(airy[0].max(airy[1]).max(0.1), f64::max));
    let chart = Chart {
        title: format!(
            "{:.1} mm: rms {:.1} µm",
            yellow.height,
            1e3 * rms_radius(analysis, i)
        ),
        x_label: "µm",
        y_label: "",
        x: -limit..limit,
        y: -limit..limit,
        curves: Vec::new(),
        legend: false,
    };
    let mut paths = String::new();
    let image = chart::svg(PANEL, |canvas| {
        let around = (0..=64).map(|k| (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos());
        let around = around.map(|(sin, cos)| (airy[0] * sin, airy[1] * cos));
        let all = spots.iter().flat_map(|s| &s.1).copied();
        let at = chart.draw_and_locate(canvas, all.chain(around))?;
        let mut rest = &at[..];
        for (line, points) in &spots {
            let (own, others) = rest.split_at(points.len().min(rest.len()));
            paths += &dots(own, chart::PALETTE[OF_LINES[*line]]);
            rest = others;
        }
        paths += &outline(rest);
        Ok(())
    })?;
    Ok(image.replacen("</svg>", &format!("{paths}</svg>"), 1))
}

/// One path of round dots: a twentieth of the size of as many circles.
fn dots(at: &[(i32, i32)], color: RGBColor) -> String {
    let mut path = String::new();
    for (x, y) in at {
        // Writing to a string cannot fail.
        let _ = write!(path, "M{x} {y}h0");
    }
    let (RGBColor(r, g, b), width) = (color, 1.3 * f64::from(chart::FINE));
    format!(
        "<path d=\"{path}\" fill=\"none\" stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{width}\" stroke-linecap=\"round\"/>\n"
    )
}

fn outline(at: &[(i32, i32)]) -> String {
    let points: Vec<String> = at.iter().map(|(x, y)| format!("{x},{y}")).collect();
    let width = chart::FINE;
    format!(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#000000\" stroke-width=\"{width}\"/>\n",
        points.join(" ")
    )
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
pub(super) fn fans(analysis: &LensAnalysis) -> Result<Vec<String>, Failure> {
    let colors = analysis.color.as_ref().map_or(&[][..], |c| &c.points);
    let others = colors.iter().flat_map(|c| &c.fans);
    let errors = analysis
        .fans
        .iter()
        .chain(others)
        .flat_map(|f| f.tangential.iter().chain(&f.sagittal));
    let reach = errors.map(|p| p[1].abs()).fold(1e-4, f64::max);
    let limit = 1.05 * round_up(1e3 * reach);
    let image = |(i, yellow): (usize, &Fan)| {
        let fans: Vec<(usize, &Fan)> = match colors.get(i) {
            Some(c) => vec![(0, &c.fans[0]), (1, yellow), (2, &c.fans[1])],
            None => vec![(1, yellow)],
        };
        let panel = |row: usize| {
            let curve = |(line, fan): &(usize, &Fan)| {
                let points = [&fan.tangential, &fan.sagittal][row];
                let points = points.iter().map(|p| (p[0], 1e3 * p[1]));
                Curve::new("", OF_LINES[*line], Stroke::Solid, points)
            };
            Chart {
                title: format!(
                    "{:.1} mm, {}",
                    yellow.height,
                    ["tangential", "sagittal"][row]
                ),
                x_label: if row == 1 { "pupil" } else { "" },
                y_label: if i == 0 { "error (µm)" } else { "" },
                x: -1.1..1.1,
                y: -limit..limit,
                curves: fans.iter().map(curve).collect(),
                legend: false,
            }
        };
        chart::svg((PANEL.0, 2 * PANEL.1), |canvas| {
            let (above, below): (Canvas, Canvas) = canvas.split_vertically(PANEL.1 * chart::FINE);
            panel(0).draw(&above)?;
            panel(1).draw(&below)
        })
    };
    analysis.fans.iter().enumerate().map(image).collect()
}
