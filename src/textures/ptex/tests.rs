//! Laws of the filters, on files of the test's own writing.

mod files;
mod quads;
mod triangles;

use super::*;
use crate::assets::ptex::writer::{Packing, SampleKind, Writer};
use crate::assets::ptex::{Face, Resolution};
use crate::math::hash::{mix2, unit_float};
use proptest::prelude::*;

const fn res(u: u8, v: u8) -> Resolution {
    Resolution { u, v }
}

fn footprint(x: Vec2, y: Vec2) -> Footprint {
    Footprint {
        duvdx: x,
        duvdy: y,
        ..Footprint::default()
    }
}

fn file(writer: &Writer) -> PtexFile {
    PtexFile::parse(&writer.to_bytes()).unwrap()
}

/// The first channel.
fn value(file: &PtexFile, face: u32, uv: Vec2, width: f32) -> f32 {
    filtered(file, face, uv, &footprint(Vec2::X * width, Vec2::Y * width)).x
}

/// Texels of a function of (u, v) at their centers.
fn sampled(at: Resolution, f: impl Fn(Vec2) -> f32) -> Vec<f32> {
    let size = Vec2::new(at.width() as f32, at.height() as f32);
    let texel = |i: usize| Vec2::new((i % at.width()) as f32, (i / at.width()) as f32) + 0.5;
    (0..at.texels()).map(|i| f(texel(i) / size)).collect()
}

/// Of a triangle: below the diagonal a third in, above it of the other half.
fn sampled_triangle(at: Resolution, f: impl Fn(Vec2) -> f32) -> Vec<f32> {
    let side = at.width();
    let texel = |i: usize| {
        let (x, y) = (i % side, i / side);
        let place = |x: usize, y: usize, third: f32| Vec2::new(x as f32, y as f32) + third;
        match x + y < side {
            true => place(x, y, 1.0 / 3.0),
            false => place(side - 1 - y, side - 1 - x, 2.0 / 3.0),
        }
    };
    (0..at.texels())
        .map(|i| f(texel(i) / side as f32))
        .collect()
}

/// Where a corner of a quadrilateral is, counterclockwise.
const CORNERS: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

/// A map from (u, v) of a face whose edge `edge` lies along the right edge of the unit square, outside it,
/// to the plane.
fn beyond_right(edge: u8) -> impl Fn(Vec2) -> Vec2 {
    // Its corners at the edge's start and end are the square's (1, 1) and (1, 0).
    let corner = |i: u8| CORNERS[usize::from(edge + i) & 3];
    let (start, end, inward) = (corner(0), corner(1), corner(3) - corner(0));
    move |uv: Vec2| {
        let along = (uv - start).dot(end - start);
        let into = (uv - start).dot(inward);
        Vec2::new(1.0 + into, 1.0 - along)
    }
}

/// Two faces: the unit square, and one beyond its right edge that is turned.
fn pair(edge: u8, at: [Resolution; 2], f: impl Fn(Vec2) -> f32) -> Writer {
    let mut back = [None; 4];
    back[usize::from(edge)] = Some((0, 1));
    let map = beyond_right(edge);
    Writer {
        faces: vec![
            (
                Face::new(at[0], [None, Some((1, edge)), None, None]),
                sampled(at[0], &f),
            ),
            (Face::new(at[1], back), sampled(at[1], |uv| f(map(uv)))),
        ],
        ..Writer::default()
    }
}

/// Four faces around the corner (1, 1) of the first, all upright.
fn four(at: Resolution, f: impl Fn(Vec2) -> f32) -> Writer {
    let faces = [
        [None, Some((1, 3)), Some((2, 0)), None],
        [None, None, Some((3, 0)), Some((0, 1))],
        [Some((0, 2)), Some((3, 3)), None, None],
        [Some((1, 2)), None, None, Some((2, 1))],
    ];
    let texels = |i: usize| sampled(at, |uv| f(uv + Vec2::new((i % 2) as f32, (i / 2) as f32)));
    Writer {
        faces: (0..4)
            .map(|i| (Face::new(at, faces[i]), texels(i)))
            .collect(),
        ..Writer::default()
    }
}

