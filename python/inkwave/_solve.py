"""One explicit geometry, or a scan of wavelengths and angles over it."""

from __future__ import annotations

import difflib
import itertools
import json
import os
import pathlib
import tempfile
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np

from ._files import Layer, Path, input_file, plain
from ._program import InputError, call
from ._tables import Table

__all__ = ["Scan", "solve"]

# Words of studies for keys of a case.
WORDS = {"period_um": "L", "thickness_um": "H", "binder": "eta_binder", "index_in": "n_in", "index_out": "n_out",
         "polar_deg": "sigma_deg", "azimuth_deg": "phi_deg", "center_um": "center", "radius_um": "radius", "index": "eta"}
_WAVELENGTHS = ("wavelength", "wavelength_nm", "wavelength_um")
_ANGLES = ("sigma_deg", "phi_deg")
_KEYS = {"wavelength", "wavelength_nm", "wavelength_um", "sigma_deg", "phi_deg", "from", "directions", "L", "Ly", "H", "n_in", "n_out", "eta_in",
         "eta_out", "eta_binder", "note", "spheres", "cylinders", "bodies", "layers_from_z0", "sublayers_from_z0", *WORDS}
# Options of the command line.
_FLAGS = ("accuracy", "solver", "nxy", "nz", "tolerance", "wave", "scheme", "constant_mean", "real_mean", "memory_gb", "export_operator", "gradient",
          "realisation", "wavelength_nm", "polar_deg", "snap", "illuminated_um", "illuminated_step_deg")
_WAVES = {"scalar": "scalar", "vector": "vector", "s": "vector", "p": "vector", "unpolarised": "vector"}


class Scan(Table):
    """Totals of several solves, one row each; `solves` holds the whole answers."""

    solves: List[Dict[str, Any]]


def solve(case: Union[Mapping[str, Any], Path, Layer, None] = None, accuracy: Optional[float] = None, *, wave: Optional[str] = None,
          **options: Any) -> Any:
    """One solve of an explicit geometry: totals, error estimate, and the orders as arrays; or a scan of several.

    `case` is a dictionary as in `inkwave solve CASE.json` (lengths in µm, angles in degrees), or the path of such a file; its keys may
    be words here, too. Of a study (a `Layer` or its dictionary) one packing is solved, `realisation=1` unless another is given, at its first
    wavelength and angle unless `wavelength_nm` and `polar_deg` are given. Indices are numbers, complex numbers or [re, im]; arrays are NumPy's or lists. A list of wavelengths or
    angles, or of `directions` (dictionaries with `polar_deg`, `azimuth_deg` and `from`), gives a `Scan`; the directions of a wavelength are
    solved on one grid, at a fraction of the cost of single solves. `wave` is "scalar", "vector", "s", "p" or "unpolarised", as in studies: with "vector" amplitudes are
    `far["orders"]["R"]["s"]["p"]` and so on, with "s" or "p" those of that incident light, and "unpolarised" takes the mean of the
    totals. Further options are those of the command line: `solver="born"`, `nxy=20, nz=12` instead of an accuracy,
    `illuminated_um=10` for the light per steradian of a lit square (`far["finite_area"]`), `snap=True` for a direction of the
    lattice (`far["snapped"]`); False leaves an option out.

    >>> far = solve(wavelength_nm=500, thickness_um=0.3, binder=1.5)
    >>> abs(far["R_total"] + far["T_total"] + far["A_total"] - 1) < 1e-6
    True
    >>> scan = solve(wavelength_nm=np.arange(400, 701, 100), thickness_um=np.float64(0.3), binder=1.5 + 0.1j)
    >>> scan["wavelength_nm"].tolist(), bool((scan["A_total"] > 0.1).all())
    ([400, 500, 600, 700], True)
    """
    inputs, flags = _separated(options)
    if isinstance(case, Layer) or case is not None and "realisation" in flags or isinstance(case, Mapping) and {"layer", "pigment"} & set(case):
        light: Dict[str, Any] = {name: inputs.pop(name) for name in ("wavelength_nm", "polar_deg") if name in inputs}
        if inputs:
            raise TypeError(f"{', '.join(inputs)}: keys of a case beside a study; change the study, for example by `with_`")
        with input_file(case, {}, "study") as path:
            return _solved(path, accuracy, wave, {"realisation": 1, **light, **flags})
    if isinstance(case, Mapping):
        inputs = {**case, **inputs}
    elif case is not None:
        if inputs:
            raise TypeError(f"{', '.join(inputs)}: keys of a case beside a file; write them into {os.fspath(case)}, or give a dictionary")
        return _solved(case, accuracy, wave, flags)
    inputs = _translated(plain(inputs))
    colours = {name: inputs[name] for name in _WAVELENGTHS if isinstance(inputs.get(name), list)}
    angles = {name: inputs.pop(name) for name in _ANGLES if isinstance(inputs.get(name), list)}
    if angles and "directions" in inputs:
        raise TypeError(f"{', '.join(angles)}: a list of angles beside directions; give one of them")
    if angles:
        inputs["directions"] = [dict(zip(angles, values)) for values in itertools.product(*angles.values())]
    directions = inputs.get("directions")
    if not colours and directions is None:
        return _solved(inputs, accuracy, wave, flags)
    seen = list(angles) or [name for name in (*_ANGLES, "from") if any(name in one for one in directions or [])]
    usual = {"sigma_deg": 0.0, "phi_deg": 0.0, "from": "incident", **inputs}
    solves, rows = [], []
    for values in itertools.product(*colours.values()):
        place = dict(zip(colours, values))
        found = _solved({**inputs, **place}, accuracy, wave, flags)
        for direction, far in zip(directions or [{}], found if isinstance(found, list) else [found]):
            solves.append(far)
            place.update({name: direction.get(name, usual[name]) for name in seen})
            totals = {name: far.get(name) for name in ("R_total", "T_total", "A_total", "error_estimate")}
            rows.append({**{_OUTWARD.get(name, name): value for name, value in place.items()}, **_flat(totals)})
    index = [_OUTWARD.get(name, name) for name in (*colours, *seen)]
    units = {str(name): "nm" if name.endswith("_nm") else "°" if name.endswith("_deg") else "µm" for name in index}
    scan = Scan({name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}, index=index, units=units)
    scan.solves = solves
    return scan


