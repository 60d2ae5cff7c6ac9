//! What a photographer wants to know of a realistic camera before the image is taken.

use super::{Band, Compat, Realistic, Weighting};
use crate::cameras::FilmGeometry;
use crate::film::Photograph;
use crate::optics::analysis::illumination::{effective_f_number, spread};
use crate::optics::focus::hinge_distance;
use crate::optics::models::ModelKind;
use crate::optics::pupil::projected_solid_angle;
use crate::optics::report::length_text;

impl Realistic {
    /// See [`crate::cameras::Camera::describe`].
    pub fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        let spec = &self.spec;
        let lens = &spec.lens;
        let [width, height] = film.size_mm(spec.diagonal(film));
        let pitch = 1000.0 * width / f64::from(film.resolution.x);
        let mut lines = vec![
            self.lens_line(),
            format!(
                "film {width:.2} x {height:.2} mm, {:.4} mm behind the last surface, pixels of {pitch:.1} um",
                lens.film_distance()
            ),
            self.focus_line(),
        ];
        let chosen = { spec.autofocus.as_ref() }.and_then(|auto| Some(auto.target(&auto.chosen?)));
        lines.extend(chosen.map(|target| format!("focused on {target}")));
        lines.extend(photograph_lines(&self.photograph(film)));
        lines.push(self.field_of_view_line([width, height], spec.diagonal(film)));
        lines.push(format!(
            "about {:.1} % of the rays are vignetted",
            100.0 * self.vignetted_fraction(film)
        ));
        if self.main.model.kind() != ModelKind::Exact {
            lines.push(format!(
                "rays by the lens model `{}`",
                self.main.model.kind()
            ));
        }
        if let Some(ghosts) = &self.main.ghosts {
            lines.push(format!(
                "surfaces reflect: {:.1} % of the light on the axis is transmitted, and {} pairs of them make ghosts",
                100.0 * spec.transmitted(),
                ghosts.pairs().count()
            ));
        }
        if self.disperses() {
            let nanometers = |band: Option<&Band>| band.map_or(0.0, |b| 1000.0 * b.wavelength);
            lines.push(format!(
                "dispersion in {} bands, {:.0} to {:.0} nm",
                spec.bands.len(),
                nanometers(spec.bands.first()),
                nanometers(spec.bands.last())
            ));
        }
        if spec.compat == Compat::PbrtV2 {
            lines.push("sampling the rear element as the course kit on pbrt-v2 did".to_string());
        }
        if spec.weighting == Weighting::Physical
            && spec.shutter.open == spec.shutter.close
            && spec.exposure.time.is_none()
        {
            lines.push("equal shutter times: no exposure factor".to_string());
        }
        lines
    }

    /// The angles that the middle row and column of a film of this size, mm, see, degrees; `None` where an end is dark.
    pub(super) fn field_of_view(&self, size: [f64; 2]) -> [Option<f64>; 2] {
        if let Some(ends) = self.tilted_ends(size) {
            return ends.map(|ends| Some(self.angle_between(ends)?.abs()));
        }
        let shift = self.spec.shift;
        [0, 1].map(|i| {
            let half = 0.5 * size[i];
            self.angle_between([shift[i] - half, shift[i] + half])
        })
    }

    /// Between what two points of a line through the flat film's middle see, mm from there; degrees.
    fn angle_between(&self, [low, high]: [f64; 2]) -> Option<f64> {
        let signed = |x: f64| Some(self.field_angle(x.abs())?.copysign(x));
        Some((signed(high)? - signed(low)?).to_degrees())
    }

    /// Of a film of this size, mm, and of its diagonal where its middle lies on the axis.
    fn field_of_view_line(&self, size: [f64; 2], diagonal: f64) -> String {
        let text =
            |angle: Option<f64>| angle.map_or("dark".to_string(), |angle| format!("{angle:.1}"));
        let [x, y] = self.field_of_view(size).map(text);
        let view = format!("field of view {x} x {y} degrees");
        if self.tilted.is_some() {
            return view;
        }
        if self.spec.shift == [0.0; 2] {
            let corners = text(self.angle_between([-0.5 * diagonal, 0.5 * diagonal]));
            return format!("{view}, diagonal {corners}");
        }
        let [right, up] = self.spec.shift.map(length_text);
        format!("{view}, the lens shifted {right} mm to the right and {up} mm up")
    }

    /// Where the lines from the ends of a tilted film's middle row and column through the middle of the pupil meet the flat film: x of the one's and y
    /// of the other's, mm. `None` if it is not tilted.
    fn tilted_ends(&self, size: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let tilted = self.tilted.as_ref()?;
        let pupil = [0.0, 0.0, self.main.model.plane_z()];
        let shift = self.spec.shift;
        let end = |axis: usize, side: f64| {
            let mut film = [-shift[0], -shift[1]];
            film[axis] += 0.5 * side * size[axis];
            tilted.on_flat(film, pupil)[axis]
        };
        Some([0, 1].map(|axis| [end(axis, -1.0), end(axis, 1.0)]))
    }

    fn lens_line(&self) -> String {
        let paraxial = self.spec.lens.paraxial();
        let stop = &self.spec.lens.surfaces()[paraxial.stop];
        let focal = match paraxial.cardinals {
            Some(c) => format!("focal length {:.3} mm", c.focal_length),
            None => "afocal".to_string(),
        };
        let number = match self.effective_f_number() {
            Some(n) => format!("effective f/{n:.2}"),
            None => "no light".to_string(),
        };
        format!(
            "lens of {} surfaces, {focal}, {number} ({} {} mm)",
            self.spec.lens.surfaces().len(),
            if stop.is_stop {
                "stop"
            } else {
                "no stop; narrowest rim"
            },
            length_text(stop.aperture)
        )
    }

    /// f-number of the light that reaches the middle of the film, which rims in front of the stop may narrow and a near focus
    /// does; `None` where none does.
    fn effective_f_number(&self) -> Option<f64> {
        // To a percent of the area where rims cut the pupil, and a half of that of the f-number.
        const SAMPLES: u32 = 4096;
        let film = [0.0, 0.0];
        let at = [0.0, 0.0, self.spec.lens.film_z()];
        let light = spread(SAMPLES).filter_map(|u| {
            let aim = self.main.aim(film, u)?;
            self.main.model.trace_from_film(film, aim.point).ok()?;
            Some(projected_solid_angle(at, &aim))
        });
        let mean = light.sum::<f64>() / f64::from(SAMPLES);
        effective_f_number(mean, self.spec.lens.rear().index)
    }

    fn focus_line(&self) -> String {
        if let Some(line) = self.tilt_line() {
            return line;
        }
        match self.spec.lens.plane_of_focus() {
            Some(z) if z == f64::NEG_INFINITY => "focused at infinity".to_string(),
            Some(z) => format!(
                "plane of focus {} in front of the lens, {} from the film",
                length(-z),
                length(self.spec.lens.film_z() - z)
            ),
            None => "no plane of focus in front of the lens".to_string(),
        }
    }

    /// Where the plane of focus of a tilted film lies; `None` if it is not tilted or the lens has no focal length.
    fn tilt_line(&self) -> Option<String> {
        let plane = self.spec.sharp_plane()?;
        let (_, slopes) = self.tilted.as_ref()?.on_axis()?;
        let cardinals = self.spec.lens.paraxial().cardinals?;
        let [x, y] = self.spec.tilt.map(length_text);
        let axis = match plane.on_axis() {
            Some(z) if z < 0.0 => format!(
                "meets the axis {} from the film",
                length(self.spec.lens.film_z() - z)
            ),
            _ => "does not meet the axis in front of the lens".to_string(),
        };
        Some(format!(
            "film tilted by {x} and {y} degrees: the plane of focus {axis}, and the front focal plane {} from the axis",
            length(hinge_distance(&cardinals, slopes))
        ))
    }

    /// See [`crate::cameras::Camera::warnings`].
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let lens = &self.spec.lens;
        if self.spec.ghosts && !self.has_ghosts() {
            warnings.push(
                "there are no ghosts: they need the lens model `exact`, no `compat`, and a camera that no projection places"
                    .to_string(),
            );
        }
        match lens.plane_of_focus() {
            // Some part of the film may well be in focus, or it is about to move.
            _ if self.tilted.is_some() || self.spec.autofocus.is_some() => {}
            Some(z) if z >= 0.0 => warnings.push(format!(
                "the lens is focused inside itself, {} behind its front vertex: is the film distance of {} mm right?",
                length(z),
                length_text(lens.film_distance())
            )),
            None => warnings.push(format!(
                "no object in front of the lens is in focus: the film, {} mm behind the last surface, is nearer than the focal point",
                length_text(lens.film_distance())
            )),
            Some(_) => {}
        }
        let rear = lens.rear();
        let rim = rear.sag(rear.clear_radius());
        if rim >= lens.film_distance() {
            warnings.push(format!(
                "the film lies inside the rear element, whose rim reaches {rim:.3} mm behind its vertex"
            ));
        }
        if rear.index != 1.0 {
            warnings.push(format!("the film lies in a medium of index {}", rear.index));
        }
        // Double precision has sixteen digits, of which the outline of a pupil wants six.
        let narrowest = lens.surfaces().iter().map(|s| s.aperture);
        let narrowest = narrowest.fold(f64::INFINITY, f64::min);
        if narrowest < 1e-8 * lens.film_z() {
            warnings.push(format!(
                "an aperture of {} mm is too fine to trace rays through: light may be lost",
                length_text(narrowest)
            ));
        }
        if self.field_angle(0.0).is_none() {
            warnings.push("no light reaches the middle of the film".to_string());
        }
        warnings
    }
}

