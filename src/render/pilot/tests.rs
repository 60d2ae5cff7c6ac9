use crate::build::build;
use crate::render::RenderJob;
use crate::scene::{ReadSettings, read_scene};
use crate::syntax::SourceMap;

/// A box around the camera and a lamp without area, after a pilot pass for this integrator, with what `more` says.
fn after_pilot(integrator: &str, more: &str) -> RenderJob {
    let text = format!(
        "Integrator {integrator} Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 32 \
         {more} Shape \"sphere\" \"float radius\" 9 WorldEnd"
    );
    let sources = SourceMap::new();
    let file = sources.add_text("test.pbrt", text);
    let (scene, _) = read_scene(&sources, file, &ReadSettings::default());
    let frame = scene.frames.into_iter().next().expect("one frame");
    build(frame, 0).0.expect("it can be built").job
}

/// Light that is scattered once is found by emitter sampling, and so are light paths of a matte world, if rarely better.
#[test]
fn light_paths_are_left_out_where_they_bring_nothing_else() {
    let lamp = "WorldBegin LightSource \"point\" \"point from\" [0 0 5]";
    let glass = format!("{lamp} Material \"glass\" Shape \"sphere\" Material \"matte\"");
    let once = after_pilot("\"bdpt\" \"integer maxdepth\" 1", &glass);
    assert!(!once.traces_light());
    assert_eq!(once.light_paths(64), 0);
    assert!(after_pilot("\"bdpt\"", &glass).traces_light());
}

/// A pilot pass says little of media.
#[test]
fn in_media_there_are_as_many_light_paths_as_samples() {
    let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fog\" \"fog\" \
               WorldBegin MediumInterface \"fog\" \"fog\" LightSource \"point\" \"point from\" [0 0 5]";
    assert!(after_pilot("\"bdpt\"", fog).light_share.0 >= 1.0);
}
