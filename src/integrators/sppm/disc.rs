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

    /// Appends it to `out`, for a checkpoint.
    pub fn store(&self, out: &mut Vec<u8>) {
        for number in [self.radius, self.photons] {
            out.extend(number.to_le_bytes());
        }
    }

    /// What this one became, by the start of `bytes`, which is taken away; `None` if it cannot have become that.
    pub fn restored(&self, bytes: &mut &[u8]) -> Option<Disc> {
        let mut number = || {
            let (first, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            Some(f64::from_le_bytes(*first))
        };
        let (radius, photons) = (number()?, number()?);
        let is_one = radius > 0.0 && radius <= self.radius && photons >= 0.0 && photons.is_finite();
        is_one.then_some(Disc { radius, photons })
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

    /// From a checkpoint, which anybody may have written.
    #[test]
    fn a_disc_comes_back_as_it_was_or_not_at_all() {
        let mut disc = Disc::new(0.5);
        disc.shrink(30);
        let stored = |disc: &Disc| {
            let mut bytes = Vec::new();
            disc.store(&mut bytes);
            bytes
        };
        let mut bytes = &[stored(&disc), vec![77]].concat()[..];
        assert_eq!(Disc::new(0.5).restored(&mut bytes), Some(disc));
        assert_eq!(bytes, [77]);
        assert_eq!(Disc::new(0.5).restored(&mut &stored(&disc)[..15]), None);
        let none = f64::NAN;
        for (radius, photons) in [
            (0.6, 1.0),
            (0.0, 1.0),
            (-0.1, 1.0),
            (none, 1.0),
            (0.1, -1.0),
            (0.1, none),
            (0.1, f64::INFINITY),
        ] {
            let bytes = stored(&Disc { radius, photons });
            assert_eq!(Disc::new(0.5).restored(&mut &bytes[..]), None);
        }
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
