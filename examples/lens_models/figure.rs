//! A scatter plot with logarithmic axes, as SVG.

use std::fmt::Write;

/// One measurement.
pub struct Point {
    /// What it belongs to: the part before the comma decides its colour.
    pub series: String,
    /// Drawn as a ring?
    pub hollow: bool,
    /// Shown when pointed at.
    pub label: String,
    /// Horizontal and vertical value; what lies beyond the axes is drawn at their ends.
    pub at: [f64; 2],
}

/// An axis from 10^`low` to 10^`high`.
pub struct Axis {
    pub title: &'static str,
    pub low: i32,
    pub high: i32,
}

impl Axis {
    /// Where a value lies, from 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let low = f64::from(self.low);
        ((value.log10() - low) / (f64::from(self.high) - low)).clamp(0.0, 1.0)
    }
}

const SIZE: [f64; 2] = [900.0, 560.0];
const LEFT: f64 = 70.0;
const BOTTOM: f64 = 60.0;
const TOP: f64 = 20.0;
/// Room for the legend.
const RIGHT: f64 = 210.0;

/// Okabe and Ito's colours, told apart by the colour-blind too ("Color Universal Design", 2008).
const COLORS: [&str; 10] = [
    "#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999",
    "#f0e442", "#882255",
];

/// The plot.
pub fn scatter(points: &[Point], [x, y]: [Axis; 2]) -> String {
    let (width, height) = (SIZE[0] - LEFT - RIGHT, SIZE[1] - TOP - BOTTOM);
    let place = |at: [f64; 2]| {
        [
            LEFT + width * x.place(at[0]),
            TOP + height * (1.0 - y.place(at[1])),
        ]
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        SIZE[0], SIZE[1]
    );
    // Writing to a string cannot fail.
    let mut draw = |line: String| {
        let _ = writeln!(svg, "{line}");
    };
    let bottom = TOP + height;
    for k in x.low..=x.high {
        let [at, _] = place([10f64.powi(k), 1.0]);
        draw(format!(
            "<path d=\"M{at:.1} {TOP}V{bottom:.1}\" stroke=\"#ddd\"/>"
        ));
        draw(format!(
            "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            bottom + 18.0,
            power(k)
        ));
    }
    for k in y.low..=y.high {
        for tick in [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(k)) {
            if y.place(tick) >= 1.0 && k == y.high && tick > 10f64.powi(k) {
                continue;
            }
            let [_, at] = place([1.0, tick]);
            draw(format!(
                "<path d=\"M{LEFT} {at:.1}h{width:.1}\" stroke=\"#ddd\"/>"
            ));
            draw(format!(
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{tick}</text>",
                LEFT - 6.0,
                at + 4.0
            ));
        }
    }
    draw(format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
        LEFT + 0.5 * width,
        SIZE[1] - 14.0,
        x.title
    ));
    draw(format!(
        "<text transform=\"translate(18 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        TOP + 0.5 * height,
        y.title
    ));
    // Colours by the first part of the name, in the order of appearance.
    let mut colors: Vec<&str> = Vec::new();
    let mut series: Vec<(&str, bool)> = Vec::new();
    for p in points {
        let first = p.series.split(',').next().unwrap_or_default();
        if !colors.contains(&first) {
            colors.push(first);
        }
        if !series.contains(&(p.series.as_str(), p.hollow)) {
            series.push((&p.series, p.hollow));
        }
    }
    series.sort_by_key(|(_, hollow)| *hollow);
    for (i, (name, hollow)) in series.iter().enumerate() {
        let first = name.split(',').next().unwrap_or_default();
        let color = colors.iter().position(|c| *c == first).unwrap_or(0);
        let color = COLORS[color % COLORS.len()];
        let style = if *hollow {
            format!("fill=\"none\" stroke=\"{color}\"")
        } else {
            format!("fill=\"{color}\" fill-opacity=\"0.7\"")
        };
        let at = TOP + 20.0 * i as f64 + 10.0;
        let legend = SIZE[0] - RIGHT + 16.0;
        draw(format!(
            "<circle cx=\"{legend}\" cy=\"{at}\" r=\"5\" {style}/><text x=\"{}\" y=\"{}\">{name}</text>",
            legend + 12.0,
            at + 4.0
        ));
        for p in points.iter().filter(|p| p.series == *name) {
            let [cx, cy] = place(p.at);
            draw(format!(
                "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"4\" {style}><title>{}</title></circle>",
                p.label
            ));
        }
    }
    svg + "</svg>\n"
}

fn power(k: i32) -> String {
    match k {
        0..=3 => format!("{}", 10i32.pow(k as u32)),
        -3..=-1 => format!("{}", 10f64.powi(k)),
        _ => format!("1e{k}"),
    }
}
