//! One false-alarm rate over the images of a suite.

use crate::compare::Correction;

/// The images of a suite, each of which has one p-value: an upper bound, corrected for all tests within the image.
///
/// Holm's procedure (`correction` says of whom) shares `alpha` among them: the probability that *any* of the images that
/// have not changed is reported is at most `alpha`, however they depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Family {
    /// Maximum probability of any false alarm.
    pub alpha: f64,
    /// Number of images, fixed before any of them is looked at.
    pub images: usize,
    /// How `alpha` is divided.
    pub correction: Correction,
}

impl Family {
    /// What is significant whatever the other images show: the first step of the procedure, Bonferroni's correction.
    pub fn share(&self) -> f64 {
        self.correction.share(self.alpha, self.images)
    }

    /// The level at which the procedure stops: an image differs where its p-value is below.
    ///
    /// Every p-value that is rejected on the way is below the level of an earlier step, and those levels only grow; all
    /// others are no smaller than the one that stopped it. So a single number says the same of all images.
    pub fn level(&self, p: &[f64]) -> f64 {
        let rejected = self
            .correction
            .rejected(p.to_vec(), self.images, self.alpha);
        let left = self.images.saturating_sub(rejected);
        self.correction.share(self.alpha, left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(p: &[f64]) -> f64 {
        let family = Family {
            alpha: 0.05,
            images: 4,
            correction: Correction::Holm,
        };
        family.level(p)
    }

    /// By hand: 0.05/4, 0.05/3, 0.05/2, 0.05.
    #[test]
    fn stepping_down_by_hand() {
        assert_eq!(level(&[0.5, 0.03, 0.9, 0.02]), 0.0125);
        // 0.01 is below 0.0125, 0.016 below 0.0167, 0.03 not below 0.025.
        assert_eq!(level(&[0.03, 0.01, 0.9, 0.016]), 0.025);
        assert_eq!(level(&[0.0; 4]), 0.05);
        // An image that could not be rendered is one of the four nevertheless.
        assert_eq!(level(&[0.0125]), 0.0125);
        assert_eq!(level(&[]), 0.0125);
    }
}
