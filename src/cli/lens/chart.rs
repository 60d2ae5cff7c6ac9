//! Curves on axes, as SVG.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

/// An image being drawn.
pub(crate) type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The backend counts in whole pixels, so images are drawn so much larger than they are shown.
pub(crate) const FINE: u32 = 4;

/// Text height on axes, in drawn pixels.
const TEXT: u32 = 13 * FINE;

/// Blue, vermilion, green, purple, orange: told apart by people who see colors differently (Okabe and Ito, "Color universal design",
/// 2008).
pub(crate) const PALETTE: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(150, 80, 140),
    RGBColor(200, 140, 0),
];

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stroke {
    /// In one line.
    Solid,
    /// Dashed.
    Dashed,
    /// Dashed finely.
    Dotted,
}

/// One curve.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// In the legend; empty for a curve that is explained by another one.
    pub name: String,
    pub color: RGBColor,
    pub stroke: Stroke,
    /// A curve that breaks off and continues has several parts.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// A curve in a color of the [`PALETTE`].
    pub(crate) fn new(
        name: &str,
        color: usize,
        stroke: Stroke,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Curve {
        Curve {
            name: name.to_string(),
            color: PALETTE[color],
            stroke,
            points: points.collect(),
        }
    }
}

/// One set of axes with its curves.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Above it.
    pub title: String,
    /// With units.
    pub x_label: &'static str,
    pub y_label: &'static str,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub curves: Vec<Curve>,
    /// `true` if the curves are named, below the axes.
    pub legend: bool,
}

/// Draws an image of `size` as shown on the page, as SVG text.
pub(crate) fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Canvas) -> Result<(), Failure>,
) -> Result<String, Failure> {
    let mut text = String::new();
    {
        let canvas =
            SVGBackend::with_string(&mut text, (size.0 * FINE, size.1 * FINE)).into_drawing_area();
        draw(&canvas)?;
        canvas.present().map_err(failure)?;
    }
    // The size it is shown at; the view box keeps the drawn one.
    let drawn = format!("width=\"{}\" height=\"{}\"", size.0 * FINE, size.1 * FINE);
    let shown = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    Ok(text.replacen(&drawn, &shown, 1))
}

/// Why an image could not be drawn.
pub(crate) type Failure = String;

/// Turns the library's errors into ours.
pub(crate) fn failure(error: impl std::fmt::Display) -> Failure {
    format!("drawing: {error}")
}

impl Chart {
    /// As an image of its own.
    pub(crate) fn svg(&self, size: (u32, u32)) -> Result<String, Failure> {
        svg(size, |canvas| self.draw(canvas))
    }

    /// Onto a part of an image.
    pub(crate) fn draw(&self, canvas: &Canvas) -> Result<(), Failure> {
        self.draw_and_locate(canvas, std::iter::empty()).map(drop)
    }

