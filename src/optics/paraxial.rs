//! The lens near its axis: focal points, principal planes and pupils.
//!
//! A paraxial ray is its height y and its reduced angle n·u; a refraction and a transfer are
//! 2 × 2 matrices of determinant 1, and the whole lens is their product (Born and Wolf,
//! *Principles of Optics*, 7th edition, §4.4 and 4.8.3; Hecht, *Optics*, §6.2.1). All z are in lens
//! coordinates: millimeters from the first vertex, toward the film.

use super::surface::Surface;
use serde::Serialize;

/// Takes (y, n·u) from one plane to another.
///
/// The diagonal is kept less 1, its value for no lens at all: principal planes are made of these differences, which for
/// a weak lens have no digits left in the elements themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayMatrix {
    /// a − 1.
    pub a_less_1: f64,
    pub b: f64,
    pub c: f64,
    /// d − 1.
    pub d_less_1: f64,
}

impl RayMatrix {
    pub(super) const IDENTITY: RayMatrix = RayMatrix {
        a_less_1: 0.0,
        b: 0.0,
        c: 0.0,
        d_less_1: 0.0,
    };

    /// Height at the end of a ray that starts at height 1 along the axis.
    pub(super) fn a(&self) -> f64 {
        1.0 + self.a_less_1
    }

    /// Reduced angle at the end of a ray that starts on the axis at reduced angle 1.
    pub(super) fn d(&self) -> f64 {
        1.0 + self.d_less_1
    }

    /// Then refracts at a surface of curvature `c` from index `n` to `n2`: n·u falls by (n2−n)·c·y.
    pub(super) fn refract(self, c: f64, n: f64, n2: f64) -> RayMatrix {
        let power = (n2 - n) * c;
        RayMatrix {
            c: self.c - power * self.a(),
            d_less_1: self.d_less_1 - power * self.b,
            ..self
        }
    }

    /// Then goes `t` along the axis through index `n`: y grows by t·u.
    pub(super) fn transfer(self, t: f64, n: f64) -> RayMatrix {
        RayMatrix {
            a_less_1: self.a_less_1 + t / n * self.c,
            b: self.b + t / n * self.d(),
            ..self
        }
    }
}

/// The cardinal points of a lens with air in front. A lens without focal length (an afocal attachment) has
/// none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cardinals {
    /// Effective focal length, mm, the one in front: behind the lens it is `index_behind` times as long. Negative for a
    /// diverging lens.
    pub focal_length: f64,
    /// z of the front focal point: where a point source gives parallel light behind the lens.
    /// This is also the front focal distance, negative in front of the first vertex.
    pub front_focal_point: f64,
    /// z of the front principal plane.
    pub front_principal_plane: f64,
    /// z of the rear principal plane.
    pub rear_principal_plane: f64,
    /// From the last vertex to the rear focal point.
    pub back_focal_distance: f64,
    /// z of the rear focal point.
    pub rear_focal_point: f64,
    /// Refractive index of the space behind the lens: 1, but for a film in glass or water.
    pub index_behind: f64,
}

/// An image of the aperture stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pupil {
    /// Where it lies on the axis.
    pub z: f64,
    /// Its diameter, mm.
    pub diameter: f64,
}

/// Everything first-order about a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraxial {
    /// `None` for an afocal lens.
    pub cardinals: Option<Cardinals>,
    /// The surface that limits the axial beam of a distant object: of the stop rows, or of all
    /// rows where there is no stop, the one whose image seen from the scene is smallest.
    pub stop: usize,
    /// The stop seen from the scene; `None` where its image lies at infinity.
    pub entrance_pupil: Option<Pupil>,
    /// The stop seen from the film; `None` where its image lies at infinity (a telecentric lens).
    pub exit_pupil: Option<Pupil>,
    /// Focal length over entrance pupil diameter; `None` where either is missing.
    pub f_number: Option<f64>,
}

/// Lengths beyond this (a million kilometers, in mm) are infinite: a matrix element that should be
/// 0 is some 1e-16 by rounding.
pub(super) const FAR: f64 = 1e12;

impl Paraxial {
    /// Of `surfaces`, scene to film; at least one, air in front.
    pub fn new(surfaces: &[Surface]) -> Paraxial {
        let (heights, whole) = propagate(surfaces, 0);
        let inner = &surfaces[..surfaces.len() - 1];
        let length: f64 = inner.iter().map(|s| s.thickness).sum();
        let behind = surfaces[surfaces.len() - 1].index;
        let cardinals = cardinals(&whole, length, behind);
        let stop = limiting_surface(surfaces, &heights);
        let entrance_pupil = pupil(
            heights[stop].b / heights[stop].a(),
            surfaces[stop].aperture / heights[stop].a().abs(),
        );
        // From the stop to the space behind the lens; refraction at the stop itself moves no image of it.
        let (_, rear) = propagate(surfaces, stop);
        let exit_pupil = pupil(
            length - behind * rear.b / rear.d(),
            surfaces[stop].aperture / rear.d().abs(),
        );
        let f_number = match (cardinals, entrance_pupil) {
            // A closed stop has none.
            (Some(c), Some(p)) if p.diameter > 0.0 => Some(c.focal_length.abs() / p.diameter),
            _ => None,
        };
        Paraxial {
            cardinals,
            stop,
            entrance_pupil,
            exit_pupil,
            f_number,
        }
    }
}

