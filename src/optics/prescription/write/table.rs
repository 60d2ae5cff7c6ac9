//! Lens tables ([`dat`](crate::optics::prescription::dat)).

use super::WriteError;
use crate::optics::dispersion::Dispersion;
use crate::optics::prescription::Prescription;
use crate::optics::surface::Surface;
use std::fmt::Write;

impl Prescription {
    /// The lens as a table of five columns, with its groups' positions if they move.
    ///
    /// # Errors
    /// Fails for a lens that the format cannot say; see [`WriteError`].
    pub fn to_table(&self) -> Result<String, WriteError> {
        let mut text = "# radius thickness index V diameter\n".to_string();
        if let Some(positions) = &self.positions {
            text += &positions.to_lines();
        }
        let mut medium = 1.0;
        for (i, s) in self.surfaces.iter().enumerate() {
            let named = self.positions.as_ref().and_then(|p| p.name_behind(i));
            let thickness = match i + 1 == self.surfaces.len() {
                true => self.film_distance,
                false => s.thickness,
            };
            let thickness = named.map_or_else(|| thickness.to_string(), str::to_string);
            text += &row(i + 1, s, &thickness, medium)?;
            medium = s.index;
        }
        Ok(text)
    }
}

/// The row of surface `number`, behind a space of index `medium`.
fn row(number: usize, s: &Surface, thickness: &str, medium: f64) -> Result<String, WriteError> {
    let plain = s.radius.is_infinite() && s.asphere.is_none() && s.index == medium;
    if s.is_stop && !plain {
        return Err(WriteError::Stop(number));
    }
    if !(s.aperture > 0.0 && s.aperture.is_finite()) {
        return Err(WriteError::NoDiameter(number));
    }
    // A plane has no sides.
    let radius = match s.radius {
        _ if s.is_stop => 0.0,
        r if r.is_infinite() => f64::INFINITY,
        r => r,
    };
    let index = if s.is_stop { 0.0 } else { s.index };
    let abbe = s.abbe.unwrap_or(0.0);
    let mut row = format!("{radius}\t{thickness}\t{index}\t{abbe}\t{}", s.aperture);
    if let Some(asphere) = &s.asphere {
        let _ = write!(row, " k={}", asphere.conic);
        for (i, term) in asphere.terms.iter().enumerate().filter(|(_, t)| **t != 0.0) {
            let _ = write!(row, " A{}={term}", 2 * (i + 1));
        }
    }
    if let Some(formula) = &s.dispersion {
        let (name, numbers) = match formula {
            Dispersion::Cauchy(numbers) => ("cauchy", numbers.to_vec()),
            Dispersion::Sellmeier(numbers) => ("sellmeier", numbers.to_vec()),
            Dispersion::Catalogue(formula) => {
                let number = f64::from(formula.number());
                ("agf", [&[number], &formula.coefficients()[..]].concat())
            }
        };
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let _ = write!(row, " {name}={}", numbers.join(","));
    }
    if let Some(glass) = &s.glass {
        let _ = write!(row, " glass={glass}");
    }
    if let Some(coating) = &s.coating {
        let _ = write!(row, " coating={coating}");
    }
    row.push('\n');
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything but what was said about the file; shortest decimal numbers are read as the numbers they were.
    fn comes_back(lens: &Prescription) {
        let text = lens.to_table().unwrap();
        let back = Prescription::parse(&text).unwrap();
        assert_eq!(back.surfaces, lens.surfaces, "{text}");
        assert_eq!(back.film_distance, lens.film_distance);
        assert_eq!(back.positions.is_some(), lens.positions.is_some());
    }

    #[test]
    fn golden_lenses_come_back_to_the_bit() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "dat") {
                comes_back(&Prescription::read(&path).unwrap());
                count += 1;
            }
        }
        assert!(count >= 13);
    }

    #[test]
    fn aspheres_formulas_media_and_extreme_numbers_come_back() {
        for text in [
            "50 5 1.5168 64.2 20 k=-0.8 A2=1e-9 A16=-3e-300 cauchy=1.5046,0.0042,0\n0 1 0 0 10\n-50 1e-300 1.33 20\n",
            "1e30 1 1.5 20\n-0.001 7 1.8 25 0.001 sellmeier=1.0396,0.2318,1.0105,0.0060,0.0200,103.56\n",
            "inf 3 1.5 60 20 k=0\ninf -2 1 0 20\n",
            "50 5 1.5 60 20 coating=1.38@550\n-50 40 1 0 20 coating=1.4601@486.13\n",
        ] {
            comes_back(&Prescription::parse(text).unwrap());
        }
    }

    #[test]
    fn positions_come_back() {
        for head in [
            "zoom 150 150 250 250\nfocus inf 2 inf 2\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
            "focus inf 0.7 2 3\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
            "zoom 1 2 3 4\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
        ] {
            let text = format!("{head}50 D 1.5 20\n-50 D 1 20\n0 E 0 10\n");
            let lens = Prescription::parse(&text).unwrap();
            comes_back(&lens);
            let back = Prescription::parse(&lens.to_table().unwrap()).unwrap();
            let zooms = lens.positions.as_ref().unwrap().zooms();
            let zooms: Vec<_> = zooms.iter().copied().map(Some).chain([None]).collect();
            for zoom in zooms {
                for distance in [f64::INFINITY, 2500.0, 700.0, 100.0] {
                    let [a, b] = [&lens, &back].map(|l| l.at_position(zoom, distance).unwrap());
                    for (a, b) in a.surfaces.iter().zip(&b.surfaces) {
                        // The distance is stored as its reciprocal.
                        assert!((a.thickness - b.thickness).abs() < 1e-14);
                    }
                    assert!((a.film_distance - b.film_distance).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn what_no_table_says_is_refused() {
        let mut lens = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
        lens.surfaces[1].aperture = f64::INFINITY;
        assert_eq!(lens.to_table(), Err(WriteError::NoDiameter(2)));
        lens.surfaces[0].is_stop = true;
        assert_eq!(lens.to_table(), Err(WriteError::Stop(1)));
    }
}
