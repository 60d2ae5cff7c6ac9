//! An image's rays, made side by side in single precision: pupil sampled, traced, weighted and placed in the
//! scene, all in one [`Kernel`]. The bits of a ray do not depend on the others of its bundle, nor on the processor.

use super::Realistic;
use super::optics::{Optics, PupilTarget};
use crate::cameras::camera_transform::BatchTransform;

use crate::cameras::{BUNDLE, CameraRay, CameraSample};
use crate::math::Vec3;
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::math::ray::{Ray, RayDifferentials};
use crate::optics::lanes::{LaneMask, Lanes};
use crate::optics::models::{LensModel, WeightedRays};
use crate::optics::pupil::ExitPupil;
use crate::optics::real::{Dual, Number};
use crate::optics::trace::LensRay;
use arrayvec::ArrayVec;

/// Rays side by side where few of a bundle's samples have anything in common, being of different bands of the spectrum; and where
/// derivatives make every number three: 8 of those fill as many registers as there are.
const FEW: usize = 8;

impl Realistic {
    /// The rays for `samples`, side by side; `None` where they must be made one at a time.
    pub(super) fn rays_in_lanes(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
    ) -> Option<ArrayVec<Option<CameraRay>, BUNDLE>> {
        let placing = self.placing.as_ref()?;
        let samples = &samples[..samples.len().min(BUNDLE)];
        let mut rays = ArrayVec::new();
        rays.extend(samples.iter().map(|_| None));
        let mut maker = Maker {
            camera: self,
            placing,
            samples,
            rays: &mut rays,
        };
        for optics in self.bands.iter().chain([&self.main]) {
            let of_this = |i: &usize| std::ptr::eq(self.optics(&samples[*i]), optics);
            let chosen: ArrayVec<usize, BUNDLE> = (0..samples.len()).filter(of_this).collect();
            if want_differentials {
                for few in chosen.chunks(FEW) {
                    maker.make_with_differentials(optics, few)?;
                }
            } else if self.disperses() {
                for few in chosen.chunks(FEW) {
                    maker.make::<FEW>(optics, few)?;
                }
            } else {
                maker.make::<BUNDLE>(optics, &chosen)?;
            }
        }
        Some(rays)
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
    /// The rays of the samples number `chosen`, at most N, through `optics`. `None` unless those aim at an exit pupil.
    fn make<const N: usize>(&mut self, optics: &Optics, chosen: &[usize]) -> Option<()> {
        let (film, u) = self.bundle::<N>(chosen);
        let made = vectorize(N, self.kernel(optics, &film, &u)?);
        self.finish(optics, chosen, &made, |_| None);
        Some(())
    }

    /// The same with differentials.
    fn make_with_differentials(&mut self, optics: &Optics, chosen: &[usize]) -> Option<()> {
        let (film, u) = self.bundle::<FEW>(chosen);
        let kernel = RaysWithDifferentials {
            rays: self.kernel(optics, &film, &u)?,
            shift: self.camera.per_pixel.map(|x| x as f32),
        };
        let made = vectorize(FEW, kernel);
        self.finish(optics, chosen, &made.rays, |lane| made.differentials(lane));
        Some(())
    }

    /// Film points and lens samples of the chosen samples.
    fn bundle<const N: usize>(&self, chosen: &[usize]) -> ([Lanes<N>; 2], [Lanes<N>; 2]) {
        let mut film = [Lanes::splat(0.0); 2];
        let mut u = film;
        for (lane, i) in chosen.iter().take(N).enumerate() {
            let point = self.camera.film_point(self.samples[*i].raster);
            for axis in 0..2 {
                film[axis].0[lane] = point[axis] as f32;
                u[axis].0[lane] = self.samples[*i].lens[axis];
            }
        }
        (film, u)
    }

    fn kernel<'b, const N: usize>(
        &self,
        optics: &'b Optics,
        film: &'b [Lanes<N>; 2],
        u: &'b [Lanes<N>; 2],
    ) -> Option<Rays<'b, N>> {
        let PupilTarget::Pupil(pupil) = &optics.aim else {
            return None;
        };
        Some(Rays {
            model: &optics.model,
            pupil,
            placing: *self.placing,
            film,
            u,
        })
    }

    fn finish<const N: usize>(
        &mut self,
        optics: &Optics,
        chosen: &[usize],
        made: &Placed<N>,
        differentials: impl Fn(usize) -> Option<RayDifferentials>,
    ) {
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
                tint: optics.tint,
                differentials: differentials(lane),
            });
        }
    }
}

