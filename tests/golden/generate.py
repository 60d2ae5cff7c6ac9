#!/usr/bin/env python3
"""Golden data of lenses from geometry alone: `python3 tests/golden/generate.py` (pip install mpmath numpy).

Written without fstop's code. Rays, first order, pupils, focus and chief rays are computed with 50 digits (mpmath) and rounded once; projected
solid angles with float64 (numpy) from the outline of the pupil. Lengths in mm, origin at the first vertex, z toward the film. README.md says what
the fields are. Writes the files of OWN below; the others in this folder are of an earlier generator.
"""
import json
import math
import random
from pathlib import Path

import numpy as np
from mpmath import mp, mpf

mp.dps = 50
FOLDER = Path(__file__).parent

# Name of the data, file of the lens, zoom.
OWN = [
    ("dgauss_50_film_in_glass", "dgauss_50_film_in_glass", None),
    ("fisheye_206", "fisheye_206", None),
    ("zoom_80_200_at_81.55", "zoom_80_200", 81.55),
    ("zoom_80_200_at_194", "zoom_80_200", 194.0),
]
CORNER = 21.633  # of 36 x 24 mm


class Surface:
    def __init__(self, z, radius, before, behind, aperture, stop):
        self.z, self.radius, self.before, self.behind = z, radius, before, behind
        self.aperture, self.stop = aperture, stop


def read(name, zoom):
    """The surfaces of a table, its gaps at one of its zooms, and its description."""
    columns, gaps, rows, description = [], {}, [], None
    for line in (FOLDER / f"{name}.dat").read_text().splitlines():
        comment = line.split("#", 1)
        if len(comment) == 2 and description is None:
            description = comment[1].strip()
        words = comment[0].split()
        if not words:
            continue
        if words[0] == "zoom":
            columns = [float(w) for w in words[1:]]
        elif words[0] == "gap":
            gaps[words[1]] = words[2:]
        else:
            rows.append(words)
    surfaces, z, index = [], mpf(0), mpf(1)
    for radius, thickness, ior, diameter in rows:
        stop = float(ior) == 0
        behind = index if stop else mpf(ior)
        surfaces.append(Surface(z, mpf(radius), index, behind, mpf(diameter) / 2, stop))
        if thickness in gaps:
            thickness = gaps[thickness][columns.index(zoom)]
        z, index = z + mpf(thickness), behind
    return surfaces, description


# --- near the axis -----------------------------------------------------------------------------------------------------------

def refracted(surface, y, u, from_scene):
    """Slope behind (or, from the film, in front of) a surface of a ray near the axis; slopes are dy/dz."""
    power = 0 if surface.radius == 0 else (surface.behind - surface.before) / surface.radius
    if from_scene:
        return (surface.before * u - y * power) / surface.behind
    return (surface.behind * u + y * power) / surface.before


def to_film(surfaces, y, u, z):
    """Height and slope behind the last of `surfaces` of a ray that starts at z."""
    for s in surfaces:
        y, z = y + u * (s.z - z), s.z
        u = refracted(s, y, u, True)
    return y, u, z


def to_scene(surfaces, y, u, z):
    for s in reversed(surfaces):
        y, z = y + u * (s.z - z), s.z
        u = refracted(s, y, u, False)
    return y, u, z


def first_order(surfaces):
    last, n = surfaces[-1].z, surfaces[-1].behind
    y, u, _ = to_film(surfaces, mpf(1), mpf(0), surfaces[0].z)
    rear_focus = last - y / u
    y2, u2, z2 = to_scene(surfaces, mpf(1), mpf(0), last)
    front_focus = z2 - y2 / u2
    f = 1 / u2  # the one in front
    assert abs(f * n + 1 / u) < mpf(10) ** -40 * abs(f)
    return {
        "efl": f, "ffd": front_focus, "bfd": rear_focus - last, "z_F": front_focus, "z_H": front_focus + f,
        "z_H2": rear_focus - n * f, "z_F2": rear_focus, "length": last,
    }


def pupils(surfaces, f, scale):
    k = next(i for i, s in enumerate(surfaces) if s.stop)
    stop = surfaces[k]
    radius = stop.aperture * scale
    image = {}
    for side, trace, part in (("entrance", to_scene, surfaces[:k]), ("exit", to_film, surfaces[k + 1:])):
        y, u, z = trace(part, mpf(0), mpf(1), stop.z)  # from the middle of the stop
        at = z - y / u
        y, u, z = trace(part, radius, mpf(0), stop.z)  # and from its rim
        image[f"{side}_z"] = at
        image[f"{side}_diameter"] = 2 * abs(y + u * (at - z))
    return {"stop_diameter": 2 * radius, **image, "f_number": f / image["entrance_diameter"]}


