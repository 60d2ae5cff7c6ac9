//! Focus on what the image shows somewhere: `"float focuspoint"`, `"float autofocuszones"`, the course's `"string af_zones"`, and
//! `--focus-point`; or on one thing wherever the image shows it: `"string focusobject"`.
//!
//! A camera of the course takes small images of a zone with the film at many distances, and keeps the one of most contrast. What that looks for is known
//! here: rays from the middle of the pupil say how far the things in a zone are, and their median is what the lens is focused on, as by `focusdistance`.
//! It is right where there is no contrast, too. Of several zones the nearest counts, as most cameras have it. As the
//! view changes a little with the focus, that is repeated until it settles.

use super::{Band, Form, Realistic, RealisticSpec};
use crate::cameras::{CameraSample, FilmGeometry};
use crate::files;
use crate::math::ray::Ray;
use crate::math::{DVec3, Vec2, Vec3};
use crate::optics::f_number::ApertureNumber;
use crate::optics::{FocusError, Lens, Paraxial, Prescription, best_focus, focus};
use crate::params::ParamReader;
use crate::syntax::Span;
use std::fmt;
use std::path::Path;

/// A part of the image, in fractions of its width and height from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zone {
    /// The neighborhood of a point (x, y).
    Point([f64; 2]),
    /// A rectangle.
    Area {
        /// Left and right end.
        x: [f64; 2],
        /// Upper and lower end.
        y: [f64; 2],
    },
    /// All of it.
    Image,
}

impl fmt::Display for Zone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Zone::Point([x, y]) => write!(f, "the point {x} {y} of the image"),
            Zone::Area { x, y } => {
                let ([left, right], [top, bottom]) = (x, y);
                write!(f, "the zone {left} {right} {top} {bottom} of the image")
            }
            Zone::Image => write!(f, "the image"),
        }
    }
}

/// Rays along each side of a zone: of a thousand, the median is off by two percent of the zone's things.
const ACROSS_AREA: u32 = 32;

/// In all of the image, for one thing in it: what is a hundredth of it wide is met by one or two of these rays.
const ACROSS_IMAGE: u32 = 128;

/// Of a point, whose rays come from this many pixels to either side of it: a wire there, or a gap, is not what is looked at.
const ACROSS_POINT: u32 = 5;
const POINT_PIXELS: f64 = 2.0;

impl Zone {
    /// Raster points all over it.
    fn points(&self, film: &FilmGeometry) -> impl Iterator<Item = Vec2> {
        let size = film.resolution.as_dvec2().to_array();
        let (ends, count) = match *self {
            Zone::Point(p) => {
                let around = |i: usize| {
                    let middle = p[i] * size[i];
                    [middle - POINT_PIXELS, middle + POINT_PIXELS]
                };
                ([around(0), around(1)], ACROSS_POINT)
            }
            Zone::Area { x, y } => (
                [x.map(|v| v * size[0]), y.map(|v| v * size[1])],
                ACROSS_AREA,
            ),
            Zone::Image => (size.map(|n| [0.0, n]), ACROSS_IMAGE),
        };
        let at = move |axis: usize, i: u32| {
            let [low, high] = ends[axis];
            (low + (f64::from(i) + 0.5) / f64::from(count) * (high - low)) as f32
        };
        let all = (0..count).flat_map(move |j| (0..count).map(move |i| (i, j)));
        all.map(move |(i, j)| Vec2::new(at(0, i), at(1, j)))
    }
}

/// How the stop is set.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stop {
    /// To this diameter, mm.
    Diameter(f64),
    /// By a number.
    Number(ApertureNumber),
}

/// What to focus on, and all that is needed to do so.
#[derive(Clone, Debug)]
pub struct Autofocus {
    /// At least one.
    pub zones: Vec<Zone>,
    /// The name of the only thing that counts, if one is given.
    pub object: Option<String>,
    /// Where the scene asks for it; `None`: on the command line.
    pub place: Option<Span>,
    /// The one that the lens is focused on; `None` before it is.
    pub chosen: Option<Zone>,
    pub(super) maker: LensMaker,
}