/// `count` faces around a common corner, which is the origin of each: the edge v = 0 of one is the edge
/// u = 0 of the one before.
fn fan(count: u32, at: Resolution, of: impl Fn(u32) -> Vec<f32>) -> Writer {
    let face = |i: u32| {
        let (before, after) = ((i + count - 1) % count, (i + 1) % count);
        Face::new(at, [Some((before, 3)), None, None, Some((after, 0))])
    };
    Writer {
        faces: (0..count).map(|i| (face(i), of(i))).collect(),
        ..Writer::default()
    }
}

/// The six triangles around a common corner, which is the origin of each.
fn triangle_fan(at: Resolution, of: impl Fn(u32) -> Vec<f32>) -> Writer {
    let face = |i: u32| {
        Face::new(
            at,
            [Some(((i + 5) % 6, 2)), None, Some(((i + 1) % 6, 0)), None],
        )
    };
    Writer {
        mesh: MeshKind::Triangles,
        faces: (0..6).map(|i| (face(i), of(i))).collect(),
        ..Writer::default()
    }
}

/// Middles, ends and edges.
fn places() -> impl Iterator<Item = Vec2> {
    let ends = [0.0, 0.01, 0.3, 0.5, 0.77, 0.999, 1.0];
    ends.into_iter()
        .flat_map(move |u| ends.map(|v| Vec2::new(u, v)))
}

const WIDTHS: [f32; 9] = [0.0, 0.01, 0.07, 0.13, 0.24, 0.3, 0.6, 1.0, 50.0];

#[test]
fn a_constant_texture_is_constant() {
    let flat = |at: Resolution| vec![0.625; at.texels()];
    let at = res(4, 3);
    let mut files = vec![four(at, |_| 0.625)];
    files.extend((2..=12).map(|count| fan(count, at, |_| flat(at))));
    for edge in 0..4 {
        for other in [res(0, 0), res(1, 5), res(4, 4)] {
            files.push(pair(edge, [at, other], |_| 0.625));
        }
    }
    files.push(triangle_fan(res(4, 4), |_| flat(res(4, 4))));
    files.push(triangle_fan(res(0, 0), |_| flat(res(0, 0))));
    for writer in files {
        let file = file(&writer);
        for face in 0..file.faces().len() as u32 {
            for (uv, width) in places().flat_map(|uv| WIDTHS.map(|w| (uv, w))) {
                let v = value(&file, face, uv, width);
                // A few dozen roundings.
                assert!(
                    (v - 0.625).abs() < 1e-5,
                    "{v} at {uv} of face {face}, width {width}"
                );
            }
            let slanted = footprint(Vec2::new(0.2, 0.01), Vec2::new(-0.03, 0.001));
            let v = filtered(&file, face, Vec2::new(0.9, 0.1), &slanted).x;
            assert!((v - 0.625).abs() < 1e-5, "{v}");
        }
    }
}

#[test]
fn wide_footprints_give_the_mean() {
    let ramp = |p: Vec2| 0.2 + 0.2 * p.x + 0.15 * p.y;
    let whole = four(res(4, 4), ramp);
    let file = file(&whole);
    // Center of a face, one texel a face: the face's own mean.
    let v = value(&file, 0, Vec2::splat(0.5), 1.0);
    assert!((v - ramp(Vec2::splat(0.5))).abs() < 1e-5, "{v}");
    // At the corner the mean of four.
    let v = value(&file, 3, Vec2::ZERO, 1e30);
    assert!((v - ramp(Vec2::ONE)).abs() < 1e-5, "{v}");
    // A triangle alone: with a wide Gaussian all of it.
    let at = res(4, 4);
    let alone = Writer {
        mesh: MeshKind::Triangles,
        faces: vec![(
            Face::new(at, [None; 4]),
            sampled_triangle(at, |p| p.x + 2.0 * p.y),
        )],
        ..Writer::default()
    };
    let v = value(&self::file(&alone), 0, Vec2::splat(1.0 / 3.0), 1e3);
    // The mean of u + 2 v over a triangle.
    assert!((v - 1.0).abs() < 1e-4, "{v}");
}

