"""Scenes of this folder's .pbrt files for Mitsuba 3: `cornell`, `creature` and `copper`. Mitsuba's max_depth is ours and one more.

`roughplastic` has a diffuse layer below its coating, so the creature's plastic is a blend of what pbrt's is the sum of."""

import numpy

DEPTH_OF_ROULETTE = 5

# How often Mitsuba samples the creature's coating: of 0.3, 0.4 and 0.5 that with the least time to equal error.
COAT = 0.3


def mesh(path, vertices, faces, uv=None):
    """Writes a PLY file; returns its path."""
    vertices = numpy.asarray(vertices, "<f4").reshape(-1, 3)
    names = ["x", "y", "z"]
    if uv is not None:
        vertices = numpy.hstack([vertices, numpy.asarray(uv, "<f4")])
        names += ["u", "v"]
    rows = numpy.zeros(len(faces), dtype=[("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, faces
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {name}" for name in names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header\n"]
    with open(path, "wb") as file:
        file.write("\n".join(head).encode() + vertices.tobytes() + rows.tobytes())
    return path


def quads(folder, name, corners, bsdf, emitter=None):
    corners = numpy.asarray(corners, float).reshape(-1, 3)
    faces = [[4 * i + k for k in t] for i in range(len(corners) // 4) for t in ((0, 1, 2), (0, 2, 3))]
    shape = {"type": "ply", "filename": mesh(f"{folder}/{name}.ply", corners, faces), "face_normals": True, "bsdf": bsdf}
    return shape | ({"emitter": emitter} if emitter else {})


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def area(*radiance):
    return {"type": "area", "radiance": rgb(*radiance)}


def matte(*reflectance):
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(*reflectance)}}


def camera(mi, eye, target, fov, side):
    film = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return {
        "type": "perspective",
        "fov": fov,
        "to_world": mi.ScalarTransform4f().look_at(origin=eye, target=target, up=[0, 1, 0]),
        "film": film | {"component_format": "float32"},
        "sampler": {"type": "multijitter"},
    }


def scene(depth, **parts):
    path = {"type": "path", "max_depth": depth + 1, "rr_depth": DEPTH_OF_ROULETTE}
    return {"type": "scene", "integrator": path} | parts


def cornell(mi, folder):
    white = matte(0.73, 0.73, 0.73)
    low = [130, 165, 65], [82, 165, 225], [240, 165, 272], [290, 165, 114]
    high = [423, 330, 247], [265, 330, 296], [314, 330, 456], [472, 330, 406]

    def block(top):
        sides = [[top[i], top[(i + 1) % 4]] for i in range(4)]
        floor = lambda p: [p[0], 0, p[2]]
        return [list(top)] + [[a, b, floor(b), floor(a)] for a, b in sides]

    lamp = [[343, 548.7, 227], [343, 548.7, 332], [213, 548.7, 332], [213, 548.7, 227]]
    room = [
        [[552.8, 0, 0], [0, 0, 0], [0, 0, 559.2], [549.6, 0, 559.2]],
        [[556, 548.8, 0], [556, 548.8, 559.2], [0, 548.8, 559.2], [0, 548.8, 0]],
        [[549.6, 0, 559.2], [0, 0, 559.2], [0, 548.8, 559.2], [556, 548.8, 559.2]],
    ]
    green = [[0, 0, 559.2], [0, 0, 0], [0, 548.8, 0], [0, 548.8, 559.2]]
    red = [[552.8, 0, 0], [549.6, 0, 559.2], [556, 548.8, 559.2], [556, 548.8, 0]]
    return scene(
        8,
        sensor=camera(mi, [278, 273, -800], [278, 273, -799], 39.3, 300),
        lamp=quads(folder, "lamp", lamp, matte(0.78, 0.78, 0.78), area(18.4, 15.6, 8)),
        room=quads(folder, "room", room, white),
        green=quads(folder, "green", green, matte(0.12, 0.45, 0.15)),
        red=quads(folder, "red", red, matte(0.65, 0.05, 0.05)),
        low=quads(folder, "low", block(low), white),
        high=quads(folder, "high", block(high), white),
    )


def creature(mi, folder):
    stage = [
        [[-30, -1.25, -30], [30, -1.25, -30], [30, -1.25, 30], [-30, -1.25, 30]],
        [[-30, -30, 8], [30, -30, 8], [30, 30, 8], [-30, 30, 8]],
    ]
    # A conductor that absorbs nothing reflects as a dielectric does; pbrt's coating is seen from within, total reflection included.
    coat = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.4617, "eta": 1 / 1.5, "k": 0.0}
    coat["specular_reflectance"] = rgb(*[0.3 / COAT] * 3)
    base = {"type": "diffuse", "reflectance": rgb(*[kd / (1 - COAT) for kd in (0.42, 0.26, 0.12)])}
    plastic = {"type": "blendbsdf", "weight": COAT, "base": base, "coat": coat}
    ball = lambda center, radius, emitter: sphere(center, radius) | {"emitter": emitter, "bsdf": matte(0.5, 0.5, 0.5)}
    return scene(
        5,
        sensor=camera(mi, [4.2, 2.6, -4.6], [0, 0.05, 0], 32, 400),
        key=ball([4, 6, -3], 0.9, area(26, 25, 22)),
        fill=ball([-5, 4, -4], 1.2, area(6, 8, 12)),
        stage=quads(folder, "stage", stage, matte(0.55, 0.53, 0.5)),
        creature=the_creature(mi, folder, {"type": "twosided", "bsdf": plastic}),
    )


def sphere(center, radius):
    return {"type": "sphere", "center": center, "radius": radius}


def the_creature(mi, folder, bsdf):
    turned = mi.ScalarTransform4f().rotate([0, 1, 0], 25)
    return {"type": "ply", "filename": f"{folder}/creature.ply", "to_world": turned, "bsdf": bsdf}


def copper(mi, folder):
    # Mitsuba's images of the sky have y up, pbrt's z, which this scene turns to y.
    to_pbrt = numpy.array([[0, 0, -1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
    turn = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
    ground = [[-30, -1.25, -30], [30, -1.25, -30], [30, -1.25, 30], [-30, -1.25, 30]]
    uv = [[0, 0], [1, 0], [1, 1], [0, 1]]
    tiles = mi.ScalarTransform4f().scale([20, 20, 1])
    grass = {"type": "bitmap", "filename": f"{folder}/grass.png", "to_uv": tiles}
    metal = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3, "material": "Cu"}
    return scene(
        5,
        sensor=camera(mi, [4.2, 2.6, -4.6], [0, 0.05, 0], 32, 400),
        sky={"type": "envmap", "filename": f"{folder}/sky.hdr", "to_world": mi.ScalarTransform4f(turn @ to_pbrt)},
        ground={
            "type": "ply",
            "filename": mesh(f"{folder}/ground_uv.ply", ground, [[0, 1, 2], [0, 2, 3]], uv),
            "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": grass}},
        },
        creature=the_creature(mi, folder, {"type": "twosided", "bsdf": metal}),
        ball={"type": "sphere", "center": [1.9, -0.65, -1.2], "radius": 0.6, "bsdf": matte(0.6, 0.5, 0.3)},
    )


# With the samples a pixel of the .pbrt files. Light does not matter for relative errors: the box has twice that of its file.
SCENES = {"cornell": (cornell, 32), "creature": (creature, 8), "copper": (copper, 16)}
