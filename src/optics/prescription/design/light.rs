//! The light that a design is made for, and how wide it is at each surface.
//!
//! Design programs leave clear diameters to the rays of the design: those of each field through the rim of the stop. The stop is
//! as wide as the axial beam there, of which the file gives the entrance pupil, the f-number or the numerical aperture. Rays off the
//! axis are started in the stop and sought by the angle at which they leave it toward the scene, so that pupils of wide lenses, which
//! move with the field, are no matter. By symmetry the widest rays of a field are those in its own plane.

use crate::optics::bisection::bisect;
use crate::optics::element::Toward;
use crate::optics::paraxial::Paraxial;
use crate::optics::surface::Surface;
use crate::optics::trace::{LensRay, LensTracer};

/// How wide the axial beam is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in super::super) enum Beam {
    /// As the stop's own diameter says.
    #[default]
    Stop,
    /// Diameter of the entrance pupil.
    EntrancePupil(f64),
    /// Focal length over entrance pupil.
    FNumber(f64),
    /// 1/(2 tan u') of the paraxial marginal ray at the film, at the object's distance.
    WorkingFNumber(f64),
    /// Sine of the angle of the marginal ray with the axis at the object.
    ObjectAperture(f64),
}

/// What fields are measured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) enum FieldKind {
    /// Degrees from the axis.
    #[default]
    Angle,
    ObjectHeight,
    ImageHeight,
}

/// A point of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Field {
    /// Distance from the axis, by [`FieldKind`].
    pub height: f64,
    /// Which part of the stop its light goes through, from below to above, in radii of the stop.
    pub through: [f64; 2],
}

/// The light that a design is made for, in units of the file.
#[derive(Clone, Debug)]
pub(in super::super) struct Light {
    pub beam: Beam,
    pub kind: FieldKind,
    pub fields: Vec<Field>,
    /// From the object to the first surface; infinite.
    pub object_distance: f64,
}

impl Default for Light {
    fn default() -> Light {
        Light {
            beam: Beam::Stop,
            kind: FieldKind::Angle,
            fields: Vec::new(),
            object_distance: f64::INFINITY,
        }
    }
}

/// Objects this far, in mm, are at infinity: programs write 1e10 and more for it.
const FAR: f64 = 1e9;
/// More fields are not looked at.
const MAX_FIELDS: usize = 32;

/// How wide the light is at each surface, mm; 0 where none arrives.
pub(super) struct Lit {
    pub radii: Vec<f64>,
    /// What to say of how that was found.
    pub remark: String,
}

impl Light {
    /// In millimeters, of which a unit of the file has `unit`.
    pub(super) fn scaled(mut self, unit: f64) -> Light {
        if let Beam::EntrancePupil(diameter) = &mut self.beam {
            *diameter *= unit;
        }
        if self.kind != FieldKind::Angle {
            self.fields.iter_mut().for_each(|f| f.height *= unit);
        }
        self.object_distance *= unit;
        self
    }

    /// The radius of the light on each of `surfaces`, those without an edge having an infinite aperture. Apertures of
    /// the others do not block.
    pub(super) fn clear_radii(&self, surfaces: &[Surface]) -> Lit {
        let open: Vec<Surface> = surfaces.iter().map(unbounded).collect();
        let rays = self.rays(surfaces, &open);
        let mut lit = Lit {
            radii: vec![0.0; surfaces.len()],
            remark: String::new(),
        };
        let given = 0.5 * surfaces[rays.stop].aperture;
        let axial = self.axial_height(&rays);
        let radius = match axial {
            Some(heights) => {
                widen(&mut lit.radii, 0, &heights);
                heights.get(rays.stop).copied().unwrap_or(0.0)
            }
            None => given,
        };
        // The stop's own diameter goes before what the beam would need.
        let radius = if given.is_finite() { given } else { radius };
        if !(radius > 0.0 && radius.is_finite()) {
            return lit;
        }
        lit.radii[rays.stop] = radius;
        let given = radius;
        let radius = rays.filled(self.kind, given);
        let mut lost = 0;
        for field in self.fields.iter().take(MAX_FIELDS).chain([&Field::AXIS]) {
            let found = rays.of_field(field, self.kind, radius, &mut lit.radii);
            lost += u32::from(!found);
        }
        if radius < given {
            lit.remark = format!(
                "; no ray from the axis fills the stop of radius {given}: the widest that gets through has {radius:.4} there"
            );
        } else if lost > 0 {
            lit.remark = format!("; the rays of {lost} of its fields do not get through");
        } else if self.fields.iter().all(|f| f.height == 0.0) {
            lit.remark = " on the axis: it has no field off it".to_string();
        }
        lit
    }

