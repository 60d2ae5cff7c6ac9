//! The lens report: one HTML page that needs nothing else.

use super::chart::Failure;
use super::{Bench, cross_section, plots};
use crate::cli::html::{self, escaped, table};
use crate::optics::LensReport;
use crate::optics::analysis::text::meters;
use crate::optics::analysis::{LensAnalysis, SeidelTerms};
use crate::optics::paraxial::Pupil;
use crate::optics::report;
use std::fmt::Write;

/// One image of the report with what is said about it.
pub(super) struct Figure {
    /// File name without ending, and the anchor on the page.
    pub slug: &'static str,
    /// Heading.
    pub title: &'static str,
    /// How to read it.
    pub caption: String,
    /// SVG documents, side by side.
    pub svgs: Vec<String>,
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

/// What the grid shows.
const OF_GRID: &str = "Where a square grid of the scene lies on the film, beside where a lens without distortion has it, of the same scale in the middle.";

/// What the field curves show.
const OF_FIELD_CURVES: &str = "Where narrow beams of the d line come to a focus, along real chief rays (Coddington). Between the two lies astigmatism; Petzval's surface, drawn through the focus of the axis, is where both would lie without it. Points far off are cut.";

/// What the longitudinal aberrations show.
const OF_LONGITUDINAL: &str = "Where rays of a point on the axis cross it, by their height in the pupil: an upright line is perfect, a slanted one has spherical aberration; lines apart are chromatic.";

/// What the focal shift shows.
const OF_FOCAL_SHIFT: &str = "Where rays near the axis come to a focus, relative to the d line. A curve that turns once is an achromat's, twice an apochromat's.";

/// What footprints show.
const OF_FOOTPRINTS: &str = "The part of the stop that light of each film height goes through; rims in front and behind cut the rest. It is the shape of highlights out of focus.";

/// What the contrast through focus shows.
const OF_THROUGH_FOCUS: &str = "At 30 line pairs per mm, by rays, as the film is moved. Solid: sagittal; dashed: tangential. Where contrast is negative black and white are reversed (spurious resolution).";

fn figures(bench: &Bench, analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let drawing = cross_section::svg(&bench.lens, bench.film, bench.object);
    let mut figures = vec![figure(
        "cross-section",
        "Cross-section",
        vec![drawing],
        OF_CROSS_SECTION,
    )];
    figures.extend(of_points(bench, analysis)?);
    figures.extend(of_contrast(analysis)?);
    figures.extend(of_focus(analysis)?);
    figures.extend(of_film(analysis)?);
    // A lens that lets nothing through has no curves.
    figures.retain(|figure| !figure.svgs.is_empty());
    Ok(figures)
}

fn figure(
    slug: &'static str,
    title: &'static str,
    svgs: Vec<String>,
    caption: impl Into<String>,
) -> Figure {
    Figure {
        slug,
        title,
        caption: caption.into(),
        svgs,
    }
}

/// Spots and fans.
fn of_points(bench: &Bench, analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let object = match bench.object.z {
        Some(_) => "a point of the object plane",
        None => "a distant point",
    };
    let colors = match &analysis.color {
        Some(_) => "Blue: F (486 nm); green: d (588 nm); vermilion: C (656 nm).",
        None => "d line (588 nm): the file says nothing of dispersion.",
    };
    let of_spots = format!(
        "Where rays from {object}, spread evenly over the beam, meet the film, about the centroid of the d line; above each the film height and the \
         root mean square radius (d). Each has a scale of its own. The black ellipse is Airy's disc, the least that diffraction allows. {colors}"
    );
    let of_fans = format!("{OF_FANS} {colors}");
    Ok(vec![
        figure("spots", "Spot diagrams", plots::spots(analysis)?, of_spots),
        figure("fans", "Ray aberrations", plots::fans(analysis)?, of_fans),
    ])
}

/// Contrast in all its forms.
fn of_contrast(analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let over_field = format!(
        "Geometric: the Fourier transform of the spots, at the film's position, without diffraction{}. Tangential contrast is that of lines across the \
         radius, sagittal that of lines along it. Where contrast is negative black and white are reversed.",
        diffraction(analysis)
    );
    let by_frequency = "Left (or above): geometric, from rays alone; right (or below): with diffraction, from the wavefront (d line). Solid: sagittal; dashed: tangential; colors are film heights. \
         Where contrast is negative black and white are reversed (spurious resolution).";
    Ok(vec![
        figure(
            "mtf-frequency",
            "MTF by frequency",
            plots::mtf_by_frequency(analysis)?,
            by_frequency,
        ),
        figure(
            "mtf",
            "MTF over the field",
            vec![plots::mtf(analysis)?],
            over_field,
        ),
        figure(
            "mtf-focus",
            "MTF through focus",
            plots::through_focus(analysis)?,
            OF_THROUGH_FOCUS,
        ),
    ])
}

/// Where fans and colors come to a focus.
fn of_focus(analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let mut figures = vec![
        figure(
            "field-curves",
            "Field curves",
            vec![plots::field_curves(analysis)?],
            OF_FIELD_CURVES,
        ),
        figure(
            "longitudinal",
            "Longitudinal aberration",
            vec![plots::longitudinal(analysis)?],
            OF_LONGITUDINAL,
        ),
    ];
    if let Some(color) = &analysis.color {
        figures.push(figure(
            "focal-shift",
            "Chromatic focal shift",
            vec![plots::focal_shift(color)?],
            OF_FOCAL_SHIFT,
        ));
        figures.push(figure(
            "color",
            "Lateral color",
            vec![plots::lateral_color(analysis, color)?],
            format!(
                "How much farther from the middle of the film blue and red light of a direction arrives than yellow (d). Indices from \
                 the file's formulas, or from Abbe numbers by a Cauchy formula of three terms. Blue focuses {} mm behind red.",
                cell(color.longitudinal, 3)
            ),
        ));
    }
    Ok(figures)
}

/// Shape and brightness of the image.
fn of_film(analysis: &LensAnalysis) -> Result<Vec<Figure>, Failure> {
    let grid = analysis
        .distortion_grid
        .as_ref()
        .map(plots::grid)
        .transpose()?;
    Ok(vec![
        figure(
            "distortion",
            "Distortion",
            vec![plots::distortion(analysis)?],
            OF_DISTORTION,
        ),
        figure(
            "grid",
            "Distortion grid",
            grid.into_iter().collect(),
            OF_GRID,
        ),
        figure(
            "illumination",
            "Relative illumination",
            vec![plots::illumination(analysis)?],
            OF_ILLUMINATION,
        ),
        figure(
            "footprints",
            "Pupil footprints",
            vec![plots::footprints(analysis)?],
            OF_FOOTPRINTS,
        ),
    ])
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
    body += "<main>\n";
    for (i, figure) in content.figures.iter().enumerate() {
        let wide = if figure.svgs.len() > 1 || i == 0 {
            " class=\"wide\""
        } else {
            ""
        };
        let _ = write!(
            body,
            "<section id=\"{}\"{wide}><h2>{}</h2>\n<figure><div>{}</div><figcaption>{}</figcaption></figure></section>\n",
            figure.slug,
            figure.title,
            figure.svgs.concat(),
            figure.caption
        );
        // What a photographer asks first comes right below the drawing.
        if i == 0 {
            body += &first_order(content);
        }
    }
    body += "</main>\n";
    body += &seidel_table(content.analysis);
    body += &field_table(content.analysis);
    body += &focus_table(content.analysis);
    body += &prescription(content.report);
    let note =
        " Lengths in millimeters, z from the front vertex toward the film, d line (587.56 nm).";
    html::page(&title, &(html::PLAIN.to_owned() + STYLE), &body, note)
}

/// Charts of one column stand in pairs where there is room, panels wrap, and what is too wide for a telephone is scrolled by itself. In the dark, colors
/// are turned over but for their hue.
const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#222;max-width:1000px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em;margin-bottom:0;overflow-wrap:anywhere}h2{font-size:1.15em;margin:1.6em 0 .4em}.lead{color:#555;margin-top:.2em}\
main{display:flex;flex-wrap:wrap;gap:0 2em}section{flex:1 1 340px;min-width:0;max-width:480px}section.wide{flex-basis:100%;max-width:100%}\
figure{margin:0}figure>div{display:flex;flex-wrap:wrap;overflow-x:auto}svg{max-width:100%;height:auto}figcaption{color:#555;max-width:46em}\
#cross-section svg{flex:none;min-width:640px}.scroll{overflow-x:auto}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}th,td{padding:.15em .8em;text-align:right;border-bottom:1px solid #e3e3e3}\
th{font-weight:600}td:first-child,th:first-child{text-align:left}.sum td{font-weight:600}.columns{display:flex;flex-wrap:wrap;gap:0 3em;flex-basis:100%}\
footer{margin:3em 0 1em;color:#777;font-size:.9em}\
@media (prefers-color-scheme:dark){body{background:#15171a;color:#ddd}.lead,figcaption{color:#aaa}th,td{border-color:#3a3d42}\
svg{filter:invert(.92) hue-rotate(180deg)}}";

/// A heading and a table that is scrolled where it is wider than the page.
fn under(heading: &str, table: &str, note: &str) -> String {
    format!("<h2>{heading}</h2>\n<div class=\"scroll\">{table}</div>{note}\n")
}

fn seidel_table(analysis: &LensAnalysis) -> String {
    let Some(seidel) = &analysis.seidel else {
        return String::new();
    };
    let row = |name: String, terms: &SeidelTerms| {
        let values = terms.values().map(|x| cell(Some(1e3 * x), 3));
        std::iter::once(name).chain(values).collect::<Vec<_>>()
    };
    let surfaces = seidel.surfaces.iter().enumerate();
    let mut rows: Vec<_> = surfaces
        .map(|(i, terms)| row((i + 1).to_string(), terms))
        .collect();
    rows.push(
        row("sum".to_string(), &seidel.sum)
            .into_iter()
            .map(|x| format!("<b>{x}</b>"))
            .collect(),
    );
    let head = [
        "surface",
        "S_I spherical",
        "S_II coma",
        "S_III astigmatism",
        "S_IV Petzval",
        "S_V distortion",
        "C_I axial",
        "C_II lateral",
    ];
    let note = format!(
        "<p>Micrometers of optical path, for an image at {:.2} mm and the stop as it is (Welford 1986, chapter 8). The wavefront at the rim is off by \
         S_I/8, S_II/2, S_III/2, (S_III + S_IV)/4 and S_V/2; colors between F and C.</p>",
        seidel.image_height
    );
    under("Seidel sums", &table(&head, rows), &note)
}

/// A number with `decimals`, or a dash.
fn cell(value: Option<f64>, decimals: usize) -> String {
    value
        .filter(|v| v.is_finite())
        .map_or_else(|| "–".to_string(), |v| report::decimals(v, decimals))
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
        "<section class=\"wide\"><h2>In numbers</h2><div class=\"columns\">{}{}{}</div></section>\n",
        column(&lengths),
        column(&planes),
        column(&view)
    )
}

fn degrees(value: Option<f64>) -> String {
    value.map_or_else(|| "not covered".to_string(), |v| format!("{v:.1}°"))
}

fn field_table(analysis: &LensAnalysis) -> String {
    let rows = analysis.shown(&analysis.fields).map(|p| {
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
    under("Over the field", &table(&head, rows), "")
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
    let note = format!(
        "<p>Distances from the film; the whole lens moves. Sharp: a blur of at most {:.0} µm.</p>",
        1e3 * analysis.film.circle_of_confusion()
    );
    under("Focus table", &table(&head, rows), &note)
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
    under("Prescription", &table(&head[..columns], rows), "")
}
