//! An image's rays, made side by side in single precision: pupil sampled, traced, weighted and placed in the
//! scene, all in one [`Kernel`]. The bits of a ray do not depend on the others of its bundle, nor on the processor.

use super::Realistic;
use super::optics::{Optics, PupilTarget};
use crate::cameras::camera_transform::{BatchTransform, Lines};

use crate::cameras::{BUNDLE, CameraRay, CameraSample};
use crate::math::Vec3;
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::math::ray::{Ray, RayDifferentials};
use crate::optics::lanes::{LaneMask, Lanes};
use crate::optics::models::{LensModel, WeightedRays};
use crate::optics::pupil::ExitPupil;
use crate::optics::real::Number;
use crate::optics::trace::LensRay;
use arrayvec::ArrayVec;

/// Rays side by side where few of a bundle's samples have anything in common, being of different bands of the spectrum; and where
/// derivatives make every number three: 8 of those fill as many registers as there are.
pub(super) const FEW: usize = 8;

impl Realistic {
    /// Writes the rays for at most [`BUNDLE`] samples to the front of `rays`, side by side; `None` where they must be made one at
    /// a time.
    pub(super) fn rays_in_lanes(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut [Option<CameraRay>],
    ) -> Option<()> {
        let placing = self.placing.as_ref()?;
        rays[..samples.len()].fill(None);
        let mut maker = Maker {
            camera: self,
            placing,
            samples,
            rays,
        };
        for optics in self.bands.iter().chain([&self.main]) {
            let of_this = |i: &usize| std::ptr::eq(self.optics(&samples[*i]), optics);
            let chosen: ArrayVec<usize, BUNDLE> = (0..samples.len()).filter(of_this).collect();
            if want_differentials {
                for few in chosen.chunks(FEW) {
                    maker.make::<FEW, 2>(optics, few)?;
                }
            } else if self.disperses() {
                for few in chosen.chunks(FEW) {
                    maker.make::<FEW, 0>(optics, few)?;
                }
            } else {
                maker.make::<BUNDLE, 0>(optics, &chosen)?;
            }
        }
        Some(())
    }
}

/// Makes the rays of a bundle.
struct Maker<'a> {
    camera: &'a Realistic,
    placing: &'a BatchTransform,
    samples: &'a [CameraSample],
    rays: &'a mut [Option<CameraRay>],
}

impl Maker<'_> {
    /// The rays of the samples number `chosen`, at most N, through `optics`, with those of M neighboring pixels: none, or the
    /// next in x and in y. `None` unless `optics` aims at an exit pupil.
    fn make<const N: usize, const M: usize>(
        &mut self,
        optics: &Optics,
        chosen: &[usize],
    ) -> Option<()> {
        let PupilTarget::Pupil(pupil) = &optics.aim else {
            return None;
        };
        let mut film = [Lanes::splat(0.0); 2];
        let mut u = film;
        for (lane, i) in chosen.iter().take(N).enumerate() {
            let point = self.camera.film_point(self.samples[*i].raster);
            for axis in 0..2 {
                film[axis].0[lane] = point[axis] as f32;
                u[axis].0[lane] = self.samples[*i].lens[axis];
            }
        }
        let kernel = Rays::<N, M> {
            model: &optics.model,
            pupil,
            placing: *self.placing,
            film: &film,
            u: &u,
            shift: self.camera.per_pixel.map(|x| x as f32),
        };
        let made = vectorize::<N, _>(kernel);
        for (lane, i) in chosen.iter().take(N).enumerate() {
            if !made.passed.at(lane) {
                continue;
            }
            self.rays[*i] = Some(CameraRay {
                ray: Ray {
                    o: vector(&made.o, lane),
                    d: vector(&made.d, lane),
                    t_max: made.t_max.0[lane],
                    time: self.camera.spec.shutter.time(self.samples[*i].time),
                },
                weight: optics.weight_scale as f32 * made.projected_solid_angle.0[lane],
                tint: optics.band_tint,
                differentials: made.differentials(lane),
            });
        }
        Some(())
    }
}

fn vector<const N: usize>(lanes: &[Lanes<N>; 3], lane: usize) -> Vec3 {
    Vec3::from(lanes.each_ref().map(|x| x.0[lane]))
}

/// From film points and lens samples to rays in render space, and to those of M neighboring pixels.
struct Rays<'a, const N: usize, const M: usize> {
    model: &'a LensModel,
    pupil: &'a ExitPupil,
    placing: BatchTransform,
    film: &'a [Lanes<N>; 2],
    u: &'a [Lanes<N>; 2],
    /// Change of the film point per pixel in x and in y, mm.
    shift: [f32; 2],
}

/// Rays in render space, cut to what lies between the clip planes.
struct Placed<const N: usize, const M: usize> {
    o: [Lanes<N>; 3],
    d: [Lanes<N>; 3],
    t_max: Lanes<N>,
    /// Origin and direction of the rays one pixel on in x and y.
    shifted: [Lines<N>; M],
    projected_solid_angle: Lanes<N>,
    passed: LaneMask<N>,
}

impl<const N: usize, const M: usize> Kernel for Rays<'_, N, M> {
    type Output = Placed<N, M>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Placed<N, M> {
        if M == 0 {
            let made = self.model.rays(self.pupil, self.film, self.u);
            let ray = made.traced.ray;
            return self.placed(&made, &ray, |_| ray);
        }
        let made = self
            .model
            .rays_with_derivatives(self.pupil, self.film, self.u);
        let dual = made.traced.ray;
        self.placed(&made, &dual.map(|x| x.value), |axis| {
            // To first order.
            let shift = Lanes::splat(self.shift[axis]);
            dual.map(|x| x.value + x.by[axis] * shift)
        })
    }
}

impl<const N: usize, const M: usize> Rays<'_, N, M> {
    /// `made` in render space, whose values are `ray`, with the rays `shifted` in x and y.
    #[inline(always)]
    fn placed<T: Number<Mask = LaneMask<N>>>(
        &self,
        made: &WeightedRays<T, N>,
        ray: &LensRay<Lanes<N>>,
        shifted: impl Fn(usize) -> LensRay<Lanes<N>>,
    ) -> Placed<N, M> {
        let (o, d, t_max) = self.placing.ray(ray);
        Placed {
            o,
            d,
            t_max,
            shifted: std::array::from_fn(|axis| self.placing.unclipped(&shifted(axis))),
            projected_solid_angle: made.projected_solid_angle,
            passed: made.traced.passed,
        }
    }
}

impl<const N: usize, const M: usize> Placed<N, M> {
    /// `None` without neighbors, and on the very edge of total reflection, where a derivative is infinite.
    fn differentials(&self, lane: usize) -> Option<RayDifferentials> {
        let [[rx_o, rx_d], [ry_o, ry_d]] = self
            .shifted
            .first_chunk()?
            .each_ref()
            .map(|ray| ray.each_ref().map(|v| vector(v, lane)));
        let finite = [rx_o, rx_d, ry_o, ry_d].iter().all(|v| v.is_finite());
        finite.then_some(RayDifferentials {
            rx_o,
            rx_d,
            ry_o,
            ry_d,
        })
    }
}
