//! The ghosts of a distant lamp, one row for each.

use super::Ghosts;
use crate::optics::Surface;
use crate::optics::f_number::working_number;
use crate::optics::trace::LensRay;
use serde::Serialize;
use std::fmt;

/// A ghost of a lamp at infinity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GhostRow {
    /// Numbers of the two surfaces, from 1 at the scene; light is reflected at the second one first.
    pub surfaces: [usize; 2],
    /// Its light over that of the lamp's image.
    pub light: f64,
    /// Its middle on the film, mm from the axis in the lamp's meridian; that of the lamp's image is of the other sign than the lamp's angle.
    pub height: f64,
    /// Diameter of a uniform disk that scatters as far as it does, 2 √2 times the root of the mean square distance from its middle, mm.
    pub diameter: f64,
    /// From the film to where it is sharp near the axis, mm, positive behind the film; `None` where that is infinite.
    pub focus: Option<f64>,
}

impl GhostRow {
    /// How bright it is: its light by area.
    #[must_use]
    pub fn brightness(&self) -> f64 {
        self.light / (self.diameter * self.diameter)
    }
}

/// What a lens makes of the light of a distant lamp.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GhostTable {
    /// Of the light on the axis that no rim and no stop blocks: the share that no surface reflects. Glass absorbs nothing.
    pub transmitted: f64,
    /// The T-number with that: the f-number of a lens without reflections and with the same light in the middle of the film. `None` where
    /// no light gets there. That of renders with `"bool ghosts"`; others, whose lenses do not reflect, are brighter.
    pub t_number: Option<f64>,
    /// The ghosts, the brightest by area first; those that no ray makes are left out.
    pub ghosts: Vec<GhostRow>,
}

/// Of a lamp at infinity, `degrees` off the axis, at the first of the wavelengths.
#[must_use]
pub fn table(ghosts: &Ghosts, degrees: f64) -> GhostTable {
    let [transmitted, ..] = ghosts.transmitted();
    GhostTable {
        transmitted,
        // Rays that are even in the entrance pupil are so in the squared sine at the film, as far as Abbe's sine condition holds.
        t_number: working_number(&ghosts.lens, transmitted).filter(|_| transmitted > 0.0),
        ghosts: rows(ghosts, degrees),
    }
}

/// Rays across the front surface: ghosts of a thousandth of its area are still seen.
const RAYS: usize = 100;

/// See [`GhostTable::ghosts`].
pub(super) fn rows(ghosts: &Ghosts, degrees: f64) -> Vec<GhostRow> {
    let rays = parallel(ghosts, degrees);
    let direct: f64 = { rays.iter() }
        .filter_map(|ray| ghosts.trace_direct(ray))
        .map(|arrival| arrival.light[0])
        .sum();
    let mut rows: Vec<GhostRow> = ghosts
        .pairs()
        .filter_map(|pair| row(ghosts, &rays, direct, pair))
        .collect();
    rows.sort_by(|a, b| b.brightness().total_cmp(&a.brightness()));
    rows
}

/// From the axis to the farthest that light of a distant lamp crosses the plane of the first vertex which meets the surface within its rim, mm.
pub(crate) fn reach(front: &Surface, degrees: f64) -> f64 {
    let radius = front.clear_radius();
    radius + front.sag(radius).abs() * degrees.to_radians().tan().abs()
}

/// Rays of a distant lamp over the clear aperture of the first surface, in the y-z plane.
pub(crate) fn parallel(ghosts: &Ghosts, degrees: f64) -> Vec<LensRay<f64>> {
    let Some(front) = ghosts.lens.surfaces().first() else {
        return Vec::new();
    };
    let (sin, cos) = degrees.to_radians().sin_cos();
    let radius = reach(front, degrees);
    let place = |k: usize| radius * (2.0 * (k as f64 + 0.5) / RAYS as f64 - 1.0);
    let all = (0..RAYS * RAYS).map(|k| [place(k % RAYS), place(k / RAYS)]);
    let inside = all.filter(|[x, y]| x * x + y * y <= radius * radius);
    // In the plane of the first vertex; what meets the glass before is followed back to it.
    inside
        .map(|[x, y]| LensRay::new([x, y, 0.0], [0.0, sin, cos]))
        .collect()
}

