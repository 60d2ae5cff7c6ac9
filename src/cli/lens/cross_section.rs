//! The lens cut through its axis, to scale, with rays.

use crate::optics::analysis::path;
use crate::optics::analysis::{Beam, ChiefFinder, Film, ObjectPlane};
use crate::optics::pupil::RINGS;
use crate::optics::{ExitPupil, Lens, Surface};

/// Width of the image in pixels.
const WIDTH: f64 = 960.0;

/// Parts of half the film diagonal (or of the image circle, where that is smaller) whose beams are drawn, with colors as in the charts.
const FIELDS: [(f64, &str, usize); 3] = [
    (0.0, "#0072b2", 7),
    (0.7, "#d55e00", 5),
    (1.0, "#009e73", 5),
];

/// A polygon or line in lens coordinates, (z, y) mm.
type Line = Vec<[f64; 2]>;

/// Everything in the drawing, in mm.
struct Scene<'a> {
    lens: &'a Lens,
    film: Film,
    /// z of every vertex.
    vertices: Vec<f64>,
    /// The rays of each field.
    fans: Vec<(&'static str, Vec<Line>)>,
    /// Lowest and highest z.
    z: [f64; 2],
    /// Largest y and largest −y.
    y: [f64; 2],
}

/// Draws `lens` before `film` as an SVG document, with rays from `object`.
pub(super) fn svg(lens: &Lens, film: Film, object: ObjectPlane) -> String {
    let scene = Scene::new(lens, film, object);
    let mut image = Drawing::new(scene.z, scene.y);
    scene.draw(&mut image);
    image.finish()
}

