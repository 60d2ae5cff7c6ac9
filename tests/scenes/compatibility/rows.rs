//! The evidence, in the order of `docs/generated/compatibility.md`. `what` is the heading in
//! `docs/compatibility.md` under which the difference is explained.

use super::Much::{Measured, References, Words};
use super::Proof::{Measurement, Reference, Scene, Test};
use super::{Row, measures};

/// Where pbrt-v3 makes no image.
const NO_IMAGE: &[super::Much] = &[Words("no image to compare with")];

/// Where expectations are the same.
const NOISE: super::Much = Words("noise only");

pub(super) const ROWS: &[Row] = &[
    Row {
        what: "Area lights under scales",
        much: &[Measured(measures::stretched_cylinder)],
        held: &[
            Measurement,
            Test(
                "src/shapes/emitter/tests.rs",
                "mean_inverse_density_is_the_solid_angle",
            ),
        ],
    },
    Row {
        what: "Projection lights under large scales",
        much: &[Measured(measures::scaled_projector)],
        held: &[
            Measurement,
            Test("src/lights/projection.rs", "size_does_not_matter"),
        ],
    },
    Row {
        what: "Hyperboloids",
        much: &[References(&["shape_quadrics2"])],
        held: &[Test(
            "src/shapes/hyperboloid.rs",
            "elsewhere_it_is_the_surface_of_pbrt_v3",
        )],
    },
    Row {
        what: "Hyperboloids that are cones",
        much: NO_IMAGE,
        held: &[Test(
            "src/shapes/hyperboloid.rs",
            "the_default_is_a_cone_and_level_segments_are_none",
        )],
    },
    Row {
        what: "Cones, paraboloids and hyperboloids as area lights",
        much: NO_IMAGE,
        held: &[Test(
            "src/shapes/emitter/tests.rs",
            "samples_land_where_the_density_says",
        )],
    },
    Row {
        what: "Several hits on one curve piece",
        much: &[References(&["shape_curve"])],
        held: &[Test(
            "src/shapes/curve/tests.rs",
            "boxes_do_not_change_what_is_met",
        )],
    },
    Row {
        what: "Ribbons with equal normals at both ends",
        much: &[Words("a strip, or all that lies beside it too")],
        held: &[Test(
            "src/shapes/curve/tests.rs",
            "ribbons_face_their_normals",
        )],
    },
    Row {
        what: "Subdivision of non-manifold meshes",
        much: &[Words("the shape along those edges")],
        held: &[Test(
            "src/shapes/loopsubdiv/tests.rs",
            "what_is_no_manifold_is_said_and_ends",
        )],
    },
    Row {
        what: "Incomplete NURBS and height fields",
        much: NO_IMAGE,
        held: &[
            Test(
                "src/shapes/nurbs.rs",
                "what_does_not_fit_is_an_error_and_what_is_outside_is_moved",
            ),
            Test(
                "src/shapes/heightfield.rs",
                "missing_and_surplus_numbers_are_errors",
            ),
        ],
    },
    Row {
        what: "Motion under mirroring transforms",
        much: &[Words("the shape, or its mirror image")],
        held: &[Test(
            "src/math/motion.rs",
            "mirrors_stay_mirrors_on_the_way",
        )],
    },
    Row {
        what: "Motion with small rotations",
        much: &[Measured(measures::small_turns)],
        held: &[Measurement, Reference("shape_motionblur")],
    },
    Row {
        what: "Emitters inside instanced objects",
        much: &[Measured(measures::instanced_lamp)],
        held: &[
            Measurement,
            Scene(
                "instancing",
                "an emitter inside an object glows but lights nothing",
            ),
        ],
    },
    Row {
        what: "Reconstruction filters",
        much: &[
            NOISE,
            References(&[
                "filter_gaussian",
                "filter_mitchell",
                "filter_sinc",
                "filter_triangle",
            ]),
        ],
        held: &[
            Reference("filter_gaussian"),
            Reference("filter_mitchell"),
            Reference("filter_sinc"),
            Reference("filter_triangle"),
        ],
    },
    Row {
        what: "Bidirectional paths where a light path begins dark",
        much: &[Words("a sixth of a projector's direct light")],
        held: &[Test("tests/scenes/census.rs", "every_scene_is_compared")],
    },
    Row {
        what: "Metropolis light transport",
        much: &[
            Words("noise only, and what `mlt` misses the brightness of the whole image by"),
            References(&["int_bdpt", "int_mlt"]),
        ],
        held: &[Reference("int_bdpt"), Reference("int_mlt")],
    },
    Row {
        what: "Light through smooth glass and off mirrors",
        much: &[Words("none: what is missing is missing in both")],
        held: &[
            Test("tests/program/lost_light.rs", "bdpt_finds_the_laser"),
            Test(
                "src/build/light_paths.rs",
                "bdpt_has_a_note_where_caustics_are_seen_by_caustics",
            ),
        ],
    },
    Row {
        what: "Cameras of bidirectional paths",
        much: &[Words("the reference renders none of them")],
        held: &[Test(
            "src/build/light_paths.rs",
            "cameras_that_light_paths_do_not_reach_are_warned_of",
        )],
    },
    Row {
        what: "Photon mapping",
        much: &[
            Words("within the discs of the last iterations, and what the reference loses"),
            References(&["int_sppm"]),
        ],
        held: &[Reference("int_sppm")],
    },
    Row {
        what: "Low-discrepancy samplers",
        much: &[NOISE, Measured(measures::samplers)],
        held: &[
            Measurement,
            Test(
                "tests/program/unreadable.rs",
                "the_sampler_is_noted_on_demand",
            ),
        ],
    },
    Row {
        what: "Orthographic camera with a lens",
        much: &[Words("another image")],
        held: &[Test(
            "src/cameras/projective.rs",
            "rays_of_one_film_point_meet_in_focus_and_spread_by_the_lens",
        )],
    },
    Row {
        what: "Focus of the realistic camera",
        much: &[References(&[
            "realistic_focus_0p7m",
            "realistic_focus_20m",
            "realistic_focus_fisheye_1m",
        ])],
        held: &[
            Reference("realistic_focus_0p7m"),
            Reference("realistic_focus_20m"),
            Reference("realistic_focus_fisheye_1m"),
        ],
    },
    Row {
        what: "Exit pupil of the realistic camera",
        much: &[Measured(measures::realistic)],
        held: &[
            Reference("realistic_dgauss50_full"),
            Reference("realistic_wide22_full"),
            Test("tests/optics/pupil.rs", "no_ray_outside_the_region_passes"),
        ],
    },
    Row {
        what: "Subsurface materials with other integrators",
        much: &[Measured(measures::milk)],
        held: &[
            Measurement,
            Scene("subsurface_boundary", "their boundary alone is seen"),
        ],
    },
    Row {
        what: "Very dense subsurface materials",
        much: &[Words("below any pixel")],
        held: &[Test(
            "tests/scenes/laws.rs",
            "a_plain_of_kdsubsurface_shows_its_kd_in_a_white_sky",
        )],
    },
    Row {
        what: "Subsurface light below curved surfaces",
        much: &[
            Measured(measures::below_a_ball),
            Measured(measures::below_the_ball_of_mat_kdsubsurface),
            References(&["mat_subsurface", "mat_kdsubsurface"]),
        ],
        held: &[
            Measurement,
            Test(
                "src/bssrdf/tests.rs",
                "a_sphere_returns_the_effective_albedo",
            ),
        ],
    },
    Row {
        what: "Fresnel moments",
        much: &[
            Measured(measures::fresnel_polynomials),
            References(&["mat_subsurface", "mat_kdsubsurface"]),
        ],
        held: &[
            Measurement,
            Test("src/bsdf/fresnel_moments.rs", "moments_are_the_integrals"),
        ],
    },
    Row {
        what: "Running integrals in .bsdf files",
        much: &[Words("none for files whose integrals are theirs")],
        held: &[Test(
            "src/bsdf/fourier/tests.rs",
            "samples_follow_the_density",
        )],
    },
    Row {
        what: "Grazing angles in .bsdf files",
        much: &[Words(
            "none where the table is black at these two cosines; else between them and the next ones only",
        )],
        held: &[Test(
            "src/bsdf/fourier/tests.rs",
            "samples_at_grazing_angles_follow_the_density",
        )],
    },
    Row {
        what: "Shape of the aperture stop",
        much: &[Words("brightness by the area ratio")],
        held: &[Test(
            "tests/optics/stop_shape.rs",
            "irradiance_on_the_axis_falls_by_the_area",
        )],
    },
    Row {
        what: "Black channels",
        much: &[Measured(measures::black_channels)],
        held: &[Measurement, Reference("light_projection")],
    },
    Row {
        what: "Mixes of many lobes",
        much: NO_IMAGE,
        held: &[
            Test(
                "src/materials/mix.rs",
                "too_many_lobes_are_left_out_or_refused",
            ),
            Test("src/materials/mix.rs", "none_passes_its_share"),
            Scene("mixes", "those beyond 8 at a point are left out"),
        ],
    },
    Row {
        what: "Mixes of subsurface materials",
        much: &[Measured(measures::chalk_and_milk)],
        held: &[
            Measurement,
            Test(
                "tests/scenes/mixed_interiors.rs",
                "a_mix_shows_what_comes_out_of_each_of_its_parts",
            ),
            Test(
                "tests/scenes/mixed_interiors.rs",
                "all_of_a_part_is_the_part_alone",
            ),
        ],
    },
    Row {
        what: "Substrate with specular reflectance above 1",
        much: &[Words("negative light, or none")],
        held: &[Test(
            "src/bsdf/fresnel_blend.rs",
            "a_full_coat_leaves_the_base_nothing",
        )],
    },
    Row {
        what: "Rough dielectrics with an index near 1",
        much: &[Words("black, or all of the light")],
        held: &[Test(
            "src/materials/robustness.rs",
            "nothing_is_ever_not_a_number",
        )],
    },
    Row {
        what: "Microfacets seen from behind",
        much: &[
            Words("at grazing angles only"),
            References(&["mat_glass_rough"]),
        ],
        held: &[Reference("mat_glass_rough")],
    },
    Row {
        what: "Parameters out of range in disney and hair",
        much: NO_IMAGE,
        held: &[
            Scene("disney", "`metallic` is 2: 1 is used"),
            Scene("hair", "`eta` is 0.5, below that of air: 1 is used"),
        ],
    },
    Row {
        what: "Texture values that are not numbers",
        much: NO_IMAGE,
        held: &[Test(
            "src/materials/robustness.rs",
            "nothing_is_ever_not_a_number",
        )],
    },
    Row {
        what: "Marble",
        much: &[Measured(measures::marble)],
        held: &[
            Measurement,
            Test(
                "src/textures/marble.rs",
                "colors_stay_within_those_of_the_spline",
            ),
        ],
    },
    Row {
        what: "Ptex files with alpha",
        much: &[Words("the texture")],
        held: &[Test(
            "src/assets/ptex/tests.rs",
            "texels_are_multiplied_by_alpha_which_is_left_out_of_four_channels",
        )],
    },
    Row {
        what: "Ptex faces that the file does not have",
        much: NO_IMAGE,
        held: &[Test(
            "tests/scenes/ptex.rs",
            "without_numbers_all_is_of_the_first_face_and_beyond_the_last_one_black",
        )],
    },
    Row {
        what: "Ptex as cut-outs",
        much: &[Words("the holes")],
        held: &[Test(
            "tests/scenes/ptex.rs",
            "instances_and_cut_outs_know_their_faces",
        )],
    },
    Row {
        what: "Face indices of quadrilaterals",
        much: NO_IMAGE,
        held: &[Scene(
            "ptex",
            "face_indices number faces of more than three corners",
        )],
    },
    Row {
        what: "Channel selection in homogeneous media",
        much: &[NOISE, References(&["int_volpath_fog"])],
        held: &[Test(
            "src/media/homogeneous.rs",
            "expectations_follow_beers_law_in_every_channel",
        )],
    },
    Row {
        what: "Emitters without a material under volpath",
        much: &[Measured(measures::bare_emitter)],
        held: &[Measurement],
    },
    Row {
        what: "Cut-outs for shadow rays only",
        much: &[Measured(measures::shadow_holes)],
        held: &[Measurement, Reference("shape_alpha")],
    },
    Row {
        what: "Infinite lights in endless fog",
        much: &[
            Words("what is left of the light after two radii"),
            References(&["int_volpath_fog"]),
        ],
        held: &[Reference("int_volpath_fog")],
    },
    Row {
        what: "Very dense heterogeneous media",
        much: &[Words("invisible")],
        held: &[Test(
            "src/media/heterogeneous.rs",
            "odd_grids_have_a_meaning",
        )],
    },
    Row {
        what: "Extreme phase functions",
        much: NO_IMAGE,
        held: &[Test("src/media/phase.rs", "extreme_lobes_have_a_meaning")],
    },
    Row {
        what: "Frames that name the same file",
        much: &[Words("all images, or the last")],
        held: &[Test(
            "tests/program/loading.rs",
            "frames_do_not_overwrite_each_other",
        )],
    },
    Row {
        what: "JPEG textures",
        much: NO_IMAGE,
        held: &[Scene("jpeg_texture", "")],
    },
    Row {
        what: "Unknown accelerators",
        much: NO_IMAGE,
        held: &[Scene("unknown_types", "ccelerator")],
    },
    Row {
        what: "Volumes",
        much: &[Words(
            "noise and the error of marching, where volumes do not overlap",
        )],
        held: &[
            Test(
                "tests/scenes/volumes.rs",
                "single_means_light_scattered_once",
            ),
            Test(
                "tests/scenes/volumes.rs",
                "a_point_light_in_fog_is_the_integral_over_the_ray",
            ),
            Test(
                "tests/scenes/volumes.rs",
                "volpath_follows_light_through_volumes_without_end",
            ),
            Scene("v2_volumes", ""),
        ],
    },
    Row {
        what: "Emissive meshes",
        much: &[NOISE],
        held: &[Test(
            "tests/scenes/laws.rs",
            "a_mesh_is_one_light_in_pbrt_v2",
        )],
    },
];