/// A pupil, unless it is infinitely far.
fn pupil(z: f64, diameter: f64) -> Option<Pupil> {
    (z.abs() < FAR && diameter < FAR).then_some(Pupil { z, diameter })
}

/// The matrices from the vertex plane of surface `first` to each surface behind (before it refracts), and to the
/// space behind the last.
fn propagate(surfaces: &[Surface], first: usize) -> (Vec<RayMatrix>, RayMatrix) {
    let mut m = RayMatrix::IDENTITY;
    let mut n = first.checked_sub(1).map_or(1.0, |i| surfaces[i].index);
    let mut at = Vec::with_capacity(surfaces.len() - first);
    for (i, s) in surfaces.iter().enumerate().skip(first) {
        at.push(m);
        m = m.refract(s.curvature(), n, s.index);
        n = s.index;
        if i + 1 < surfaces.len() {
            m = m.transfer(s.thickness, n);
        }
    }
    (at, m)
}

fn cardinals(m: &RayMatrix, length: f64, behind: f64) -> Option<Cardinals> {
    let focal_length = -1.0 / m.c;
    let front_focal_point = m.d() / m.c;
    let back_focal_distance = -behind * m.a() / m.c;
    let far = [focal_length, front_focal_point, back_focal_distance];
    // Written so that a NaN counts as far.
    if !far.iter().all(|x| x.abs() < FAR) {
        return None;
    }
    Some(Cardinals {
        focal_length,
        front_focal_point,
        front_principal_plane: m.d_less_1 / m.c,
        rear_principal_plane: length - behind * m.a_less_1 / m.c,
        back_focal_distance,
        rear_focal_point: length + back_focal_distance,
        index_behind: behind,
    })
}

/// The surface that stops a growing axial parallel beam first.
fn limiting_surface(surfaces: &[Surface], heights: &[RayMatrix]) -> usize {
    let any_stop = surfaces.iter().any(|s| s.is_stop);
    let mut best = (f64::INFINITY, 0);
    for (i, s) in surfaces.iter().enumerate() {
        if any_stop && !s.is_stop {
            continue;
        }
        // A ray that enters at height 1 is here at height a.
        let admitted = s.clear_radius() / heights[i].a().abs();
        if admitted < best.0 || (any_stop && best.0 == f64::INFINITY) {
            best = (admitted, i);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    fn paraxial(text: &str) -> Paraxial {
        Paraxial::new(&Prescription::parse(text).unwrap().surfaces)
    }

    #[test]
    fn thick_lens_agrees_with_the_lensmakers_equation() {
        // 1/f = (n−1)(1/R1 − 1/R2 + (n−1)d/(n R1 R2)); the principal planes lie f(n−1)d/(n R2)
        // and f(n−1)d/(n R1) from their vertices (Hecht §6.1).
        let p = paraxial("50 6 1.5 20\n-40 0 1 20\n");
        let c = p.cardinals.unwrap();
        let f = 1.0 / (0.5 * (1.0 / 50.0 + 1.0 / 40.0 - 0.5 * 6.0 / (1.5 * 50.0 * 40.0)));
        assert!((c.focal_length / f - 1.0).abs() < 1e-14);
        assert!((c.front_principal_plane - f * 0.5 * 6.0 / (1.5 * 40.0)).abs() < 1e-13);
        assert!((c.rear_principal_plane - 6.0 + f * 0.5 * 6.0 / (1.5 * 50.0)).abs() < 1e-13);
    }

    #[test]
    fn afocal_and_telecentric_lenses_have_no_infinities() {
        let window = paraxial("inf 5 1.5 20\ninf 0 1 20\n");
        assert_eq!(window.cardinals, None);
        assert_eq!(window.f_number, None);
        assert!(window.entrance_pupil.is_some());
        // A thin plano-convex lens of f = 100 with the stop in its front focal plane.
        let telecentric = paraxial("0 100 0 5\n50 0 1.5 20\ninf 0 1 20\n");
        assert_eq!(telecentric.exit_pupil, None);
        assert_eq!(telecentric.entrance_pupil.unwrap().diameter, 5.0);
        assert!((telecentric.f_number.unwrap() - 20.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_stop_the_smallest_image_of_a_rim_limits() {
        // The second rim, seen through the first surface.
        let p = paraxial("50 5 1.5 20\n-50 0 1 12\n");
        assert_eq!(p.stop, 1);
        // Height at the second surface of a parallel ray at 1: 1 − 5/1.5·0.5/50.
        let a = 1.0 - 5.0 / 1.5 * 0.01;
        assert!((p.entrance_pupil.unwrap().diameter - 12.0 / a).abs() < 1e-13);
        assert!((p.exit_pupil.unwrap().z - 5.0).abs() < 1e-13);
    }
}
