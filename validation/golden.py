#!/usr/bin/env python3
"""Derives every number that a run publishes, from its study and its solves, independently of the program.

    python3 validation/golden.py --take FOLDER NAME   # the solves of a finished run of validation/data/golden/NAME.toml
    python3 validation/golden.py [NAME …]             # the numbers that follow from them; all studies if none is named
    python3 validation/golden.py --check [NAME …]     # changes nothing; status 1 where a file holds other numbers

Standard library alone, and nothing of the program: own interference matrices, own quadratures, own least squares, own
colour. `tests/suite/golden.rs` hands the same solves to the program and compares value by value. Formulas: P1 section 5, CIE 15,
IEC 61966-2-1, Sharma, Wu and Dalal 2005 (CIEDE2000), Efron and Stein 1981 (jackknife), Eilers and Marx 1996 (splines).
"""

import cmath
import csv
import json
import math
import pathlib
import sqlite3
import struct
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent / "data"
GOLDEN = HERE / "golden"
CHECK = "--check" in sys.argv
PI = math.pi


# ---------------------------------------------------------------- the store: SQLite rows of MessagePack


def unpack(data, at=0):
    """One MessagePack value and the place behind it."""
    code = data[at]
    number = lambda form: (struct.unpack_from(">" + form, data, at + 1)[0], at + 1 + struct.calcsize(form))
    if code < 0x80:
        return code, at + 1
    if code >= 0xE0:
        return code - 256, at + 1
    if code < 0x90:
        return unpack_map(data, at + 1, code & 15)
    if code < 0xA0:
        return unpack_list(data, at + 1, code & 15)
    if code < 0xC0:
        end = at + 1 + (code & 31)
        return data[at + 1 : end].decode(), end
    if code in (0xC0, 0xC2, 0xC3):
        return {0xC0: None, 0xC2: False, 0xC3: True}[code], at + 1
    if code in (0xD9, 0xDA, 0xDB):
        size, at = number({0xD9: "B", 0xDA: "H", 0xDB: "I"}[code])
        return data[at : at + size].decode(), at + size
    if code in (0xDC, 0xDD):
        size, at = number("H" if code == 0xDC else "I")
        return unpack_list(data, at, size)
    if code in (0xDE, 0xDF):
        size, at = number("H" if code == 0xDE else "I")
        return unpack_map(data, at, size)
    forms = {0xCA: "f", 0xCB: "d", 0xCC: "B", 0xCD: "H", 0xCE: "I", 0xCF: "Q", 0xD0: "b", 0xD1: "h", 0xD2: "i", 0xD3: "q"}
    return number(forms[code])


def unpack_list(data, at, size):
    values = []
    for _ in range(size):
        value, at = unpack(data, at)
        values.append(value)
    return values, at


def unpack_map(data, at, size):
    values = {}
    for _ in range(size):
        key, at = unpack(data, at)
        values[key], at = unpack(data, at)
    return values, at


def rounded(value):
    """Ten digits are plenty: both sides read the same ones."""
    if isinstance(value, float):
        return float(f"{value:.10g}")
    if isinstance(value, list):
        return [rounded(v) for v in value]
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    return value


def take(folder, name):
    """Keeps the solves, packings and grid of a run as JSON beside the study."""
    kinds = {"point": [], "packing": [], "grid": []}
    for path in sorted(pathlib.Path(folder, "records").glob("*.sqlite")):
        for kind, content in sqlite3.connect(path).execute("select kind, content from records"):
            if kind in kinds:
                kinds[kind].append(rounded(unpack(content)[0]))
    (grid,) = kinds["grid"]
    exact = Study(name).exact_deg
    place = lambda p: (
        p["incidence"]["wavelength_um"],
        p["incidence"]["from"] == "exit",
        exact.index(p["incidence"]["polar_deg"]) if p["incidence"]["polar_deg"] in exact else len(exact),
        p["incidence"]["polar_deg"],
    )
    realisations = []
    for packing in sorted(kinds["packing"], key=lambda p: p["realisation"]):
        own = sorted((p for p in kinds["point"] if p["realisation"] == packing["realisation"]), key=place)
        for point in own:
            point["key"], point["build"] = "", "golden"
            point["account"]["seconds"] = 0.0
        realisations.append({"packing": packing, "points": own})
    write(GOLDEN / f"{name}-solves.json", {"grid": grid, "realisations": realisations})


def same(one, other):
    """Whether two values of JSON differ by rounding alone, which varies between machines."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-12)
    return one == other


def write(path, value):
    """JSON with a line for each realisation's point or row; with --check only a comparison with what is there."""
    if CHECK:
        there = json.loads(path.read_text())
        return same(json.loads(json.dumps(value)), there) or sys.exit(f"{path.name} is not what follows from its solves")
    path.write_text(json.dumps(value, indent=0, ensure_ascii=False).replace("\n", " ").replace(' { ', '\n{ ') + "\n")


# ---------------------------------------------------------------- the study


class Study:
    """What the study file says, as far as published numbers depend on it."""

    def __init__(self, name, file=None):
        self.file = file or tomllib.loads((GOLDEN / f"{name}.toml").read_text())
        layer, light, angles = self.file["layer"], self.file["light"], self.file["angles"]
        thickness = layer["thickness_um"]
        self.thickness_um, self.thickness_std = (
            (thickness["mean"], thickness["std"]) if isinstance(thickness, dict) else (thickness, 0.0)
        )
        period = layer.get("period_um")
        self.period_um = period if isinstance(period, list) else [period, period]
        self.index_out = layer.get("index_out", 1.0)
        self.contact = self.file["paper"].get("coupling") == "optical_contact"
        if "wavelengths_nm" in light:
            self.wavelengths = [float(nm) for nm in light["wavelengths_nm"]]
        else:
            count = math.floor((light["to_nm"] - light["from_nm"]) / light["step_nm"] + 1e-9)
            self.wavelengths = [light["from_nm"] + i * light["step_nm"] for i in range(count + 1)]
        self.listed = "wavelengths_nm" in light or light.get("sampling") == "listed"
        self.range = [self.wavelengths[0], self.wavelengths[-1]]
        self.intervals = light.get("per_realisation", len(self.wavelengths) - 1)
        self.exact_deg = [float(d) for d in angles.get("polar_deg", [0, 45])]
        self.strata = angles["count"] - 2 if "count" in angles else 3
        self.exit_strata = self.strata if self.contact or "relief" in layer else 0
        self.picture_max = angles.get("picture_max_deg", 60.0)
        self.sky_excluded = self.file.get("output", {}).get("mirrored_sky") == "excluded"
        self.varied = layer.get("cell", "varied") == "varied"
        grains = [p for p in self.file.get("pigment", []) if p["diameter_nm"] != "molecular"]
        dissolved = [p for p in self.file.get("pigment", []) if p["diameter_nm"] == "molecular"]
        self.grains = [index_of(p["index"]) for p in grains]
        # what is dissolved shares the room that the grains leave
        room = 1.0 - sum(p["volume_fraction"] for p in grains)
        binder = index_of(layer["binder"]["index"])
        parts = [(p["volume_fraction"] / room, index_of(p["index"])) for p in dissolved]
        self.binder = lambda nm: cmath.sqrt(
            binder(nm) ** 2 + sum(share * (index(nm) ** 2 - binder(nm) ** 2) for share, index in parts)
        )
        albedo = self.file["paper"]["albedo"]
        self.albedo = (lambda nm: linear(albedo, nm)) if isinstance(albedo, list) else (lambda nm: albedo)
        # without chance: no grains, one thickness
        self.certain = not grains and self.thickness_std == 0.0

    def thicknesses(self):
        """Places of a normal law cut at three standard deviations, and their shares: a rule of Gauss for each of the six."""
        if self.thickness_std == 0.0:
            return [(self.thickness_um, 1.0)]
        places = [(piece + x, w) for piece in range(-3, 3) for x, w in gauss(8)]
        density = [w * math.exp(-0.5 * z * z) for z, w in places]
        whole = sum(density)
        return [(self.thickness_um + self.thickness_std * z, d / whole) for (z, _), d in zip(places, density)]


