"""Tests of the Python module: `python3 -m unittest discover python/tests`, with the program named by $INKWAVE.

NumPy is needed; what pandas, xarray, matplotlib, IPython, submitit and dask show is tested where they are installed.
"""

import contextlib
import doctest
import importlib
import importlib.util
import io
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "python"))

import inkwave as iw  # noqa: E402
from inkwave import _files, _program, _solve, _strategies, adapter  # noqa: E402

# Tests change folders.
os.environ["INKWAVE"] = os.path.abspath(iw.program())

INK = iw.Layer(0.3, binder=1.558, pigments=[iw.Pigment(d_nm=200, share=0.1, index="yellow")], title="Ink µ", more={"period_um": 0.8})
QUICK = dict(wavelength_nm=list(range(400, 701, 50)), realisations=2, resolution={"points_per_um": 20, "planes_per_um": 30},
             angles={"count": 3})
CASE = {"wavelength": 0.55, "L": 0.5, "H": 0.6, "eta_binder": 1.558, "spheres": [{"center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": 1.4 + 0.1j}]}


def have(*names):
    return all(importlib.util.find_spec(name) for name in names)


def film(case):
    """Fresnel's film at normal incidence."""
    (h, eta, _), n = case.films[0], 1.0
    r, phase = (n - eta) / (n + eta), np.exp(1j * case.k0 * eta * h)
    below = 1 - r**2 * phase**2
    return {(0, 0): (r * (1 - phase**2) / below, (1 - r**2) * phase / below)}


def film_of_powers(case):
    """A fault: powers instead of amplitudes."""
    return {order: tuple(abs(side) ** 2 for side in sides) for order, sides in film(case).items()}


class InFolder(unittest.TestCase):
    def setUp(self):
        self.before = os.getcwd()
        self.scratch = tempfile.TemporaryDirectory()
        os.chdir(self.scratch.name)

    def tearDown(self):
        os.chdir(self.before)
        self.scratch.cleanup()


class Documentation(InFolder):
    def test_examples_of_the_docstrings_run(self):
        tried = 0
        for path in sorted((ROOT / "python/inkwave").glob("*.py")):
            if path.stem not in ("__main__", "__init__"):
                module = importlib.import_module(f"inkwave.{path.stem}")
                done = doctest.testmod(module, extraglobs={"np": np}, verbose=False)
                self.assertEqual(done.failed, 0, path)
                tried += done.attempted
        self.assertGreater(tried, 25)

    def test_what_is_public_is_there_documented_and_typed(self):
        self.assertEqual(sorted(iw.__all__), sorted(set(iw.__all__)))
        for name in iw.__all__:
            self.assertTrue(getattr(iw, name).__doc__, name)
        self.assertTrue((ROOT / "python/inkwave/py.typed").exists())

    def test_the_version_is_that_of_the_program(self):
        manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
        self.assertIn(f'\nversion = "{iw.__version__}"', manifest)
        self.assertIn(iw.__version__, _program.call("--version"))

    @unittest.skipUnless(have("mypy"), "mypy is not installed")
    def test_type_hints_hold(self):
        # Python without the optional libraries: what they return is Any.
        command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--follow-imports=silent", "-p", "inkwave"]
        command += ["--exclude", "adapter", "--cache-dir", self.scratch.name]
        done = subprocess.run(command, cwd=ROOT / "python", capture_output=True, encoding="utf-8")
        faults = [line for line in done.stdout.splitlines() if ": error:" in line and "adapter.py" not in line]
        self.assertEqual(faults, [])


