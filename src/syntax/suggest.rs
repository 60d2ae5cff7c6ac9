//! "Did you mean": finds the known word nearest to a misspelled one.
//!
//! Distance is the optimal string alignment distance, the restricted form of Damerau's (1964): insertions, deletions,
//! substitutions and transpositions of neighbors, each costing one.

/// Words longer than this get no suggestion: the comparison is quadratic.
const LONGEST: usize = 64;

/// The candidate nearest to `word`, if one is near enough to be intended: at most a third of the word's letters wrong,
/// at least one allowed; differences of case are free but lose against an equally near candidate without them. Among
/// equally near candidates the alphabetically first wins, so that the order of a hash map is never visible.
/// so that the order of a hash map never shows.
///
/// ```
/// use fstop::syntax::suggest::nearest;
/// assert_eq!(nearest("Transalte", ["Rotate", "Translate"]), Some("Translate"));
/// assert_eq!(nearest("xyzzy", ["Rotate", "Translate"]), None);
/// ```
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.chars().count() > LONGEST {
        return None;
    }
    let lowered = lower(word);
    let allowed = (lowered.len() / 3).max(1);
    candidates
        .into_iter()
        .filter(|candidate| *candidate != word && candidate.chars().count() <= LONGEST)
        // Every extra or missing letter costs a step.
        .filter(|candidate| candidate.chars().count().abs_diff(lowered.len()) <= allowed)
        .map(|candidate| (distance(&lowered, &lower(candidate)), candidate))
        // A one-letter word is one step from every other one-letter word.
        .filter(|(steps, candidate)| *steps <= allowed && *steps < candidate.chars().count())
        .min_by_key(|&(steps, candidate)| (steps, case_differences(word, candidate), candidate))
        .map(|(_, candidate)| candidate)
}

fn lower(word: &str) -> Vec<char> {
    word.chars().flat_map(char::to_lowercase).collect()
}

fn case_differences(a: &str, b: &str) -> usize {
    a.chars()
        .zip(b.chars())
        .filter(|(a, b)| a != b && a.eq_ignore_ascii_case(b))
        .count()
}

fn distance(a: &[char], b: &[char]) -> usize {
    // Three rows of the usual table: transpositions look two rows back.
    let mut two_above = vec![0; b.len() + 1];
    let mut above: Vec<usize> = (0..=b.len()).collect();
    let mut row = vec![0; b.len() + 1];
    for i in 1..=a.len() {
        row[0] = i;
        for j in 1..=b.len() {
            let substitution = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = substitution.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(two_above[j - 2] + 1);
            }
            row[j] = best;
        }
        std::mem::swap(&mut two_above, &mut above);
        std::mem::swap(&mut above, &mut row);
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn distances_known_by_hand() {
        let d = |a: &str, b: &str| distance(&lower(a), &lower(b));
        assert_eq!(d("", ""), 0);
        assert_eq!(d("", "abc"), 3);
        assert_eq!(d("kitten", "sitting"), 3);
        assert_eq!(d("raduis", "radius"), 1); // one swap
        assert_eq!(d("ca", "abc"), 3); // restricted: an unrestricted swap would need 2
    }

    #[test]
    fn misspellings_find_their_word() {
        let words = super::super::directive::WORDS;
        for (typed, meant) in [
            ("Shpae", "Shape"),
            ("shape", "Shape"),
            ("WORLDBEGIN", "WorldBegin"),
            ("AtributeBegin", "AttributeBegin"),
            ("Lookat", "LookAt"),
            ("MakeNamedMateral", "MakeNamedMaterial"),
            ("Incldue", "Include"),
        ] {
            assert_eq!(nearest(typed, words), Some(meant), "{typed}");
        }
        assert_eq!(nearest("Banana", words), None);
        assert_eq!(nearest("K", ["L", "P"]), None);
    }

    #[test]
    fn case_decides_between_equals_and_then_the_alphabet() {
        assert_eq!(nearest("kd", ["KD", "Kd"]), Some("Kd"));
        assert_eq!(nearest("uve", ["uvb", "uva"]), Some("uva"));
    }

    proptest! {
        #[test]
        fn a_distance_is_a_distance(a in "[ab]{0,6}", b in "[ab]{0,6}") {
            let (a, b) = (lower(&a), lower(&b));
            let d = distance(&a, &b);
            prop_assert_eq!(d, distance(&b, &a));
            prop_assert_eq!(d == 0, a == b);
            prop_assert!(d <= a.len().max(b.len()));
            prop_assert!(d >= a.len().abs_diff(b.len()));
        }
    }
}
