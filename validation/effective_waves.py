#!/usr/bin/env python3
"""The mean wave among equal hard spheres: `data/effective_waves.json` (standard library alone).

Quasi-crystalline approximation for Δu + k0² η² u = 0. The field that excites a sphere at z is
e^{iKz} Σ (2n+1) iⁿ Xₙ jₙ(kρ) Pₙ. It is the waves of all others, averaged with the pair correlation g:
Xₙ = 4π N Σ_ν (2ν+1) T_ν X_ν Σ_q c_q ∫ g(r) h_q(kr) j_q(Kr) r² dr, with PₙP_ν = Σ c_q P_q (Adams) and N
spheres per volume. Green's theorem gives the integral of 1 beyond contact (its part at infinity extinguishes
the incident wave), Gauss's rule in shells of one diameter that of g - 1. K makes the determinant vanish:
secants along a growing volume fraction, from K² = k² + 4π N f(0). Percus and Yevick's r (g - 1) is a Taylor
series in every shell, from Wertheim's Laplace transform. Every run makes and prints the checks below.

    python3 validation/effective_waves.py

Fikioris and Waterman, J. Math. Phys. 5 (1964) 1413; Linton and Martin, SIAM J. Appl. Math. 66 (2006) 1649;
Lloyd and Berry, Proc. Phys. Soc. 91 (1967) 678; Gower and Kristensson, New J. Phys. 23 (2021) 063083;
Wertheim, Phys. Rev. Lett. 10 (1963) 321.
"""

import cmath
import json
import math
import pathlib

PI = math.pi
DATA = pathlib.Path(__file__).resolve().parent / "data"
WAVELENGTH, ORDER = 0.55, 9  # the highest partial wave
GROUPS = [(2.0, 1.5, 0.25, (0.02, 0.05, 0.1, 0.2)), (1.4 + 0.02j, 1.558, 0.25, (0.05, 0.1, 0.2, 0.3)),
          (2.5, 1.5, 0.25, (0.05, 0.08, 0.15)), (1.7, 1.5, 0.2, (0.05, 0.1, 0.2))]


def bessel(order, z):
    """j_0 … j_order by recurrence downwards."""
    top = order + 24 + int(abs(z))
    values = [0j] * top + [1e-280]
    for q in range(top - 1, 0, -1):
        values[q - 1] = (2 * q + 1) / z * values[q] - values[q + 1]
    first, second = cmath.sin(z) / z, (cmath.sin(z) / z - cmath.cos(z)) / z
    scale = first / values[0] if abs(values[0]) > abs(values[1]) else second / values[1]
    return [value * scale for value in values[: order + 1]]


def hankel(order, z):
    values = [cmath.exp(1j * z) / (1j * z), -cmath.exp(1j * z) * (z + 1j) / (z * z)]
    for q in range(1, order):
        values.append((2 * q + 1) / z * values[q] - values[q - 1])
    return values


def slopes(values, z):
    return [q / z * values[q] - values[q + 1] for q in range(len(values) - 1)]


