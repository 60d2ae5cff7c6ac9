//! How bright the film is: the pupil's projected solid angle.

use crate::math::Vec2;
use crate::optics::lens::Lens;
use crate::optics::pupil::ExitPupil;

/// Well-spread points of the unit square: the R2 sequence (Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018).
pub fn spread(count: u32) -> impl Iterator<Item = Vec2> {
    // 1/p and 1/p², p the plastic number.
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    (0..count).map(|i| {
        let [x, y] = STEP.map(|a| (0.5 + f64::from(i) * a).fract() as f32);
        Vec2::new(x, y)
    })
}

/// ∫cos θ dω over the pupil that the film point at `height` mm sees light through, in steradians: irradiance
/// over the radiance at the film. Exact to about 10/`samples`.
pub fn projected_solid_angle(lens: &Lens, pupil: &ExitPupil, height: f64, samples: u32) -> f64 {
    let film = [0.0, height];
    let sum: f64 = spread(samples)
        .filter_map(|u| pupil.sample(film, u))
        .filter(|s| lens.trace_from_film(film, s.point).is_ok())
        .map(|s| pupil.projected_solid_angle(film, &s))
        .sum();
    sum / f64::from(samples.max(1))
}

/// 1/(2 n' sin u') of a cone of projected solid angle `omega` = π sin² u' in a medium of index n'; `None` for no light.
pub fn effective_f_number(omega: f64, index: f64) -> Option<f64> {
    (omega > 0.0).then(|| 0.5 / (index * (omega / std::f64::consts::PI).sqrt()))
}