def focus(first, n):
    """Where the film is to be for planes at some distances."""
    entries = []
    f = first["efl"]
    for distance in (500, 1000, 2000, 10000):
        for origin in ("front_vertex", "film"):
            entry = {"object_distance": float(distance), "measured_from": origin}
            if origin == "front_vertex":
                film = image_of(first, n, -mpf(distance))
            else:
                # x = z_F - z_object, x' = z_film - z_F2: x x' = n f^2 (Newton), x + x' + z_F2 - z_F = distance.
                total = distance - (first["z_F2"] - first["z_F"])
                square = total**2 - 4 * n * f**2
                film = None if square < 0 or total < 0 else first["z_F2"] + (total - mp.sqrt(square)) / 2
            if film is None:
                entry["infeasible"] = True
            else:
                entry["film_z"] = film
            entries.append(entry)
    entries.append({"object_distance": None, "measured_from": "infinity", "film_z": first["z_F2"]})
    return entries


def image_of(first, n, z):
    x = first["z_F"] - z
    return first["z_F2"] + n * first["efl"] ** 2 / x if x > 0 else None


# --- real rays ---------------------------------------------------------------------------------------------------------------

class Doubtful(Exception):
    """An outcome that rounding, or where a sphere is cut off, could decide."""


MARGIN = mpf("1e-4")


def meet(surface, o, d, forward):
    """Where a ray meets the half of a sphere that has the vertex, there first; None if it misses the sphere. Surfaces may cross outside
    their rims, where sequential tracing goes back a little, unless `forward`."""
    if surface.radius == 0:
        t = (surface.z - o[2]) / d[2]
    else:
        center = surface.z + surface.radius
        q = [o[0], o[1], o[2] - center]
        b = sum(x * v for x, v in zip(q, d))
        square = b * b - sum(x * x for x in q) + surface.radius**2
        if abs(square) < MARGIN:
            raise Doubtful
        if square < 0:
            return None
        roots = [-b - mp.sqrt(square), -b + mp.sqrt(square)]
        here = [t for t in roots if (q[2] + t * d[2]) * surface.radius < 0]
        if not here:
            raise Doubtful
        t = min(here, key=abs)
        if abs(q[2] + t * d[2]) < MARGIN:
            raise Doubtful
    if t < 0 and forward:
        raise Doubtful
    return [x + t * v for x, v in zip(o, d)]


def refract(surface, p, d, toward_film):
    """Snell's law as vectors: what is tangential keeps its length times the index. None for total reflection."""
    n, n2 = (surface.before, surface.behind) if toward_film else (surface.behind, surface.before)
    if n == n2:
        return d
    if surface.radius == 0:
        normal = [mpf(0), mpf(0), mpf(1)]
    else:
        center = surface.z + surface.radius
        normal = [p[0] / surface.radius, p[1] / surface.radius, (p[2] - center) / surface.radius]
    cosine = sum(a * b for a, b in zip(normal, d))
    tangent = [n / n2 * (v - cosine * a) for v, a in zip(d, normal)]
    square = 1 - sum(x * x for x in tangent)
    if abs(square) < mpf("1e-8"):
        raise Doubtful
    if square < 0:
        return None
    along = mp.sqrt(square) * (1 if cosine > 0 else -1)
    return [x + along * a for x, a in zip(tangent, normal)]


def trace(surfaces, o, d, scale=1, clipped=True, toward_film=False, first=True):
    """(outcome, surface, height there or point, direction) of a ray toward the scene."""
    order = range(len(surfaces)) if toward_film else range(len(surfaces) - 1, -1, -1)
    for i in order:
        s = surfaces[i]
        p = meet(s, o, d, not first)
        first = False
        if p is None:
            return "miss", i, None, None
        r = mp.sqrt(p[0] ** 2 + p[1] ** 2)
        rim = s.aperture * (scale if s.stop else 1)
        if clipped:
            if abs(r - rim) < MARGIN:
                raise Doubtful
            if r > rim:
                return "vig", i, r, None
        d2 = refract(s, p, d, toward_film)
        if d2 is None:
            return "tir", i, r, None
        o, d = p, d2
    return "ok", -1, o, d


def unit(d):
    length = mp.sqrt(sum(x * x for x in d))
    return [x / length for x in d]


def from_film(surfaces, film_z, film, target, scale):
    o = [mpf(film[0]), mpf(film[1]), film_z]
    d = unit([mpf(target[0]) - o[0], mpf(target[1]) - o[1], surfaces[-1].z - film_z])
    return trace(surfaces, o, d, scale)


