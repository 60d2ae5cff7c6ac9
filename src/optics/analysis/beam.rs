//! The beam of one object point: the rays that get from it through the lens.

use super::chief::ChiefRay;
use super::illumination::spread;
use super::object::ObjectPlane;
use crate::optics::bisection::bisect;
use crate::optics::lens::Lens;
use crate::optics::pupil::ExitPupil;
use crate::optics::real::Real;
use crate::optics::trace::LensRay;

/// The rays from the object point whose chief ray lands at a film point, by where they cross a plane: the one
/// perpendicular to the chief ray where that enters the lens. Beams of a distant object are parallel.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Its chief ray, which says where on the film it lands.
    pub chief: ChiefRay,
    /// Toward the film.
    direction: [f64; 3],
    /// Unit vectors of that plane, sagittal (across the meridional plane) and tangential (in it).
    axes: [[f64; 3]; 2],
    /// The object point; `None` at infinity.
    object: Option<[f64; 3]>,
    /// The rectangle that holds the beam: lowest and highest coordinate sagittally and tangentially, mm from the chief ray.
    pub extent: [[f64; 2]; 2],
}

impl Beam {
    /// The beam from the point of `object` that `chief` comes from; `None` where no light arrives. `pupil` says where to
    /// look for it.
    pub fn new(
        lens: &Lens,
        pupil: &ExitPupil,
        chief: &ChiefRay,
        object: ObjectPlane,
    ) -> Option<Beam> {
        let d = chief.ray.d.map(|x| -x);
        let mut beam = Beam {
            chief: *chief,
            direction: d,
            axes: [[1.0, 0.0, 0.0], [0.0, d[2], -d[1]]],
            object: object_point(object, chief),
            extent: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        };
        beam.find_extent(lens, pupil)?;
        beam.widen(lens);
        Some(beam)
    }

    /// Half its height in the meridional plane.
    pub fn half_height(&self) -> f64 {
        0.5 * (self.extent[1][1] - self.extent[1][0])
    }

    /// The ray toward the film that crosses the plane at (sagittal, tangential) mm from the chief ray.
    pub fn ray<T: Real<Base = f64>>(&self, p: [T; 2]) -> LensRay<T> {
        let o: [T; 3] = std::array::from_fn(|i| {
            p[0].times(self.axes[0][i]).plus(self.chief.ray.o[i]) + p[1].times(self.axes[1][i])
        });
        match self.object {
            Some(object) => LensRay::through(object.map(T::constant), o),
            None => LensRay {
                o,
                d: self.direction.map(T::constant),
            },
        }
    }

    /// How far the beam reaches along an axis through the chief ray (0 sagittal, 1 tangential), to either side: where rays end, to
    /// rounding, looking inward from the rectangle. 0 where the chief ray itself does not pass.
    pub fn rim(&self, lens: &Lens, axis: usize) -> [f64; 2] {
        let on_axis = |x: f64| std::array::from_fn(|i| if i == axis { x } else { 0.0 });
        let passes = |x: f64| self.on_film(lens, on_axis(x)).is_some();
        match passes(0.0) {
            false => [0.0; 2],
            true => self.extent[axis].map(|edge| bisect([0.0, edge], 50, passes)[0]),
        }
    }

    /// Light, by the plane in front of the lens: from the object point, or from a wave front of a distant one, to where the ray
    /// through `p` starts.
    pub(super) fn lead(&self, ray: &LensRay<f64>) -> f64 {
        match self.object {
            Some(object) => length(std::array::from_fn(|i| ray.o[i] - object[i])),
            // The plane is a wave front.
            None => 0.0,
        }
    }

    /// Where the ray through `p` meets the film, (x, y) mm; `None` where it is blocked.
    pub fn on_film(&self, lens: &Lens, p: [f64; 2]) -> Option<[f64; 2]> {
        self.at_film(lens, p).map(|ray| [ray.o[0], ray.o[1]])
    }

    /// The ray through `p` where it meets the film; `None` where it is blocked.
    pub fn at_film(&self, lens: &Lens, p: [f64; 2]) -> Option<LensRay<f64>> {
        let out = lens.tracer().to_film(&self.ray(p)).ok()?;
        let t = (lens.film_z() - out.o[2]) / out.d[2];
        let at = [out.o[0] + t * out.d[0], out.o[1] + t * out.d[1]];
        let o = [at[0], at[1], lens.film_z()];
        at.iter()
            .all(|x| x.is_finite())
            .then_some(LensRay { o, d: out.d })
    }

