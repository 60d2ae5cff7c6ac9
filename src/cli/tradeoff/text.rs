//! The study as text.

use crate::tradeoff::integrators::BIASED;
use crate::tradeoff::{Candidate, Estimate, Measurement, Setting, Study};
use std::fmt::Write;

/// The table and the recommendation.
pub(super) fn report(study: &Study, scene: &str, shrunk: bool) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}\n", heading(study, scene, shrunk));
    let mut line = |[setting, value, spp, error, bias, seconds, efficiency]: [String; 7]| {
        let _ = writeln!(
            text,
            "{setting:<15} {value:<13} {spp:>7} {error:>18} {bias:>18} {seconds:>16} {efficiency:>16}"
        );
    };
    let head = [
        "setting",
        "value",
        "spp",
        "error %",
        "bias %",
        "processor s",
        "efficiency",
    ];
    line(head.map(str::to_string));
    rows(study).for_each(line);
    for (candidate, why) in &study.failed {
        let _ = writeln!(
            text,
            "{:<15} {:<13} {why}",
            candidate.setting.name(),
            candidate.value
        );
    }
    let _ = writeln!(text, "\n{}", legend(study));
    let _ = writeln!(text, "\n{}", sentence(study));
    text
}

/// The cells of the table.
pub(super) fn rows(study: &Study) -> impl Iterator<Item = [String; 7]> {
    let base = study.measured.first().map(|(_, m)| m);
    study.measured.iter().map(move |(candidate, m)| {
        let efficiency = base.map(|base| number(relative_efficiency(m, base)));
        [
            candidate.setting.name().to_string(),
            candidate.value.clone(),
            m.spp.to_string(),
            percent(m.error()),
            bias(m),
            number(m.seconds),
            efficiency.unwrap_or_default(),
        ]
    })
}

/// What was measured, in one line.
pub(super) fn heading(study: &Study, scene: &str, shrunk: bool) -> String {
    let [width, height] = study.resolution;
    let size = if shrunk {
        ", smaller than the scene asks for"
    } else {
        ""
    };
    format!(
        "{scene}: {width}x{height} pixels{size}; reference of {:.0} samples a pixel, relative error {:.2} %",
        study.reference_spp,
        100.0 * study.reference_error
    )
}

/// How to read the table.
pub(super) fn legend(study: &Study) -> String {
    let slope = study.slope.map_or_else(String::new, |slope| {
        format!(
            " Squared noise falls with samples to the power -{slope:.2} (independent samples: -1)."
        )
    });
    format!(
        "Errors are relative to the image (root mean square over pixels and channels, dark ones kept from \
         deciding alone by 1 % of the mean). Bias is what more samples do not mend; textures are filtered for the \
         scene's own number of samples throughout. Efficiency is \
         1/(variance x processor time), the scene's own being 1. ± is half the 95 % confidence interval.{slope}"
    )
}

/// The recommendation.
pub(super) fn sentence(study: &Study) -> String {
    let Some(advice) = &study.recommendation else {
        return "Nothing could be measured.".to_string();
    };
    let turned: Vec<String> = advice
        .turned
        .iter()
        .map(|&i| &study.measured[i].0)
        .map(|candidate| match candidate.setting {
            Setting::Sampler
            | Setting::LensModel
            | Setting::Integrator
            | Setting::LightChoice
            | Setting::PupilSampling => {
                format!("{} \"{}\"", candidate.setting.name(), candidate.value)
            }
            setting => format!("{} {}", setting.name(), candidate.value),
        })
        .collect();
    let settings = match turned.len() {
        0 => "the scene's own settings".to_string(),
        _ => turned.join(", "),
    };
    let check = match &study.verified {
        Some(m) => format!(
            " Rendered so, it took {} s of processor time and had an error of {} %.",
            number(m.seconds),
            percent(m.error())
        ),
        None => " (Not rendered: it would take longer than the study.)".to_string(),
    };
    format!(
        "For {} % error take {settings} with {} samples a pixel: about {:.3} s of processor time ({:.3} s at the {:.1} \
         processors that this study had).{check}{}",
        short(100.0 * advice.target),
        advice.spp,
        advice.seconds,
        advice.seconds / study.processors,
        study.processors,
        about_integrators(study)
    )
}

