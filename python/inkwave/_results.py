"""Finished work as Python sees it: a study, a sweep, a fit, a design, each with its folder."""

from __future__ import annotations

import base64
import functools
import html
import json
import os
import pathlib
import tempfile
import webbrowser
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from ._files import Path
from ._program import call
from ._tables import Table, Value, _needed, read_table

__all__ = ["Colour", "Design", "Fit", "Ink", "Sweep", "export", "read"]


def _value(found: Any, unit: str = "", coverage_factor: Optional[float] = None) -> Optional[Value]:
    """A number of a results file, `{ value, standard_error }` or bare; None where the program withholds it."""
    if found is None:
        return None
    if isinstance(found, Mapping):
        return Value(found["value"], found.get("standard_error"), unit, coverage_factor)
    return Value(found, None, unit, coverage_factor)


class Colour:
    """A colour with its errors: CIELAB, sRGB, the light and the place it is seen from."""

    def __init__(self, conditions: str, lab: np.ndarray, lab_error: np.ndarray, hex: Optional[str] = None,
                 coverage_factor: Optional[float] = None, delta_e_95: Optional[float] = None, thickness_um: Optional[float] = None):
        self.conditions, self.lab, self.lab_error, self.hex = conditions, lab, lab_error, hex
        self.coverage_factor, self.delta_e_95, self.thickness_um = coverage_factor, delta_e_95, thickness_um

    @property
    def chroma(self) -> float:
        """C*."""
        return float(np.hypot(self.lab[1], self.lab[2]))

    @property
    def hue_deg(self) -> float:
        """Hue angle, degrees from the a* axis."""
        return float(np.degrees(np.arctan2(self.lab[2], self.lab[1])) % 360)

    def __repr__(self) -> str:
        parts = [f"{name} {Value(v, e)!r}" for name, v, e in zip(("L*", "a*", "b*"), self.lab, self.lab_error)]
        of = f", {self.thickness_um:g} µm" if self.thickness_um is not None else ""
        return f"{', '.join(parts)} ({self.conditions}{of})"

    def _repr_html_(self) -> str:
        patch = f'<span style="background:{self.hex};padding:0 1em">&nbsp;</span> ' if self.hex else ""
        return patch + html.escape(repr(self))


class _Folder:
    """Results in a folder, which stands for them wherever a path is asked for."""

    folder: pathlib.Path
    page: str = "report.html"

    def __fspath__(self) -> str:
        return os.fspath(self.folder)

    def show(self) -> pathlib.Path:
        """Opens the page in a browser; its path."""
        path = (self.folder / self.page).resolve()
        webbrowser.open(path.as_uri())
        return path


