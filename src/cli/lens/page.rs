//! The lens report: one HTML page that needs nothing else.

use super::chart::Failure;
use super::{Bench, cross_section, plots};
use crate::cli::html::{self, escaped, table};
use crate::optics::LensReport;
use crate::optics::analysis::LensAnalysis;
use crate::optics::analysis::text::meters;
use crate::optics::paraxial::Pupil;
use std::fmt::Write;

/// One image of the report with what is said about it.
pub(super) struct Figure {
    /// File name without ending, and the anchor on the page.
    pub slug: &'static str,
    /// Heading.
    pub title: &'static str,
    /// How to read it.
    pub caption: String,
    /// An SVG document.
    pub svg: String,
}

/// Everything on the page.
pub(super) struct Content<'a> {
    /// Of the lens.
    pub name: String,
    /// From the film to the object plane, mm; `None` at infinity.
    pub object_distance: Option<f64>,
    pub report: &'a LensReport,
    pub analysis: &'a LensAnalysis,
    pub figures: Vec<Figure>,
}

impl<'a> Content<'a> {
    /// Draws all images of a lens.
    pub(super) fn new(
        bench: &Bench,
        report: &'a LensReport,
        analysis: &'a LensAnalysis,
    ) -> Result<Content<'a>, Failure> {
        Ok(Content {
            name: bench.name.clone(),
            object_distance: bench.object.z.map(|z| bench.lens.film_z() - z),
            report,
            analysis,
            figures: figures(bench, analysis)?,
        })
    }

    /// Its name and the two numbers a photographer calls it by.
    pub(super) fn title(&self) -> String {
        let mut title = self.name.clone();
        if let Some(f) = self.report.effective_focal_length {
            let _ = write!(title, ": {f:.1} mm");
        }
        if let Some(n) = self.report.f_number {
            let _ = write!(title, " f/{n:.1}");
        }
        title
    }

    /// Where it is focused, in words.
    pub(super) fn focus(&self) -> String {
        match self.object_distance {
            Some(distance) => format!("{} m from the film", meters(distance)),
            None => "at infinity".to_string(),
        }
    }
}

/// What the cross-section shows.
const OF_CROSS_SECTION: &str = "To scale; light comes from the left. Blue: the beam of the middle of the film; vermilion and green: those of 0.7 \
             and 1 of half its diagonal (of the image circle, where that is smaller). S stop, F F′ focal points, H H′ principal planes, E E′ entrance and exit pupil (drawn \
             dashed and dotted), as far as they lie within the image. The darker the glass, the higher its index.";

/// What the curves of ray aberrations show.
const OF_FANS: &str = "How far from the chief ray the rays of a fan meet the film, for the film height above each pair. The pupil coordinate \
             is 1 at the rim of the axial beam; curves of vignetted beams are shorter. A straight slope is defocus, an S spherical \
             aberration, a bowl coma.";

/// What the curve of distortion shows.
const OF_DISTORTION: &str = "How much farther from the middle of the film the chief ray arrives than without distortion. Negative: barrel; \
             positive: pincushion.";

/// What the curve of illumination shows.
const OF_ILLUMINATION: &str = "Light on the film relative to its middle: the projected solid angle of the pupil, traced with all vignetting. A lens \
             of thin elements without vignetting would follow cos⁴.";

/// What the comparison of pupil samplings shows.
const OF_SAMPLING: &str = "Part of the rays that get through the lens, for what fstop aims at and for other ways to choose where to aim. \
             The paraxial exit pupil also misses light off the axis.";

