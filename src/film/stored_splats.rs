//! Sums of splats as bytes, in checkpoints: little-endian, to the same bits on every machine.
//!
//! They are stored in parts of so many pixels, so that no more than one part is in memory twice. The first begins with the
//! paths and with what was dropped. A pixel is the lengths of its six numbers, five bits each in four bytes, and then
//! those bytes of them that are not leading zeros; what has no light is four zero bytes and, again in four, the number of
//! such pixels.

use super::splats::{DroppedSplat, Splats, Sums};
use crate::math::UVec2;

/// Pixels in a part.
const PART: usize = 1 << 16;

/// Bits of the length of a number.
const LENGTH: u32 = 5;

/// About as many bytes are stored for a pixel.
pub(crate) const STORED_PIXEL: u64 = 48;

impl Splats {
    /// How many parts there are.
    pub(crate) fn parts(&self) -> u32 {
        self.pixels.len().div_ceil(PART).max(1) as u32
    }

    /// Appends a part to `out`.
    pub(crate) fn store(&self, part: u32, out: &mut Vec<u8>) {
        let mut number = |number: u64| out.extend(number.to_le_bytes());
        if part == 0 {
            number(self.paths().ranges().len() as u64);
            for range in self.paths().ranges() {
                number(range.start);
                number(range.end);
            }
            number(self.dropped);
            let first = self.first_dropped.map_or([u64::MAX; 3], |first| {
                let UVec2 { x, y } = first.pixel;
                [first.path, x.into(), y.into()]
            });
            first.into_iter().for_each(number);
        }
        let mut dark = 0u32;
        for sums in self.pixels.chunks(PART).nth(part as usize).unwrap_or(&[]) {
            if *sums == Sums::default() {
                dark += 1;
                continue;
            }
            store_dark(std::mem::take(&mut dark), out);
            sums.store(out);
        }
        store_dark(dark, out);
    }

    /// Adds the sums and paths of a part. Returns `false` if they cannot be one of these, or if some paths are here
    /// already: then the sums are useless.
    #[must_use]
    pub(crate) fn add_stored(&mut self, part: u32, mut bytes: &[u8]) -> bool {
        self.stored(part, &mut bytes)
            .is_some_and(|()| bytes.is_empty())
    }

    fn stored(&mut self, part: u32, bytes: &mut &[u8]) -> Option<()> {
        if part == 0 {
            for _ in 0..word(bytes)? {
                let range = word(bytes)?..word(bytes)?;
                let is_new = !range.is_empty() && self.paths.insert(range);
                is_new.then_some(())?;
            }
            self.dropped = self.dropped.saturating_add(word(bytes)?);
            let [path, x, y] = [word(bytes)?, word(bytes)?, word(bytes)?];
            let pixel = UVec2::new(x as u32, y as u32);
            let first = (path != u64::MAX).then_some(DroppedSplat { path, pixel });
            self.first_dropped = DroppedSplat::first(self.first_dropped, first);
        }
        let mut pixels = self.pixels.chunks_mut(PART).nth(part as usize)?.iter_mut();
        while pixels.len() > 0 {
            match u32::from_le_bytes(take(bytes)?) {
                0 => {
                    let dark = u32::from_le_bytes(take(bytes)?) as usize;
                    pixels.nth(dark.checked_sub(1)?)?;
                }
                lengths => pixels.next()?.join(&Sums::stored(lengths, bytes)?),
            }
        }
        Some(())
    }
}

fn store_dark(count: u32, out: &mut Vec<u8>) {
    if count > 0 {
        out.extend(0u32.to_le_bytes());
        out.extend(count.to_le_bytes());
    }
}

impl Sums {
    fn store(&self, out: &mut Vec<u8>) {
        // The sign in the last bit, so that a small negative number is as short as a positive one.
        let values = self.values.map(|sum| ((sum << 1) ^ (sum >> 127)) as u128);
        let numbers = [values, self.squares];
        let numbers = numbers.as_flattened();
        let length = |number: &u128| u128::BITS / 8 - number.leading_zeros() / 8;
        let lengths = { numbers.iter() }
            .rev()
            .fold(0, |all, n| all << LENGTH | length(n));
        out.extend(lengths.to_le_bytes());
        for number in numbers {
            out.extend(&number.to_le_bytes()[..length(number) as usize]);
        }
    }