#[test]
fn gamma_applies_between_0_and_1_after_filtering() {
    let at = res(1, 1);
    let writer = Writer {
        channels: 3,
        faces: vec![(Face::new(at, [None; 4]), [0.5, 4.0, -0.5].repeat(4))],
        ..Writer::default()
    };
    let textures = Textures {
        ptex: vec![Some(file(&writer)), None],
        ..Textures::default()
    };
    let here = TexturePoint {
        p: Rgb::ZERO,
        uv: Vec2::splat(0.5),
        footprint: Footprint::default(),
        face: 0,
    };
    let of = |index, gamma| Ptex {
        file: None,
        gamma,
        index,
    };
    let color: Rgb = of(Some(0), 2.2).evaluate(&textures, &here);
    assert!(
        (color - Rgb::new(0.5f32.powf(2.2), 4.0, -0.5))
            .abs()
            .max_element()
            < 1e-5
    );
    let float: f32 = of(Some(0), 1.0).evaluate(&textures, &here);
    // The mean of what the channels come to.
    assert!((float - 4.0 / 3.0).abs() < 1e-5);
    let beyond = TexturePoint { face: 1, ..here };
    let black: Rgb = of(Some(0), 2.2).evaluate(&textures, &beyond);
    assert_eq!(black, Rgb::ZERO);
    for file in [Some(1), Some(2), None] {
        let black: Rgb = of(file, 2.2).evaluate(&textures, &here);
        assert_eq!(black, Rgb::ZERO);
    }
}

#[test]
fn constant_neighborhoods_are_looked_up_at_once() {
    let at = res(5, 5);
    let mut writer = four(at, |_| 0.0);
    writer.faces[0] = (Face::new(at, [None; 4]).as_constant(true), vec![0.75]);
    // Neighbors are not asked: here they do not agree.
    assert_eq!(value(&file(&writer), 0, Vec2::ONE, 0.3), 0.75);
}

/// Logarithms of the resolution, whether it is a subface, and neighbors.
type WildFace = (u8, u8, bool, [Option<(u32, u8)>; 4]);

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn wild_neighbors_and_footprints_give_what_is_between_the_texels(
        triangles in any::<bool>(),
        faces in proptest::collection::vec(
            (0u8..4, 0u8..4, any::<bool>(), proptest::array::uniform4(proptest::option::of((0u32..4, 0u8..3)))),
            4,
        ),
        borders in proptest::array::uniform2(0u16..3),
        lookups in proptest::collection::vec(
            (0u32..4, proptest::array::uniform2(-1.5f32..2.5), proptest::array::uniform4(-2f32..2.0), -5i32..6),
            8,
        ),
    ) {
        let mesh = if triangles { MeshKind::Triangles } else { MeshKind::Quads };
        let face = |i: usize, (u, v, sub, neighbors): WildFace| {
            let at = if triangles { res(u, u) } else { res(u, v) };
            let face = Face::new(at, neighbors);
            let texel = |k| 0.25 + 0.5 * unit_float(mix2(i as u64, k));
            (if sub { face.as_subface() } else { face }, (0..at.texels() as u64).map(texel).collect())
        };
        let writer = Writer {
            mesh,
            borders,
            faces: faces.into_iter().enumerate().map(|(i, f)| face(i, f)).collect(),
            ..Writer::default()
        };
        let file = file(&writer);
        for (face, uv, d, scale) in lookups {
            let d = d.map(|d| d * 10f32.powi(2 * scale));
            let footprint = footprint(Vec2::new(d[0], d[1]), Vec2::new(d[2], d[3]));
            let v = filtered(&file, face, uv.into(), &footprint).x;
            // Never beyond the texels; below them where the border is black.
            let low = if borders.contains(&1) { 0.0 } else { 0.25 };
            prop_assert!(v.is_finite() && v > low - 1e-4 && v < 0.75 + 1e-4, "{v}");
        }
        for uv in [f32::NAN, f32::INFINITY, 1e30, -1e30] {
            let wild = footprint(Vec2::splat(uv), Vec2::splat(-uv));
            prop_assert!(filtered(&file, 0, Vec2::splat(uv), &wild).is_finite());
            prop_assert!(filtered(&file, 9, Vec2::splat(uv), &wild) == Rgb::ZERO);
        }
    }
}
