//! The way of a ray through the lens, for drawing it.

use crate::optics::lens::Lens;
use crate::optics::trace::LensRay;

/// Where a `ray` from the scene crosses every surface and the film, as far as it gets. The direction's z must be positive.
pub fn points(lens: &Lens, ray: &LensRay<f64>) -> Vec<[f64; 3]> {
    let mut points = Vec::with_capacity(lens.surfaces().len() + 1);
    let out = lens.tracer().visit_to_film(ray, |_, p| points.push(p));
    if let Ok(out) = out {
        let t = (lens.film_z() - out.o[2]) / out.d[2];
        points.push(std::array::from_fn(|i| out.o[i] + t * out.d[i]));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn a_path_bends_at_surfaces_and_ends_where_the_ray_does() {
        let p = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
        let lens = Lens::new(&p, 49.0).unwrap();
        let at = |y: f64| LensRay::new([0.0, y, 0.0], [0.0, 0.0, 1.0]);
        let points = points(&lens, &at(3.0));
        assert_eq!(points.len(), 3);
        // A converging lens brings it toward the axis at every step.
        assert!(points[0][1] == 3.0 && points.windows(2).all(|p| p[1][1] < p[0][1]));
        assert_eq!(points[2][2], 54.0);
        // Outside the first aperture it is not followed further.
        assert!(super::points(&lens, &at(10.5)).is_empty());
    }
}