def bisect(rising, value, low, high):
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rising(middle) < value else (low, middle)
    return 0.5 * (low + high)


def index_of(written):
    """n + iκ against nm: a number, { n, k }, or a table of κ and n, linear between its rows."""
    if isinstance(written, (int, float)):
        return lambda nm: complex(written)
    if "csv" in written:
        with open(GOLDEN / written["csv"], newline="") as file:
            rows = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
        return lambda nm: complex(linear([r[:1] + r[2:] for r in rows], nm), linear([r[:2] for r in rows], nm))
    return lambda nm: complex(written["n"], written.get("k", 0.0))


def linear(rows, x):
    for (x0, y0), (x1, y1) in zip(rows, rows[1:]):
        if x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return rows[-1][1]


# ---------------------------------------------------------------- the coherent film: characteristic matrices


def gauss(count):
    """Gauss–Legendre nodes and weights on 0…1 by Newton's method."""
    rule = []
    for i in range(count):
        x = math.cos(PI * (i + 0.75) / (count + 0.5))
        for _ in range(100):
            p, q = 1.0, 0.0
            for k in range(count):
                p, q = ((2 * k + 1) * x * p - k * q) / (k + 1), p
            slope = count * (x * p - q) / (x * x - 1)
            x -= p / slope
        rule.append((0.5 * (1 + x), 1.0 / ((1 - x * x) * slope * slope)))
    return rule


FINE = gauss(48)


def film(slices, thickness, nm, index_out, deg, from_exit=False):
    """[R, T] of equal slices of permittivities `slices` for s-polarised light, by their characteristic matrices."""
    start, end = (index_out, 1.0) if from_exit else (1.0, index_out)
    along = start * math.sin(math.radians(deg))
    a, c = start * math.cos(math.radians(deg)), cmath.sqrt(complex(end * end - along * along))
    height = 2 * PI / (1e-3 * nm) * thickness / len(slices)
    # field and its slope carried from the far face to the near one, for a transmitted wave of one
    u, v = 1, c
    for square in slices if from_exit else reversed(slices):
        b = cmath.sqrt(square - along * along)
        cos, sin = cmath.cos(b * height), -1j * cmath.sin(b * height)
        u, v = cos * u + sin / b * v, b * sin * u + cos * v
    r, t = (a * u - v) / (a * u + v), 2 * a / (a * u + v)
    return [abs(r) ** 2, c.real / a * abs(t) ** 2]


class Films:
    """The film of the mean profile at any wavelength, averaged over thicknesses."""

    def __init__(self, study, profile):
        self.study, self.profile, self.known, self.made = study, profile, {}, {}

    def slices(self, nm):
        if nm not in self.made:
            self.made[nm] = self.mixed(nm)
        return self.made[nm]

    def mixed(self, nm):
        base = self.study.binder(nm) ** 2
        others = [index(nm) ** 2 for index in self.study.grains] + [1.0]
        return [base + sum(phi * (square - base) for phi, square in zip(row, others)) for row in self.profile]

    def at(self, nm, deg, thicknesses, from_exit=False):
        key = (nm, deg, tuple(thicknesses), from_exit)
        if key not in self.known:
            each = [(film(self.slices(nm), h, nm, self.study.index_out, deg, from_exit), share) for h, share in thicknesses]
            self.known[key] = [sum(share * rt[i] for rt, share in each) for i in range(2)]
        return self.known[key]

    def totals(self, nm, deg, thicknesses):
        r, t = self.at(nm, deg, thicknesses)
        return [r, r, t, t, 1 - r - t]

    def means(self, nm, thicknesses):
        """T̄ and R̄ from the incident side, Ā from the exit side."""
        parts = [(mu, w, self.at(nm, math.degrees(math.acos(mu)), thicknesses)) for mu, w in FINE]
        r, t = [sum(2 * mu * w * rt[i] for mu, w, rt in parts) for i in range(2)]
        if not self.study.exit_strata:
            return t, r, 1 - r - t
        lost = lambda mu: 1 - sum(self.at(nm, math.degrees(math.acos(mu)), thicknesses, True))
        inner = 1 / self.study.index_out**2  # the cone inside the critical angle, as a share of μ²
        # both sides of the critical angle in variables that are smooth there
        absorbed = sum(w * 2 * x * inner * lost(math.sqrt(1 - inner + inner * x * x)) for x, w in FINE)
        if inner < 1:
            turn = lambda x: math.sqrt(1 - inner) * math.cos(0.5 * PI * x)
            absorbed += sum(w * 0.5 * PI * math.sin(PI * x) * (1 - inner) * lost(turn(x)) for x, w in FINE)
        return t, r, absorbed


# ---------------------------------------------------------------- least squares over wavelength and angle


def shares(study, nm):
    """Functions of the wavelength that do not vanish there, with their values."""
    if study.listed:
        return [(min(range(len(study.wavelengths)), key=lambda i: abs(study.wavelengths[i] - nm)), 1.0)]
    place = (nm - study.range[0]) / (study.range[1] - study.range[0]) * study.intervals
    piece = min(max(math.floor(place), 0), study.intervals - 1)
    t = place - piece
    # the cubic B-spline M₄ at t + 3 − k
    spline = lambda x: sum((-1) ** j * math.comb(4, j) * max(x - j, 0.0) ** 3 for j in range(5)) / 6
    return [(piece + k, spline(t + 3 - k)) for k in range(4)]


def functions(study):
    return len(study.wavelengths) if study.listed else study.intervals + 3


def solve(a, b):
    """Gauss–Jordan elimination with pivots for several right sides."""
    n, m = len(a), [row[:] + right[:] for row, right in zip(a, b)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(m[k][i]))
        m[i], m[pivot] = m[pivot], m[i]
        for k in range(n):
            if k != i and m[i][i] != 0.0:
                factor = m[k][i] / m[i][i]
                m[k] = [x - factor * y for x, y in zip(m[k], m[i])]
    # without any sample there is nothing to fit
    return [[x / m[i][i] if x else 0.0 for x in m[i][n:]] for i in range(n)]


def fits(study, samples, width, columns):
    """Coefficients [function × width][column] of all realisations, and of all but each.

    `samples[r]` are (wavelength functions, direction functions, values)."""
    size = functions(study) * width

    def normal_equations(rows):
        a, b = [[0.0] * size for _ in range(size)], [[0.0] * columns for _ in range(size)]
        for over_nm, over_mu, values in rows:
            row = [(i * width + k, s * d) for i, s in over_nm for k, d in enumerate(over_mu)]
            for i, x in row:
                for j, y in row:
                    a[i][j] += x * y
                for c, v in enumerate(values):
                    b[i][c] += x * v
        return a, b

    def fit(parts):
        a = [[sum(p[0][i][j] for p in parts) for j in range(size)] for i in range(size)]
        b = [[sum(p[1][i][c] for p in parts) for c in range(columns)] for i in range(size)]
        scale = sum(a[i][i] for i in range(size)) / size
        if not study.listed:
            for i in range(functions(study) - 2):
                for k in range(width):
                    row = [(i * width + k, 1.0), ((i + 1) * width + k, -2.0), ((i + 2) * width + k, 1.0)]
                    for p, x in row:
                        for q, y in row:
                            a[p][q] += 1e-3 * scale * x * y
        for i in range(size):
            a[i][i] += 1e-12 * max(scale, 5e-324)
        return solve(a, b)

    parts = [normal_equations(rows) for rows in samples]
    without = [fit(parts[:r] + parts[r + 1 :]) for r in range(len(parts))] if len(parts) > 1 else []
    return [fit(parts)] + without


