//! Measured coefficients of materials by name: `preset` of a medium, `name` of a subsurface scattering material. Names
//! are those of pbrt-v3, including case (docs/scene-language.md §6.4).
//!
//! Apple to Wholemilk, those without a space in their names: Jensen, Marschner, Levoy and Hanrahan, "A Practical Model
//! for Subsurface Light Transport" (SIGGRAPH 2001), figure 5. The rest: Narasimhan et al., "Acquiring Scattering
//! Properties of Participating Media by Dilution" (SIGGRAPH 2006), table 1, as reduced scattering.

use crate::math::Rgb;

/// Absorption and scattering coefficients, per millimeter in the table and per scene unit elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Absorption coefficient σₐ.
    pub sigma_a: Rgb,
    /// Scattering coefficient σₛ; in the table it is the reduced one, σₛ(1 − g).
    pub sigma_s: Rgb,
}

impl Coefficients {
    /// Extinction coefficient σₜ.
    pub fn sigma_t(&self) -> Rgb {
        self.sigma_a + self.sigma_s
    }
}

/// The row with that name.
pub fn find(name: &str) -> Option<Coefficients> {
    let i = TABLE.binary_search_by_key(&name, |row| row.0).ok()?;
    let (_, sigma_s, sigma_a) = TABLE.get(i)?;
    Some(Coefficients {
        sigma_a: Rgb::from_array(*sigma_a),
        sigma_s: Rgb::from_array(*sigma_s),
    })
}

/// All names, in order.
pub fn names() -> impl Iterator<Item = &'static str> {
    TABLE.iter().map(|row| row.0)
}

/// Name, reduced scattering, absorption; sorted by name.
const TABLE: [(&str, [f32; 3], [f32; 3]); 47] = include!("presets.in");

/// Whole milk, what pbrt-v3 takes where nothing is given.
pub const WHOLE_MILK: Coefficients = Coefficients {
    sigma_a: Rgb::new(0.0011, 0.0024, 0.014),
    sigma_s: Rgb::new(2.55, 3.21, 3.77),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found() {
        assert!(TABLE.is_sorted_by_key(|row| row.0));
        for name in names() {
            assert!(find(name).is_some(), "{name}");
        }
        assert_eq!(find("wholemilk"), None);
        assert_eq!(find(""), None);
    }

    /// The default medium is whole milk, as in pbrt-v3.
    #[test]
    fn whole_milk_is_the_default_medium() {
        let milk = find("Wholemilk").unwrap();
        assert_eq!(milk.sigma_s, Rgb::new(2.55, 3.21, 3.77));
        assert_eq!(milk.sigma_a, Rgb::new(0.0011, 0.0024, 0.014));
    }
}
