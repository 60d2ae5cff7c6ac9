//! Reading `Camera "realistic"`: both spellings, and every problem of the lens file.

use super::autofocus::{LensMaker, Stop, Wish, wish};
use super::stop_shape;
use super::{Autofocus, Band, Compat, Exposure, Form, Precision, RealisticSpec, Weighting};
use crate::cameras::{CameraChoices, Clip, Shutter};
use crate::optics::coating::Coating;
use crate::optics::f_number::{ApertureError, ApertureNumber};
use crate::optics::ghosts::Ghosts;
use crate::optics::models::ModelKind;
use crate::optics::prescription::positions::PositionError;
use crate::optics::pupil::PupilSampling;
use crate::optics::report::length_text;
use crate::optics::{Lens, Prescription, PrescriptionError, StopShape, best_focus};
use crate::params::ParamReader;
use crate::syntax::ParamList;

/// Names only the course form has.
const COURSE_NAMES: [&str; 3] = ["specfile", "aperture_diameter", "filmdiag"];
/// Names only the pbrt-v3 form has. `simpleweighting` is not among them: course scenes carry it.
const PBRT3_NAMES: [&str; 3] = ["lensfile", "aperturediameter", "focusdistance"];

/// Stop diameter where none is given, mm: both forms' default.
const DEFAULT_APERTURE: f64 = 1.0;
/// Film distance of the course form, mm.
const DEFAULT_FILM_DISTANCE: f64 = 70.0;
/// Focus distance of the pbrt-v3 form, meters.
const DEFAULT_FOCUS_DISTANCE: f64 = 10.0;

/// Returns `true` if the parameters are those of the course's form of the camera.
pub(crate) fn is_course_form(params: &ParamList) -> bool {
    let given = |name: &&str| params.named(name).is_some();
    COURSE_NAMES.iter().any(given)
}

impl RealisticSpec {
    /// Reads the parameters and the lens file. Everything wrong with either is reported; `None`
    /// where no lens can be made. `choices` win over what the parameters say.
    pub fn from_params(params: &ParamReader, choices: &CameraChoices) -> Option<RealisticSpec> {
        let form = form(params);
        // The film's.
        params.accept("sensor");
        let shutter = Shutter::from_params(params);
        let compat = [("none", Compat::None), ("pbrt-v2", Compat::PbrtV2)];
        let compat = choice(params, "compat", compat);
        let pupil_sampling = [
            ("concentric", PupilSampling::Concentric),
            ("polar", PupilSampling::Polar),
            ("rejection", PupilSampling::Rejection),
        ];
        let pupil_sampling = choice(params, "pupilsampling", pupil_sampling);
        let model = model(params);
        let precision = [("single", Precision::Single), ("double", Precision::Double)];
        let precision = choice(params, "precision", precision);
        let weighting = match params.boolean("simpleweighting", form == Form::Pbrt3) {
            true => Weighting::Simple,
            false => Weighting::Physical,
        };
        let course = form == Form::Course;
        let film_diagonal =
            (course && params.has("filmdiag")).then(|| positive(params, "filmdiag", 35.0));
        let clip = match form {
            Form::Course => Clip::from_params(params),
            Form::Pbrt3 => Clip::NONE,
        };
        let (exposure, shift) = (Exposure::from_params(params), shift(params));
        let tilt = tilt(params);
        let stop_shape = stop_shape::from_params(params);
        let light = stop_shape.as_ref().map_or(1.0, StopShape::light);
        let (ghosts, coating) = (params.boolean("ghosts", false), coating(params));
        let number = |params: &ParamReader, prescription: &Prescription| {
            let number = number(params, light, choices.f_number)?;
            Some(match ghosts {
                true => number.of_reflecting(prescription, coating),
                false => number,
            })
        };
        let (prescription, mut maker) = prescription(params, form, number)?;
        let wish = wish(params, choices.focus_point);
        let lens = lens(params, form, &prescription)?;
        let bands = bands(params, &prescription, &lens);
        let nominal_focal_length = maker.nominal_focal_length();
        let autofocus = wish.map(|wish| {
            maker.best = form == Form::Pbrt3 && is_best(params);
            maker.dispersion = !bands.is_empty();
            let Wish {
                zones,
                object,
                place,
            } = wish;
            Box::new(Autofocus {
                zones,
                object,
                place,
                chosen: None,
                maker,
            })
        });
        if stop_shape.is_some() && !lens.surfaces().iter().any(|s| s.is_stop) {
            params.warn(
                given(params, ["aperture", "blades"]),
                "the lens has no stop row to be given a shape",
            );
        }
        let file = params.string(if course { "specfile" } else { "lensfile" }, "");
        let lens_name = file.rsplit(['/', '\\']).next().unwrap_or(file).to_string();
        Some(RealisticSpec {
            lens_name,
            nominal_focal_length,
            lens,
            form,
            weighting,
            compat,
            pupil_sampling,
            model,
            precision,
            stop_shape,
            bands,
            ghosts,
            coating,
            film_diagonal,
            shift,
            tilt,
            autofocus,
            shutter,
            exposure,
            clip,
        })
    }
}