class Ink(_Folder):
    """A finished study: numbers and provenance, spectra with standard errors, colours, far fields."""

    results: Dict[str, Any]
    """`results.json`: colours, certainty, the study itself."""
    spectra: Table
    """`spectra.csv`, a row for each angle (or thickness) and wavelength."""

    def __init__(self, folder: Path):
        self.folder = pathlib.Path(folder)
        self.results = json.loads((self.folder / "results.json").read_text(encoding="utf-8"))
        self.spectra = read_table(self.folder / "spectra.csv", coverage_factor=self.coverage_factor, title=self.title)

    @property
    def title(self) -> str:
        """The study's title."""
        return str(self.results["title"])

    @property
    def status(self) -> str:
        """"complete", or what is missing."""
        return str(self.results["status"])

    @property
    def coverage_factor(self) -> Optional[float]:
        """What a standard error is multiplied by for half of a 95 % interval: Student's t; None where the program states none."""
        found: Optional[float] = self.results.get("certainty", {}).get("coverage_factor_95")
        return found

    @property
    def colours(self) -> Tuple[Colour, ...]:
        """All colours: by light, and by thickness for a composed layer."""
        found = []
        for row in self.results.get("colours") or []:
            if "lab" in row:
                hexadecimal = "#{:02x}{:02x}{:02x}".format(*row["srgb8"]) if row.get("srgb8") else None
                found.append(Colour(row["conditions"], np.array(row["lab"]), np.array(row["lab_standard_error"]), hexadecimal,
                                    self.coverage_factor, row.get("delta_e_2000_95"), row.get("thickness_um")))
            else:
                found += [_composed_colour(row, key, self.coverage_factor) for key in _LIGHTS if row.get(key)]
        return tuple(found)

    @property
    def colour(self) -> Optional[Colour]:
        """The first colour: under natural light; None where there is none (`results["no_colour"]` says why)."""
        return next(iter(self.colours), None)

    @property
    def lab(self) -> np.ndarray:
        """L*, a*, b* of `colour`."""
        return self._colour().lab

    @property
    def lab_error(self) -> np.ndarray:
        """Standard errors of `lab`."""
        return self._colour().lab_error

    def _colour(self) -> Colour:
        if self.colour is None:
            raise ValueError(f"{self.title} has no colour: {self.results.get('no_colour') or 'the results name none'}")
        return self.colour

    def __getattr__(self, name: str) -> Any:
        """Numbers of `results.json` by name, such as `hiding_thickness_um`, as values with errors."""
        if name.startswith("_") or name in ("results", "folder", "spectra") or name not in self.results:
            raise AttributeError(f"the results have no {name}; there are {', '.join(self.__dict__.get('results', {}))}")
        found = self.results[name]
        if isinstance(found, (int, float)) and not isinstance(found, bool) or isinstance(found, Mapping) and "value" in found:
            unit = "µm" if name.endswith("_um") else "m²/l" if name.endswith("_m2_per_l") else ""
            return _value(found, unit, self.coverage_factor)
        return found

    @property
    def remarks(self) -> List[str]:
        """Sentences of the program about the results: what is withheld, and why."""
        found = [self.results.get("no_colour"), self.results.get("no_hiding"), *(self.results.get("remarks") or [])]
        return [line for line in found if line]

    @functools.cached_property
    def far_fields(self) -> Dict[str, np.ndarray]:
        """Arrays `solve_…` with one row per solve and `order_…` with one row per order; read from the stored solves when first asked."""
        with tempfile.TemporaryDirectory(prefix="inkwave-") as scratch:
            export(self.folder, "npz", output=scratch)
            with np.load(pathlib.Path(scratch) / "far-fields.npz") as arrays:
                return {name: arrays[name] for name in arrays.files}

    def orders(self, solve: int) -> slice:
        """Rows of the `order_…` arrays that belong to a solve."""
        first = self.far_fields["solve_first_order"]
        return slice(int(first[solve]), int(first[solve + 1]))

    @property
    def picture(self) -> Optional[pathlib.Path]:
        """The picture of the print, if there is one."""
        return next((path for path in (self.folder / "picture-with-axes.png", self.folder / "picture.png") if path.exists()), None)

    def plot(self, *names: str, ax: Any = None) -> Any:
        """R(λ) at the normal, or the named columns, with 95 % bars, and the picture beside it; matplotlib's axes."""
        if ax is None and self.picture is not None:
            pyplot = _needed("matplotlib.pyplot")
            ax, picture = pyplot.subplots(1, 2, figsize=(10, 4))[1]
            picture.imshow(pyplot.imread(self.picture))
            picture.axis("off")
        table = self.spectra.where(polar_deg=0) if "polar_deg" in self.spectra else self.spectra
        asked = [colour.thickness_um for colour in self.colours if colour.thickness_um is not None]
        if asked and "thickness_um" in table:  # the others are there to find the thickness that hides
            table = table._like({name: column[np.isin(table["thickness_um"], asked)] for name, column in table._columns.items()})
        first = next((name for name in ("natural_light", "reflectance") if name in table and np.isfinite(table[name]).any()), None)
        return table.plot(*(names or ([first] if first else [])), x="wavelength_nm", ax=ax)

    def __repr__(self) -> str:
        """At most ten lines."""
        factor = f"95 % intervals are ± {self.coverage_factor:.3g} standard errors" if self.coverage_factor else "± is one standard error"
        lines = [f"{self.title} ({self.status}): {factor}", *[f"  {colour!r}" for colour in self.colours[:4]],
                 f"  spectra: {self.spectra.n_rows} rows of {', '.join(list(self.spectra)[:4])}, …",
                 *[f"  {line[:150]}" for line in self.remarks[:3]], f"  {self.folder}"]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        picture = ""
        if self.picture is not None:
            data = base64.b64encode(self.picture.read_bytes()).decode("ascii")
            picture = f'<img alt="{html.escape(self.title)}" style="max-width:100%" src="data:image/png;base64,{data}">'
        colours = "".join(f"<li>{colour._repr_html_()}</li>" for colour in self.colours[:4])
        remarks = "".join(f"<li>{html.escape(line)}</li>" for line in self.remarks)
        head = html.escape(f"{self.title} ({self.status}; coverage factor {self.coverage_factor or 'not stated'})")
        return f"<p><b>{head}</b></p>{picture}<ul>{colours}{remarks}</ul>"


