//! Laws of the filters, on files of the test's own writing.

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

/// Texels of a function of (u, v) at their centres.
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
fn a_ramp_goes_on_over_an_edge_however_the_faces_are_turned() {
    let ramp = |p: Vec2| 0.3 + 0.2 * p.x + 0.1 * p.y;
    for turn in 0..4 {
        for edge in 0..4 {
            // Turning the first face too: the edge may be any of its.
            let mut writer = pair(edge, [res(5, 5); 2], ramp);
            let (first, second) = writer.faces.split_at_mut(1);
            let spin = |uv: Vec2| {
                let mut at = uv - 0.5;
                for _ in 0..turn {
                    at = at.perp();
                }
                at + 0.5
            };
            // Its edge that lies along u = 1 of the square is the one before, `turn` times.
            let own = (1 + 4 - turn) & 3;
            let mut neighbours = [None; 4];
            neighbours[usize::from(own)] = Some((1, edge));
            first[0] = (
                Face::new(res(5, 5), neighbours),
                sampled(res(5, 5), |uv| ramp(spin(uv))),
            );
            let mut back = [None; 4];
            back[usize::from(edge)] = Some((0, own));
            second[0].0 = Face::new(res(5, 5), back);
            let file = file(&writer);
            let unspin = |p: Vec2| {
                let mut at = p - 0.5;
                for _ in 0..turn {
                    at = -at.perp();
                }
                at + 0.5
            };
            let map = beyond_right(edge);
            for width in [0.0, 0.04, 0.1, 0.2] {
                for y in [0.45, 0.5, 0.55] {
                    for x in [0.8, 0.97, 1.0] {
                        let p = Vec2::new(x, y);
                        let v = value(&file, 0, unspin(p), width);
                        // B-splines reproduce ramps; stretched ones that are sampled by texels to about a
                        // hundredth of a texel's rise.
                        assert!(
                            (v - ramp(p)).abs() < 2e-4,
                            "{v} {} {turn} {edge} {width}",
                            ramp(p)
                        );
                    }
                    // From the other face.
                    for uv in [
                        Vec2::splat(0.5),
                        map(Vec2::new(0.97, y)),
                        map(Vec2::new(0.5, 0.9)),
                    ] {
                        let inside = uv.clamp(Vec2::splat(0.46), Vec2::splat(0.54));
                        let v = value(&file, 1, inside, width);
                        assert!((v - ramp(map(inside))).abs() < 2e-4, "{v}");
                    }
                }
            }
        }
    }
}

#[test]
fn both_sides_of_an_edge_agree() {
    let wild = |p: Vec2| unit_float(mix2(p.x.to_bits().into(), p.y.to_bits().into()));
    for edge in 0..4 {
        // Also where one is coarser: its texels are what both see.
        for sizes in [[res(4, 4); 2], [res(5, 5), res(3, 3)]] {
            let writer = pair(edge, sizes, wild);
            let file = file(&writer);
            let corner = |i: u8| CORNERS[usize::from(edge + i) & 3];
            for y in [0.2, 0.4, 0.5, 0.71] {
                let along = corner(0).lerp(corner(1), 1.0 - y);
                for width in [0.13, 0.2, 0.3] {
                    let here = value(&file, 0, Vec2::new(1.0, y), width);
                    let there = value(&file, 1, along, width);
                    // The same texels with the same weights; added up in another order.
                    assert!((here - there).abs() < 1e-5, "{here} {there} {edge} {width}");
                }
            }
        }
    }
}

#[test]
fn ramps_and_corners_of_four_faces() {
    let ramp = |p: Vec2| 0.2 + 0.2 * p.x + 0.15 * p.y;
    let file = file(&four(res(5, 5), ramp));
    for face in 0..4 {
        let corner = Vec2::new((face % 2) as f32, (face / 2) as f32);
        for off in [Vec2::ZERO, Vec2::new(0.02, 0.01), Vec2::new(0.1, 0.0)] {
            let p = Vec2::ONE + off * (2.0 * corner - 1.0);
            for width in [0.0, 0.05, 0.1, 0.2] {
                let v = value(&file, face, p - corner, width);
                assert!((v - ramp(p)).abs() < 2e-4, "{v} {}", ramp(p));
            }
        }
    }
}