/// Makes a lens of its file for any focus.
#[derive(Clone, Debug)]
pub(super) struct LensMaker {
    /// Scaled; groups and stop as in the file.
    pub prescription: Prescription,
    pub zoom: Option<f64>,
    pub stop: Stop,
    /// By real rays.
    pub best: bool,
    pub dispersion: bool,
}

/// Why what was found cannot be focused on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AutofocusError {
    /// Rays from there meet nothing.
    #[error("autofocus finds nothing in {0}, and the focus is left as it is")]
    Nothing(String),
    /// What is to be focused on is not seen.
    #[error("autofocus does not find `{0}` in the image, and the focus is left as it is")]
    Unseen(String),
    /// The lens does not focus so near.
    #[error("autofocus on {zone}: {error}")]
    Focus {
        /// What was to be focused on.
        zone: String,
        /// Why it is not.
        error: FocusError,
    },
}

impl Autofocus {
    /// What it focuses on in `zone`.
    pub(super) fn target(&self, zone: &Zone) -> String {
        match &self.object {
            Some(name) => format!("`{name}`"),
            None => zone.to_string(),
        }
    }
}

impl LensMaker {
    /// Focal length of the lens focused at infinity, mm; `None` if it is afocal.
    pub(super) fn nominal_focal_length(&self) -> Option<f64> {
        let lens = self.prescription.at_position(self.zoom, f64::INFINITY);
        let lens = lens.as_ref().unwrap_or(&self.prescription);
        Some(Paraxial::new(&lens.surfaces).cardinals?.focal_length)
    }

    /// Focused at a plane, mm from the film or, in the course's form, from the first vertex, and what it is in the bands of the spectrum.
    fn focused(&self, form: Form, distance: f64) -> Result<(Lens, Vec<Band>), FocusError> {
        // Only the film moves in the course's form.
        let from_film = match form {
            Form::Pbrt3 => distance,
            Form::Course => f64::INFINITY,
        };
        let moved = self.prescription.at_position(self.zoom, from_film);
        let mut lens = moved.unwrap_or_else(|_| self.prescription.clone());
        match self.stop {
            Stop::Diameter(diameter) => drop(lens.set_stops(diameter)),
            Stop::Number(number) => {
                // What is wrong with the number has been said; the stop is open then.
                if let Ok(diameter) = number.diameter(&lens) {
                    lens.set_stops(diameter);
                }
            }
        }
        let film_distance = match form {
            Form::Pbrt3 if self.best => best_focus::film_distance(&lens, distance)?,
            Form::Pbrt3 => Lens::focused(&lens, distance)?,
            Form::Course => {
                let cardinals = Paraxial::new(&lens.surfaces).cardinals;
                focus::film_distance_for_object(cardinals, distance)?
            }
        };
        let bands = match self.dispersion {
            true => Band::all(&lens, film_distance).unwrap_or_default(),
            false => Vec::new(),
        };
        let inside = FocusError::InsideLens {
            asked: distance,
            inside: -film_distance,
        };
        Ok((Lens::new(&lens, film_distance).map_err(|_| inside)?, bands))
    }
}

impl RealisticSpec {
    /// Focused on the point `p` of [`Realistic::fixed_point`]'s coordinates.
    fn focused_at(&self, auto: &Autofocus, p: DVec3) -> Result<RealisticSpec, FocusError> {
        let mut distance = -p.z;
        // The plane of a tilted film passes the axis elsewhere: its distances go with those of a flat film's, all but for the lens' own length.
        const STEPS: usize = 12;
        for _ in 0..STEPS {
            let (lens, bands) = auto.maker.focused(self.form, distance)?;
            let spec = RealisticSpec {
                lens,
                bands,
                ..self.clone()
            };
            let Some(plane) = spec.sharp_plane() else {
                return Ok(spec);
            };
            let [a, b, n] = plane.normal;
            let z = (plane.distance - a * p.x - b * p.y) / n - spec.fixed_z();
            let ratio = p.z / z;
            if (ratio - 1.0).abs() < 1e-9 {
                return Ok(spec);
            }
            distance *= ratio;
        }
        Err(FocusError::Unsettled { asked: -p.z })
    }

