//! The filter on quadrilaterals: a separable kernel, cut where it crosses edges, its pieces weighed on
//! the neighbors.

use super::axis::Axis;
use super::kernel::{BOTTOM, Kernel, LEFT, RIGHT, TOP};
use super::sum;
use crate::assets::ptex::{Border, Face, PtexFile};
use crate::math::{Rgb, Vec2};

/// Most faces around a corner that are gathered.
const MAX_AROUND: usize = 10;

/// How often a piece that came to a subface may be cut again: one may reach past a subface in both
/// directions and not farther. Neighbors that make no sense would lead on.
const MAX_CUTS: u8 = 4;

/// The filtered value at `uv` of a face with its number, of footprint [∂(u,v)/∂x, ∂(u,v)/∂y].
pub(super) fn filtered(
    file: &PtexFile,
    (number, face): (u32, &Face),
    uv: Vec2,
    [x, y]: [Vec2; 2],
) -> Rgb {
    let (Some(u), Some(v)) = (within(uv.x, file.borders[0]), within(uv.y, file.borders[1])) else {
        return Rgb::ZERO;
    };
    // The box around both differentials.
    let width = x.abs() + y.abs();
    let kernel = Kernel::new(Vec2::new(u, v), width, face.resolution, face.is_subface());
    let mut gathering = Gathering {
        file,
        sum: Rgb::ZERO,
        weight: kernel.weight(),
    };
    gathering.add_across(kernel, number, face, 0);
    // Without weight, all of the kernel was beyond corners where faces are missing.
    sum::weighted_mean(file, face, gathering.sum, gathering.weight)
}

/// A coordinate where the border's way of continuing has a face; `None` where it is all black.
fn within(u: f32, border: Border) -> Option<f32> {
    match border {
        Border::Clamp => Some(u.clamp(0.0, 1.0)),
        Border::Periodic => Some(u - u.floor()),
        Border::Black => (u > -1.0 && u < 2.0).then_some(u),
    }
}

/// A sum of weighted texels over faces.
struct Gathering<'a> {
    file: &'a PtexFile,
    /// In units of the file's numbers.
    sum: Rgb,
    /// Of all texels.
    weight: f32,
}

/// Another face, and the edge of it that something is about.
#[derive(Clone, Copy)]
struct Beside<'a> {
    number: u32,
    face: &'a Face,
    edge: u8,
}

