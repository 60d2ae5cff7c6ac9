//! The types that scene files know, and their parameters.
//!
//! A parameter is written as one letter for what its values are, its name, and for texts the choice:
//! `f` float, `i` small integer, `b` bool, `s` one of the texts behind it, `c` color or spectrum or a
//! texture of them, `t` float or a texture of floats, `p` a point, `F3` three floats, `I3` three
//! integers, `P3` three points, `N3` three normals, `Q3` three points of the plane.

/// A type and its parameters.
pub(super) type Kind = (&'static str, &'static str);

pub(super) const CAMERAS: &[Kind] = &[
    (
        "perspective",
        "f fov;f halffov;f lensradius;f focaldistance;f frameaspectratio;F4 screenwindow;f shutteropen;f shutterclose",
    ),
    (
        "orthographic",
        "f lensradius;f focaldistance;F4 screenwindow;f shutteropen;f shutterclose",
    ),
    ("environment", "f shutteropen;f shutterclose"),
    (
        "realistic",
        "s lensfile lenses/wild.dat|../reference/lenses/dgauss50.dat|../reference/lenses/fisheye10.dat|nosuch.dat;\
         f focusdistance;f aperturediameter;b simpleweighting;b dispersion;i blades;f bladerotation;\
         f fnumber;f tnumber;f iso;f exposuretime;F2 shift;f zoom;f shift;\
         s aperture square|star|gaussian|textures/nosuch.png;s lensmodel exact|thick|thin|nosuch;f tolerance",
    ),
];

pub(super) const SAMPLERS: &[Kind] = &[
    ("random", "i pixelsamples"),
    ("stratified", "i xsamples;i ysamples;b jitter;i dimensions"),
    ("halton", "i pixelsamples;b samplepixelcenter"),
    ("sobol", "i pixelsamples"),
    ("02sequence", "i pixelsamples;i dimensions"),
    ("maxmindist", "i pixelsamples"),
    ("adaptive", "i minsamples;i maxsamples"),
];

pub(super) const FILTERS: &[Kind] = &[
    ("box", "f xwidth;f ywidth"),
    ("gaussian", "f xwidth;f ywidth;f alpha"),
    ("mitchell", "f xwidth;f ywidth;f B;f C"),
    ("sinc", "f xwidth;f ywidth;f tau"),
    ("triangle", "f xwidth;f ywidth"),
];

pub(super) const FILMS: &[Kind] = &[(
    "image",
    "F4 cropwindow;f scale;f diagonal;f maxsampleluminance",
)];

pub(super) const INTEGRATORS: &[Kind] = &[
    (
        "path",
        "i maxdepth;f rrthreshold;s lightsamplestrategy uniform|power|spatial",
    ),
    (
        "volpath",
        "i maxdepth;f rrthreshold;s lightsamplestrategy uniform|power|spatial",
    ),
    ("directlighting", "i maxdepth;s strategy all|one"),
    ("whitted", "i maxdepth"),
    ("ambientocclusion", "i nsamples;b cossample;f maxdist"),
    ("bdpt", "i maxdepth"),
    ("mlt", "i maxdepth"),
    ("sppm", "i maxdepth;f radius"),
    ("photonmap", "i maxdepth"),
];

const CUTS: &str = "t alpha;t shadowalpha";

pub(super) const SHAPES: &[Kind] = &[
    ("sphere", "f radius;f zmin;f zmax;f phimax"),
    ("disk", "f radius;f height;f innerradius;f phimax"),
    ("cylinder", "f radius;f zmin;f zmax;f phimax"),
    ("cone", "f radius;f height;f phimax"),
    ("paraboloid", "f radius;f zmin;f zmax;f phimax"),
    ("hyperboloid", "p p1;p p2;f phimax"),
    (
        "trianglemesh",
        "P4 P;I6 indices;N4 N;N4 S;Q4 uv;I2 faceIndices",
    ),
    (
        "plymesh",
        "s filename geometry/faces.ply|geometry/polygons.ply.gz|geometry/nosuch.ply",
    ),
    (
        "objmesh",
        "s filename geometry/house.obj|geometry/nosuch.obj",
    ),
    ("loopsubdiv", "P4 P;I6 indices;i nlevels;s scheme loop"),
    (
        "curve",
        "P4 P;i degree;s basis bezier|bspline;s type flat|ribbon|cylinder;N2 N;f width;f width0;f width1;i splitdepth",
    ),
    ("heightfield", "i nu;i nv;F4 Pz"),
    (
        "nurbs",
        "i nu;i nv;i uorder;i vorder;F4 uknots;F4 vknots;P4 P;F16 Pw;f u0;f u1;f v0;f v1",
    ),
];

/// What any shape may say besides.
pub(super) const OF_SHAPES: &str = CUTS;

