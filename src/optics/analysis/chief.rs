//! Chief rays: from a film point through the middle of the stop.

use crate::optics::bisection::bisect;
use crate::optics::lens::Lens;
use crate::optics::trace::LensRay;

/// The chief ray of one film point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiefRay {
    /// The film point (0, `height`), mm.
    pub height: f64,
    /// Where it crosses the vertex plane of the rear surface: aim at (0, `aim`, length).
    pub aim: f64,
    /// In front of the lens, from a point of the first surface toward the scene.
    pub ray: LensRay<f64>,
    /// `true` if the apertures let it through.
    pub passes: bool,
}

impl ChiefRay {
    /// Angle between the ray in front of the lens and the axis, radians; beyond a quarter turn for an extreme
    /// fisheye.
    pub fn field_angle(&self) -> f64 {
        let d = self.ray.d;
        d[0].hypot(d[1]).atan2(-d[2])
    }

    /// The field angle with a sign: positive where the object lies on the other side of the axis than its image.
    pub fn signed_angle(&self) -> f64 {
        let d = self.ray.d;
        f64::atan2(-d[1] * self.height.signum(), -d[2])
    }

    /// Signed tangent of the field angle: positive where the object lies on the other side of the axis than its
    /// image, as it does for a normal lens.
    pub fn tangent(&self) -> f64 {
        self.ray.d[1] / self.ray.d[2] * self.height.signum()
    }
}

/// Finds chief rays.
#[derive(Clone, Debug)]
pub struct ChiefFinder<'a> {
    lens: &'a Lens,
}

/// Directions tried over the rear element. A finer net finds the chief ray of no lens known that a coarser one
/// misses; the search between two directions is exact.
const SCAN: i32 = 128;

impl<'a> ChiefFinder<'a> {
    /// For `lens`.
    pub fn new(lens: &'a Lens) -> ChiefFinder<'a> {
        ChiefFinder { lens }
    }

    /// The chief ray of the film point (0, `height`); `None` where no ray from there goes through the glass to the
    /// middle of the stop.
    pub fn find(&self, height: f64) -> Option<ChiefRay> {
        let aim = if height == 0.0 {
            0.0
        } else {
            self.search(height)?
        };
        let film = self.lens.film_ray([0.0, height], self.aimed(aim));
        let ray = self.lens.tracer().to_scene_unclipped(&film).ok()?;
        Some(ChiefRay {
            height,
            aim,
            ray,
            passes: self.lens.tracer().to_scene(&film).is_ok(),
        })
    }

    /// Where to aim.
    fn search(&self, height: f64) -> Option<f64> {
        let [low, high] = self.rear_element(height);
        let net: Vec<(f64, Option<f64>)> = (0..=SCAN)
            .map(|i| low + (high - low) * f64::from(i) / f64::from(SCAN))
            .map(|aim| (aim, self.stop_height(height, aim)))
            .collect();
        let mut best: Option<(f64, f64, f64)> = None;
        for pair in net.windows(2) {
            let ((a, Some(fa)), (b, Some(fb))) = (pair[0], pair[1]) else {
                continue;
            };
            let size = fa.abs() + fb.abs();
            if (fa <= 0.0) != (fb <= 0.0) && best.is_none_or(|(_, _, least)| size < least) {
                best = Some((a, b, size));
            }
        }
        let (a, b, _) = best?;
        let below = |x: f64| self.stop_height(height, x).map(|f| f <= 0.0);
        let sign = below(a);
        // 60 halvings leave nothing of the interval.
        let [_, aim] = bisect([a, b], 60, |x| below(x) == sign);
        Some(aim)
    }

    /// The part of the rear vertex plane that the rear element covers, seen from (0, `height`), and a fifth more at
    /// either side: the chief ray may be one that is vignetted.
    fn rear_element(&self, height: f64) -> [f64; 2] {
        let rear = self.lens.rear();
        let (radius, away) = (rear.clear_radius(), self.lens.film_distance());
        // Enlargement from the rim's plane; a rim as far back as the film covers everything.
        let k = away / (away - rear.sag(radius)).max(0.1 * away);
        let rim = [
            height + k * (-radius - height),
            height + k * (radius - height),
        ];
        let (low, high) = (rim[0].min(-radius), rim[1].max(radius));
        let more = 0.2 * (high - low);
        [low - more, high + more]
    }

    /// The largest film height up to `largest` whose chief ray gets through, and its field angle in degrees; `None`
    /// where that of `largest` does.
    pub fn limit(&self, largest: f64) -> Option<[f64; 2]> {
        let passes = |h: f64| self.find(h).filter(|r| r.passes);
        let (mut low, mut high) = (0.0, 0.0);
        // Outward until it is blocked.
        for i in 1..=256 {
            high = largest * f64::from(i) / 256.0;
            if passes(high).is_none() {
                break;
            }
            low = high;
        }
        if low == high {
            return None;
        }
        // 40 halvings leave nothing of the interval.
        let [low, _] = bisect([low, high], 40, |h| passes(h).is_some());
        Some([low, passes(low)?.field_angle().to_degrees()])
    }

    fn aimed(&self, aim: f64) -> [f64; 3] {
        [0.0, aim, self.lens.length()]
    }

    /// How far from the middle of the stop the ray from (0, `height`) toward (0, `aim`) crosses it.
    fn stop_height(&self, height: f64, aim: f64) -> Option<f64> {
        let film = self.lens.film_ray([0.0, height], self.aimed(aim));
        let tracer = self.lens.tracer();
        // Only rays that come from the scene count.
        tracer.to_scene_unclipped(&film).ok()?;
        let at = tracer.point_from_film(&film, self.lens.paraxial().stop, false)?;
        Some(at[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Prescription;

    #[test]
    fn the_stop_in_front_of_a_thin_lens_is_looked_through() {
        // Stop 20 mm before a thin plano-convex lens of f = 100: its image is 25 mm before it, so a chief
        // ray reaching the film, 90 mm behind the lens, at 11.5 mm left the lens at 2.5 mm (paraxially).
        let p = Prescription::parse("0 20 0 2\n50 1e-6 1.5 20\ninf 0 1 20\n").unwrap();
        let lens = Lens::new(&p, 90.0).unwrap();
        let finder = ChiefFinder::new(&lens);
        let ray = finder.find(0.0115).unwrap();
        // Third-order aberration at 0.01 mm is some 1e-9.
        assert!((ray.aim - 0.0025).abs() < 1e-8, "{}", ray.aim);
        assert!((ray.tangent() - 0.0025 / 20.0).abs() < 1e-9);
        assert!(ray.passes);
        assert_eq!(finder.find(0.0).unwrap().field_angle(), 0.0);
    }

    #[test]
    fn a_rim_limits_the_field() {
        // A stop 10 mm in front of a window of 8 mm: rays steeper than 4:10 end at its rim.
        let p = Prescription::parse("0 10 0 1\ninf 0 1 8\n").unwrap();
        let lens = Lens::new(&p, 10.0).unwrap();
        let [height, angle] = ChiefFinder::new(&lens).limit(40.0).unwrap();
        assert!((height - 8.0).abs() < 1e-9);
        assert!((angle - 0.4f64.atan().to_degrees()).abs() < 1e-9);
        assert_eq!(ChiefFinder::new(&lens).limit(7.0), None);
    }
}