    /// z of what stays where it is in the scene while the lens is focused, mm: the film, or in the course's form the first vertex.
    pub(super) fn fixed_z(&self) -> f64 {
        match self.form {
            Form::Pbrt3 => self.lens.film_z(),
            Form::Course => 0.0,
        }
    }
}

impl Realistic {
    /// The camera as it is to be after one look through it: `sees` gives the first thing that a ray meets, if that counts. `None` for one without autofocus.
    pub fn refocused(
        &self,
        film: &FilmGeometry,
        sees: &dyn Fn(&Ray) -> Option<Vec3>,
    ) -> Option<Result<RealisticSpec, AutofocusError>> {
        let auto = self.spec.autofocus.as_deref()?;
        let middles = auto.zones.iter();
        let middles = middles.filter_map(|zone| Some((*zone, self.middle_of(zone, film, sees)?)));
        let nearest = middles.max_by(|(_, a), (_, b)| a.z.total_cmp(&b.z));
        let Some((zone, p)) = nearest else {
            if let Some(name) = &auto.object {
                return Some(Err(AutofocusError::Unseen(name.clone())));
            }
            let zones: Vec<String> = auto.zones.iter().map(Zone::to_string).collect();
            return Some(Err(AutofocusError::Nothing(zones.join(", "))));
        };
        let focused = self.spec.focused_at(auto, p).map(|mut spec| {
            if let Some(auto) = &mut spec.autofocus {
                auto.chosen = Some(zone);
            }
            spec
        });
        let zone = auto.target(&zone);
        Some(focused.map_err(|error| AutofocusError::Focus { zone, error }))
    }

    /// The point of median depth, of those that the zone shows.
    fn middle_of(
        &self,
        zone: &Zone,
        film: &FilmGeometry,
        sees: &dyn Fn(&Ray) -> Option<Vec3>,
    ) -> Option<DVec3> {
        let mut found: Vec<DVec3> = zone
            .points(film)
            .filter_map(|raster| self.fixed_point(sees(&self.middle_ray(raster)?)?))
            .filter(|p| p.z < 0.0)
            .collect();
        found.sort_by(|a, b| a.z.total_cmp(&b.z));
        found.get(found.len() / 2).copied()
    }

    /// The ray from the middle of the pupil, in the middle of the exposure, or one nearby that passes.
    fn middle_ray(&self, raster: Vec2) -> Option<Ray> {
        const TRIED: [[f32; 2]; 5] = [[0.5, 0.5], [0.7, 0.5], [0.3, 0.5], [0.5, 0.7], [0.5, 0.3]];
        TRIED.iter().find_map(|lens| {
            let sample = CameraSample {
                raster,
                time: 0.5,
                lens: Vec2::from(*lens),
                wavelength: 0.5,
            };
            Some(self.ray(&sample, false)?.ray)
        })
    }

    /// Lens coordinates of a render-space point, but with z from what does not move when the lens is focused; negative in front of it.
    fn fixed_point(&self, p: Vec3) -> Option<DVec3> {
        let placement = self.transform.placement(self.spec.shutter.time(0.5));
        let lens_from_camera = super::camera_from_lens(&self.spec).inverse();
        let p = lens_from_camera.transform_point3(placement.point(p));
        let p = p - DVec3::new(0.0, 0.0, self.spec.fixed_z());
        p.is_finite().then_some(p)
    }
}

