"""Input of the program from Python: dictionaries, small builders, NumPy's numbers; and the TOML file made of them."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import difflib
import json
import math
import os
import pathlib
import sys
import tempfile
from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Union

import numpy as np

from ._program import InputError

__all__ = ["Layer", "Pigment", "material"]

Path = Union[str, "os.PathLike[str]"]
Index = Union[float, complex, str, Mapping[str, Any]]
Study = Union[Path, Mapping[str, Any], "Layer"]

# Keys whose texts are files, relative to the file that names them; in a dictionary, to the working folder.
_FILES = ("csv", "yaml", "m1_csv", "m2_csv", "donaldson_csv", "results", "spheres", "voxels", "file", "measured", "base", "study",
          "case", "command")


def material(name: str) -> Dict[str, str]:
    """A measured material that comes with the program, for `index=`; `inkwave materials` lists them.

    >>> material("TiO2 rutile")
    {'material': 'TiO2 rutile'}
    """
    return {"material": name}


def index(value: Index) -> Any:
    """A refractive index as study files write it: a number, n + iκ, the name of a built-in pigment, a table or `material`.

    >>> index(1.4 + 0.1j)
    {'n': 1.4, 'k': 0.1}
    >>> index("yellow")
    {'built_in': 'yellow'}
    >>> index("measured.csv")
    {'csv': 'measured.csv'}
    """
    if isinstance(value, str):
        for kind in ("csv", "yaml"):
            if value.lower().endswith("." + kind):
                return {kind: value}
        return {"built_in": value}
    if isinstance(value, Mapping):
        return dict(value)
    number = complex(value)
    return {"n": number.real, "k": number.imag} if number.imag else number.real


@dataclass(frozen=True)
class Pigment:
    """A kind of grains: diameter in nm, share of the layer's volume, index; other keys of `[[pigment]]` as `more`.

    >>> Pigment(d_nm=250, share=0.30, index="yellow").table()["volume_fraction"]
    0.3
    """

    d_nm: Union[float, str, None] = None
    share: Optional[float] = None
    index: Optional[Index] = None
    name: Optional[str] = None
    shape: Any = None
    more: Mapping[str, Any] = field(default_factory=dict)

    def table(self) -> Dict[str, Any]:
        """The pigment as a table of a study file."""
        parts = {"name": self.name, "shape": self.shape, "diameter_nm": self.d_nm, "volume_fraction": self.share,
                 "share": None if self.share is None else "scale_sizes",
                 "index": None if self.index is None else index(self.index)}
        return {**{key: value for key, value in parts.items() if value is not None}, **self.more}


@dataclass(frozen=True)
class Layer:
    """An ink or paint layer: thickness in µm (a list for a composed layer), index of the binder, pigments.

    >>> ink = Layer(1.0, binder=1.558, pigments=[Pigment(d_nm=250, share=0.30, index="yellow")])
    >>> ink.study(paper=0.9, delta_e=0.5)["run"]
    {'target_delta_e': 0.5}
    >>> ink.with_(thickness_um=2.0).study()["layer"]["thickness_um"]
    2.0
    """

    thickness_um: Union[float, Sequence[float], Mapping[str, float]]
    binder: Index = 1.558
    pigments: Sequence[Pigment] = ()
    title: Optional[str] = None
    more: Mapping[str, Any] = field(default_factory=dict)

    def with_(self, **changes: Any) -> "Layer":
        """A layer that differs in some of its parts."""
        return dataclasses.replace(self, **changes)

    def study(self, **settings: Any) -> Dict[str, Any]:
        """The study as a dictionary, with settings such as `paper`, `delta_e`, `accuracy` (see `run`)."""
        layer: Dict[str, Any] = {"thickness_um": self.thickness_um, "binder": {"index": index(self.binder)}}
        if isinstance(self.thickness_um, (list, tuple, np.ndarray)):
            layer["composed"] = {}
        found: Dict[str, Any] = {} if self.title is None else {"title": self.title}
        found.update({"layer": {**layer, **self.more}, "pigment": [pigment.table() for pigment in self.pigments]})
        return with_settings(found, settings)


# Tables and lists of a study file.
_TABLES = ("title", "layer", "stack", "pigment", "packing", "paper", "dots", "area", "ink", "light", "angles", "run", "resolution", "solver",
           "output", "colour", "compare", "number")
# Short words for keys of a study.
_SETTINGS = {
    "paper": ("paper", "albedo"), "delta_e": ("run", "target_delta_e"), "realisations": ("run", "realisations"),
    "seed": ("run", "seed"), "accuracy": ("resolution", "accuracy"), "wavelength_nm": ("light", "wavelengths_nm"),
    "wave": ("light", "wave"), "polar_deg": ("angles", "polar_deg"), "thickness_um": ("layer", "thickness_um"),
    "period_um": ("layer", "period_um"),
}


def with_settings(study: Dict[str, Any], settings: Mapping[str, Any]) -> Dict[str, Any]:
    """A copy of a study with settings: short words, or whole tables, which are merged; the program judges the rest.

    >>> with_settings({"run": {"seed": 1}}, {"run": {"realisations": 4}, "accuracy": 1e-2})
    {'run': {'seed': 1, 'realisations': 4}, 'resolution': {'accuracy': 0.01}}
    """
    study = copy.deepcopy(study)
    for name, value in settings.items():
        if name not in _SETTINGS and name not in _TABLES and name not in study:
            near = difflib.get_close_matches(name, [*_SETTINGS, *_TABLES], 1)
            hint = f"did you mean {near[0]}?" if near else "other keys stand in their tables, such as angles={\"count\": 3}"
            raise InputError(f"{name}: found an unknown key; allowed: {', '.join(_SETTINGS)}, and the tables "
                             f"{', '.join(_TABLES)}\n  help: {hint}")
        if name in _SETTINGS and not isinstance(value, Mapping):
            table, key = _SETTINGS[name]
            if isinstance(study.get(table), list):  # a stack has a list of layers, and one cell
                if name != "period_um":
                    raise InputError(f"{name}: found a study of several layers; allowed is a study of one: give layer=[…], or change "
                                     f"study[{table!r}][…][{key!r}]")
                table = "stack"
            study.setdefault(table, {})
            study[table][key] = [value] if name in ("wavelength_nm", "polar_deg") and np.ndim(value) == 0 else value
        elif isinstance(value, Mapping):
            if isinstance(study.get(name), list):
                raise InputError(f"{name}: found a table for a list of {len(study[name])}; allowed is a list: give {name}=[…]")
            study[name] = {**study.get(name, {}), **value}
        else:
            study[name] = value
    return study


def plain(value: Any) -> Any:
    """What JSON and TOML can write: NumPy's arrays and scalars, paths and complex numbers ([re, im]) as lists and numbers."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return plain(value.table() if isinstance(value, Pigment) else value.study() if isinstance(value, Layer)
                     else dataclasses.asdict(value))
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items() if part is not None}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, range)):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def _indices(value: Any, key: str = "") -> Any:
    """Complex numbers under `index` as tables { n, k }, as studies write them."""
    if isinstance(value, Mapping):
        return {name: _indices(part, name) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_indices(part, key) for part in value]
    if isinstance(value, (complex, np.complexfloating)) and key in ("index", "ordinary", "extraordinary"):
        return index(complex(value))
    return value


