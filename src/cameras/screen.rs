//! Which part of the projection plane the film shows.

use super::FilmGeometry;
use crate::math::DVec2;
use crate::params::ParamReader;

/// `frameaspectratio` and `screenwindow` of `perspective` and `orthographic` (docs/scene-language.md §3.1).
/// Source: Pharr, Jakob and Humphreys 2016, §6.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Screen {
    /// Width over height of the default window; the film's where absent.
    pub frame_aspect_ratio: Option<f64>,
    /// xmin, xmax, ymin, ymax of what the film shows, in screen coordinates. By default the shorter
    /// side goes from −1 to 1.
    pub window: Option<[f64; 4]>,
}

impl Screen {
    /// Reads the parameters; what means nothing is an error and leaves the default.
    pub fn from_params(params: &ParamReader) -> Screen {
        Screen {
            frame_aspect_ratio: frame_aspect_ratio(params),
            window: window(params),
        }
    }

    /// xmin, xmax, ymin, ymax behind `film`.
    pub fn window(&self, film: &FilmGeometry) -> [f64; 4] {
        let aspect = self
            .frame_aspect_ratio
            .unwrap_or(f64::from(film.resolution.x) / f64::from(film.resolution.y));
        self.window.unwrap_or(if aspect > 1.0 {
            [-aspect, aspect, -1.0, 1.0]
        } else {
            [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect]
        })
    }

    /// Screen coordinates of raster point (0, 0) of `film`, and their change per pixel.
    pub fn raster(&self, film: &FilmGeometry) -> (DVec2, DVec2) {
        let [xmin, xmax, ymin, ymax] = self.window(film);
        let size = DVec2::new(xmax - xmin, ymin - ymax);
        (DVec2::new(xmin, ymax), size / film.resolution.as_dvec2())
    }
}

fn frame_aspect_ratio(params: &ParamReader) -> Option<f64> {
    let ratio = params.find_float("frameaspectratio")?;
    if !(ratio > 0.0 && ratio.is_finite()) {
        params.error(
            "frameaspectratio",
            format!("frameaspectratio is {ratio}; expected a positive number"),
        );
        return None;
    }
    Some(ratio)
}

/// Reads `screenwindow`: four numbers that span an area.
fn window(params: &ParamReader) -> Option<[f64; 4]> {
    const EXPECTED: &str = "expected four numbers xmin xmax ymin ymax that span an area";
    let Ok(window) = <[f64; 4]>::try_from(params.floats("screenwindow")?) else {
        params.ignored("screenwindow", EXPECTED);
        return None;
    };
    let [xmin, xmax, ymin, ymax] = window;
    if xmin == xmax || ymin == ymax || !window.iter().all(|x| x.is_finite()) {
        params.error("screenwindow", EXPECTED);
        return None;
    }
    Some(window)
}