class Solves(InFolder):
    def test_numbers_of_any_kind_give_the_same_solve(self):
        lists = {**CASE, "eta_binder": [1.558, 0.0], "spheres": [{"center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": [1.4, 0.1]}]}
        arrays = {**CASE, "L": np.float64(0.5), "spheres": [{"center": np.array([0.2, 0.2, 0.3]), "radius": 0.15, "eta": np.complex128(1.4 + 0.1j)}]}
        words = dict(wavelength_nm=550, period_um=0.5, thickness_um=0.6, binder=1.558,
                     spheres=[dict(center_um=(0.2, 0.2, 0.3), radius_um=0.15, index=1.4 + 0.1j)])
        whole = iw.solve(lists, accuracy=1e-2)["R_total"]
        self.assertEqual(iw.solve(arrays, accuracy=np.float64(1e-2), snap=False)["R_total"], whole)
        self.assertEqual(iw.solve(CASE, 1e-2)["R_total"], whole)
        self.assertAlmostEqual(iw.solve(**words, accuracy=1e-2)["R_total"], whole, places=12)

    def test_a_packing_of_a_study_is_solved_as_the_command_line_does(self):
        pathlib.Path("ink.toml").write_text(_files.toml(_files.plain(INK.study(**QUICK))), encoding="utf-8")
        of_file = iw.solve("ink.toml", realisation=1, wavelength_nm=550, nxy=16, nz=8)
        self.assertEqual(iw.solve(INK.study(**QUICK), wavelength_nm=550, nxy=16, nz=8)["R_total"], of_file["R_total"])
        self.assertNotEqual(iw.solve(INK.study(**QUICK), wavelength_nm=550, realisation=2, nxy=16, nz=8)["R_total"], of_file["R_total"])

    def test_words_for_waves_are_those_of_studies(self):
        oblique = {**CASE, "sigma_deg": 40}
        both = iw.solve(oblique, 2e-2, wave="vector")
        for wave in ("s", "p"):
            one = iw.solve(oblique, 2e-2, wave=wave)
            self.assertEqual(one["R_total"], both["R_total"][wave])
            self.assertTrue(np.array_equal(one["orders"]["R"]["p"], both["orders"]["R"][wave]["p"]))
            self.assertEqual(one["orders"]["eff_R"].shape, both["orders"]["m"].shape)
        mean = iw.solve(oblique, 2e-2, wave="unpolarised")
        self.assertAlmostEqual(mean["R_total"], 0.5 * (both["R_total"]["s"] + both["R_total"]["p"]), places=12)
        self.assertNotAlmostEqual(both["R_total"]["s"], both["R_total"]["p"], places=4)

    def test_lists_of_wavelengths_and_angles_make_a_scan(self):
        scan = iw.solve(thickness_um=0.3, binder=1.5, wavelength_nm=np.arange(400, 701, 100), polar_deg=[0, 45])
        self.assertEqual(scan.n_rows, 8)
        self.assertEqual(scan.rows()[1]["polar_deg"], 45)
        # Independent: the film's closed form at normal incidence.
        n, h = 1.5, 0.3
        for row in scan.where(polar_deg=0).rows():
            r, phase = (1 - n) / (1 + n), np.exp(2j * np.pi * n * h / (1e-3 * row["wavelength_nm"]))
            exact = abs(r * (1 - phase**2) / (1 - r**2 * phase**2)) ** 2
            self.assertAlmostEqual(row["R_total"], exact, places=6)
        self.assertEqual(len(scan.solves), 8)

    def test_directions_of_both_sides_are_solved_together(self):
        listed = [{"polar_deg": 0}, {"polar_deg": 40, "azimuth_deg": 15}, {"polar_deg": 40, "from": "exit"}]
        scan = iw.solve(CASE, 1e-2, directions=listed)
        self.assertEqual(scan["polar_deg"].tolist(), [0, 40, 40])
        self.assertEqual(scan["from"].tolist(), ["incident", "incident", "exit"])
        for far, one in zip(scan.solves, listed):
            grid = dict(nxy=far["resolution"]["nx"], nz=far["resolution"]["cells"], scheme=far["resolution"]["scheme"])
            single = iw.solve(CASE, sigma_deg=one["polar_deg"], phi_deg=one.get("azimuth_deg", 0), from_=one.get("from", "incident"),
                              tolerance=2e-4, **grid)
            # the coverage of a searched grid is less exact than that of a given one
            self.assertAlmostEqual(single["R_total"], far["R_total"], places=3)
        with self.assertRaisesRegex(TypeError, "beside directions"):
            iw.solve(CASE, 1e-2, polar_deg=[0, 40], directions=listed)


