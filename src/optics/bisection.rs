//! Where a yes becomes a no.

/// Halves the interval `steps` times, keeping the half whose ends differ: `is_low` holds at `low` and not at `high`.
pub(super) fn bisect(
    [mut low, mut high]: [f64; 2],
    steps: u32,
    mut is_low: impl FnMut(f64) -> bool,
) -> [f64; 2] {
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if is_low(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}
