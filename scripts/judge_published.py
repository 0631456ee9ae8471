"""Judges the conclusions of a sweep file by its published tables (sweep.csv, variants/*/spectra.csv), as the program does.

What realisations move together is not in the tables: errors of different variants are added as if independent, which is too
much where samples pair and a little too small where they work against each other; a mean over wavelengths takes them all to one
side, L*, a*, b* of one colour likewise. What the program has judged itself keeps its paired errors.
"""

import csv
import functools
import math
import re
import statistics
import tomllib

QUANTILE = 0.975


@functools.cache
def student(n, quantile):
    """Quantile of Student's t for a mean of n realisations; the normal law's where chance plays no part."""
    if n == 0:
        return statistics.NormalDist().inv_cdf(quantile)
    f = max(n - 1, 1)
    scale = math.exp(math.lgamma((f + 1) / 2) - math.lgamma(f / 2)) / math.sqrt(f)

    def tail(t):
        """From t on; with t = √f tan θ the density is cos θ to the power f − 1 (Simpson's rule)."""
        start, steps = math.atan(t / math.sqrt(f)), 400
        h = (math.pi / 2 - start) / steps
        values = [math.cos(start + i * h) ** (f - 1) for i in range(steps + 1)]
        values[-1] = 1.0 if f == 1 else 0.0
        whole = values[0] + values[-1] + 4 * sum(values[1:-1:2]) + 2 * sum(values[2:-1:2])
        return scale * math.sqrt(f) / math.sqrt(math.pi) * whole * h / 3

    low, high = 0.0, 1000.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if tail(middle) > 1 - quantile else (low, middle)
    return low