class Chief:
    """The ray through the middle of the stop at an angle with the axis there."""

    def __init__(self, surfaces, film_z, angle):
        k = next(i for i, s in enumerate(surfaces) if s.stop)
        stop = [mpf(0), mpf(0), surfaces[k].z]
        self.heights = {}
        o, d = stop, [mpf(0), mp.sin(angle), mp.cos(angle)]
        for i in range(k + 1, len(surfaces)):
            o, d = self.step(surfaces, i, o, d, True)
        t = (film_z - o[2]) / d[2]
        self.h = o[1] + t * d[1]
        self.target = o[1] + (surfaces[-1].z - o[2]) / d[2] * d[1]
        o, d = stop, [mpf(0), -mp.sin(angle), -mp.cos(angle)]
        for i in range(k - 1, -1, -1):
            o, d = self.step(surfaces, i, o, d, False)
            if self.heights[i] > surfaces[i].aperture:
                break
        # With the direction to the film, beyond a right angle where the ray comes from behind.
        self.field = mp.degrees(mp.atan2(abs(d[1]), -d[2]))
        self.blocked = [i for i, r in self.heights.items() if r > surfaces[i].aperture]

    def step(self, surfaces, i, o, d, toward_film):
        p = meet(surfaces[i], o, d, False)
        if p is None:
            raise Doubtful
        self.heights[i] = abs(p[1])
        if self.heights[i] > surfaces[i].aperture:
            return p, d
        d = refract(surfaces[i], p, d, toward_film)
        if d is None:
            raise Doubtful
        return p, d


def bisect(low, high, is_low, steps=150):
    for _ in range(steps):
        middle = (low + high) / 2
        if is_low(middle):
            low = middle
        else:
            high = middle
    return low, high


def chief_limit(surfaces, film_z):
    def passes(angle):
        try:
            return not Chief(surfaces, film_z, angle).blocked
        except Doubtful:
            return False

    step = mpf(1) / 200
    angle = step
    while passes(angle):
        angle += step
    low, high = bisect(angle - step, angle, passes)
    inside, outside = Chief(surfaces, film_z, low), Chief(surfaces, film_z, high)
    # Of several the one that a ray from the film comes to first.
    return low, inside, max(outside.blocked)


# --- the pupil's solid angle, float64 ----------------------------------------------------------------------------------------

def passing(surfaces, film_z, h, targets, scale):
    """Which rays from (0, h) to points (x, y) of the last vertex plane come through."""
    last = float(surfaces[-1].z)
    o = np.stack([np.zeros(len(targets)), np.full(len(targets), h), np.full(len(targets), film_z)])
    d = np.stack([targets[:, 0], targets[:, 1] - h, np.full(len(targets), last - film_z)])
    d /= np.linalg.norm(d, axis=0)
    good = np.ones(len(targets), bool)
    with np.errstate(all="ignore"):
        for s in reversed(surfaces):
            z, r, n, n2 = float(s.z), float(s.radius), float(s.behind), float(s.before)
            if r == 0:
                t = (z - o[2]) / d[2]
                normal = np.stack([np.zeros_like(t), np.zeros_like(t), np.ones_like(t)])
                o = o + t * d
            else:
                q = o - np.array([[0], [0], [z + r]])
                b = (q * d).sum(0)
                root = np.sqrt(b * b - (q * q).sum(0) + r * r)
                near, far = -b - root, -b + root
                half = [(q[2] + t * d[2]) * r < 0 for t in (near, far)]
                t = np.where(half[0] & ~(half[1] & (abs(far) < abs(near))), near, far)
                good &= half[0] | half[1]
                o = o + t * d
                normal = (o - np.array([[0], [0], [z + r]])) / r
            good &= np.hypot(o[0], o[1]) <= float(s.aperture) * (scale if s.stop else 1)
            if n != n2:
                cosine = (normal * d).sum(0)
                tangent = n / n2 * (d - cosine * normal)
                d = tangent + np.sign(cosine) * np.sqrt(1 - (tangent * tangent).sum(0)) * normal
            good &= np.isfinite(d).all(0)
    return good


def solid_angle(surfaces, film_z, h, middle, scale, directions=8192):
    """Of the pupil that (0, h) sees: the area of its outline in direction cosines. Rays through points around `middle` find the outline."""
    phi = (np.arange(directions) + 0.5) * 2 * np.pi / directions
    along = np.stack([np.cos(phi), np.sin(phi)], 1)
    low, high = np.zeros(directions), np.full(directions, 2.0 * float(surfaces[-1].aperture))
    for _ in range(60):
        r = 0.5 * (low + high)
        good = passing(surfaces, film_z, h, np.array([0, middle]) + r[:, None] * along, scale)
        low, high = np.where(good, r, low), np.where(good, high, r)
    x, y = (np.array([0, middle]) + low[:, None] * along).T
    d = np.stack([x, y - h, np.full(directions, float(surfaces[-1].z) - film_z)])
    d /= np.linalg.norm(d, axis=0)
    a, b = d[0], d[1]
    return 0.5 * abs((a * np.roll(b, -1) - np.roll(a, -1) * b).sum())


# --- all of it ---------------------------------------------------------------------------------------------------------------