    fn stored(lengths: u32, bytes: &mut &[u8]) -> Option<Sums> {
        let mut numbers = [0u128; 6];
        for (number, i) in numbers.iter_mut().zip(0..) {
            let length = (lengths >> (LENGTH * i)) as usize & ((1 << LENGTH) - 1);
            let (own, rest) = bytes.split_at_checked(length)?;
            *bytes = rest;
            let mut whole = [0; 16];
            whole.get_mut(..length)?.copy_from_slice(own);
            *number = u128::from_le_bytes(whole);
        }
        let [a, b, c, d, e, f] = numbers;
        let value = |number: u128| (number >> 1) as i128 ^ -((number & 1) as i128);
        Some(Sums {
            values: [a, b, c].map(value),
            squares: [d, e, f],
        })
    }
}

fn word(bytes: &mut &[u8]) -> Option<u64> {
    take(bytes).map(u64::from_le_bytes)
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelBounds, SplatBuffer};
    use crate::handles::LightLayer;
    use crate::math::Rgb;

    /// More pixels than a part has, few of which have light.
    fn splats() -> Splats {
        let bounds = PixelBounds::new(UVec2::new(2, 3), UVec2::new(302, 303));
        let mut splats = Splats::new(bounds, -3, 0);
        let mut buffer = SplatBuffer::new(bounds, f32::INFINITY, false);
        buffer.begin(7);
        for i in 0..1000u32 {
            let pixel = UVec2::new(2 + i * 37 % 300, 3 + i / 4);
            let value = Rgb::new(0.1, 1e-6 * i as f32, -1e6);
            buffer.push(
                i.into(),
                pixel,
                if i == 500 { Rgb::NAN } else { value },
                (LightLayer::default(), Rgb::ONE),
            );
        }
        buffer.reach(1007);
        splats.add(&mut buffer);
        splats.pixels[0].values = [i128::MAX, i128::MIN, -1];
        splats.pixels[0].squares = [u128::MAX, 1, 0];
        splats
    }

    fn stored(splats: &Splats) -> Vec<Vec<u8>> {
        let store = |part| {
            let mut bytes = Vec::new();
            splats.store(part, &mut bytes);
            bytes
        };
        (0..splats.parts()).map(store).collect()
    }

    #[test]
    fn sums_come_back_bit_for_bit() {
        let splats = splats();
        let parts = stored(&splats);
        assert_eq!(parts.len(), 2);
        let blank = Splats::new(splats.bounds(), -3, 0);
        let mut again = blank.clone();
        for (part, bytes) in (0..).zip(&parts) {
            assert!(again.add_stored(part, bytes));
        }
        assert_eq!(again, splats);
        // Its paths are there already.
        assert!(!again.add_stored(0, &parts[0]));
        assert!(!blank.clone().add_stored(2, &parts[1]));
        for cut in [0, 30, parts[0].len() - 1] {
            assert!(!blank.clone().add_stored(0, &parts[0][..cut]));
        }
        let longer = [&parts[0][..], &[0]].concat();
        assert!(!blank.clone().add_stored(0, &longer));
    }

    #[test]
    fn sums_of_different_paths_add_up() {
        let bounds = PixelBounds::new(UVec2::ZERO, UVec2::new(5, 1));
        let traced = |from: u64, to: u64| {
            let mut splats = Splats::new(bounds, 0, 0);
            let mut buffer = SplatBuffer::new(bounds, f32::INFINITY, false);
            buffer.begin(from);
            for i in from..to {
                buffer.push(
                    i,
                    UVec2::new(i as u32 % 5, 0),
                    Rgb::splat(1.0 / i as f32),
                    (LightLayer::default(), Rgb::ONE),
                );
            }
            buffer.reach(to);
            splats.add(&mut buffer);
            splats
        };
        let mut sum = Splats::new(bounds, 0, 0);
        for (from, to) in [(50, 99), (1, 20), (20, 50)] {
            assert!(sum.add_stored(0, &stored(&traced(from, to))[0]));
        }
        assert_eq!(sum, traced(1, 99));
    }
}
