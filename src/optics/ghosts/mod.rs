//! Ghosts: light that is reflected twice inside the lens and gets to the film where it does not belong.
//!
//! Of n surfaces that reflect, n (n − 1) / 2 pairs make a ghost each: light goes through the lens to the farther surface of the pair,
//! back to the nearer one, and from there to the film (J. Maxwell, "Stray light from lens reflections", 1970s practice, as in
//! M. Hullin, E. Eisemann, H.-P. Seidel and S. Lee, "Physically-Based Real-Time Lens Flare Rendering", SIGGRAPH 2011, §3). At each
//! surface the ray carries on the share that is transmitted or reflected there, of unpolarized light. Glass absorbs nothing.

mod table;

pub use table::{GhostRow, GhostTable, table};

use super::coating::{Boundary, Coating};
use super::element::Toward;
use super::lens::Lens;
use super::surface::Surface;
use super::trace::LensRay;

/// A lens whose surfaces reflect.
#[derive(Clone, Debug)]
pub struct Ghosts<'a> {
    lens: &'a Lens,
    /// Of each surface, for light toward the film.
    boundaries: Vec<Boundary>,
    /// Of the light, in vacuum, nm.
    wavelength: f64,
}

/// The d line of helium, at which lens files have their indices, nm.
pub const D_LINE: f64 = 587.5618;

/// What becomes of the light of a ray, all reflections counted; the sum is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Gets to the film's side without a reflection: the picture.
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

/// A ray on its way: z is relative to the vertex of `next`, the surface that it runs to.
struct Traveller {
    ray: LensRay<f64>,
    next: Option<usize>,
    toward: Toward,
    light: f64,
    reflections: u32,
}

impl<'a> Ghosts<'a> {
    /// Of light at the d line. `coating`, if there is one, is on all surfaces between air and glass of which the lens file says none;
    /// cemented ones have none of it.
    #[must_use]
    pub fn new(lens: &'a Lens, coating: Option<Coating>) -> Ghosts<'a> {
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
            lens,
            boundaries: lens.surfaces().iter().map(boundary).collect(),
            wavelength: D_LINE,
        }
    }

    /// The pairs of surfaces that make ghosts, from 0: the nearer to the scene, where light is reflected second, then the farther.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let reflects = |i: &usize| self.boundaries[*i].from != self.boundaries[*i].into;
        let farther = (0..self.boundaries.len()).filter(reflects);
        farther.flat_map(move |j| (0..j).filter(reflects).map(move |i| (i, j)))
    }

    /// Where a ray from the scene meets the plane of the film after the reflections of a pair, mm from the axis, and how much of its
    /// light gets there. z is relative to the first vertex. `None` where it does not get there.
    #[must_use]
    pub fn trace(&self, ray: &LensRay<f64>, (i, j): (usize, usize)) -> Option<([f64; 2], f64)> {
        let mut at = self.enter(ray);
        while let Some(next) = at.next {
            let turns = (at.reflections == 0 && next == j) || (at.reflections == 1 && next == i);
            let [on, back] = self.meet(&at)?;
            at = if turns { back? } else { on? };
        }
        Some((self.on_film(&at)?, at.light))
    }

    /// The same without a reflection: the picture.
    #[must_use]
    pub fn trace_direct(&self, ray: &LensRay<f64>) -> Option<([f64; 2], f64)> {
        let mut at = self.enter(ray);
        while at.next.is_some() {
            let [on, _] = self.meet(&at)?;
            at = on?;
        }
        Some((self.on_film(&at)?, at.light))
    }

    /// What becomes of a ray from the scene. Light is followed through all reflections until less than `faintest` of it is left on
    /// a path.
    #[must_use]
    pub fn balance(&self, ray: &LensRay<f64>, faintest: f64) -> Balance {
        let mut balance = Balance::default();
        let mut pending = vec![self.enter(ray)];
        while let Some(at) = pending.pop() {
            let end = match (at.next, at.toward) {
                (None, Toward::Scene) => &mut balance.returned,
                (None, Toward::Film) if at.reflections == 0 => &mut balance.transmitted,
                (None, Toward::Film) => &mut balance.ghosts,
                (Some(_), _) if at.light < faintest => &mut balance.left,
                (Some(_), _) => match self.meet(&at) {
                    None => &mut balance.stopped,
                    Some(ways) => {
                        pending.extend(ways.into_iter().flatten());
                        continue;
                    }
                },
            };
            *end += at.light;
        }
        balance
    }

    fn enter(&self, ray: &LensRay<f64>) -> Traveller {
        Traveller {
            ray: *ray,
            next: Some(0).filter(|_| !self.boundaries.is_empty()),
            toward: Toward::Film,
            light: 1.0,
            reflections: 0,
        }
    }

    /// The two ways on from the next surface, through it and back; `None` where the ray ends in front of it.
    fn meet(&self, at: &Traveller) -> Option<[Option<Traveller>; 2]> {
        let i = at.next?;
        let split = self.lens.tracer().element(i)?.split(&at.ray, at.toward)?;
        let (boundary, turned) = match at.toward {
            Toward::Film => (self.boundaries[i], Toward::Scene),
            Toward::Scene => (self.boundaries[i].reversed(), Toward::Film),
        };
        let reflected = match split.refracted {
            Some(_) => boundary.reflectance(split.cosine, self.wavelength),
            None => 1.0,
        };
        let on = split.refracted.map(|ray| self.leave(i, ray, at.toward, at));
        let back = self.leave(i, split.reflected, turned, at);
        Some([
            on.map(|on| Traveller {
                light: at.light * (1.0 - reflected),
                ..on
            }),
            (reflected > 0.0).then_some(Traveller {
                light: at.light * reflected,
                reflections: at.reflections + 1,
                ..back
            }),
        ])
    }

    /// From surface `i` to the next one.
    fn leave(&self, i: usize, mut ray: LensRay<f64>, toward: Toward, at: &Traveller) -> Traveller {
        let surfaces = self.lens.surfaces();
        let (next, gap) = match toward {
            Toward::Film => (Some(i + 1).filter(|next| *next < surfaces.len()), i),
            Toward::Scene => (i.checked_sub(1), i.saturating_sub(1)),
        };
        if next.is_some() {
            ray.o[2] -= surfaces[gap].thickness * toward.sign::<f64>();
        }
        Traveller {
            ray,
            next,
            toward,
            ..*at
        }
    }

    /// Where a ray that has left the last surface, z relative to its vertex, meets the film.
    fn on_film(&self, at: &Traveller) -> Option<[f64; 2]> {
        let LensRay { o, d } = at.ray;
        let t = (self.lens.film_distance() - o[2]) / d[2];
        let p = [o[0] + t * d[0], o[1] + t * d[1]];
        (at.toward == Toward::Film && d[2] > 0.0 && p.iter().all(|x| x.is_finite())).then_some(p)
    }
}

#[cfg(test)]
mod tests;