    /// The radius of the stop that the file's beam fills, mm; `None` where the file does not say how wide that is.
    pub(super) fn stop_radius(&self, surfaces: &[Surface]) -> Option<f64> {
        let open: Vec<Surface> = surfaces.iter().map(unbounded).collect();
        let rays = self.rays(surfaces, &open);
        let height = self.axial_height(&rays)?.get(rays.stop).copied()?;
        Some(height.abs()).filter(|radius| *radius > 0.0 && radius.is_finite())
    }

    /// Rays through `surfaces`, which are `open` to them.
    fn rays<'a>(&self, surfaces: &[Surface], open: &'a [Surface]) -> Rays<'a> {
        let stop = surfaces.iter().position(|s| s.is_stop);
        Rays {
            tracer: LensTracer::new(open),
            stop: stop.unwrap_or(0),
            surfaces: open,
            object: self.object(),
        }
    }

    /// Distance of the object, unless fields are angles.
    fn object(&self) -> Option<f64> {
        Some(self.object_distance).filter(|d| d.abs() < FAR)
    }

    /// How far from the axis the marginal ray of the axis meets each surface; `None` where the file does not say how wide it is.
    fn axial_height(&self, rays: &Rays) -> Option<Vec<f64>> {
        let mut stop_alone = rays.surfaces.to_vec();
        stop_alone[rays.stop].aperture = 1.0;
        stop_alone[rays.stop].is_stop = true;
        let paraxial = Paraxial::new(&stop_alone);
        let pupil_z = paraxial.entrance_pupil.map_or(0.0, |p| p.z);
        let radius = match self.beam {
            Beam::Stop => return None,
            Beam::EntrancePupil(diameter) => 0.5 * diameter,
            Beam::FNumber(f) => 0.5 * paraxial.cardinals?.focal_length.abs() / f,
            Beam::WorkingFNumber(f) => {
                let cardinals = paraxial.cardinals?;
                let focal_length = cardinals.focal_length;
                match self.object() {
                    None => 0.5 * focal_length.abs() / f,
                    Some(distance) => {
                        // The magnification, by which tangents on both sides differ.
                        let s = distance + cardinals.front_principal_plane;
                        let m = (focal_length / (s - focal_length)).abs();
                        0.5 / f * m * (distance + pupil_z)
                    }
                }
            }
            Beam::ObjectAperture(sine) => {
                let slope = sine / (1.0 - sine * sine).max(0.0).sqrt();
                slope * (self.object()? + pupil_z)
            }
        };
        let to = [0.0, radius, pupil_z];
        let ray = match self.object() {
            Some(distance) => LensRay::through([0.0, 0.0, -distance], to),
            None => LensRay::new(to, [0.0, 0.0, 1.0]),
        };
        let all = 0..rays.surfaces.len();
        let (heights, _) = rays.tracer.heights(all, Toward::Film, ray);
        // Without the ray at the stop, the paraxial one there.
        match heights.len() > rays.stop {
            true => Some(heights),
            false => {
                let stop = radius / paraxial.entrance_pupil?.diameter;
                Some([vec![0.0; rays.stop], vec![stop]].concat())
            }
        }
    }
}

impl Field {
    const AXIS: Field = Field {
        height: 0.0,
        through: [-1.0, 1.0],
    };

    /// At this height, through all of the stop.
    pub(in super::super) fn at(height: f64) -> Field {
        Field {
            height,
            ..Field::AXIS
        }
    }
}

/// Steps from −85° to 85° in which directions at the stop are looked through.
const DIRECTIONS: i32 = 85;
/// Halvings of such a step: to 1e-12 of it.
const HALVINGS: usize = 40;

/// Rays in the y-z plane through the stop.
struct Rays<'a> {
    tracer: LensTracer<f64>,
    stop: usize,
    surfaces: &'a [Surface],
    /// Distance of the object, if it is not far.
    object: Option<f64>,
}