impl<'a> Scene<'a> {
    fn new(lens: &'a Lens, film: Film, object: ObjectPlane) -> Scene<'a> {
        let mut z = 0.0;
        let vertices = lens
            .surfaces()
            .iter()
            .map(|s| {
                let at = z;
                z += s.thickness;
                at
            })
            .collect();
        let total = lens.film_z();
        let half_height = lens
            .surfaces()
            .iter()
            .map(Surface::clear_radius)
            .fold(0.5 * film.diagonal(), f64::max);
        let mut scene = Scene {
            lens,
            film,
            vertices,
            fans: Vec::new(),
            z: [-0.2 * total, 1.04 * total],
            y: [half_height; 2],
        };
        scene.trace_fans(0.2 * total, object);
        // Pupils near the lens belong into the image.
        for pupil in scene.pupils().collect::<Vec<_>>() {
            if (-0.6 * total..1.4 * total).contains(&pupil.z) {
                scene.z = [
                    scene.z[0].min(pupil.z - 0.03 * total),
                    scene.z[1].max(pupil.z + 0.03 * total),
                ];
                scene.y = scene.y.map(|y| y.max(0.5 * pupil.diameter));
            }
        }
        scene
    }

    fn pupils(&self) -> impl Iterator<Item = crate::optics::Pupil> {
        let p = self.lens.paraxial();
        [p.entrance_pupil, p.exit_pupil].into_iter().flatten()
    }

    /// The rays of every field, from wave fronts `lead` mm in front of the first surface.
    fn trace_fans(&mut self, lead: f64, object: ObjectPlane) {
        let chief = ChiefFinder::new(self.lens);
        let corner = chief
            .limit(10.0 * self.film.diagonal())
            .map_or(f64::INFINITY, |l| l[0])
            .min(0.5 * self.film.diagonal());
        let pupil = ExitPupil::new(self.lens, corner * (1.0 + 1e-6), RINGS);
        for (part, color, count) in FIELDS {
            let beam = chief
                .find(part * corner)
                .and_then(|ray| Beam::new(self.lens, &pupil, &ray, object));
            let Some(beam) = beam else { continue };
            let rays: Vec<Line> = fan(self.lens, &beam, count)
                .into_iter()
                .map(|v| {
                    let ray = beam.ray([0.0, v]);
                    let mut points = path::points(self.lens, &ray);
                    // On a plane across the chief ray, `lead` in front of where that enters.
                    let (o, c) = (beam.chief.ray.o, beam.chief.ray.d);
                    let to: f64 = (0..3).map(|i| c[i] * (o[i] - ray.o[i])).sum();
                    let t = (to + lead) / (0..3).map(|i| c[i] * ray.d[i]).sum::<f64>();
                    points.insert(0, std::array::from_fn(|i| ray.o[i] + t * ray.d[i]));
                    points.iter().map(|p| [p[2], p[1]]).collect()
                })
                .collect();
            for p in rays.iter().flatten() {
                self.y = [self.y[0].max(p[1]), self.y[1].max(-p[1])];
                self.z[0] = self.z[0].min(p[0]);
            }
            self.fans.push((color, rays));
        }
    }

    fn draw(&self, image: &mut Drawing) {
        image.line(&[[self.z[0], 0.0], [self.z[1], 0.0]], "axis");
        for (i, pair) in self.lens.surfaces().windows(2).enumerate() {
            if pair[0].index != 1.0 && !(pair[0].is_stop && pair[1].is_stop) {
                self.draw_glass(image, i);
            }
        }
        for (i, s) in self.lens.surfaces().iter().enumerate() {
            // A stop row is a plane of air as a rule, but a glass surface may be the stop.
            if s.is_stop && s.curvature() == 0.0 {
                continue;
            }
            image.line(&self.arc(i, s.clear_radius()), "surface");
        }
        for (color, rays) in &self.fans {
            for ray in rays {
                image.ray(ray, color);
            }
        }
        self.draw_stops(image);
        self.draw_pupils(image);
        let half = 0.5 * self.film.diagonal();
        let z = self.lens.film_z();
        image.line(&[[z, -half], [z, half]], "film");
        let [x, y] = image.at([z, half]);
        image.add(&format!(
            r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">film</text>"#,
            y - 6.0
        ));
        image.ruler(&self.marks());
        image.legend();
    }

    /// Surface `i` from −`radius` to `radius`.
    fn arc(&self, i: usize, radius: f64) -> Line {
        const STEPS: usize = 64;
        let s = &self.lens.surfaces()[i];
        (0..=STEPS)
            .map(|k| radius * (2.0 * k as f64 / STEPS as f64 - 1.0))
            .map(|y| [self.vertices[i] + s.sag(y), y])
            .collect()
    }

    /// The glass between surfaces `i` and `i + 1`. Where their diameters differ, the smaller one continues as a plane rim to
    /// the edge of the larger.
    fn draw_glass(&self, image: &mut Drawing, i: usize) {
        let radius = |k: usize| self.lens.surfaces()[k].clear_radius();
        let edge = radius(i).max(radius(i + 1));
        let mut outline = self.arc(i, radius(i));
        let mut back = self.arc(i + 1, radius(i + 1));
        back.reverse();
        let rim = |line: &Line, k: usize, y: f64| [line[k][0], y];
        let front_end = rim(&outline, outline.len() - 1, edge);
        let front_start = rim(&outline, 0, -edge);
        let back_end = rim(&back, back.len() - 1, -edge);
        let back_start = rim(&back, 0, edge);
        outline.extend([front_end, back_start]);
        outline.extend(back);
        outline.extend([back_end, front_start]);
        image.glass(&outline, self.lens.surfaces()[i].index);
    }

    fn draw_stops(&self, image: &mut Drawing) {
        for (stop, z) in self.stops() {
            let inner = 0.5 * stop.aperture;
            let tall = self.y[0].max(self.y[1]);
            let outer = inner.max(0.06 * tall) + 0.14 * tall;
            for side in [-1.0, 1.0] {
                image.line(&[[z, side * inner], [z, side * outer]], "stop");
            }
        }
    }

    /// The stops, each with its z.
    fn stops(&self) -> impl Iterator<Item = (&Surface, f64)> {
        let surfaces = self.lens.surfaces().iter().zip(&self.vertices);
        surfaces.filter(|(s, _)| s.is_stop).map(|(s, z)| (s, *z))
    }

    fn draw_pupils(&self, image: &mut Drawing) {
        let p = self.lens.paraxial();
        for (pupil, class) in [(p.entrance_pupil, "entrance"), (p.exit_pupil, "exit")] {
            let Some(pupil) = pupil.filter(|p| self.z[0] <= p.z && p.z <= self.z[1]) else {
                continue;
            };
            let half = 0.5 * pupil.diameter;
            image.line(&[[pupil.z, -half], [pupil.z, half]], class);
            for y in [-half, half] {
                let tick = 0.008 * (self.z[1] - self.z[0]);
                image.line(&[[pupil.z - tick, y], [pupil.z + tick, y]], class);
            }
        }
    }

    /// What lies where on the axis.
    fn marks(&self) -> Vec<(f64, &'static str)> {
        let p = self.lens.paraxial();
        let mut marks = Vec::new();
        if let Some(c) = p.cardinals {
            marks.extend([
                (c.front_focal_point, "F"),
                (c.front_principal_plane, "H"),
                (c.rear_principal_plane, "H′"),
                (c.rear_focal_point, "F′"),
            ]);
        }
        marks.extend(p.entrance_pupil.map(|p| (p.z, "E")));
        marks.extend(p.exit_pupil.map(|p| (p.z, "E′")));
        marks.extend(self.stops().map(|(_, z)| (z, "S")));
        marks.retain(|(z, _)| self.z[0] <= *z && *z <= self.z[1]);
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        marks
    }
}

/// `count` tangential coordinates spread evenly over the part of the beam that gets through.
fn fan(lens: &Lens, beam: &Beam, count: usize) -> Vec<f64> {
    let [low, high] = beam.extent[1];
    let at = |i: i32| low + (high - low) * f64::from(i) / 400.0;
    let passing: Vec<f64> = (0..=400)
        .map(at)
        .filter(|v| beam.on_film(lens, [0.0, *v]).is_some())
        .collect();
    let (Some(first), Some(last)) = (passing.first(), passing.last()) else {
        return Vec::new();
    };
    (0..count)
        .map(|i| first + (last - first) * i as f64 / (count - 1).max(1) as f64)
        .collect()
}

/// An SVG document, y upward from the axis in mm.
struct Drawing {
    body: String,
    z: [f64; 2],
    /// Pixels per mm.
    scale: f64,
    /// Pixel height of the axis.
    axis: f64,
    /// Pixels of the drawing below the axis.
    below: f64,
}

/// Pixels left free around the drawing, and for the ruler below it.
const MARGIN: f64 = 18.0;
const RULER: f64 = 98.0;

impl Drawing {
    fn new(z: [f64; 2], y: [f64; 2]) -> Drawing {
        let scale = (WIDTH - 2.0 * MARGIN) / (z[1] - z[0]);
        Drawing {
            body: String::new(),
            z,
            scale,
            axis: MARGIN + 8.0 + y[0] * scale,
            below: y[1] * scale,
        }
    }

