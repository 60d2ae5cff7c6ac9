//! Ghosts: light that is reflected twice inside the lens and gets to the film where it does not belong.
//!
//! Of n surfaces that reflect, n (n − 1) / 2 pairs make a ghost each: light goes through the lens to the farther surface of the pair,
//! back to the nearer one, and from there to the film (J. Maxwell, "Stray light from lens reflections", 1970s practice, as in
//! M. Hullin, E. Eisemann, H.-P. Seidel and S. Lee, "Physically-Based Real-Time Lens Flare Rendering", SIGGRAPH 2011, §3). At each
//! surface the ray carries on the share that is transmitted or reflected there, of unpolarized light, at three wavelengths side by side:
//! a coating has a color. Glass absorbs nothing.

mod table;

pub use table::{GhostRow, GhostTable, table};
#[cfg(test)]
pub(crate) use table::{parallel, reach};

use super::coating::{Boundary, Coating};
use super::element::{Split, Toward};
use super::lens::Lens;
use super::stop_shape::StopShape;
use super::surface::Surface;
use super::trace::LensRay;

/// A lens whose surfaces reflect.
#[derive(Clone, Debug)]
pub struct Ghosts {
    lens: Lens,
    /// Of each surface, for light toward the film.
    boundaries: Vec<Boundary>,
    /// Of the light, in vacuum, nm.
    wavelengths: [f64; 3],
}

/// The d line of helium, at which lens files have their indices, nm.
pub const D_LINE: f64 = 587.5618;

/// What becomes of the light of a ray, all reflections counted, in the mean of its wavelengths; the sum is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Gets to the film's side without a reflection: the image.
    pub transmitted: f64,
    /// After two reflections or more: ghosts.
    pub ghosts: f64,
    /// Leaves toward the scene.
    pub returned: f64,
    /// Ends at a rim, a stop or the barrel.
    pub stopped: f64,
    /// Too faint to be followed any longer.
    pub left: f64,
}

impl Balance {
    /// Of all that has become of it.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.transmitted + self.ghosts + self.returned + self.stopped + self.left
    }
}

/// Light that has come to the plane of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Where it meets the plane, mm from the axis.
    pub film: [f64; 2],
    /// Along which ray, from the last surface on, in lens coordinates.
    pub ray: LensRay<f64>,
    /// The share of the ray's light, at each wavelength.
    pub light: [f64; 3],
}

/// A ray on its way: z is relative to the vertex of the last surface that it met, before the first to that of `next`.
struct Traveller {
    ray: LensRay<f64>,
    next: Option<usize>,
    toward: Toward,
    light: [f64; 3],
    reflections: u32,
}

impl Ghosts {
    /// Of light at the d line. `coating`, if there is one, is on all surfaces between air and glass of which the lens file says none;
    /// cemented ones have none of it.
    #[must_use]
    pub fn new(lens: Lens, coating: Option<Coating>) -> Ghosts {
        let mut from = 1.0;
        let boundary = |surface: &Surface| {
            let into = surface.index;
            let from = std::mem::replace(&mut from, into);
            let own = surface.coating;
            let coating = own.or(coating.filter(|_| from == 1.0 || into == 1.0));
            Boundary {
                from,
                into,
                coating: coating.filter(|_| from != into),
            }
        };
        Ghosts {
            boundaries: lens.surfaces().iter().map(boundary).collect(),
            lens,
            wavelengths: [D_LINE; 3],
        }
    }

    /// Of light at these wavelengths, nm, all of them by the indices that the lens has.
    #[must_use]
    pub fn at(self, wavelengths: [f64; 3]) -> Ghosts {
        Ghosts {
            wavelengths,
            ..self
        }
    }