def some_rays(surfaces, film_z, chiefs, radius, pupil, seed):
    """Rays that pass, and rays that end at each of the causes: half aimed about the pupil, of some radius at the last vertex, half
    anywhere at the rear element."""
    draw = random.Random(seed)
    heights = [float(c.h) for c in chiefs]
    targets = [float(c.target) for c in chiefs]
    rear = float(surfaces[-1].aperture)
    rows = []
    while len(rows) < 200:
        scale = 1.0 if len(rows) < 150 else 0.5
        h = radius * math.sqrt(draw.random())
        turn = 2 * math.pi * draw.random()
        if len(rows) % 2:
            size = 1.15 * scale * pupil * math.sqrt(draw.random())
            at = float(np.interp(h, heights, targets))
        else:
            size, at = 1.05 * rear * math.sqrt(draw.random()), 0.0
        angle = 2 * math.pi * draw.random()
        x, y = size * math.cos(angle), at + size * math.sin(angle)
        c, s = math.cos(turn), math.sin(turn)
        numbers = [-s * h, c * h, c * x - s * y, s * x + c * y]
        numbers = [round(v, 4) for v in numbers]
        texts = [str(v) for v in numbers]
        try:
            outcome, i, p, d = from_film(surfaces, film_z, texts[:2], texts[2:], scale)
        except Doubtful:
            continue
        rest = [float(v) for v in p + d] if outcome == "ok" else [] if p is None else [float(p)]
        rows.append(numbers + [scale, outcome, i] + rest)
    return rows


def axial(surfaces):
    """The widest beam along the axis, and what ends it."""
    def run(y):
        try:
            return trace(surfaces, [mpf(0), y, mpf(-100)], [mpf(0), mpf(0), mpf(1)], toward_film=True)
        except Doubtful:
            return None

    global MARGIN
    MARGIN, kept = mpf(10) ** -45, MARGIN
    low, high = bisect(mpf(0), surfaces[0].aperture, lambda y: (run(y) or [None])[0] == "ok", 80)
    blocked = run(high)
    MARGIN = kept
    return 2 * low, blocked[1]


def data(name, file, zoom):
    surfaces, description = read(file, zoom)
    n = surfaces[-1].behind
    first = first_order(surfaces)
    film_z = mpf(f"{float(first['z_F2']):.6f}")
    low, limit, blocking = chief_limit(surfaces, film_z)
    radius = round(min(CORNER, 0.98 * float(limit.h)), 3)
    fields = []
    axis = {}
    diameter, limiting = axial(surfaces)
    chiefs = []
    for part in (0, 0.25, 0.5, 0.75, 1):
        h = mpf(str(round(part * radius, 6)))
        angle = bisect(mpf(0), low, lambda a: Chief(surfaces, film_z, a).h < h)[0] if part else mpf(0)
        chief = Chief(surfaces, film_z, angle)
        chiefs.append(chief)
        field = chief.field
        distortion = 100 * (h / (first["efl"] * mp.tan(mp.radians(field))) - 1) if 0 < field < 90 else None
        omega = {
            key: solid_angle(surfaces, float(film_z), float(h), float(chief.target), float(key)) for key in ("1", "0.5", "0.25")
        }
        axis = axis or omega
        fields.append({
            "h": h, "chief_object_angle_deg": field, "chief_target": [0.0, chief.target],
            "distortion_tan_pct": distortion, "proj_solid_angle_sr": omega,
            "rel_illum": {key: omega[key] / axis[key] for key in omega},
        })
    fields[0] |= {"real_entrance_beam_diameter": diameter, "onaxis_limiting_surface": limiting}
    table = [Chief(surfaces, film_z, low * i / 40) for i in range(41)]
    pupil = math.sqrt(axis["1"] / math.pi) * float(film_z - surfaces[-1].z)
    return {
        "lens": name, "schema": 1, "description": description, "first_order": first,
        "pupils": {key: pupils(surfaces, first["efl"], mpf(key)) for key in ("1", "0.5", "0.25")},
        "focus": focus(first, n), "film_z": film_z,
        "chief_limit": {
            "object_angle_deg": limit.field, "film_height": limit.h, "blocking_surface": blocking, "cause": "vignetted",
        },
        "image_radius": radius, "fields": fields,
        # 1/(2 n' sin u') of a cone of that projected solid angle.
        "effective_f_number_from_area": 0.5 / (float(n) * math.sqrt(axis["1"] / math.pi)),
        "rays": some_rays(surfaces, film_z, table, radius, pupil, name),
    }


def plain(value):
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    if isinstance(value, (mpf, np.floating)):
        return float(value)
    return value


if __name__ == "__main__":
    for name, file, zoom in OWN:
        (FOLDER / f"{name}.json").write_text(json.dumps(plain(data(name, file, zoom))) + "\n")
        print(name)
