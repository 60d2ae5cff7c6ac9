//! Deflates what blocks of images are made of, as a zlib stream (RFC 1950, RFC 1951).
//!
//! Made for bytes that repeat every second byte or are noise: OpenEXR's differences of the even and of the odd bytes of numbers, where a number that
//! is the same in the next pixel repeats its two bytes. So nothing is searched for but what is equal to the byte before the last, and all else is literal
//! bytes in Huffman codes of their own for every 64 KiB. With layers that takes a quarter to two fifths of the time of zlib's least effort, for files up to
//! a tenth longer, with colors alone a tenth to a fifth of it, for 1 % (docs/notes/performance.md, "EXR blocks", with the crates that were tried).

use std::ops::Range;

/// Bytes of a block: as many as may be stored.
const BLOCK: usize = u16::MAX as usize;

/// The longest code of a literal or length, in bits: five of them and seven more fit in 63 (RFC 1951 allows 15).
const LONGEST: usize = 11;

/// Literals, the end of a block and lengths (RFC 1951 §3.2.5).
const SYMBOLS: usize = 286;
const END: usize = 256;

/// From so many literals on, not all of them are counted.
const MANY: u32 = 1 << 12;

/// The longest length.
const MAX_LENGTH: u32 = 258;

/// More bytes than the lengths of the codes take, and eight that are written at once.
const OF_CODES: usize = 1 << 10;

/// Bytes that are what they are, then such that are as the byte before the last.
#[derive(Clone, Copy, Default)]
struct Token {
    literals: u32,
    repeated: u32,
}

/// The zlib stream of these bytes, in this memory. Part of a [kernel](crate::math::instruction_set): with BMI2 shifts by the length of a code take fewer
/// instructions.
#[inline(always)]
pub(super) fn zlib<'a>(data: &[u8], memory: &'a mut Vec<u8>) -> &'a [u8] {
    // Codes of literals have `LONGEST` bits, and a length takes less than the bytes that it repeats.
    let size = data.len() / 2 * 3 + OF_CODES * (data.len() / BLOCK + 1);
    if memory.len() < size {
        *memory = vec![0; size];
    }
    let mut out = Bits::new(memory);
    // A window of 32 KiB, least effort.
    out.put_bytes(&[0x78, 0x01]);
    let mut tokens = Vec::new();
    let mut start = 0;
    loop {
        let end = data.len().min(start + BLOCK);
        block(data, start..end, &mut tokens, &mut out);
        if end == data.len() {
            break;
        }
        start = end;
    }
    out.pad();
    out.put_bytes(&simd_adler32::adler32(&data).to_be_bytes());
    let left = out.room.len();
    memory.get(..memory.len() - left).unwrap_or_default()
}

/// Writes a block, the last one if it ends where the data does.
#[inline(always)]
fn block(data: &[u8], range: Range<usize>, tokens: &mut Vec<Token>, out: &mut Bits) {
    tokens.clear();
    find_repeated(data, range.clone(), tokens);
    let counts = counts(data, range.start, tokens);
    let lengths = code_lengths(&counts, LONGEST);
    let is_last = u32::from(range.end == data.len());
    let bits = { counts.iter().zip(&lengths) }.map(|(&count, &length)| count * u32::from(length));
    // What is noise is stored, which takes no time to read either; and nothing at all, of which there is no code.
    if bits.sum::<u32>() / 8 >= range.len() as u32 / 64 * 63 {
        out.put(is_last, 3);
        out.pad();
        let count = range.len() as u16;
        out.put_bytes(&count.to_le_bytes());
        out.put_bytes(&(!count).to_le_bytes());
        out.put_bytes(data.get(range).unwrap_or_default());
        return;
    }
    out.put(is_last | 2 << 1, 3);
    write_lengths(&lengths, out);
    write_tokens(data, range.start, tokens, &codes(&lengths), out);
}

/// Returns `true` if there are so many bytes from here on, `at` least 2, and each is as the one before the last.
#[inline(always)]
fn repeats<const N: usize>(data: &[u8], at: usize) -> bool {
    // One range for both, and so one test that they are there.
    { data.get(at - 2..at + N) }.is_some_and(|both| both[..N] == both[2..])
}