pub(super) const MATERIALS: &[Kind] = &[
    ("matte", "c Kd;t sigma"),
    ("mirror", "c Kr"),
    (
        "glass",
        "c Kr;c Kt;t eta;t index;t uroughness;t vroughness;b remaproughness",
    ),
    ("plastic", "c Kd;c Ks;t roughness;b remaproughness"),
    (
        "metal",
        "c eta;c k;t roughness;t uroughness;t vroughness;b remaproughness",
    ),
    (
        "uber",
        "c Kd;c Ks;c Kr;c Kt;c opacity;t roughness;t eta;t index;b remaproughness",
    ),
    (
        "substrate",
        "c Kd;c Ks;t uroughness;t vroughness;b remaproughness",
    ),
    (
        "translucent",
        "c Kd;c Ks;c reflect;c transmit;t roughness;b remaproughness",
    ),
    (
        "mix",
        "c amount;s namedmaterial1 a|b|nosuch;s namedmaterial2 a|b",
    ),
    (
        "disney",
        "c color;t metallic;t eta;t roughness;t speculartint;t anisotropic;t sheen;t sheentint;t clearcoat;\
         t clearcoatgloss;t spectrans;c scatterdistance;b thin;t difftrans;t flatness",
    ),
    (
        "subsurface",
        "s name Skin1|Marble|Nosuch;c sigma_a;c sigma_prime_s;f scale;t eta;f g;c Kr;c Kt;t uroughness;t vroughness",
    ),
    (
        "kdsubsurface",
        "c Kd;c mfp;t eta;f g;c Kr;c Kt;t uroughness;t vroughness",
    ),
    ("fourier", "s bsdffile parts/small.bsdf|parts/nosuch.bsdf"),
    (
        "measured",
        "s filename parts/paint.brdf|parts/paint.binary|parts/nosuch.brdf",
    ),
    (
        "hair",
        "c sigma_a;c color;t eumelanin;t pheomelanin;t eta;t beta_m;t beta_n;t alpha",
    ),
    ("none", ""),
    ("", ""),
];

/// What any material may say besides.
pub(super) const OF_MATERIALS: &str = "t bumpmap";

const PLACED: &str =
    "s mapping uv|spherical|cylindrical|planar;f uscale;f vscale;f udelta;f vdelta;p v1;p v2";

/// What any texture may say besides.
pub(super) const OF_TEXTURES: &str = PLACED;

pub(super) const TEXTURES: &[Kind] = &[
    ("constant", "v value"),
    ("scale", "v tex1;v tex2"),
    ("mix", "v tex1;v tex2;t amount"),
    ("bilerp", "v v00;v v01;v v10;v v11"),
    (
        "imagemap",
        "s filename textures/tiny.hdr|textures/tiny.jpg|textures/nosuch.png;s wrap repeat|black|clamp;\
         b trilinear;f maxanisotropy;f scale;b gamma",
    ),
    ("uv", ""),
    (
        "checkerboard",
        "i dimension;v tex1;v tex2;s aamode none|closedform",
    ),
    ("dots", "v inside;v outside"),
    ("fbm", "i octaves;f roughness"),
    ("wrinkled", "i octaves;f roughness"),
    ("windy", ""),
    ("marble", "i octaves;f roughness;f scale;f variation"),
    (
        "ptex",
        "s filename textures/squares.ptx|textures/triangles.ptx;f gamma",
    ),
];

const PICTURE: &str = "s mapname textures/tiny.hdr|textures/tiny.jpg|textures/nosuch.exr";

pub(super) const LIGHTS: &[Kind] = &[
    ("point", "c I;c scale;p from"),
    (
        "spot",
        "c I;c scale;p from;p to;f coneangle;f conedeltaangle",
    ),
    ("distant", "c L;c scale;p from;p to"),
    ("goniometric", PICTURE),
    (
        "projection",
        "c I;f fov;s mapname textures/tiny.hdr|textures/tiny.jpg",
    ),
    (
        "infinite",
        "c L;c scale;i samples;s mapname textures/tiny.hdr|textures/nosuch.exr",
    ),
];

pub(super) const AREA_LIGHTS: &[Kind] =
    &[("diffuse", "c L;c scale;b twosided;i samples;i nsamples")];

pub(super) const MEDIA: &[Kind] = &[
    (
        "homogeneous",
        "c sigma_a;c sigma_s;f g;f scale;s preset Skin1|Nosuch",
    ),
    (
        "heterogeneous",
        "c sigma_a;c sigma_s;f g;f scale;i nx;i ny;i nz;F8 density;p p0;p p1",
    ),
];

pub(super) const ACCELERATORS: &[Kind] =
    &[("bvh", "i maxnodeprims"), ("kdtree", "i intersectcost")];
