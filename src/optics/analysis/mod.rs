//! What real rays say about a lens: everything an optical designer plots and a photographer asks.
//!
//! [`LensAnalysis`] holds it all, ready for JSON and for the pages of `fstop lens --report`:
//!
//! * [`chief`]: the ray through the middle of the stop, hence angle of view and distortion ([`field`]);
//! * [`beam`]: all rays of one object point that get through, hence spot diagrams and MTF ([`spot`]) and ray
//!   aberration curves ([`fan`]);
//! * [`mtf`]: contrast against frequency and focus, by rays and by waves ([`wavefront`]);
//! * [`field_curves`], [`longitudinal`] and [`seidel`]: where fans and colors come to a focus, and which surface adds what;
//! * [`footprint`]: which part of the stop a beam goes through; [`grid`]: a distorted grid;
//! * [`illumination`]: the projected solid angle of the pupil seen from the film, hence the fall-off;
//! * [`color`]: where other colors go, for a lens whose glass is known that well;
//! * [`maps`]: distortion and shading as maps for compositing; [`psf`]: point spread functions over field, depth and color;
//! * [`focus_table`]: where the film goes for which distance, and the depth of field.
//!
//! The meridional (tangential) plane is x = 0: film points are (0, height), and an object above the axis is imaged
//! below it. Object points lie on a plane that is given ([`object`]). See Welford, *Aberrations of Optical Systems*,
//! 1986, chapter 7; Smith, *Modern Optical Engineering*, 4th edition, chapters 6, 9 and 15. All lengths
//! are millimeters, all rays those of the d line.

pub mod beam;
pub mod chief;
pub mod color;
mod contrast;
pub mod fan;
pub mod field;
pub mod field_curves;
pub mod film;
pub mod focus_table;
pub mod footprint;
pub mod grid;
pub mod illumination;
pub mod longitudinal;
pub mod maps;
pub mod mtf;
pub mod object;
pub mod path;
pub mod psf;
pub mod seidel;
pub mod spot;
pub mod text;
pub mod wavefront;
#[cfg(test)]
mod wide_tests;

pub use beam::Beam;
pub use chief::{ChiefFinder, ChiefRay};
pub use color::{Color, ColorPoint, LateralColor};
pub use fan::Fan;
pub use field::{FieldPoint, ReferenceScale};
pub use field_curves::FieldFocus;
pub use film::{FieldOfView, Film};
pub use focus_table::FocusRow;
pub use footprint::Footprint;
pub use grid::DistortionGrid;
pub use longitudinal::{FocalShift, Longitudinal};
pub use mtf::MtfCurves;
pub use object::ObjectPlane;
pub use seidel::{Seidel, SeidelTerms};
pub use spot::Spot;
pub use wavefront::Wavefront;

use super::dispersion::LINE_D;
use super::lens::Lens;
use super::prescription::Prescription;
use super::pupil::{ExitPupil, RINGS};
use psf::ColorLenses;
use serde::Serialize;

/// How finely a lens is analyzed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Points of the curves over the field, from the middle of the film to its corner.
    pub fields: usize,
    /// Rays across the beam of one object point; a spot has some 3/4 of the square of it.
    pub rays_across: usize,
    /// Samples of the pupil from one film point, for illumination.
    pub pupil_samples: u32,
}

impl Effort {
    /// Curves that look smooth and numbers good to three digits, in less than a second on one core.
    pub const REPORT: Effort = Effort {
        fields: 25,
        rays_across: 128,
        pupil_samples: 1 << 13,
    };
}

/// Spatial frequencies of the MTF over the field, line pairs per mm: those of lens data sheets.
pub const MTF_FREQUENCIES: [f64; 3] = [10.0, 20.0, 40.0];

/// Rows over the field that are shown by default: every fifth of the field.
pub const ROWS: usize = 6;

/// The film heights of spot diagrams and ray fans, in parts of [`LensAnalysis::image_radius`]: the middle, half-way,
/// the zone of equal areas (0.7), near the edge and the edge.
pub const SPOT_FIELDS: [f64; 5] = [0.0, 0.5, 0.7, 0.9, 1.0];

/// Everything real rays say about a lens that is stopped down and focused.
#[derive(Clone, Debug, Serialize)]
pub struct LensAnalysis {
    /// The film behind it.
    pub film: Film,
    /// Angle of view on that film.
    pub field_of_view: FieldOfView,
    /// The largest film height whose chief ray gets through, and the angle in degrees at which that ray comes
    /// in; `None` where there is no such limit below ten film diagonals.
    pub chief_limit: Option<[f64; 2]>,
    /// Half the film diagonal, or the radius of the image circle where that is smaller, mm.
    pub image_radius: f64,
    /// f-number of the beam that really reaches the middle of the film: 1/(2 n' sin u').
    pub effective_f_number: Option<f64>,
    /// Rows over the field that text and page show.
    #[serde(skip)]
    pub rows: usize,
    /// From the middle of the film to the image radius.
    pub fields: Vec<FieldPoint>,
    /// Spatial frequencies of [`FieldPoint::mtf`], line pairs per mm.
    pub mtf_frequencies: [f64; 3],
    /// Spots at some film heights, drawn with fewer rays than the numbers are computed from.
    pub spots: Vec<Spot>,
    /// Ray aberrations at the same heights.
    pub fans: Vec<Fan>,
    /// Film distances for object distances.
    pub focus: Vec<FocusRow>,
    /// Contrast at the same heights, against frequency and through focus.
    pub mtf: Vec<MtfCurves>,
    /// The part of the stop that their beams go through.
    pub footprints: Vec<Footprint>,
    /// Sagittal and tangential focus over the field.
    pub field_curves: Vec<FieldFocus>,
    /// Where rays of a point on the axis cross it, by color: C, d, F, or d alone where the file knows no dispersion.
    pub longitudinal: Vec<Longitudinal>,
    /// What each surface adds to the aberrations of third order, for an image at `image_radius`.
    pub seidel: Option<Seidel>,
    /// A square grid as the film has it.
    pub distortion_grid: Option<DistortionGrid>,
    /// Color errors; `None` where the file knows no dispersion.
    pub color: Option<Color>,
}

