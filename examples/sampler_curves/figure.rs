//! Error against samples, a panel for each scene, both axes logarithmic.

use super::Curve;
use plotters::prelude::*;
use std::error::Error;

/// Colors that remain apart for color-blind eyes (Okabe and Ito 2008).
const PALETTE: [RGBColor; 4] = [
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
];

/// A sampler has the same color in every panel.
fn color(name: &str) -> RGBColor {
    let order = ["random", "stratified", "sobol"];
    let i = order.iter().position(|known| *known == name);
    PALETTE[i.unwrap_or(3)]
}

/// The panels side by side, as SVG text.
pub(crate) fn draw(scenes: &[(String, Vec<Curve>)]) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let canvas = SVGBackend::with_string(&mut text, (1200, 760)).into_drawing_area();
        canvas.fill(&WHITE)?;
        for (area, (title, curves)) in canvas.split_evenly((2, 3)).iter().zip(scenes) {
            panel(area, title, curves)?;
        }
        canvas.present()?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn panel(area: &Area, title: &str, curves: &[Curve]) -> Result<(), Box<dyn Error>> {
    let values = || curves.iter().flat_map(|c| &c.points).map(|(_, e)| e.value);
    let positive = || values().filter(|v| *v > 0.0);
    let low = positive().fold(f64::INFINITY, f64::min) / 1.5;
    let high = positive().fold(0.0, f64::max) * 1.5;
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .caption(title, ("sans-serif", 15))
        .x_label_area_size(38)
        .y_label_area_size(60)
        .build_cartesian_2d((0.9..300.0).log_scale(), (low..high).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("samples a pixel")
        .y_desc("relative mean squared error")
        .y_label_formatter(&|v| format!("{v:.0e}"))
        .x_label_formatter(&|v| format!("{v:.0}"))
        .light_line_style(RGBColor(240, 240, 240))
        .draw()?;
    for curve in curves {
        let color = color(&curve.name);
        let points = || curve.points.iter().filter(|(_, e)| e.value > 0.0);
        let line = points().map(|(n, e)| (f64::from(*n), e.value));
        chart
            .draw_series(LineSeries::new(line, color.stroke_width(2)))?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        // Bars are the 95 % confidence intervals.
        chart.draw_series(points().map(|(n, e)| {
            let x = f64::from(*n);
            let least = (e.value - e.within).max(low);
            PathElement::new([(x, least), (x, e.value + e.within)], color.stroke_width(1))
        }))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
