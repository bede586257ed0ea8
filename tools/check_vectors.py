#!/usr/bin/env python3
"""Ondine's specification (docs/specification.md) a second time, in Python: every test vector, bit for bit.

    python3 tools/check_vectors.py [docs/vectors]

tools/specification/ follows that page section by section and shares no code with the program; random numbers are
tools/sampler.py's. Exits with 1 and the first field that differs. Needs Python 3.11; standard library only.
"""

import hashlib
import json
import struct
import sys
from pathlib import Path

from specification import arithmetic, bsdfs as materials
from specification.arithmetic import *
from specification.film import blocks, mean_of, record, sums_of, variance_of
from specification.lights import Lights
from specification.scene import Camera
from specification.shapes import Quad, Room, Sphere, closest, meet_triangle


def floats(case, name):
    """A float or floats of a case, by their bits."""
    words = case[f"{name}_bits"]
    return of_bits(int(words, 16)) if isinstance(words, str) else [of_bits(int(word, 16)) for word in words]


def vector(case, name):
    return V(*floats(case, name))


def functions(section, case):
    if section == "frame":
        frame, v = Frame(vector(case, "normal")), vector(case, "v")
        return {"to_world": frame.to_world(v), "to_local": frame.to_local(v)}
    x = floats(case, "x")
    if section.startswith("sin_cos"):
        return dict(zip(("sin", "cos"), getattr(arithmetic, section.removesuffix("_eighth"))(x)))
    if section == "atan2":
        return {"value": atan2(floats(case, "y"), x)}
    if section == "pow_one_minus":
        return {"value": pow_one_minus(x, floats(case, "y"))}
    return {"value": {"exp": exp, "ln_1p": ln1p, "exp_m1": expm1, "power_heuristic": weight}[section](x)}


def warps(section, case):
    if section == "tent":
        x = tent(floats(case, "u"))
        return {"x": x, "pdf": greatest(F(1) - abs(x), F(0))}
    u, v = floats(case, "u")
    match section:
        case "uniform_disk":
            x, y, r2 = disk(u, v)
            return {"point": [x, y], "squared_radius": r2}
        case "uniform_sphere":
            return {"direction": cone(u, v, F(2)), "pdf": F(0.25) * INV_PI}
        case "uniform_hemisphere":
            return {"direction": cone(u, v, F(1)), "pdf": INV_TAU}
        case "cosine_hemisphere":
            direction = cosine_hemisphere(u, v)
            return {"direction": direction, "pdf": direction.z * INV_PI}
        case "uniform_triangle":
            return {"point": triangle_warp(u, v), "pdf": F(2)}
        case "gaussian":
            point = gaussian(u, v)
            return {"point": point, "pdf": gaussian_pdf(*point)}
    if section == "cone":
        spread = floats(case, "spread")
        return {"direction": cone(u, v, spread), "pdf": INV_TAU / spread}
    n = floats(case, "n")
    direction = cosine_power(u, v, n)
    return {"direction": direction, "pdf": cosine_power_pdf(direction, n)}


CAMERA = {"position": [0.5, 1.0, 3.0], "look_at": [-0.25, 0.5, -1.0], "vertical_fov": 50.0, "focus_distance": 3.25}


def cameras(section, case):
    lens = section == "lens"
    camera = Camera(CAMERA | ({"aperture_radius": 0.125} if lens else {}), 320, 240, "box" if lens else section)
    ray = camera.ray(case["column"], case["row"], floats(case, "u"), floats(case, "v"))
    return dict(zip(("origin", "direction"), ray))


FACING = Quad([-1, -1, -2], [2, 0, 0], [0, 2, 0])
SHAPES = {
    "sphere": [Sphere([0, 0, -4], 1), Sphere([1000, 0, 0], 0.125)],
    "quad": [Quad([-1, -0.5, -2], [2, 0, 0], [0.5, 1, 0.25])],
    "shared_edge": [Quad([0, -1, -3], [1, 0, 0], [0, 2, 0]), Quad([-1, -1, -3], [1, 0, 0], [0, 2, 0])],
    "ties": [Sphere([0, 0, -3], 1), FACING, FACING, Sphere([0, 0, -3], 1)],
    "shadow": [FACING, Sphere([0, 0, -4], 1)],
    "surface": [Sphere([0, 0, -4], 1), Sphere([100, 0, 0], 10), Quad([-1, -3, -1], [0, 0.25, 2], [2, 0.5, 0])],
}


ROOM = Room([(V(0, 0, 1), (F(-4), F(4)), (0, 1)), (V(1, 0, 0), (F(-2), F(2)), (2, 3)), (V(0, 1, 0), (F(-1), F(1)), (4, 5))])