fn vector<const N: usize>(lanes: &[Lanes<N>; 3], lane: usize) -> Vec3 {
    Vec3::from(lanes.each_ref().map(|x| x.0[lane]))
}

/// From film points and lens samples to rays in render space.
struct Rays<'a, const N: usize> {
    model: &'a LensModel,
    pupil: &'a ExitPupil,
    placing: BatchTransform,
    film: &'a [Lanes<N>; 2],
    u: &'a [Lanes<N>; 2],
}

/// Rays in render space, cut to what lies between the clip planes.
struct Placed<const N: usize> {
    o: [Lanes<N>; 3],
    d: [Lanes<N>; 3],
    t_max: Lanes<N>,
    projected_solid_angle: Lanes<N>,
    passed: LaneMask<N>,
}

impl<const N: usize> Kernel for Rays<'_, N> {
    type Output = Placed<N>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Placed<N> {
        let made = self.model.rays(self.pupil, self.film, self.u);
        Placed::new(&self.placing, &made.traced.ray, &made)
    }
}

impl<const N: usize> Placed<N> {
    /// `ray`, one of `made` or its value.
    #[inline(always)]
    fn new<T: Number<Mask = LaneMask<N>>>(
        placing: &BatchTransform,
        ray: &LensRay<Lanes<N>>,
        made: &WeightedRays<T, N>,
    ) -> Placed<N> {
        let (o, d, t_max) = placing.ray(ray);
        Placed {
            o,
            d,
            t_max,
            projected_solid_angle: made.projected_solid_angle,
            passed: made.traced.passed,
        }
    }
}

/// The same with the rays one pixel on.
struct RaysWithDifferentials<'a, const N: usize> {
    rays: Rays<'a, N>,
    /// Change of the film point per pixel in x and in y, mm.
    shift: [f32; 2],
}

/// Rays and those one pixel on in x and y: origin and direction.
struct PlacedWithDifferentials<const N: usize> {
    rays: Placed<N>,
    shifted: [[[Lanes<N>; 3]; 2]; 2],
}

impl<const N: usize> PlacedWithDifferentials<N> {
    /// `None` on the very edge of total reflection, where a derivative is infinite.
    fn differentials(&self, lane: usize) -> Option<RayDifferentials> {
        let [[rx_o, rx_d], [ry_o, ry_d]] = self
            .shifted
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

impl<const N: usize> Kernel for RaysWithDifferentials<'_, N> {
    type Output = PlacedWithDifferentials<N>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> PlacedWithDifferentials<N> {
        let Rays { model, placing, .. } = self.rays;
        let made = model.rays_with_derivatives(self.rays.pupil, self.rays.film, self.rays.u);
        let LensRay { o, d } = &made.traced.ray;
        let value = |x: &Dual<Lanes<N>>| x.value;
        let ray = LensRay {
            o: o.each_ref().map(value),
            d: d.each_ref().map(value),
        };
        let shifted = [0, 1].map(|axis| {
            // To first order.
            let shift = Lanes::splat(self.shift[axis]);
            let shifted = |x: &Dual<Lanes<N>>| x.value + x.by[axis] * shift;
            placing.unclipped(&LensRay {
                o: o.each_ref().map(shifted),
                d: d.each_ref().map(shifted),
            })
        });
        PlacedWithDifferentials {
            rays: Placed::new(&placing, &ray, &made),
            shifted,
        }
    }
}
