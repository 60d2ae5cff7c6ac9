//! The analysis as a text table.

use super::{LensAnalysis, MTF_FREQUENCIES, SeidelTerms};
use crate::optics::report::decimals;
use std::fmt;

impl fmt::Display for LensAnalysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_view(f)?;
        self.write_fields(f)?;
        self.write_focus(f)?;
        self.write_field_curves(f)?;
        self.write_seidel(f)
    }
}

impl LensAnalysis {
    /// Some of the rows over the field, as many as [`LensAnalysis::rows`], from the middle to the edge.
    pub fn shown<'a, T>(&self, all: &'a [T]) -> impl Iterator<Item = &'a T> {
        let last = all.len().saturating_sub(1);
        let count = self.rows.clamp(1, all.len().max(1));
        let place = move |i: usize| (i * last + (count - 1) / 2) / (count - 1).max(1);
        (0..count).filter_map(move |i| all.get(place(i)))
    }

    fn write_view(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let film = &self.film;
        writeln!(f, "film {:.2} mm x {:.2} mm", film.width, film.height)?;
        let view = &self.field_of_view;
        for (name, angle) in [
            ("horizontal view", view.horizontal),
            ("vertical view", view.vertical),
            ("diagonal view", view.diagonal),
        ] {
            match angle {
                Some(a) => writeln!(f, "{name:24}{a:12.2} degrees")?,
                None => writeln!(f, "{name:24}{:>12}", "not covered")?,
            }
        }
        if let Some([height, angle]) = self.chief_limit {
            writeln!(
                f,
                "{:24}{height:12.4} at {angle:.2} degrees",
                "image circle radius"
            )?;
        }
        if let Some(n) = self.effective_f_number {
            writeln!(f, "{:24}{n:12.4}", "effective f-number")?;
        }
        Ok(())
    }

    fn write_fields(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "\nheight  angle  distortion  illumination  cos^4  spot rms   contrast by rays, sagittal/tangential, at"
        )?;
        for frequency in MTF_FREQUENCIES {
            write!(f, " {frequency}")?;
        }
        writeln!(
            f,
            " lp/mm\n    mm    deg           %             %      %        um"
        )?;
        for p in self.shown(&self.fields) {
            let distortion = or_dash(p.distortion, |d| decimals(d, 3));
            let spot = or_dash(p.spot_rms, |r| format!("{:.2}", 1e3 * r));
            write!(
                f,
                "{:6.2} {:6.2} {distortion:>11} {:13.1} {:6.1} {spot:>9} ",
                p.height,
                p.field_angle,
                100.0 * p.relative_illumination,
                100.0 * p.cos4_field
            )?;
            for [s, t] in p.mtf.iter().flatten() {
                write!(f, "  {s:.2}/{t:.2}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    fn write_focus(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nfocus at  film distance  extension  magnification  sharp from        to\n       m             mm         mm                          m         m"
        )?;
        for row in &self.focus {
            writeln!(
                f,
                "{:>8} {:14.4} {:10.4} {:14.5} {:>11} {:>9}",
                meters(row.distance),
                row.film_distance,
                row.extension,
                row.magnification,
                or_dash(row.near, meters),
                or_dash(row.far, meters)
            )?;
        }
        Ok(())
    }

    fn write_field_curves(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nheight  focus, sagittal  tangential  (mm behind the film)"
        )?;
        for p in self.shown(&self.field_curves) {
            let focus = |z: Option<f64>| or_dash(z, |z| format!("{z:.4}"));
            let (s, t) = (focus(p.sagittal), focus(p.tangential));
            writeln!(f, "{:6.2} {s:>15} {t:>11}", p.height)?;
        }
        Ok(())
    }

    fn write_seidel(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(seidel) = &self.seidel else {
            return Ok(());
        };
        writeln!(
            f,
            "\nSeidel sums in um for the image height {:.2} mm\nsurface  spherical      coma  astigmatism   Petzval  distortion  C_I (F-C)  C_II (F-C)",
            seidel.image_height
        )?;
        let row = |f: &mut fmt::Formatter<'_>, name: String, terms: &SeidelTerms| {
            let [s, c, a, p, d, axial, lateral] = terms.values().map(|x| decimals(1e3 * x, 3));
            writeln!(
                f,
                "{name:>7} {s:>10} {c:>9} {a:>12} {p:>9} {d:>11} {axial:>10} {lateral:>11}"
            )
        };
        for (i, terms) in seidel.surfaces.iter().enumerate() {
            row(f, (i + 1).to_string(), terms)?;
        }
        row(f, "sum".to_string(), &seidel.sum)
    }
}

/// A number's text, or a dash where there is none.
fn or_dash(x: Option<f64>, text: impl Fn(f64) -> String) -> String {
    x.map_or_else(|| "-".to_string(), text)
}

/// A distance given in mm, in meters.
pub fn meters(mm: f64) -> String {
    if mm.is_finite() {
        // Four significant digits, or millimeters.
        let m = 1e-3 * mm;
        let decimals = if m < 10.0 { 3 } else { 1 };
        format!("{m:.decimals$}")
    } else {
        "inf".to_string()
    }
}