def intersections(section, case):
    o, w = vector(case, "origin"), vector(case, "direction")
    if section == "room":
        return dict(zip(("distance", "primitive"), ROOM.meet(o, w)))
    shapes = dict(enumerate(SHAPES[section]))
    if section == "shadow":
        others = [shape for number, shape in shapes.items() if number != case["target"]]
        return {"occluded": any(shape.meet(o, w) < floats(case, "limit") for shape in others)}
    distance, primitive = closest(shapes, o, w)
    if section != "surface":
        return {"distance": distance, "primitive": primitive}
    position, normal, _, offset, _ = shapes[primitive].vertex(o, w, distance)
    return {"position": position, "normal": normal, "offset": offset}


CORNERS = [V(0, 0, -2), V(1, -1, -2), V(1, 1, -2.5), V(-1, 1, -2), V(-1, -1, -1.5)]
TRIANGLES = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (2, 0, 1)]


def triangles(section, case):
    o, w = vector(case, "origin"), vector(case, "direction")
    met = [(meet_triangle([CORNERS[i] for i in corners], o, w), number) for number, corners in enumerate(TRIANGLES)]
    met = [(t, number) for t, number in met if t is not None and t > 0]
    if section == "any":
        others = [t for t, number in met if number != case["ignored"]]
        return {"occluded": any(t < floats(case, "farthest") for t in others)}
    distance, triangle = min(((t, n) for t, n in met if t > floats(case, "nearest")), default=(INF, None))
    return {"distance": distance, "triangle": triangle}


def bsdfs(section, case, parameters):
    bsdf = getattr(materials, section.split("_")[0].capitalize())
    row = floats(parameters, "parameters")
    if "maps" in parameters:
        r, g, b, metallic, roughness = floats(parameters, "maps")
        bsdf = bsdf(row, (V(r, g, b), metallic, roughness))
    else:
        bsdf = bsdf(row)
    wo = vector(case, "wo")
    if case["call"] == "eval":
        return dict(zip(("value", "pdf"), bsdf.eval(wo, vector(case, "wi"))))
    return dict(zip(("wi", "weight", "pdf"), bsdf.sample(wo, *floats(case, "u"), floats(case, "lobe"))))


def lights(section, case, text):
    all_lights = Lights(text)
    if case["call"] == "sample":
        drawn = all_lights.sample(vector(case, "from"), (floats(case, "choice"), F(0)), *floats(case, "u"))
        return dict(zip(("direction", "distance", "radiance", "inverse_pdf", "primitive", "punctual"), drawn))
    if case["call"] == "met":
        found = all_lights.met(case["light"], vector(case, "origin"), vector(case, "direction"), floats(case, "distance"))
    else:
        radiance, pdf = all_lights.sky_at(vector(case, "direction"))
        found = radiance, pdf * all_lights.sky_chance()
    return dict(zip(("radiance", "pdf"), found))


def film(section, case):
    samples = floats(case, "samples")
    samples = [samples[i : i + 3] for i in range(0, len(samples), 3)]
    count, sums, squares = sums_of(samples)
    text = lambda n: f"0x{n % 2**128:032x}"
    added = list(blocks(samples))
    words = lambda part: [f"0x{struct.pack('>d', x).hex()}" for block in added for x in block[part]]
    return {
        "block_sums": words(1),
        "block_squares": words(2),
        "count": count,
        "rejected": len(samples) - count,
        "sum": list(map(text, sums)),
        "square": list(map(text, squares)),
        "mean": mean_of(count, sums),
        "variance": variance_of(count, sums, squares),
        "image_hash": hashlib.sha256(record(0, 0, count, sums, squares)).hexdigest(),
    }


def shown(value):
    """Floats by their bits, as the vectors have them."""
    if isinstance(value, F):
        return f"{bits(value):#010x}"
    return [shown(v) for v in value] if isinstance(value, (list, tuple)) else value


def check(name, topic):
    """The number of cases that are as the specification has them; exits at the first that is not."""
    count = 0
    for section, content in topic["sections"].items():
        cases = content["cases"]
        more = ()
        if name == "bsdfs":
            more = (cases[0],)
            cases = cases[1:]
        elif name == "lights":
            more = (content["scene"],)
        for case in cases:
            for field, value in globals()[name](section, case, *more).items():
                written = case.get(f"{field}_bits", case[field])
                if shown(value) != written:
                    sys.exit(f"{name}: {section}: {field} is {written}, and the specification gives {shown(value)}: {case}")
            count += 1
    return count


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/vectors")
    for name in ("functions", "warps", "cameras", "intersections", "triangles", "bsdfs", "lights", "film"):
        with open(folder / f"{name}.json") as file:
            print(f"{name}: {check(name, json.load(file))} cases, as the specification has them")


if __name__ == "__main__":
    main()
