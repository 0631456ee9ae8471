"""Checks of exported files with the programs they are meant for; called by scripts/check-exports."""

import csv
import importlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(sys.argv[1])
EXPORT = FOLDER / "export"
PICTURE = sys.argv[2] if len(sys.argv) > 2 else ""
FAILURES = []


def claim(name, measured, bound):
    holds = measured <= bound
    print(f"{'ok     ' if holds else 'FAILED '} {name}: {measured:.4g} (bound {bound:g})")
    if not holds:
        FAILURES.append(name)


def available(module):
    try:
        return importlib.import_module(module)
    except Exception as error:  # a broken install is as good as none
        print(f"SKIPPED: no {module} ({error})")
        return None


def table(name):
    with open(EXPORT / name, newline="") as file:
        return list(csv.DictReader(file))


def frame(np, light, view, azimuth):
    """wi, wo in the renderer's frame: wi points to the source, azimuth 0 is where the mirror image lies."""
    light, view, azimuth = np.radians(light), np.radians(view), np.radians(azimuth)
    wi = [np.sin(light), 0 * light, np.cos(light)]
    wo = [-np.sin(view) * np.cos(azimuth), -np.sin(view) * np.sin(azimuth), np.cos(view)]
    return np.array(wi), np.array(wo)


def turned(np, v, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


def evaluate(mi, bsdf, wi, wo, wavelength=None):
    """f·cos θ_o for columns of directions."""
    values = []
    context = mi.BSDFContext()
    for k in range(wi.shape[1]):
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(*[float(x) for x in wi[:, k]])
        if wavelength is not None:
            si.wavelengths = [float(wavelength[k])] * 4
        values.append([float(x) for x in bsdf.eval(context, si, mi.Vector3f(*[float(x) for x in wo[:, k]]))])
    return values


def albedo(mi, np, bsdf, polar, nm, points=64):
    """∫ f cos θ_o dω of the renderer's own values, by quadrature over the cosine and the azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(points // 2)
    mu, w = (nodes + 1) / 2, weights / 2
    phi = (np.arange(points) + 0.5) * 2 * np.pi / points
    mus, phis = np.meshgrid(mu, phi)
    sin = np.sqrt(1 - mus.ravel() ** 2)
    wo = np.array([sin * np.cos(phis.ravel()), sin * np.sin(phis.ravel()), mus.ravel()])
    wi = np.repeat(np.array([[np.sin(np.radians(polar))], [0.0], [np.cos(np.radians(polar))]]), wo.shape[1], axis=1)
    values = np.array(evaluate(mi, bsdf, wi, wo, np.full(wo.shape[1], nm)))[:, 0]
    return float(np.sum(values.reshape(points, -1) * w[None, :]) * 2 * np.pi / points)


def check_material(mi, np):
    mi.set_variant("scalar_spectral")
    bsdf = mi.load_dict({"type": "measured", "filename": str(EXPORT / "ink-spectral.bsdf")})
    rows = table("brdf-samples.csv")
    names = ["wavelength_nm", "light_polar_deg", "view_polar_deg", "azimuth_deg", "brdf_per_sr"]
    nm, light, view, azimuth, f = (np.array([float(r[n]) for r in rows]) for n in names)
    keep = (np.cos(np.radians(light)) > 0.2) & (np.cos(np.radians(view)) > 0.2)
    keep &= (np.arange(len(nm)) % 5 == 0) | (len(nm) < 1500)
    nm, light, view, azimuth, f = (x[keep] for x in (nm, light, view, azimuth, f))
    wi, wo = frame(np, light, view, azimuth)
    expected = f * wo[2]
    got = np.array(evaluate(mi, bsdf, wi, wo, nm))[:, 0]
    error = np.abs(got / expected - 1)
    print(f"        {len(error)} directions, median {np.median(error):.2%}")
    claim("material against the program, 95th percentile at cos > 0.2", float(np.percentile(error, 95)), 0.03)
    # the whole frame turned about the normal: the same numbers
    wi2, wo2 = turned(np, wi, 1.234), turned(np, wo, 1.234)
    got2 = np.array(evaluate(mi, bsdf, wi2, wo2, nm))[:, 0]
    claim("turned by 70.7 degrees, largest change", float(np.max(np.abs(got2 / got - 1))), 2e-3)
    # planted fault: directions without the half turn must not pass
    wrong = np.array(evaluate(mi, bsdf, wi, wo * np.array([[-1], [-1], [1]]), nm))[:, 0]
    caught = float(np.percentile(np.abs(wrong / expected - 1), 95))
    print(f"        planted: without the half turn 95th percentile {caught:.1%}")
    if caught < 0.03:
        print("        (this ink is too even to tell: the check of azimuths is empty)")
    spec = [r for r in table("specular.csv") if float(r["polar_deg"]) in (0.0, 30.0, 60.0)]
    waves = sorted({float(r["wavelength_nm"]) for r in spec})
    chosen = {waves[0], waves[len(waves) // 2], waves[-1]}
    worst, of_totals = 0.0, 0.0
    for row in (r for r in spec if float(r["wavelength_nm"]) in chosen):
        have = albedo(mi, np, bsdf, float(row["polar_deg"]), float(row["wavelength_nm"]))
        worst = max(worst, abs(have - float(row["albedo_of_brdf"])))
        of_totals = max(of_totals, abs(have - float(row["albedo_without_specular"])))
    claim("albedo against the program's own integral of f, largest difference", worst, 0.001)
    print(f"        the same against the totals R and T: {of_totals:.4f}")
    check_totals(table("specular.csv"))


def check_totals(rows):
    """f is fitted to orders, the albedo to the totals R and T of the same solves: beyond three standard errors of their
    difference, which chance explains, they may differ as much as the renderer's table does."""
    beyond, largest = 0.0, 0.0
    for row in (r for r in rows if float(r["polar_deg"]) <= 60.0):
        apart = abs(float(row["albedo_of_brdf"]) - float(row["albedo_without_specular"]))
        chance = 3.0 * float(row["difference_by_chance"] or 0.0)
        largest, beyond = max(largest, apart), max(beyond, apart - chance)
    print(f"        f against the totals up to 60 degrees: largest difference {largest:.4f}")
    claim("f against the totals R and T up to 60 degrees, largest difference beyond 3 standard errors", beyond, 0.007)


def check_patch(mi, np):
    """A flat patch under a uniform sky shows the natural light less its mirror part."""
    mi.set_variant("scalar_rgb")
    mi.load_dict({"type": "measured", "filename": str(EXPORT / "ink-rgb.bsdf")})
    mi.set_variant("scalar_spectral")
    bsdf = mi.load_dict({"type": "measured", "filename": str(EXPORT / "ink-spectral.bsdf")})
    rows = [r for r in table("specular.csv") if float(r["polar_deg"]) == 40.0]
    rng = np.random.default_rng(7)
    worst = 0.0
    for row in rows[:: max(1, len(rows) // 4)]:
        n = 40000
        u = rng.random((2, n))
        nm = float(row["wavelength_nm"])
        wi = [float(np.sin(np.radians(40.0))), 0.0, float(np.cos(np.radians(40.0)))]
        si = mi.SurfaceInteraction3f()
        si.wi, si.wavelengths = mi.Vector3f(*wi), [nm] * 4
        context, total = mi.BSDFContext(), 0.0
        for k in range(n):
            sample, weight = bsdf.sample(context, si, 0.5, mi.Point2f(float(u[0, k]), float(u[1, k])))
            total += float(weight[0])
        # radiance 1 from everywhere: the mean weight of the renderer's own sampling is the radiance seen
        worst = max(worst, abs(total / n - float(row["albedo_without_specular"])))
    claim("patch under a uniform sky, seen at 40 degrees, largest difference", worst, 0.01)


def render(mi):
    for variant, scene in (("scalar_spectral", "scene-spectral.xml"), ("scalar_rgb", "scene-rgb.xml")):
        mi.set_variant(variant)
        if variant == "scalar_rgb":
            image = mi.render(mi.load_file(str(EXPORT / scene)), spp=256 if PICTURE else 64)
            target = PICTURE or str(EXPORT / "scene.png")
            mi.util.write_bitmap(target, image)
            print(f"ok      {scene} rendered to {target}")
        else:
            mi.load_file(str(EXPORT / scene))
            print(f"ok      {scene} loads")


def check_cxf(np):
    colour_cxf = available("colour_cxf")
    # one row for each wavelength and angle; the print's columns stand in one of them
    rows = csv.DictReader(open(FOLDER / "spectra.csv"))
    known = {float(r["wavelength_nm"]): float(r["lit_at_45"]) for r in rows if r["lit_at_45"]}
    if colour_cxf:
        cxf = colour_cxf.read_cxf_from_file(EXPORT / "spectra.cxf")
        first = cxf.resources.object_collection.object_value[0].color_values.choice[0]
        values, start = list(first.value), int(first.start_wl)
        error = max(abs(values[round((nm - start) / 10)] - r) for nm, r in known.items() if nm % 10 == 0)
        claim("CxF read by colour-cxf, largest difference of 45:0", error, 1e-6)
    if shutil.which("cxf2ti3"):
        with tempfile.TemporaryDirectory() as scratch:
            base = pathlib.Path(scratch) / "x"
            done = subprocess.run(["cxf2ti3", EXPORT / "spectra.cxf", base], capture_output=True, text=True)
            found = list(pathlib.Path(scratch).iterdir())
            rows = argyll_rows(found[0]) if found else []
            if not rows:
                print(done.stdout, done.stderr)
            error = spectrum_error(rows[0], known) if rows else 1.0
        claim("CxF read by Argyll's cxf2ti3, largest difference of 45:0", error, 1e-5)
    if shutil.which("spec2cie"):
        with tempfile.TemporaryDirectory() as scratch:
            out = pathlib.Path(scratch) / "out.sp"
            light, observer = lab_conditions(EXPORT / "spectra.sp")
            asked = ["-i", light if light in SPEC2CIE_LIGHTS else "D65", "-o", SPEC2CIE_OBSERVERS.get(observer, "1931_2")]
            command = ["spec2cie", *asked, EXPORT / "spectra.sp", out]
            done = subprocess.run(command, capture_output=True, text=True)
            if not out.exists():
                print(done.stdout, done.stderr)
                claim("CGATS read by Argyll's spec2cie", 1, 0)
                return
            rows, own = argyll_rows(out), argyll_rows(EXPORT / "spectra.sp")
            claim("CGATS read by spec2cie, largest difference of 45:0", spectrum_error(rows[0], known), 1e-5)
            # LAB_* of the answer is relative to D50; Lab relative to the illuminant asked for carries its name
            lab = lambda row, name: np.array([float(row[f"{name}_{axis}"]) for axis in "LAB"])
            # that of D50 is LAB itself
            name = "LAB" if light == "D50" else f"{light}LAB"
            if light not in SPEC2CIE_LIGHTS or observer not in SPEC2CIE_OBSERVERS or f"{name}_L" not in rows[0]:
                print(f"SKIPPED: this spec2cie gives no Lab relative to {light} for the {observer} observer")
                return
            theirs = [lab(row, name) for row in rows]
            here = [lab(row, "LAB") for row in own]
            print(f"        Lab here {here[0].round(2)}, spec2cie {theirs[0].round(2)}")
            apart = max(float(np.linalg.norm(a - b)) for a, b in zip(here, theirs))
            # two summation rules over 10 nm: ΔE up to 0.17 between them
            claim("Lab against spec2cie, largest distance", apart, 0.17)


SPEC2CIE_LIGHTS = ["A", "C", "D50", "D65", "F5", "F8", "F10"]
SPEC2CIE_OBSERVERS = {"2 degree": "1931_2", "10 degree": "1964_10"}


def lab_conditions(path):
    """Illuminant and observer that the file says its Lab is for."""
    line = next(line for line in path.read_text().splitlines() if line.startswith("LAB_CONDITIONS"))
    light, observer = line.split('"')[1].split(", ", 1)
    return light, observer.split(" observer")[0]


def argyll_rows(path):
    words, fields, rows, mode = pathlib.Path(path).read_text().splitlines(), [], [], None
    for line in words:
        if line.startswith(("BEGIN_DATA_FORMAT", "BEGIN_DATA")):
            mode = "format" if "FORMAT" in line else "data"
        elif line.startswith("END_DATA"):
            mode = None
        elif mode == "format":
            fields += line.split()
        elif mode == "data" and line.strip():
            cells = [c for c in csv.reader([line.strip()], delimiter=" ")][0]
            rows.append(dict(zip(fields, [c for c in cells if c])))
    return rows


def spectrum_error(row, known):
    column = lambda nm: float(row.get(f"SPEC_{int(nm):03d}", row.get(f"SPEC_{int(nm)}", "nan"))) / 100
    return max(abs(column(nm) - r) for nm, r in known.items() if nm % 10 == 0)


def check_prints():
    """Characterisation sets: read by Argyll's txt2ti3, and made into an ICC profile by colprof where they are of process inks."""
    for path in sorted(EXPORT.glob("prints*.cgats")):
        if not shutil.which("txt2ti3"):
            return print("SKIPPED: no txt2ti3 of Argyll")
        rows = argyll_rows(path)
        device = [field for field in rows[0] if field.startswith("CMYK_")]
        with tempfile.TemporaryDirectory() as scratch:
            base = pathlib.Path(scratch) / "set"
            # it knows CMYK and RGB alone
            if not device:
                print(f"SKIPPED: {path.name} is of other inks than cyan, magenta, yellow and black")
                continue
            done = subprocess.run(["txt2ti3", path, base], capture_output=True, text=True)
            read = argyll_rows(base.with_suffix(".ti3")) if done.returncode == 0 else []
            claim(f"{path.name}: prints that txt2ti3 leaves out", abs(len(read) - len(rows)), 0)
            if not read:
                print(done.stdout, done.stderr)
                continue
            names = [*device, "LAB_L", "LAB_A", "LAB_B"]
            apart = max(abs(float(a[name]) - float(b[name])) for a, b in zip(read, rows) for name in names)
            claim(f"{path.name}: inks and Lab as txt2ti3 reads them, largest difference", apart, 1e-3)
            claim(f"{path.name}: bands of its spectra that txt2ti3 leaves out",
                  sum(name.startswith("SPECTRAL_NM") for name in rows[0]) - sum(name.startswith("SPEC_") for name in read[0]), 0)
            # a profile needs more prints than its smallest grid has places
            if len(rows) < 60:
                continue
            done = subprocess.run(["colprof", "-v", "-ql", "-bn", base], capture_output=True, text=True)
            error = re.search(r"avg err = ([0-9.]+)", done.stdout + done.stderr)
            claim(f"{path.name}: mean distance of the profile that colprof makes from its prints", float(error[1]) if error else 9.0, 1.0)


def check_arrays(np):
    f = np.load(EXPORT / "far-fields.npz")
    first, r, t = f["solve_first_order"], f["order_reflected_efficiency"], f["order_transmitted_efficiency"]
    total = np.add.reduceat(r, first[:-1])
    claim("npz: reflected orders sum to R, largest difference", float(np.max(np.abs(total - f["solve_reflectance"]))), 1e-9)
    energy = f["solve_reflectance"] + f["solve_transmittance"] + f["solve_absorptance"] - 1
    print(f"        {len(total)} solves, {len(r)} orders, largest |R + T + A - 1| {np.max(np.abs(energy)):.1e}")
    pyvista = available("pyvista")
    if pyvista:
        study = json.load(open(EXPORT / "study.json"))
        image = pyvista.read(EXPORT / "contrast.vti")
        for pigment in study["pigments"]:
            share = float(np.mean(image[f"share_{pigment['name']}"]))
            asked = pigment["grains"]["volume_fraction"]
            claim(f"vti: share of {pigment['name']} against the study", abs(share - asked), 0.01)
        size = [(n * s) for n, s in zip(image.dimensions, image.spacing)]
        claim("vti: volume against the study", abs(size[2] - study["layer"]["thickness_um"]), 1e-9)
        if (EXPORT / "near-field.vti").exists():
            near = pyvista.read(EXPORT / "near-field.vti")
            print(f"        near field {near.dimensions}, mean intensity {float(np.mean(near['intensity'])):.3f}")


def check_provenance():
    if frictionless := available("frictionless"):
        report = frictionless.Package(str(EXPORT / "datapackage.json")).validate()
        errors = report.flatten(["message"])
        print(*errors[:5], sep="\n")
        claim("datapackage.json, errors of frictionless", len(errors), 0)
    if available("rocrate"):
        from rocrate.rocrate import ROCrate

        crate = ROCrate(EXPORT)
        missing = [e.id for e in crate.data_entities if not (EXPORT / e.id).exists()]
        claim("RO-Crate, parts that are missing", len(missing), 0)
        actions = [e for e in crate.contextual_entities if e.type == "CreateAction"]
        claim("RO-Crate, one action", abs(len(actions) - 1), 0)


def main():
    np = available("numpy")
    if not np:
        return
    if mi := available("mitsuba"):
        check_material(mi, np)
        check_patch(mi, np)
        render(mi)
    check_cxf(np)
    check_prints()
    check_arrays(np)
    check_provenance()
    print(f"{len(FAILURES)} checks failed" if FAILURES else "all checks that could run hold")
    sys.exit(1 if FAILURES else 0)


main()
