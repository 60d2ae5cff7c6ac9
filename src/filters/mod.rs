//! Pixel reconstruction filters, sampled by importance.
//!
//! A pixel's value is the mean of (filter × radiance) around its center. Instead of splatting each
//! sample onto all pixels near it, as pbrt-v3's film does, every pixel places its own samples with
//! a density proportional to |filter| and gives each the weight sign · ∫|f| / ∫f (Ernst,
//! Stamminger and Greiner, "Filter Importance Sampling", 2006). The expectation is the same, and
//! pixels stay independent of each other.
//!
//! As in pbrt-v3 a filter is the product of two one-dimensional ones, each replaced by 16 constant
//! pieces from the center to its edge (docs/scene-language.md §3.3). Widths are *half* widths, in pixels.

mod axis;
mod box_filter;
mod gaussian;
mod mitchell;
mod radius;
mod sinc;
mod triangle;

pub use box_filter::BoxFilter;
pub use gaussian::GaussianFilter;
pub use mitchell::MitchellFilter;
pub use sinc::SincFilter;
pub use triangle::TriangleFilter;

use crate::math::{DVec2, Vec2};
use crate::params::ParamReader;
use axis::Axis;

macro_rules! filter_types {
    ($($name:literal => $Variant:ident($Type:ident),)*) => {
        /// The type names a scene may give, for "did you mean".
        pub const FILTER_NAMES: &[&str] = &[$($name,)*];

        /// A filter's shape, before it is prepared for sampling.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum FilterShape {
            $(#[doc = concat!("`", $name, "`")] $Variant($Type),)*
        }

        impl FilterShape {
            /// Half widths in pixels.
            pub fn radius(&self) -> DVec2 {
                match self {
                    $(FilterShape::$Variant(f) => f.radius,)*
                }
            }

            /// One factor of the separable filter, `distance` ≥ 0 pixels from the center along an axis
            /// whose half width is `radius`; not normalized.
            pub fn factor(&self, distance: f64, radius: f64) -> f64 {
                match self {
                    $(FilterShape::$Variant(f) => f.factor(distance, radius),)*
                }
            }

            fn from_params(reader: &ParamReader) -> FilterShape {
                match reader.kind() {
                    $($name => FilterShape::$Variant($Type::from_params(reader)),)*
                    _ => {
                        reader.unknown_kind(FILTER_NAMES);
                        FilterShape::Box(BoxFilter::default())
                    }
                }
            }
        }
    };
}

// A new type: its file, which gives `radius`, `factor` and `from_params`, and a line here.
filter_types! {
    "box" => Box(BoxFilter),
    "gaussian" => Gaussian(GaussianFilter),
    "mitchell" => Mitchell(MitchellFilter),
    "sinc" => Sinc(SincFilter),
    "triangle" => Triangle(TriangleFilter),
}

/// Where a sample lies, and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// Pixels from the pixel's center: x right, y down, each in [−radius, radius).
    pub offset: Vec2,
    /// Factor of the sample's radiance; 1 in the mean, negative where the filter is.
    pub weight: f32,
}

/// A filter prepared for sampling.
#[derive(Clone, Debug)]
pub struct Filter {
    shape: FilterShape,
    x: Axis,
    y: Axis,
}

impl Default for Filter {
    /// pbrt's default: the box of one pixel.
    fn default() -> Filter {
        let shape = FilterShape::Box(BoxFilter::default());
        Filter {
            shape,
            x: Axis::uniform(0.5),
            y: Axis::uniform(0.5),
        }
    }
}

impl Filter {
    /// Reads a `PixelFilter`. An unknown type, or one that integrates to zero, is reported as an error and replaced by
    /// the default box.
    pub fn from_params(reader: &ParamReader) -> Filter {
        let shape = FilterShape::from_params(reader);
        Filter::new(shape).unwrap_or_else(|| {
            reader.error("", "this filter integrates to zero; using \"box\"");
            Filter::default()
        })
    }

    /// Prepares `shape` for sampling; `None` where its integral is not finite or nearly zero relative to that of its
    /// magnitude.
    pub fn new(shape: FilterShape) -> Option<Filter> {
        let radius = shape.radius();
        let axis = |r: f64| Axis::continuous(r, |distance| shape.factor(distance, r));
        Some(Filter {
            shape,
            x: axis(radius.x)?,
            y: axis(radius.y)?,
        })
    }

    /// The filter for samples that may lie only at pixel centers (halton's `samplepixelcenter`):
    /// a pixel then averages the centers of the pixels around it.
    pub fn at_pixel_centers(&self) -> Filter {
        let radius = self.shape.radius();
        let axis = |r: f64| {
            // Whatever cannot be normalized falls back to the pixel's own center.
            Axis::integers(r, |distance| self.shape.factor(distance, r))
                .unwrap_or_else(|| Axis::uniform(0.0))
        };
        Filter {
            shape: self.shape,
            x: axis(radius.x),
            y: axis(radius.y),
        }
    }