/// What is to be focused on.
pub(super) struct Wish {
    pub zones: Vec<Zone>,
    pub object: Option<String>,
    pub place: Option<Span>,
}

/// What is requested, if anything. `point` comes from the command line, and wins.
pub(super) fn wish(params: &ParamReader, point: Option<[f64; 2]>) -> Option<Wish> {
    let object = params.find_string("focusobject").map(str::to_string);
    let image = object.as_ref().map(|_| vec![Zone::Image]);
    let [point_given, zones_given, zones_of_file] =
        [point_of, zones_of, zones_of_file].map(|read| read(params));
    if let Some(point) = point {
        return Some(Wish {
            zones: vec![Zone::Point(point)],
            object: None,
            place: None,
        });
    }
    let mut found = [
        ("focusobject", image),
        ("focuspoint", point_given),
        ("autofocuszones", zones_given),
        ("af_zones", zones_of_file),
    ]
    .into_iter()
    .filter_map(|(name, zones)| Some((name, zones?)));
    let (name, zones) = found.next()?;
    for (other, _) in found {
        params.warn(other, format!("{name} is given too, and wins"));
    }
    Some(Wish {
        zones,
        object,
        place: Some(params.place(name)),
    })
}

/// Returns `true` if it is a fraction.
fn is_part(x: &f64) -> bool {
    (0.0..=1.0).contains(x)
}

fn point_of(params: &ParamReader) -> Option<Vec<Zone>> {
    match params.floats("focuspoint")? {
        [x, y] if is_part(x) && is_part(y) => Some(vec![Zone::Point([*x, *y])]),
        _ => {
            let message = "expected a point of the image: two numbers from 0 to 1, from the left and from the top";
            params.error("focuspoint", message);
            None
        }
    }
}

/// What a zone is.
const ZONE: &str = "left, right, top and bottom, from 0 to 1 across the image";

fn zones_of(params: &ParamReader) -> Option<Vec<Zone>> {
    let zones = of_numbers(params.floats("autofocuszones")?);
    if zones.is_none() {
        params.error(
            "autofocuszones",
            format!("expected four numbers for each zone: {ZONE}"),
        );
    }
    zones
}

/// Of four numbers each; `None` unless all are zones.
fn of_numbers(numbers: &[f64]) -> Option<Vec<Zone>> {
    let (zones, []) = numbers.as_chunks::<4>() else {
        return None;
    };
    let zone = |[left, right, top, bottom]: &[f64; 4]| {
        let sound = [left, right, top, bottom].into_iter().all(is_part);
        (sound && left < right && top < bottom).then_some(Zone::Area {
            x: [*left, *right],
            y: [*top, *bottom],
        })
    };
    let zones: Option<Vec<Zone>> = zones.iter().map(zone).collect();
    zones.filter(|zones| !zones.is_empty())
}

/// Of a file as the course has them: a zone a line.
fn zones_of_file(params: &ParamReader) -> Option<Vec<Zone>> {
    // Scenes without say so by an empty name.
    let file = params.optional_file("af_zones")?;
    let problem =
        |what: String| params.error("af_zones", format!("{}: {what}", file.path.display()));
    read_zones(&file.path).map_err(problem).ok()
}

/// Bytes of a file of zones at most.
const LARGEST: u64 = 1 << 20;

fn read_zones(path: &Path) -> Result<Vec<Zone>, String> {
    let bytes = files::read(path, LARGEST).map_err(|problem| problem.to_string())?;
    let text = String::from_utf8_lossy(&bytes);
    let mut zones = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(|n| n.parse().ok()).collect();
        let zone = numbers
            .filter(|n| n.len() == 4)
            .and_then(|n| of_numbers(&n));
        zones.extend(
            zone.ok_or_else(|| format!("line {}: `{line}` is no zone; expected {ZONE}", i + 1))?,
        );
    }
    match zones.is_empty() {
        true => Err(format!("no zones; expected lines of {ZONE}")),
        false => Ok(zones),
    }
}
