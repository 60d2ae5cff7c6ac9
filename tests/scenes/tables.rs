//! Tables of the documentation that tests write: when, one at a time, and whether the committed rows
//! are those that the tests would write.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Whether the tables are to be written, not checked.
pub(crate) fn writing() -> bool {
    std::env::var_os("FSTOP_WRITE_TABLES").is_some_and(|value| value == "1")
}

/// Held while a table is read and written: tests run at the same time, and many write the same page.
pub(crate) fn lock() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    // What another test's panic left behind is a whole file: writes replace it.
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Do two rows say the same? Numbers may differ by one in their last digit: sines and powers are the
/// platform's own, and a sample in a million takes another path on another processor. That of an
/// exponential, a p-value, by a tenth.
pub(crate) fn same(a: &str, b: &str) -> bool {
    let words = |text: &str| -> Vec<String> {
        text.split_whitespace()
            .map(|word| word.trim_end_matches(',').to_owned())
            .collect()
    };
    let (a, b) = (words(a), words(b));
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a == b || close(a, b))
}

fn close(a: &str, b: &str) -> bool {
    let Some((x, y)) = a.parse::<f64>().ok().zip(b.parse::<f64>().ok()) else {
        return false;
    };
    if a.contains('e') || b.contains('e') {
        return (x - y).abs() <= 0.1 * x.abs().max(y.abs());
    }
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, digits)| digits.len());
    let unit = 10f64.powi(-(decimals(a).min(decimals(b)) as i32));
    (x - y).abs() <= 1.001 * unit
}

#[test]
fn rows_are_compared_as_numbers() {
    assert!(same(
        "| `x` | a 1.0002, 0.31 | 12 |",
        "| `x` | a 1.0003, 0.31 | 12 |"
    ));
    assert!(!same(
        "| `x` | a 1.0002, 0.31 |",
        "| `x` | a 1.0004, 0.31 |"
    ));
    assert!(same("1.2e-3", "1.3e-3") && !same("1.2e-3", "1.5e-3"));
    assert!(!same("", "| `x` |") && !same("cones 3", "disks 3"));
}