    /// Half widths in pixels.
    pub fn radius(&self) -> Vec2 {
        self.shape.radius().as_vec2()
    }

    /// The shape this filter was made from.
    pub fn shape(&self) -> &FilterShape {
        &self.shape
    }

    /// Density per squared pixel with which [`Filter::sample`] chooses this offset, and the weight that it gives; both 0
    /// beyond the radius. Their product is the filter, normalized.
    pub fn at(&self, offset: Vec2) -> (f32, f32) {
        let ((x, weight_x), (y, weight_y)) = (self.x.at(offset.x), self.y.at(offset.y));
        (x * y, weight_x * weight_y)
    }

    /// Returns `true` if samples may lie anywhere within the radius, so that [`Filter::at`] means something.
    pub fn is_continuous(&self) -> bool {
        self.x.is_continuous() && self.y.is_continuous()
    }

    /// The film position for `u` in [0, 1)². Continuous in `u` and increasing along each axis, so
    /// that stratified samples give stratified positions.
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let (x, weight_x) = self.x.sample(u.x);
        let (y, weight_y) = self.y.sample(u.y);
        FilterSample {
            offset: Vec2::new(x, y),
            weight: weight_x * weight_y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::UVec2;

    fn all() -> Vec<FilterShape> {
        vec![
            FilterShape::Box(BoxFilter::default()),
            FilterShape::Box(BoxFilter {
                radius: DVec2::new(1.0, 3.0),
            }),
            FilterShape::Triangle(TriangleFilter::default()),
            FilterShape::Gaussian(GaussianFilter::default()),
            FilterShape::Gaussian(GaussianFilter {
                radius: DVec2::new(1.0, 1.5),
                alpha: 0.5,
            }),
            FilterShape::Mitchell(MitchellFilter::default()),
            FilterShape::Mitchell(MitchellFilter {
                radius: DVec2::splat(2.0),
                b: 0.0,
                c: 0.5,
            }),
            FilterShape::Sinc(SincFilter::default()),
            FilterShape::Sinc(SincFilter {
                radius: DVec2::splat(3.0),
                ..SincFilter::default()
            }),
        ]
    }

    /// pbrt's table: the entry that serves a point `x` pixels from the center.
    fn table(shape: &FilterShape, x: f64, r: f64) -> f64 {
        let i = ((16.0 * x.abs() / r) as usize).min(15);
        shape.factor((i as f64 + 0.5) * r / 16.0, r)
    }

    #[test]
    fn samples_integrate_like_the_table() {
        // Test functions whose filtered value is known from the table by summation.
        let tests: [fn(f64) -> f64; 4] = [|_| 1.0, |x| x, |x| x * x, |x| (2.0 * x).cos()];
        for shape in all() {
            let filter = Filter::new(shape).unwrap();
            let r = shape.radius().x;
            for g in tests {
                let (mut weighted, mut total) = (0.0, 0.0);
                let n = 1 << 14;
                for i in 0..n {
                    let x = (2.0 * (i as f64 + 0.5) / n as f64 - 1.0) * r;
                    weighted += table(&shape, x, r) * g(x);
                    total += table(&shape, x, r);
                }
                let expected = weighted / total;
                let mean = (0..n)
                    .map(|i| filter.x.sample((i as f32 + 0.5) / n as f32))
                    .map(|(offset, weight)| f64::from(weight) * g(f64::from(offset)))
                    .sum::<f64>()
                    / n as f64;
                // Midpoint sums over 2¹⁴ points, up to 32 jumps misplaced by at most one point.
                assert!(
                    (mean - expected).abs() < 5e-3 * (1.0 + expected.abs()),
                    "{shape:?}: {mean} but {expected}"
                );
            }
        }
    }

    #[test]
    fn samples_have_the_density_and_weight_of_their_offset() {
        for shape in all() {
            let filter = Filter::new(shape).unwrap();
            let radius = filter.radius();
            // A histogram of 8 × 8 cells of the filter's square, each of a few of its pieces, and the integral of the density.
            let (n, cells) = (512, 8.0);
            let mut counts = [0.0f64; 64];
            let mut integral = [0.0f64; 64];
            for i in 0..n * n {
                let u = (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
                let sample = filter.sample(u);
                let (density, weight) = filter.at(sample.offset);
                assert!(
                    density > 0.0 && weight == sample.weight,
                    "{shape:?} at {}",
                    sample.offset
                );
                let cell = |at: Vec2| {
                    let at = ((at / radius * 0.5 + 0.5) * cells)
                        .as_uvec2()
                        .min(UVec2::splat(7));
                    (at.y * 8 + at.x) as usize
                };
                counts[cell(sample.offset)] += 1.0 / f64::from(n * n);
                let even = (2.0 * u - 1.0) * radius;
                let area = 4.0 * radius.x * radius.y / (n * n) as f32;
                integral[cell(even)] += f64::from(filter.at(even).0 * area);
            }
            // A row of the grid more or less on each side of a cell.
            for (count, integral) in counts.iter().zip(&integral) {
                assert!(
                    (count - integral).abs() < 4.0 / 512.0 / 8.0 * 8.0,
                    "{shape:?}: {count} {integral}"
                );
            }
            let (density, weight) = filter.at(radius * 1.001);
            assert_eq!((density, weight), (0.0, 0.0));
        }
        let centers = Filter::default().at_pixel_centers();
        assert!(!centers.is_continuous() && Filter::default().is_continuous());
    }

    #[test]
    fn weights_have_mean_one_in_two_dimensions() {
        for shape in all() {
            let filter = Filter::new(shape).unwrap();
            let n = 512;
            let at = |i: usize| (i as f32 + 0.5) / n as f32;
            let sum: f64 = (0..n * n)
                .map(|i| filter.sample(Vec2::new(at(i % n), at(i / n))).weight as f64)
                .sum();
            // Each sign change of each axis may be misplaced by one of 512 points.
            assert!((sum / (n * n) as f64 - 1.0).abs() < 0.05, "{shape:?}");
        }
    }

    #[test]
    fn positive_filters_weigh_every_sample_the_same() {
        for shape in all().into_iter().take(5) {
            let filter = Filter::new(shape).unwrap();
            for i in 0..64 {
                let u = Vec2::new(i as f32 / 64.0, (i * 5 % 64) as f32 / 64.0);
                assert_eq!(filter.sample(u).weight, 1.0);
            }
        }
    }

    #[test]
    fn offsets_increase_and_stay_inside() {
        for shape in all() {
            let filter = Filter::new(shape).unwrap();
            let r = filter.radius();
            let mut last = -r;
            for i in 0..1000 {
                let o = filter.sample(Vec2::splat(i as f32 / 1000.0)).offset;
                assert!(
                    o.cmpge(last).all() && o.cmpge(-r).all() && o.cmplt(r).all(),
                    "{shape:?}"
                );
                last = o;
            }
            let end = filter.sample(Vec2::splat(1.0 - f32::EPSILON / 2.0)).offset;
            assert!(end.cmple(r).all() && end.cmpge(last).all());
        }
    }

    #[test]
    fn the_default_box_is_the_pixel() {
        let s = Filter::default().sample(Vec2::new(0.25, 0.75));
        assert_eq!(
            s,
            FilterSample {
                offset: Vec2::new(-0.25, 0.25),
                weight: 1.0
            }
        );
    }

    #[test]
    fn pixel_centers_average_whole_pixels() {
        let filter = Filter::default().at_pixel_centers();
        assert_eq!(
            filter.sample(Vec2::new(0.1, 0.9)),
            FilterSample {
                offset: Vec2::ZERO,
                weight: 1.0
            }
        );

        let shape = FilterShape::Triangle(TriangleFilter {
            radius: DVec2::splat(1.5),
        });
        let filter = Filter::new(shape).unwrap().at_pixel_centers();
        let n = 3000;
        let mut counts = [0usize; 3];
        for i in 0..n {
            let s = filter.sample(Vec2::new((i as f32 + 0.5) / n as f32, 0.5));
            counts[(s.offset.x + 1.0) as usize] += 1;
        }
        // Table entries for distances 0 and 1: 1.5 − 0.5·1.5/16 and 1.5 − 10.5·1.5/16.
        let (center, side) = (1.453_125, 0.515_625);
        let expected = n as f64 * center / (center + 2.0 * side);
        assert!((counts[1] as f64 - expected).abs() < 2.0);
        assert_eq!(counts[0], counts[2]);
    }

    #[test]
    fn filters_without_integral_are_refused() {
        let zero = FilterShape::Gaussian(GaussianFilter {
            radius: DVec2::splat(2.0),
            alpha: 0.0,
        });
        assert!(Filter::new(zero).is_none());
        let nan = FilterShape::Mitchell(MitchellFilter {
            radius: DVec2::splat(2.0),
            b: f64::NAN,
            c: 0.0,
        });
        assert!(Filter::new(nan).is_none());
        let huge = FilterShape::Mitchell(MitchellFilter {
            radius: DVec2::splat(2.0),
            b: f64::MAX,
            c: 0.0,
        });
        assert!(Filter::new(huge).is_none());
    }
}
