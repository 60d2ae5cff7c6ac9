//! Vertices side by side, on surfaces that scatter by the same kind of BSDF.

use crate::accel::{FlatHits, SmoothHits};
use crate::bsdf::{Coated, CoatedLobes, Matte, Scatterer, ScattererRows};
use crate::integrators::context::WAVE;
use crate::integrators::vertex::LeanVertex;
use crate::math::color::is_black;
use crate::math::float::offset_ray_origin;
use crate::math::frame::Frame;
#[cfg(test)]
use crate::math::instruction_set::InstructionSet;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::rows::Rows3;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::{ReferencePoint, SurfaceHit};
use arrayvec::ArrayVec;

/// Up to `N` of them. Those on flat matte or smooth coated triangles come first.
pub(super) struct Vertices<S: Scatterer, const N: usize> {
    paths: ArrayVec<u32, N>,
    throughput: Rows3<N>,
    p: Rows3<N>,
    p_error: Rows3<N>,
    scatterers: S::Rows<N>,
    /// The axes of the shading frame along the surface.
    s: Rows3<N>,
    t: Rows3<N>,
    u: [[f32; N]; 2],
    next: NextRows<N>,
}

/// How a path continues.
pub(super) struct Next {
    pub throughput: Rgb,
    pub o: Vec3,
    pub d: Vec3,
    /// Of the direction, per steradian.
    pub pdf: f32,
}

struct NextRows<const N: usize> {
    throughput: Rows3<N>,
    /// What the sampled directions multiply it by.
    weight: Rows3<N>,
    o: Rows3<N>,
    d: Rows3<N>,
    pdf: [f32; N],
    goes_on: [u32; N],
}

impl<S: Scatterer, const N: usize> Default for Vertices<S, N> {
    fn default() -> Self {
        Vertices {
            paths: ArrayVec::new(),
            throughput: Rows3::default(),
            p: Rows3::default(),
            p_error: Rows3::default(),
            scatterers: Default::default(),
            s: Rows3::default(),
            t: Rows3::default(),
            u: [[0.0; N]; 2],
            next: NextRows {
                throughput: Rows3::default(),
                weight: Rows3::default(),
                o: Rows3::default(),
                d: Rows3::default(),
                pdf: [0.0; N],
                goes_on: [0; N],
            },
        }
    }
}

