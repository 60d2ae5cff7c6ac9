//! Where a pixel looks for photons, and how that shrinks.

/// The part of an iteration's new photons that is kept (Hachisuka and Jensen 2009, α): below 1 the radius goes to 0,
/// and above 0 the noise does.
const KEPT: f64 = 2.0 / 3.0;

/// A disc around what a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its radius.
    radius: f64,
    /// Photons kept so far.
    photons: f64,
}

impl Disc {
    /// Before the first iteration.
    pub(super) fn new(radius: f32) -> Disc {
        Disc {
            radius: radius.into(),
            photons: 0.0,
        }
    }

    /// The radius of the next iteration.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Takes account of the photons that an iteration has `found`: with N kept before and M found, N + αM are kept, and the area
    /// shrinks as if these were as dense as the N + M (Hachisuka and Jensen 2009, equation 5).
    pub(super) fn shrink(&mut self, found: u64) {
        if found == 0 {
            return;
        }
        let found = found as f64;
        let kept = self.photons + KEPT * found;
        self.radius *= (kept / (self.photons + found)).sqrt();
        self.photons = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's formulas, step by step.
    #[test]
    fn the_area_shrinks_by_what_is_not_kept() {
        let mut disc = Disc::new(0.5);
        disc.shrink(0);
        assert_eq!(disc, Disc::new(0.5));
        disc.shrink(30);
        // 20 of 30; then 24 of 26.
        let area = 0.25 * 20.0 / 30.0;
        assert!((disc.radius().powi(2) - area).abs() < 1e-15);
        disc.shrink(6);
        assert!((disc.radius().powi(2) - area * 24.0 / 26.0).abs() < 1e-15);
        assert!((disc.photons - 24.0).abs() < 1e-12);
    }

    /// With M photons an iteration in a disc of unit area the n-th radius squared goes like n^(α − 1): each iteration finds photons in
    /// proportion to the area.
    #[test]
    fn radii_go_to_zero_as_the_theory_says() {
        let (mut disc, mut at) = (Disc::new(1.0), Vec::new());
        for n in 1..=100_000u32 {
            if n == 1_000 || n == 100_000 {
                at.push(disc.radius().powi(2));
            }
            let found = 1e4 * disc.radius().powi(2);
            disc.shrink(found.round() as u64);
        }
        let exponent = (at[1] / at[0]).log10() / 2.0;
        // The law holds in the limit; counts are whole numbers.
        assert!((exponent - (KEPT - 1.0)).abs() < 0.01, "{exponent}");
    }
}