#[test]
fn all_faces_around_a_corner_agree_there() {
    let at = res(4, 4);
    let of = |i: u32| {
        sampled(at, |uv| {
            unit_float(mix2(
                i.into(),
                (uv.x * 977.0 + uv.y * 31.0).to_bits().into(),
            ))
        })
    };
    // Three faces leave the corner out, four take it as it is; of more each is as good, as far as what is
    // symmetric goes.
    for count in [3, 4, 5, 7] {
        let file = file(&fan(count, at, of));
        for width in [0.1, 0.2, 0.3] {
            let values: Vec<f32> = (0..count)
                .map(|i| value(&file, i, Vec2::ZERO, width))
                .collect();
            let [low, high] =
                [f32::min, f32::max].map(|f| values.iter().copied().reduce(f).unwrap());
            // Random texels between 0 and 1 would differ by a tenth or more. Of three and of more than
            // four faces the library's rule weighs the corner face differently from each side: it differs by
            // what that is worth.
            let most = if count == 4 { 1e-5 } else { 0.12 };
            assert!(high - low < most, "{count}: {values:?}");
        }
    }
}

#[test]
fn wide_footprints_give_the_mean() {
    let ramp = |p: Vec2| 0.2 + 0.2 * p.x + 0.15 * p.y;
    let whole = four(res(4, 4), ramp);
    let file = file(&whole);
    // Centre of a face, one texel a face: the face's own mean.
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
fn missing_neighbours_are_as_the_border_says() {
    let at = res(3, 3);
    let with = |borders| {
        let face = (Face::new(at, [None; 4]), vec![1.0; 64]);
        file(&Writer {
            borders,
            faces: vec![face],
            ..Writer::default()
        })
    };
    let corner = |borders| value(&with(borders), 0, Vec2::ONE, 0.0);
    assert!((corner([0, 0]) - 1.0).abs() < 1e-6);
    // Half of the kernel is beyond each edge.
    assert!((corner([1, 0]) - 0.5).abs() < 1e-6);
    assert!((corner([1, 1]) - 0.25).abs() < 1e-6);
    let black = with([1, 1]);
    for uv in [
        Vec2::new(1.5, 0.5),
        Vec2::new(-3.0, 0.5),
        Vec2::splat(f32::NAN),
    ] {
        let v = value(&black, 0, uv, 0.0);
        assert!(v.abs() < 0.3, "{v}");
    }
    // A torus of one face: its own neighbour all around.
    let torus = Face::new(at, [Some((0, 2)), Some((0, 3)), Some((0, 0)), Some((0, 1))]);
    let periodic = file(&Writer {
        borders: [2, 2],
        faces: vec![(
            torus,
            sampled(at, |uv| {
                unit_float(mix2(uv.x.to_bits().into(), uv.y.to_bits().into()))
            }),
        )],
        ..Writer::default()
    });
    for (one, other) in [
        ((0.0, 0.3), (1.0, 0.3)),
        ((0.2, 0.0), (3.2, 1.0)),
        ((0.0, 0.0), (1.0, -1.0)),
    ] {
        let [a, b] = [one, other].map(|uv| value(&periodic, 0, Vec2::from(uv), 0.2));
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

/// A square [0, 2]² cut as Ptex cuts faces of other than four corners: whole faces 1 below, 2 to the right,
/// 3 above, 4 to the left of a face that is made of the four subfaces 5 to 8, counterclockwise from its
/// lower left corner; each subface has its own corner as its origin and turns with it. Around it all is one
/// plane, so that subfaces need no curvature to be tested.
fn subfaces(at: Resolution, f: impl Fn(Vec2) -> f32) -> (Writer, impl Fn(u32, Vec2) -> Vec2) {
    // From (u, v) of each face to the plane in which the face in the middle is the unit square.
    let place = |face: u32, uv: Vec2| match face {
        0 => uv + 9.0,
        1 => uv + Vec2::NEG_Y,
        2 => uv + Vec2::X,
        3 => uv + Vec2::Y,
        4 => uv + Vec2::NEG_X,
        _ => {
            let mut off = uv * 0.5 - 0.5;
            for _ in 5..face {
                off = off.perp();
            }
            off + 0.5
        }
    };
    // Subface i has the outer half edges on its bottom (following its corner) and left, and the next subface
    // across its right edge.
    let subface = |i: u32| {
        let (after, before) = (5 + (i - 4) % 4, 5 + (i - 2) % 4);
        let below = 1 + (i - 5);
        let left = 1 + (i - 2) % 4;
        // The whole face's edge that touches the middle: its top for the one below, and so on around.
        let edge = |face: u32| ((face + 1) & 3) as u8;
        Face::new(
            at,
            [
                Some((below, edge(below))),
                Some((after, 2)),
                Some((before, 1)),
                Some((left, edge(left))),
            ],
        )
        .as_subface()
    };
    // Whole faces refer to the first subface counterclockwise around themselves.
    let whole = |face: u32| {
        let mut neighbours = [None; 4];
        let first = 5 + face % 4;
        neighbours[((face + 1) & 3) as usize] = Some((first, 3));
        Face::new(res(at.u + 1, at.v + 1), neighbours)
    };
    let mut faces = vec![(Face::new(res(0, 0), [None; 4]), vec![0.0])];
    for face in 1..9 {
        let info = if face < 5 { whole(face) } else { subface(face) };
        let texels = sampled(info.resolution, |uv| f(place(face, uv)));
        faces.push((info, texels));
    }
    let writer = Writer {
        faces,
        ..Writer::default()
    };
    (writer, place)
}

#[test]
fn subfaces_join_whole_faces() {
    let ramp = |p: Vec2| 0.5 + 0.1 * p.x + 0.05 * p.y;
    let (writer, place) = subfaces(res(4, 4), ramp);
    let file = file(&writer);
    for face in 1..9 {
        for (u, v) in
            (0..=10).flat_map(|i| (0..=10).map(move |j| (i as f32 / 10.0, j as f32 / 10.0)))
        {
            let uv = Vec2::new(u, v);
            let p = place(face, uv);
            // Where the kernel stays inside the plus sign that the faces make.
            let inside = |x: f32| (0.25..=0.75).contains(&x);
            for width in [0.02, 0.06] {
                let width = if face < 5 { width } else { 2.0 * width };
                if inside(p.x) && (-0.7..1.7).contains(&p.y)
                    || inside(p.y) && (-0.7..1.7).contains(&p.x)
                {
                    let v = value(&file, face, uv, width);
                    assert!(
                        (v - ramp(p)).abs() < 3e-4,
                        "{v} {} at {p} of {face}",
                        ramp(p)
                    );
                }
            }
        }
    }
    let (flat, _) = subfaces(res(2, 2), |_| 0.25);
    let flat = self::file(&flat);
    for face in 1..9 {
        for (uv, width) in places().flat_map(|uv| WIDTHS.map(|w| (uv, w))) {
            let v = value(&flat, face, uv, width);
            assert!(
                (v - 0.25).abs() < 1e-5,
                "{v} at {uv} of {face}, width {width}"
            );
        }
    }
}

#[test]
fn triangles_join_their_neighbours_on_every_edge() {
    // Two equilateral triangles in the plane, joined on any two edges, and a ramp over both.
    let corners = [Vec2::ZERO, Vec2::X, Vec2::new(0.5, 0.75f32.sqrt())];
    let plane = |[a, b, c]: [Vec2; 3]| move |uv: Vec2| a + uv.x * (b - a) + uv.y * (c - a);
    let ramp = |p: Vec2| 0.4 + 0.2 * p.x - 0.1 * p.y;
    let at = res(4, 4);
    for (mine, theirs) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
        // Edge i goes from corner i to the next: v = 0, u + v = 1, u = 0.
        let [start, end] = [corners[mine], corners[(mine + 1) % 3]];
        let off = corners[(mine + 2) % 3];
        let mut others = [Vec2::ZERO; 3];
        others[theirs] = end;
        others[(theirs + 1) % 3] = start;
        others[(theirs + 2) % 3] = start + end - off;
        let [here, there] = [plane(corners), plane(others)];
        let mut neighbours = [[None; 4]; 2];
        neighbours[0][mine] = Some((1, theirs as u8));
        neighbours[1][theirs] = Some((0, mine as u8));
        let writer = Writer {
            mesh: MeshKind::Triangles,
            faces: vec![
                (
                    Face::new(at, neighbours[0]),
                    sampled_triangle(at, |uv| ramp(here(uv))),
                ),
                (
                    Face::new(at, neighbours[1]),
                    sampled_triangle(at, |uv| ramp(there(uv))),
                ),
            ],
            ..Writer::default()
        };
        let file = file(&writer);
        let corner_uv = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let middle = |edge: usize| corner_uv[edge].midpoint(corner_uv[(edge + 1) % 3]);
        for face in 0..2 {
            let edge = if face == 0 { mine } else { theirs };
            let map = |uv| if face == 0 { here(uv) } else { there(uv) };
            for into in [0.0, 0.05, 0.15] {
                let uv = middle(edge).lerp(Vec2::splat(1.0 / 3.0), into);
                let v = value(&file, face, uv, 0.0);
                // The lattice of centres is not quite even in the ellipse: a hundredth of a texel.
                assert!(
                    (v - ramp(map(uv))).abs() < 3e-4,
                    "{v} {} {mine} {theirs}",
                    ramp(map(uv))
                );
            }
        }
    }
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
    let spec = |gamma| PtexSpec { file: None, gamma };
    let color: Rgb = spec(2.2).compile(Some(0)).evaluate(&textures, &here);
    assert!(
        (color - Rgb::new(0.5f32.powf(2.2), 4.0, -0.5))
            .abs()
            .max_element()
            < 1e-5
    );
    let float: f32 = spec(1.0).compile(Some(0)).evaluate(&textures, &here);
    // The mean of what the channels come to.
    assert!((float - 4.0 / 3.0).abs() < 1e-5);
    let beyond = TexturePoint { face: 1, ..here };
    assert_eq!(
        spec(2.2)
            .compile(Some(0))
            .evaluate::<Rgb>(&textures, &beyond),
        Rgb::ZERO
    );
    for file in [Some(1), Some(2), None] {
        assert_eq!(
            spec(2.2).compile(file).evaluate::<Rgb>(&textures, &here),
            Rgb::ZERO
        );
    }
}

#[test]
fn constant_neighbourhoods_are_looked_up_at_once() {
    let at = res(5, 5);
    let mut writer = four(at, |_| 0.0);
    writer.faces[0] = (Face::new(at, [None; 4]).as_constant(true), vec![0.75]);
    // Neighbours are not asked: here they do not agree.
    assert_eq!(value(&file(&writer), 0, Vec2::ONE, 0.3), 0.75);
}

#[test]
fn vectors_turn_from_face_to_face() {
    let at = res(3, 3);
    for edge in 0..4 {
        let mut writer = pair(edge, [at; 2], |_| 0.0);
        writer.channels = 3;
        writer.tangent_vectors = true;
        // One vector of the plane, in each face's own u and v.
        let map = beyond_right(edge);
        let back = |along: Vec2| {
            Vec2::new(
                (map(Vec2::X) - map(Vec2::ZERO)).dot(along),
                (map(Vec2::Y) - map(Vec2::ZERO)).dot(along),
            )
        };
        let vector = Vec2::new(0.5, 0.25);
        for (face, v) in [(0, vector), (1, back(vector))] {
            let mut texels = [v.x, v.y, 0.125].repeat(64);
            // Not all the same, or the face would be constant.
            texels[2] = 0.5;
            writer.faces[face].1 = texels;
        }
        let file = file(&writer);
        let v = filtered(&file, 0, Vec2::new(1.0, 0.5), &Footprint::default());
        assert!((v.truncate() - vector).length() < 1e-5, "{v} {edge}");
    }
}

/// The files of `tests/scenes/valid`: what they are called, and how they are written.
fn small_files() -> [(&'static str, Writer); 2] {
    // Four squares, in each of which a colour prevails, and of the four numbers a texel one is alpha.
    let colors = [
        [0.8, 0.2, 0.1],
        [0.2, 0.7, 0.3],
        [0.3, 0.3, 0.9],
        [0.9, 0.8, 0.2],
    ];
    let mut squares = four(res(4, 4), |_| 0.0);
    squares.channels = 4;
    squares.alpha = 3;
    squares.samples = SampleKind::U8;
    squares.packing = Packing::Tiled(res(3, 2));
    squares.reductions = 2;
    squares.meta_data = true;
    for ((face, texels), [r, g, b]) in squares.faces.iter_mut().zip(colors) {
        *texels = [r, g, b, 1.0].repeat(face.resolution.texels());
        // A mark in the corner.
        texels[..4].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
    }
    let at = res(3, 3);
    let mut triangles = triangle_fan(at, |i| vec![0.1 * (i + 1) as f32; at.texels()]);
    triangles.samples = SampleKind::F16;
    triangles.reductions = 1;
    triangles.faces[2].0 = triangles.faces[2].0.as_constant(false);
    triangles.faces[2].1.truncate(1);
    [("squares.ptx", squares), ("triangles.ptx", triangles)]
}

fn small_file(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/scenes/valid/textures")
        .join(name)
}

#[test]
fn the_small_files_are_the_writers() {
    for (name, writer) in small_files() {
        // Compressed bytes may be others one day; what they stand for may not.
        let ours = format!("{:?}", file(&writer));
        let theirs = PtexFile::load(&small_file(name)).unwrap();
        assert_eq!(format!("{theirs:?}"), ours, "{name}");
    }
}

#[test]
#[ignore = "writes the files of tests/scenes/valid anew"]
fn write_the_small_files() {
    for (name, writer) in small_files() {
        std::fs::write(small_file(name), writer.to_bytes()).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn wild_neighbours_and_footprints_give_what_is_between_the_texels(
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
        let face = |i: usize, (u, v, sub, neighbours): (u8, u8, bool, [Option<(u32, u8)>; 4])| {
            let at = if triangles { res(u, u) } else { res(u, v) };
            let face = Face::new(at, neighbours);
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
