//! `--stats`: where a render's time went, and what its paths did, as JSON.

use crate::session::{Prepared, Process, Rendered};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// When the parts of a render began and ended.
#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct Times {
    /// From the command to the scene file's end.
    pub reading: Duration,
    /// Of the frame, when its meshes and images were due.
    pub started: Instant,
    /// Its first sample.
    pub rendering: Instant,
    /// Its files.
    pub writing: Instant,
}

/// All that is known.
pub(super) fn of(frame: &Prepared, rendered: &Rendered, number: usize, times: &Times) -> Value {
    let seconds = |from: Instant, to: Instant| to.duration_since(from).as_secs_f64();
    let now = Instant::now();
    let process = Process::measured();
    json!({
        "fstop": env!("CARGO_PKG_VERSION"),
        "scene": rendered.metadata.scene,
        "frame": number,
        "integrator": frame.scene.job.integrator.name(),
        "threads": frame.threads_started(),
        "time_s": {
            "reading": times.reading.as_secs_f64(),
            "preparing": seconds(times.started, times.rendering),
            "rendering": seconds(times.rendering, times.writing),
            "writing": seconds(times.writing, now),
        },
        "memory_bytes": { "now": process.now, "peak": process.peak },
        "samples": {
            "all": rendered.samples,
            "per_pixel": rendered.spp,
            "passes": rendered.passes.map(|(passes, _)| passes),
            "dropped": rendered.dropped.as_ref().map_or(0, |dropped| dropped.count),
        },
        "paths": paths(frame),
    })
}

/// What was counted; null where the integrator counts nothing.
fn paths(frame: &Prepared) -> Option<Value> {
    let counts = frame.counts()?;
    let world = &frame.scene.job.world;
    let lights = world.lights.iter().zip(&counts.shadows);
    let lights = lights.enumerate().map(|(number, (light, [sent, lit]))| {
        json!({"light": number, "type": light.name(), "shadow_rays": sent, "unblocked": lit})
    });
    let materials = world.materials.iter().zip(&counts.surfaces);
    let materials = materials.enumerate().map(|(number, (material, hits))| {
        json!({"material": number, "type": material.name(), "vertices": hits})
    });
    let sent: u64 = counts.shadows.iter().map(|[sent, _]| sent).sum();
    Some(json!({
        "count": counts.paths(),
        "blocked_by_the_lens": counts.blocked,
        "rays": { "path": counts.rays(), "shadow": sent, "occlusion": counts.occlusion },
        "vertices": {
            "surface": counts.surfaces.iter().sum::<u64>(),
            "without_material": counts.surfaces.last(),
            "medium": counts.in_media,
            "escaped": counts.escaped,
        },
        "lengths": counts.lengths,
        "lights": lights.filter(|light| light["shadow_rays"] != 0).collect::<Vec<_>>(),
        "materials": materials.filter(|m| m["vertices"] != 0).collect::<Vec<_>>(),
    }))
}