/// The choice of this name, the first of `choices` unless another is given.
fn choice<T: Copy, const N: usize>(
    params: &ParamReader,
    name: &str,
    choices: [(&'static str, T); N],
) -> T {
    let chosen = params.one_of(name, &choices.map(|(word, _)| word));
    let chosen = choices.iter().find(|(word, _)| *word == chosen);
    chosen.unwrap_or(&choices[0]).1
}

/// What rays are to be made with. Scenes written for earlier versions may name approximations that are gone.
fn model(params: &ParamReader) -> ModelKind {
    match params.string("model", "exact") {
        gone @ ("polynomial" | "table" | "auto") => {
            params.accept("degree");
            params.accept("tolerance");
            params.note(format!(
                "there is no lens model `{gone}` any more: rays are traced exactly, which costs no more"
            ));
            ModelKind::Exact
        }
        _ => {
            let kinds = [
                ("exact", ModelKind::Exact),
                ("thick", ModelKind::Thick),
                ("thin", ModelKind::Thin),
            ];
            choice(params, "model", kinds)
        }
    }
}

/// Which spelling this is; a mixture is the course's.
fn form(params: &ParamReader) -> Form {
    let given = |names: [&'static str; 3]| names.into_iter().find(|n| params.has(n));
    match (given(COURSE_NAMES), given(PBRT3_NAMES)) {
        (None, _) => Form::Pbrt3,
        (Some(_), None) => Form::Course,
        (Some(course), Some(pbrt3)) => {
            params.warn(
                pbrt3,
                format!(
                    "\"{course}\" is the course form of this camera and \"{pbrt3}\" the pbrt-v3 form; \
                     read as the course form: millimeters, origin at the front vertex, no autofocus"
                ),
            );
            // Looked up so that it is not reported as unused besides.
            params.find_float("focusdistance");
            Form::Course
        }
    }
}

/// The first of `names` that was given; the first of all where none was.
fn given<'n>(params: &ParamReader, names: [&'n str; 2]) -> &'n str {
    if !params.has(names[0]) && params.has(names[1]) {
        names[1]
    } else {
        names[0]
    }
}

/// The surfaces, scaled and their stop set; and what makes them for another focus.
fn prescription(
    params: &ParamReader,
    form: Form,
    number: impl Fn(&ParamReader, &Prescription) -> Option<Number>,
) -> Option<(Prescription, LensMaker)> {
    // The form's own name first.
    let name = |[course, pbrt3]: [&'static str; 2]| match form {
        Form::Course => given(params, [course, pbrt3]),
        Form::Pbrt3 => given(params, [pbrt3, course]),
    };
    let aperture_name = name(["aperture_diameter", "aperturediameter"]);
    let aperture = positive(params, aperture_name, DEFAULT_APERTURE);
    let mut prescription = read(params, name(["specfile", "lensfile"]))?;
    let scale = positive(params, "scale", 1.0);
    if scale != 1.0 {
        prescription = prescription.scaled(scale);
    }
    let zoom = params.find_float("zoom");
    let unmoved = prescription.clone();
    let distance = match form {
        Form::Pbrt3 => {
            1e3 * params
                .find_float("focusdistance")
                .unwrap_or(DEFAULT_FOCUS_DISTANCE)
        }
        Form::Course => f64::INFINITY,
    };
    match prescription.at_position(zoom, distance) {
        Ok(positioned) => prescription = positioned,
        Err(e @ PositionError::NoZoom) => params.warn("zoom", e.to_string()),
        Err(e) => params.error("zoom", e.to_string()),
    }
    let number = number(params, &prescription);
    let maker = LensMaker {
        prescription: unmoved,
        zoom,
        stop: match &number {
            Some(number) => Stop::Number(number.number),
            None => Stop::Diameter(aperture),
        },
        best: false,
        dispersion: false,
    };
    if let Some(number) = number {
        if params.has(aperture_name) && number.name != OPTION {
            let message = format!("{} is given too, and wins", number.name);
            params.warn(aperture_name, message);
        }
        set_number(params, number, &mut prescription);
        return Some((prescription, maker));
    }
    for note in prescription.set_stops(aperture) {
        params.warn(aperture_name, note);
    }
    if params.has(aperture_name) && !prescription.has_stop() {
        params.warn(
            aperture_name,
            format!("the lens has no stop row, so {aperture_name} has no effect"),
        );
    }
    Some((prescription, maker))
}

