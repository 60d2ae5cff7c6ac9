//! Focusing on what the camera sees, once there is something to see.

use crate::accel::Standing;
use crate::cameras::{Camera, CameraSpec};
use crate::math::Vec3;
use crate::math::ray::Ray;
use crate::scene::FocusTarget;
use crate::scene::options::Options;
use crate::syntax::Diagnostic;
use crate::world::{MAX_NULL_SURFACES, World};

/// Looks at most: the view of a lens moves by a thousandth with the focus, and what it shows in a zone by less.
const LOOKS: usize = 4;

/// Focuses a camera that asks for it, and `options` with it. What cannot be focused on is told, and the focus stays as it is.
pub(super) fn focus(
    options: &mut Options,
    camera: &mut Camera,
    world: &World,
) -> Option<Diagnostic> {
    let film = super::film_geometry(options);
    let target = options.focus_target.clone();
    for _ in 0..LOOKS {
        let Camera::Realistic(realistic) = &*camera else {
            return None;
        };
        let looked =
            realistic.refocused(&film, &|ray| first_surface(world, ray, target.as_ref()))?;
        let before = realistic.film_distance();
        let place = realistic.autofocus_place();
        let at = |message: String| Diagnostic {
            span: place,
            ..Diagnostic::warning(message)
        };
        let spec = match looked {
            Ok(spec) => spec,
            Err(error) => return Some(at(error.to_string())),
        };
        let after = spec.lens.film_distance();
        options.camera = CameraSpec::Realistic(Box::new(spec));
        match super::camera(options) {
            Ok(focused) => *camera = focused,
            Err(error) => return Some(at(format!("autofocus: {error}"))),
        }
        // To a hundredth of a wavelength of light, as a lens of f/1 would see.
        if (after - before).abs() < 5e-6 {
            break;
        }
    }
    None
}

/// Where a ray meets something that is seen, if that is the target or there is none.
fn first_surface(world: &World, ray: &Ray, target: Option<&FocusTarget>) -> Option<Vec3> {
    let mut ray = *ray;
    for _ in 0..=MAX_NULL_SURFACES {
        let hit = world.intersect(&ray)?;
        let Some(material) = hit.material else {
            ray = hit.surface.spawn_ray(ray.d);
            continue;
        };
        let counts = target.is_none_or(|target| match world.geometry.standing(&hit) {
            _ if target.materials.contains(&material) => true,
            Standing::Shape(number) => target.shapes.contains(&number),
            Standing::Instance(number) => target.instances.contains(&number),
        });
        return counts.then_some(hit.surface.p);
    }
    None
}
