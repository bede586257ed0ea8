"""Section 8 of docs/specification.md: BSDFs, from what is computed of a material and from factors of its maps."""

from specification.arithmetic import *

# Colour, metallic, roughness.
NO_MAPS = (V(1, 1, 1), F(1), F(1))


class Lambert:
    def __init__(self, row, maps=NO_MAPS):
        self.color = V(*row[:3]) * maps[0]

    def eval(self, wo, wi):
        pdf = greatest(wi.z, F(0)) * INV_PI
        return self.color * pdf, pdf

    def sample(self, wo, u, v, lobe):
        wi = cosine_hemisphere(u, v)
        return wi, self.color, wi.z * INV_PI


class Mirror(Lambert):
    def sample(self, wo, u, v, lobe):
        return V(-wo.x, -wo.y, wo.z), self.color, INF


class Glass:
    def __init__(self, row, maps=NO_MAPS):
        self.sides = row[:3], row[3:6]

    def sample(self, wo, u, v, lobe):
        eta, eta2, g = self.sides[wo.z < 0]
        ci = abs(wo.z)
        ct2 = fma(eta2, ci * ci, g)
        ct = safe_sqrt(ct2)
        s = g / greatest(square(fma(eta, ci, ct)), TINY)
        p = g * fma(F(1) + eta2, ci * ci, -eta2) / greatest(square(fma(eta, ct, ci)), TINY)
        fresnel = least(fma(square(s), F(0.5), square(p) * F(0.5)), F(1))
        if ct2 <= 0 or lobe < fresnel:
            return V(-wo.x, -wo.y, wo.z), gray(F(1)), INF
        return V(-(eta * wo.x), -(eta * wo.y), ct if wo.z < 0 else -ct), gray(eta2), INF


class Mixture:
    """What draws from one of two lobes, and then asks for value and density of both together."""

    def weighed(self, wo, wi):
        value, pdf = self.eval(wo, wi)
        return wi, value * (F(1) / pdf) if pdf > 0 else V(0, 0, 0), pdf


class Phong(Mixture):
    def __init__(self, row, maps=None):
        self.diffuse, self.specular, self.n, self.choose = V(*row[:3]), V(*row[3:6]), row[6], row[7]
        if maps:
            self.diffuse = self.diffuse * maps[0]
            both = luminance(self.diffuse) + luminance(self.specular)
            self.choose = luminance(self.specular) / greatest(both, TINY)

    def eval(self, wo, wi):
        if not (wi.z > 0 and wo.z >= 0):
            return V(0, 0, 0), F(0)
        d = wi - V(-wo.x, -wo.y, wo.z)
        h = dot(d, d) * F(0.5)
        lobe = pow_one_minus(h, self.n) * INV_TAU if h < 1 else F(0)
        cosine = wi.z * INV_PI
        value = fma(self.diffuse, cosine, self.specular * (lobe * (self.n + 2) * wi.z))
        return value, fma(self.choose, lobe * (self.n + 1), (F(1) - self.choose) * cosine)

    def sample(self, wo, u, v, lobe):
        if lobe < self.choose:
            wi = Frame(V(-wo.x, -wo.y, wo.z)).to_world(cosine_power(u, v, self.n))
        else:
            wi = cosine_hemisphere(u, v)
        return self.weighed(wo, wi)


class Ggx:
    def __init__(self, alpha, alpha2, inverse, peak):
        self.alpha, self.alpha2, self.inverse, self.peak = alpha, alpha2, inverse, peak

    def stretched(self, w):
        return sqrt(fma(fma(w.x, w.x, square(w.y)), self.alpha2, square(w.z)))

    def eval(self, wo, wi):
        if not (wo.z > 0 and wi.z > 0):
            return F(0), F(0)
        h = wo + wi
        s2, c2 = fma(h.x, h.x, square(h.y)), square(h.z)
        q = (s2 + c2) / greatest(fma(s2, self.inverse, c2), TINY)
        d = square(q) * self.peak * F(0.5)
        so, si = self.stretched(wo), self.stretched(wi)
        return d * wi.z / fma(so, wi.z, si * wo.z), d / (so + wo.z)

    def weight(self, wo, wi):
        so, si = self.stretched(wo), self.stretched(wi)
        return wi.z * (so + wo.z) / fma(so, wi.z, si * wo.z)

    def sample(self, wo, u, v):
        w = normalize(V(wo.x * self.alpha, wo.y * self.alpha, wo.z))
        height = F(1) + w.z
        below = u * height
        r = safe_sqrt(below * (F(2) - below))
        s, c = sin_cos_turns(v)
        m = normalize(V(fma(r, c, w.x) * self.alpha, fma(r, s, w.y) * self.alpha, (F(1) - u) * height))
        return fma(m, dot(wo, m) * 2, -wo)