impl<S: Scatterer, const N: usize> Vertices<S, N> {
    pub(super) fn clear(&mut self) {
        self.paths.clear();
    }

    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.paths.len()
    }

    /// The path that vertex `i` is of.
    #[inline(always)]
    pub(super) fn path(&self, i: usize) -> usize {
        self.paths[i] as usize
    }

    /// Adds one, all else of which is set later: its number.
    #[inline(always)]
    fn push(&mut self, path: u32, throughput: Rgb) -> usize {
        let i = self.count();
        self.paths.push(path);
        self.throughput.set(i, throughput);
        i
    }

    /// Adds one on any surface.
    pub(super) fn add(
        &mut self,
        path: u32,
        surface: &SurfaceHit,
        (scatterer, frame): (&S, &Frame),
        throughput: Rgb,
    ) {
        let i = self.push(path, throughput);
        self.p.set(i, surface.p);
        self.p_error.set(i, surface.p_error);
        self.s.set(i, frame.s);
        self.t.set(i, frame.t);
        self.scatterers.set(i, scatterer);
    }

    /// The same with these instructions.
    #[cfg(test)]
    pub(super) fn sample_with(&mut self, set: InstructionSet) {
        let count = self.count();
        set.run(Sample {
            vertices: self,
            count,
        });
    }

    /// The point that receives light.
    #[inline(always)]
    pub(super) fn from(&self, i: usize, time: f32) -> ReferencePoint {
        let scatterer = self.scatterers.get(i);
        ReferencePoint {
            p: self.p.get(i),
            p_error: self.p_error.get(i),
            n: scatterer.geometric_normal(),
            shading_n: self.turned_normal(i),
            time,
            receiver_side: scatterer.receiver_side(),
        }
    }

    /// Where vertex `i` is.
    #[inline(always)]
    pub(super) fn p(&self, i: usize) -> Vec3 {
        self.p.get(i)
    }

    /// Its shading normal, turned to where its ray came from.
    #[inline(always)]
    pub(super) fn turned_normal(&self, i: usize) -> Vec3 {
        self.scatterers.turned_normal(i)
    }

    /// Vertex `i`.
    #[inline(always)]
    pub(super) fn vertex(&self, i: usize, time: f32) -> LeanVertex<S> {
        LeanVertex {
            from: self.from(i, time),
            scatterer: self.scatterers.get(i),
        }
    }

    /// Sets the numbers that choose a point of a light, or a direction.
    #[inline(always)]
    pub(super) fn set_number(&mut self, i: usize, u: Vec2) {
        (self.u[0][i], self.u[1][i]) = (u.x, u.y);
    }

    /// The 2-D sample that [`Vertices::set_number`] has set.
    #[inline(always)]
    pub(super) fn number(&self, i: usize) -> Vec2 {
        Vec2::new(self.u[0][i], self.u[1][i])
    }

    /// Chooses directions.
    pub(super) fn sample(&mut self) {
        let count = self.count();
        vectorize::<N, _>(Sample {
            vertices: self,
            count,
        });
    }

    /// How the path continues, if it does.
    #[inline(always)]
    pub(super) fn next(&self, i: usize) -> Option<Next> {
        let next = &self.next;
        (next.goes_on[i] != 0).then(|| Next {
            throughput: next.throughput.get(i),
            o: next.o.get(i),
            d: next.d.get(i),
            pdf: next.pdf[i],
        })
    }

    /// What the direction in which the path continues multiplies its throughput by, if it does.
    #[inline(always)]
    pub(super) fn weight(&self, i: usize) -> Option<Rgb> {
        (self.next.goes_on[i] != 0).then(|| self.next.weight.get(i))
    }

    /// The steps of BSDF sampling at a single vertex of a path, and what follows.
    #[inline(always)]
    fn sample_at(&mut self, i: usize) {
        let scatterer = self.scatterers.get(i);
        let u = Vec2::new(self.u[0][i], self.u[1][i]);
        let (sample, is_lit) = scatterer.sample(self.s.get(i), self.t.get(i), u);
        let weight = scatterer.weight(&sample);
        let throughput = self.throughput.get(i) * weight;
        let ng = scatterer.geometric_normal();
        let o = offset_ray_origin(self.p.get(i), self.p_error.get(i), ng, sample.wi);
        let [x, y, z] = [throughput.x, throughput.y, throughput.z];
        let is_finite = x.is_finite() & y.is_finite() & z.is_finite();
        let next = &mut self.next;
        next.throughput.set(i, throughput);
        next.weight.set(i, weight);
        next.o.set(i, o);
        next.d.set(i, sample.wi);
        next.pdf[i] = sample.pdf;
        next.goes_on[i] = (is_lit & !is_black(throughput) & is_finite).into();
    }
}

/// What light is sampled with, wherever it is kept.
pub(super) struct VertexRows<'a, S: Scatterer> {
    pub pmf: &'a [f32; WAVE],
    pub u: &'a [[f32; WAVE]; 2],
    pub p: &'a Rows3<WAVE>,
    pub p_error: &'a Rows3<WAVE>,
    pub scatterers: &'a S::Rows<WAVE>,
    pub throughput: &'a Rows3<WAVE>,
}

/// The probability of a light that is sampled at all vertices.
static CERTAIN: [f32; WAVE] = [1.0; WAVE];

impl<S: Scatterer> Vertices<S, WAVE> {
    /// Where a light is sampled at the points that their numbers choose.
    pub(super) fn rows(&self) -> VertexRows<'_, S> {
        VertexRows {
            pmf: &CERTAIN,
            u: &self.u,
            p: &self.p,
            p_error: &self.p_error,
            scatterers: &self.scatterers,
            throughput: &self.throughput,
        }
    }
}

impl<const N: usize> Vertices<Matte, N> {
    /// Adds one on a flat triangle, which is [placed](Vertices::place) later.
    #[inline(always)]
    pub(super) fn add_flat(&mut self, path: u32, reflectance: Rgb, throughput: Rgb) {
        let i = self.push(path, throughput);
        self.scatterers.set_reflectance(i, reflectance);
    }

    /// Places all that there are where flat triangles are hit.
    pub(super) fn place(&mut self, hits: &FlatHits<N>) {
        let count = self.count();
        vectorize::<N, _>(Place {
            vertices: self,
            hits,
            count,
        });
    }

    /// The same with these instructions.
    #[cfg(test)]
    pub(super) fn place_with(&mut self, set: InstructionSet, hits: &FlatHits<N>) {
        let count = self.count();
        set.run(Place {
            vertices: self,
            hits,
            count,
        });
    }