/// The numbers of the image beside those of the lens.
fn photograph_lines(p: &Photograph) -> Vec<String> {
    let text = |m: f64| length(1e3 * m);
    let mut numbers = Vec::new();
    numbers.extend(p.t_number.map(|t| format!("T{t:.2}")));
    numbers.extend(
        p.f_number
            .map(|n| format!("f/{n:.2} by focal length and entrance pupil")),
    );
    if let Some(f) = p.pinhole_focal_length {
        numbers.push(format!("view of a pinhole {f:.3} mm from its film"));
    }
    let mut sharp = Vec::new();
    if let Some(near) = p.near {
        let far = p.far.map_or("infinity".to_string(), text);
        sharp.push(format!(
            "depth of field {} to {far} from the film",
            text(near)
        ));
    }
    sharp.extend(
        p.hyperfocal
            .map(|h| format!("hyperfocal distance {}", text(h))),
    );
    let mut exposure = Vec::new();
    if let Some(iso) = p.iso {
        let time = p
            .exposure_time
            .map_or("no time".to_string(), |t| format!("{t} s"));
        exposure.push(format!("exposed for {time} at ISO {iso}"));
    }
    let lines = [numbers, sharp, exposure].into_iter();
    lines
        .filter(|l| !l.is_empty())
        .map(|l| l.join(", "))
        .collect()
}

/// A length in mm, in the unit a photographer would say.
fn length(mm: f64) -> String {
    if mm.abs() >= 1000.0 {
        format!("{:.3} m", 1e-3 * mm)
    } else {
        format!("{mm:.2} mm")
    }
}
