#!/usr/bin/env python3
"""Ondine's random numbers from their specification (docs/specification.md, section 4), in plain integers.

    python3 tools/sampler.py [docs/vectors/samplers.json] [--self-test]

Computes every number of the test vectors again and exits with 1 at the first that differs. --self-test changes each field of
each case, and exits with 1 unless every change is found. Shares no code with the program; standard library only.
"""

import json
import struct
import sys

DIMENSIONS = ["PixelFilter", "Lens", "LightChoice", "LightPoint", "BsdfLobe", "BsdfDirection", "Roulette"]
LAST_SOBOL_EDGE = 3
WORD = 2**32 - 1
LONG = 2**64 - 1


def hash_word(n):
    n ^= 0xE6FE3BEB
    n = (n ^ n >> 16) * 0x7FEB352D & WORD
    n = (n ^ n >> 15) * 0x846CA68B & WORD
    return n ^ n >> 16


def seeds(seed):
    low = hash_word(seed & WORD)
    high = hash_word(seed >> 32 ^ low)
    return hash_word(low ^ (high << 16 | high >> 16) & WORD), high


def reverse(n):
    return int(f"{n:032b}"[::-1], 2)


def pcg_key(seed, pixel, sample):
    a, b = seeds(seed)
    return hash_word(sample ^ hash_word(pixel ^ a)), hash_word(hash_word(sample ^ b) ^ pixel)


def pcg_words(key, index, position):
    """Outputs number `position` and the next of PCG32 (XSH-RR 64/32), one step after another."""
    step = lambda state: (state * 6364136223846793005 + (0x0A02BDBF7BB3C0A7 << 1 | 1)) & LONG
    state = step((index << 32 | key) + (0x0A02BDBF7BB3C0A7 << 1 | 1))
    words = []
    for _ in range(position + 2):
        word, turn = ((state >> 18 ^ state) >> 27) & WORD, state >> 59
        words.append((word >> turn | word << (32 - turn)) & WORD)
        state = step(state)
    return words[-2:]


def sobol_key(seed, pixel, sample):
    a, b = seeds(seed)
    return hash_word(hash_word(pixel ^ a) ^ sample >> 16 ^ b), reverse(sample & 0xFFFF)


def scramble(n, seed):
    n ^= n * 0x3D20ADEA & WORD
    n = (n + seed) * (seed >> 16 | 1) & WORD
    n ^= n * 0x05526C56 & WORD
    return n ^ n * 0x53A22864 & WORD


def sobol_words(key, index, position, edge):
    seed = hash_word(key ^ hash_word(hash_word(position)))
    if edge > LAST_SOBOL_EDGE:
        first = hash_word(seed ^ index)
        return [first, hash_word(first)]
    place = reverse(scramble(index, hash_word(seed ^ 0x79C68E4A)) & 0xFFFF0000)
    # Sobol's second dimension, its digits reversed: bit k is the parity of the bits of `place` at supersets of k.
    second = sum((sum(place >> j & 1 for j in range(16) if j & k == k) & 1) << k for k in range(16))
    base = seed * 0x9C8F2D3B & WORD
    return [reverse(scramble(n, hash_word(base ^ salt))) for n, salt in ((place, 0x912F69BA), (second, 0x174F18AB))]


def expected(section, case):
    """What the specification says of a case's inputs, as the vectors write it."""
    text = "{:#010x}".format
    if section == "hash":
        return {"hash": text(hash_word(int(case["word"], 16)))}
    seed, pixel = int(case["seed"], 16), case["row"] << 16 | case["column"]
    position = 14 * case["edge"] + 2 * DIMENSIONS.index(case["dimension"])
    if section == "pcg":
        key, index = pcg_key(seed, pixel, case["sample"])
        words = pcg_words(key, index, position)
    else:
        key, index = sobol_key(seed, pixel, case["sample"])
        words = sobol_words(key, index, position, case["edge"])
    # A number (word >> 9) / 2^23 as the bits of a float.
    bits = [struct.unpack("<I", struct.pack("<f", (word >> 9) / 2**23))[0] for word in words]
    fields = {"key": text(key), "index": text(index), "position": position, "numbers_bits": list(map(text, bits))}
    return fields | ({"words": list(map(text, words))} if section == "pcg" else {})


def difference(section, case):
    """The first field that is not what the specification says, as text."""
    for field, value in expected(section, case).items():
        if case[field] != value:
            return f"{field} is {case[field]}, and the specification gives {value}"
    return None


def changed(value):
    """The same, but for its last digit."""
    if isinstance(value, list):
        return value[:-1] + [changed(value[-1])]
    if isinstance(value, str):
        return value[:-1] + ("1" if value[-1] == "0" else "0")
    return value + 1


def main():
    options = [word for word in sys.argv[1:] if word == "--self-test"]
    paths = [word for word in sys.argv[1:] if word not in options] or ["docs/vectors/samplers.json"]
    with open(paths[0]) as file:
        sections = json.load(file)["sections"]
    cases = [(section, number, case) for section in sections for number, case in enumerate(sections[section]["cases"])]
    for section, number, case in cases:
        if found := difference(section, case):
            sys.exit(f"{paths[0]}: {section}, case {number}: {found}")
        for field in expected(section, case) if options else ():
            if difference(section, case | {field: changed(case[field])}) is None:
                sys.exit(f"{section}, case {number}: a change of {field} is not found")
    print(f"{paths[0]}: {len(cases)} cases, as the specification has them" + ("; every change is found" if options else ""))


if __name__ == "__main__":
    main()
