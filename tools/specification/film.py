"""Sections 11 and 12 of docs/specification.md: exact sums of a pixel's samples, what they show, and how they are hashed."""

from fractions import Fraction

from specification.arithmetic import f


def blocks(samples):
    """Of each 16 samples: how many are kept, their sum and the sum of their squares, in f64."""
    for first in range(0, len(samples), 16):
        block = [sample for sample in samples[first : first + 16] if all(abs(x) < 2**32 for x in sample)]
        sums, squares = [0.0] * 3, [0.0] * 3
        for sample in block:
            sums = [s + float(x) for s, x in zip(sums, sample)]
            squares = [q + float(x) ** 2 for q, x in zip(squares, sample)]
        yield len(block), sums, squares


def sums_of(samples):
    """Samples kept, and for each channel the sum in units of 2^-64 and the sum of squares in units of 2^-40."""
    count, sums, squares = 0, [0, 0, 0], [0, 0, 0]
    for kept, block_sums, block_squares in blocks(samples):
        count += kept
        sums = [total + round(Fraction(s) * 2**64) for total, s in zip(sums, block_sums)]
        squares = [min(total + round(Fraction(q) * 2**40), 2**127 - 1) for total, q in zip(squares, block_squares)]
    return count, sums, squares


def mean_of(count, sums):
    return [f(float(s) * 2.0**-64 / count) if count else f(0) for s in sums]


def variance_of(count, sums, squares):
    """Of the mean."""
    n = float(count)
    spread = [max(count * q * 2**88 - s * s, 0) for s, q in zip(sums, squares)]
    return [f(float(x) * 2.0**-128 / (n * n * (n - 1))) if count > 1 else f(0) for x in spread]


def record(column, row, count, sums, squares):
    """What a pixel adds to the hash."""
    words = b"".join(word.to_bytes(4, "little") for word in (column, row, count))
    return words + b"".join((n % 2**128).to_bytes(16, "little") for n in sums + squares)
