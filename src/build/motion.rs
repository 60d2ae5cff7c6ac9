//! The interval over which the layer `motion` tells how far things move.

use crate::cameras::Shutter;
use crate::scene::Frame;
use crate::scene::transforms::Placement;

/// While the shutter is open; of an image without motion blur, whose shutter opens and closes at once, while anything moves
/// (`TransformTimes`): it may be blurred afterwards.
pub(super) fn times(frame: &Frame, shutter: &Shutter) -> [f32; 2] {
    if shutter.close > shutter.open {
        return [shutter.open as f32, shutter.close as f32];
    }
    let in_objects = frame.objects.iter().flat_map(|object| &object.shapes);
    let shapes = frame.shapes.iter().chain(in_objects);
    let placed = { shapes.map(|shape| &shape.world_from_shape) }
        .chain(
            frame
                .instances
                .iter()
                .map(|instance| &instance.world_from_object),
        )
        .chain([&frame.options.camera_from_world]);
    let times = placed.filter_map(|placement: &Placement| Some(placement.end.as_deref()?.times));
    let whole = times.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    whole.unwrap_or([shutter.open; 2]).map(|time| time as f32)
}