    /// Onto a part of an image; returns where in the image `points` lie.
    pub(crate) fn draw_and_locate(
        &self,
        canvas: &Canvas,
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Result<Vec<(i32, i32)>, Failure> {
        let named: Vec<&Curve> = self.curves.iter().filter(|c| !c.name.is_empty()).collect();
        let rows = if self.legend {
            legend_rows(&named, canvas.dim_in_pixel().0)
        } else {
            Vec::new()
        };
        let height = canvas
            .dim_in_pixel()
            .1
            .saturating_sub(rows.len() as u32 * LEGEND_ROW);
        let (canvas, below) = canvas.split_vertically(height);
        draw_legend(&below, &rows)?;
        let canvas = &canvas;
        // Room for the numbers, and for what they are where that is said.
        let room = |label: &str, plain: u32| if label.is_empty() { plain } else { plain + 18 };
        let mut builder = ChartBuilder::on(canvas);
        builder
            .margin(6 * FINE)
            .margin_right(14 * FINE)
            .x_label_area_size(room(self.x_label, 20) * FINE)
            .y_label_area_size(room(self.y_label, 40) * FINE);
        if !self.title.is_empty() {
            builder.caption(&self.title, ("sans-serif", TEXT));
        }
        let mut chart = builder
            .build_cartesian_2d(self.x.clone(), self.y.clone())
            .map_err(failure)?;
        let (x_step, y_step) = (step(&self.x), step(&self.y));
        chart
            .configure_mesh()
            .set_all_tick_mark_size(5 * FINE)
            .x_desc(self.x_label)
            .y_desc(self.y_label)
            .x_labels(labels(&self.x, canvas.dim_in_pixel().0))
            .y_labels(labels(&self.y, canvas.dim_in_pixel().1))
            .x_label_formatter(&|v| number(*v, x_step))
            .y_label_formatter(&|v| number(*v, y_step))
            .label_style(("sans-serif", TEXT))
            .axis_desc_style(("sans-serif", TEXT))
            .bold_line_style(ShapeStyle::from(&RGBColor(220, 220, 220)).stroke_width(FINE))
            .axis_style(ShapeStyle::from(&BLACK).stroke_width(FINE))
            .light_line_style(TRANSPARENT)
            .draw()
            .map_err(failure)?;
        let inside = |range: &Range<f64>| range.start < 0.0 && range.end > 0.0;
        let level = inside(&self.y).then_some([(self.x.start, 0.0), (self.x.end, 0.0)]);
        let upright = inside(&self.x).then_some([(0.0, self.y.start), (0.0, self.y.end)]);
        for zero in level.into_iter().chain(upright) {
            let style = ShapeStyle::from(&RGBColor(120, 120, 120)).stroke_width(FINE);
            chart
                .draw_series(LineSeries::new(zero, style))
                .map_err(failure)?;
        }
        for curve in &self.curves {
            draw_curve(&mut chart, curve)?;
        }
        Ok(points.map(|p| chart.backend_coord(&p)).collect())
    }
}

/// The axes of a chart.
type Axes = Cartesian2d<RangedCoordf64, RangedCoordf64>;

/// Draws a curve.
fn draw_curve<'b>(
    chart: &mut ChartContext<'_, SVGBackend<'b>, Axes>,
    curve: &Curve,
) -> Result<(), Failure> {
    let style = ShapeStyle::from(&curve.color).stroke_width(3 * FINE / 2);
    let points = curve.points.iter().copied();
    match dashes(curve.stroke) {
        None => chart.draw_series(LineSeries::new(points, style)),
        Some((dash, gap)) => chart.draw_series(DashedLineSeries::new(points, dash, gap, style)),
    }
    .map_err(failure)?;
    Ok(())
}

/// Height of a row of the legend, in drawn pixels.
const LEGEND_ROW: u32 = 19 * FINE;

/// The curves of each row of the legend, with where its entries begin, in drawn pixels.
fn legend_rows<'a>(curves: &[&'a Curve], width: u32) -> Vec<Vec<(i32, &'a Curve)>> {
    let mut rows: Vec<Vec<(i32, &Curve)>> = Vec::new();
    let mut next = i32::MAX;
    for curve in curves {
        // Letters of sans-serif fonts are some 0.55 of their height wide.
        let letters = curve.name.chars().count() as i32 * TEXT as i32 * 55 / 100;
        let size = letters + 48 * FINE as i32;
        if next.saturating_add(size) > width as i32 {
            rows.push(Vec::new());
            next = 16 * FINE as i32;
        }
        rows.extend(rows.is_empty().then(Vec::new));
        if let Some(row) = rows.last_mut() {
            row.push((next, curve));
        }
        next += size;
    }
    rows
}

fn draw_legend(canvas: &Canvas, rows: &[Vec<(i32, &Curve)>]) -> Result<(), Failure> {
    for (i, row) in rows.iter().enumerate() {
        let middle = (i as u32 * LEGEND_ROW + LEGEND_ROW / 2) as i32;
        for (x, curve) in row {
            let style = ShapeStyle::from(&curve.color).stroke_width(3 * FINE / 2);
            for piece in legend_pieces(curve.stroke) {
                let [a, b] = piece.map(|dx| x + dx * FINE as i32);
                let line = PathElement::new(vec![(a, middle), (b, middle)], style);
                canvas.draw(&line).map_err(failure)?;
            }
            let at = (x + 30 * FINE as i32, middle - TEXT as i32 / 2);
            let name = Text::new(curve.name.clone(), at, ("sans-serif", TEXT));
            canvas.draw(&name).map_err(failure)?;
        }
    }
    Ok(())
}