def ciede2000(one, other):
    """CIE 142-2001 (Sharma et al. 2005)."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    mean = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 1.5 - 0.5 * math.sqrt(mean**7 / (mean**7 + 25.0**7))
    a1, a2 = a1 * g, a2 * g
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1, h2 = (math.degrees(math.atan2(b, a)) % 360 for a, b in ((a1, b1), (a2, b2)))
    dh = (h2 - h1 + 180) % 360 - 180
    l, c, h = (l1 + l2) / 2, (c1 + c2) / 2, (h1 + dh / 2) % 360
    t = 1 - 0.17 * cosd(h - 30) + 0.24 * cosd(2 * h) + 0.32 * cosd(3 * h + 6) - 0.2 * cosd(4 * h - 63)
    sl = 1 + 0.015 * (l - 50) ** 2 / math.sqrt(20 + (l - 50) ** 2)
    parts = ((l2 - l1) / sl, (c2 - c1) / (1 + 0.045 * c), 2 * math.sqrt(c1 * c2) * math.sin(math.radians(dh / 2)) / (1 + 0.015 * c * t))
    turn = 60 * math.exp(-(((h - 275) / 25) ** 2))
    rotation = -2 * math.sqrt(c**7 / (c**7 + 25.0**7)) * math.sin(math.radians(turn))
    return math.sqrt(sum(x * x for x in parts) + rotation * parts[1] * parts[2])


def cosd(degrees):
    return math.cos(math.radians(degrees))


class Missing(Exception):
    """What a conclusion lacks, in words."""


class Tables:
    """A published sweep: its conclusions and its numbers."""

    def __init__(self, sweep_file, folder):
        self.file, self.folder = tomllib.loads(sweep_file.read_text()), folder
        with open(folder / "sweep.csv", newline="") as table:
            self.rows = list(csv.DictReader(table))
        self.axes = list(self.rows[0])[1 : list(self.rows[0]).index("solves")]

    def labels(self, axis):
        return list(dict.fromkeys(row[axis] for row in self.rows))

    def variant(self, where):
        [row] = [row for row in self.rows if all(row[axis] == str(label) for axis, label in where.items())]
        if not row["L"]:
            raise Missing(f"no value of {row['variant']}")
        return row

    def name(self, where):
        row = next(row for row in self.rows if all(row[axis] == str(label) for axis, label in where.items()))
        return ", ".join(row[axis] for axis in self.axes)

    @functools.cache
    def transmittance(self, variant):
        """{nm: (T, its error)} at the smallest angle."""
        with open(self.folder / "variants" / variant / "spectra.csv", newline="") as table:
            rows = list(csv.DictReader(table))
        first = [row for row in rows if row["polar_deg"] == rows[0]["polar_deg"]]
        column = "transmittance"
        return {float(r["wavelength_nm"]): (float(r[column]), float(r[f"{column}_standard_error"] or 0)) for r in first}

    def conclusions(self):
        """One by one, those of `each` for every label."""
        for table in self.file["conclusion"]:
            axis = table.get("each")
            for label in self.labels(axis) if axis else [None]:
                extra = {axis: label} if axis else {}
                one = dict(table, id=f"{label}: {table['id']}" if axis else table["id"])
                for key in ("plus", "minus", "among"):
                    one[key] = [extra | where for where in table.get(key, [])]
                if "absorbed_by" in table:
                    one["absorbed_by"] = extra | table["absorbed_by"]
                yield one


def fewest(rows):
    return min((int(row["realisations"]) for row in rows if int(row["realisations"]) > 1), default=0)


def margin(claim, value):
    value = abs(value) if claim.get("absolute") else value
    return min(value - claim.get("at_least", -math.inf), claim.get("at_most", math.inf) - value)


def decide(claim, value, error, n, quantile=QUANTILE):
    distance = margin(claim, value)
    if abs(distance) > error * student(n, quantile) or error == 0:
        return "confirmed" if distance >= 0 else "refuted"
    return "undecided"


def lab(row):
    return [float(row[k]) for k in "Lab"], [float(row[f"{k}_standard_error"] or 0) for k in "Lab"]


def difference(a, b):
    """ΔE₀₀ of two rows, with its error by numeric slopes."""
    (one, errors_one), (other, errors_other) = lab(a), lab(b)

    def reach(colour, errors, of):
        total, h = 0.0, 1e-4
        for i, error in enumerate(errors):
            up, down = ([x + s * h * (i == j) for j, x in enumerate(colour)] for s in (1, -1))
            total += abs(of(up) - of(down)) / (2 * h) * error
        return total

    by_one = reach(one, errors_one, lambda x: ciede2000(x, other))
    by_other = reach(other, errors_other, lambda x: ciede2000(one, x))
    return ciede2000(one, other), math.hypot(by_one, by_other)


def on_curve(claim, rows, value, error):
    """Place on a curve of variants with the same value."""
    points = [(at, float(row["C"]), float(row["C_standard_error"] or 0)) for at, row in zip(claim["along"], rows)]
    found = [w for w in zip(points, points[1:]) if w[0][1] <= value < w[1][1] or w[1][1] < value <= w[0][1]]
    if len(found) != 1:
        raise Missing(f"the curve has {value:.4f} at {len(found) or 'no'} places")
    [((start, low, low_error), (end, high, high_error))] = found
    slope, share = (high - low) / (end - start), (value - low) / (high - low)
    reach = math.hypot(error, (1 - share) * low_error, share * high_error)
    return start + share * (end - start), reach / abs(slope)


def spectrum(tables, claim, plus, minus):
    """The verdict over a range of wavelengths, the number, its error and a remark."""
    start, end = claim["range_nm"]
    spectra = [(sign, tables.transmittance(row["variant"])) for sign, rows in ((1, plus), (-1, minus)) for row in rows]
    nm = [x for x in spectra[0][1] if start <= x <= end]
    if "absorbed_by" in claim:
        seen = tables.transmittance(tables.variant(claim["absorbed_by"])["variant"])
        seen = {x: seen[x][0] for x in nm}
        nm = [x for x in nm if seen[x] <= (min(seen.values()) + max(seen.values())) / 2]
    n = fewest(plus + minus)
    if claim.get("over") == "mean":
        value = sum(sign * t[x][0] for sign, t in spectra for x in nm) / len(nm)
        error = math.hypot(*(sum(t[x][1] for x in nm) / len(nm) for _, t in spectra))
        return decide(claim, value, error, n), value, error, f"mean over {len(nm)} wavelengths from {nm[0]:.0f} to {nm[-1]:.0f} nm"
    parts = [(x, sum(sign * t[x][0] for sign, t in spectra), math.hypot(*(t[x][1] for _, t in spectra))) for x in nm]
    some = claim.get("over") == "some"
    wanted, other = ("confirmed", "refuted") if some else ("refuted", "confirmed")
    together = 1 - (1 - QUANTILE) / len(nm)
    sign = -1 if some else 1
    clear = [p for p in parts if decide(claim, p[1], p[2], n, together) == wanted]
    if clear:
        x, value, error = min(clear, key=lambda p: sign * margin(claim, p[1]) / (p[2] or 1e-300))
    else:
        x, value, error = min(parts, key=lambda p: sign * margin(claim, p[1]))
    verdicts = [decide(claim, p[1], p[2], n) for p in parts]
    verdict = wanted if clear else "undecided"
    verdict = other if all(v == other for v in verdicts) else verdict
    why = f"{wanted} most clearly" if clear else ("nearest to its bound" if some else "worst")
    remark = f"measured at {x:.0f} nm, where it is {why}"
    for word in ["confirmed"] if some else ["refuted", "undecided"]:
        there = [f"{p[0]:.0f}" for p, v in zip(parts, verdicts) if v == word]
        if there and len(there) < len(parts):
            remark += f"; {word} at {', '.join(there)} nm"
    return verdict, value, error, remark


def measured(tables, claim):
    plus, minus = ([tables.variant(where) for where in claim[key]] for key in ("plus", "minus"))
    if claim["quantity"] == "transmittance":
        return spectrum(tables, claim, plus, minus)
    among = [tables.variant(where) for where in claim["among"]]
    if claim["quantity"] == "delta_e":
        value, error = difference(plus[0], minus[0])
    else:
        value = sum(float(row["C"]) for row in plus) - sum(float(row["C"]) for row in minus)
        error = math.hypot(*(float(row["C_standard_error"] or 0) for row in plus + minus))
    if among:
        value, error = on_curve(claim, among, value, error)
    return decide(claim, value, error, fewest(plus + minus + among)), value, error, ""


def inequality(tables, claim):
    number = lambda x: f"{x:g}".replace("-", "−")
    symbol = "C*" if claim["quantity"] == "chroma" else "T" + "–".join(f"{x:.0f}" for x in claim.get("range_nm", []))
    plus, minus = ([tables.name(where) for where in claim[key]] for key in ("plus", "minus"))
    if claim["quantity"] == "delta_e":
        what = f"ΔE₀₀({plus[0]}; {minus[0]})"
    else:
        what = " + ".join(f"{symbol}({x})" for x in plus) + "".join(f" − {symbol}({x})" for x in minus)
    what = f"|{what}|" if claim.get("absolute") else what
    what = f"place with the same {what}" if claim["among"] else what
    low, high = (claim.get(key) for key in ("at_least", "at_most"))
    if low is None:
        text = f"{what} ≤ {number(high)}"
    else:
        text = f"{what} ≥ {number(low)}" if high is None else f"{number(low)} ≤ {what} ≤ {number(high)}"
    text += {"some": ", at some wavelength", "mean": ", on the mean"}.get(claim.get("over"), "")
    absorber = f", where {tables.name(claim['absorbed_by'])} absorbs well (lower half of its T)" if "absorbed_by" in claim else ""
    return text + absorber


def judged(sweep_file, folder):
    """Rows of conclusions.csv."""
    tables = Tables(sweep_file, folder)
    for claim in tables.conclusions():
        try:
            verdict, value, error, remark = measured(tables, claim)
        except Missing as why:
            verdict, value, error, remark = "undecided", "", "", str(why)
        words = {key: claim.get(key, "") for key in ("source", "quote", "translation", "because")}
        numbers = {"measured": value, "standard_error": error, "verdict": verdict, "remark": remark}
        yield {"id": claim["id"], "statement": claim["statement"], "inequality": inequality(tables, claim)} | numbers | words


def place(row):
    found = re.search(r"measured at (\d+) nm", row["remark"])
    return found and found[1]


def with_paired(rows, program):
    """Rows that the program itself has judged, pairing its samples, keep what it says; the values must agree."""
    known = {row["inequality"]: row for row in program if row["measured"]}
    for row in rows:
        there = known.get(row["inequality"])
        if there is None:
            yield row | {"errors": "unpaired"}
            continue
        value = float(there["measured"])
        # numbers of some 16 digits; ΔE₀₀ loses a few in differences of hues
        if place(row) == place(there) and abs(value - row["measured"]) > 1e-6 * max(1, abs(value)):
            raise SystemExit(f"{row['id']}: {row['measured']} from the tables, {value} by the program")
        numbers = {key: there[key] for key in ("measured", "standard_error", "verdict", "remark")}
        yield row | numbers | {"errors": "paired", "unpaired_error": row["standard_error"], "unpaired_verdict": row["verdict"]}