def between(mu):
    """Shares of the values at 0° and 45° of a curve that vanishes at grazing, and two functions that vanish at all three."""
    c = math.sqrt(0.5)
    bend = mu * (1 - mu) * (mu - c)
    return [mu * (mu - c) / (1 - c), mu * (1 - mu) / (c * (1 - c))], [bend, bend * mu]


def symmetric(x, y):
    return [1.0, x + y, x * y, x * x + y * y, x * y * (x + y), x * x * y * y]


def cosine(deg):
    return math.cos(math.radians(deg))


# ---------------------------------------------------------------- statistics


def jackknife(values):
    """Standard error from leave-one-out values."""
    return math.sqrt(covariance([[v] for v in values])[0][0]) if len(values) > 1 else None


def covariance(rows):
    n = len(rows)
    means = [sum(column) / n for column in zip(*rows)]
    size = range(len(means))
    return [[(n - 1) / n * sum((r[i] - means[i]) * (r[j] - means[j]) for r in rows) for j in size] for i in size]


def mean_and_error(samples):
    n = len(samples)
    mean = sum(samples) / n
    if n < 2:
        return [mean, None]
    return [mean, math.sqrt(sum((x - mean) ** 2 for x in samples) / (n - 1) / n)]


def student(degrees):
    """The 97.5 % quantile by integrating Student's density."""
    if degrees < 1:
        return None
    scale = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * PI)
    # x = √ν tan φ makes the integral one of cos^(ν − 1)
    share = lambda x: 0.5 + scale * math.sqrt(degrees) * sum(
        w * math.atan(x / math.sqrt(degrees)) * math.cos(u * math.atan(x / math.sqrt(degrees))) ** (degrees - 1)
        for u, w in FINE
    )
    return bisect(share, 0.975, 0.0, 1000.0)


# ---------------------------------------------------------------- colour


TABLES = json.loads((HERE / "colour.json").read_text())["doc"]["tables"]["g380_780_5"]


def rows_of_tables():
    """S(λ) and (x̄, ȳ, z̄)(λ) at 380, 385, … 780 nm."""
    return TABLES["D65"], list(zip(*TABLES["cmf"]))


def tabulated(nm):
    """Light times observer between the tables' rows: D65 is linear there (CIE), the observer a sixth-degree curve."""
    light, observer = rows_of_tables()
    place = (nm - 380) / 5
    i = min(max(math.floor(place + 1e-9), 0), 79)
    t = place - i
    if abs(t) < 1e-9:
        return [light[i] * o[i] for o in observer]
    first = min(max(i - 2, 0), 75)
    nodes = range(first, first + 6)
    weight = lambda j: math.prod((place - k) / (j - k) for k in nodes if k != j)
    of_light = light[i] + t * (light[i + 1] - light[i])
    # between whole nanometres the tables are read linearly, like the program's
    return [of_light * sum(weight(j) * o[j] for j in nodes) for o in observer]