/// Lengths of dashes and of the gaps between them, in drawn pixels.
fn dashes(stroke: Stroke) -> Option<(u32, u32)> {
    match stroke {
        Stroke::Solid => None,
        Stroke::Dashed => Some((7 * FINE, 4 * FINE)),
        Stroke::Dotted => Some((2 * FINE, 3 * FINE)),
    }
}

/// The three parts of the stroke shown in a legend, shown pixels.
fn legend_pieces(stroke: Stroke) -> [[i32; 2]; 3] {
    match stroke {
        Stroke::Solid => [[0, 8], [8, 16], [16, 24]],
        Stroke::Dashed => [[0, 6], [9, 15], [18, 24]],
        Stroke::Dotted => [[2, 5], [10, 13], [18, 21]],
    }
}

/// How many tick labels the axis of this range is to have at most: as many as so many drawn pixels have room for, or more where these would be
/// fewer than two, which show no scale.
fn labels(range: &Range<f64>, pixels: u32) -> usize {
    const MOST: usize = 9;
    let room = (pixels / (48 * FINE)).clamp(4, MOST as u32) as usize;
    let axis = RangedCoordf64::from(range.clone());
    let shows = |most: &usize| axis.key_points(*most).len() > 1;
    (room..=MOST).find(shows).unwrap_or(room)
}

/// About the distance between two tick labels of a range.
fn step(range: &Range<f64>) -> f64 {
    (range.end - range.start).abs() / 8.0
}

/// A number with as many decimals as tell neighboring labels apart.
fn number(value: f64, step: f64) -> String {
    let decimals = (-step.log10()).ceil().clamp(0.0, 9.0) as usize;
    // Rounding must not leave a minus before a zero.
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_string(),
        _ => text,
    }
}

/// The smallest round number that is at least `x`, for the end of an axis; 1 for nothing.
pub(crate) fn round_up(x: f64) -> f64 {
    next_of(&[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0], x)
}

/// The smallest of 1, 2, 5 times a power of ten that is at least `x`, for the distance between ticks.
pub(crate) fn tick_step(x: f64) -> f64 {
    next_of(&[1.0, 2.0, 5.0, 10.0], x)
}

/// The smallest of `steps` times a power of ten that is at least `x`; 1 for nothing.
fn next_of(steps: &[f64], x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf(x.log10().floor());
    steps
        .iter()
        .map(|m| m * power)
        .find(|limit| *limit >= x * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_round() {
        for (x, limit) in [
            (0.0, 1.0),
            (3.1, 4.0),
            (0.021, 0.025),
            (100.0, 100.0),
            (f64::NAN, 1.0),
        ] {
            assert!((round_up(x) - limit).abs() < 1e-12, "{x}");
        }
    }

    /// An axis from -4 to 4 with four labels at most had one, at 0.
    #[test]
    fn every_axis_shows_its_scale() {
        for i in 1..400 {
            let end = 0.05 * f64::from(i);
            for range in [-end..end, 0.0..end, -0.2 * end..end] {
                let axis = RangedCoordf64::from(range.clone());
                let shown = axis.key_points(labels(&range, 130 * FINE)).len();
                assert!((2..=6).contains(&shown), "{range:?}: {shown}");
            }
        }
    }

    #[test]
    fn labels_have_the_decimals_they_need() {
        assert_eq!(number(-0.0, 0.5), "0.0");
        assert_eq!(number(0.25, 0.05), "0.25");
        assert_eq!(number(20.0, 2.5), "20");
    }

    #[test]
    fn a_chart_is_svg_with_its_labels() {
        let chart = Chart {
            title: "Title".to_string(),
            x_label: "height (mm)",
            y_label: "y (%)",
            x: 0.0..20.0,
            y: -1.0..1.0,
            curves: vec![Curve::new(
                "curve",
                0,
                Stroke::Dashed,
                [(0.0, 0.0), (20.0, 0.5)].into_iter(),
            )],
            legend: true,
        };
        let text = chart.svg((640, 400)).unwrap();
        assert!(text.starts_with("<svg width=\"640\" height=\"400\" viewBox=\"0 0 2560 1600\""));
        for part in ["height (mm)", "y (%)", "Title", "curve", "</svg>"] {
            assert!(text.contains(part), "{part}");
        }
    }
}