fn figures(bench: &Bench, analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let figure = |slug, title, svg, caption: String| Figure {
        slug,
        title,
        caption,
        svg,
    };
    let object = match bench.object.z {
        Some(_) => "a point of the object plane",
        None => "a distant point",
    };
    let mut figures = vec![
        figure(
            "cross-section",
            "Cross-section",
            cross_section::svg(&bench.lens, bench.film, bench.object),
            OF_CROSS_SECTION.to_string(),
        ),
        figure(
            "spots",
            "Spot diagrams",
            plots::spots(analysis)?,
            format!(
                "Where rays from {object}, spread evenly over the beam, meet the film, about their centroid; above each the film \
                 height and the root mean square radius. All on one scale; d line."
            ),
        ),
        figure(
            "fans",
            "Ray aberrations",
            plots::fans(analysis)?,
            OF_FANS.to_string(),
        ),
        figure(
            "mtf",
            "MTF over the field",
            plots::mtf(analysis)?,
            format!(
                "Geometric: the Fourier transform of the spots, at the film's position, without diffraction{}. Tangential \
                 contrast is that of lines across the radius, sagittal that of lines along it.",
                diffraction(analysis)
            ),
        ),
        figure(
            "distortion",
            "Distortion",
            plots::distortion(analysis)?,
            OF_DISTORTION.to_string(),
        ),
        figure(
            "illumination",
            "Relative illumination",
            plots::illumination(analysis)?,
            OF_ILLUMINATION.to_string(),
        ),
        figure(
            "sampling",
            "Pupil sampling",
            plots::pass_fractions(analysis)?,
            OF_SAMPLING.to_string(),
        ),
    ];
    if let Some(color) = &analysis.color {
        figures.insert(
            4,
            figure(
                "color",
                "Lateral color",
                plots::lateral_color(analysis, color)?,
                format!(
                    "How much farther from the middle of the film blue and red light of a direction arrives than yellow (d). Indices from \
                     the Abbe numbers by a Cauchy formula of three terms. Blue focuses {} mm behind red.",
                    cell(color.longitudinal, 3)
                ),
            ),
        );
    }
    Ok(figures)
}

/// What diffraction would do at most, in words.
fn diffraction(analysis: &LensAnalysis) -> String {
    // Cut-off frequency 1/(λN) at 587.56 nm (Smith §15.10).
    analysis.effective_f_number.map_or_else(String::new, |n| {
        format!(
            " (which cuts off at {:.0} lp/mm here)",
            1.0 / (587.56e-6 * n)
        )
    })
}