/// Parts a range into what repeats the byte before the last and the rest: where eight bytes do, at every eighth place.
#[inline(always)]
fn find_repeated(data: &[u8], range: Range<usize>, tokens: &mut Vec<Token>) {
    let data = data.get(..range.end).unwrap_or_default();
    let (mut from, mut at) = (range.start, range.start.max(2));
    while at + 8 <= data.len() {
        if !repeats::<8>(data, at) {
            at += 8;
            continue;
        }
        let first = from.max(2);
        let mut begin = at;
        while begin > first && repeats::<1>(data, begin - 1) {
            begin -= 1;
        }
        at += 8;
        // Most of them are long.
        while repeats::<32>(data, at) {
            at += 32;
        }
        while repeats::<8>(data, at) {
            at += 8;
        }
        while repeats::<1>(data, at) {
            at += 1;
        }
        tokens.push(Token {
            literals: (begin - from) as u32,
            repeated: (at - begin) as u32,
        });
        from = at;
    }
    tokens.push(Token {
        literals: (range.end - from) as u32,
        repeated: 0,
    });
}

/// Tokens with their literals.
struct Parts<'a> {
    data: &'a [u8],
    start: usize,
    tokens: std::slice::Iter<'a, Token>,
}

/// Those of this data, from `start` on.
#[inline(always)]
fn parts<'a>(data: &'a [u8], start: usize, tokens: &'a [Token]) -> Parts<'a> {
    Parts {
        data,
        start,
        tokens: tokens.iter(),
    }
}

impl<'a> Iterator for Parts<'a> {
    type Item = (&'a [u8], u32);

    #[inline(always)]
    fn next(&mut self) -> Option<(&'a [u8], u32)> {
        let token = self.tokens.next()?;
        let end = self.start + token.literals as usize;
        let literals = self.data.get(self.start..end).unwrap_or_default();
        self.start = end + token.repeated as usize;
        Some((literals, token.repeated))
    }
}

/// How often each symbol is used. Where they are many, four of eight literals are counted, twice, in half the time, and one more of each, so that all have
/// a code: codes are hardly longer.
#[inline(always)]
fn counts(data: &[u8], start: usize, tokens: &[Token]) -> [u32; SYMBOLS] {
    let are_many = { tokens.iter() }.map(|token| token.literals).sum::<u32>() >= MANY;
    // Two tables: a processor waits where it counts the same twice in a row.
    let mut tables = [[0; SYMBOLS]; 2];
    for (literals, repeated) in parts(data, start, tokens) {
        let (eights, rest) = literals.as_chunks::<8>();
        for eight in eights {
            let (counted, others) = eight.split_at(4);
            let weight = if are_many { 2 } else { 1 };
            for (i, &byte) in counted.iter().enumerate() {
                tables[i % 2][usize::from(byte)] += weight;
            }
            for &byte in others.iter().filter(|_| !are_many) {
                tables[0][usize::from(byte)] += 1;
            }
        }
        for &byte in rest {
            tables[0][usize::from(byte)] += 1;
        }
        for length in Lengths(repeated) {
            tables[0][symbol(length).0] += 1;
        }
    }
    let [mut counts, others] = tables;
    for (i, (count, other)) in counts.iter_mut().zip(others).enumerate() {
        *count += other + u32::from(are_many && i < END);
    }
    counts[END] = 1;
    counts
}

/// Parts a number of repeated bytes into lengths of 3 to 258.
struct Lengths(u32);

impl Iterator for Lengths {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        let length = match self.0 {
            0 => return None,
            // One or two would be left.
            259 | 260 => self.0 - 3,
            left => left.min(MAX_LENGTH),
        };
        self.0 -= length;
        Some(length)
    }
}

