//! What a photographer notes of an image, for the render line and the image's file.

use super::{Realistic, RealisticSpec};
use crate::cameras::FilmGeometry;
use crate::film::Photograph;
use crate::optics::Prescription;
use crate::optics::StopShape;
use crate::optics::analysis::Film;
use crate::optics::depth_of_field::depth_of_field;
use crate::optics::f_number::{t_number, working_number};
use crate::optics::ghosts::Ghosts;

/// Millimeters to meters, of what is finite.
fn meters(mm: f64) -> Option<f64> {
    mm.is_finite().then_some(1e-3 * mm)
}

impl Realistic {
    /// What was set, and what follows from it for the image on `film`.
    pub fn photograph(&self, film: &FilmGeometry) -> Photograph {
        let size = film.size_mm(self.spec.diagonal(film));
        let [x, y] = self.field_of_view(size);
        Photograph {
            field_of_view: x.zip(y).map(|(x, y)| [x, y]),
            ..self.spec.photograph(film)
        }
    }
}

impl RealisticSpec {
    /// What the spec alone tells of that.
    pub(super) fn photograph(&self, film: &FilmGeometry) -> Photograph {
        let lens = &self.lens;
        let paraxial = lens.paraxial();
        let diagonal = self.diagonal(film);
        let [width, height] = film.size_mm(diagonal);
        let circle = Film { width, height }.circle_of_confusion();
        let depth = depth_of_field(lens, lens.film_distance(), circle);
        let light = self.stop_shape.as_ref().map_or(1.0, StopShape::light);
        let light = light * self.transmitted();
        let plane = match self.sharp_plane() {
            None => lens.plane_of_focus().map(|z| lens.film_z() - z),
            // Where it meets the axis.
            Some(plane) => plane.on_axis().map(|z| lens.film_z() - z),
        };
        // What is sharp on a tilted film lies in a wedge, between no two distances.
        let depth = depth.filter(|_| self.tilt == [0.0; 2]);
        Photograph {
            lens: self.lens_name.clone(),
            f_number: paraxial.f_number,
            t_number: t_number(&self.prescription(), light),
            working_number: working_number(lens, light),
            focal_length: paraxial.cardinals.map(|c| c.focal_length),
            nominal_focal_length: self.nominal_focal_length,
            // Its ends are found by the pupil: see `Realistic::photograph`.
            field_of_view: None,
            pinhole_focal_length: lens.pinhole_focal_length(),
            entrance_pupil: paraxial.entrance_pupil.map(|p| lens.film_z() - p.z),
            focus: plane.and_then(meters),
            focused_at_infinity: plane == Some(f64::INFINITY),
            near: depth.and_then(|d| meters(d.near)),
            far: depth.and_then(|d| meters(d.far)),
            hyperfocal: depth.and_then(|d| d.hyperfocal).and_then(meters),
            exposure_time: self.exposure.seconds(&self.shutter),
            iso: self.exposure.iso,
            sensor: [width, height],
            pixel_pitch: 1e3 * width / f64::from(film.resolution.x),
            sensor_offset: self.shift.map(|mm| 0.0 - 1e3 * mm),
        }
    }

    /// The share of light along the axis that no surface reflects, at the d line; 1 if none does.
    pub(super) fn transmitted(&self) -> f64 {
        if !self.reflects() {
            return 1.0;
        }
        let [transmitted, ..] = Ghosts::new(self.lens.clone(), self.coating).transmitted();
        transmitted
    }

    /// The lens without its film.
    fn prescription(&self) -> Prescription {
        Prescription {
            surfaces: self.lens.surfaces().to_vec(),
            film_distance: self.lens.film_distance(),
            positions: None,
            warnings: Vec::new(),
        }
    }
}
