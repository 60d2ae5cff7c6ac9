//! A log-log chart of error against time.

use crate::cli::lens::chart::{FINE, Failure, failure, svg};
use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;

/// A series of points in one color.
pub(super) struct Series {
    /// Name in the legend.
    pub name: String,
    /// Seconds of CPU time, error in percent, and a label for the point.
    pub points: Vec<(f64, f64, String)>,
    /// `true` if the points are joined by lines.
    pub joined: bool,
}

const TEXT: u32 = 14 * FINE;

/// One color per series, distinguishable for color-blind readers (Okabe and Ito 2008, yellow darkened, and gray).
const PALETTE: [RGBColor; 9] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(150, 140, 20),
    RGBColor(0, 0, 0),
    RGBColor(130, 130, 130),
];

/// Draws the series; those without a positive point are left out.
pub(super) fn log_log(size: (u32, u32), series: &[Series]) -> Result<String, Failure> {
    let points = || {
        series
            .iter()
            .flat_map(|s| &s.points)
            .filter(|p| p.0 > 0.0 && p.1 > 0.0)
    };
    if points().next().is_none() {
        return Err(failure("nothing was measured"));
    }
    let range = |value: &dyn Fn(&(f64, f64, String)) -> f64| {
        let low = points().map(value).fold(f64::INFINITY, f64::min);
        let high = points().map(value).fold(0.0, f64::max);
        (low / 1.5)..(high * 2.0)
    };
    let (x, y) = (range(&|p| p.0), range(&|p| p.1));
    svg(size, |canvas| {
        let mut chart = ChartBuilder::on(canvas)
            .margin(6 * FINE)
            .margin_right(14 * FINE)
            .x_label_area_size(38 * FINE)
            .y_label_area_size(58 * FINE)
            .build_cartesian_2d(x.log_scale(), y.log_scale())
            .map_err(failure)?;
        chart
            .configure_mesh()
            .x_desc("processor seconds for an image")
            .y_desc("relative error (%)")
            .x_label_formatter(&|v| tick(*v))
            .y_label_formatter(&|v| tick(*v))
            .label_style(("sans-serif", TEXT))
            .axis_desc_style(("sans-serif", TEXT))
            .bold_line_style(ShapeStyle::from(&RGBColor(220, 220, 220)).stroke_width(FINE))
            .light_line_style(ShapeStyle::from(&RGBColor(240, 240, 240)).stroke_width(FINE / 2))
            .axis_style(ShapeStyle::from(&BLACK).stroke_width(FINE))
            .draw()
            .map_err(failure)?;
        let mut room = Room::new(size, series, |at| chart.backend_coord(at));
        for (series, color) in series.iter().zip(PALETTE.iter().cycle()) {
            draw_series(&mut chart, series, color, &mut room)?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(22 * FINE)
            .label_font(("sans-serif", TEXT))
            .background_style(WHITE.mix(0.8))
            .draw()
            .map_err(failure)
    })
}

/// The axes of the chart.
type Axes = Cartesian2d<LogCoord<f64>, LogCoord<f64>>;

/// Draws a series, its marks with their names where there is room, and names it in the legend.
fn draw_series<'a, 'b: 'a>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, Axes>,
    series: &Series,
    color: &RGBColor,
    room: &mut Room,
) -> Result<(), Failure> {
    let style = ShapeStyle::from(color).stroke_width(2 * FINE);
    let filled = style.filled();
    let positive = || series.points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0);
    if series.joined {
        let line = positive().map(|p| (p.0, p.1));
        chart
            .draw_series(LineSeries::new(line, style))
            .map_err(failure)?;
    }
    // Small letters are read on white only if they are darker than a mark needs to be.
    let [r, g, b] = [color.0, color.1, color.2].map(|c| c / 3 * 2);
    let label = ("sans-serif", TEXT * 6 / 7)
        .into_font()
        .color(&RGBColor(r, g, b));
    let placed: Vec<_> = positive()
        .map(|p| (p, room.take(chart.backend_coord(&(p.0, p.1)), &p.2)))
        .collect();
    let marks = placed.into_iter().map(|(p, beside)| {
        // A label without room is in the table.
        let said = beside.map_or(String::new(), |_| p.2.clone());
        EmptyElement::at((p.0, p.1))
            + Circle::new((0, 0), 4 * FINE, filled)
            + Text::new(said, beside.unwrap_or_default(), label.clone())
    });
    chart
        .draw_series(marks)
        .map_err(failure)?
        .label(&series.name)
        .legend(move |(x, y)| Circle::new((x + 8 * FINE as i32, y), 4 * FINE, filled));
    Ok(())
}

/// Height of a label's letters.
const LETTER: i32 = (TEXT * 6 / 7) as i32;

/// Half the side of a mark, and the distance of its label.
const MARK: i32 = 6 * FINE as i32;

/// A box in the units of the drawing: left, top, right, bottom.
type Box4 = [i32; 4];

/// What is taken by marks and labels.
struct Room {
    taken: Vec<Box4>,
    size: [i32; 2],
}

impl Room {
    fn new(
        (width, height): (u32, u32),
        series: &[Series],
        place: impl Fn(&(f64, f64)) -> (i32, i32),
    ) -> Room {
        let points = series.iter().flat_map(|s| &s.points);
        let points = points.filter(|p| p.0 > 0.0 && p.1 > 0.0);
        let mark = |p: &(f64, f64, String)| {
            let (x, y) = place(&(p.0, p.1));
            [x - MARK / 2, y - MARK / 2, x + MARK / 2, y + MARK / 2]
        };
        let fine = |n: u32| i32::try_from(n * FINE).unwrap_or(i32::MAX);
        Room {
            taken: points.map(mark).collect(),
            size: [fine(width), fine(height)],
        }
    }

    /// Where a label goes, from its mark: the first of six places that is free, and is taken from then on.
    fn take(&mut self, (x, y): (i32, i32), label: &str) -> Option<(i32, i32)> {
        // Letters of such a face are a bit more than half as wide as high.
        let width = i32::try_from(label.chars().count())
            .unwrap_or(i32::MAX)
            .saturating_mul(LETTER)
            * 3
            / 5;
        let (right, left) = (MARK, -MARK - width);
        let (above, level, below) = (-MARK - LETTER / 2, -LETTER / 2, MARK - LETTER / 2);
        let places = [
            (right, above),
            (right, level),
            (right, below),
            (left, above),
            (left, level),
            (left, below),
        ];
        let at = |(dx, dy): (i32, i32)| [x + dx, y + dy, x + dx + width, y + dy + LETTER];
        let is_free = |b: Box4| {
            let apart = |t: &Box4| b[2] <= t[0] || t[2] <= b[0] || b[3] <= t[1] || t[3] <= b[1];
            b[0] >= 0
                && b[1] >= 0
                && b[2] <= self.size[0]
                && b[3] <= self.size[1]
                && self.taken.iter().all(apart)
        };
        let free = places.into_iter().find(|place| is_free(at(*place)))?;
        self.taken.push(at(free));
        Some(free)
    }
}

fn tick(v: f64) -> String {
    match v {
        v if v >= 1.0 => format!("{v:.0}"),
        v => format!("{v:.*}", (-v.log10()).ceil() as usize),
    }
}
