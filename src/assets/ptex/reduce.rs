//! Reductions that the file does not store.

use super::face::Resolution;
use super::header::MeshKind;
use super::sample::Sample;

/// Computes all reductions of a quadrilateral that are not `given` (those halved equally often in u and v), except the
/// one to a single texel. Where a reduction can be reached both ways, u and v are halved in turn.
pub(super) fn quadrilateral<S: Sample>(
    texels: &mut [S],
    full: Resolution,
    channels: usize,
    given: &[bool],
) {
    let position = |at| MeshKind::Quads.texels_before(full, at) * channels;
    for u in (0..=full.u).rev() {
        for v in (0..=full.v).rev() {
            let at = Resolution { u, v };
            let (halved_u, halved_v) = (full.u - u, full.v - v);
            let is_given = halved_u == halved_v && given[usize::from(halved_u)];
            if is_given || at == Resolution::ONE {
                continue;
            }
            let along_u = match halved_u == halved_v {
                true => u % 2 == 1,
                false => halved_u > halved_v,
            };
            let from = Resolution {
                u: u + u8::from(along_u),
                v: v + u8::from(!along_u),
            };
            // Finer ones are stored later.
            let (before, source) = texels.split_at_mut(position(from));
            let target = &mut before[position(at)..][..at.texels() * channels];
            let row = from.width() * channels;
            let (to_next, to_second) = match along_u {
                true => ((2 * channels, row), channels),
                false => ((channels, 2 * row), row),
            };
            for (y, line) in target.chunks_exact_mut(at.width() * channels).enumerate() {
                for (x, texel) in line.chunks_exact_mut(channels).enumerate() {
                    let first = x * to_next.0 + y * to_next.1;
                    for (c, number) in texel.iter_mut().enumerate() {
                        *number = S::mean([source[first + c], source[first + to_second + c]]);
                    }
                }
            }
        }
    }
}

/// The same for a triangle, which is halved in u and v at once: each triangular texel is the mean of the four within
/// it. The inverted one of them is in the other half of the square, mirrored.
pub(super) fn triangle<S: Sample>(
    texels: &mut [S],
    full: Resolution,
    channels: usize,
    given: &[bool],
) {
    let position = |at| MeshKind::Triangles.texels_before(full, at) * channels;
    for log2 in (1..full.u).rev() {
        if given[usize::from(full.u - log2)] {
            continue;
        }
        let square = |log2| Resolution { u: log2, v: log2 };
        let (before, source) = texels.split_at_mut(position(square(log2 + 1)));
        let side = 2usize << log2;
        let of = |x: usize, y: usize, c: usize| source[(y * side + x) * channels + c];
        let target = &mut before[position(square(log2))..];
        for y in 0..side / 2 {
            for x in 0..side / 2 {
                for c in 0..channels {
                    target[(y * side / 2 + x) * channels + c] = S::mean([
                        of(2 * x, 2 * y, c),
                        of(2 * x + 1, 2 * y, c),
                        of(2 * x, 2 * y + 1, c),
                        of(side - 1 - 2 * y, side - 1 - 2 * x, c),
                    ]);
                }
            }
        }
    }
}
