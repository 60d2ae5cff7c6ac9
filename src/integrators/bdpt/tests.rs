use super::light_path::LightTracer;
use crate::integrators::context::WAVE;
use crate::integrators::testing::{OUTDOORS, ROOM_WITH_LAMPS, bits, in_waves, job, one_by_one};
use crate::integrators::{Integrator, IntegratorSpec};
use crate::integrators::{Splat, Workspace};
use crate::math::color::is_black;
use crate::render::RenderJob;

/// The scene with this integrator, and this share of camera paths joined to light paths.
fn joined(text: &str, share: f32) -> RenderJob {
    let mut job = job(&text.replace("\"path\"", "\"bdpt\""));
    job.integrator.join(share);
    assert_eq!(job.integrator.name(), "bdpt");
    job
}

/// [`ROOM_WITH_LAMPS`] in haze, with a ball and a pane of glass, a mirror, and a box of denser haze.
fn hazy() -> String {
    let things = r#"
        Material "glass"
        Shape "sphere" "float radius" 1
        Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -3 -3 0  3 -3 0  3 3 0  -3 3 0 ]
        Material "mirror"
        Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -2 -1 2  -1 -1 1  -1 2 1  -2 2 2 ]
        AttributeBegin
        Material "none"
        MediumInterface "dense" "thin"
        Translate 2 -2 1
        Shape "sphere" "float radius" 1
        AttributeEnd
        Material "plastic""#;
    let media = r#"
        MakeNamedMedium "thin" "string type" "homogeneous" "rgb sigma_a" [ .01 .01 .01 ] "rgb sigma_s" [ .05 .04 .03 ]
        MakeNamedMedium "dense" "string type" "homogeneous" "rgb sigma_a" [ .1 .2 .1 ] "rgb sigma_s" [ 1 1 1 ]
        MediumInterface "" "thin"
        Camera"#;
    let text = ROOM_WITH_LAMPS.replacen("Material \"plastic\"", things, 1);
    text.replacen("Camera", media, 1)
}

/// [`hazy`] without the ball of dense haze, beyond which shadow rays look one by one.
fn simple() -> String {
    let text = hazy();
    let begin = text.find("AttributeBegin").expect("the ball");
    let end = text.find("AttributeEnd").expect("the ball") + "AttributeEnd".len();
    format!("{}{}", &text[..begin], &text[end..])
}

#[test]
fn a_camera_path_brings_the_same_in_any_wave_as_by_itself() {
    let glassy = simple().replacen("MediumInterface \"\" \"thin\"", "", 1);
    for text in [ROOM_WITH_LAMPS, OUTDOORS, &hazy(), &simple(), &glassy] {
        for share in [0.0, 0.25, 1.0] {
            let job = joined(text, share);
            let expected = one_by_one(&job, 200.0).radiances;
            let lit = expected.iter().filter(|&&light| !is_black(light)).count();
            assert!(lit > expected.len() / 2, "{lit}");
            for of in [1, 7, WAVE] {
                let found = in_waves(&job, of, 200.0, false).radiances;
                assert_eq!(
                    bits(&found),
                    bits(&expected),
                    "waves of {of}, {share} joined"
                );
            }
        }
    }
}

#[test]
fn layers_see_the_same_in_a_wave_as_by_itself() {
    for text in [ROOM_WITH_LAMPS, OUTDOORS, &hazy(), &simple()] {
        let job = joined(text, 0.5);
        let (expected, found) = (one_by_one(&job, 200.0), in_waves(&job, WAVE, 200.0, true));
        assert_eq!(bits(&found.radiances), bits(&expected.radiances));
        assert_eq!(found.seen, expected.seen);
        for (found, expected) in found.parts.iter().zip(&expected.parts) {
            assert_eq!(bits(found), bits(expected));
        }
    }
}

/// What light paths with these numbers bring, by path.
fn splats(job: &RenderJob, paths: std::ops::Range<u64>, workspace: &mut Workspace) -> Vec<Splat> {
    let streams = paths.map(|path| (path, job.sampler.light_stream(path)));
    let mut splats: Vec<Splat> = Vec::new();
    let mut collect = |splat: Splat| splats.push(splat);
    let integrator = &job.integrator;
    integrator.light_paths(&job.light_job(), streams, workspace, &mut collect);
    // Those of a path come in order.
    splats.sort_by_key(|splat| splat.path);
    splats
}

