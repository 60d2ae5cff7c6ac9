use crate::build::build;
use crate::render::RenderJob;
use crate::scene::{ReadSettings, read_scene};
use crate::syntax::SourceMap;

/// A box around the camera and a lamp without area, after a pilot pass for this integrator, with what `more` says.
fn after_pilot(integrator: &str, more: &str) -> RenderJob {
    pilot_of(format!(
        "Integrator {integrator} Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 32 \
         {more} Shape \"sphere\" \"float radius\" 9 WorldEnd"
    ))
}

/// The scene of this text, after its pilot pass.
fn pilot_of(text: String) -> RenderJob {
    let sources = SourceMap::new();
    let file = sources.add_text("test.pbrt", text);
    let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
    assert!(!diagnostics.has_errors());
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

fn lamp(radius: f32) -> String {
    format!(
        "WorldBegin AttributeBegin AreaLightSource \"diffuse\" Translate 0 5 0 \
         Shape \"sphere\" \"float radius\" {radius} AttributeEnd "
    )
}

fn ball(material: &str, at: &str) -> String {
    format!("AttributeBegin Material \"{material}\" Translate {at} Shape \"sphere\" AttributeEnd ")
}

/// Paths of `bdpt` begin at lights; those of `path` do not.
#[test]
fn the_path_tracer_renders_what_it_finds_at_less_cost() {
    let is_left = |more: &str| {
        let job = after_pilot("\"bdpt\"", more);
        assert_eq!(job.traces_light(), job.light_paths(64) > 0);
        !job.integrator.begins_at_lights()
    };
    let point = "WorldBegin LightSource \"point\" \"point from\" [0 0 5]";
    assert!(is_left(point));
    assert!(is_left(&(lamp(1.0) + &ball("plastic", "0 0 5"))));
    // A caustic that camera paths meet rarely, and one that they never meet.
    assert!(!is_left(&(lamp(0.2) + &ball("glass", "0 5 0"))));
    assert!(!is_left(&(point.to_owned() + &ball("glass", "0 3 0"))));
    // No light path comes to a camera in glass, so that none tells of it; surfaces without a material end shadow rays of `path`.
    assert!(!is_left(&(lamp(1.0) + &ball("glass", "0 0 0"))));
    assert!(!is_left(&(lamp(1.0) + &ball("none", "0 0 5"))));
    // As those do that move.
    let moving =
        "AttributeBegin ActiveTransform EndTime Translate 0.1 0 0 ActiveTransform All ".to_owned();
    assert!(!is_left(
        &(lamp(1.0) + &moving + &ball("none", "0 0 5") + "AttributeEnd")
    ));
    // Curves turn to what meets them, and samples that are cut depend on how they are made.
    let curve = "Shape \"curve\" \"point P\" [0 0 4 1 0 4 1 1 4 2 1 4]";
    assert!(!is_left(&(lamp(1.0) + curve)));
    let cut = "\"float maxsampleluminance\" 10 ".to_owned();
    assert!(!is_left(&(cut + &lamp(1.0))));
}

/// Few samples meet nothing of what is rare, and those that meet nothing at all are without noise.
#[test]
fn what_a_pilot_pass_has_not_seen_proves_nothing() {
    let rough = "glass\" \"float uroughness\" 0.001 \"float vroughness\" 0.001 \"bool remaproughness\" \"false";
    let lamp = lamp(0.003) + &ball(rough, "0 5 0");
    assert!(after_pilot("\"bdpt\"", &lamp).integrator.begins_at_lights());
    let light = "WorldBegin LightSource \"point\" \"point from\" [0 0 5]";
    for (spp, is_left) in [(16, true), (8, false)] {
        let few = format!("\"bdpt\" Sampler \"halton\" \"integer pixelsamples\" {spp}");
        let job = after_pilot(&few, light);
        assert_eq!(job.integrator.begins_at_lights(), !is_left);
    }
}

/// With the parameters that `path` has.
#[test]
fn what_is_left_to_the_path_tracer_is_rendered_as_by_it() {
    let [ours, path] = ["\"bdpt\"", "\"path\""].map(|integrator| {
        let job = after_pilot(integrator, &(lamp(1.0) + &ball("plastic", "0 0 5")));
        format!("{:?}", job.integrator)
    });
    assert_eq!(ours, path);
}

/// A lit wall with a window, a tenth of the image, into a room; with what `more` says.
fn window(more: &str) -> RenderJob {
    let quad = |points: &str| {
        format!("Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{points}]\n")
    };
    let wall = [
        "-4 -4 -1  4 -4 -1  4 1.05 -1  -4 1.05 -1",
        "-4 1.95 -1  4 1.95 -1  4 6 -1  -4 6 -1",
        "-4 1.05 -1  -.45 1.05 -1  -.45 1.95 -1  -4 1.95 -1",
        ".45 1.05 -1  4 1.05 -1  4 1.95 -1  .45 1.95 -1",
    ];
    let room = [
        "-2 -.5 -.95  -2 3.5 -.95  -2 3.5 3  -2 -.5 3",
        "2 -.5 -.95  2 3.5 -.95  2 3.5 3  2 -.5 3",
        "-2 -.5 -.95  2 -.5 -.95  2 -.5 3  -2 -.5 3",
        "-2 3.5 -.95  2 3.5 -.95  2 3.5 3  -2 3.5 3",
        "-2 -.5 3  2 -.5 3  2 3.5 3  -2 3.5 3",
    ];
    let shapes: String = wall.into_iter().chain(room).map(quad).collect();
    pilot_of(format!(
        "LookAt 0 1.5 -5  0 1.5 0  0 1 0 Camera \"perspective\" \"float fov\" 40 PixelFilter \"box\" \
         Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 48 \
         Sampler \"random\" \"integer pixelsamples\" 64 Integrator \"bdpt\" WorldBegin\n{shapes}{more}\nWorldEnd"
    ))
}

/// A lamp 0.004 over a floor lights a room by a small spot, which camera samples meet rarely, and then far too brightly. Joined to the lens, or to camera
/// paths, light paths find it.
#[test]
fn light_paths_are_not_left_out_where_camera_samples_are_rarely_bright() {
    let lamp = |place: &str, radius: f32, light: f32| {
        format!(
            "AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\" \"rgb L\" [{light} {light} {light}] \
             {place} Shape \"disk\" \"float radius\" {radius} AttributeEnd\n"
        )
    };
    let far = lamp("Translate 0 1.5 -60", 1.0, 3324.0);
    let near = lamp("Translate 1 -.496 -.8 Rotate 90 1 0 0", 0.003, 675_476.0);
    let job = window(&(far + &near));
    assert!(job.traces_light() || job.integrator.joined() >= 1.0);
}

/// A lamp between a floor and a shelf 0.1 above it: of a few thousand light paths some forty come out and into view, none of them from where the floor
/// is brightest, which camera samples meet once in a million.
#[test]
fn few_light_paths_prove_nothing() {
    let shelf = "AttributeBegin Material \"matte\" \"rgb Kd\" [.6 .6 .6] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                 \"point P\" [.5 -.4 -1  1.5 -.4 -1  1.5 -.4 -.3  .5 -.4 -.3] AttributeEnd";
    let lights = "LightSource \"point\" \"point from\" [0 6 -6] \"rgb I\" [30 30 30] \
                  LightSource \"point\" \"point from\" [1 -.45 -.8] \"rgb I\" [10 10 10]";
    let job = window(&format!("{lights} {shelf}"));
    assert!(job.integrator.begins_at_lights());
}

/// A tenth of the image, behind a pane and lit by a bulb of glass, lives by joints alone.
#[test]
fn all_are_joined_where_a_part_of_the_image_lives_by_it() {
    let glass = "AttributeBegin Material \"glass\"";
    let pane = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3 4 5 6 4 6 7] \
                \"point P\" [-.45 1.05 -1 .45 1.05 -1 .45 1.95 -1 -.45 1.95 -1  -.45 1.05 -.98 .45 1.05 -.98 .45 1.95 -.98 -.45 1.95 -.98]";
    let lights = "LightSource \"point\" \"point from\" [0 1.5 -31] \"rgb I\" [3000 3000 3000] \
                  LightSource \"point\" \"point from\" [0 2.9 1] \"rgb I\" [10 10 10]";
    let bulb = "Translate 0 2.9 1 Shape \"sphere\" \"float radius\" .2";
    let more = format!("{lights} {glass} {pane} AttributeEnd {glass} {bulb} AttributeEnd");
    assert_eq!(window(&more).integrator.joined(), 1.0);
    // Not where that lives by nothing but emitter sampling.
    assert!(window(lights).integrator.joined() < 1.0);
}