class Studies(InFolder):
    def test_a_builder_a_dictionary_and_a_file_are_one_study(self):
        built = iw.run(INK, "built", **QUICK)
        table = iw.run(INK.study(**QUICK), "table")
        pathlib.Path("file.toml").write_text(_files.toml(_files.plain(INK.study(**QUICK))), encoding="utf-8")
        file = iw.run("file.toml")
        self.assertEqual(built.results["study_hash"], table.results["study_hash"])
        self.assertEqual(built.results["study_hash"], file.results["study_hash"])
        self.assertEqual(file.folder, pathlib.Path("out/file"))
        self.assertTrue(np.array_equal(built.spectra["reflectance"], file.spectra["reflectance"], equal_nan=True))
        self.assertEqual(iw.read(built).title, "Ink µ")

    def test_results_have_names_units_and_errors(self):
        r = iw.run(INK, "ink", **QUICK)
        self.assertEqual(r.spectra.units["wavelength_nm"], "nm")
        self.assertIn("reflectance", r.spectra.descriptions)
        self.assertEqual(r.spectra["wavelength_nm"].dtype.kind, "i")
        low, high = r.spectra.interval("reflectance")
        half = r.results["certainty"]["coverage_factor_95"] * r.spectra["reflectance_standard_error"]
        self.assertTrue(np.allclose(high - low, 2 * half) and r.spectra.coverage_factor > 1.9)
        self.assertEqual(r.lab.tolist(), r.results["colours"][0]["lab"])
        self.assertEqual(r.colour.conditions, "natural light")
        sums = np.add.reduceat(r.far_fields["order_reflected_efficiency"], r.far_fields["solve_first_order"][:-1])
        self.assertTrue(np.allclose(sums, r.far_fields["solve_reflectance"]))
        for text in (repr(r), repr(r.spectra)):
            self.assertLessEqual(len(text.splitlines()), 10)
            self.assertLess(len(text), 2500)
        self.assertIn("data:image/png;base64,", r._repr_html_())
        with self.assertRaisesRegex(AttributeError, "no hiding_thickness_um; there are .*spectra"):
            r.hiding_thickness_um

    def test_withheld_colours_are_warnings(self):
        with self.assertWarnsRegex(iw.InkwaveWarning, "no colour: wavelengths_nm from 450"):
            r = iw.run(INK, "few", **{**QUICK, "wavelength_nm": [450, 550, 650]})
        self.assertIsNone(r.colour)
        with self.assertRaisesRegex(ValueError, "no colour: wavelengths"):
            r.lab

    def test_grains_keep_their_integers(self):
        spheres = iw.pack(INK, "packed", realisations=1)[0]
        self.assertEqual((spheres["grain"].dtype.kind, spheres["pigment"].dtype.kind), ("i", "i"))
        self.assertTrue(np.array_equal(spheres["center_um"][:, 2], spheres["z_um"]))

    def test_a_sweep_is_one_table_whose_variants_are_the_folders(self):
        s = iw.sweep(INK, "swept", d_nm=[150, 200], share=[0.1, 0.2], **QUICK)
        folders = {path.name for path in pathlib.Path("swept/variants").iterdir()}
        self.assertEqual(set(s.variants), folders)
        self.assertEqual((s["d_nm"].dtype.kind, s["d_nm"].tolist()), ("i", [150, 150, 200, 200]))
        self.assertEqual(s.spectra.n_rows, sum(s.study(name).spectra.n_rows for name in s.variants))
        one = s.study("150-0.2").spectra["reflectance"]
        self.assertTrue(np.array_equal(s.spectra.where(d_nm=150, share=0.2)["reflectance"], one, equal_nan=True))
        self.assertEqual(s["coverage_factor_95"][0], s.study(s.variants[0]).coverage_factor)
        with self.assertRaisesRegex(KeyError, "there are 150-0.1"):
            s.study("150-0.3")

    @unittest.skipUnless(have("xarray", "pandas"), "xarray and pandas are not installed")
    def test_tables_become_xarray_and_pandas(self):
        s = iw.sweep(INK, "swept", d_nm=[150, 200], share=[0.1, 0.2], **QUICK)
        data = s.spectra.to_xarray()
        self.assertEqual(dict(data.sizes)["d_nm"], 2)
        self.assertEqual(data["wavelength_nm"].attrs["units"], "nm")
        row = s.spectra.where(d_nm=200, share=0.1, polar_deg=0, wavelength_nm=500)
        self.assertEqual(float(data["reflectance"].sel(d_nm=200, share=0.1, polar_deg=0, wavelength_nm=500)), row["reflectance"][0])
        if s.coverage_factor is not None:
            self.assertEqual(data["reflectance_standard_error"].attrs["coverage_factor_95"], s.coverage_factor)
        frame = s.spectra.to_pandas()
        self.assertEqual((len(frame), frame["d_nm"].dtype.kind, frame.attrs["units"]["wavelength_nm"]), (s.spectra.n_rows, "i", "nm"))

    def test_rows_that_are_missing_are_not_a_number(self):
        if not have("xarray"):
            self.skipTest("xarray is not installed")
        table = iw.Table({"a": [1, 1, 2], "b": ["x", "y", "x"], "v": [1, 2, 3], "t": ["p", "q", "r"]}, index=["a", "b"])
        data = table.to_xarray()
        self.assertTrue(np.isnan(data["v"].sel(a=2, b="y")))
        self.assertTrue(data["t"].isnull().sel(a=2, b="y"))
        self.assertEqual(list(iw.Table({"a": [1, 1], "v": [1, 2]}, index=["a"]).to_xarray().sizes), ["row"])

    @unittest.skipUnless(have("matplotlib"), "matplotlib is not installed")
    def test_plots_have_bars_of_95_percent(self):
        os.environ["MPLBACKEND"] = "Agg"
        r = iw.run(INK, "ink", **QUICK)
        ax = r.plot("reflectance", ax=__import__("matplotlib.pyplot").pyplot.subplots()[1])
        bars = ax.containers[0].lines[2][0].get_segments()
        table = r.spectra.where(polar_deg=0)
        drawn = np.array([bar[1][1] - bar[0][1] for bar in bars])
        self.assertTrue(np.allclose(drawn, 2 * r.coverage_factor * table.error("reflectance")))
        r.plot()