    /// The rays of `across`² points, spread evenly over its extent, where they meet the film. Not a grid: the rows of that would be
    /// seen as a grating in the image of a point out of focus.
    pub fn rays_at_film(&self, lens: &Lens, across: usize) -> Vec<LensRay<f64>> {
        let point = |u: crate::math::Vec2| {
            let part = [f64::from(u.x), f64::from(u.y)];
            let [x, y] = self.extent;
            [
                x[0] + part[0] * (x[1] - x[0]),
                y[0] + part[1] * (y[1] - y[0]),
            ]
        };
        let points = spread((across * across) as u32).map(point);
        points.filter_map(|p| self.at_film(lens, p)).collect()
    }

    fn grid_point(&self, across: usize, i: usize) -> [f64; 2] {
        let at = |axis: usize, i: usize| {
            let [low, high] = self.extent[axis];
            low + (high - low) * (i as f64 + 0.5) / across as f64
        };
        [at(0, i % across), at(1, i / across)]
    }

    /// The points of the beam on a square grid of `across` by `across` over its extent, each in the middle of its cell,
    /// with where their rays meet the film.
    pub fn grid(&self, lens: &Lens, across: usize) -> Vec<([f64; 2], [f64; 2])> {
        (0..across * across)
            .map(|i| self.grid_point(across, i))
            .filter_map(|p| Some((p, self.on_film(lens, p)?)))
            .collect()
    }

    /// From the rays of the film point itself, which nearly meet in the object point.
    fn find_extent(&mut self, lens: &Lens, pupil: &ExitPupil) -> Option<()> {
        let film = [0.0, self.chief.height];
        let across = 48;
        for i in 0..across * across {
            let u = crate::math::Vec2::new(
                ((i % across) as f32 + 0.5) / across as f32,
                ((i / across) as f32 + 0.5) / across as f32,
            );
            let Some(sample) = pupil.sample(film, u) else {
                break;
            };
            let Ok(out) = lens.trace_from_film(film, sample.point) else {
                continue;
            };
            let p = self.crossing(&out);
            for (range, x) in self.extent.iter_mut().zip(p) {
                *range = [range[0].min(x), range[1].max(x)];
            }
        }
        self.extent
            .iter()
            .all(|[low, high]| low <= high && low.is_finite() && high.is_finite())
            .then_some(())
    }

    /// Where a ray crosses the plane, along its axes.
    fn crossing(&self, ray: &LensRay<f64>) -> [f64; 2] {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let to: [f64; 3] = std::array::from_fn(|i| self.chief.ray.o[i] - ray.o[i]);
        let t = dot(to, self.direction) / dot(ray.d, self.direction);
        let p: [f64; 3] = std::array::from_fn(|i| t * ray.d[i] - to[i]);
        self.axes.map(|axis| dot(p, axis))
    }

    /// Until no ray along the rectangle's edge gets through: aberration makes the beam differ from the one
    /// seen from the film.
    fn widen(&mut self, lens: &Lens) {
        // Half a cell of the search above, at least.
        self.grow([[0.02; 2]; 2]);
        for _ in 0..8 {
            let probes = 64;
            let mut growth = [[0.0; 2]; 2];
            for (axis, sides) in growth.iter_mut().enumerate() {
                for (side, amount) in sides.iter_mut().enumerate() {
                    let edge = |i: usize| {
                        let [low, high] = self.extent[1 - axis];
                        let mut p = [0.0; 2];
                        p[axis] = self.extent[axis][side];
                        p[1 - axis] = low + (high - low) * i as f64 / probes as f64;
                        p
                    };
                    if (0..=probes).any(|i| self.on_film(lens, edge(i)).is_some()) {
                        *amount = 0.05;
                    }
                }
            }
            if growth == [[0.0; 2]; 2] {
                break;
            }
            self.grow(growth);
        }
    }

    /// Moves each edge outward by a part of the rectangle's size.
    fn grow(&mut self, parts: [[f64; 2]; 2]) {
        for (range, part) in self.extent.iter_mut().zip(parts) {
            let size = (range[1] - range[0]).max(f64::MIN_POSITIVE);
            *range = [range[0] - part[0] * size, range[1] + part[1] * size];
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Where the chief ray meets the object plane; `None` for one at infinity, and where it lies behind the lens.
fn object_point(object: ObjectPlane, chief: &ChiefRay) -> Option<[f64; 3]> {
    let t = (object.z? - chief.ray.o[2]) / chief.ray.d[2];
    let p: [f64; 3] = std::array::from_fn(|i| chief.ray.o[i] + t * chief.ray.d[i]);
    (t > 0.0 && p.iter().all(|x| x.is_finite())).then_some(p)
}
