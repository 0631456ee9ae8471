"""Predicts what a printer-ink or paint layer looks like: the program `inkwave`, called from Python.

Every function runs the program that the wheel has installed, so the numbers are those of the command line.
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
from dataclasses import dataclass

import numpy as np

__all__ = ["InkwaveError", "Ink", "export", "program", "read", "run", "solve"]


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
    raise InkwaveError("the program inkwave is not installed: pip install inkwave")


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
    with open(folder / "spectra.csv", newline="") as file:
        rows = list(csv.reader(file))
    numbers = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]])
    spectra = {name: numbers[:, i] for i, name in enumerate(rows[0])}
    return Ink(json.loads((folder / "results.json").read_text()), spectra, far_fields)