fn texts(splats: impl IntoIterator<Item = Splat>) -> Vec<String> {
    let text = |splat| format!("{splat:?}");
    splats.into_iter().map(text).collect()
}

#[test]
fn a_light_path_brings_the_same_beside_others_as_by_itself() {
    for text in [ROOM_WITH_LAMPS, OUTDOORS, &hazy(), &simple()] {
        let job = joined(text, 0.0);
        let mut workspace = Workspace::default();
        let together = splats(&job, 0..1000, &mut workspace);
        let alone = (0..1000).map(|path| splats(&job, path..path + 1, &mut workspace));
        assert!(together.len() > 100, "{}", together.len());
        assert_eq!(texts(together), texts(alone.flatten()));
    }
}

/// A lamp above panes of glass, and below them a floor that the camera sees from below them.
fn panes(count: usize) -> String {
    let begin = r#"
        LookAt 0 1 -3  0 0 0  0 1 0
        Camera "perspective" "float fov" 90
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "sobol" "integer pixelsamples" 16
        Integrator "bdpt" "integer maxdepth" 8
        WorldBegin
        LightSource "spot" "point from" [ 0 6 0 ] "point to" [ 0.5 0 0 ] "float coneangle" 8
        Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -9 0 -9  9 0 -9  9 0 9  -9 0 9 ]
        Material "glass""#;
    let pane = |i: usize| {
        let y = 2 + i;
        format!(
            r#" Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point P" [ -9 {y} -9  9 {y} -9  9 {y} 9  -9 {y} 9 ]"#
        )
    };
    format!(
        "{begin}{} WorldEnd",
        (0..count).map(pane).collect::<String>()
    )
}

#[test]
fn what_glass_lets_through_is_no_matter_of_chance() {
    for count in [1, 3] {
        let job = joined(&panes(count), 0.0);
        let IntegratorSpec::Bdpt(bdpt) = &job.integrator.spec else {
            panic!("bdpt");
        };
        // Without a guide, which leads past the narrow cone, too.
        let integrator = Integrator::new(&job.integrator.spec, &job.world);
        let tracer = LightTracer {
            bdpt,
            world: &job.world,
            lights: &integrator.lights,
            max_depth: 8,
        };
        let (mut through, mut others) = (0, 0);
        for path in 0..1000 {
            let mut first = None;
            tracer.trace(
                0.0,
                &mut job.sampler.light_stream(path),
                |_, vertex, _| match first {
                    None => first = Some(vertex.depth),
                    Some(_) => others += 1,
                },
            );
            // Straight through all panes, which is taken first.
            through += usize::from(first == Some(count as u32));
        }
        assert_eq!(through, 1000, "{count} panes");
        // What is reflected comes back from a second pane: of two in a row, each with a chance of 0.2.
        assert!(count == 1 || others > 10, "{others}");
    }
}

#[test]
fn nor_is_what_the_camera_sees_through_it() {
    for count in [1, 3] {
        // From above the panes, out of the glass and never so obliquely that all is reflected; a lamp is below them.
        let text = panes(count)
            .replacen("\"float fov\" 90", "\"float fov\" 20", 1)
            .replacen(
                "LookAt 0 1 -3  0 0 0  0 1 0",
                "LookAt 0 8 0  0 0 0  0 0 1",
                1,
            )
            .replacen(
                "\"spot\" \"point from\" [ 0 6 0 ]",
                "\"point\" \"point from\" [ 0 1 0 ]",
                1,
            )
            .replacen("\"point to\" [ 0.5 0 0 ] \"float coneangle\" 8", "", 1);
        let radiances = one_by_one(&joined(&text, 0.0), 200.0).radiances;
        let black = radiances.iter().filter(|&&light| is_black(light)).count();
        assert_eq!(black, 0, "{count} panes, {} paths", radiances.len());
    }
}
