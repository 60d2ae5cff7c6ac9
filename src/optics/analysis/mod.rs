//! What real rays say about a lens: everything an optical designer plots and a photographer asks.
//!
//! [`LensAnalysis`] holds it all, ready for JSON and for the pages of `fstop lens --report`:
//!
//! * [`chief`]: the ray through the middle of the stop, hence angle of view and distortion ([`field`]);
//! * [`beam`]: all rays of one object point that get through, hence spot diagrams and MTF ([`spot`]) and ray
//!   aberration curves ([`fan`]);
//! * [`illumination`]: the projected solid angle of the pupil seen from the film, hence the fall-off;
//! * [`sampling`]: how many of the rays of several ways to sample the pupil get through;
//! * [`color`]: where other colors go, for a lens whose glass is known that well;
//! * [`focus_table`]: where the film goes for which distance, and the depth of field.
//!
//! The meridional (tangential) plane is x = 0: film points are (0, height), and an object above the axis is imaged
//! below it. Object points lie on a plane that is given ([`object`]). See Welford, *Aberrations of Optical Systems*,
//! 1986, chapter 7; Smith, *Modern Optical Engineering*, 4th edition, chapters 6, 9 and 15. All lengths
//! are millimeters, all rays those of the d line.

pub mod beam;
pub mod chief;
pub mod color;
pub mod fan;
pub mod field;
pub mod film;
pub mod focus_table;
pub mod illumination;
pub mod object;
pub mod path;
pub mod sampling;
pub mod spot;
pub mod text;
#[cfg(test)]
mod wide_tests;

pub use beam::Beam;
pub use chief::{ChiefFinder, ChiefRay};
pub use color::{Color, LateralColor};
pub use fan::Fan;
pub use field::{FieldPoint, ReferenceScale};
pub use film::{FieldOfView, Film};
pub use focus_table::FocusRow;
pub use object::ObjectPlane;
pub use sampling::PassFractions;
pub use spot::Spot;

use super::lens::Lens;
use super::pupil::{ExitPupil, RINGS};
use serde::Serialize;

/// How finely a lens is analyzed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Points of the curves over the field, from the middle of the film to its corner.
    pub fields: usize,
    /// Rays across the beam of one object point; a spot has some 3/4 of the square of it.
    pub rays_across: usize,
    /// Samples of the pupil from one film point, for illumination and pass fractions.
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
    /// Color errors; filled in by those who have the prescription ([`Color::new`]).
    pub color: Option<Color>,
    /// How well pupil sampling works, over the field.
    pub pass_fractions: Vec<PassFractions>,
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
        let beams: Vec<Beam> = SPOT_FIELDS
            .iter()
            .filter_map(|part| Beam::new(lens, &pupil, &chief.find(part * corner)?, object))
            .collect();
        let axial_radius = beams.first().map_or(1.0, Beam::half_height);
        // Enough rays for the eye to see the shape of the spot.
        const DRAWN_ACROSS: usize = 48;
        LensAnalysis {
            film,
            field_of_view: FieldOfView::new(&chief, film),
            chief_limit,
            image_radius: corner,
            effective_f_number: illumination::effective_f_number(at_axis, lens.rear().index),
            fields,
            mtf_frequencies: MTF_FREQUENCIES,
            spots: beams
                .iter()
                .map(|b| Spot::trace(lens, b, DRAWN_ACROSS))
                .collect(),
            fans: beams
                .iter()
                .map(|b| Fan::trace(lens, b, axial_radius))
                .collect(),
            focus: focus_table::rows(lens, film),
            color: None,
            pass_fractions: sampling::over_the_field(lens, &pupil, corner, effort.pupil_samples),
        }
    }
}
