"""Comparisons, and strategies of one's own in Python as rows of them."""

from __future__ import annotations

import builtins
import importlib
import inspect
import json
import os
import pathlib
import pickle
import sys
import tempfile
import textwrap
import types
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Set, Union

from ._files import Layer, Path, Study, input_file, plain, table_of
from ._program import InkwaveError, call
from ._solve import _translated
from ._tables import Table, read_table

__all__ = ["compare", "conforms"]

Solver = Callable[[Any], Mapping[Any, Any]]
_INDEX = ("case", "strategy", "knob", "mean", "scheme", "nx", "ny", "cells")
_CASE_KEYS = ("wavelength", "wavelength_nm", "wavelength_um")
# Keys of a comparison that are not those of a study.
_OWN_KEYS = ("strategies", "schemes", "resolutions", "cases", "case", "external", "matrix", "goal")


def compare(study: Study, output: Path = "out/comparison", *, against: Union[Solver, Mapping[str, Solver], None] = None,
            knob: Sequence[float] = (), progress: Optional[bool] = None, **settings: Any) -> Table:
    """Compares strategies and programs; the columns of `comparison.csv`, one row for each solve.

    `study` is a comparison, a study or a case, each a path, a dictionary or a `Layer`. `against` is a function of your own, or several
    by name: it takes a case and returns `{(m, n): (r, t)}`, the amplitudes of the orders that propagate, None where one does not;
    for Maxwell's equations r and t are 2 × 2, by incident, then outgoing polarisation (s, p). The case has `inputs`, `wave`, `k0`, `n`, `films`,
    `spheres`, `orders()` and `permittivity(x, y, z)` (`inkwave.adapter.Case`); raise `inkwave.adapter.Refusal` for what it cannot solve.
    `knob` are values of its own setting of accuracy, `case.knob`. Settings are keys of a comparison, such as `strategies` or `wave`.

    The function runs in a process of its own, so that time and memory are its own.

    >>> def film(case):
    ...     (h, eta, bars), n = case.films[0], 1.0
    ...     r, phase = (n - eta) / (n + eta), np.exp(1j * case.k0 * eta * h)
    ...     below = 1 - r**2 * phase**2
    ...     return {(0, 0): (r * (1 - phase**2) / below, (1 - r**2) * phase / below)}
    >>> case = {"wavelength": 0.5, "H": 0.3, "eta_binder": 1.5}
    >>> table = compare(case, "compared", against=film, strategies=["krylov"], schemes=["cubic"])
    >>> rows = table.where(strategy="film")
    >>> rows["outcome"].tolist(), bool(rows["error"][0] < 1e-6)
    (['converged'], True)
    """
    solvers: Mapping[str, Solver] = {} if against is None else dict(against) if isinstance(against, Mapping) \
        else {getattr(against, "__name__", "own"): against}
    if not isinstance(study, (Mapping, Layer)) and not solvers and not settings:
        call("compare", study, "--output", output, show=progress)
        return _table(output)
    with tempfile.TemporaryDirectory(prefix="inkwave-") as scratch:
        table = comparison_table(study, settings, pathlib.Path(scratch))
        rows = [row_of(name, solver, pathlib.Path(scratch), knob) for name, solver in solvers.items()]
        table["external"] = [*table.get("external", []), *rows]
        if not table["external"]:
            del table["external"]
        with input_file(table, {}, "comparison") as path:
            call("compare", path, "--output", output, show=progress)
    return _table(output)


def _table(folder: Path) -> Table:
    return read_table(pathlib.Path(folder) / "comparison.csv", index=_INDEX, title="comparison")


def comparison_table(study: Study, settings: Mapping[str, Any], scratch: pathlib.Path) -> Dict[str, Any]:
    """A comparison as a dictionary, from one, or from a study or a case."""
    own = {name: value for name, value in settings.items()}
    if isinstance(study, Layer):
        return {"study": study.study(), **own}
    if not isinstance(study, Mapping):
        path = pathlib.Path(study)
        if path.suffix == ".json":
            return {"case": str(path.resolve()), **own}
        found = table_of(study, {})
        if any(key in found for key in _OWN_KEYS) or "study" in found:
            return {**found, **own}
        study = found
    if any(key in study for key in _CASE_KEYS):
        path = scratch / "case.json"
        path.write_text(json.dumps(_translated(plain(study))), encoding="utf-8")
        return {"case": str(path), **own}
    if any(key in study for key in _OWN_KEYS) or "study" in study:
        return {**study, **own}
    return {"study": dict(study), **own}


def row_of(name: str, solver: Solver, scratch: pathlib.Path, knob: Sequence[float]) -> Dict[str, Any]:
    """An `[[external]]` table that runs the function in a process of its own."""
    path = scratch / f"solver_{len(list(scratch.glob('solver_*')))}.pickle"
    path.write_bytes(pickle.dumps(_sent(solver)))
    package = str(pathlib.Path(__file__).resolve().parent.parent)
    start = f"import sys; sys.path.insert(0, {package!r}); from inkwave._strategies import answer; answer({str(path)!r}, {name!r})"
    row: Dict[str, Any] = {"name": name, "command": [sys.executable, "-c", start]}
    return {**row, "knob": plain(knob)} if len(knob) else row