    /// The pairs of surfaces that make ghosts, from 0: the nearer to the scene, where light is reflected second, then the farther.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let reflects = |i: &usize| self.boundaries[*i].from != self.boundaries[*i].into;
        let farther = (0..self.boundaries.len()).filter(reflects);
        farther.flat_map(move |j| (0..j).filter(reflects).map(move |i| (i, j)))
    }

    /// Where a ray from the scene meets the plane of the film after the reflections of a pair, and how much of its light gets there. z is
    /// relative to the first vertex. `None` where it does not get there.
    #[must_use]
    pub fn trace(&self, ray: &LensRay<f64>, (i, j): (usize, usize)) -> Option<Arrival> {
        let mut at = self.enter(ray);
        while let Some(next) = at.next {
            let turns = (at.reflections == 0 && next == j) || (at.reflections == 1 && next == i);
            let [on, back] = self.meet(&at)?;
            at = if turns { back? } else { on? };
        }
        self.on_film(&at)
    }

    /// The same without a reflection: the image.
    #[must_use]
    pub fn trace_direct(&self, ray: &LensRay<f64>) -> Option<Arrival> {
        let mut at = self.enter(ray);
        while at.next.is_some() {
            let [on, _] = self.meet(&at)?;
            at = on?;
        }
        self.on_film(&at)
    }

    /// The share of its light that a ray from the film keeps on its way to the scene, z relative to the first vertex; light that comes along it from
    /// the scene keeps the same (Stokes). What an image of the stop takes is not counted. `None` where it does not get through.
    #[must_use]
    pub fn through(&self, ray: &LensRay<f64>) -> Option<[f64; 3]> {
        let mut ray = *ray;
        ray.o[2] -= self.lens.length();
        let mut light = [1.0; 3];
        for i in (0..self.boundaries.len()).rev() {
            let split = { self.lens.tracer() }.split(i, Toward::Scene, false, ray)?;
            let reflected = self.reflected(i, Toward::Scene, &split);
            light = std::array::from_fn(|k| light[k] * (1.0 - reflected[k]));
            ray = split.refracted?;
        }
        Some(light)
    }

    /// Of the light along the axis that no rim and no stop blocks: the share that no surface reflects.
    #[must_use]
    pub fn transmitted(&self) -> [f64; 3] {
        let (mut sum, mut count) = ([0.0; 3], 0u32);
        let rays = table::parallel(self, 0.0).into_iter();
        for Arrival { light, .. } in rays.filter_map(|ray| self.trace_direct(&ray)) {
            sum = std::array::from_fn(|k| sum[k] + light[k]);
            count += 1;
        }
        sum.map(|sum| sum / f64::from(count.max(1)))
    }

    /// What becomes of a ray from the scene. Light is followed through all reflections until less than `faintest` of it is left on
    /// a path.
    #[must_use]
    pub fn balance(&self, ray: &LensRay<f64>, faintest: f64) -> Balance {
        let mut balance = Balance::default();
        let mut pending = vec![self.enter(ray)];
        while let Some(at) = pending.pop() {
            let light = at.light.iter().sum::<f64>() / 3.0;
            let end = match (at.next, at.toward) {
                (None, Toward::Scene) => &mut balance.returned,
                (None, Toward::Film) if at.reflections == 0 => &mut balance.transmitted,
                (None, Toward::Film) => &mut balance.ghosts,
                (Some(_), _) if light < faintest => &mut balance.left,
                (Some(_), _) => match self.meet(&at) {
                    None => &mut balance.stopped,
                    Some(ways) => {
                        pending.extend(ways.into_iter().flatten());
                        continue;
                    }
                },
            };
            *end += light;
        }
        balance
    }

    fn enter(&self, ray: &LensRay<f64>) -> Traveller {
        Traveller {
            ray: *ray,
            next: Some(0).filter(|_| !self.boundaries.is_empty()),
            toward: Toward::Film,
            light: [1.0; 3],
            reflections: 0,
        }
    }

    /// The two ways on from the next surface, through it and back; `None` where the ray ends in front of it.
    fn meet(&self, at: &Traveller) -> Option<[Option<Traveller>; 2]> {
        let i = at.next?;
        let enters = i == 0 && at.toward == Toward::Film && at.reflections == 0;
        let split = { self.lens.tracer() }.split(i, at.toward, enters, at.ray)?;
        let reflected = self.reflected(i, at.toward, &split);
        let passes = self.shape_at(i, &split);
        let turned = match at.toward {
            Toward::Film => Toward::Scene,
            Toward::Scene => Toward::Film,
        };
        let light = |share: [f64; 3]| std::array::from_fn(|k| at.light[k] * share[k] * passes);
        let on = split.refracted.map(|ray| Traveller {
            ray,
            next: self.beyond(i, at.toward),
            light: light(reflected.map(|r| 1.0 - r)),
            ..*at
        });
        let back = (reflected != [0.0; 3]).then(|| Traveller {
            ray: split.reflected,
            next: self.beyond(i, turned),
            toward: turned,
            light: light(reflected),
            reflections: at.reflections + 1,
        });
        Some([on, back])
    }

    /// The share that surface `i` reflects.
    fn reflected(&self, i: usize, toward: Toward, split: &Split<f64>) -> [f64; 3] {
        if split.refracted.is_none() {
            return [1.0; 3];
        }
        let boundary = match toward {
            Toward::Film => self.boundaries[i],
            Toward::Scene => self.boundaries[i].reversed(),
        };
        let [first, rest @ ..] = self.wavelengths;
        // Fresnel's equations know no wavelength.
        match boundary.coating.is_none() || rest == [first; 2] {
            true => [boundary.reflectance(split.cosine, first); 3],
            false => { self.wavelengths }.map(|nm| boundary.reflectance(split.cosine, nm)),
        }
    }

    /// The share that an image of the stop lets pass where a ray meets surface `i`.
    fn shape_at(&self, i: usize, split: &Split<f64>) -> f64 {
        let surface = &self.lens.surfaces()[i];
        match self.lens.stop_shape().filter(|_| surface.is_stop) {
            // Rays end at blades by themselves.
            None | Some(StopShape::Polygon(_)) => 1.0,
            Some(shape) => {
                let [x, y, _] = split.reflected.o;
                shape.transmission([x, y].map(|p| p / (0.5 * surface.aperture)))
            }
        }
    }

    /// The surface after number `i`.
    fn beyond(&self, i: usize, toward: Toward) -> Option<usize> {
        match toward {
            Toward::Film => Some(i + 1).filter(|next| *next < self.boundaries.len()),
            Toward::Scene => i.checked_sub(1),
        }
    }

    /// Where a ray that has left the last surface meets the film.
    fn on_film(&self, at: &Traveller) -> Option<Arrival> {
        let mut ray = at.ray;
        ray.o[2] += self.lens.length();
        let LensRay { o, d } = ray;
        let t = (self.lens.film_z() - o[2]) / d[2];
        let film = [o[0] + t * d[0], o[1] + t * d[1]];
        let arrives = at.toward == Toward::Film && d[2] > 0.0 && film.iter().all(|x| x.is_finite());
        arrives.then_some(Arrival {
            film,
            ray,
            light: at.light,
        })
    }
}

#[cfg(test)]
mod tests;