fn row(
    ghosts: &Ghosts,
    rays: &[LensRay<f64>],
    direct: f64,
    pair: (usize, usize),
) -> Option<GhostRow> {
    let hits: Vec<_> = rays
        .iter()
        .filter_map(|ray| ghosts.trace(ray, pair))
        .map(|arrival| (arrival.film, arrival.light[0]))
        .collect();
    let light: f64 = hits.iter().map(|(_, light)| light).sum();
    if light <= 0.0 || direct <= 0.0 {
        return None;
    }
    let mean = |value: &dyn Fn([f64; 2]) -> f64| {
        hits.iter().map(|(p, light)| light * value(*p)).sum::<f64>() / light
    };
    let middle = [mean(&|p| p[0]), mean(&|p| p[1])];
    let square = mean(&|p| (p[0] - middle[0]).powi(2) + (p[1] - middle[1]).powi(2));
    Some(GhostRow {
        surfaces: [pair.0 + 1, pair.1 + 1],
        light: light / direct,
        height: middle[1],
        diameter: 2.0 * (2.0 * square).sqrt(),
        focus: focus(ghosts, pair),
    })
}

/// Where parallel light near the axis meets it again, from the film, by tracing heights and angles from surface to surface; a reflection is
/// a refraction into the negative index (W. Welford, *Aberrations of Optical Systems*, 1986, §3.2).
fn focus(ghosts: &Ghosts, (i, j): (usize, usize)) -> Option<f64> {
    let surfaces = ghosts.lens.surfaces();
    let forth = (0..j).map(|k| (k, false)).chain([(j, true)]);
    let back = (i + 1..j).rev().map(|k| (k, false)).chain([(i, true)]);
    let again = (i + 1..surfaces.len()).map(|k| (k, false));
    // The index is negative while light runs toward the scene, and so are the ways: their quotient is not.
    let (mut y, mut nu, mut sign, mut last) = (1.0, 0.0, 1.0, None::<usize>);
    for (k, turns) in forth.chain(back).chain(again) {
        if let Some(last) = last {
            let gap = last.min(k);
            y += nu * surfaces[gap].thickness / surfaces[gap].index;
        }
        let boundary = ghosts.boundaries[k];
        let [here, beyond] = match sign > 0.0 {
            true => [boundary.from, boundary.into],
            false => [boundary.into, boundary.from],
        };
        let (n, next) = match turns {
            true => (sign * here, -sign * here),
            false => (sign * here, sign * beyond),
        };
        nu -= (next - n) * surfaces[k].curvature() * y;
        if turns {
            sign = -sign;
        }
        last = Some(k);
    }
    let index = surfaces.last()?.index;
    let from_last = -y * index / nu;
    (from_last.is_finite()).then_some(from_last - ghosts.lens.film_distance())
}

impl fmt::Display for GhostTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "light on the axis: {:.2} % transmitted",
            100.0 * self.transmitted
        )?;
        if let Some(t_number) = self.t_number {
            write!(f, ", T/{t_number:.2} with reflections counted")?;
        }
        f.write_str(
            "\n\n surfaces    light (%)  height (mm)  diameter (mm)  sharp behind the film (mm)\n",
        )?;
        for row in &self.ghosts {
            let [first, second] = row.surfaces;
            let focus = row
                .focus
                .map_or("-".to_string(), |focus| format!("{focus:.3}"));
            writeln!(
                f,
                "{:>9}  {:>11.5}  {:>11.3}  {:>13.3}  {:>26}",
                format!("{first}-{second}"),
                100.0 * row.light,
                row.height + 0.0,
                row.diameter,
                focus,
            )?;
        }
        Ok(())
    }
}