_LIGHTS = {"natural_light": "natural light", "lit_at_45": "45:0", "over_black": "45:0, over black"}


def _composed_colour(row: Mapping[str, Any], key: str, coverage_factor: Optional[float]) -> Colour:
    parts = row[key]
    parts = [parts[name] for name in ("l", "a", "b")] if isinstance(parts, Mapping) else parts
    values, errors = ([part[name] for part in parts] for name in ("value", "standard_error"))
    return Colour(_LIGHTS[key], np.array(values), np.array(errors), row.get("hex") if key == "natural_light" else None,
                  coverage_factor, None, row["thickness_um"])


class Sweep(Table, _Folder):
    """A finished sweep: one row for each variant, named as its folder, with its axes, colours and errors."""

    def __init__(self, folder: Path):
        self.folder = pathlib.Path(folder)
        outline = json.loads((self.folder / "sweep.json").read_text(encoding="utf-8"))
        self.axes = [axis["name"] for axis in outline["axes"]]
        table = read_table(self.folder / "sweep.csv", index=self.axes)
        table._columns["variant"] = np.array([str(name) for name in table["variant"]])
        factors = [self._factor(name) for name in table["variant"]]
        columns = {**table, "coverage_factor_95": np.array(factors, float)}
        same = factors[0] if factors and len(set(factors)) == 1 else None
        super().__init__(columns, index=self.axes, units=table.units, coverage_factor=same, title=str(outline["title"]), descriptions={
            **table.descriptions, "coverage_factor_95": "factor that makes half of a 95 % interval of a standard error"})

    def _told(self) -> List[str]:
        """Axes and colours first: what a sweep is made for, before the account of its work."""
        first = [name for name in (*self.axes, "L", "a", "b", "variant") if name in self]
        return first + [name for name in self if name not in first]

    def _factor(self, name: str) -> Optional[float]:
        path = self.folder / "variants" / name / "results.json"
        found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        factor: Optional[float] = found.get("certainty", {}).get("coverage_factor_95")
        return factor

    @property
    def variants(self) -> List[str]:
        """Names of the variants, which are those of their folders."""
        return [str(name) for name in self["variant"]]

    def study(self, variant: str) -> Ink:
        """The results of a variant."""
        if variant not in self.variants:
            raise KeyError(f"no variant {variant!r}; there are {', '.join(self.variants)}")
        return Ink(self.folder / "variants" / variant)

    @functools.cached_property
    def spectra(self) -> Table:
        """The spectra of all variants in one table over the sweep's axes, angle (or thickness) and wavelength."""
        parts = []
        for row in Table(self).rows():
            path = self.folder / "variants" / row["variant"] / "spectra.csv"
            if not path.exists():
                continue
            table = read_table(path, coverage_factor=self.coverage_factor)
            place = {name: np.full(table.n_rows, row[name]) for name in [*self.axes, "variant", "coverage_factor_95"]}
            first = {name: place.pop(name) for name in self.axes}
            parts.append(Table({**first, **table, **place}, index=[*self.axes, *table.index], units={**self.units, **table.units},
                               descriptions={**self.descriptions, **table.descriptions}, title=self.title))
        if not parts:
            return Table({}, title=self.title)
        names = list(dict.fromkeys(name for part in parts for name in part))
        columns = {name: np.concatenate([part.get(name, np.full(part.n_rows, np.nan)) for part in parts]) for name in names}
        return Table(columns, index=parts[0].index, units=parts[0].units, descriptions=parts[0].descriptions,
                     coverage_factor=self.coverage_factor, title=self.title)