class Fits(InFolder):
    """Folders as `inkwave fit` and `inkwave design` write them: a run of either takes minutes."""

    def test_a_fit_is_a_table_and_its_remarks_are_warnings(self):
        quick = {**QUICK, "wavelength_nm": [450, 550, 650], "realisations": 6}
        ink = iw.Layer(0.5, pigments=[iw.Pigment(d_nm=200, share=0.2, index=1.4 + 0.2j, name="p")], title="draw", more={"period_um": 0.8})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for paper, name in ((0.85, "w"), (0.04, "b")):
                t = iw.run(ink, name, paper=paper, seed=5, **quick).spectra.where(polar_deg=0)
                rows = "".join(f"{nm},{r}\n" for nm, r in zip(t["wavelength_nm"], t["lit_at_45"]))
                pathlib.Path(f"{name}.csv").write_text("wavelength_nm,reflectance\n" + rows, encoding="utf-8")
        unknown = ink.with_(pigments=[iw.Pigment(d_nm=200, share=0.2, name="p", index=1.5)])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            fit = iw.fit(unknown, "fitted", white=("w.csv", 0.85), black=("b.csv", 0.04), noise=0.01, **quick)
        told = [str(one.message) for one in caught if issubclass(one.category, iw.InkwaveWarning)]
        self.assertEqual(fit.is_determined, not any("n is not determined" in line for line in told))
        self.assertTrue(set(fit.remarks) <= set(told))
        self.assertEqual(sorted(told), sorted(set(told)), "each remark once")
        self.assertFalse([line for line in told if "linearisation" in line or "coarse table" in line])
        self.assertEqual(caught[0].filename, __file__)
        self.assertTrue(np.allclose(fit.interval("kappa")[1] - fit["kappa"], 1.96 * fit.error("kappa")) and (fit.error("kappa") > 0).all())
        again = iw.run(ink.with_(pigments=[iw.Pigment(d_nm=200, share=0.2, name="p", index=fit.pigment_index)]), "again", **{**QUICK, "wavelength_nm": [450, 550, 650]})
        self.assertEqual(again.status, "complete")

    def test_a_fit_says_what_is_not_determined(self):
        folder = pathlib.Path("fit")
        folder.mkdir()
        (folder / "pigment.csv").write_text("# a remark, µ\nwavelength_nm,n,kappa,n_error,kappa_error,correlation\n450,1.4,0.3,0.01,0.02,0.5\n"
                                            "550,1.41,0.1,0.01,0.02,0.5\n", encoding="utf-8")
        (folder / "pigment-other.csv").write_text("wavelength_nm,n,kappa\n450,1.7,0.2\n550,1.7,0.1\n", encoding="utf-8")
        (folder / "fit.json").write_text('{"title": "t", "fit": {"remarks": ["n is not determined"], "n_is_determined": false, "trust": '
                                         '"consistent", "degrees_of_freedom": 3.5, "other_solution": {}}}', encoding="utf-8")
        fit = iw.Fit(folder)
        self.assertFalse(fit.is_determined)
        self.assertEqual(fit.other["n"].tolist(), [1.7, 1.7])
        self.assertTrue(np.allclose(fit.interval("n")[1] - fit["n"], 0.0196))
        self.assertIn("n is NOT determined", repr(fit))
        if have("matplotlib"):
            os.environ["MPLBACKEND"] = "Agg"
            axes = fit.plot()
            self.assertEqual(len(axes[0].lines), 2)

    def test_a_design_that_misses_its_target_says_how_near_it_comes(self):
        settings = {**QUICK, "run": {"realisations": 6}, "verifications": 1, "variants": 6, "delta_e": 0.05}
        del settings["realisations"]
        with self.assertWarnsRegex(iw.InkwaveWarning, "the target is not reached"):
            design = iw.design(INK, "designed", target=(80, 30, 20), vary={"share": (0.05, 0.2)}, **settings)
        self.assertFalse(design["met"])
        row = design.recipes.rows()[0]
        self.assertTrue(0.05 <= row["pigment[0].volume_fraction"] <= 0.2 and row["delta_e_2000"] > 0.05, row)
        self.assertRegex(row["hex"], "#[0-9a-f]{6}")
        self.assertLessEqual(len(repr(design).splitlines()), 10)

    def test_words_become_a_fit_and_a_design(self):
        pathlib.Path("w.csv").write_text("wavelength_nm,reflectance\n", encoding="utf-8")
        with self.assertRaisesRegex(iw.InputError, "w.csv"):
            iw.fit(INK, white=("w.csv", 0.85), noise=0.003)
        with self.assertRaisesRegex(iw.InputError, "target"):
            iw.design(INK, target=(300, 0, 0), vary={"d_nm": (140, 300)})


class Lines(InFolder):
    def test_a_plot_has_a_line_for_all_rows_that_differ_in_x_alone(self):
        table = iw.Table({"thickness_um": [1, 1, 2, 2], "wavelength_nm": [400, 500, 400, 500], "R": [0.1, 0.2, 0.3, 0.4]},
                         index=["thickness_um", "wavelength_nm"], units={"thickness_um": "µm"})
        lines = [(label, part["R"].tolist()) for label, part in table._lines("wavelength_nm")]
        self.assertEqual(lines, [("thickness_um [µm] 1", [0.1, 0.2]), ("thickness_um [µm] 2", [0.3, 0.4])])
        self.assertEqual([label for label, _ in table.where(thickness_um=1)._lines("wavelength_nm")], [""])

    def test_a_composed_layer_is_drawn_at_the_thicknesses_asked_for(self):
        if not have("matplotlib"):
            self.skipTest("no matplotlib")
        importlib.import_module("matplotlib").use("Agg")
        ax = iw.read(ROOT / "reports/white-paint").plot()
        self.assertEqual([text.get_text() for text in ax.get_legend().get_texts()], [f"thickness_um [µm] {um}" for um in (10, 20, 30)])