_OUTWARD = {"sigma_deg": "polar_deg", "phi_deg": "azimuth_deg", "wavelength": "wavelength_um"}


def _flat(totals: Mapping[str, Any]) -> Dict[str, Any]:
    """Totals by polarisation as columns `R_total_s`, `R_total_p`, …"""
    found = {}
    for name, value in totals.items():
        found.update({f"{name}_{part}": v for part, v in value.items()} if isinstance(value, Mapping) else {name: value})
    return found


def _separated(options: Mapping[str, Any]) -> Tuple[Dict[str, Any], Dict[str, Any]]:
    """Keys of a case, and options of the command line."""
    inputs = {name: value for name, value in options.items() if name.rstrip("_") in _KEYS}
    flags = {name: value for name, value in options.items() if name not in inputs}
    for name in flags:
        if name not in _FLAGS:
            near = difflib.get_close_matches(name, [*WORDS, *sorted(_KEYS), *_FLAGS], 1)
            hint = f"did you mean {near[0]}?" if near else "grains and films are keys of a case: `inkwave schema case --annotated`"
            raise InputError(f"{name}: found an unknown key; allowed: {', '.join(sorted(_KEYS))}, and the options {', '.join(_FLAGS)}"
                             f"\n  help: {hint}")
    return {name.rstrip("_"): value for name, value in inputs.items()}, flags


def _translated(case: Any) -> Any:
    """Words of studies as the keys of a case, and real indices as [n, 0], at every depth."""
    if not isinstance(case, dict):
        return [_translated(part) for part in case] if isinstance(case, list) else case
    if "kind" in case:  # a shape, whose words are its own
        return case
    found: Dict[str, Any] = {str(WORDS.get(name, name)): _translated(value) for name, value in case.items()}
    return {name: [float(value), 0.0] if name.startswith("eta") and isinstance(value, (int, float)) else value
            for name, value in found.items()}


def _solved(case: Union[Mapping[str, Any], Path], accuracy: Optional[float], wave: Optional[str], flags: Mapping[str, Any]) -> Any:
    """One answer, or those of a list of directions."""
    arguments: List[object] = [] if accuracy is None else ["--accuracy", accuracy]
    if wave is not None and wave not in _WAVES:
        raise InputError(f"wave: found {wave!r}; allowed: {', '.join(_WAVES)}\n  help: scalar is the default; unpolarised is the mean of s and p")
    if wave is not None:
        arguments += ["--wave", _WAVES[wave]]
    for name, value in flags.items():
        if value is None or value is False:
            continue
        arguments += ["--" + name.replace("_", "-")] + ([] if value is True else [plain(value)])
    with tempfile.TemporaryDirectory(prefix="inkwave-") as scratch:
        path: Path = pathlib.Path(scratch) / "case.json"
        if isinstance(case, Mapping):
            pathlib.Path(path).write_text(json.dumps(case), encoding="utf-8")
        else:
            path = case
        found: Dict[str, Any] = json.loads(call("solve", path, *arguments, show=False))
    answers = found.get("solves", [found])
    for one in answers:
        one["orders"] = columns(one["orders"])
        if wave in ("s", "p", "unpolarised"):
            polarised(one, wave)
    return answers if "solves" in found else found


def polarised(found: Dict[str, Any], wave: str) -> Dict[str, Any]:
    """The answer of the vector wave for one incident polarisation, or the mean totals of both."""
    found["wave"] = wave
    for name, value in found.items():
        if isinstance(value, dict) and {"s", "p"} <= set(value):
            found[name] = value.get(wave, 0.5 * (value["s"] + value["p"]))
    for name, value in found["orders"].items():
        if isinstance(value, dict):
            mean = not isinstance(value["s"], dict)
            found["orders"][name] = value[wave] if wave in value else 0.5 * (value["s"] + value["p"]) if mean else value
    return found


def columns(rows: List[Dict[str, Any]]) -> Dict[str, Any]:
    """A list of objects as arrays; pairs [re, im] become complex numbers, objects inside dictionaries of arrays."""
    def column(name: str) -> Any:
        values = [row[name] for row in rows]
        if values and isinstance(values[0], dict):
            return columns(values)
        pairs = values and isinstance(values[0], list) and len(values[0]) == 2
        return np.array([complex(*v) for v in values]) if pairs and name != "direction" else np.array(values)

    return {name: column(name) for name in (rows[0] if rows else {})}