class Fit(Table, _Folder):
    """A pigment's index from drawdowns: `n`, `kappa`, their errors and correlation at every wavelength."""

    def __init__(self, folder: Path):
        self.folder = pathlib.Path(folder)
        found = json.loads((self.folder / "fit.json").read_text(encoding="utf-8"))
        self.results: Dict[str, Any] = found
        fit = found["fit"]
        table = read_table(self.folder / "pigment.csv", index=["wavelength_nm"])
        super().__init__(table, index=["wavelength_nm"], units=table.units, descriptions=table.descriptions,
                         coverage_factor=_NORMAL_95, title=str(found["title"]))
        self.remarks: List[str] = list(fit["remarks"])
        self.is_determined = bool(fit["n_is_determined"])
        self.trust: str = fit["trust"]
        self.degrees_of_freedom: float = fit["degrees_of_freedom"]
        second = self.folder / "pigment-other.csv"
        self.other: Optional[Table] = None
        if fit["other_solution"] is not None:
            self.other = read_table(second, index=["wavelength_nm"], coverage_factor=_NORMAL_95, title="second solution")

    @property
    def pigment_index(self) -> Dict[str, str]:
        """The index for `Pigment(index=…)` and any study."""
        return {"csv": str((self.folder / "pigment.csv").resolve())}

    def plot(self, *names: str, x: Optional[str] = None, ax: Any = None) -> Any:
        """n and κ with 95 % bands, and the other solution where there is one; both axes."""
        axes = np.atleast_1d(ax) if ax is not None else _needed("matplotlib.pyplot").subplots(1, 2, figsize=(10, 4))[1]
        for panel, name in zip(axes, names or ("n", "kappa")):
            for table, label in ((self, "fitted"), (self.other, "second solution")):
                if table is not None:
                    low, high = table.interval(name)
                    panel.plot(table["wavelength_nm"], table[name], label=label)
                    panel.fill_between(table["wavelength_nm"], low, high, alpha=0.3)
            panel.set_xlabel("wavelength_nm [nm]")
            panel.set_title(name)
            panel.legend()
        return axes

    def __repr__(self) -> str:
        told = "n is determined" if self.is_determined else "n is NOT determined"
        return "\n".join([f"{self.title}: {told}, {self.trust}", *super().__repr__().splitlines()[1:8], f"  {self.folder}"])


_NORMAL_95 = 1.96


class Design(Dict[str, Any], _Folder):
    """Recipes for a target colour: what `design.json` says under `design`, and the folder with the page and the best recipe."""

    def __init__(self, folder: Path):
        self.folder = pathlib.Path(folder)
        found = json.loads((self.folder / "design.json").read_text(encoding="utf-8"))
        super().__init__(found["design"])
        self.title, self.variables = str(found["title"]), list(found["variables"])

    @property
    def verified(self) -> List[Dict[str, Any]]:
        """Recipes that were run, the best first."""
        return list(self["verified"])

    @property
    def recipes(self) -> Table:
        """The verified recipes as a table: a column for each variable, ΔE₀₀ with its error, contrast ratio, wanted numbers, cost, colour."""
        runs = self.verified
        columns: Dict[str, Any] = {name: [run["values"][i] for run in runs] for i, name in enumerate(self.variables)}
        for name in ("delta_e_2000", "contrast_ratio"):
            found = [run.get(name) for run in runs]
            if runs and all(part is None for part in found):
                continue  # no colour is wanted
            columns[name] = [part["value"] if isinstance(part, Mapping) else part for part in found]
            if any(isinstance(part, Mapping) for part in found):
                columns[name + "_standard_error"] = [part["standard_error"] for part in found if part is not None]
        for place, wish in enumerate(self.get("wishes", [])):
            reached = [run["numbers"][place] for run in runs]
            columns[wish["name"]] = [number["value"] for number in reached]
            columns[wish["name"] + "_standard_error"] = [number["standard_error"] for number in reached]
        columns.update({name: [run.get(name) for run in runs] for name in ("cost", "hex")})
        return Table({name: np.array(column) for name, column in columns.items()}, title=self.title)

    def __repr__(self) -> str:
        """At most ten lines."""
        return "\n".join([f"{self.title}: {self['verdict']}"[:200], *repr(self.recipes).splitlines()[1:8], f"  {self.folder}"])


def export(folder: Path, *formats: str, output: Optional[Path] = None) -> pathlib.Path:
    """Writes files for other programs, as `inkwave export` does: `export(folder, "mitsuba", "cxf")`; their folder."""
    folder = os.fspath(folder)
    call("export", folder, "--to", ",".join(formats), *([] if output is None else ["--output", os.fspath(output)]))
    return pathlib.Path(output or pathlib.Path(folder) / "export")


def read(folder: Path) -> Any:
    """Reads a folder of results without solving anything: an `Ink`, or a `Sweep`, `Fit` or `Design`, as the folder holds."""
    place = pathlib.Path(folder)
    kinds = {"results.json": Ink, "sweep.json": Sweep, "fit.json": Fit, "design.json": Design}
    for name, kind in kinds.items():
        if (place / name).exists():
            return kind(place)
    raise FileNotFoundError(f"{os.fspath(folder)} holds no results: give the folder that run, sweep, fit or design wrote "
                            f"({', '.join(kinds)})" if place.is_dir() else f"{os.fspath(folder)} is no folder")
