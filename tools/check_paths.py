#!/usr/bin/env python3
"""Renders a few pixels by the specification alone (docs/specification.md, in Python), and with Ondine: the same bits.

    python3 tools/check_paths.py ONDINE

For each scene, strategy and sampler below, the hash of an image of a few pixels is that of the program ONDINE. Exits with 1
where one is not. Standard library only, so the paths are some hundreds: each takes milliseconds.
"""

import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from specification.film import record, sums_of
from specification.paths import Numbers, radiance
from specification.scene import Scene

# Scene, width and height, crop, samples, strategy, sampler, path length, roulette.
RENDERS = [
    ("cornell", (32, 32), (6, 9, 10, 13), 18, "mis", "sobol", 6, None),
    ("cornell", (32, 32), (20, 20, 23, 22), 5, "uniform", "pcg", 4, None),
    ("cornell", (32, 32), (14, 3, 18, 6), 5, "light", "pcg", 5, 2),
    ("materials", (24, 24), (8, 12, 14, 16), 4, "mis", "pcg", 9, None),
    ("glossy", (24, 24), (9, 10, 13, 14), 6, "cosine", "sobol", 5, None),
    ("phong", (24, 24), (4, 12, 9, 15), 6, "mis", "sobol", 5, 3),
    ("blur", (24, 24), (10, 10, 14, 13), 5, "mis", "pcg", 6, None),
    ("sky", (24, 16), (6, 5, 12, 9), 5, "mis", "sobol", 8, None),
    ("sky", (24, 16), (12, 5, 16, 9), 5, "light", "pcg", 4, None),
    ("many-lights", (24, 18), (8, 9, 12, 12), 4, "mis", "sobol", 6, None),
    ("furnace", (8, 8), (2, 2, 5, 5), 3, "mis", "pcg", 12, 4),
    ("meshes of matte", (20, 15), (7, 4, 14, 10), 4, "mis", "sobol", 5, None),
    ("meshes of lacquer", (20, 15), (7, 4, 14, 10), 4, "light", "pcg", 5, 3),
    ("meshes of clear", (20, 15), (7, 4, 14, 10), 4, "mis", "pcg", 7, None),
    ("meshes of tin", (20, 15), (7, 2, 14, 8), 4, "cosine", "sobol", 4, None),
    ("meshes of tin", (20, 15), (4, 9, 10, 13), 4, "uniform", "pcg", 4, None),
]
SEED = 0x1_0000_0007
SCENES = Path(__file__).parent / "specification/scenes"


def specified(text, folder, size, crop, spp, strategy, sampler, length, roulette):
    """The hash of the image by the specification."""
    scene = Scene(text, *size, folder)
    image = hashlib.sha256()
    for row in range(crop[1], crop[3]):
        for column in range(crop[0], crop[2]):
            numbers = [Numbers(sampler, SEED, column, row, sample) for sample in range(spp)]
            samples = [radiance(scene, path, column, row, strategy, length, roulette) for path in numbers]
            image.update(record(column, row, *sums_of(samples)))
    return image.hexdigest()


def rendered(ondine, file, folder, size, crop, spp, strategy, sampler, length, roulette):
    """The hash of the image as the program renders it."""
    words = [ondine, "render", file, "--size", f"{size[0]}x{size[1]}", "--crop", ",".join(map(str, crop))]
    words += ["--spp", spp, "--strategy", strategy, "--sampler", sampler, "--path-length", length, "--seed", SEED]
    words += ["--roulette", roulette] if roulette else []
    words += ["--output", folder / "image.exr", "--no-png", "--json"]
    return json.loads(subprocess.run(map(str, words), check=True, capture_output=True).stdout)["image_hash"]


def scene_file(ondine, name, folder):
    """A built-in scene, or that of meshes with a gem of some material: its text, and how the program is to find it."""
    if name.startswith("meshes of "):
        for file in SCENES.iterdir():
            data = file.read_bytes()
            data = data.replace(b"GEM", name.split()[-1].encode()) if file.suffix == ".toml" else data
            (folder / file.name).write_bytes(data)
        return (folder / "meshes.toml").read_text(), folder / "meshes.toml"
    return subprocess.run([ondine, "scenes", name], check=True, capture_output=True, text=True).stdout, name


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    ondine = str(Path(sys.argv[1]).resolve())
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, *settings in RENDERS:
            text, file = scene_file(ondine, name, folder)
            ours, theirs = specified(text, folder, *settings), rendered(ondine, file, folder, *settings)
            same = "the same bits" if ours == theirs else f"NOT the same: {ours} and {theirs}"
            spp, strategy, sampler, length = settings[2:6]
            print(f"{name}, {strategy}, {sampler}, {spp} samples, path length {length}: {same}", flush=True)
            wrong += ours != theirs
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
