//! Quadrilaterals side by side, turned, around corners, and cut into subfaces.

use super::*;

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
            let mut neighbors = [None; 4];
            neighbors[usize::from(own)] = Some((1, edge));
            first[0] = (
                Face::new(res(5, 5), neighbors),
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
fn missing_neighbors_are_as_the_border_says() {
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
    // A torus of one face: its own neighbor all around.
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
        let mut neighbors = [None; 4];
        let first = 5 + face % 4;
        neighbors[((face + 1) & 3) as usize] = Some((first, 3));
        Face::new(res(at.u + 1, at.v + 1), neighbors)
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