def _absolute(value: Any, key: str = "") -> Any:
    """Names of files made absolute: the program takes them relative to its own file, which is a temporary one."""
    if isinstance(value, dict):
        return {name: _absolute(part, name) for name, part in value.items()}
    if isinstance(value, list):
        return [_absolute(part, key) for part in value]
    if isinstance(value, str) and key in _FILES and os.path.exists(value):
        return os.path.abspath(value)
    return value


def written(table: Mapping[str, Any]) -> str:
    """The text of a file that the program reads, of a study, sweep, fit or design as a dictionary."""
    return toml(_absolute(plain(_indices(table))))


def toml(table: Mapping[str, Any]) -> str:
    r"""A table as TOML, two levels of it with headings.

    >>> print(toml({"title": "Ink", "layer": {"thickness_um": 1.0}, "pigment": [{"diameter_nm": 250}]}), end="")
    title = "Ink"
    <BLANKLINE>
    [layer]
    thickness_um = 1.0
    <BLANKLINE>
    [[pigment]]
    diameter_nm = 250
    """
    return "\n".join(_tables(table, (), 2)).lstrip("\n") + "\n"


def _tables(table: Mapping[str, Any], path: Sequence[str], depth: int) -> List[str]:
    lines: List[str] = []
    later: List[str] = []
    for key, value in table.items():
        heading = ".".join(_key(part) for part in (*path, key))
        if depth and isinstance(value, Mapping):
            later += ["", f"[{heading}]", *_tables(value, (*path, key), depth - 1)]
        elif depth and isinstance(value, list) and value and all(isinstance(part, Mapping) for part in value):
            for part in value:
                later += ["", f"[[{heading}]]", *_tables(part, (*path, key), 0)]
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    return lines + later


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise TypeError(f"{value!r} cannot be written to a file of inkwave: numbers, texts, lists and dictionaries can")


def read_toml(path: Path) -> Dict[str, Any]:
    """A TOML file as a dictionary, with its files' names made absolute."""
    try:
        import tomllib  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        try:
            import tomli as tomllib  # type: ignore[import-not-found,no-redef,unused-ignore]
        except ImportError:
            raise TypeError(f"to change settings of {os.fspath(path)}, Python 3.11 or tomli is needed: "
                            "write the settings into the file, or give a dictionary") from None
    table = tomllib.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    folder = pathlib.Path(path).resolve().parent

    def found(value: Any, key: str = "") -> Any:
        if isinstance(value, dict):
            return {name: found(part, name) for name, part in value.items()}
        if isinstance(value, list):
            return [found(part, key) for part in value]
        return str(folder / value) if isinstance(value, str) and key in _FILES and (folder / value).exists() else value

    changed: Dict[str, Any] = found(table)
    return changed


def table_of(study: Study, settings: Mapping[str, Any]) -> Dict[str, Any]:
    """A study with settings as a dictionary, from any of its forms."""
    if isinstance(study, Layer):
        return study.study(**settings)
    if isinstance(study, Mapping):
        return with_settings(dict(study), settings)
    return with_settings(read_toml(study), settings)


@contextlib.contextmanager
def input_file(study: Study, settings: Mapping[str, Any], name: str) -> Iterator[pathlib.Path]:
    """Path of the file that the program reads: the user's own, or a temporary one made of a dictionary or a builder."""
    if not isinstance(study, (Mapping, Layer)) and not settings:
        yield pathlib.Path(study)
        return
    text = written(table_of(study, settings))
    with tempfile.TemporaryDirectory(prefix="inkwave-") as scratch:
        path = pathlib.Path(scratch) / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        yield path


if sys.version_info < (3, 9):  # pragma: no cover
    raise ImportError("inkwave needs Python 3.9 or newer")
