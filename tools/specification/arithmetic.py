"""Sections 2, 3 and 5 of docs/specification.md: f32 arithmetic, elementary functions, vectors, frames, warps.

Where a product and a sum are rounded once, they are exact rationals until then.
"""

import ctypes
import math
import struct
from fractions import Fraction

# Section 2: arithmetic. Sums, products, quotients and roots of f32 are rounded rightly by way of f64 (Figueroa 1995).


def rounded(x):
    return F(ctypes.c_float(x).value)


class F(float):
    """An f32."""

    def __add__(self, o):
        return rounded(float(self) + float(F(o)))

    def __sub__(self, o):
        return rounded(float(self) - float(F(o)))

    def __mul__(self, o):
        return rounded(float(self) * float(F(o))) if isinstance(o, (int, float)) else o * self

    def __truediv__(self, o):
        if o == 0:
            zero = math.isnan(self) or self == 0
            return F(math.nan if zero else math.copysign(math.inf, self) * math.copysign(1, o))
        return rounded(float(self) / float(F(o)))

    def __neg__(self):
        return F(-float(self))

    def __abs__(self):
        return F(abs(float(self)))


def f(x):
    """The nearest f32 of a constant, or of a result in f64."""
    return rounded(float(x))


def bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def of_bits(word):
    return F(struct.unpack("<f", struct.pack("<I", word))[0])


def to_f32(x):
    """A rational to the nearest f32, ties to even."""
    if x == 0:
        return F(0.0)
    exponent = max(math.frexp(float(abs(x)))[1] - 24, -149) if abs(x) > Fraction(1, 2**1000) else -149
    unit = Fraction(2) ** exponent
    return rounded(float(round(x / unit) * unit))


def fma(a, b, c):
    if isinstance(a, V):
        b3 = b if isinstance(b, V) else V(b, b, b)
        c3 = c if isinstance(c, V) else V(c, c, c)
        return V(*map(fma, a, b3, c3))
    a, b, c = F(a), F(b), F(c)
    if not all(map(math.isfinite, (a, b, c))):
        return a * b + c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    return to_f32(exact) if exact != 0 else a * b + c


def sqrt(x):
    return f(math.sqrt(x)) if x >= 0 else F(math.nan)


def least(a, b):
    return a if a < b else b


def greatest(a, b):
    return a if a > b else b


def safe_sqrt(x):
    return sqrt(greatest(x, F(0)))


def clamp(x):
    return least(x, F(1)) if x > 0 else F(0)


PI = f(math.pi)
TAU = f(2 * math.pi)
QUARTER_PI = f(math.pi / 4)
INV_PI = of_bits(0x3EA2F983)
INV_TAU = of_bits(0x3E22F983)
EPSILON = F(2**-23)
TINY = F(2**-126)
INF = F(math.inf)


def square(x):
    return x * x


def sin_cos(x):
    x2 = x * x
    s = fma(x2 * x, fma(x2, fma(x2, f(-1.9515296e-4), f(8.332161e-3)), f(-1.6666655e-1)), x)
    c = fma(x2 * x2, fma(x2, fma(x2, f(2.4433157e-5), f(-1.3887316e-3)), f(4.1666646e-2)), fma(x2, F(-0.5), F(1)))
    return s, c


def sin_cos_turns(u):
    k = F(round(u * 4))
    s, c = sin_cos(fma(-k, F(0.25), u) * TAU)
    return [(s, c), (c, -s), (-s, -c), (-c, s)][int(k) % 4]


def poly5(x, c):
    x2 = x * x
    return fma(fma(c[3], x, c[2]), x2, fma(fma(c[5], x, c[4]), x2 * x2, fma(c[1], x, c[0])))


def exp_parts(x):
    r = F(round(x * f(1.442695040888963)))
    y = fma(-r, f(-2.1219444e-4), fma(-r, F(0.693359375), x))
    z = poly5(y, [f(1 / n) for n in (2, 6, 24, 120, 720, 5040)])
    return r, fma(z, y * y, y)


def exp(x):
    r, z = exp_parts(x)
    return (z + 1) * F(2.0 ** int(r))


def expm1(x):
    r, z = exp_parts(x)
    return x if x == 0 else z if r == 0 else (z + 1) * F(2.0 ** int(r)) - 1


LN = [3.3333331174e-1, -2.4999993993e-1, 2.0000714765e-1, -1.6668057665e-1, 1.4249322787e-1]
LN += [-1.2420140846e-1, 1.1676998740e-1, -1.1514610310e-1, 7.0376836292e-2]


def ln(x):
    fraction, e = math.frexp(x)
    fraction = F(fraction)
    t, k = (fraction - 1, F(e)) if fraction > of_bits(0x3F3504F3) else ((fraction + fraction) - 1, F(e - 1))
    c, t2 = [f(value) for value in LN], t * t
    t4 = t2 * t2
    high = fma(t2, fma(c[7], t, c[6]), fma(t, c[5], c[4]))
    low = fma(t4 * t4, c[8], fma(t2, fma(t, c[3], c[2]), fma(t, c[1], c[0])))
    q = fma(k, f(-2.1219444e-4), t2 * t * fma(t4, high, low))
    return fma(k, F(0.693359375), q + fma(-t2, F(0.5), t))


def ln1p(x):
    u = x + 1
    return x if u == 1 else x * (ln(u) / (u - 1))