    fn at(&self, p: [f64; 2]) -> [f64; 2] {
        [
            MARGIN + (p[0] - self.z[0]) * self.scale,
            self.axis - p[1] * self.scale,
        ]
    }

    fn points(&self, line: &[[f64; 2]]) -> String {
        let points = line.iter().map(|p| self.at(*p));
        let points: Vec<String> = points.map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        points.join(" ")
    }

    /// Appends an element, on a line of its own.
    fn add(&mut self, element: &str) {
        self.body += element;
        self.body.push('\n');
    }

    fn line(&mut self, line: &[[f64; 2]], class: &str) {
        let points = self.points(line);
        self.add(&format!(r#"<polyline class="{class}" points="{points}"/>"#));
    }

    fn ray(&mut self, line: &[[f64; 2]], color: &str) {
        let points = self.points(line);
        self.add(&format!(
            r#"<polyline class="ray" stroke="{color}" points="{points}"/>"#
        ));
    }

    /// Glass is the darker, the higher its index.
    fn glass(&mut self, outline: &[[f64; 2]], index: f64) {
        let points = self.points(outline);
        let opacity = (0.25 + 0.6 * (index - 1.4)).clamp(0.2, 0.75);
        self.add(&format!(
            r#"<polygon class="glass" fill-opacity="{opacity:.2}" points="{points}"><title>n = {index}</title></polygon>"#
        ));
    }

    /// A tick across the ruler from `[x, y]` to height `end` in pixels, with a text at height `text_y`.
    fn tick(&mut self, [x, y]: [f64; 2], end: f64, text: &str, text_y: f64) {
        self.add(&format!(
            r#"<polyline class="tick" points="{x:.1},{y:.1} {x:.1},{end:.1}"/><text x="{x:.1}" y="{text_y:.1}" text-anchor="middle">{text}</text>"#
        ));
    }

    fn bottom(&self) -> f64 {
        self.axis + self.below + 8.0
    }

    /// z in mm below the drawing, with the marks on it. Marks that would touch go in rows above each other.
    fn ruler(&mut self, marks: &[(f64, &str)]) {
        let y = self.bottom() + 44.0;
        let step = super::chart::tick_step((self.z[1] - self.z[0]) / 14.0);
        self.add(&format!(
            r#"<polyline class="tick" points="{MARGIN},{y:.1} {:.1},{y:.1}"/>"#,
            WIDTH - MARGIN
        ));
        let first = (self.z[0] / step).ceil() as i64;
        let last = (self.z[1] / step).floor() as i64;
        for i in first..=last {
            let z = i as f64 * step;
            let x = self.at([z, 0.0])[0];
            let unit = if i == last { " mm" } else { "" };
            // Three decimals at most are all a step of this kind needs.
            let text = format!("{}{unit}", (z * 1000.0).round() / 1000.0);
            self.tick([x, y], y + 5.0, &text, y + 19.0);
        }
        // Where the last mark of each row is.
        let mut last = [f64::NEG_INFINITY; 3];
        for (z, name) in marks {
            let x = self.at([*z, 0.0])[0];
            let row = last.iter().position(|l| *l <= x - 18.0).unwrap_or(0);
            last[row] = x;
            let top = y - 5.0 - 13.0 * row as f64;
            self.tick([x, y], top, name, top - 2.0);
        }
    }

    fn legend(&mut self) {
        let y = self.bottom() + 85.0;
        self.add(&format!(
            r##"<text x="{MARGIN}" y="{y:.1}" font-size="11" fill="#555">S stop · E entrance pupil (dashed) · E′ exit pupil (dotted) · F, F′ focal points · H, H′ principal planes</text>"##
        ));
    }

    fn finish(self) -> String {
        let height = self.bottom() + RULER;
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:.0}" viewBox="0 0 {WIDTH} {height:.0}" class="cross-section" font-family="sans-serif" font-size="12">
<style>
.cross-section polyline {{ fill: none; stroke-width: 1; stroke-linejoin: round; }}
.cross-section .glass {{ fill: #7fb2d9; stroke: #456; stroke-width: 0.5; }}
.cross-section .surface {{ stroke: #234; stroke-width: 1.2; }}
.cross-section .ray {{ stroke-width: 0.8; }}
.cross-section .axis {{ stroke: #888; stroke-width: 0.7; stroke-dasharray: 10 3 2 3; }}
.cross-section .stop {{ stroke: #000; stroke-width: 3; }}
.cross-section .film {{ stroke: #000; stroke-width: 2.5; }}
.cross-section .entrance {{ stroke: #a0307a; stroke-width: 1.4; stroke-dasharray: 5 3; }}
.cross-section .exit {{ stroke: #6a3fb0; stroke-width: 1.4; stroke-dasharray: 2 3; }}
.cross-section .tick {{ stroke: #444; }}
</style>
<rect width="100%" height="100%" fill="#fff"/>
{}</svg>
"##,
            self.body
        )
    }
}
