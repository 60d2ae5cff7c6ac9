//! Spoiling a scene: one small damage at a time, as editors, transfers and typing do it, and some
//! as only malice does. Everything is drawn from a seed, so that what failed once fails again.

use fstop::math::hash::mix;

/// A stream of numbers.
pub(super) struct Dice(u64);

impl Dice {
    /// The same seed gives the same numbers.
    pub(super) fn new(seed: u64) -> Dice {
        Dice(mix(seed))
    }

    /// A number below `n`, 0 where `n` is 0.
    pub(super) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        // The remainder prefers small numbers by one part in 10^15.
        mix(self.0).checked_rem(n as u64).unwrap_or(0) as usize
    }

    fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> &'a T {
        from[self.below(from.len())]
    }

    /// A piece of `0..length`, short more often than long.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        let most = [1, 4, 30, length][self.below(4)].min(length - start);
        start..start + self.below(most + 1)
    }
}

/// What may stand anywhere in a broken file, or in place of any word of a good one.
const NASTY: [&str; 50] = [
    "",
    "\"",
    "[",
    "]",
    "[ ]",
    "\"\"",
    "#",
    "\\",
    "\0",
    "-1",
    "0",
    "-0",
    "1",
    "2",
    "3",
    "1e-30",
    "1e-300",
    "1e30",
    "1e38",
    "-1e38",
    "1e300",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "2147483647",
    "-2147483648",
    "4294967296",
    "9223372036854775808",
    "99999999999999999999999999999999999",
    "0x",
    ".",
    "1,2",
    "true",
    "\"true\"",
    "WorldBegin",
    "WorldEnd",
    "AttributeBegin",
    "AttributeEnd",
    "TransformEnd",
    "ObjectBegin \"pair\"",
    "ObjectEnd",
    "ObjectInstance \"pair\"",
    "ReverseOrientation",
    "Scale 0 0 0",
    "Scale 1e20 1e-20 1e20",
    "Shape \"sphere\"",
    "AreaLightSource \"diffuse\"",
    "Volume \"homogeneous\"",
    "\"texture Kd\" \"t\"",
];

/// `scene` with one to four damages; `other` is where pieces are taken from.
pub(super) fn spoil(scene: &[u8], other: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = scene.to_vec();
    for _ in 0..=dice.below(4) {
        damage(&mut bytes, other, dice);
    }
    bytes
}

fn damage(bytes: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    match dice.below(10) {
        0 => flip(bytes, dice),
        1 => drop(bytes.drain(dice.range(bytes.len()))),
        2 => duplicate(bytes, dice),
        3 => bytes.truncate(dice.below(bytes.len() + 1)),
        4 => splice(bytes, other, dice),
        5 => swap_words(bytes, dice),
        6 => swap_lines(bytes, dice),
        // Words are where the meaning lies: three times as often as the rest.
        _ => replace_word(bytes, dice),
    }
}

fn flip(bytes: &mut [u8], dice: &mut Dice) {
    let at = dice.below(bytes.len());
    let bit = 1 << dice.below(8);
    if let Some(byte) = bytes.get_mut(at) {
        *byte ^= bit;
    }
}

fn duplicate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let piece = bytes[dice.range(bytes.len())].to_vec();
    let at = dice.below(bytes.len() + 1);
    bytes.splice(at..at, piece);
}

fn splice(bytes: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    let piece = other[dice.range(other.len())].to_vec();
    let place = dice.range(bytes.len());
    bytes.splice(place, piece);
}

/// Words with the blanks behind them.
fn words(bytes: &[u8]) -> Vec<Vec<u8>> {
    let blank = |b: &u8| b.is_ascii_whitespace();
    bytes
        .chunk_by(|a, b| !blank(a) || blank(b))
        .map(<[u8]>::to_vec)
        .collect()
}

fn swap_words(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let mut words = words(bytes);
    if !words.is_empty() {
        let (a, b) = (dice.below(words.len()), dice.below(words.len()));
        words.swap(a, b);
    }
    *bytes = words.concat();
}

fn swap_lines(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|b| *b == b'\n').collect();
    if !lines.is_empty() {
        let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
        lines.swap(a, b);
    }
    *bytes = lines.concat();
}

fn replace_word(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let mut words = words(bytes);
    let at = dice.below(words.len());
    let nasty = dice.pick(&NASTY).as_bytes();
    if let Some(word) = words.get_mut(at) {
        // Half of the time brackets glued to the word stay, so that lists stay lists.
        let number = |b: &u8| b.is_ascii_alphanumeric() || b".+-".contains(b);
        let inner = word
            .iter()
            .position(number)
            .zip(word.iter().rposition(number));
        match inner.filter(|_| dice.below(2) == 0) {
            Some((first, last)) => drop(word.splice(first..=last, nasty.iter().copied())),
            None => *word = [nasty, b" "].concat(),
        }
    }
    *bytes = words.concat();
}