/// The name of a number that comes from the command line.
const OPTION: &str = "--f-number";

/// What sets the stop, and who says so.
struct Number {
    name: &'static str,
    number: ApertureNumber,
}

impl Number {
    /// The same of a lens whose surfaces reflect, as these are or with this coating: a T-number knows of that. What they let through depends a little on the
    /// stop.
    fn of_reflecting(self, prescription: &Prescription, coating: Option<Coating>) -> Number {
        /// What is transmitted varies by some percent from pinhole to open, and the stop with a half of that: each round gains two digits.
        const ROUNDS: usize = 4;
        let ApertureNumber::T {
            number,
            transmission: light,
        } = self.number
        else {
            return self;
        };
        let mut found = self.number;
        for _ in 0..ROUNDS {
            let mut stopped = prescription.clone();
            if let Ok(diameter) = found.diameter(prescription) {
                stopped.set_stops(diameter);
            }
            // Wherever the film is.
            let Ok(lens) = Lens::new(&stopped, 1.0) else {
                return self;
            };
            let [transmitted, ..] = Ghosts::new(lens, coating).transmitted();
            if transmitted <= 0.0 {
                return self;
            }
            let transmission = light * transmitted;
            found = ApertureNumber::T {
                number,
                transmission,
            };
        }
        Number {
            number: found,
            ..self
        }
    }
}

/// What is on surfaces of which the lens file says nothing.
fn coating(params: &ParamReader) -> Option<Coating> {
    let text = params.string("coating", "");
    if text.is_empty() {
        return None;
    }
    if !params.boolean("ghosts", false) {
        params.warn(
            "coating",
            "without \"bool ghosts\" no surface reflects, and a coating changes nothing",
        );
    }
    text.parse().map_err(|e| params.error("coating", e)).ok()
}

/// The requested f-number or T-number; `light` is what the stop's shape lets through.
fn number(params: &ParamReader, light: f64, option: Option<f64>) -> Option<Number> {
    let (f, t) = (params.find_float("fnumber"), params.find_float("tnumber"));
    if f.is_some() && t.is_some() {
        params.warn("tnumber", "fnumber is given too, and wins");
    }
    let number = |name, number| Some(Number { name, number });
    match (option, f, t) {
        (Some(n), ..) => number(OPTION, ApertureNumber::F(n)),
        (None, Some(n), _) => number("fnumber", ApertureNumber::F(n)),
        (None, None, Some(n)) => number(
            "tnumber",
            ApertureNumber::T {
                number: n,
                transmission: light,
            },
        ),
        (None, None, None) => None,
    }
}

/// Sets the stops by a number. A lens that is too slow for it is opened.
fn set_number(params: &ParamReader, asked: Number, prescription: &mut Prescription) {
    match asked.number.diameter(prescription) {
        Ok(diameter) => {
            prescription.set_stops(diameter);
        }
        Err(e @ ApertureError::TooFast { .. }) => {
            params.warn(asked.name, format!("{} {e}: its stop is open", asked.name));
        }
        Err(e @ ApertureError::NoStop) => {
            params.warn(asked.name, format!("{e}, so {} has no effect", asked.name));
        }
        Err(e) => params.error(asked.name, format!("{}: {e}", asked.name)),
    }
}

/// How far the lens is moved across the film, mm.
fn shift(params: &ParamReader) -> [f64; 2] {
    let Some(given) = params.floats("shift") else {
        return [0.0; 2];
    };
    match given {
        [x, y] if x.is_finite() && y.is_finite() => [*x, *y],
        _ => {
            let message =
                "expected two numbers: how far the lens is moved to the right and up, in mm";
            params.error("shift", message);
            [0.0; 2]
        }
    }
}

