//! Vectors side by side: a row for each coordinate, so that a loop over them is compiled to vector instructions
//! ([`super::instruction_set`]).

use super::Vec3;

/// `N` vectors.
#[derive(Clone, Debug)]
pub(crate) struct Rows3<const N: usize>([[f32; N]; 3]);

impl<const N: usize> Default for Rows3<N> {
    fn default() -> Self {
        Rows3([[0.0; N]; 3])
    }
}

impl<const N: usize> Rows3<N> {
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, v: Vec3) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (v.x, v.y, v.z);
    }
}