def lagrange(grid, at, most=4):
    """ASTM E2022: four nearest points, three in the outer intervals; or two."""
    after = min(max(sum(1 for x in grid if x < at), 1), len(grid) - 1)
    window = range(max(after - most // 2, 0), min(after + most // 2, len(grid)))
    return [(j, math.prod((at - grid[k]) / (grid[j] - grid[k]) for k in window if k != j)) for j in window]


class Meter:
    """XYZ of a spectrum on a grid: a plain sum up to 10 nm, resampled to 5 nm where the grid is coarser."""

    def __init__(self, grid):
        self.grid = grid
        self.step = (grid[-1] - grid[0]) / (len(grid) - 1)
        if self.step <= 10.0 + 1e-6:
            raw = [tabulated(nm) for nm in grid]
        else:
            raw = [[0.0] * 3 for _ in grid]
            pieces = math.ceil((grid[-1] - grid[0]) / 5 - 1e-9)
            for k in range(pieces + 1):
                nm = grid[0] + (grid[-1] - grid[0]) * k / pieces
                for j, share in lagrange(grid, nm):
                    raw[j] = [x + share * y for x, y in zip(raw[j], tabulated(nm))]
        self.scale = 100 / sum(row[1] for row in raw)
        self.weights = [[self.scale * x for x in row] for row in raw]
        self.white = self.xyz([1.0] * len(grid))
        self.white_rgb = rgb(self.white)

    def xyz(self, values):
        return [sum(w[c] * v for w, v in zip(self.weights, values)) for c in range(3)]

    def resampled(self, grid, values, at_most=4):
        """X, Y, Z of a spectrum known on another grid between the same ends, every 5 nm by its nearest points."""
        first, last = self.grid[0], self.grid[-1]
        pieces, total = math.ceil((last - first) / 5 - 1e-9), [0.0] * 3
        for k in range(pieces + 1):
            nm = first + (last - first) * k / pieces
            value = sum(share * values[j] for j, share in lagrange(grid, nm, at_most))
            step = (last - first) / pieces
            weights = [self.scale * x * (step / self.step if self.step <= 10.0 + 1e-6 else 1.0) for x in tabulated(nm)]
            total = [x + value * w for x, w in zip(total, weights)]
        return total

    def between(self, values, guide, fine, guide_fine):
        """Independent errors of X, Y, Z of a spectrum known at the grid's wavelengths alone, beside a guide that is known in between."""
        grid, rest = self.grid, [v - g for v, g in zip(values, guide)]
        widest, last = max(b - a for a, b in zip(grid, grid[1:])), len(grid) - 1
        take = lambda places, at_most=4: self.resampled([grid[j] for j in places], [rest[j] for j in places], at_most)
        less = lambda factor, one, other: [factor * (x - y) for x, y in zip(one, other)]
        best = take(range(last + 1))
        parts = [less(min((widest / 40) ** 2, 1.0), take(range(last + 1), 2), best)]
        for odd in (0, 1):
            half = [j for j in range(last + 1) if j % 2 == odd or j in (0, last)]
            parts.append(less(min((widest / 80) ** 1.5, 1.0), take(half), best))
        for a, b in zip(grid, grid[1:]):
            high = max(abs(x) for x in rest) * min(0.2 * ((b - a) / 100) ** 4, 0.4)
            arc = lambda nm: 4 * high * (nm - a) * (b - nm) / (b - a) ** 2 if a <= nm < b else 0.0
            pieces = math.ceil((grid[-1] - grid[0]) / 5 - 1e-9)
            nodes = [grid[0] + (grid[-1] - grid[0]) * k / pieces for k in range(pieces + 1)]
            parts.append(self.resampled(nodes, [arc(nm) for nm in nodes]))
        parts.append(less(1.0, self.resampled(fine, guide_fine), self.resampled(grid, guide)))
        return parts

    def per_nm(self, nm):
        # whole nanometres around it, as the program's tables have them
        low = math.floor(nm)
        a, b = tabulated(low), tabulated(low + 1)
        return [self.scale * (x + (nm - low) * (y - x)) / self.step for x, y in zip(a, b)]

    def colour(self, xyz):
        linear_rgb = [c / w for c, w in zip(rgb(xyz), self.white_rgb)]
        srgb = [transfer(min(max(c, 0.0), 1.0)) for c in linear_rgb]
        return {
            "xyz": xyz,
            "white_xyz": self.white,
            "lab": lab(xyz, self.white),
            "linear_rgb": linear_rgb,
            "srgb": srgb,
            "srgb8": [math.floor(255 * c + 0.5) for c in srgb],
            "out_of_gamut": any(c < -1e-9 or c > 1 + 1e-9 for c in linear_rgb),
        }


def rgb(xyz):
    matrix = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    return [sum(m * x for m, x in zip(row, xyz)) / 100 for row in matrix]


def transfer(c):
    return 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055


def lab(xyz, white):
    f = lambda t: t ** (1 / 3) if t > (6 / 29) ** 3 else t / (3 * (6 / 29) ** 2) + 4 / 29
    x, y, z = [f(a / b) for a, b in zip(xyz, white)]
    return [116 * y - 16, 500 * (x - y), 200 * (y - z)]


def ciede2000(one, other):
    (l1, a1, b1), (l2, a2, b2) = one, other
    mean = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 0.5 * (1 - math.sqrt(mean**7 / (mean**7 + 25**7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1, h2 = [math.degrees(math.atan2(b, a)) % 360 for a, b in ((a1, b1), (a2, b2))]
    turn = 0.0 if c1 * c2 == 0 else (h2 - h1 + 180) % 360 - 180
    dl, dc, dh = l2 - l1, c2 - c1, 2 * math.sqrt(c1 * c2) * math.sin(math.radians(turn / 2))
    l, c = (l1 + l2) / 2, (c1 + c2) / 2
    h = (h1 + h2) / 2 if abs(h1 - h2) <= 180 else (h1 + h2 + (360 if h1 + h2 < 360 else -360)) / 2
    h = h1 + h2 if c1 * c2 == 0 else h
    cos = lambda factor, shift: math.cos(math.radians(factor * h + shift))
    t = 1 - 0.17 * cos(1, -30) + 0.24 * cos(2, 0) + 0.32 * cos(3, 6) - 0.20 * cos(4, -63)
    sl = 1 + 0.015 * (l - 50) ** 2 / math.sqrt(20 + (l - 50) ** 2)
    sc, sh = 1 + 0.045 * c, 1 + 0.015 * c * t
    turned = 60 * math.exp(-(((h - 275) / 25) ** 2))
    rt = -math.sin(math.radians(turned)) * 2 * math.sqrt(c**7 / (c**7 + 25**7))
    return math.sqrt((dl / sl) ** 2 + (dc / sc) ** 2 + (dh / sh) ** 2 + rt * dc / sc * dh / sh)


def noise_2000(at, c):
    """√tr(M C) with the metric M of ΔE₀₀ by steps of a hundredth."""
    square = lambda by: (ciede2000(at, [x + 0.01 * y for x, y in zip(at, by)]) / 0.01) ** 2
    unit = lambda i: [1.0 if k == i else 0.0 for k in range(3)]
    both = lambda i, j: [x + y for x, y in zip(unit(i), unit(j))]
    metric = lambda i, j: square(unit(i)) if i == j else (square(both(i, j)) - square(unit(i)) - square(unit(j))) / 2
    return math.sqrt(max(0.0, sum(metric(i, j) * c[i][j] for i in range(3) for j in range(3))))


def quadratic(c, g):
    return max(0.0, sum(g[i] * c[i][j] * g[j] for i in range(3) for j in range(3)))


# ---------------------------------------------------------------- the layer and the ink on its paper


class Solved:
    """One solve as the evaluation sees it."""

    def __init__(self, point):
        self.deg = point["incidence"]["polar_deg"]
        orders = point["orders"]
        mirrored = next(o for o in orders if o[0] == 0 and o[1] == 0)
        self.r, self.t, self.a = (point[k] for k in ("reflectance", "transmittance", "absorptance"))
        self.totals = [self.r, mirrored[10], self.t, mirrored[11], self.a]
        self.straight = complex(mirrored[8], mirrored[9]), mirrored[11]
        density = point["period_um"][0] * point["period_um"][1] / point["incidence"]["wavelength_um"] ** 2
        seen = lambda o: math.sqrt(max(0.0, 1 - o[2] ** 2 - o[3] ** 2))
        self.scattered = [(seen(o), density * o[10]) for o in orders if o[4] and (o[0], o[1]) != (0, 0)]


class Layer:
    """All fits to an ensemble: differences from the film."""

    def __init__(self, study, solves):
        self.study = study
        self.realisations = solves["realisations"]
        count = len(self.realisations)
        profiles = [r["packing"]["profile"] for r in self.realisations]
        mean = [[sum(p[i][k] for p in profiles) / count for k in range(len(profiles[0][i]))] for i in range(len(profiles[0]))]
        self.films = Films(study, mean)
        self.exact, self.n = study.exact_deg, len(study.exact_deg)
        each = self.n + study.strata + study.exit_strata
        self.solved = []  # [realisation][wavelength]: nm, exact, strata, exit
        for r in self.realisations:
            chunks = [r["points"][k : k + each] for k in range(0, len(r["points"]), each)]
            assert all(len(chunk) == each for chunk in chunks)
            self.solved.append([self.at_wavelength(chunk) for chunk in chunks])
        self.thickness = [r["packing"]["thickness_um"] for r in self.realisations]
        samples, bends, diffuse = [], [], []
        self.measured = []
        for r, wavelengths in enumerate(self.solved):
            own = [self.differences(r, w) for w in wavelengths]
            self.measured.append(own)
            samples.append([(shares(study, w[0]), [1.0], d) for w, d in zip(wavelengths, own)])
            if self.on_paper():
                bends.append([row for w, d in zip(wavelengths, own) for row in self.between_anchors(r, w, d)])
                diffuse.append(
                    [
                        (shares(study, nm), symmetric(cosine(s.deg), mu), [density])
                        for nm, exact, strata, _ in wavelengths
                        for s in exact + strata
                        for mu, density in s.scattered
                    ]
                )
        self.columns = 5 * self.n + (4 if study.strata else 0)
        self.fit = fits(study, samples, 1, self.columns)
        if self.on_paper():
            self.bends, self.diffuse = fits(study, bends, 2, 3), fits(study, diffuse, 6, 1)

    def on_paper(self):
        return self.study.strata > 0 and 0.0 in self.exact and 45.0 in self.exact

    def at_wavelength(self, chunk):
        solved = [Solved(p) for p in chunk]
        n, strata = self.n, self.study.strata
        return 1e3 * chunk[0]["incidence"]["wavelength_um"], solved[:n], solved[n : n + strata], solved[n + strata :]

    def differences(self, r, at):
        """From the film of its own thickness: totals at the exact angles; means of T, R, A from the exit side, R there."""
        nm, exact, strata, exit_side = at
        thickness = [(self.thickness[r], 1.0)]
        columns = [x - y for s in exact for x, y in zip(s.totals, self.films.totals(nm, s.deg, thickness))]
        if not strata:
            return columns
        mean = lambda values: sum(values) / len(values)
        own = [self.films.at(nm, s.deg, thickness) for s in strata]
        t, r_ = mean([s.t - f[1] for s, f in zip(strata, own)]), mean([s.r - f[0] for s, f in zip(strata, own)])
        a, back = mean([s.a - (1 - f[0] - f[1]) for s, f in zip(strata, own)]), r_
        if exit_side:
            below = [self.films.at(nm, s.deg, thickness, True) for s in exit_side]
            a = mean([s.a - (1 - f[0] - f[1]) for s, f in zip(exit_side, below)])
            back = mean([s.r - f[0] for s, f in zip(exit_side, below)])
        return columns + [t, r_, a, back]

    def anchors(self, columns):
        """[R, T, specular R] at 0° and 45° among the columns."""
        return [[columns[5 * self.exact.index(deg) + c] for c in (0, 2, 1)] for deg in (0.0, 45.0)]

    def between_anchors(self, r, at, columns):
        nm, _, strata, _ = at
        anchored = self.anchors(columns)
        for s in strata:
            weights, functions = between(cosine(s.deg))
            f = self.films.totals(nm, s.deg, [(self.thickness[r], 1.0)])
            values = [s.r - f[0], s.t - f[2], s.totals[1] - f[0]]
            yield shares(self.study, nm), functions, [v - sum(w * a[q] for w, a in zip(weights, anchored)) for q, v in enumerate(values)]

    def fitted(self, table, without, nm, width, row, column):
        return sum(s * table[without][i * width + row][column] for i, s in shares(self.study, nm))


class Paper:
    """The layer on paper at one wavelength, of the whole ensemble (0) or without realisation r (r + 1)."""

    def __init__(self, layer, nm, without, film_means):
        self.layer, self.nm, self.study = layer, nm, layer.study
        columns = [layer.fitted(layer.fit, without, nm, 1, 0, c) for c in range(layer.columns)]
        self.anchors = layer.anchors(columns)
        t, _, a = film_means
        k = 5 * layer.n
        self.mean_t, self.mean_a = t + columns[k], a + columns[k + 2]
        self.bends = [[layer.fitted(layer.bends, without, nm, 2, b, q) for b in range(2)] for q in range(3)]
        self.diffuse = [layer.fitted(layer.diffuse, without, nm, 6, k, 0) for k in range(6)]
        self.albedo = self.study.albedo(nm)

    @staticmethod
    def of_film(layer, nm):
        """The film of the layer on the paper, without the grains' scattering."""
        own = object.__new__(Paper)
        own.layer, own.nm, own.study = layer, nm, layer.study
        own.mean_t, _, own.mean_a = layer.films.means(nm, layer.study.thicknesses())
        own.anchors, own.bends, own.diffuse = [[0.0] * 3] * 2, [[0.0] * 2] * 3, [0.0] * 6
        own.albedo = layer.study.albedo(nm)
        return own

    def moved(self, by, step):
        other = object.__new__(Paper)
        other.__dict__.update(self.__dict__)
        other.anchors = [[x + step * y for x, y in zip(own, dy)] for own, dy in zip(self.anchors, by[0])]
        other.mean_t, other.mean_a = self.mean_t + step * by[1], self.mean_a + step * by[2]
        return other

    def g(self, albedo=None):
        rho, square = self.albedo if albedo is None else albedo, self.study.index_out**2
        back = 1 - self.mean_t / square - self.mean_a
        return rho / (1 - rho * back) / square

    def curve(self, mu, q):
        weights, functions = between(mu)
        return sum(w * a[q] for w, a in zip(weights, self.anchors)) + sum(f * c for f, c in zip(functions, self.bends[q]))

    def total(self, deg, q):
        """R (0), T (1), specular R (2) at an angle."""
        f = self.layer.films.at(self.nm, deg, self.study.thicknesses())
        return f[1 if q == 1 else 0] + self.curve(cosine(deg), q)

    def brdf(self, light, view, albedo=None):
        own = sum(f * c for f, c in zip(symmetric(cosine(light), cosine(view)), self.diffuse))
        return own + self.g(albedo) * self.total(light, 1) * self.total(view, 1) / PI

    def mirrored(self, view):
        """The specular order without the diffuse light that a cell's order holds: f times its projected solid angle."""
        width, depth = self.study.period_um
        area = (1e-3 * self.nm) ** 2 / (width * depth)
        return self.total(view, 2) - area * sum(f * c for f, c in zip(symmetric(cosine(view), cosine(view)), self.diffuse))

    def sky(self, view):
        mirrored = self.mirrored(view) if self.study.sky_excluded else 0.0
        return self.total(view, 0) + self.g() * self.total(view, 1) * self.mean_t - mirrored

    def quadrature_error(self, degrees):
        """What equal weights at these angles miss of the fitted curves' means over the hemisphere: of T̄ and Ā."""
        def error(q):
            sampled = sum(self.curve(cosine(d), q) for d in degrees) / len(degrees)
            return sampled - sum(2 * mu * w * self.curve(mu, q) for mu, w in FINE)

        r, t = error(0), error(1)
        return [[0.0] * 3] * 2, t, 0.0 if self.study.exit_strata else -r - t


SKY = lambda p: p.sky(0.0)
PRINT = lambda p: PI * p.brdf(45.0, 0.0)
# what errors of R and T do to both: each pass through the layer counts
def through_paper(p, inwards, outwards, e, albedo=None):
    """g T1 T2 where T errs by e[1] and the layer's reflectance towards the paper by e[0]: d(1/g)/dR = -n²."""
    g, square = p.g(albedo), p.study.index_out**2
    return g * (inwards + outwards) * e[1] + square * g * g * inwards * outwards * e[0]


SKY_MOVED = lambda p, e: e[0] + through_paper(p, p.total(0.0, 1), p.mean_t, e)
PRINT_MOVED = lambda p, e, albedo=None: e[0] + through_paper(p, p.total(45.0, 1), p.total(0.0, 1), e, albedo)


class Ink:
    """The ink on its paper at all wavelengths of interest."""

    def __init__(self, layer):
        self.layer, study = layer, layer.study
        self.study, self.count = study, len(layer.realisations)
        self.outputs = study.wavelengths
        first, last = study.range
        pieces = max(1, math.ceil((last - first) / 5))
        self.colours = self.outputs if study.listed else [first + (last - first) * k / pieces for k in range(pieces + 1)]
        self.meter = Meter(self.colours)
        means = {}
        solved = [] if study.listed else [w[0] for r in layer.solved for w in r]
        for nm in {*self.outputs, *self.colours, *solved}:
            means[nm] = layer.films.means(nm, study.thicknesses())
        variants = range(self.count + 1) if self.count > 1 else range(1)
        self.at = [{nm: Paper(layer, nm, v, means[nm]) for nm in means} for v in variants]
        pieces = max(1, math.ceil((last - first) / 5 - 1e-9))
        self.fine = [first + (last - first) * k / pieces for k in range(pieces + 1)] if study.listed else []
        self.film = {nm: Paper.of_film(layer, nm) for nm in {*self.fine, *(self.colours if study.listed else [])}}

    def between(self, quantity):
        """Errors of X, Y, Z due to what lies between the wavelengths of a list."""
        if not self.study.listed:
            return []
        values = [quantity(self.at[0][nm]) for nm in self.colours]
        film = lambda grid: [quantity(self.film[nm]) for nm in grid]
        return self.meter.between(values, film(self.colours), self.fine, film(self.fine))

    def between_lab(self, quantity, xyz):
        """The same as shifts of Lab."""
        here, shifts = lab(xyz, self.meter.white), []
        for by in self.between(quantity):
            there = lab([max(x + d, 0.0) for x, d in zip(xyz, by)], self.meter.white)
            shifts.append([x - y for x, y in zip(there, here)])
        return shifts

    def spectrum(self, quantity):
        """Value and leave-one-out values at every output wavelength."""
        return [[quantity(at[nm]) for at in self.at] for nm in self.outputs]

    def plain(self, quantity, variant=0):
        return self.meter.xyz([quantity(self.at[variant][nm]) for nm in self.colours])

    def xyz(self, quantity, variant=0):
        """The sum over the fit, and to first order what the solves say beyond it."""
        xyz = self.plain(quantity, variant)
        if self.study.listed:
            return xyz
        kept = [r for r in range(self.count) if r != variant - 1]
        width = (self.study.range[1] - self.study.range[0]) / self.study.intervals
        for r in kept:
            for j, (nm, *_) in enumerate(self.layer.solved[r]):
                fitted = [self.layer.fitted(self.layer.fit, variant, nm, 1, 0, c) for c in range(self.layer.columns)]
                rest = [x - y for x, y in zip(self.layer.measured[r][j], fitted)]
                k = 5 * self.layer.n
                by, here = (self.layer.anchors(rest), rest[k], rest[k + 2]), self.at[0][nm]
                slope = (quantity(here.moved(by, 1e-4)) - quantity(here.moved(by, -1e-4))) / 2e-4
                xyz = [x + w * width * slope / len(kept) for x, w in zip(xyz, self.meter.per_nm(nm))]
        return xyz

    def nearest(self, r, nm):
        return min(self.layer.solved[r], key=lambda w: abs(w[0] - nm))

    def angle_covariance(self, quantity):
        if self.count < 2:
            return None
        rows = []
        for r in range(self.count):
            values = []
            for nm in self.colours:
                here = self.at[0][nm]
                by = here.quadrature_error([s.deg for s in self.nearest(r, nm)[2]])
                slope = (quantity(here.moved(by, 1e-4)) - quantity(here.moved(by, -1e-4))) / 2e-4
                values.append(quantity(here) + slope)
            rows.append(lab(self.meter.xyz(values), self.meter.white))
        return [[x / (self.count - 1) ** 2 for x in row] for row in covariance(rows)]

    def unseen_directions(self, quantity, xyz):
        """Shifts of Lab by errors of the directions that all realisations have in common: of each component, what the squared
        error of the fitted curves' means over the hemispheres has beyond the jackknife's square, over 16 common shifts."""
        study, layer = self.study, self.layer
        if not 2 <= self.count <= 64 or not study.strata:
            return []
        beyond = lambda r, nm, s: s.a - 1 + sum(layer.films.at(nm, s.deg, [(layer.thickness[r], 1.0)], True))
        rows = lambda r: [
            (shares(study, w[0]), [cosine(s.deg) ** k for k in range(4)], [beyond(r, w[0], s)]) for w in layer.solved[r] for s in w[3]
        ]
        absorbed = fits(study, [rows(r) for r in range(self.count)], 4, 1) if study.exit_strata else None

        def degrees(strata, place):
            squares = [max((k + place) / strata, 1e-4) for k in range(strata)]
            return [math.degrees(math.acos(math.sqrt(x))) for x in squares]

        def errors(here, nm, place):
            _, t, a = here.quadrature_error(degrees(study.strata, place))
            if absorbed:
                poly = [layer.fitted(absorbed, 0, nm, 4, k, 0) for k in range(4)]
                below = [cosine(d) for d in degrees(study.exit_strata, place)]
                a = sum(c * (sum(mu**k for mu in below) / len(below) - 2 / (k + 2)) for k, c in enumerate(poly))
            return [[0.0] * 3] * 2, t, a

        first, white, n = study.strata - 1, self.meter.white, self.count
        place = lambda w: study.strata * cosine(w[2][0].deg) ** 2 - first
        commons, seen = [], [0.0] * 3
        for k in range(16):
            labs = []
            for r in range(n):
                by = []
                for nm in self.colours:
                    here = self.at[0][nm]
                    error = errors(here, nm, (place(self.nearest(r, nm)) + k / 16) % 1)
                    by.append((quantity(here.moved(error, 1e-4)) - quantity(here.moved(error, -1e-4))) / 2e-4)
                there = lab([max(0.0, x + y) for x, y in zip(xyz, self.meter.xyz(by))], white)
                labs.append([x - y for x, y in zip(there, lab(xyz, white))])
            mean = [sum(column) / n for column in zip(*labs)]
            commons.append(mean)
            seen = [s + sum((row[i] - mean[i]) ** 2 for row in labs) / (n * (n - 1)) for i, s in enumerate(seen)]
        squares = [sum(mean[i] ** 2 for mean in commons) for i in range(3)]
        scale = [math.sqrt(max(0.0, 1 - s / q) / 16) if q > 1e-18 else 0.0 for s, q in zip(seen, squares)]
        return [[x * y for x, y in zip(scale, mean)] for mean in commons] if any(scale) else []

    def colour(self, name, quantity, moved, grid, residual):
        """A colour with its covariance and the parts of its error."""
        colour = self.meter.colour(self.xyz(quantity))
        labs = [lab(self.xyz(quantity, v), self.meter.white) for v in range(1, self.count + 1)] if self.count > 1 else []
        chance = covariance(labs) if labs else None
        def shift(e):
            there = lab(self.xyz(lambda p: quantity(p) + moved(p, e)), self.meter.white)
            return [x - y for x, y in zip(there, colour["lab"])]

        shifts = [shift(grid), shift([residual] * 2)]
        between = self.between_lab(quantity, colour["xyz"])
        unseen = self.unseen_directions(quantity, colour["xyz"])
        whole = self.widened(chance, shifts + between + unseen)
        spread = lambda c: math.sqrt(max(0.0, c[0][0] + c[1][1] + c[2][2]))
        angles = self.angle_covariance(quantity)
        angles = angles and spread(angles)
        plain = lab(self.plain(quantity), self.meter.white)
        _, a, b = colour["lab"]
        error = lambda gradient: whole and math.sqrt(quadratic(whole, gradient))
        factor = student(self.count - 1)
        degrees = 180 / PI
        return colour | {
            "conditions": name,
            "lab_covariance": whole,
            "lab_standard_error": whole and [math.sqrt(whole[i][i]) for i in range(3)],
            "chroma": [math.hypot(a, b), error([0.0, a / math.hypot(a, b), b / math.hypot(a, b)])],
            "hue_deg": [math.atan2(b, a) * degrees % 360, error([0.0, -b / (a * a + b * b) * degrees, a / (a * a + b * b) * degrees])],
            "delta_e_2000_95": whole and factor and factor * noise_2000(colour["lab"], whole),
            "budget": {
                "chance_and_cell": chance and math.sqrt(max(0.0, spread(chance) ** 2 - (angles or 0.0) ** 2)),
                "angles": math.hypot(angles, *(x for by in unseen for x in by)) if unseen else angles,
                "wavelengths": math.dist(colour["lab"], plain),
                "grid": math.hypot(*shifts[0]),
                "residual": math.hypot(*shifts[1]),
            }
            | ({"between_wavelengths": math.hypot(*(x for by in between for x in by))} if between else {}),
        }

    def maker(self, shifts):
        """What an ink maker asks, at 45:0; `shifts` are the grid's and the residual's errors of R and T."""
        target = self.study.file.get("colour", {}).get("target_lab")

        def sums(albedo, variant=0, by=(0.0, 0.0)):
            return self.xyz(lambda p: PI * p.brdf(45.0, 0.0, albedo) + PRINT_MOVED(p, by, albedo), variant)

        def swatch(albedo):
            each = [self.meter.colour(sums(albedo, k)) for k in range(len(self.at))]
            chance = covariance([c["lab"] for c in each[1:]]) if len(each) > 1 else None
            there = [lab(sums(albedo, 0, by), self.meter.white) for by in shifts]
            moved = [[x - y for x, y in zip(one, each[0]["lab"])] for one in there]
            moved += self.between_lab(lambda p: PI * p.brdf(45.0, 0.0, albedo), each[0]["xyz"])
            return each[0] | {"lab_covariance": self.widened(chance, moved)}

        def estimate(values, moved, beside):
            return widened(self.study, values, math.hypot(*(x - values[0] for x in moved), beside))

        mine = swatch(None)
        found = {"print": mine, "over_black": swatch(0.0), "over_white": swatch(0.8)}
        ratio = lambda k, by: sums(0.0, k, by)[1] / sums(0.8, k, by)[1]
        ratios = [ratio(k, (0.0, 0.0)) for k in range(len(self.at))]
        missed = lambda albedo: math.hypot(*(by[1] for by in self.between(lambda p: PI * p.brdf(45.0, 0.0, albedo))))
        beside = math.hypot(missed(0.0), ratios[0] * missed(0.8)) / sums(0.8)[1]
        found["contrast_ratio"] = estimate(ratios, [ratio(0, by) for by in shifts], beside)
        if target:
            step = lambda i, h: [x + (h if k == i else 0.0) for k, x in enumerate(mine["lab"])]
            gradient = [(ciede2000(step(i, 1e-3), target) - ciede2000(step(i, -1e-3), target)) / 2e-3 for i in range(3)]
            error = mine["lab_covariance"] and math.sqrt(quadratic(mine["lab_covariance"], gradient))
            found["target"] = [ciede2000(mine["lab"], target), error]
        return found

    def widened(self, chance, moved):
        """Chance's covariance with what shared errors do; none where one realisation leaves chance unknown."""
        if chance is None and self.study.certain and any(x for by in moved for x in by):
            chance = [[0.0] * 3 for _ in range(3)]
        return chance and [[chance[i][j] + sum(by[i] * by[j] for by in moved) for j in range(3)] for i in range(3)]

    def picture(self, count=61):
        """sRGB of the strip, top to bottom, and of the square's rows: viewing angle down, illumination to the right."""
        angles = [i * self.study.picture_max / (count - 1) for i in range(count)]
        through = {nm: [p.total(deg, 1) for deg in angles] for nm, p in self.at[0].items() if nm in self.colours}

        def pixel(quantity):
            colour = self.meter.colour(self.meter.xyz([quantity(self.at[0][nm]) for nm in self.colours]))
            return "".join(f"{c:02x}" for c in colour["srgb8"])

        def lit(i, o):
            own = lambda p: sum(f * c for f, c in zip(symmetric(cosine(angles[i]), cosine(angles[o])), p.diffuse))
            return lambda p: PI * own(p) + p.g() * through[p.nm][i] * through[p.nm][o]

        strip = [pixel(lambda p: p.sky(deg)) for deg in angles]
        return {"strip": strip, "square": ["".join(pixel(lit(i, o)) for i in range(count)) for o in range(count)]}


# ---------------------------------------------------------------- what is published


def spectra(study, layer, ink, shared):
    """Rows like those of spectra.csv: wavelength, angle, then value and error of each column."""
    rows = []
    for k, deg in enumerate(study.exact_deg):
        for nm in study.wavelengths:
            own = layer.films.totals(nm, deg, study.thicknesses())
            row = [nm, deg]
            together = lambda moved: math.hypot(*(moved(e) for e in shared))
            r, t = together(lambda e: e[0]), together(lambda e: e[1])
            # A's error: what both others may miss
            errors = [r, r, t, t, together(lambda e: e[0] + e[1])]
            for c in range(5):
                values = [own[c] + layer.fitted(layer.fit, v, nm, 1, 0, 5 * k + c) for v in range(len(layer.fit))]
                row += widened(study, values, errors[c])
            if ink and deg == 0.0:
                for quantity, moved in ((SKY, SKY_MOVED), (PRINT, PRINT_MOVED)):
                    row += widened(study, [quantity(at[nm]) for at in ink.at], together(lambda e: moved(ink.at[0][nm], e)))
            else:
                row += [None] * 4
            rows.append(row + coherent(study, layer, k, nm, t))
    return rows


def coherent(study, layer, k, nm, shared):
    """|⟨t⟩|² of listed wavelengths less the variance of the mean, and its error; uneven layers have none."""
    if study.thickness_std > 0:
        return [None, None]
    if len(layer.realisations) == 1:
        # a film without chance: all of its straight light is coherent
        return widened(study, [layer.films.totals(nm, study.exact_deg[k], study.thicknesses())[3]], shared)
    assert study.listed
    # amplitudes of the unscattered order, scaled to the roots of its efficiencies
    solved = [min(wavelengths, key=lambda w: abs(w[0] - nm))[1][k] for wavelengths in layer.solved]
    straight = [cmath.rect(math.sqrt(s.straight[1]), cmath.phase(s.straight[0])) for s in solved]
    n, mean = len(straight), sum(straight) / len(straight)
    variance = sum(abs(a - mean) ** 2 for a in straight) / (n * (n - 1))
    without = [abs((n * mean - a) / (n - 1)) ** 2 for a in straight]
    error = math.hypot(jackknife(without) or 0.0, variance, shared)
    return [abs(mean) ** 2 - variance, error]


def widened(study, values, shared):
    chance = jackknife(values[1:])
    if chance is None and not study.certain:
        return [values[0], None]
    error = math.hypot(chance or 0.0, shared)
    return [values[0], error if error > 0 or not study.certain else None]


def distributions(study, layer, amplitude_error):
    """Rows like those of bdf.csv."""
    rows = []
    fixed = not study.varied and study.listed and study.thickness_std == 0.0
    each = layer.n + study.strata + study.exit_strata
    for w in range(len(layer.solved[0])):
        for k in range(layer.n):
            points = [r["points"][w * each + k] for r in layer.realisations]
            um = sum(p["incidence"]["wavelength_um"] for p in points) / len(points)
            azimuth = points[0]["incidence"]["azimuth_deg"] if fixed else 0.0
            step = [um / x for x in study.period_um]
            for lobe, flag, column in (("reflected", 4, 10), ("transmitted", 5, 11)):
                cells = lattice(points, step, flag, column, fixed)
                for (m, n), (direction, samples) in cells.items():
                    value, error = mean_and_error(samples)
                    index = study.index_out if lobe == "transmitted" else 1.0
                    # orders in a steradian of the medium, where dα dβ = n² cos θ dω
                    density = index**2 / (step[0] * step[1])
                    flux = math.sqrt(max(0.0, index**2 - direction[0] ** 2 - direction[1] ** 2)) / cosine(study.exact_deg[k])
                    rows.append(
                        [1e3 * um, "incident", study.exact_deg[k], azimuth, lobe, m, n, *direction, (m, n) == (0, 0)]
                        + [value, error, density * value, error and density * error, len(points)]
                        + [2 * math.sqrt(max(value, 0.0) * flux) * amplitude_error]
                    )
    return rows


def lattice(points, step, flag, column, fixed):
    """Efficiencies of every realisation, order by order, or collected on the nominal lattice in the plane of incidence."""
    cells = {}
    mirrored = next(o for o in points[0]["orders"] if (o[0], o[1]) == (0, 0))
    centre = [math.hypot(mirrored[2], mirrored[3]), 0.0]
    inside = [o for p in points for o in p["orders"] if o[flag]]
    reach = max([1.0] + [math.hypot(o[2], o[3]) for o in inside])
    where = lambda m, n: [centre[0] + m * step[0], centre[1] + n * step[1]]
    for r, point in enumerate(points):
        turn = math.radians(point["incidence"]["azimuth_deg"])
        for o in (o for o in point["orders"] if o[flag]):
            place, direction = (o[0], o[1]), o[2:4]
            if not fixed:
                x, y = o[2] * math.cos(turn) + o[3] * math.sin(turn), o[3] * math.cos(turn) - o[2] * math.sin(turn)
                if place != (0, 0):
                    m, n = (round((v - c) / s) for v, c, s in zip((x, y), centre, step))
                    near = [(m + i, n + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
                    near = [p for p in near if p != (0, 0) and math.hypot(*where(*p)) < reach]
                    place = min(near, key=lambda p: math.dist(where(*p), (x, y)), default=(m, n))
                direction = where(*place)
            cells.setdefault(place, (direction, [0.0] * len(points)))[1][r] += o[column]
    return cells


def certainty(study, layer, ink, grid):
    points = [p for r in layer.realisations for p in r["points"]]
    energy = [abs(p["reflectance"] + p["transmittance"] + p["absorptance"] - 1) for p in points]
    count = len(layer.realisations)
    found = {
        "amplitude_error_estimate": grid["error_estimate"],
        "reflectance_grid_error": grid["grid_error"]["reflectance"],
        "transmittance_grid_error": grid["grid_error"]["transmittance"],
        "degrees_of_freedom": count - 1,
        "coverage_factor_95": student(count - 1),
        "mean_energy_error": sum(energy) / len(energy),
        "largest_energy_error": max(energy),
        "largest_residual": max(p["account"]["residual"] for p in points),
        "mean_steps": sum(p["account"]["steps"] for p in points) / len(points),
        "operator_applications": sum(p["account"]["operator_applications"] for p in points),
    }
    if ink:
        missed = lambda nm, r: ink.at[0][nm].quadrature_error([s.deg for s in ink.nearest(r, nm)[2]])[1]
        each = [math.sqrt(sum(missed(nm, r) ** 2 for r in range(count))) / count for nm in study.wavelengths]
        found["angle_error_estimate"] = max(each)
    if study.strata > 1:
        # the film of the output wavelength nearest to each solve, of mean thickness
        near = lambda nm: min(study.wavelengths, key=lambda x: abs(x - nm))
        rest = lambda w, s: s.t - layer.films.at(near(w[0]), s.deg, study.thicknesses())[1]
        half = lambda r, w: sum((-1) ** (k + r) * rest(w, s) for k, s in enumerate(w[2])) / len(w[2])
        alternating = [sum(half(r, w) for w in ws) / len(ws) for r, ws in enumerate(layer.solved)]
        found["half_strata_difference"] = mean_and_error(alternating)
    if study.exit_strata:
        k = 5 * layer.n
        apart = lambda d: d[k + 3] + d[k] / study.index_out**2 + d[k + 2]
        found["exit_reflectance_difference"] = mean_and_error([sum(map(apart, own)) / len(own) for own in layer.measured])
    return found


def flat(order):
    """m, n, direction (2), whether it propagates (2), amplitudes (4), efficiencies (2): of each the reflected one first."""
    m, n, direction, propagates, amplitudes, efficiencies = order[:6]
    return [m, n, *direction, *propagates, *amplitudes[0], *amplitudes[1], *efficiencies]


def derive(name):
    """Everything that the run of a study publishes."""
    study, solves = Study(name), json.loads((GOLDEN / f"{name}-solves.json").read_text())
    for point in (p for r in solves["realisations"] for p in r["points"]):
        point["orders"] = [flat(order) for order in point["orders"]]
    layer = Layer(study, solves)
    ink = Ink(layer) if layer.on_paper() else None
    grid = solves["grid"]
    known = certainty(study, layer, ink, grid)
    residual = known["mean_energy_error"] if known["mean_energy_error"] > 1e-12 else 0.0
    errors = [known["reflectance_grid_error"], known["transmittance_grid_error"]]
    shared = [errors, [residual] * 2]
    golden = {
        "certainty": known,
        "spectra": spectra(study, layer, ink, shared),
        "bdf": distributions(study, layer, grid["error_estimate"]),
    }
    if ink:
        golden["colours"] = [
            ink.colour("natural light", SKY, SKY_MOVED, errors, residual),
            ink.colour("45:0", PRINT, PRINT_MOVED, errors, residual),
        ]
        golden["ink_maker"], golden["picture"] = ink.maker([errors, [residual] * 2]), ink.picture()
    write(GOLDEN / f"{name}.json", golden)


def film_alone(study):
    """The solves of a layer without grains: what the film's formulas say."""
    films = Films(study, [[]])
    points = []
    for nm in study.wavelengths:
        strata = [math.degrees(math.acos(math.sqrt((k + 0.5) / study.strata))) for k in range(study.strata)]
        for deg in study.exact_deg + strata:
            r, t = films.at(nm, deg, study.thicknesses())
            light = {"wavelength_um": 1e-3 * nm, "polar_deg": deg, "azimuth_deg": 0.0}
            order = [0, 0, math.sin(math.radians(deg)), 0.0, True, True, 0.0, 0.0, 0.0, 0.0, r, t]
            totals = {"reflectance": r, "transmittance": t, "absorptance": 1 - r - t}
            points.append(totals | {"incidence": light, "period_um": study.period_um, "orders": [order]})
    packing = {"profile": [[]], "thickness_um": study.thickness_um}
    return {"realisations": [{"packing": packing, "points": points}]}


def derive_sweep(name):
    """L*, a*, b*, C*, h and ΔE₀₀ to the reference of every variant of a sweep of films; the difference it draws."""
    file = tomllib.loads((GOLDEN / f"{name}.toml").read_text())
    labs, through = [], []
    for share in file["axis"][0]["values"]:
        for albedo in file["axis"][1]["values"]:
            base = json.loads(json.dumps(file["base"]))
            base["pigment"][0]["volume_fraction"], base["paper"]["albedo"] = share, albedo
            study = Study(name, base)
            ink = Ink(Layer(study, film_alone(study)))
            through.append(ink.layer.films.at(500.0, 0.0, study.thicknesses())[1])
            labs.append(ink.meter.colour(ink.xyz(SKY))["lab"])
    # of "strong" on 0.9, the third; the first and second differ by the paper alone
    reference = labs[2]
    rows = [
        dict(zip("Lab", lab)) | {
            "C": math.hypot(lab[1], lab[2]),
            "h_deg": math.degrees(math.atan2(lab[2], lab[1])) % 360,
            "delta_e_2000": ciede2000(lab, reference),
        }
        for lab in labs
    ]
    write(GOLDEN / f"{name}.json", {"variants": rows, "conclusions": [labs[0][0] - labs[1][0], through[0] - through[2]]})


def main():
    if sys.argv[1:2] == ["--take"]:
        return take(sys.argv[2], sys.argv[3])
    names = [name for name in sys.argv[1:] if name != "--check"] or sorted(p.stem for p in GOLDEN.glob("*.toml"))
    for name in names:
        derive_sweep(name) if name == "sweep" else derive(name)


if __name__ == "__main__":
    main()