/// The symbol of a length, and the bits that follow it, with their number (RFC 1951 §3.2.5).
#[inline(always)]
fn symbol(length: u32) -> (usize, (u32, u32)) {
    let above = length - 3;
    match length {
        MAX_LENGTH => (SYMBOLS - 1, (0, 0)),
        ..11 => (END + 1 + above as usize, (0, 0)),
        _ => {
            let extra = above.ilog2() - 2;
            let symbol = END as u32 + 1 + 4 * extra + (above >> extra);
            (symbol as usize, (above & ((1 << extra) - 1), extra))
        }
    }
}

#[inline(always)]
fn write_tokens<'a>(
    data: &[u8],
    start: usize,
    tokens: &[Token],
    codes: &[Code; SYMBOLS],
    bits: &mut Bits<'a>,
) {
    // In the processor's registers.
    let mut out = Bits::<'a> {
        room: std::mem::take(&mut bits.room),
        ..*bits
    };
    for (literals, repeated) in parts(data, start, tokens) {
        let (fives, rest) = literals.as_chunks::<5>();
        for five in fives {
            for &byte in five {
                out.put_code(codes[usize::from(byte)]);
            }
            out.flush();
        }
        for &byte in rest {
            out.put_code(codes[usize::from(byte)]);
        }
        out.flush();
        for length in Lengths(repeated) {
            let (symbol, (bits, count)) = symbol(length);
            out.put_code(codes[symbol]);
            out.put(bits, count);
            // The only distance: 2.
            out.put(0, 1);
            out.flush();
        }
    }
    out.put_code(codes[END]);
    out.flush();
    *bits = out;
}

/// Writes the lengths of the codes, in Huffman codes themselves (RFC 1951 §3.2.7).
fn write_lengths(lengths: &[u8; SYMBOLS], out: &mut Bits) {
    const ORDER: [usize; 19] = [
        16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15,
    ];
    // Of distances there is 2 alone.
    let all: Vec<u8> = lengths.iter().copied().chain([0, 1]).collect();
    let words: Vec<_> = all.chunk_by(|a, b| a == b).flat_map(words_of_run).collect();
    let mut counts = [0; 19];
    for (symbol, _) in &words {
        counts[*symbol] += 1;
    }
    let lengths = code_lengths(&counts, 7);
    let codes = codes(&lengths);
    out.put((SYMBOLS - 257) as u32, 5);
    out.put(2 - 1, 5);
    out.put(19 - 4, 4);
    out.flush();
    for place in ORDER {
        out.put(lengths[place].into(), 3);
        out.flush();
    }
    for (symbol, (bits, count)) in words {
        out.put_code(codes[symbol]);
        out.put(bits, count);
        out.flush();
    }
}

/// A run of equal lengths of codes: symbols, each with bits that follow it and their number.
fn words_of_run(run: &[u8]) -> Vec<(usize, (u32, u32))> {
    let (Some(&length), mut left) = (run.first(), run.len() as u32) else {
        return Vec::new();
    };
    let itself = (usize::from(length), (0, 0));
    let mut words = Vec::new();
    if length > 0 {
        words.push(itself);
        left -= 1;
    }
    while left >= 3 {
        let (count, word) = match (length, left) {
            (0, 11..) => (left.min(138), (18, (left.min(138) - 11, 7))),
            (0, _) => (left, (17, (left - 3, 3))),
            _ => (left.min(6), (16, (left.min(6) - 3, 2))),
        };
        words.push(word);
        left -= count;
    }
    words.extend((0..left).map(|_| itself));
    words
}