/// Which integrator to take, and which of them show another image; empty if there is no choice.
fn about_integrators(study: &Study) -> String {
    let measured = study.measured.iter().enumerate();
    let others = measured.filter(|(_, (candidate, _))| candidate.setting == Setting::Integrator);
    let turned =
        |i: usize| { study.recommendation.iter() }.any(|advice| advice.turned.contains(&i));
    let (mut taken, mut count, mut notes) = (None, 0, String::new());
    for (i, (candidate, m)) in others {
        count += 1;
        let name = &candidate.value;
        taken = if turned(i) {
            Some(spelled(candidate))
        } else {
            taken
        };
        let differs = m.squared_bias.excludes(0.0) && m.squared_bias.value > 0.0;
        if let Some(why) = why_it_differs(name).filter(|_| differs) {
            let _ = write!(
                notes,
                " `{name}` differs by {} %: {why}.",
                percent(m.bias())
            );
        }
    }
    match (count, taken) {
        (0, _) => String::new(),
        (_, Some(name)) => format!(" Of the integrators take {name}.{notes}"),
        (_, None) => format!(" Of the integrators keep the scene's own.{notes}"),
    }
}

/// An integrator as a scene names it, with the disc that it was measured with.
fn spelled(candidate: &Candidate) -> String {
    let name = &candidate.value;
    match candidate.photon_radius() {
        Some(radius) => format!("`{name}` with \"float radius\" {radius}"),
        None => format!("`{name}`"),
    }
}

/// Where an integrator's image is another one than the reference.
fn why_it_differs(integrator: &str) -> Option<&'static str> {
    match integrator {
        BIASED => Some(
            "it blurs light over discs, less so with more samples, finds caustics in mirrors and through glass, and \
             passes over media",
        ),
        "bdpt" => Some("it finds caustics of lights without area, which path tracers lack"),
        "path" => Some("it lacks caustics of lights without area, and media"),
        "volpath" => Some("it lacks caustics of lights without area"),
        _ => None,
    }
}

/// Efficiency of a setting relative to another's.
fn relative_efficiency(m: &Measurement, base: &Measurement) -> Estimate {
    let value = m.efficiency.value / base.efficiency.value;
    let part = |e: &Estimate| (e.within / e.value).powi(2);
    // To first order; the scene's own setting is the unit.
    let within = match std::ptr::eq(m, base) {
        true => 0.0,
        false => value * (part(&m.efficiency) + part(&base.efficiency)).sqrt(),
    };
    Estimate { value, within }
}

/// A bias, or a dash if it cannot be told from noise.
fn bias(m: &Measurement) -> String {
    match m.squared_bias.excludes(0.0) && m.squared_bias.value > 0.0 {
        true => percent(m.bias()),
        false => "-".to_string(),
    }
}

/// A fraction in percent.
fn percent(e: Estimate) -> String {
    number(Estimate {
        value: 100.0 * e.value,
        within: 100.0 * e.within,
    })
}

/// Rounded to its significant digits.
fn number(e: Estimate) -> String {
    if !e.value.is_finite() {
        return "-".to_string();
    }
    if !e.within.is_finite() || e.within == 0.0 {
        return short(e.value);
    }
    let digits = (1.0 - e.within.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{:.digits$} ± {:.digits$}", e.value, e.within)
}

fn short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_what_is_known() {
        let of = |value, within| number(Estimate { value, within });
        assert_eq!(of(1.23456, 0.0123), "1.235 ± 0.012");
        assert_eq!(of(123.456, 45.6), "123 ± 46");
        assert_eq!(of(2.0, 0.0), "2");
        assert_eq!(of(2.5, f64::INFINITY), "2.5");
        assert_eq!(of(f64::NAN, 1.0), "-");
        assert_eq!(short(100.0), "100");
    }
}