/// The page.
pub(super) fn html(content: &Content) -> String {
    let mut body = String::new();
    let title = content.title();
    let _ = write!(
        body,
        "<h1>{}</h1>\n<p class=\"lead\">focused {}; film {:.1} mm × {:.1} mm.</p>\n",
        escaped(&title),
        content.focus(),
        content.analysis.film.width,
        content.analysis.film.height
    );
    for (i, figure) in content.figures.iter().enumerate() {
        let _ = write!(
            body,
            "<section id=\"{0}\"><h2>{1}</h2>\n<figure>{2}<figcaption>{3}</figcaption></figure></section>\n",
            figure.slug, figure.title, figure.svg, figure.caption
        );
        // What a photographer asks first comes right below the drawing.
        if i == 0 {
            body += &first_order(content);
        }
    }
    body += &field_table(content.analysis);
    body += &focus_table(content.analysis);
    body += &prescription(content.report);
    let note =
        " Lengths in millimeters, z from the front vertex toward the film, d line (587.56 nm).";
    html::page(&title, STYLE, &body, note)
}

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#222;max-width:1000px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em;margin-bottom:0}h2{font-size:1.15em;margin:1.6em 0 .4em}.lead{color:#555;margin-top:.2em}\
figure{margin:0}figure>svg{max-width:100%;height:auto}figcaption{color:#555;max-width:46em}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.15em .8em;text-align:right;border-bottom:1px solid #e3e3e3}\
th{font-weight:600}td:first-child,th:first-child{text-align:left}.columns{display:flex;flex-wrap:wrap;gap:0 3em}\
footer{margin:3em 0 1em;color:#777;font-size:.9em}";

/// A number with `decimals`, or a dash.
fn cell(value: Option<f64>, decimals: usize) -> String {
    value
        .filter(|v| v.is_finite())
        .map_or_else(|| "–".to_string(), |v| format!("{v:.decimals$}"))
}

fn first_order(content: &Content) -> String {
    let (r, a) = (content.report, content.analysis);
    let pupil = |pupil: Option<Pupil>| {
        let (z, diameter) = (pupil.map(|p| p.z), pupil.map(|p| p.diameter));
        format!("{}, {}", cell(z, 3), cell(diameter, 3))
    };
    let lengths = [
        ("effective focal length", cell(r.effective_focal_length, 3)),
        ("f-number", cell(r.f_number, 3)),
        ("effective f-number", cell(a.effective_f_number, 3)),
        ("back focal distance", cell(r.back_focal_distance, 3)),
        ("film distance", cell(Some(r.film_distance), 3)),
        ("length, first to last vertex", cell(Some(r.length), 3)),
    ];
    let planes = [
        ("front focal point z", cell(r.front_focal_distance, 3)),
        ("principal plane z, front", cell(r.front_principal_plane, 3)),
        ("principal plane z, rear", cell(r.rear_principal_plane, 3)),
        ("entrance pupil z, ⌀", pupil(r.entrance_pupil)),
        ("exit pupil z, ⌀", pupil(r.exit_pupil)),
    ];
    let view = [
        ("view, horizontal", degrees(a.field_of_view.horizontal)),
        ("view, vertical", degrees(a.field_of_view.vertical)),
        ("view, diagonal", degrees(a.field_of_view.diagonal)),
        ("image circle ⌀", cell(a.chief_limit.map(|l| 2.0 * l[0]), 1)),
        ("full field", degrees(a.chief_limit.map(|l| 2.0 * l[1]))),
    ];
    let column = |rows: &[(&str, String)]| {
        let cells = rows
            .iter()
            .map(|(name, value)| [name.to_string(), value.clone()]);
        table(&[], cells)
    };
    format!(
        "<h2>In numbers</h2><div class=\"columns\">{}{}{}</div>\n",
        column(&lengths),
        column(&planes),
        column(&view)
    )
}

fn degrees(value: Option<f64>) -> String {
    value.map_or_else(|| "not covered".to_string(), |v| format!("{v:.1}°"))
}

fn field_table(analysis: &LensAnalysis) -> String {
    let rows = analysis.fields.iter().map(|p| {
        vec![
            cell(Some(p.height), 2),
            cell(Some(p.field_angle), 2),
            cell(p.distortion, 3),
            cell(Some(100.0 * p.relative_illumination), 1),
            cell(Some(100.0 * p.cos4_field), 1),
            cell(p.spot_rms.map(|r| 1e3 * r), 1),
        ]
    });
    let head = [
        "film height",
        "field angle (°)",
        "distortion (%)",
        "illumination (%)",
        "cos⁴ (%)",
        "spot rms (µm)",
    ];
    format!("<h2>Over the field</h2>\n{}", table(&head, rows))
}

fn focus_table(analysis: &LensAnalysis) -> String {
    let distance = |mm: f64| match mm.is_finite() {
        true => meters(mm),
        false => "∞".to_string(),
    };
    let rows = analysis.focus.iter().map(|row| {
        vec![
            distance(row.distance),
            cell(Some(row.film_distance), 3),
            cell(Some(row.extension), 3),
            cell(Some(row.magnification), 4),
            row.near.map_or_else(|| "–".to_string(), distance),
            row.far.map_or_else(|| "–".to_string(), distance),
        ]
    });
    let head = [
        "focus (m)",
        "film distance",
        "extension",
        "magnification",
        "sharp from (m)",
        "to (m)",
    ];
    format!(
        "<h2>Focus table</h2>\n{}<p>Distances from the film; the whole lens moves. Sharp: a blur of at most {:.0} µm.</p>\n",
        table(&head, rows),
        1e3 * analysis.film.circle_of_confusion()
    )
}

fn prescription(report: &LensReport) -> String {
    let rows = report.surfaces.iter().enumerate().map(|(i, s)| {
        vec![
            (i + 1).to_string(),
            s.radius_text(),
            cell(Some(s.thickness), 4),
            cell(Some(s.index), 5),
            cell(s.abbe, 1),
            cell(Some(s.aperture), 3),
            s.shape().unwrap_or_default(),
        ]
    });
    let head = [
        "surface",
        "radius",
        "thickness",
        "index",
        "V",
        "diameter",
        "aspheric terms",
    ];
    // A column for what no surface has would only take room.
    let aspheric = report.surfaces.iter().any(|s| s.conic.is_some());
    let columns = head.len() - usize::from(!aspheric);
    let rows = rows.map(|row| row[..columns].to_vec());
    format!("<h2>Prescription</h2>\n{}", table(&head[..columns], rows))
}
