//! `--error` and `--time`: when to stop rendering.

use clap::Args;
use std::time::Duration;

/// Arguments that stop a render at an error goal or time limit.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "When it is done")]
pub(super) struct GoalArgs {
    /// Render until the image's estimated relative error is this: 0.01 or 1%
    #[arg(long, value_parser = relative, allow_hyphen_values = true, value_name = "REL")]
    pub(super) error: Option<f64>,
    /// With --error: stop only when the true error is as small with this confidence, though the render looks after each
    /// pass
    #[arg(long, value_parser = confidence, allow_hyphen_values = true, value_name = "P", requires = "error")]
    pub(super) confidence: Option<f64>,
    /// Render until this many seconds have passed; an image without the time for a sample in each pixel is
    /// coarse
    #[arg(long, value_parser = seconds, allow_hyphen_values = true, value_name = "SECONDS")]
    pub(super) time: Option<Duration>,
}

impl GoalArgs {
    /// Returns `true` if there is one.
    pub(super) fn is_given(&self) -> bool {
        self.error.is_some() || self.time.is_some()
    }
}

/// Parses a fraction: a number or a percentage.
pub(super) fn relative(text: &str) -> Result<f64, String> {
    let expected = || "expected a positive share such as 0.01 or 1%".to_string();
    let (number, unit) = match text.strip_suffix('%') {
        Some(number) => (number.trim_end(), 0.01),
        None => (text, 1.0),
    };
    let share = number.parse::<f64>().map_err(|_| expected())? * unit;
    if unit == 1.0 && (1.0..).contains(&share) {
        // 1 more likely means 1 % than an error as large as the image.
        return Err(format!(
            "{text} without % is {}%: for {text} % write {text}%",
            100.0 * share
        ));
    }
    (share > 0.0 && share.is_finite())
        .then_some(share)
        .ok_or_else(expected)
}

/// Parses a probability from one half to below one, as a number or a percentage.
fn confidence(text: &str) -> Result<f64, String> {
    let expected = "expected a probability of at least a half and below one, such as 95% or 0.95";
    let number = |text: &str| text.trim_end().parse::<f64>();
    let share = match text.strip_suffix('%') {
        Some(percent) => number(percent).map(|n| n / 100.0),
        None => number(text),
    };
    let share = share.ok().filter(|share| (0.5..1.0).contains(share));
    share.ok_or_else(|| expected.to_string())
}

/// Longer than anybody waits, in seconds: 30,000 years.
const LONGEST: f64 = 1e12;

/// Parses a positive duration.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let expected = || "expected a positive number of seconds".to_string();
    let seconds = text.parse::<f64>().map_err(|_| expected())?;
    if seconds >= LONGEST {
        return Err(format!("too long: expected less than {LONGEST:e} seconds"));
    }
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| expected())?;
    (!time.is_zero()).then_some(time).ok_or_else(expected)
}

/// Parses a positive duration with or without a unit: 90, 90s, 5m, 2h.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let units = [("s", 1), ("m", 60), ("h", 3600)];
    let unit = units
        .iter()
        .find_map(|(unit, s)| Some((text.strip_suffix(unit)?, *s)));
    let (number, scale) = unit.unwrap_or((text, 1));
    seconds(number)?
        .checked_mul(scale)
        .ok_or_else(|| "too long".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_seconds() {
        assert_eq!(relative("0.5"), Ok(0.5));
        assert_eq!(relative("1%"), Ok(0.01));
        assert_eq!(relative("2 %"), Ok(0.02));
        for bad in ["", "%", "0", "-1", "nan", "inf", "1%%", "x"] {
            assert!(relative(bad).is_err(), "{bad}");
            assert!(seconds(bad).is_err(), "{bad}");
        }
        let bare = relative("5").expect_err("500 %");
        assert_eq!(bare, "5 without % is 500%: for 5 % write 5%");
        assert_eq!((relative("5%"), relative("150%")), (Ok(0.05), Ok(1.5)));
        assert!(relative("1").is_err() && relative("1e9").is_err());
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        assert!(seconds("1e300").is_err_and(|message| message.starts_with("too long")));
    }
}
