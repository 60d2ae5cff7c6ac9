//! Triangles side by side.

use super::*;

#[test]
fn triangles_join_their_neighbors_on_every_edge() {
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
        let mut neighbors = [[None; 4]; 2];
        neighbors[0][mine] = Some((1, theirs as u8));
        neighbors[1][theirs] = Some((0, mine as u8));
        let writer = Writer {
            mesh: MeshKind::Triangles,
            faces: vec![
                (
                    Face::new(at, neighbors[0]),
                    sampled_triangle(at, |uv| ramp(here(uv))),
                ),
                (
                    Face::new(at, neighbors[1]),
                    sampled_triangle(at, |uv| ramp(there(uv))),
                ),
            ],
            ..Writer::default()
        };
        let file = file(&writer);
        let corner_uv = [Vec2::ZERO, Vec2::X, Vec2::Y];
        // Not in its middle, where a neighbor that is turned over looks the same.
        let on = |edge: usize| corner_uv[edge].lerp(corner_uv[(edge + 1) % 3], 0.4);
        for face in 0..2 {
            let edge = if face == 0 { mine } else { theirs };
            let map = |uv| if face == 0 { here(uv) } else { there(uv) };
            for into in [0.0, 0.05, 0.15] {
                let uv = on(edge).lerp(Vec2::splat(1.0 / 3.0), into);
                let v = value(&file, face, uv, 0.0);
                // The lattice of centers is not quite even in the ellipse: a hundredth of a texel.
                assert!(
                    (v - ramp(map(uv))).abs() < 3e-4,
                    "{v} {} {mine} {theirs}",
                    ramp(map(uv))
                );
            }
        }
    }
}
