//! Photon mapping against pbrt-v3's: the census's light paths that are found by `sppm` alone (caustics of lights without area in
//! mirrors and through glass), or by it alone behind cameras that pbrt-v3's light paths are not joined to.
//!
//! Iterations, photons and radius are the reference's, so that both have the same bias: nothing is allowed for it. Single pixels
//! are not compared, as in [`crate::census`]. The variance of a block is taken for that of independent pixels, although these share
//! photons: from 16 runs of pbrt-v3 it is 0.5 to 1.1 times that, as photons are well distributed.
//!
//! With four runs of ours a bias of 1 % is found over an image, and of 3 % in the median block of 8 × 8 pixels; with two, at most √2 times as much.

use crate::census::check;

macro_rules! scenes {
    ($($name:ident,)*) => {
        $(
            #[test]
            fn $name() {
                check(stringify!($name));
            }
        )*
    };
}

scenes! {
    distant_sdsglass_sppm,
    point_mirrorring_sppm,
    point_sdsglass_sppm,
    spot_glassball_sppm,
    spot_ortho_sppm,
    spot_realistic_sppm,
    spot_sdsmirror_sppm,
}