    /// Places one where a surface is hit.
    pub(super) fn place_alone(&mut self, i: usize, surface: &SurfaceHit) {
        let point = (surface.p, surface.p_error, surface.n);
        self.place_at(i, point, surface.wo);
    }

    #[inline(always)]
    fn place_at(&mut self, i: usize, (p, p_error, n): (Vec3, Vec3, Vec3), wo: Vec3) {
        let frame = Frame::from_normal(n);
        self.p.set(i, p);
        self.p_error.set(i, p_error);
        self.s.set(i, frame.s);
        self.t.set(i, frame.t);
        let matte = Matte::new(self.scatterers.reflectance(i), n, n, wo);
        self.scatterers.set(i, &matte);
    }

    /// Of a vertex on a flat triangle.
    #[inline(always)]
    pub(super) fn reflectance(&self, i: usize) -> Rgb {
        self.scatterers.reflectance(i)
    }
}

impl<const N: usize> Vertices<Coated, N> {
    /// Adds one on a smooth triangle, which is [placed](Vertices::place_smooth) later.
    #[inline(always)]
    pub(super) fn add_smooth(&mut self, path: u32, lobes: &CoatedLobes, throughput: Rgb) {
        let i = self.push(path, throughput);
        self.scatterers.set_lobes(i, lobes);
    }

    /// Places all that there are where smooth triangles are hit.
    pub(super) fn place_smooth(&mut self, hits: &SmoothHits<N>) {
        let count = self.count();
        vectorize::<N, _>(PlaceSmooth {
            vertices: self,
            hits,
            count,
        });
    }

    /// The same with these instructions.
    #[cfg(test)]
    pub(super) fn place_smooth_with(&mut self, set: InstructionSet, hits: &SmoothHits<N>) {
        let count = self.count();
        set.run(PlaceSmooth {
            vertices: self,
            hits,
            count,
        });
    }

    /// Adds one on any surface; [`Vertices::finish`] makes it whole.
    pub(super) fn begin(
        &mut self,
        path: u32,
        surface: &SurfaceHit,
        (lobes, frame): (&CoatedLobes, &Frame),
        throughput: Rgb,
    ) {
        let i = self.push(path, throughput);
        self.p.set(i, surface.p);
        self.p_error.set(i, surface.p_error);
        self.scatterers.set_lobes(i, lobes);
        self.scatterers.place(i, surface.n, frame, surface.wo);
    }

    /// The same as [`Vertices::finish`] with these instructions.
    #[cfg(test)]
    pub(super) fn finish_with(&mut self, set: InstructionSet) {
        let count = self.count();
        set.run(Finish {
            vertices: self,
            count,
        });
    }

    /// Computes what depends on the outgoing directions.
    pub(super) fn finish(&mut self) {
        let count = self.count();
        vectorize::<N, _>(Finish {
            vertices: self,
            count,
        });
    }
}

/// The loop that places vertices on smooth triangles.
struct PlaceSmooth<'a, const N: usize> {
    vertices: &'a mut Vertices<Coated, N>,
    hits: &'a SmoothHits<N>,
    count: usize,
}

impl<const N: usize> Kernel for PlaceSmooth<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            let point = self.hits.point(i);
            let frame = Frame::from_normal(point.shading_n);
            self.vertices.p.set(i, point.p);
            self.vertices.p_error.set(i, point.p_error);
            let scatterers = &mut self.vertices.scatterers;
            scatterers.place(i, point.n, &frame, point.wo);
        }
    }
}

/// The loop that finishes vertices.
struct Finish<'a, const N: usize> {
    vertices: &'a mut Vertices<Coated, N>,
    count: usize,
}

impl<const N: usize> Kernel for Finish<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            self.vertices.scatterers.finish(i);
        }
    }
}

/// The loop that places vertices.
struct Place<'a, const N: usize> {
    vertices: &'a mut Vertices<Matte, N>,
    hits: &'a FlatHits<N>,
    count: usize,
}

impl<const N: usize> Kernel for Place<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            let (point, wo) = self.hits.point(i);
            self.vertices.place_at(i, point, wo);
        }
    }
}

/// The loop that chooses directions.
struct Sample<'a, S: Scatterer, const N: usize> {
    vertices: &'a mut Vertices<S, N>,
    count: usize,
}

impl<S: Scatterer, const N: usize> Kernel for Sample<'_, S, N> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        for i in 0..self.count.next_multiple_of(WIDEST).min(N) {
            self.vertices.sample_at(i);
        }
    }
}