impl LensAnalysis {
    /// Of `lens` before `film`, looking at `object`.
    pub fn new(lens: &Lens, film: Film, object: ObjectPlane, effort: &Effort) -> LensAnalysis {
        let chief = ChiefFinder::new(lens);
        let chief_limit = chief.limit(10.0 * film.diagonal());
        let corner = chief_limit
            .map_or(f64::INFINITY, |l| l[0])
            .min(0.5 * film.diagonal());
        // The corner itself must lie within the last ring.
        let pupil = ExitPupil::new(lens, corner * (1.0 + 1e-6), RINGS);
        let heights = |count: usize| {
            let last = count.max(2) - 1;
            (0..=last).map(move |i| corner * i as f64 / last as f64)
        };
        let at_axis = illumination::projected_solid_angle(lens, &pupil, 0.0, effort.pupil_samples);
        let scale = ReferenceScale::new(&chief, object, corner);
        let fields = heights(effort.fields)
            .map_while(|height| {
                let context = field::Context {
                    lens,
                    pupil: &pupil,
                    chief: &chief,
                    scale,
                    at_axis,
                    effort,
                };
                context.point(height)
            })
            .collect();
        let beam = |height: f64| Beam::new(lens, &pupil, &chief.find(height)?, object);
        let beams: Vec<Beam> = SPOT_FIELDS
            .iter()
            .filter_map(|part| beam(part * corner))
            .collect();
        let axial_radius = axial_radius(lens, &beams);
        let axis = beams.first().and_then(|b| FieldFocus::new(lens, b, None));
        let axial_focus = axis.and_then(|focus| focus.tangential);
        LensAnalysis {
            film,
            field_of_view: FieldOfView::new(&chief, film),
            chief_limit,
            image_radius: corner,
            effective_f_number: illumination::effective_f_number(at_axis, lens.rear().index),
            rows: ROWS,
            fields,
            mtf_frequencies: MTF_FREQUENCIES,
            spots: of_beams(&beams, |b| Spot::trace(lens, b, DRAWN_ACROSS)),
            fans: of_beams(&beams, |b| Fan::trace(lens, b, axial_radius)),
            focus: focus_table::rows(lens, film),
            mtf: of_beams(&beams, |b| MtfCurves::new(lens, b)),
            footprints: of_beams(&beams, |b| Footprint::new(lens, b)),
            field_curves: heights(effort.fields)
                .filter_map(|height| FieldFocus::new(lens, &beam(height)?, axial_focus))
                .collect(),
            longitudinal: of_beams(&beams[..beams.len().min(1)], |b| {
                Longitudinal::new(lens, LINE_D, b)
            }),
            seidel: Seidel::new(lens, object, corner),
            distortion_grid: DistortionGrid::new(lens, film, object),
            color: None,
        }
    }

    /// With the color errors of the lens, of which `prescription` says what its glasses do to other wavelengths; the same where it does not.
    pub fn with_color(
        mut self,
        lens: &Lens,
        prescription: &Prescription,
        object: ObjectPlane,
    ) -> LensAnalysis {
        let corner = self.image_radius;
        self.color = Color::new(prescription, lens.film_distance(), corner);
        let (Some(color), Some(colors)) = (
            &mut self.color,
            ColorLenses::new(prescription, lens.film_distance(), self.film),
        ) else {
            return self;
        };
        let chief = ChiefFinder::new(lens);
        let pupil = ExitPupil::new(lens, corner * (1.0 + 1e-6), RINGS);
        let beam = |part: &f64| Beam::new(lens, &pupil, &chief.find(part * corner)?, object);
        let beams: Vec<Beam> = SPOT_FIELDS.iter().filter_map(beam).collect();
        let axial_radius = axial_radius(lens, &beams);
        let [red, _, blue] = colors.lenses();
        color.points = of_beams(&beams, |b| ColorPoint {
            spots: [red, blue].map(|lens| Spot::trace(lens, b, DRAWN_ACROSS)),
            fans: [red, blue].map(|lens| Fan::trace(lens, b, axial_radius)),
        });
        color.focal_shift = FocalShift::over_the_spectrum(prescription, object);
        if let Some(axial) = beams.first() {
            let of = colors.lenses().iter().zip(psf::COLORS);
            let of = of.map(|(lens, wavelength)| Longitudinal::new(lens, wavelength, axial));
            self.longitudinal = of.collect();
        }
        self
    }
}

/// Enough rays across a beam for the eye to see the shape of its spot.
const DRAWN_ACROSS: usize = 48;

fn of_beams<T>(beams: &[Beam], of: impl Fn(&Beam) -> T) -> Vec<T> {
    beams.iter().map(of).collect()
}

/// Half the height of the axial beam, which is the first.
fn axial_radius(lens: &Lens, beams: &[Beam]) -> f64 {
    let rim = beams.first().map_or(0.0, |beam| beam.rim(lens, 1)[1]);
    if rim > 0.0 { rim } else { 1.0 }
}
