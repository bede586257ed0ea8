"""Sections 11 and 12 of docs/specification.md: exact sums of a pixel's samples, what they show, and how they are hashed."""

from fractions import Fraction

from specification.arithmetic import f


def sums_of(samples):
    """Samples kept, and for each channel the sum in units of 2^-64 and the sum of squares in units of 2^-40."""
    count, sums, squares = 0, [0, 0, 0], [0, 0, 0]
    for first in range(0, len(samples), 16):
        block = [sample for sample in samples[first : first + 16] if all(abs(x) < 2**32 for x in sample)]
        count += len(block)
        for channel in range(3):
            s = q = 0.0
            for sample in block:
                s += float(sample[channel])
                q += float(sample[channel]) ** 2
            sums[channel] += round(Fraction(s) * 2**64)
            squares[channel] = min(squares[channel] + round(Fraction(q) * 2**40), 2**127 - 1)
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
