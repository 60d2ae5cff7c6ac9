//! What the scene file says of a realistic camera.

use super::tilted::TiltedFilm;
use super::{Autofocus, Band, Exposure};
use crate::cameras::{Clip, FilmGeometry, Shutter};
use crate::optics::coating::Coating;
use crate::optics::focus::{SharpPlane, sharp_plane};
use crate::optics::models::ModelKind;
use crate::optics::pupil::PupilSampling;
use crate::optics::{Lens, StopShape};
use crate::syntax::Span;

/// Which spelling a camera was written in: decides units and origin of camera space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Camera space in millimeters, origin at the front vertex.
    Course,
    /// Camera space in meters, origin at the film's center.
    Pbrt3,
}

/// Which renderer to imitate (`"string compat"`, `--compat`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compat {
    /// None: every film point sees its true exit pupil.
    #[default]
    None,
    /// The course kit's on pbrt-v2: samples the rear element's disk, flat at its vertex (and so
    /// misses what enters a curved element outside it), and drops a sample when the ray of the
    /// next pixel in x or in y through the same point of the disk is vignetted.
    PbrtV2,
}

/// What the radiance along a ray counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The pixel is the irradiance on the film (times the shutter's opening time, where that is
    /// not 0): n'²·A·cos⁴θ/Z², as radiance in a medium of index n' is n'² times that in air.
    Physical,
    /// pbrt-v3's `simpleweighting`: cos⁴θ times the pupil's area relative to pbrt's box around
    /// the pupil of the film's middle, so that a white scene gives at most 1. A relative weight, that knows no n'².
    Simple,
}

/// The number type that an image's rays are traced in (`"string precision"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f32, side by side.
    #[default]
    Single,
    /// f64, one ray at a time.
    Double,
}

/// A realistic camera as the scene file describes it: lens file read, stop set, focused.
#[derive(Clone, Debug)]
pub struct RealisticSpec {
    /// Name of the lens file, without folders.
    pub lens_name: String,
    /// The lens, its stop set and its film in place.
    pub lens: Lens,
    /// Its focal length at this zoom, focused at infinity, mm: what is engraved on it. `None` for an afocal one.
    pub nominal_focal_length: Option<f64>,
    /// Units and origin of camera space.
    pub form: Form,
    /// What rays count for.
    pub weighting: Weighting,
    /// Which renderer to imitate.
    pub compat: Compat,
    /// How lens samples are spread over the exit pupil.
    pub pupil_sampling: PupilSampling,
    /// What rays are made with.
    pub model: ModelKind,
    /// In which precision.
    pub precision: Precision,
    /// What the stop is shaped like, if not round.
    pub stop_shape: Option<StopShape>,
    /// The bands of the spectrum that rays are traced in; none: all at the d line.
    pub bands: Vec<Band>,
    /// `true` if surfaces reflect, so that there are ghosts.
    pub ghosts: bool,
    /// What is on surfaces between air and glass of which the lens file says nothing.
    pub coating: Option<Coating>,
    /// Film diagonal in mm that overrides the film's own (`filmdiag`).
    pub film_diagonal: Option<f64>,
    /// How far the lens is moved across the film's middle, mm: positive to the right and up, and the image shows what lies there.
    pub shift: [f64; 2],
    /// How the film is tilted, degrees: its upper edge away from the lens, then its right edge, seen from behind.
    pub tilt: [f64; 2],
    /// What of the image to focus on.
    pub autofocus: Option<Box<Autofocus>>,
    /// When light is let in.
    pub shutter: Shutter,
    /// For how long, and how much it counts.
    pub exposure: Exposure,
    /// Clip planes, in camera units.
    pub clip: Clip,
}

impl RealisticSpec {
    /// Returns `true` if surfaces reflect, as they do only where rays are traced through them.
    pub(super) fn reflects(&self) -> bool {
        self.ghosts && self.model == ModelKind::Exact && self.compat == Compat::None
    }

    /// The diagonal that counts, mm.
    pub fn diagonal(&self, film: &FilmGeometry) -> f64 {
        self.film_diagonal.unwrap_or(film.diagonal_mm)
    }

    /// The name of the thing to focus on, and where the scene asks for it.
    pub fn focus_object(&self) -> Option<(&str, Option<Span>)> {
        let auto = self.autofocus.as_ref()?;
        Some((auto.object.as_deref()?, auto.place))
    }

    /// Where the film lies, if it is tilted.
    pub(in super::super) fn tilted_film(&self) -> Option<TiltedFilm> {
        TiltedFilm::new(self.tilt, self.shift.map(|mm| 0.0 - mm), self.lens.film_z())
    }

    /// The plane that is sharp on a film that is tilted; `None` if it is not, or the lens has no focal length.
    pub(super) fn sharp_plane(&self) -> Option<SharpPlane> {
        let (z, slopes) = self.tilted_film()?.on_axis()?;
        let cardinals = self.lens.paraxial().cardinals?;
        Some(sharp_plane(&cardinals, z - self.lens.length(), slopes))
    }

    /// From the axis to the corner of the film that is farthest from it, mm.
    pub fn film_reach(&self, film: &FilmGeometry) -> f64 {
        let diagonal = self.diagonal(film);
        if self.shift == [0.0; 2] {
            return 0.5 * diagonal;
        }
        let [width, height] = film.size_mm(diagonal);
        let [x, y] = self.shift.map(f64::abs);
        (0.5 * width + x).hypot(0.5 * height + y)
    }
}