class Orphans(InFolder):
    @unittest.skipUnless(sys.platform == "linux", "reads /proc")
    def test_a_kernel_that_is_killed_leaves_no_program_at_work(self):
        script = ("import sys; sys.path.insert(0, sys.argv[1]); import inkwave as iw\n"
                  "iw.run(iw.Layer(1.0, pigments=[iw.Pigment(d_nm=200, share=0.3, index='yellow')]), 'endless', realisations=4000, accuracy=1e-3)")
        with subprocess.Popen([sys.executable, "-c", script, str(ROOT / "python")]) as kernel:
            folder = pathlib.Path("endless/records")
            deadline = time.monotonic() + 120
            while not folder.exists() and time.monotonic() < deadline:
                time.sleep(0.2)
            (child,) = (pid for pid, parent in _parents() if parent == kernel.pid)
            kernel.kill()
        deadline = time.monotonic() + 120
        while _runs(child) and time.monotonic() < deadline:
            time.sleep(0.2)
        left = _runs(child)
        if left:
            os.kill(child, signal.SIGKILL)
        self.assertFalse(left)


def _stat(pid):
    """State and parent of a process; None where there is none."""
    try:
        state, parent = pathlib.Path("/proc", str(pid), "stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return None
    return state, int(parent)


def _parents():
    """All processes with their parents."""
    pids = [int(path.name) for path in pathlib.Path("/proc").iterdir() if path.name.isdigit()]
    return [(pid, stat[1]) for pid in pids if (stat := _stat(pid))]


def _runs(pid):
    """Whether a process is there and at work."""
    stat = _stat(pid)
    return stat is not None and stat[0] not in "ZX"


class Mistakes(InFolder):
    """Each mistake: the program's message, the right exception, nothing left behind, nothing lost."""

    def refused(self, pattern, call, kind=iw.InputError):
        before = sorted(os.listdir())
        with self.assertRaises(kind) as caught:
            call()
        message = str(caught.exception)
        self.assertRegex(re.sub(r"\s*│?\s+", " ", message), pattern)
        self.assertNotIn("\x1b", message)
        self.assertEqual(sorted(os.listdir()), before)
        return message

    def test_a_wrong_key(self):
        study = INK.study(**QUICK)
        study["pigment"][0]["diametre_nm"] = study["pigment"][0].pop("diameter_nm")
        message = self.refused("diametre_nm: found an unknown key", lambda: iw.run(study, "x"))
        self.assertIn("did you mean diameter_nm", message)
        self.refused("papr.*unknown key", lambda: iw.run(INK, "x", papr=0.9))
        self.refused("eta_bindr", lambda: iw.solve({**CASE, "eta_bindr": 1.5}))
        # words of the call are judged before the program is: with what is near
        self.refused("realizations.*did you mean realisations", lambda: iw.run(INK, "x", realizations=4))
        self.refused("indx.*did you mean index", lambda: iw.solve(wavelength_nm=550, thickness_um=0.3, indx=1.5))
        self.refused("wave: found 'q'; allowed: scalar, vector, s, p, unpolarised", lambda: iw.solve({**CASE}, wave="q"))
        self.refused("wavelength_nm: found 0.55; allowed: from 100", lambda: iw.solve(wavelength_nm=0.55, thickness_um=0.3, binder=1.5))

    def test_words_and_options_are_those_of_the_program(self):
        said = self.refused("unknown key", lambda: iw.run({"layr": {}}, "x"))
        allowed = re.search("allowed: (.*?)\n *╭", re.sub(r"\n +│", "", said), re.DOTALL)
        self.assertEqual(re.findall("`(\w+)`", allowed[1]), list(_files._TABLES))
        helped = re.findall(r"^ +--([\w-]+)", _program.call("solve", "--help"), re.MULTILINE)
        self.assertEqual([name.replace("-", "_") for name in helped], list(_solve._FLAGS))

    def test_settings_of_a_stack(self):
        """One cell for all layers; a thickness belongs to one of them."""
        stack = {"stack": {}, "layer": [{"thickness_um": 0.2}, {"thickness_um": 0.3}]}
        self.assertEqual(_files.with_settings(stack, {"period_um": 0.8})["stack"], {"period_um": 0.8})
        self.refused("thickness_um: found a study of several layers", lambda: iw.run(stack, "x", thickness_um=0.2))
        self.refused("layer: found a table for a list of 2", lambda: iw.run(stack, "x", layer={"thickness_um": 0.2}))

    def test_files_of_a_dictionary_are_those_of_the_working_folder(self):
        pathlib.Path("m1.csv").write_text("", encoding="utf-8")
        pathlib.Path("solved").mkdir()
        study = {"paper": {"fluorescence": {"m1_csv": "m1.csv"}}, "area": [{"results": pathlib.Path("solved")}]}
        text = _files.written(study)
        self.assertIn(json.dumps(os.path.abspath("m1.csv")), text)
        self.assertIn(json.dumps(os.path.abspath("solved")), text)

    def test_complex_indices_of_two_axes(self):
        text = _files.written({"pigment": [{"index": {"ordinary": 2.0, "extraordinary": 2.2 + 0.01j}}]})
        self.assertIn("extraordinary = { n = 2.2, k = 0.01 }", text)

    def test_a_mistaken_unit(self):
        self.refused("diameter_nm", lambda: iw.run(INK.with_(pigments=[iw.Pigment(d_nm=0.2, share=0.1, index="yellow")]), "x", **QUICK))
        self.refused("thickness_um", lambda: iw.run(INK.with_(thickness_um=3000.0), "x", **QUICK))
        self.refused("wavelength", lambda: iw.solve({**CASE, "wavelength": 550}))

    def test_a_study_of_another_kind(self):
        table = {"base": INK.study(**QUICK), "axis": [{"field": "run.seed", "values": [1, 2]}]}
        self.refused("is a sweep, and this command reads a study", lambda: iw.run(table, "x"))
        self.refused("is a study, and this command reads a sweep", lambda: iw.sweep(INK.study(**QUICK), "x"))
        self.refused("is a sweep, and this command reads a case", lambda: iw.solve(pathlib.Path(ROOT, "examples/crowding.toml")))

    def test_a_folder_of_something_else_stays(self):
        iw.pack(INK, "here", realisations=1)
        before = {path: path.read_bytes() for path in pathlib.Path("here").iterdir() if path.is_file()}
        self.refused("here", lambda: iw.run(INK, "here", **QUICK))
        self.assertEqual({path: path.read_bytes() for path in pathlib.Path("here").iterdir() if path.is_file()}, before)

    def test_remarks_before_a_failure_are_not_lost(self):
        program = pathlib.Path("program")
        program.write_text("#!/bin/sh\necho 'no unit is stated' >&2\necho 'packing realisation 1/2' >&2\necho 'Error:   × too thin' >&2\n"
                           "echo '  help: thicker' >&2\nexit 1\n")
        program.chmod(0o755)
        with unittest.mock.patch.dict(os.environ, INKWAVE=str(program.resolve())):
            with self.assertWarnsRegex(iw.InkwaveWarning, "^no unit is stated$"), self.assertRaises(iw.InkwaveError) as caught:
                _program.call("run", "x")
        self.assertEqual(str(caught.exception), "too thin\n  help: thicker")
        self.assertNotIsInstance(caught.exception, iw.InputError)

    def test_a_file_that_is_not_there(self):
        self.refused("cannot read the study file", lambda: iw.run("nowhere.toml", "x"))

    def test_a_missing_program(self):
        named = os.environ["INKWAVE"]
        try:
            os.environ["INKWAVE"] = "/nowhere/inkwave"
            self.refused("INKWAVE names /nowhere/inkwave", lambda: iw.solve(CASE), iw.MissingProgram)
            del os.environ["INKWAVE"]
            path, os.environ["PATH"] = os.environ["PATH"], "/nowhere"
            try:
                if not any(os.path.exists(os.path.join(os.path.dirname(sys.executable), "inkwave")) for _ in "x"):
                    with self.assertRaises(FileNotFoundError):
                        iw.program()
            finally:
                os.environ["PATH"] = path
        finally:
            os.environ["INKWAVE"] = named

    def test_messages_have_no_terminal_codes(self):
        with unittest.mock.patch.dict(os.environ, {"FORCE_COLOR": "1", "CLICOLOR_FORCE": "1"}):
            self.refused("cannot read", lambda: iw.run("nowhere.toml", "x"))

    def test_what_toml_cannot_say(self):
        with self.assertRaisesRegex(TypeError, "cannot be written to a file of inkwave"):
            iw.run({"layer": object()}, "x")

    def test_the_locale_does_not_matter(self):
        iw.run(INK, "ink", **QUICK)
        code = f"import inkwave as iw; r = iw.read('ink'); assert r.title == 'Ink \\xb5', ascii(r.title); iw.run({INK.study(**QUICK)!a}, 'ink')"
        script = pathlib.Path("script.py")
        script.write_text(code, encoding="utf-8")
        environment = dict(os.environ, LC_ALL="C", PYTHONUTF8="0", PYTHONCOERCECLOCALE="0", PYTHONPATH=str(ROOT / "python"))
        done = subprocess.run([sys.executable, "script.py"], env=environment, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)


LONG = """
import inkwave as iw
iw.run({study!r}, "long")
"""


class Interrupts(InFolder):
    @unittest.skipIf(sys.platform == "win32", "signals of Unix")
    def test_an_interrupt_stops_the_work_and_keeps_what_is_stored(self):
        study = INK.study(wavelength_nm=list(range(400, 701, 50)), realisations=96, angles={"count": 3},
                          resolution={"points_per_um": 30, "planes_per_um": 30})
        pathlib.Path("long.py").write_text(LONG.format(study=study), encoding="utf-8")
        environment = dict(os.environ, PYTHONPATH=str(ROOT / "python"))
        # a shell's work in the background ignores the signal, and what it starts does, too
        child = subprocess.Popen([sys.executable, "long.py"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8",
                                 preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        records, until = pathlib.Path("long/records"), time.monotonic() + 120
        while not (records.exists() and sum(path.stat().st_size for path in records.iterdir() if path.is_file()) > 300_000):
            self.assertIsNone(child.poll(), "it ended before it could be interrupted")
            self.assertLess(time.monotonic(), until, "nothing is stored")
            time.sleep(0.05)
        child.send_signal(signal.SIGINT)
        said = child.communicate(timeout=120)[1]
        self.assertIn("KeyboardInterrupt", said)
        self.assertNotEqual(child.returncode, 0)
        # A clean stop writes what there is, a killed program nothing.
        self.assertTrue(pathlib.Path("long/results.json").exists(), os.listdir("long"))
        self.assertNotEqual(iw.read("long").status, "complete")
        here = os.path.realpath(self.scratch.name)
        left = [path for path in pathlib.Path("/proc").glob("[0-9]*/cmdline") if "--output" in _read(path) and _folder(path) == here]
        self.assertEqual(left, [], "the program still runs")
        heard = []
        with _files.input_file(study, {}, "long") as path:
            _program.call("run", path, "--output", "long", listen=heard.append)
        stored = [line for line in heard if line.endswith("solves were already stored")]
        self.assertEqual(len(stored), 1, heard)
        self.assertGreater(int(stored[0].split()[0]), 0)
        whole = iw.run(study, "whole")
        self.assertTrue(np.array_equal(iw.read("long").lab, whole.lab))


def _folder(path):
    with contextlib.suppress(OSError):
        return os.readlink(path.parent / "cwd")
    return ""


def _read(path):
    with contextlib.suppress(OSError):
        return path.read_text(encoding="utf-8", errors="replace")
    return ""


class Comparisons(InFolder):
    CASE = {"wavelength": 0.5, "H": 0.3, "eta_binder": 1.5 + 0.05j}

    def test_a_film_alone_is_compared_as_the_readme_says(self):
        table = iw.compare({"wavelength": 0.5, "H": 0.3, "eta_binder": 1.5}, against=film)
        self.assertIn("film", [str(name) for name in table["strategy"]])

    def test_a_function_of_ones_own_is_a_row(self):
        table = iw.compare(self.CASE, "compared", against={"good": film, "wrong": film_of_powers}, strategies=["krylov"], schemes=["cubic"])
        good, wrong = table.where(strategy="good"), table.where(strategy="wrong")
        self.assertLess(good["error"][0], 1e-6)
        self.assertGreater(wrong["error"][0], 1e-2)
        self.assertGreater(good["processor_seconds"][0], 0)

    def test_its_source_is_enough(self):
        space = {"np": np}
        name = pathlib.Path("cell.py").resolve()
        name.write_text("SIGN = 1\ndef own(case):\n    return scaled(case)\ndef scaled(case):\n    (h, eta, _), n = case.films[0], 1.0\n"
                        "    r, phase = (n - eta) / (n + eta), np.exp(SIGN * 1j * case.k0 * eta * h)\n    below = 1 - r**2 * phase**2\n"
                        "    return {(0, 0): (r * (1 - phase**2) / below, (1 - r**2) * phase / below)}\n")
        exec(compile(name.read_text(), str(name), "exec"), space)
        sources = _strategies._sources(space["own"])
        self.assertEqual({part: kind for part, (kind, _) in sources.items()}, {"own": "source", "scaled": "source", "np": "module", "SIGN": "value"})
        table = iw.compare(self.CASE, "compared", against=space["own"], strategies=["krylov"], schemes=["cubic"])
        self.assertLess(table.where(strategy="own")["error"][0], 1e-6)

    def test_what_cannot_be_sent_is_said(self):
        factor = 2
        with self.assertRaisesRegex(TypeError, "install cloudpickle"):
            _strategies._sources(lambda case: factor)

    def test_refusals_and_mistakes_are_named(self):
        table = iw.compare(CASE, "compared", against={"films": only_films}, strategies=["krylov"], schemes=["cubic"], accuracy=1e-2)
        self.assertIn("films only", table.where(strategy="films")["outcome"][0])
        with self.assertRaisesRegex(iw.InkwaveError, "(?s)film, scalar: .*power"):
            iw.conforms(general_powers)


def only_films(case):
    if case.spheres:
        raise adapter.Refusal("films only")
    return film(case)


def general_powers(case):
    """Films alone, with powers for amplitudes."""
    return {order: tuple(abs(side) ** 2 for side in sides) for order, sides in only_films(case).items()}


class Shards(InFolder):
    def merged(self, **engine):
        job = iw.submit(INK, 2, "sharded", share=[0.1, 0.2], **QUICK, **engine)
        found = job.result()
        self.assertTrue(job.done())
        whole = iw.sweep(INK, "whole", share=[0.1, 0.2], **QUICK)
        for name in ("variant", "share", "L", "L_standard_error"):
            self.assertTrue(np.array_equal(found[name], whole[name]), name)

    def test_a_local_pool_gives_the_numbers_of_one_process(self):
        self.merged(engine="local")

    def test_a_study_is_a_sweep_of_one_variant(self):
        found = iw.submit(INK, 2, **QUICK).result()
        # in folders of their own, without one being named
        alone = iw.run(INK, **QUICK)
        self.assertEqual(found["L"][0], alone.lab[0])

    @unittest.skipUnless(have("submitit"), "submitit is not installed")
    def test_submitit_on_this_machine(self):
        import submitit

        with unittest.mock.patch.dict(os.environ, PYTHONPATH=str(ROOT / "python")):
            self.merged(engine=submitit.LocalExecutor(folder="logs"))

    @unittest.skipUnless(have("dask", "distributed"), "dask.distributed is not installed")
    def test_dask_on_this_machine(self):
        from dask.distributed import Client

        with Client(n_workers=1, threads_per_worker=2, dashboard_address=None) as client:
            self.merged(engine=client)

    def test_bad_engines_are_refused(self):
        with self.assertRaisesRegex(ValueError, "local.*submitit.*dask"):
            iw.submit(INK, 2, "x", engine="slurm", **QUICK)
        with self.assertRaisesRegex(ValueError, "shards"):
            iw.submit(INK, 0, "x", **QUICK)


class Bars(unittest.TestCase):
    def test_progress_is_one_line_and_remarks_are_none_of_it(self):
        bar = _program.Progress("inkwave run", show=True)
        out = io.StringIO()
        with contextlib.redirect_stderr(out):
            for line in ("packing realisation 1/12", "grid: 18 × 24 points, 8 cells for an error of 1.0e-2",
                         "12/360 solves, realisation 1/12 · 500 nm · 0°, about 2 minutes left", "900 solves in 7 s: 462857 per hour, 9 % of the time outside solves"):
                self.assertTrue(bar.hear(line), line)
            for line in ('measured[0]: white.csv: no unit is stated; taken as factors of a perfect white', "no paper, colour and picture: angles", "n is not determined: its standard error is 0.13", "warning: layer.thickness_um",
                         "1 % more thickness than stated would change n by 0.008"):
                self.assertFalse(bar.hear(line), line)
            bar.close()
        self.assertEqual((bar.done, bar.all), (12, 360))
        self.assertEqual(out.getvalue().count("\n"), 0)

    def test_stages_of_the_sources_are_progress(self):
        stages = set()
        for path in (ROOT / "src").rglob("*.rs"):
            if "test" not in path.name:
                text = path.read_text(encoding="utf-8")
                stages |= set(re.findall(r'\.stage\((?:&format!\(\s*)?"([^"]*)"', text))
        reasons = {"{name}: {reason}", "no result: {error}", "{name}: {what}", "packing realisation 4/6"}
        self.assertGreater(len(stages - reasons), 12)
        bar = _program.Progress("inkwave", show=False)
        for stage in stages - reasons:
            line = re.sub(r"\{[^{}]*\}", "3", stage)
            self.assertTrue(bar.hear(line), line)
            self.assertTrue(bar.hear(f"0.1-150: {line}"), line)

    def test_nothing_is_printed_where_there_is_neither_terminal_nor_notebook(self):
        out = io.StringIO()
        with contextlib.redirect_stderr(out):
            bar = _program.Progress("inkwave run")
            bar.hear("1/2 solves, x")
            bar.close()
        self.assertEqual(out.getvalue(), "")

    @unittest.skipUnless(have("IPython"), "IPython is not installed")
    def test_a_notebook_has_one_bar(self):
        import IPython.display
        shown = []

        class Handle:
            def update(self, what):
                shown.append(("update", what.data))

        def display(what, display_id):
            shown.append(("display", what.data))
            return Handle()

        with unittest.mock.patch.object(_program, "in_notebook", return_value=True), unittest.mock.patch.object(IPython.display, "display", display):
            bar = _program.Progress("inkwave run")
            bar.hear("1/2 solves, <b>, a minute")
            bar.hear("2/2 solves, x")
            bar.close()
        self.assertEqual([kind for kind, _ in shown], ["display", "update", "update"])
        self.assertIn('value="1" max="2"', shown[0][1])
        self.assertIn("&lt;b&gt;", shown[0][1])


import unittest.mock  # noqa: E402

if __name__ == "__main__":
    warnings.simplefilter("default")
    unittest.main()
