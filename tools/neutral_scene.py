#!/usr/bin/env python3
"""Translates a neutral JSON scene to an Ondine scene on standard output.

    neutral_scene.py SCENE.json > SCENE.toml

The neutral form is what scripts for several renderers read, to compare them on one scene: `camera` (eye, target,
up, vfov_deg, lens_radius, focus_distance), `film` (width, height, filter), `materials`, `objects` and `lights`
(spheres, and quads by corner `p` and edges `u`, `v`; a light of type `env_gradient` is the sky), and `bounces`: the
greatest number of scattering events, which is one less than Ondine's path length. The scene may also stand under the
key `scene` of a file that describes a reference image.
"""
import json
import re
import sys

MATERIALS = {"lambert": ["albedo"], "mirror": ["reflectance"], "glass": ["ior"],
             "phong": ["diffuse", "specular", "exponent"], "conductor": ["roughness", "reflectance"]}


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    # JSON's strings, numbers and booleans are TOML's.
    return json.dumps(value, ensure_ascii=False)


def bare(name):
    return name if re.fullmatch("[A-Za-z0-9_-]+", name) else toml(name)


def table(header, values):
    print(f"\n{header}")
    for key, value in values.items():
        print(f"{key} = {toml(value)}")


def shape(item):
    if item["type"] == "sphere":
        return {"sphere": {"center": item["center"], "radius": item["radius"]}}
    if item["type"] == "quad":
        return {"quad": {"corner": item["p"], "u": item["u"], "v": item["v"]}}
    sys.exit(f"shape {item['type']!r} has no counterpart; leave it out of the scene")


def material(item):
    kind, values = item["type"], dict(item)
    if kind == "ggx_conductor":
        kind, values["roughness"] = "conductor", item["alpha"]
    if kind not in MATERIALS:
        sys.exit(f"material type {kind!r} has no counterpart; replace it in the scene")
    return {"type": kind} | {key: values[key] for key in MATERIALS[kind]}


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        scene = json.load(file)
    scene = scene.get("scene", scene)
    camera, film = scene["camera"], scene["film"]
    print(f"# {scene['name']}: {scene.get('title', 'a scene')}\nversion = 1")
    table("[camera]", {"position": camera["eye"], "look_at": camera["target"], "up": camera["up"],
                       "vertical_fov": camera["vfov_deg"], "aperture_radius": camera["lens_radius"],
                       "focus_distance": camera["focus_distance"]})
    table("[film]", {key: film[key] for key in ("width", "height", "filter")})
    table("[render]", {"path_length": scene["bounces"] + 1})
    for name, item in scene["materials"].items():
        table(f"[materials.{bare(name)}]", material(item))
    for item in scene["objects"]:
        table("[[objects]]", shape(item) | {"material": item["material"]})
    for item in scene["lights"]:
        if item["type"] == "env_gradient":
            table("[environment]", {"gradient": {key: item[key] for key in ("zenith", "horizon", "ground")}})
        else:
            table("[[lights]]", shape(item) | {"radiance": item["radiance"]})


main()
