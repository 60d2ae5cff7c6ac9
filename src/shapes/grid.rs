//! Grids of points as triangle meshes: what heightfields and diced patches become.

/// Two triangles for each cell of a grid of `columns` × `rows` points that are numbered row by row:
/// (x, y) (x+1, y) (x+1, y+1) and (x, y) (x+1, y+1) (x, y+1), as in pbrt-v3.
pub(super) fn triangles(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    let cells = columns.saturating_sub(1) as usize * rows.saturating_sub(1) as usize;
    let mut triangles = Vec::with_capacity(2 * cells);
    for y in 1..rows {
        for x in 1..columns {
            let (below, above) = ((y - 1) * columns + x, y * columns + x);
            triangles.push([below - 1, below, above]);
            triangles.push([below - 1, above, above - 1]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_cut_from_the_first_corner_to_the_last() {
        assert_eq!(triangles(2, 2), [[0, 1, 3], [0, 3, 2]]);
        assert_eq!(triangles(3, 2)[2..], [[1, 2, 5], [1, 5, 4]]);
        assert_eq!(triangles(3, 4).len(), 12);
        assert!(triangles(1, 9).is_empty() && triangles(0, 0).is_empty());
    }
}