def _sent(solver: Solver) -> Dict[str, Any]:
    """How another process finds a function: by its module, by cloudpickle where installed, else by its source."""
    module = sys.modules.get(getattr(solver, "__module__", None) or "")
    named = getattr(solver, "__qualname__", "?")
    if module is not None and module.__name__ != "__main__" and "<" not in named and getattr(module, "__file__", None):
        if getattr(module, named, None) is solver:
            return {"module": module.__name__, "name": named, "path": [place for place in sys.path if place] + [os.getcwd()]}
    try:
        import cloudpickle  # type: ignore[import-not-found,import-untyped,unused-ignore]

        return {"pickled": cloudpickle.dumps(solver)}
    except ImportError:
        return {"sources": _sources(solver), "name": named}


def _sources(function: Any) -> Dict[str, Any]:
    """Source of a function and of what it names: functions, modules, and values that can be pickled."""
    if not isinstance(function, types.FunctionType) or function.__closure__ or "<" in function.__qualname__:
        raise TypeError(f"{function!r} uses variables of the function around it, or is none: define it at the top level of a "
                        "file or a cell, or install cloudpickle")
    found: Dict[str, Any] = {}
    _collect(function, found)
    return found


def _collect(function: types.FunctionType, found: Dict[str, Any]) -> None:
    try:
        source = textwrap.dedent(inspect.getsource(function))
    except (OSError, TypeError):
        raise TypeError(f"the source of {function.__name__} is not known: define it in a file or a cell, or install cloudpickle") from None
    found[function.__name__] = ("source", source)
    for name in sorted(_names(function.__code__)):
        if name in found or name not in function.__globals__ or hasattr(builtins, name):
            continue
        value = function.__globals__[name]
        if isinstance(value, types.ModuleType):
            found[name] = ("module", value.__name__)
        elif isinstance(value, types.FunctionType) and value.__module__ == function.__module__:
            _collect(value, found)
        else:
            try:
                found[name] = ("value", pickle.dumps(value))
            except Exception as reason:
                raise TypeError(f"{function.__name__} uses {name}, which cannot be sent to its process ({reason}): "
                                "install cloudpickle") from None


def _names(code: types.CodeType) -> Set[str]:
    inner = (part for part in code.co_consts if isinstance(part, types.CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _received(path: str) -> Solver:
    """The function, in its own process."""
    sent = pickle.loads(pathlib.Path(path).read_bytes())
    if "module" in sent:
        sys.path[:0] = sent["path"]
        solver: Solver = getattr(importlib.import_module(sent["module"]), sent["name"])
        return solver
    if "pickled" in sent:
        solver = pickle.loads(sent["pickled"])
        return solver
    space: Dict[str, Any] = {"__name__": "__inkwave_solver__"}
    for name, (kind, value) in sent["sources"].items():
        if kind == "module":
            space[name] = importlib.import_module(value)
        elif kind == "value":
            space[name] = pickle.loads(value)
    for name, (kind, value) in sent["sources"].items():
        if kind == "source":
            exec(compile(value, f"<{name}>", "exec"), space)
    solver = space[sent["name"]]
    return solver


def answer(path: str, name: str) -> None:
    """The process of a function: describes itself, or answers the question on standard input."""
    adapter: Any = importlib.import_module("inkwave.adapter")
    solver: Any = None if "--describe" in sys.argv else _received(path)
    adapter.main({"program": f"{name} (Python)", "waves": ["scalar", "vector"]}, lambda case: orders_of(case, solver(case)))


def orders_of(case: Any, found: Mapping[Any, Any]) -> List[Dict[str, Any]]:
    """Orders of the protocol from `{(m, n): (r, t)}`; an order that does not propagate on a side is left out there."""
    pair: Any = importlib.import_module("inkwave.adapter").pair

    def amplitude(value: Any) -> Any:
        if case.wave == "scalar":
            return pair(value)
        return {a: {b: pair(value[i][j]) for j, b in enumerate("sp")} for i, a in enumerate("sp")}

    propagating = {(m, n): kz for m, n, _, kz in case.orders()}
    orders = []
    for (m, n), sides in found.items():
        normal = propagating.get((m, n), (0j, 0j))
        for side, kz, value in zip(("reflected", "transmitted"), normal, sides):
            if value is not None and kz.real > 0:
                orders.append({"m": int(m), "n": int(n), "side": side, "amplitude": amplitude(value)})
    return orders


def conforms(solver: Solver, knob: Optional[float] = None) -> str:
    """Puts a film, a grating and a sphere whose answers are known to your function; what the program says of it.

    Common mistakes (another time factor, sides exchanged, powers for amplitudes) are named in the error that is raised.
    """
    with tempfile.TemporaryDirectory(prefix="inkwave-") as scratch:
        command = row_of(getattr(solver, "__name__", "own"), solver, pathlib.Path(scratch), ())["command"]
        try:
            return call("compare", *([] if knob is None else ["--knob", knob]), "--check", *command, show=False)
        except InkwaveError as error:  # which of the questions it failed
            raise type(error)(f"{error.printed.strip()}\n{error}".lstrip()) from None