class Conductor:
    def __init__(self, row, maps=NO_MAPS):
        self.color, self.ggx = V(*row[:3]) * maps[0], Ggx(*row[3:7])

    def eval(self, wo, wi):
        value, pdf = self.ggx.eval(wo, wi)
        return self.color * value, pdf

    def sample(self, wo, u, v, lobe):
        wi = self.ggx.sample(wo, u, v)
        pdf = self.ggx.eval(wo, wi)[1]
        return wi, self.color * self.ggx.weight(wo, wi) if pdf > 0 else V(0, 0, 0), pdf


class Principled(Mixture):
    def __init__(self, row, maps=NO_MAPS):
        self.color = V(*row[:3]) * maps[0]
        self.metallic, rough, self.normal, self.grazing = row[3] * maps[1], row[4] * maps[2], row[5], row[6]
        alpha = greatest(square(rough), f(1e-4))
        inverse = F(1) / square(alpha)
        self.ggx = Ggx(alpha, square(alpha), inverse, inverse * INV_PI)
        k = F(1) / fma(alpha, fma(alpha, F(20), F(6)), F(1))
        self.b0 = alpha * k * f(0.01)
        self.b3 = fma(alpha, f(1.2), f(0.23)) * k
        self.b5 = fma(alpha, f(-0.92), f(0.77)) * k
        self.fade = self.grazing - self.normal

    def bound(self, cos):
        x = F(1) - cos
        x2 = square(x)
        return fma(fma(self.b5, x2, self.b3), x2 * x, self.b0)

    def through(self, cos):
        return greatest(fma(-self.fade, self.bound(cos), F(1) - self.normal), F(0))

    def lobes(self, wo):
        """Reflectance along a facet's normal, at grazing angles, of the base, and the chance of the specular lobe."""
        dielectric = F(1) - self.metallic
        normal = fma(self.color, self.metallic, gray(self.normal * dielectric))
        grazing = self.grazing * dielectric + self.metallic
        mean = fma(self.b5, f(1 / 21), fma(self.b3, f(0.1), self.b0))
        mean = fma(-self.fade, mean, F(1) - self.normal)
        color = self.color * dielectric
        base = color * (self.through(wo.z) / greatest(mean, TINY))
        along = luminance(normal)
        specular = fma(grazing - along, self.bound(wo.z), along)
        both = fma(luminance(color), self.through(wo.z), specular)
        return normal, grazing, base, specular / greatest(both, TINY)

    def eval(self, wo, wi):
        normal, grazing, base, choose = self.lobes(wo)
        facets, density = self.ggx.eval(wo, wi)
        cos = sqrt(dot(wo + wi, wo + wi)) * F(0.5)
        rest = greatest(F(1) - cos, F(0))
        schlick = square(square(rest)) * rest
        fresnel = fma(normal, F(1) - schlick, gray(grazing * schlick))
        cosine = wi.z * INV_PI if wo.z > 0 and wi.z > 0 else F(0)
        value = fma(base, self.through(wi.z) * cosine, fresnel * facets)
        return value, fma(choose, density, (F(1) - choose) * cosine)

    def sample(self, wo, u, v, lobe):
        choose = self.lobes(wo)[3]
        return self.weighed(wo, self.ggx.sample(wo, u, v) if lobe < choose else cosine_hemisphere(u, v))