def legendre(top, x):
    values = [1.0, x]
    for n in range(1, top):
        values.append(((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1))
    return values


def gauss(count):
    """Places and weights from 0 to 1."""
    for i in range(count):
        x = math.cos(PI * (i + 0.75) / (count + 0.5))
        for _ in range(20):
            *_, low, p = legendre(count, x)
            slope = count * (x * p - low) / (x * x - 1)
            x -= p / slope
        yield (1 + x) / 2, 1 / ((1 - x * x) * slope * slope)


def product(n, m):
    """The (q, c_q) of PₙPₘ = Σ c_q P_q."""
    a = lambda r: math.comb(2 * r, r) / 2**r
    return [(n + m - 2 * r, a(r) * a(n - r) * a(m - r) / a(n + m - r) * (2 * (n + m - 2 * r) + 1)
             / (2 * (n + m - r) + 1)) for r in range(min(n, m) + 1)]


RULE = list(gauss(16))
PRODUCTS = {(n, m): product(n, m) for n in range(ORDER + 4) for m in range(ORDER + 4)}


def single(k, inside, radius, order=ORDER, density=1.0):
    """T of one sphere; `density`: that of the sphere over that of its host, 1 where grad u is continuous."""
    j, h = bessel(order + 1, k * radius), hankel(order + 1, k * radius)
    i, ratio = bessel(order + 1, inside * radius), inside / (k * density)
    rows = zip(j, h, i, slopes(j, k * radius), slopes(h, k * radius), slopes(i, inside * radius))
    return [-(dj * i - ratio * j * di) / (dh * i - ratio * h * di) for j, h, i, dj, dh, di in rows]


def far_field(k, t, cosine=1.0):
    """f(θ) = -i/k Σ (2n+1) Tₙ Pₙ(cos θ)"""
    return -1j / k * sum((2 * n + 1) * a * p for n, (a, p) in enumerate(zip(t, legendre(len(t), cosine))))


def percus_yevick(p, size=36):
    """Places r, weights times r², g - 1, in diameters; w = r (g - 1) solves S(D) w(r) = -L(D) w(r-1)."""
    s = [-12 * p * (1 + 2 * p), 18 * p * p, 6 * p * (1 - p), (1 - p) ** 2]
    l = [12 * p * (1 + 2 * p), 12 * p * (1 + p / 2)]
    contact = (1 + p / 2) / (1 - p) ** 2
    slope = (1 + 2 * p - s[2] * contact) / s[3]
    w, points = [0.0, -1.0] + [0.0] * (size - 1), []
    for shell in range(1, 60):
        last, w = w, [sum(c * math.comb(j, i) for j, c in enumerate(w)) for i in range(3)]
        if shell == 1:
            w = [contact - 1, slope - 1, -(s[2] * slope + s[1] * contact) / s[3] / 2]
        elif shell == 2:
            w[2] -= l[1] * contact / s[3] / 2
        for j in range(size - 2):
            known = l[1] * (j + 1) * last[j + 1] + l[0] * last[j]
            known += s[2] * (j + 2) * (j + 1) * w[j + 2] + s[1] * (j + 1) * w[j + 1] + s[0] * w[j]
            w.append(-known / (s[3] * (j + 3) * (j + 2) * (j + 1)))
        for t, weight in RULE:
            r = shell + t
            points.append((r, weight * r * r, sum(c * t**j for j, c in enumerate(w)) / r))
        if max(abs(h * r) for r, _, h in points[-len(RULE):]) < 1e-11:
            return points
    raise ArithmeticError("no end of the pair correlation")


def structure(p, q):
    """Percus and Yevick's structure factor from the direct correlation, q in 1/diameter."""
    a, b = (1 + 2 * p) ** 2 / (1 - p) ** 4, -6 * p * (1 + p / 2) ** 2 / (1 - p) ** 4
    return 1 / (1 + 24 * p / q * sum(weight * r * math.sin(q * r) * (a + b * r + p * a / 2 * r**3)
                                     for r, weight in RULE))


class Medium:
    """The determinant of a random medium as a function of Δ = K² - k²."""

    def __init__(self, k, inside, d, fraction, pair, order=ORDER, density=1.0):
        self.k, self.d, self.order, self.amount = k, d, order, 24 * fraction / d**3  # 4π N
        self.t, self.h = single(k, inside, d / 2, order, density), hankel(2 * order + 1, k * d)
        self.points = [(r * d, [weight * g * d**3 * h for h in hankel(2 * order, k * r * d)])
                       for r, weight, g in (percus_yevick(fraction) if pair == "percus_yevick" else [])]

    def determinant(self, delta):
        k, d, h, top, wave = self.k, self.d, self.h, 2 * self.order + 1, cmath.sqrt(self.k**2 + delta)
        j = bessel(top, wave * d)
        dj, dh = slopes(j, wave * d), slopes(h, k * d)
        kernels = [d * d * (wave * h[q] * dj[q] - k * dh[q] * j[q]) / delta for q in range(top)]
        for r, weights in self.points:
            kernels = [kernel + w * j for kernel, w, j in zip(kernels, weights, bessel(top - 1, wave * r))]
        size, value = self.order + 1, delta
        waves = [self.amount * (2 * v + 1) * t for v, t in enumerate(self.t)]
        m = [[(n == v) - waves[v] * sum(c * kernels[q] for q, c in PRODUCTS[n, v]) for v in range(size)]
             for n in range(size)]
        for c in range(size):
            pivot = max(range(c, size), key=lambda row: abs(m[row][c]))
            m[c], m[pivot] = m[pivot], m[c]
            value *= m[c][c] if pivot == c else -m[c][c]
            for row in range(c + 1, size):
                m[row] = [x - m[row][c] / m[c][c] * y for x, y in zip(m[row], m[c])]
        return value

    def root(self, guess):
        old, new = guess * (1 + 1e-4 + 1e-4j), guess
        before, now = self.determinant(old), self.determinant(new)
        for _ in range(40):
            old, new, before = new, new - now * (new - old) / (now - before), now
            now = self.determinant(new)
            if abs(new - old) < 1e-13 * abs(new) or now == before:
                return new
        raise ArithmeticError("no root")


def follow(k, inside, d, fraction, pair, step=0.02, **more):
    """The medium and its Δ, along a growing volume fraction."""
    count, ratios = math.ceil(fraction / step), []
    for i in range(1, count + 1):
        medium = Medium(k, inside, d, fraction * i / count, pair, **more)
        ratios = ratios or [far_field(k, medium.t)] * 2
        ratios.append(medium.root(medium.amount * (2 * ratios[-1] - ratios[-2])) / medium.amount)
    return medium, medium.amount * ratios[-1]


def second(k, species, spacing=1.0, misprint=False):
    """Linton and Martin's N² in K² for species (N, T, radius); distances of contact times `spacing`."""
    total = 0j
    for n1, t1, a1 in species:
        for n2, t2, a2 in species:
            x, top = k * (a1 + a2) * spacing, 2 * len(t1) - 1
            j, h = bessel(top, x), hankel(top, x)
            d = [x * dj * (x * dh + h[q]) + (x * x - q * (q + 1)) * j[q] * (j if misprint else h)[q]
                 for q, (dj, dh) in enumerate(zip(slopes(j, x), slopes(h, x)))]
            total += n1 * n2 * x * sum((2 * n + 1) * (2 * v + 1) * t * u * c * d[q]
                                       for n, t in enumerate(t1) for v, u in enumerate(t2)
                                       for q, c in PRODUCTS[n, v])
    return 8j * PI**2 / k**4 * total


def near(what, found, expected, tolerance):
    error = abs(found / expected - 1)
    print(f"{what}: {found:.10g}, expected {expected:.10g}, relative difference {error:.0e}")
    assert error < tolerance, what


def checks():
    hole_structure = lambda p, q: 1 - 24 * p * (math.sin(q) - q * math.cos(q)) / q**3
    for fraction, q in ((0.15, 2.0), (0.3, 6.5)):
        beyond = sum(weight * h * math.sin(q * r) / (q * r) for r, weight, h in percus_yevick(fraction))
        found = hole_structure(fraction, q) + 24 * fraction * beyond
        near(f"Percus and Yevick, S({q}) at {fraction}", found, structure(fraction, q), 1e-11)

    k0, host, d = 2 * PI / WAVELENGTH, 1.5, 0.25
    k = k0 * host
    t = single(k, 2 * k0, d / 2)
    sphere = [(1 / (4 * PI), t, d / 2)]  # 4π N = 1
    for pair in ("hole", "percus_yevick"):
        low = [(m.amount, delta) for m, delta in (follow(k, 2 * k0, d, f, pair) for f in (1e-5, 5e-6))]
        (big, over), (small, under) = ((amount, delta / amount) for amount, delta in low)
        near(f"dilute, {pair}: forward scattering", 2 * under - over, far_field(k, t), 1e-8)
        near(f"dilute, {pair}: second order", (over - under) / (big - small), second(k, sphere), 1e-4)
    square = lambda s: far_field(k, t, 1 - 2 * s * s) ** 2  # s = sin(θ/2); Lloyd and Berry by parts
    berry = sum(weight * (square(0) - square(s)) / s**2 for s, weight in RULE) / (4 * k * k)
    near("dilute, points: Lloyd and Berry", second(k, sphere, 1e-4), berry, 1e-6)

    k0 = 2 * PI / 250  # long waves: the mean of η², and the attenuation of monopoles
    contrast = (2**2 - host**2) * k0**2
    for pair, at_zero in (("hole", hole_structure(0.1, 1e-2)), ("percus_yevick", structure(0.1, 1e-3))):
        medium, delta = follow(host * k0, 2 * k0, d, 0.1, pair)
        near(f"long waves, {pair}: K² - k²", delta.real, 0.1 * contrast, 1e-4)
        damping = medium.amount * medium.k * (contrast * (d / 2) ** 3 / 3) ** 2 * at_zero
        near(f"long waves, {pair}: Im K²", delta.imag, damping, 1e-3)
    # EffectiveWaves.jl, test/acoustics-3D/low_frequency.jl
    medium, delta = follow(0.01 / 1.5, 0.01 / 10.1, 0.002, 0.15, "hole", order=2, density=8.5)
    bulk, mass = 1 + 0.15 * (1.5**2 / (8.5 * 10.1**2) - 1), 0.15 * (1 - 8.5) / (1 + 2 * 8.5)
    expected = bulk * (1 - mass) / (1 + 2 * mass)
    near("long waves, heavy spheres: K²/k²", 1 + delta / medium.k**2, expected, 1e-10)

    k0, fraction = 2 * PI / WAVELENGTH, 0.15  # weak spheres, contrasts of both signs
    for pair, factor in (("hole", hole_structure), ("percus_yevick", structure)):
        ratios = []
        for inside in (host - 1e-3, host + 1e-3):
            medium, delta = follow(k, inside * k0, d, fraction, pair)
            born = 0.0
            for s, weight in RULE:  # s = sin(θ/2), dΩ = 8π s ds
                x = k * d * s
                shape = (math.sin(x) - x * math.cos(x)) / x**3
                f = k0**2 * (inside**2 - host**2) * (d / 2) ** 3 * shape
                born += weight * 2 * medium.amount * s * f * f * factor(fraction, 2 * x)
            ratios.append(2 * cmath.sqrt(k * k + delta).imag / born)
        near(f"weak spheres, {pair}: 2 Im K over Born's", sum(ratios) / 2, 1.0, 1e-5)

    # EffectiveWaves.jl (361bbe2), docs/src/manual/wavenumbers.md: two fluids. The number is of 2020, with
    # contact at 1.005 and j² for j h in the second order, which its change c802975 corrected.
    fluids = [(f / (4 / 3 * PI * a**3), single(1 / 1.5, 1 / c, a, 2, density / 1.2), a)
              for f, density, c, a in ((0.02, 10.2, 10.1, 0.3), (0.03, 0.2, 4.1, 0.2))]
    first = sum(4 * PI * n * far_field(1 / 1.5, t) for n, t, _ in fluids)
    found = cmath.sqrt(1 / 1.5**2 + first + second(1 / 1.5, fluids, 1.005, misprint=True))
    near("two dilute fluids, EffectiveWaves.jl", found, 0.6477267068908865 + 3.20821643199973e-5j, 1e-14)


def case(inside, host, d, fraction):
    k0 = 2 * PI / WAVELENGTH
    result = {"name": f"n{inside.real:g}{'a' if inside.imag else ''}_in_{host:g}_d{d:g}_at_{fraction:g}",
              "wavelength_um": WAVELENGTH, "diameter_um": d, "sphere_index": [inside.real, inside.imag],
              "host_index": host, "volume_fraction": fraction}
    for pair in ("hole", "percus_yevick"):
        _, delta = follow(k0 * host, k0 * inside, d, fraction, pair)
        _, fine = follow(k0 * host, k0 * inside, d, fraction, pair, step=0.01, order=ORDER + 3)
        assert abs(fine / delta - 1) < 1e-11, "partial waves and steps"
        index = cmath.sqrt(host**2 + delta / k0**2)
        result[f"effective_index_{pair}"] = [round(index.real, 10), round(index.imag, 10)]
    return result


if __name__ == "__main__":
    checks()
    doc = ("Effective index K/k0 of the mean scalar wave among equal hard spheres: quasi-crystalline "
           "approximation with g = 1 beyond contact (hole) and with Percus and Yevick's g; e^{-iωt}; "
           "u and grad u continuous. Fikioris and Waterman 1964, Linton and Martin 2006, Wertheim 1963; made "
           "and checked by validation/effective_waves.py: 9 digits of the approximation, not of the truth.")
    cases = [case(complex(inside), host, d, f) for inside, host, d, fractions in GROUPS for f in fractions]
    text = json.dumps({"doc": doc, "cases": cases}, indent=1, ensure_ascii=False)
    (DATA / "effective_waves.json").write_text(text + "\n", encoding="utf-8")
