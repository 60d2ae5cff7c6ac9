//! The four sample types of the format.

use half::f16;
use std::fmt::Debug;

/// The type of a file's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleKind {
    U8,
    U16,
    F16,
    F32,
}

impl SampleKind {
    pub(super) fn from_number(number: u32) -> Result<SampleKind, String> {
        match number {
            0 => Ok(SampleKind::U8),
            1 => Ok(SampleKind::U16),
            2 => Ok(SampleKind::F16),
            3 => Ok(SampleKind::F32),
            _ => Err(format!("its kind of sample {number} is unknown")),
        }
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            SampleKind::U8 => 1,
            SampleKind::U16 | SampleKind::F16 => 2,
            SampleKind::F32 => 4,
        }
    }
}

/// Texels of all faces, in the file's sample type: eight-bit ones would take four times the memory as floats.
#[derive(Clone, Debug)]
pub enum Texels {
    /// 8-bit integers; 255 is 1.
    U8(Box<[u8]>),
    /// 16-bit integers; 65535 is 1.
    U16(Box<[u16]>),
    /// Half floats.
    F16(Box<[f16]>),
    /// Floats.
    F32(Box<[f32]>),
}

impl Texels {
    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Texels::U8(texels) => size_of_val(&texels[..]),
            Texels::U16(texels) => size_of_val(&texels[..]),
            Texels::F16(texels) => size_of_val(&texels[..]),
            Texels::F32(texels) => size_of_val(&texels[..]),
        }
    }

    /// The stored value that represents 1.
    #[inline]
    pub fn one(&self) -> f32 {
        match self {
            Texels::U8(_) => u8::ONE,
            Texels::U16(_) => u16::ONE,
            Texels::F16(_) | Texels::F32(_) => 1.0,
        }
    }
}

/// A sample of a texel. Integers are truncated, not rounded, when they are averaged or multiplied, as the format's
/// authors do it.
pub trait Sample: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The stored value that represents 1.
    const ONE: f32;

    /// The stored value: [`Sample::ONE`] times the value it represents.
    fn value(self) -> f32;

    /// Decodes the first little-endian sample in `bytes`.
    fn from_bytes(bytes: &[u8]) -> Self;

    /// The mean of two or four samples.
    fn mean<const N: usize>(samples: [Self; N]) -> Self;

    /// The sample times a factor.
    fn scaled(self, factor: f32) -> Self;

    /// Undoes difference encoding: each sample was stored minus the one before it. Floats are never stored this way.
    fn sum_up(differences: &mut [Self]);
}

macro_rules! integer_sample {
    ($kind:ty, $wider:ty) => {
        impl Sample for $kind {
            const ONE: f32 = <$kind>::MAX as f32;

            #[inline(always)]
            fn value(self) -> f32 {
                f32::from(self)
            }

            fn from_bytes(bytes: &[u8]) -> $kind {
                bytes
                    .first_chunk()
                    .map_or(0, |b| <$kind>::from_le_bytes(*b))
            }

            fn mean<const N: usize>(samples: [$kind; N]) -> $kind {
                (samples.map(<$wider>::from).iter().sum::<$wider>() / N as $wider) as $kind
            }

            fn scaled(self, factor: f32) -> $kind {
                (f32::from(self) * factor) as $kind
            }

            fn sum_up(differences: &mut [$kind]) {
                let mut before: $kind = 0;
                for number in differences {
                    before = before.wrapping_add(*number);
                    *number = before;
                }
            }
        }
    };
}

integer_sample!(u8, u16);
integer_sample!(u16, u32);

macro_rules! float_sample {
    ($kind:ty, $from:path, $to:path) => {
        impl Sample for $kind {
            const ONE: f32 = 1.0;

            #[inline(always)]
            fn value(self) -> f32 {
                $to(self)
            }

            fn from_bytes(bytes: &[u8]) -> $kind {
                bytes
                    .first_chunk()
                    .map_or($from(0.0), |b| <$kind>::from_le_bytes(*b))
            }

            fn mean<const N: usize>(samples: [$kind; N]) -> $kind {
                $from(samples.map($to).iter().sum::<f32>() / N as f32)
            }

            fn scaled(self, factor: f32) -> $kind {
                $from($to(self) * factor)
            }

            fn sum_up(_: &mut [$kind]) {}
        }
    };
}

float_sample!(f16, f16::from_f32, f16::to_f32);
float_sample!(f32, std::convert::identity, std::convert::identity);