impl<'a> Gathering<'a> {
    /// What lies beyond an edge.
    fn beyond(&self, face: &Face, edge: u8) -> Option<Beside<'a>> {
        let neighbor = face.neighbor(edge)?;
        Some(Beside {
            number: neighbor.face,
            face: self.file.face(neighbor.face)?,
            edge: neighbor.edge,
        })
    }

    /// Takes off what is beyond an edge, if anything; without a neighbor there it is put back.
    fn cut(&self, kernel: &mut Kernel, face: &Face, edge: u8, cuts: u8) -> Option<Kernel> {
        if !kernel.crosses(edge) {
            return None;
        }
        if cuts == MAX_CUTS || face.neighbor(edge).is_none() {
            kernel.merge(edge, self.file.borders);
            return None;
        }
        Some(kernel.split(edge))
    }

    /// Adds a kernel that may reach beyond the face's edges. First the pieces beyond left and right edges,
    /// less those beyond corners, which are gathered around these; then the pieces above and below.
    fn add_across(&mut self, mut kernel: Kernel, number: u32, face: &'a Face, cuts: u8) {
        for side in [RIGHT, LEFT] {
            let Some(mut beyond) = self.cut(&mut kernel, face, side, cuts) else {
                continue;
            };
            for end in [TOP, BOTTOM] {
                let Some(corner) = self.cut(&mut beyond, face, end, cuts) else {
                    continue;
                };
                // The edge that one crosses first, going clockwise around the corner.
                let first = match (side, end) {
                    (RIGHT, TOP) => TOP,
                    (RIGHT, _) => RIGHT,
                    (_, TOP) => LEFT,
                    _ => BOTTOM,
                };
                self.add_corner(corner, number, face, first, cuts);
            }
            self.add_beyond(beyond, number, face, side, cuts);
        }
        for end in [TOP, BOTTOM] {
            if let Some(beyond) = self.cut(&mut kernel, face, end, cuts) {
                self.add_beyond(beyond, number, face, end, cuts);
            }
        }
        self.add(kernel, face);
    }

    /// Adds a piece that was split off beyond an edge.
    fn add_beyond(&mut self, mut kernel: Kernel, number: u32, face: &Face, edge: u8, cuts: u8) {
        if kernel.is_empty() {
            return;
        }
        let Some(mut beside) = self.beyond(face, edge) else {
            self.weight -= kernel.weight();
            return;
        };
        let to_subface = beside.face.is_subface();
        let mut turn = edge + 2 + 4 - beside.edge;
        if to_subface && !face.is_subface() {
            if !kernel.enter_subface(edge) {
                // On to the second subface, clockwise.
                let across = (beside.edge + 3) & 3;
                let Some(second) = self.beyond(beside.face, across) else {
                    self.weight -= kernel.weight();
                    return;
                };
                turn += across + 2 + 4 - second.edge;
                beside = second;
            }
        } else if face.is_subface() && !to_subface {
            // A whole face refers to the first of two subfaces. From the second it is as from the first
            // beyond the next edge.
            let back = beside.face.neighbor(beside.edge);
            let is_first = back.is_some_and(|back| back.face == number);
            kernel.leave_subface(edge + 4 - u8::from(is_first));
        }
        kernel.rotate(turn & 3);
        self.add_turned(kernel, beside, to_subface, cuts);
    }

    /// Adds a kernel that counts from where `beside` is. On a subface it may have to be cut again.
    fn add_turned(&mut self, kernel: Kernel, beside: Beside<'a>, cut: bool, cuts: u8) {
        match cut && cuts < MAX_CUTS {
            true => self.add_across(kernel, beside.number, beside.face, cuts + 1),
            false => self.add(kernel, beside.face),
        }
    }

    /// Adds a piece beyond a corner. The faces around it are found clockwise, across `edge` first.
    fn add_corner(&mut self, mut kernel: Kernel, number: u32, face: &'a Face, edge: u8, cuts: u8) {
        if kernel.is_empty() {
            return;
        }
        let mut around: [Option<Beside>; MAX_AROUND] = [None; MAX_AROUND];
        let mut last = Beside { number, face, edge };
        let mut closed = None;
        for (i, place) in around.iter_mut().enumerate() {
            let next = self.beyond(last.face, last.edge).map(|mut next| {
                next.edge = (next.edge + 1) & 3;
                next
            });
            // The edge too: on a torus of one face all corners are the same face's.
            let next = match next {
                Some(next) if (next.number, next.edge) != (number, edge) => next,
                _ => {
                    closed = Some(i);
                    break;
                }
            };
            let back = next.face.neighbor(next.edge + 3);
            let from_first = back.is_some_and(|back| back.face == last.number);
            if last.face.is_subface() && !next.face.is_subface() && from_first {
                // The corner is in the middle of a whole face's edge: a single face is beyond it.
                let first = i == 1;
                kernel.leave_subface(edge + 2 * u8::from(first));
                kernel.rotate((edge + 4 - next.edge + 3 - u8::from(first)) & 3);
                self.add_turned(kernel, next, true, cuts);
                return;
            }
            *place = Some(next);
            last = next;
        }
        // Faces besides this one and its neighbors across both edges.
        let count = closed.map_or(0, |faces| faces.saturating_sub(2));
        let corners = around.iter().flatten().skip(1).take(count);
        match count {
            // Of three faces around a corner, and where it is on the border, none is beyond it.
            0 => self.weight -= kernel.weight(),
            1 => corners.for_each(|&beside| self.add_corner_face(kernel, face, edge, beside, cuts)),
            _ => {
                // All alike, and for each as much as the one would have got.
                kernel.rotate((edge + 2) & 3);
                let before = kernel.weight();
                let sum = Axis::make_equal(&mut kernel.u, &mut kernel.v);
                let scale = before / (sum * sum);
                if !scale.is_finite() {
                    self.weight -= before;
                    return;
                }
                kernel.u.scale(scale.min(1.0));
                self.weight += kernel.weight() * count as f32 - before;
                corners.for_each(|&beside| self.add_corner_face(kernel, face, TOP, beside, cuts));
            }
        }
    }

    /// Adds a piece to a face beyond a corner.
    fn add_corner_face(
        &mut self,
        mut kernel: Kernel,
        face: &Face,
        edge: u8,
        beside: Beside<'a>,
        cuts: u8,
    ) {
        let to_subface = beside.face.is_subface();
        if face.is_subface() != to_subface {
            if to_subface {
                kernel.enter_subface(edge + 3);
            } else {
                kernel.leave_subface(edge + 3);
            }
        }
        kernel.rotate((edge + 4 - beside.edge + 2) & 3);
        self.add_turned(kernel, beside, to_subface, cuts);
    }

    /// Adds texels of a face, as coarse as it has them.
    fn add(&mut self, mut kernel: Kernel, face: &Face) {
        if [BOTTOM, RIGHT, TOP, LEFT]
            .iter()
            .any(|&edge| kernel.crosses(edge))
        {
            // Only where neighbors do not fit together.
            let weight = kernel.weight();
            kernel.u.clip();
            kernel.v.clip();
            self.weight -= weight - kernel.weight();
        }
        if kernel.is_empty() {
            return;
        }
        if face.is_constant() {
            self.sum += kernel.weight() * sum::mean(self.file, face);
            return;
        }
        kernel.coarsen(face.resolution);
        let sum = sum::weighted(self.file, face, kernel.resolution(), &kernel);
        self.sum += match self.file.tangent_vectors {
            true => turned(sum, kernel.turns),
            false => sum,
        };
    }
}

/// A vector whose first two numbers are in a face's own (u, v), as the face that was asked for has it.
fn turned(sum: Rgb, turns: u8) -> Rgb {
    let [u, v, other] = sum.to_array();
    match turns {
        1 => Rgb::new(-v, u, other),
        2 => Rgb::new(-u, -v, other),
        3 => Rgb::new(v, -u, other),
        _ => sum,
    }
}