def atan2(y, x):
    swap = abs(y) > abs(x)
    t = abs(x) / abs(y) if swap else abs(y) / abs(x)
    far = t >= f(math.sqrt(2)) - 1
    z = (t - 1) / (t + 1) if far else t
    w = z * z
    p = fma(fma(f(8.05374449538e-2), w, f(-1.38776856032e-1)), w * w, fma(f(1.99777106478e-1), w, f(-3.33329491539e-1)))
    a = fma(p, w * z, z) + (QUARTER_PI if far else 0)
    a = f(math.pi / 2) - a if swap else a
    a = F(0) if x == 0 and y == 0 else a
    a = PI - a if math.copysign(1, x) < 0 else a
    return -a if math.copysign(1, y) < 0 else a


def pow_one_minus(x, y):
    if x >= 1 and y > 0:
        return F(0)
    return exp(greatest(ln1p(-least(x, F(1) - EPSILON)) * y, F(-87)))


# Section 3: vectors, colours, frames.


class V(tuple):
    """A vector or a colour."""

    def __new__(cls, *values):
        return super().__new__(cls, map(F, values))

    x = property(lambda self: self[0])
    y = property(lambda self: self[1])
    z = property(lambda self: self[2])

    def __add__(self, o):
        return V(*(a + b for a, b in zip(self, o)))

    def __sub__(self, o):
        return V(*(a - b for a, b in zip(self, o)))

    def __mul__(self, o):
        return V(*(a * b for a, b in zip(self, o if isinstance(o, V) else (o, o, o))))

    def __neg__(self):
        return V(*(-a for a in self))


def gray(x):
    return V(x, x, x)


def dot(a, b):
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z))


def cross(a, b):
    return V(*(fma(a[i], b[j], -(a[j] * b[i])) for i, j in ((1, 2), (2, 0), (0, 1))))


def normalize(v):
    return v * (F(1) / sqrt(dot(v, v)))


def max_abs(v):
    return greatest(greatest(abs(v.x), abs(v.y)), abs(v.z))


def luminance(c):
    return fma(c[0], f(0.2126), fma(c[1], f(0.7152), c[2] * f(0.0722)))


def plain_luminance(c):
    return f(0.2126) * c[0] + f(0.7152) * c[1] + f(0.0722) * c[2]


class Frame:
    def __init__(self, n):
        s = F(math.copysign(1, n.z))
        a = F(-1) / (s + n.z)
        b = n.x * n.y * a
        self.t = V(fma(s * n.x * n.x, a, F(1)), s * b, -(s * n.x))
        self.b = V(b, fma(n.y * n.y, a, s), -n.y)
        self.n = n

    def to_world(self, v):
        return fma(self.t, v.x, fma(self.b, v.y, self.n * v.z))

    def to_local(self, v):
        return V(dot(self.t, v), dot(self.b, v), dot(self.n, v))


# Section 5: warps.


def disk(u, v):
    a, b = fma(u, F(2), F(-1)), fma(v, F(2), F(-1))
    wide = abs(a) > abs(b)
    r, o = (a, b) if wide else (b, a)
    s, c = sin_cos(o / (F(1) if r == 0 else r) * QUARTER_PI)
    return r * (c if wide else s), r * (s if wide else c), r * r


def cone(u, v, spread):
    x, y, r2 = disk(u, v)
    h = r2 * spread
    k = sqrt(spread * (F(2) - h))
    return V(x * k, y * k, F(1) - h)


def cosine_hemisphere(u, v):
    x, y, r2 = disk(u, v)
    return V(x, y, sqrt(F(1) - r2))


def cosine_power(u, v, n):
    h = -expm1(ln1p(-u) / (n + 1))
    r = safe_sqrt(h * (F(2) - h))
    s, c = sin_cos_turns(v)
    return V(r * c, r * s, F(1) - h)


def cosine_power_pdf(d, n):
    z = greatest(d.z, F(0))
    h = fma(d.x, d.x, d.y * d.y) / (z + 1)
    return pow_one_minus(h, n) * (n + 1) * INV_TAU if d.z > 0 else F(0)


def triangle_warp(u, v):
    lower = u > v
    half = (v if lower else u) * F(0.5)
    return (u - half, half) if lower else (half, v - half)


def tent(u):
    left = u < 0.5
    e = F(1) - sqrt((u if left else F(1) - u) * 2)
    return -e if left else e


def gaussian(u, v):
    r = safe_sqrt(ln1p(u * f(-0.988891)) * F(-0.5))
    s, c = sin_cos_turns(v)
    return r * c, r * s


def gaussian_pdf(x, y):
    r2 = fma(x, x, y * y)
    return exp(r2 * F(-2)) * (F(0.5) * INV_PI / (F(0.25) * f(0.988891)))


def weight(q):
    return F(1) / (F(1) + q * q)


# Section 2: vectors of f64, for what is computed once, and rounded in the end.


def subtract(a, b):
    return [x - y for x, y in zip(a, b)]


def scale(a, s):
    return [x * s for x in a]


def inner(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def outer(a, b):
    return [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]


def unit(a):
    return scale(a, 1 / math.sqrt(inner(a, a)))


def exact(a):
    """What a file's numbers are as f32, in f64."""
    return [float(f(x)) for x in a]


def single(a):
    return V(*map(f, a))