/// Lengths of Huffman codes for symbols that are used so often, in bits; 0 for those that are not. At least two are.
fn code_lengths<const N: usize>(counts: &[u32; N], longest: usize) -> [u8; N] {
    // As one number each, which are sorted in less time.
    let key = |(symbol, &count): (usize, &u32)| u64::from(count) << 32 | symbol as u64;
    let used = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let mut leaves: Vec<u64> = used.map(key).collect();
    leaves.sort_unstable();
    let mut of_length = lengths_of_tree(&leaves, longest);
    // Where codes were too long, others have to become longer (Kraft's inequality): as few bits as that takes.
    let space = |of_length: &[u32; 16]| -> u32 {
        (1..=longest).map(|i| of_length[i] << (longest - i)).sum()
    };
    for _ in 1 << longest..space(&of_length) {
        if let Some(shorter) = (1..longest).rev().find(|&i| of_length[i] > 0) {
            of_length[longest] -= 1;
            of_length[shorter] -= 1;
            of_length[shorter + 1] += 2;
        }
    }
    let mut lengths = [0; N];
    let longest_first = (1..=longest).rev();
    let in_order = longest_first.flat_map(|i| std::iter::repeat_n(i as u8, of_length[i] as usize));
    for (leaf, length) in leaves.iter().zip(in_order) {
        lengths[*leaf as u32 as usize] = length;
    }
    lengths
}

/// How many of these leaves, in order of their counts in the upper half, a Huffman tree has at each depth; all that are deeper than `longest` are
/// counted there.
fn lengths_of_tree(leaves: &[u64], longest: usize) -> [u32; 16] {
    let count = leaves.len();
    let mut weights: Vec<u32> = leaves.iter().map(|leaf| (leaf >> 32) as u32).collect();
    let mut parents = vec![0; (2 * count).saturating_sub(1)];
    // The least two nodes become one, again and again: both the leaves and the nodes that are made are in order.
    let (mut leaf, mut inner) = (0, count);
    for node in count..parents.len() {
        let mut weight = 0;
        for _ in 0..2 {
            let is_leaf = leaf < count && (inner == node || weights[leaf] <= weights[inner]);
            let least = if is_leaf { &mut leaf } else { &mut inner };
            weight += weights[*least];
            parents[*least] = node;
            *least += 1;
        }
        weights.push(weight);
    }
    let mut depths = vec![0; parents.len()];
    let mut of_length = [0; 16];
    for node in (0..parents.len().saturating_sub(1)).rev() {
        depths[node] = depths[parents[node]] + 1;
        if node < count {
            of_length[depths[node].min(longest)] += 1;
        }
    }
    of_length
}

/// A symbol's bits, the first one lowest, and their number.
#[derive(Clone, Copy, Default)]
struct Code {
    bits: u16,
    length: u8,
}

/// The codes of these lengths (RFC 1951 §3.2.2).
fn codes<const N: usize>(lengths: &[u8; N]) -> [Code; N] {
    let mut of_length = [0; 16];
    for &length in lengths.iter().filter(|length| **length > 0) {
        of_length[usize::from(length)] += 1;
    }
    // The first of each length.
    let mut next = [0_u16; 16];
    for length in 1..16 {
        next[length] = (next[length - 1] + of_length[length - 1]) << 1;
    }
    lengths.map(|length| match length {
        0 => Code::default(),
        _ => {
            let next = &mut next[usize::from(length)];
            let bits = next.reverse_bits() >> (16 - length);
            *next += 1;
            Code { bits, length }
        }
    })
}

/// Room for bytes that are to be written, and bits that do not make one yet.
struct Bits<'a> {
    room: &'a mut [u8],
    buffer: u64,
    count: u32,
}

