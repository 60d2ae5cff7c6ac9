//! The way of a ray through the lens, for drawing it.

use crate::optics::lens::Lens;
use crate::optics::surface::Surface;
use crate::optics::trace::{LensRay, LensTracer};

/// Follows rays from the scene to the film and keeps where they cross each surface.
#[derive(Clone, Debug)]
pub struct PathTracer {
    /// The lens up to each of its surfaces.
    parts: Vec<LensTracer<f64>>,
    film_z: f64,
}

impl PathTracer {
    /// For `lens`.
    pub fn new(lens: &Lens) -> PathTracer {
        let surfaces: &[Surface] = lens.surfaces();
        PathTracer {
            parts: (1..=surfaces.len())
                .map(|n| LensTracer::new(&surfaces[..n]))
                .collect(),
            film_z: lens.film_z(),
        }
    }

    /// Where `ray` crosses every surface and the film, as far as it gets. The direction's z must be positive.
    pub fn points(&self, ray: &LensRay<f64>) -> Vec<[f64; 3]> {
        let mut points = Vec::with_capacity(self.parts.len() + 1);
        let mut last = None;
        for part in &self.parts {
            let Ok(out) = part.to_film(ray) else {
                return points;
            };
            points.push(out.o);
            last = Some(out);
        }
        points.extend(last.map(|out: LensRay<f64>| {
            let t = (self.film_z - out.o[2]) / out.d[2];
            std::array::from_fn(|i| out.o[i] + t * out.d[i])
        }));
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn a_path_bends_at_surfaces_and_ends_where_the_ray_does() {
        let p = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
        let lens = Lens::new(&p, 49.0).unwrap();
        let path = PathTracer::new(&lens);
        let at = |y: f64| LensRay::new([0.0, y, 0.0], [0.0, 0.0, 1.0]);
        let points = path.points(&at(3.0));
        assert_eq!(points.len(), 3);
        // A converging lens brings it toward the axis at every step.
        assert!(points[0][1] == 3.0 && points.windows(2).all(|p| p[1][1] < p[0][1]));
        assert_eq!(points[2][2], 54.0);
        // Outside the first aperture it is not followed further.
        assert!(path.points(&at(10.5)).is_empty());
    }
}
