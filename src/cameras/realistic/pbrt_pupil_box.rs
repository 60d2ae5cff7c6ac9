//! The area that `simpleweighting` divides by: pbrt-v3's box around the exit pupil of the film's
//! middle (docs/scene-language.md §5.6). pbrt finds it by trial, and adds a margin for what it may have
//! missed; images inherit both, so both are reproduced.

use crate::optics::Lens;
use crate::optics::pupil::boundary;

/// Candidates that pbrt tries.
const CANDIDATES: u32 = 1 << 20;

/// The film radius is cut into this many rings, each with a box.
pub const RINGS: u32 = 64;

/// Half the side of the square that candidates lie in, in radii of the rear element.
const SQUARE: f64 = 1.5;

/// Area in mm² of pbrt-v3's innermost exit-pupil box, on the rear vertex plane, for a film of
/// diagonal `diagonal` mm.
pub fn innermost_box_area(lens: &Lens, diagonal: f64) -> f64 {
    let half = SQUARE * 0.5 * lens.rear().aperture;
    pupil_box(lens, diagonal, 0).map_or(4.0 * half * half, |b| b.area())
}

/// pbrt-v3's exit-pupil box of ring `ring` (of [`RINGS`]), on the rear vertex plane, its x along the film
/// point's azimuth; `None` where pbrt finds nothing, and then samples a square of three times the rear
/// element's radius.
pub fn pupil_box(lens: &Lens, diagonal: f64, ring: u32) -> Option<PupilBox> {
    let half = SQUARE * 0.5 * lens.rear().aperture;
    let width = 0.5 * diagonal / f64::from(RINGS);
    let inner = f64::from(ring) * width;
    let limits = PupilBox::around_pupil(lens, inner, width)?;
    let mut found: Option<PupilBox> = None;
    for i in 0..CANDIDATES {
        let x = half * (2.0 * radical_inverse(i, 2) - 1.0);
        // Far from the true pupil: would be blocked.
        if x < limits.low[0] || x > limits.high[0] {
            continue;
        }
        let p = [x, half * (2.0 * radical_inverse(i, 3) - 1.0)];
        if !limits.holds(p) || found.is_some_and(|b| b.holds(p)) {
            continue;
        }
        let film = inner + width * (f64::from(i) + 0.5) / f64::from(CANDIDATES);
        if lens
            .trace_from_film([film, 0.0], [p[0], p[1], lens.length()])
            .is_ok()
        {
            found = Some(found.map_or(PupilBox { low: p, high: p }, |b| b.with(p)));
        }
    }
    // Twice the square's diagonal over the candidates per side, on every side.
    let margin = 2.0 * (2.0 * half) * std::f64::consts::SQRT_2 / f64::from(CANDIDATES).sqrt();
    found.map(|b| b.grown(margin))
}

/// An axis-parallel rectangle, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilBox {
    /// Its lowest corner.
    pub low: [f64; 2],
    /// Its highest corner.
    pub high: [f64; 2],
}

impl PupilBox {
    /// In mm².
    pub fn area(&self) -> f64 {
        (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])
    }

    /// Somewhat more than the pupil of the film points of a ring; `None` where nothing passes.
    fn around_pupil(lens: &Lens, inner: f64, width: f64) -> Option<PupilBox> {
        let points = [0.0, 0.5, 1.0]
            .map(|s| boundary(lens, inner + s * width, lens.length()))
            .concat();
        let one = |p: [f64; 2]| PupilBox { low: p, high: p };
        let first = one(*points.first()?);
        let b = points
            .iter()
            .fold(first, |b, p| b.with(*p).with([p[0], -p[1]]));
        // Wide of the boundary, sought in 3.75 degree steps, by any measure.
        Some(b.grown(0.05 * (b.high[0] - b.low[0]).max(b.high[1] - b.low[1])))
    }

    /// With this margin on every side.
    fn grown(&self, margin: f64) -> PupilBox {
        PupilBox {
            low: self.low.map(|x| x - margin),
            high: self.high.map(|x| x + margin),
        }
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (0..2).all(|i| p[i] >= self.low[i] && p[i] <= self.high[i])
    }

    fn with(&self, p: [f64; 2]) -> PupilBox {
        PupilBox {
            low: std::array::from_fn(|i| self.low[i].min(p[i])),
            high: std::array::from_fn(|i| self.high[i].max(p[i])),
        }
    }
}

/// The digits of `i` in base `base`, mirrored at the point (van der Corput).
fn radical_inverse(mut i: u32, base: u32) -> f64 {
    if base == 2 {
        return f64::from(i.reverse_bits()) / 4_294_967_296.0;
    }
    let (mut digits, mut scale) = (0.0, 1.0);
    while i > 0 {
        scale /= f64::from(base);
        digits += scale * f64::from(i % base);
        i /= base;
    }
    digits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn radical_inverses_mirror_the_digits() {
        assert_eq!(radical_inverse(6, 2), 0.375);
        assert!((radical_inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn the_box_of_a_bare_stop_is_its_square_and_the_margin() {
        // Only a stop, 10 mm across: from the film's middle all of it is seen.
        let lens = Lens::new(&Prescription::parse("0 0 0 10\n").unwrap(), 50.0).unwrap();
        let margin = 0.0082864 * 5.0;
        // The candidates come within a thousandth of the rim.
        let expected = (10.0f64 + 2.0 * margin).powi(2);
        let area = innermost_box_area(&lens, 40.0);
        assert!((area / expected - 1.0).abs() < 1e-3, "{area} {expected}");
    }

    #[test]
    fn agrees_with_pbrts_box_of_a_wide_angle_lens() {
        // The reference images realistic_simpleweight_true and _false differ by nothing but the
        // weight: their mean luminances, per unit of light, .29780/1.2 and .37298/(45·½), have
        // the ratio z²/A with z = 14.96932 mm, so A = 14.968 mm².
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/wide.22mm.dat");
        let mut p = Prescription::read(file.as_ref()).unwrap();
        p.set_stops(6.0);
        let lens = Lens::new(&p, Lens::focused(&p, 800.0).unwrap()).unwrap();
        assert!((lens.film_distance() / 14.96932 - 1.0).abs() < 1e-5);
        // The noise of the two means is some 3e-4 each.
        let area = innermost_box_area(&lens, 30.0);
        assert!((area / 14.968 - 1.0).abs() < 1e-3, "{area}");
    }
}