/// How the film is tilted, degrees.
fn tilt(params: &ParamReader) -> [f64; 2] {
    let Some(given) = params.floats("tilt") else {
        return [0.0; 2];
    };
    let turned = |degrees: &f64| degrees.abs() < 90.0;
    match given {
        [x] if turned(x) => [*x, 0.0],
        [x, y] if turned(x) && turned(y) => [*x, *y],
        _ => {
            let message = "expected one or two angles of less than 90 degrees: how far the film's upper and right edges lean back";
            params.error("tilt", message);
            [0.0; 2]
        }
    }
}

/// The lens with its film in place.
fn lens(params: &ParamReader, form: Form, prescription: &Prescription) -> Option<Lens> {
    let film_distance = film_distance(params, form, prescription)?;
    Lens::new(prescription, film_distance)
        .map_err(|e| params.error("filmdistance", e.to_string()))
        .ok()
}

/// The bands of the spectrum that are asked for.
fn bands(params: &ParamReader, prescription: &Prescription, lens: &Lens) -> Vec<Band> {
    if !params.boolean("dispersion", false) {
        return Vec::new();
    }
    if !prescription.disperses() {
        params.warn(
            "dispersion",
            "the lens file tells no Abbe numbers (nor dispersion formulas), so all colors see the \
             indices of the d line",
        );
        return Vec::new();
    }
    // A formula that gives no index somewhere in the spectrum.
    Band::all(prescription, lens.film_distance())
        .map_err(|e| params.error("dispersion", e.to_string()))
        .unwrap_or_default()
}

/// Reads the lens file that parameter `name` gives.
fn read(params: &ParamReader, name: &str) -> Option<Prescription> {
    if !params.has(name) {
        params.error(
            name,
            format!("a realistic camera needs a lens file: expected \"string {name}\""),
        );
        return None;
    }
    // A file that does not exist has been reported.
    let path = params.file(name)?;
    match Prescription::read(&path) {
        Ok(prescription) => {
            for note in &prescription.warnings {
                params.warn(name, format!("{}: {note}", path.display()));
            }
            Some(prescription)
        }
        Err(PrescriptionError::Rows(notes)) => {
            for note in notes {
                params.error(name, format!("{}: {note}", path.display()));
            }
            None
        }
        Err(e) => {
            params.file_error(name, format!("{}: {e}", path.display()), e.is_failure());
            None
        }
    }
}

/// Returns `true` if the lens is focused by real rays.
fn is_best(params: &ParamReader) -> bool {
    params.one_of("focus", &["paraxial", "best"]) == "best"
}

/// From the rear vertex to the film, mm.
fn film_distance(params: &ParamReader, form: Form, prescription: &Prescription) -> Option<f64> {
    if params.has("filmdistance") {
        if form == Form::Pbrt3 && params.find_float("focusdistance").is_some() {
            params.warn("focusdistance", "filmdistance is given too, and wins");
        }
        let distance = positive(params, "filmdistance", DEFAULT_FILM_DISTANCE);
        warn_of_meters(params, distance, prescription);
        return Some(distance);
    }
    if form == Form::Course {
        let from_file = prescription.film_distance;
        return Some(if from_file > 0.0 {
            from_file
        } else {
            DEFAULT_FILM_DISTANCE
        });
    }
    let meters = match params.find_float("focusdistance") {
        // Focused at infinity.
        Some(f64::INFINITY) => f64::INFINITY,
        _ => positive(params, "focusdistance", DEFAULT_FOCUS_DISTANCE),
    };
    let distance = 1000.0 * meters;
    let film = match is_best(params) {
        true => best_focus::film_distance(prescription, distance),
        false => Lens::focused(prescription, distance),
    };
    film.map_err(|e| params.error("focusdistance", format!("{e} (focusdistance is in meters)")))
        .ok()
}

/// Warns where the film would be about where a far object is sharp if its distance were in meters, as in ISET3d's `omni`.
fn warn_of_meters(params: &ParamReader, distance: f64, prescription: &Prescription) {
    let in_meters = 1e3 * distance;
    let far = Lens::focused(prescription, f64::INFINITY);
    if distance < 0.5 && far.is_ok_and(|far| (0.5..2.0).contains(&(in_meters / far))) {
        params.warn(
            "filmdistance",
            format!(
                "filmdistance is in mm, and {distance} mm is very near; ISET3d's cameras have meters: write {}?",
                length_text(in_meters)
            ),
        );
    }
}

/// The parameter `name`, or `default`; anything but a positive number is an error.
fn positive(params: &ParamReader, name: &str, default: f64) -> f64 {
    let x = params.float(name, default);
    if x > 0.0 && x.is_finite() {
        return x;
    }
    params.error(name, format!("{name} is {x}; expected a positive number"));
    default
}