impl Rays<'_> {
    /// Traces the rays of a field that pass the stop of `radius` and widens `radii`; false where there is none.
    fn of_field(&self, field: &Field, kind: FieldKind, radius: f64, radii: &mut [f64]) -> bool {
        let Some(target) = self.target(field, kind) else {
            return false;
        };
        let ends = field.through.map(|part| part * radius);
        let chief = 0.5 * (ends[0] + ends[1]);
        let mut found = false;
        for height in [ends[0], chief, ends[1]] {
            if let Some(angle) = self.angle(height, target) {
                found = true;
                self.widen(radii, height, angle);
            }
        }
        found
    }

    /// The angle at the stop's point at `height` of the ray whose [`Rays::seen`] is `target`.
    fn angle(&self, height: f64, target: f64) -> Option<f64> {
        root(|angle| Some(self.seen(&self.toward_scene(height, angle)?) - target))
    }

    /// The radius of the stop, `radius` at most, that light from the axis fills: a stop may be wider than what spheres in front of it
    /// let through.
    fn filled(&self, kind: FieldKind, radius: f64) -> f64 {
        let Some(target) = self.target(&Field::AXIS, kind) else {
            return radius;
        };
        let passes = |height: f64| self.angle(height, target).is_some();
        if passes(radius) || !passes(0.0) {
            return radius;
        }
        let [inside, _] = bisect([0.0, radius], HALVINGS as u32, passes);
        inside
    }

    /// What [`Rays::seen`] of the field's rays is.
    fn target(&self, field: &Field, kind: FieldKind) -> Option<f64> {
        match (kind, self.object) {
            (FieldKind::Angle, None) => Some(field.height.to_radians()),
            (FieldKind::Angle, Some(distance)) => Some(-field.height.to_radians().tan() * distance),
            (FieldKind::ObjectHeight, Some(_)) => Some(field.height),
            // An object at infinity has no height.
            (FieldKind::ObjectHeight, None) => None,
            (FieldKind::ImageHeight, _) => {
                let at_film = |angle: f64| Some(self.at_film(0.0, angle)? - field.height);
                Some(self.seen(&self.toward_scene(0.0, root(at_film)?)?))
            }
        }
    }

    /// Where in the scene a ray that leaves the lens in front comes from: its angle with the axis, or its height at the object.
    fn seen(&self, ray: &LensRay<f64>) -> f64 {
        let ([_, y, z], [_, m, n]) = (ray.o, ray.d);
        match self.object {
            None => (-m).atan2(-n),
            Some(distance) => y - (distance + z) * m / n,
        }
    }

    /// The ray from the stop's point at `height` toward the scene, at `angle` with the axis in the medium in front of the stop;
    /// z relative to the stop's vertex.
    fn start(&self, height: f64, angle: f64) -> LensRay<f64> {
        let z = self.surfaces[self.stop].sag(height);
        LensRay {
            o: [0.0, height, z],
            d: [0.0, -angle.sin(), -angle.cos()],
        }
    }

    /// That ray in front of the lens.
    fn toward_scene(&self, height: f64, angle: f64) -> Option<LensRay<f64>> {
        let start = self.start(height, angle);
        self.tracer.heights(0..self.stop, Toward::Scene, start).1
    }

    /// The same light on its way to the film: where it meets the stop and what follows, and behind that.
    fn toward_film(&self, height: f64, angle: f64) -> (Vec<f64>, Option<LensRay<f64>>) {
        let mut ray = self.start(height, angle);
        ray.d = ray.d.map(|x| -x);
        // The tracer begins beside the vertex in front.
        if let Some(i) = self.stop.checked_sub(1) {
            ray.o[2] += self.surfaces[i].thickness;
        }
        let surfaces = self.stop..self.surfaces.len();
        self.tracer.heights(surfaces, Toward::Film, ray)
    }

    /// Its height on the film.
    fn at_film(&self, height: f64, angle: f64) -> Option<f64> {
        let ray = self.toward_film(height, angle).1?;
        let distance = self.surfaces.last()?.thickness;
        Some(ray.o[1] + (distance - ray.o[2]) * ray.d[1] / ray.d[2])
    }

    fn widen(&self, radii: &mut [f64], height: f64, angle: f64) {
        let start = self.start(height, angle);
        let (mut heights, _) = self.tracer.heights(0..self.stop, Toward::Scene, start);
        heights.reverse();
        widen(radii, self.stop - heights.len().min(self.stop), &heights);
        widen(radii, self.stop, &self.toward_film(height, angle).0);
    }
}

/// Radii from surface `first` on that hold these heights.
fn widen(radii: &mut [f64], first: usize, heights: &[f64]) {
    for (radius, height) in radii.iter_mut().skip(first).zip(heights) {
        *radius = radius.max(height.abs());
    }
}

/// The angle nearest to 0, radians, at which `f` passes through 0; where it has no value rays do not get through.
fn root(f: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let at = |degrees: i32| f64::from(degrees).to_radians();
    let steps = (0..DIRECTIONS).flat_map(|i| [(i, i + 1), (-i, -i - 1)]);
    for (inner, outer) in steps {
        let (mut a, mut b) = (at(inner), at(outer));
        let (Some(fa), Some(fb)) = (f(a), f(b)) else {
            continue;
        };
        if fa == 0.0 {
            return Some(a);
        }
        if fa * fb > 0.0 || !(fa * fb).is_finite() {
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (a + b);
            match f(middle)? * fa > 0.0 {
                true => a = middle,
                false => b = middle,
            }
        }
        return Some(0.5 * (a + b));
    }
    None
}

/// The surface without an edge.
fn unbounded(s: &Surface) -> Surface {
    Surface {
        aperture: f64::INFINITY,
        ..*s
    }
}
