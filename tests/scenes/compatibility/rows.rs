//! The rows, in the order of the table.

use super::Much::{Measured, References, Words};
use super::Proof::{Measurement, Reference, Scene, Test};
use super::{Row, measures};

/// Where pbrt-v3 makes no picture.
const NO_PICTURE: &[super::Much] = &[Words("no picture to compare with")];

/// Where expectations are the same.
const NOISE: super::Much = Words("noise only");

pub const ROWS: &[Row] = &[
    Row {
        what: "area lights under scales, even or uneven",
        pbrt: "their density is that of the shape before it is scaled: biased",
        fstop: "the area element of the transformed surface",
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
        what: "`projection` under a scale of 1000 or more",
        pbrt: "dark: a direction is compared with 0.001 before it has unit length",
        fstop: "size does not matter",
        much: &[Measured(measures::scaled_projector)],
        held: &[
            Measurement,
            Test("src/lights/projection.rs", "size_does_not_matter"),
        ],
    },
    Row {
        what: "`Shape \"hyperboloid\"`",
        pbrt: "not the turned segment but a quadric with its waist at z = 0, fitted to p2 and the line beyond it; shaded with the segment's normal",
        fstop: "the same surface and shading normal; rays leave it by its own normal",
        much: &[References(&["shape_quadrics2"])],
        held: &[Test(
            "src/shapes/hyperboloid.rs",
            "elsewhere_it_is_the_surface_of_pbrt_v3",
        )],
    },
    Row {
        what: "hyperboloids whose line meets the axis at z = 0 (the default)",
        pbrt: "never returns",
        fstop: "a cone",
        much: NO_PICTURE,
        held: &[Test(
            "src/shapes/hyperboloid.rs",
            "the_default_is_a_cone_and_level_segments_are_none",
        )],
    },
    Row {
        what: "cones, paraboloids and hyperboloids as area lights",
        pbrt: "aborts",
        fstop: "sampled by area",
        much: NO_PICTURE,
        held: &[Test(
            "src/shapes/emitter/tests.rs",
            "samples_land_where_the_density_says",
        )],
    },
    Row {
        what: "curves as area lights",
        pbrt: "aborts",
        fstop: "they emit: flat and cylinder toward whoever looks, ribbons on the side of their normals",
        much: &[Measured(measures::glowing_curve)],
        held: &[
            Measurement,
            Test(
                "tests/scenes/curve_lights.rs",
                "a_straight_strip_is_a_thin_tube",
            ),
            Test(
                "tests/scenes/curve_lights.rs",
                "light_sampling_and_scattered_rays_agree",
            ),
        ],
    },
    Row {
        what: "a ray that meets one piece of a curve several times",
        pbrt: "the last one found counts",
        fstop: "the nearest",
        much: &[References(&["shape_curve"])],
        held: &[Test(
            "src/shapes/curve/tests.rs",
            "boxes_do_not_change_what_is_met",
        )],
    },
    Row {
        what: "ribbons whose ends have the same normal",
        pbrt: "0 · ∞: the strip has no edges",
        fstop: "as wide as it says",
        much: &[Words("a strip, or all that lies beside it too")],
        held: &[Test(
            "src/shapes/curve/tests.rs",
            "ribbons_face_their_normals",
        )],
    },
    Row {
        what: "`loopsubdiv` of what is no manifold",
        pbrt: "follows wrong neighbours, or crashes",
        fstop: "open along such edges, with a warning",
        much: &[Words("the shape along those edges")],
        held: &[Test(
            "src/shapes/loopsubdiv/tests.rs",
            "what_is_no_manifold_is_said_and_ends",
        )],
    },
    Row {
        what: "`nurbs` and `heightfield` with missing numbers",
        pbrt: "aborts",
        fstop: "an error, the shape is left out",
        much: NO_PICTURE,
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
        what: "motion under a mirroring transformation",
        pbrt: "the mirror is lost on the way",
        fstop: "kept",
        much: &[Words("the shape, or its mirror image")],
        held: &[Test(
            "src/math/motion.rs",
            "mirrors_stay_mirrors_on_the_way",
        )],
    },
    Row {
        what: "motion that turns by less than 3.6°",
        pbrt: "quaternions are blended and normalised",
        fstop: "turned evenly, as for larger angles",
        much: &[Measured(measures::small_turns)],
        held: &[Measurement, Reference("shape_motionblur")],
    },
    Row {
        what: "emitters inside instanced objects",
        pbrt: "glow but light nothing",
        fstop: "the same, with a warning at the shape",
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
        what: "reconstruction filters",
        pbrt: "samples are splatted over the filter's radius",
        fstop: "the filter is importance-sampled (Ernst, Stamminger and Greiner 2006): same expectation, pixels stay independent",
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
        what: "`bdpt`, `mlt`",
        pbrt: "integrators of their own",
        fstop: "rendered by `volpath`, with a note",
        much: &[
            Words("noise only, and what `mlt` misses the whole picture's brightness by"),
            References(&["int_bdpt", "int_mlt"]),
        ],
        held: &[Reference("int_bdpt"), Reference("int_mlt")],
    },
    Row {
        what: "`sppm`",
        pbrt: "photons gathered from discs around each point: biased",
        fstop: "rendered by `path`, with a note; mirrors between the camera and the first other surface are counted apart from `maxdepth`, as there",
        much: &[
            Words("edges and caustics are not blurred"),
            References(&["int_sppm"]),
        ],
        held: &[Reference("int_sppm")],
    },
    Row {
        what: "`halton`, `sobol`, `02sequence`, `lowdiscrepancy`, `maxmindist`",
        pbrt: "five samplers",
        fstop: "Owen-scrambled low-discrepancy points serve all, with a note",
        much: &[NOISE, Measured(measures::samplers)],
        held: &[
            Measurement,
            Scene(
                "samplers",
                "rendered with Owen-scrambled low-discrepancy points",
            ),
        ],
    },
    Row {
        what: "`orthographic` with `lensradius`",
        pbrt: "rays start on the lens alone, the film point is forgotten: a perspective picture",
        fstop: "a telecentric lens: they start around the film point's own place",
        much: &[Words("another picture")],
        held: &[Test(
            "src/cameras/orthographic.rs",
            "rays_of_one_film_point_meet_in_focus_and_spread_by_the_lens",
        )],
    },
    Row {
        what: "focus of the realistic camera",
        pbrt: "two rays traced near the axis, in single precision",
        fstop: "the paraxial limit, in double precision",
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
        what: "exit pupil of the realistic camera",
        pbrt: "boxes from a grid of rays on the rear element: light at their edges can be lost",
        fstop: "boundaries traced from both sides, nothing lost",
        much: &[Measured(measures::realistic)],
        held: &[
            Reference("realistic_dgauss50_full"),
            Reference("realistic_wide22_full"),
            Test("tests/optics/pupil.rs", "no_ray_outside_the_region_passes"),
        ],
    },
    Row {
        what: "`subsurface`, `kdsubsurface` with `bdpt`, `mlt`, `sppm`",
        pbrt: "a warning, and their boundary alone, as bare glass",
        fstop: "rendered by `volpath` or `path`, which follow the light inside",
        much: &[Measured(measures::milk)],
        held: &[
            Measurement,
            Scene("subsurface_boundary", "their boundary alone is seen"),
        ],
    },
    Row {
        what: "`subsurface` finer than positions can be told apart, `mfp` 0",
        pbrt: "no number (`mfp` 0) or noise",
        fstop: "scattered over 16 rounding errors of the position",
        much: &[Words("below any pixel")],
        held: &[Test(
            "tests/scenes/laws.rs",
            "a_plain_of_kdsubsurface_shows_its_kd_in_a_white_sky",
        )],
    },
    Row {
        what: "light below curved surfaces",
        pbrt: "a channel's probes end at the distance within which 0.999 of its light comes out, but their density counts beyond it too: light is lost where channels differ",
        fstop: "counts as far as the probes reach",
        much: &[
            Measured(measures::below_a_ball),
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
        what: "Fresnel moments of subsurface scattering",
        pbrt: "polynomial fits (d'Eon and Irving 2011)",
        fstop: "integrated",
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
        what: "running integrals in `.bsdf` files",
        pbrt: "taken from the file, for sampling",
        fstop: "made from the coefficients",
        much: &[Words("none for files whose integrals are theirs")],
        held: &[Test(
            "src/bsdf/fourier/tests.rs",
            "samples_follow_the_density",
        )],
    },
    Row {
        what: "shape of the stop (`\"string aperture\"`, pbrt-v4)",
        pbrt: "pbrt-v3 has none; pbrt-v4 brightens what a shape lets through to what a round stop would, and lets light through the corners of the square around the stop",
        fstop: "names, sizes and directions are pbrt-v4's; the picture darkens by the area that is covered, and the stop's circle stays the limit",
        much: &[Words("brightness by the area ratio")],
        held: &[Test(
            "tests/optics/stop_shape.rs",
            "irradiance_on_the_axis_falls_by_the_area",
        )],
    },
    Row {
        what: "black channels",
        pbrt: "sums kept as XYZ in single precision: some of the other channels comes back",
        fstop: "exactly 0",
        much: &[Measured(measures::black_channels)],
        held: &[Measurement, Reference("light_projection")],
    },
    Row {
        what: "mixes of many lobes",
        pbrt: "more than 8 lobes at a point, or a `none`: aborts",
        fstop: "lobes beyond 8 are left out, the share of `none` goes straight on, both with a warning; more than 64 nested are an error",
        much: NO_PICTURE,
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
        what: "mixes of materials that light wanders below",
        pbrt: "of the first part's light what goes in looks for surfaces of that part, finds the mix, and is lost; the second part is its boundary alone",
        fstop: "light wanders below the part that let it in",
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
        what: "`substrate` with `Ks` above 1",
        pbrt: "the base takes light away",
        fstop: "the base gets nothing",
        much: &[Words("negative light, or none")],
        held: &[Test(
            "src/bsdf/fresnel_blend.rs",
            "a_full_coat_leaves_the_base_nothing",
        )],
    },
    Row {
        what: "rough glass and `disney` of an index within 1e-4 of 1",
        pbrt: "half-vectors of opposite directions: black or noise",
        fstop: "light goes straight on, as in the limit",
        much: &[Words("black, or all of the light")],
        held: &[Test(
            "src/materials/wild.rs",
            "nothing_is_ever_not_a_number",
        )],
    },
    Row {
        what: "rough reflection and refraction at facets seen from behind",
        pbrt: "counted in values, never sampled",
        fstop: "not counted",
        much: &[
            Words("at grazing angles only"),
            References(&["mat_glass_rough"]),
        ],
        held: &[Reference("mat_glass_rough")],
    },
    Row {
        what: "numbers out of their range in `disney` and `hair`",
        pbrt: "negative light, NaN, or aborts",
        fstop: "the nearer end of the range, with a warning",
        much: NO_PICTURE,
        held: &[
            Scene("disney", "`metallic` is 2: 1 is used"),
            Scene("hair", "`eta` is 0.5, below that of air: 1 is used"),
        ],
    },
    Row {
        what: "values of textures that are no numbers, or no index of refraction",
        pbrt: "NaN spreads",
        fstop: "count as 0, an index as 1.5",
        much: NO_PICTURE,
        held: &[Test(
            "src/materials/wild.rs",
            "nothing_is_ever_not_a_number",
        )],
    },
    Row {
        what: "texture `marble`",
        pbrt: "past the end of the second of its spline's six segments, by a slip of one number: far brighter than the stone",
        fstop: "the six segments of the book and of pbrt-v2",
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
        what: "Ptex files of two or four channels, one of them alpha",
        pbrt: "refused: black",
        fstop: "the others are read, multiplied by it as in files of three",
        much: &[Words("the texture")],
        held: &[Test(
            "src/assets/ptex/tests.rs",
            "texels_are_multiplied_by_alpha_which_is_left_out_of_four_channels",
        )],
    },
    Row {
        what: "texture `ptex` on a face that its file does not have",
        pbrt: "whatever the stack holds",
        fstop: "black",
        much: NO_PICTURE,
        held: &[Test(
            "tests/scenes/ptex.rs",
            "without_numbers_all_is_of_the_first_face_and_beyond_the_last_one_black",
        )],
    },
    Row {
        what: "texture `ptex` as `alpha` or `shadowalpha`",
        pbrt: "all triangles are of the first face",
        fstop: "each is of its own, as for materials",
        much: &[Words("the holes")],
        held: &[Test(
            "tests/scenes/ptex.rs",
            "instances_and_cut_outs_know_their_faces",
        )],
    },
    Row {
        what: "`face_indices` of quadrilaterals in a PLY file",
        pbrt: "aborts",
        fstop: "all triangles of a face have its number, with a warning",
        much: NO_PICTURE,
        held: &[Scene(
            "ptex",
            "face_indices number faces of more than three corners",
        )],
    },
    Row {
        what: "channel of a free path in homogeneous media",
        pbrt: "chosen evenly",
        fstop: "chosen by the path's throughput (same expectation)",
        much: &[NOISE, References(&["int_volpath_fog"])],
        held: &[Test(
            "src/media/homogeneous.rs",
            "expectations_follow_beers_law_in_every_channel",
        )],
    },
    Row {
        what: "emitters without material under `volpath`",
        pbrt: "rays that the BSDF or the medium scattered fly through them without seeing them, and multiple importance sampling misses their share",
        fstop: "they are seen",
        much: &[Measured(measures::bare_emitter)],
        held: &[Measurement],
    },
    Row {
        what: "`shadowalpha` without `alpha`, under lights that scattered rays find too",
        pbrt: "shadow rays pass the holes and scattered rays do not, so the light through them depends on the weights of multiple importance sampling; these leave out how likely the light was to be chosen",
        fstop: "the same, with weights that count it, and our own sampling of constant lights",
        much: &[Measured(measures::shadow_holes)],
        held: &[Measurement, Reference("shape_alpha")],
    },
    Row {
        what: "infinite light in endless fog under `volpath`",
        pbrt: "its light samples cross two radii of the scene, scattered rays never arrive, so the picture depends on the heuristic's weights",
        fstop: "the same, with the weights of our own sampling of constant lights",
        much: &[
            Words("what is left of the light after two radii"),
            References(&["int_volpath_fog"]),
        ],
        held: &[Reference("int_volpath_fog")],
    },
    Row {
        what: "very dense voxels of heterogeneous media",
        pbrt: "no end of tiny steps",
        fstop: "no denser than 100,000 mean free paths across the box, with a warning",
        much: &[Words("invisible")],
        held: &[Test(
            "src/media/heterogeneous.rs",
            "odd_grids_have_a_meaning",
        )],
    },
    Row {
        what: "`g` of ±1 in media",
        pbrt: "division by zero",
        fstop: "±0.9999",
        much: NO_PICTURE,
        held: &[Test("src/media/phase.rs", "extreme_lobes_have_a_meaning")],
    },
    Row {
        what: "frames that name the same picture",
        pbrt: "the last one overwrites the others",
        fstop: "numbered, with a warning",
        much: &[Words("all pictures, or the last")],
        held: &[Test(
            "tests/program/loading.rs",
            "frames_do_not_overwrite_each_other",
        )],
    },
    Row {
        what: "`.jpg` textures",
        pbrt: "refused",
        fstop: "read",
        much: NO_PICTURE,
        held: &[Scene("jpeg_texture", "")],
    },
    Row {
        what: "unknown accelerators",
        pbrt: "an empty scene",
        fstop: "ignored, with a warning",
        much: NO_PICTURE,
        held: &[Scene("unknown_types", "ccelerator")],
    },
];