impl Bits<'_> {
    fn new(room: &mut [u8]) -> Bits<'_> {
        Bits {
            room,
            buffer: 0,
            count: 0,
        }
    }

    /// Writes bytes, where no bits wait.
    fn put_bytes(&mut self, bytes: &[u8]) {
        if let Some(room) = self.room.get_mut(..bytes.len()) {
            room.copy_from_slice(bytes);
            self.skip(bytes.len());
        }
    }

    /// So many bytes are written.
    #[inline(always)]
    fn skip(&mut self, count: usize) {
        let room = std::mem::take(&mut self.room);
        self.room = room.get_mut(count..).unwrap_or_default();
    }

    /// So many bits. With those that wait, there must be fewer than 64.
    #[inline(always)]
    fn put(&mut self, bits: u32, count: u32) {
        self.buffer |= u64::from(bits) << self.count;
        self.count += count;
    }

    #[inline(always)]
    fn put_code(&mut self, code: Code) {
        self.put(code.bits.into(), code.length.into());
    }

    /// Writes all whole bytes, where there is room for eight.
    #[inline(always)]
    fn flush(&mut self) {
        if let Some(room) = self.room.first_chunk_mut() {
            *room = self.buffer.to_le_bytes();
            // Never all eight of them.
            self.skip((self.count / 8 % 8) as usize);
        }
        self.buffer = self.buffer.wrapping_shr(self.count & !7);
        self.count %= 8;
    }

    /// Writes all, up to a whole byte.
    fn pad(&mut self) {
        self.count = self.count.next_multiple_of(8);
        self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::mix2;
    use flate2::read::ZlibDecoder;
    use proptest::prelude::*;
    use std::io::Read;

    /// How long the stream is of which zlib makes these bytes again.
    fn round_trip(data: &[u8]) -> usize {
        // In memory that has other bytes in it.
        let mut memory = vec![0xa5; 100];
        let zipped = zlib(data, &mut memory);
        let mut again = Vec::new();
        let mut decoder = ZlibDecoder::new(zipped);
        decoder.read_to_end(&mut again).unwrap();
        assert!(again == data, "{} bytes", data.len());
        assert_eq!(decoder.total_in(), zipped.len() as u64);
        zipped.len()
    }

    fn noise(count: u64) -> Vec<u8> {
        (0..count).map(|i| mix2(i, 0) as u8).collect()
    }

    #[test]
    fn runs_of_every_length_come_back() {
        for count in 0..1000 {
            round_trip(&vec![7; count]);
            let pairs: Vec<u8> = (0..count).map(|i| [9, 200][i % 2]).collect();
            round_trip(&pairs);
            let between = [&noise(20)[..], &pairs, &noise(9)].concat();
            round_trip(&between);
        }
    }

    /// Literals that are not counted have long codes: the most that a block may take.
    #[test]
    fn what_is_not_counted_comes_back() {
        let byte = |i: u64| match i % 8 {
            0..4 => (i % 3) as u8,
            _ => 128 | mix2(i, 2) as u8,
        };
        let data: Vec<u8> = (0..200_000).map(byte).collect();
        assert!(round_trip(&data) < data.len() + 100);
        assert!(round_trip(&data[..MANY as usize / 2]) < MANY as usize / 2);
    }

    #[test]
    fn blocks_end_anywhere() {
        for count in [
            BLOCK - 9,
            BLOCK - 1,
            BLOCK,
            BLOCK + 1,
            2 * BLOCK,
            3 * BLOCK + 5,
        ] {
            assert!(round_trip(&vec![0; count]) < 2000);
            assert!(round_trip(&noise(count as u64)) < count + 50);
        }
    }

    #[test]
    fn codes_are_no_longer_than_they_may_be() {
        // Counts as Fibonacci's numbers make the deepest tree.
        let mut data = Vec::new();
        let (mut count, mut next) = (1, 1);
        for byte in 0..23 {
            data.extend(std::iter::repeat_n(byte * 3, count));
            (count, next) = (next, count + next);
        }
        // In an order that has no runs.
        let mut shuffled: Vec<_> = (0_u64..).map(|i| mix2(i, 1)).zip(&data).collect();
        shuffled.sort_unstable();
        let shuffled: Vec<u8> = shuffled.into_iter().map(|(_, byte)| *byte).collect();
        assert!(round_trip(&shuffled) < shuffled.len() / 2);
    }

    proptest! {
        #[test]
        fn anything_comes_back(
            parts in prop::collection::vec((any::<u16>(), any::<u8>(), 0_usize..3000), 0..60)
        ) {
            let mut data = Vec::new();
            for (seed, kinds, count) in parts {
                let pair = seed.to_le_bytes();
                data.extend((0..count).map(|i| match kinds % 4 {
                    0 => pair[i % 2],
                    1 => pair[0],
                    2 => mix2(seed.into(), i as u64) as u8 >> (pair[0] % 8),
                    _ => (i as u8).wrapping_mul(pair[1]),
                }));
            }
            round_trip(&data);
        }
    }
}
