"""Predicts what a printer-ink or paint layer looks like: the program `inkwave`, called from Python.

Every function runs the program, so the numbers are those of the command line. It works without a wheel: with this folder on
the path (`PYTHONPATH=python`), the program on the PATH or named by $INKWAVE, and NumPy.
"""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import warnings
from dataclasses import dataclass

import numpy as np

__all__ = ["InkwaveError", "Ink", "compare", "export", "pack", "program", "read", "run", "solve", "sweep"]


class InkwaveError(RuntimeError):
    """The program refused its input or failed; the text is its message."""


def program() -> str:
    """Path of the program: $INKWAVE, next to this Python, or on the PATH."""
    name = "inkwave.exe" if sys.platform == "win32" else "inkwave"
    places = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    own = [os.path.join(place, name) for place in places if place]
    for candidate in [os.environ.get("INKWAVE"), *own, shutil.which("inkwave")]:
        if candidate and os.path.exists(candidate):
            return candidate
    raise InkwaveError("the program inkwave is not found: name it by $INKWAVE, or install the wheel (python/README.md)")


def _call(*arguments, show=False) -> str:
    """Standard output of the program; its standard error is shown or becomes the exception."""
    command = [program(), *map(str, arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=None if show else subprocess.PIPE, text=True)
    if done.returncode:
        raise InkwaveError((done.stderr or f"inkwave {arguments[0]} failed").strip())
    return done.stdout


def solve(case, accuracy: float = 1e-3, **options) -> dict:
    """One solve of an explicit geometry: totals, error estimate, and the orders as arrays.

    `case` is a dictionary as in `inkwave solve CASE.json` (lengths in µm, angles in degrees), or the path of such a
    file. Further options are those of the command line: `solver="born"`, `nxy=20, nz=12` instead of an accuracy,
    `wave="vector"` (amplitudes are then `far["orders"]["R"]["s"]["p"]` and so on), `illuminated_um=10` for the light per steradian of a
    lit square (`far["finite_area"]`), `snap=True` for a direction of the lattice (`far["snapped"]`).

    >>> far = solve({"wavelength": 0.5, "H": 0.3, "eta_binder": [1.5, 0.0]})
    >>> abs(far["R_total"] + far["T_total"] + far["A_total"] - 1) < 1e-6
    True
    """
    arguments = [] if "nz" in options else ["--accuracy", accuracy]
    for name, value in options.items():
        arguments += ["--" + name.replace("_", "-")] + ([] if value is True else [value])
    with tempfile.TemporaryDirectory() as scratch:
        path = case
        if isinstance(case, dict):
            path = pathlib.Path(scratch) / "case.json"
            path.write_text(json.dumps(case))
        found = json.loads(_call("solve", path, *arguments))
    found["orders"] = _columns(found["orders"])
    return found


def _columns(rows) -> dict:
    """A list of objects as arrays; pairs [re, im] become complex numbers, objects inside dictionaries of arrays."""
    def column(name):
        values = [row[name] for row in rows]
        if values and isinstance(values[0], dict):
            return _columns(values)
        pairs = values and isinstance(values[0], list) and len(values[0]) == 2
        complex_pair = pairs and name not in ("direction",)
        return np.array([complex(*v) for v in values]) if complex_pair else np.array(values)

    return {name: column(name) for name in (rows[0] if rows else {})}


def run(study, output, jobs=None) -> pathlib.Path:
    """Runs or resumes a study file, showing progress, and returns the folder of its results."""
    _call("run", study, "--output", output, *([] if jobs is None else ["--jobs", jobs]), show=True)
    return pathlib.Path(output)


def pack(study, output, realisations=None) -> list:
    """Packs a study without solving: the grains of each packing, one dictionary of arrays for each realisation.

    `center_um` (x, y, z), `radius_um`, `pigment` (its place in the study's list) and `grain` (the rigid body) have one
    entry for each sphere.
    """
    more = [] if realisations is None else ["--realisations", realisations]
    _call("pack", study, "--output", output, *more, show=True)
    tables = [_table(path) for path in sorted(pathlib.Path(output).glob("grains_*.csv"))]
    return [{"center_um": np.column_stack([t["x_um"], t["y_um"], t["z_um"]]), **t} for t in tables]


def sweep(file, output, jobs=None) -> dict:
    """Runs or resumes a sweep, showing progress; the columns of `sweep.csv`, one row for each variant."""
    _call("sweep", file, "--output", output, *([] if jobs is None else ["--jobs", jobs]), show=True)
    return _table(pathlib.Path(output) / "sweep.csv")


def compare(file, output) -> dict:
    """Runs a comparison of strategies and programs; the columns of `comparison.csv`, one row for each solve."""
    _call("compare", file, "--output", output, show=True)
    return _table(pathlib.Path(output) / "comparison.csv")


def fit(file, output) -> dict:
    """Fits a pigment's index to spectra of drawdowns, or resumes; the columns of `pigment.csv`: `n`, `kappa` and their errors.

    Besides them `remarks`, the sentences that the program says of the result, `n_is_determined`, `trust` ("consistent", "untested",
    "inflated"), `degrees_of_freedom`, and `other_solution`: the columns of `pigment-other.csv` where a second index fits as well, else None.
    Where n is not determined, the first remark is a warning, too.
    """
    _call("fit", file, "--output", output, show=True)
    folder = pathlib.Path(output)
    found = json.loads((folder / "fit.json").read_text())["fit"]
    told = {name: found[name] for name in ("remarks", "n_is_determined", "trust", "degrees_of_freedom")}
    second = _table(folder / "pigment-other.csv") if found["other_solution"] else None
    if not found["n_is_determined"]:
        warnings.warn(found["remarks"][0], stacklevel=2)
    return _table(folder / "pigment.csv") | told | {"other_solution": second}


def design(file, output) -> dict:
    """Looks for recipes of a target colour, or resumes; what `design.json` says under `design`."""
    _call("design", file, "--output", output, show=True)
    return json.loads((pathlib.Path(output) / "design.json").read_text())["design"]


def _table(path) -> dict:
    """Columns of a CSV file: arrays of numbers, empty cells NaN, or of texts where a cell is no number."""
    with open(path, newline="") as file:
        names, *rows = csv.reader(line for line in file if not line.startswith("#"))

    def column(cells):
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            return np.array(cells)

    return {name: column([row[i] for row in rows]) for i, name in enumerate(names)}


def export(folder, *formats, output=None) -> pathlib.Path:
    """Writes files for other programs, as `inkwave export` does: export(folder, "mitsuba", "cxf")."""
    _call("export", folder, "--to", ",".join(formats), *([] if output is None else ["--output", output]))
    return pathlib.Path(output or pathlib.Path(folder) / "export")


@dataclass
class Ink:
    """A finished study: numbers and provenance, spectra with standard errors, far fields."""

    results: dict
    """`results.json`: colours, certainty, the study itself."""
    spectra: dict
    """Columns of `spectra.csv` as arrays, one row for each angle and wavelength; unknown values are NaN."""
    far_fields: dict
    """Arrays `solve_…` with one row per solve and `order_…` with one row per order."""

    def orders(self, solve: int) -> slice:
        """Rows of the `order_…` arrays that belong to a solve."""
        first = self.far_fields["solve_first_order"]
        return slice(int(first[solve]), int(first[solve + 1]))


def read(folder) -> Ink:
    """Reads a folder written by `inkwave run` as arrays, without solving anything."""
    folder = pathlib.Path(folder)
    with tempfile.TemporaryDirectory() as scratch:
        export(folder, "npz", output=scratch)
        with np.load(pathlib.Path(scratch) / "far-fields.npz") as arrays:
            far_fields = {name: arrays[name] for name in arrays.files}
    spectra = _table(folder / "spectra.csv")
    return Ink(json.loads((folder / "results.json").read_text()), spectra, far_fields)
