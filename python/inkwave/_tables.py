"""Tables with names, units and errors, and single values with theirs; pandas, xarray and matplotlib where installed."""

from __future__ import annotations

import csv
import html
import json
import pathlib
import re
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from ._files import Path

__all__ = ["Table", "Value"]

_ERROR = "_standard_error"
_INTEGER = re.compile(r"[+-]?\d+\Z")


class Value(float):
    """A number with its standard error, its unit and the factor that makes a 95 % interval of the error.

    >>> hiding = Value(12.5, 0.25, unit="µm", coverage_factor=2.2)
    >>> hiding, hiding.error, round(hiding.interval[0], 2)
    (12.50 ± 0.25 µm, 0.25, 11.95)
    >>> hiding * 2
    25.0
    """

    error: Optional[float]
    unit: str
    coverage_factor: Optional[float]

    def __new__(cls, value: float, error: Optional[float] = None, unit: str = "",
                coverage_factor: Optional[float] = None) -> "Value":
        found = super().__new__(cls, value)
        found.error, found.unit, found.coverage_factor = error, unit, coverage_factor
        return found

    def __getnewargs__(self) -> Tuple[Any, ...]:
        return float(self), self.error, self.unit, self.coverage_factor

    @property
    def interval(self) -> Tuple[float, float]:
        """Ends of the 95 % interval; not a number where the error or the coverage factor is unknown."""
        half = np.nan if self.error is None or self.coverage_factor is None else self.error * self.coverage_factor
        return float(self) - half, float(self) + half

    def __repr__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if not self.error:
            return f"{float(self):.6g}{unit}"
        digits = max(0, 1 - int(np.floor(np.log10(self.error))))
        return f"{float(self):.{digits}f} ± {self.error:.{digits}f}{unit}"

    __str__ = __repr__


class Table(Mapping[str, np.ndarray]):
    """Columns of equal length by name, as arrays, with units and descriptions.

    The standard error of a column `x` is the column `x_standard_error`; `coverage_factor` times it is half of the 95 % interval.
    `index` names the columns that tell rows apart, which become the axes of `to_xarray`.

    >>> table = Table({"wavelength_nm": [450, 550], "R": [0.125, 0.25], "R_standard_error": [0.25, 0.5]}, index=["wavelength_nm"],
    ...               units={"wavelength_nm": "nm"}, coverage_factor=2.0)
    >>> table["R"].tolist(), table.error("R").tolist(), table.interval("R")[1].tolist()
    ([0.125, 0.25], [0.25, 0.5], [0.625, 1.25])
    >>> table.rows()[0]["wavelength_nm"]
    450
    >>> print(table)
    2 rows, 95 % intervals are ± 2 standard errors
    wavelength_nm [nm]      R  R_standard_error
                   450  0.125              0.25
                   550   0.25               0.5
    """

    def __init__(self, columns: Mapping[str, Any], *, index: Sequence[str] = (), units: Optional[Mapping[str, str]] = None,
                 descriptions: Optional[Mapping[str, str]] = None, coverage_factor: Optional[float] = None, title: str = ""):
        self._columns = {name: np.asarray(column) for name, column in columns.items()}
        self.index = [name for name in index if name in self._columns]
        self.units: Dict[str, str] = dict(units or {})
        self.descriptions: Dict[str, str] = dict(descriptions or {})
        self.coverage_factor, self.title = coverage_factor, title

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"no column {name!r}; there are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __or__(self, other: Mapping[str, Any]) -> Dict[str, Any]:
        return {**self._columns, **other}

    @property
    def n_rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()))) if self._columns else 0

    def error(self, name: str) -> np.ndarray:
        """Standard errors of a column; not a number where there are none."""
        found = self._columns.get(name + _ERROR, self._columns.get(name + "_error"))
        return np.full(self.n_rows, np.nan) if found is None else found

    def interval(self, name: str) -> Tuple[np.ndarray, np.ndarray]:
        """Ends of the 95 % intervals of a column."""
        half = self.error(name) * (np.nan if self.coverage_factor is None else self.coverage_factor)
        return self[name] - half, self[name] + half

    def rows(self) -> List[Dict[str, Any]]:
        """The rows, each a dictionary of Python's own numbers and texts."""
        lists = {name: column.tolist() for name, column in self._columns.items()}
        return [{name: column[i] for name, column in lists.items()} for i in range(self.n_rows)]

    def where(self, **values: Any) -> "Table":
        """The rows with these values, for example `where(polar_deg=0)`."""
        keep = np.ones(self.n_rows, bool)
        for name, value in values.items():
            keep &= self[name] == value
        return self._like({name: column[keep] for name, column in self._columns.items()})

    def _like(self, columns: Mapping[str, Any]) -> "Table":
        return Table(columns, index=self.index, units=self.units, descriptions=self.descriptions,
                     coverage_factor=self.coverage_factor, title=self.title)

    def to_pandas(self) -> Any:
        """A pandas DataFrame; units, descriptions and the coverage factor are in its `attrs`."""
        pandas = _needed("pandas")
        frame = pandas.DataFrame({name: list(column) if column.ndim > 1 else column for name, column in self._columns.items()})
        frame.attrs.update(units=self.units, descriptions=self.descriptions, coverage_factor=self.coverage_factor)
        return frame

    def to_xarray(self) -> Any:
        """An xarray Dataset over the columns of `index`, with `units`, `long_name` and `coverage_factor_95`.

        Rows that are missing are not a number; without an index, or where it does not tell rows apart, the axis is `row`.
        """
        xarray = _needed("xarray")
        places, coordinates = self._places()
        axes = list(coordinates)
        shape = tuple(len(values) for values in coordinates.values())
        variables = {}
        for name, column in self._columns.items():
            if name in axes or column.ndim > 1:
                continue
            whole = len(column) == np.prod(shape)
            if whole:
                values = np.empty(shape, column.dtype)
            elif column.dtype.kind in "US":
                values = np.full(shape, None, object)
            else:
                values = np.full(shape, np.nan, np.result_type(column.dtype, float))
            values[places] = column
            variables[name] = (axes, values, self._attributes(name))
        found = {name: (name, values, self._attributes(name, False)) for name, values in coordinates.items()}
        return xarray.Dataset(variables, found, {"title": self.title})

    def _attributes(self, name: str, numbers: bool = True) -> Dict[str, Any]:
        said: Dict[str, Any] = {"long_name": self.descriptions.get(name, name.replace("_", " ")), "units": self.units.get(name, "")}
        if numbers and name.endswith("_error") and self.coverage_factor is not None:
            said["coverage_factor_95"] = self.coverage_factor
        return {key: value for key, value in said.items() if value != ""}

    def _places(self) -> Tuple[Tuple[np.ndarray, ...], Dict[str, np.ndarray]]:
        """Place of every row in an array over the axes, and the axes."""
        coordinates: Dict[str, np.ndarray] = {}
        places = []
        for name in self.index:
            values, first, place = np.unique(self[name], return_index=True, return_inverse=True)
            if values.dtype.kind in "US":  # texts keep the order of the table
                order = np.argsort(first)
                values, place = values[order], np.argsort(order)[place]
            coordinates[name] = values
            places.append(place.reshape(-1))
        if not places or len(set(zip(*(place.tolist() for place in places)))) < self.n_rows:
            return (np.arange(self.n_rows),), {"row": np.arange(self.n_rows)}
        return tuple(places), coordinates

    def _head(self, name: str) -> str:
        return f"{name} [{self.units[name]}]" if self.units.get(name) else name

    def _cells(self, most_rows: int, most_columns: int) -> Tuple[List[str], List[List[str]]]:
        names = [name for name in self._told() if self._columns[name].ndim == 1][:most_columns]
        cells = [[_cell(self._columns[name][i]) for name in names] for i in range(min(self.n_rows, most_rows))]
        return [self._head(name) for name in names], cells

    def _told(self) -> List[str]:
        """Names of the columns in the order in which they are shown."""
        return list(self._columns)

    def _summary(self) -> str:
        errors = any(name.endswith("_error") for name in self._columns)
        interval = f", 95 % intervals are ± {self.coverage_factor:.3g} standard errors" if errors and self.coverage_factor else ""
        return f"{self.title + ': ' if self.title else ''}{self.n_rows} rows{interval}"

    def __repr__(self) -> str:
        """At most ten lines."""
        heads, cells = self._cells(7, 5)
        widths = [max(len(row[i]) for row in [heads, *cells]) for i in range(len(heads))]
        lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in [heads, *cells]]
        more = len(self._columns) - len(heads)
        rest = [f"… {more} more columns" if more else "", f"{self.n_rows - 7} more rows" if self.n_rows > 7 else ""]
        told = ", ".join(part for part in rest if part)
        return "\n".join([self._summary(), *lines, *([told] if told else [])])

    def _repr_html_(self) -> str:
        heads, cells = self._cells(10, 12)
        head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
        body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in cells)
        return f"<p>{html.escape(self._summary())}</p><table><tr>{head}</tr>{body}</table>"

    def plot(self, *names: str, x: Optional[str] = None, ax: Any = None) -> Any:
        """Columns against `x`, a line for all rows that differ in `x` alone, bars are 95 % intervals; returns matplotlib's axes."""
        ax = ax or _needed("matplotlib.pyplot").subplots()[1]
        x = x or (self.index[-1] if self.index else next(iter(self._columns)))
        shown = names or tuple(name for name in self._columns if name + _ERROR in self._columns)[:1]
        for name in shown:
            for label, part in self._lines(x):
                half = part.error(name) * (self.coverage_factor or 1.0)
                told = ", ".join([name, label] if label and len(shown) > 1 else [label or name])
                ax.errorbar(part[x], part[name], yerr=np.nan_to_num(half), capsize=2, marker="o", markersize=3, label=told)
        ax.set_xlabel(self._head(x))
        if len(shown) == 1:
            ax.set_ylabel(self._head(shown[0]))
        ax.set_title(self.title)
        ax.legend()
        return ax


    def _lines(self, x: str) -> Iterator[Tuple[str, "Table"]]:
        """The rows that differ in `x` alone, and what tells them from the others."""
        others = [name for name in self.index if name != x and len(np.unique(self[name])) > 1]
        for place in dict.fromkeys(zip(*(self[name].tolist() for name in others))) if others else [()]:
            yield ", ".join(f"{self._head(name)} {_cell(value)}" for name, value in zip(others, place)), self.where(**dict(zip(others, place)))


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)


def _needed(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.split(".")[0]
        raise ImportError(f"{package} is not installed: pip install {package}") from None


def column_of(cells: Sequence[str]) -> np.ndarray:
    """Cells of a CSV file: integers, numbers (empty cells not a number) or texts.

    >>> column_of(["1", "2"]), column_of(["1", ""]), column_of(["1e3"]), column_of(["1", "a"])
    (array([1, 2]), array([ 1., nan]), array([1000.]), array(['1', 'a'], dtype='<U1'))
    """
    if cells and all(_INTEGER.match(cell) and len(cell) < 19 for cell in cells):
        return np.array([int(cell) for cell in cells])
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def described(path: Path) -> Tuple[Dict[str, str], Dict[str, str]]:
    """Units and descriptions of a CSV file's columns, from `datapackage.json` beside it."""
    path = pathlib.Path(path)
    package = path.parent / "datapackage.json"
    units: Dict[str, str] = {}
    descriptions: Dict[str, str] = {}
    if package.exists():
        for resource in json.loads(package.read_text(encoding="utf-8"))["resources"]:
            if resource["path"] == path.name:
                for column in resource.get("schema", {}).get("fields", []):
                    descriptions[column["name"]] = column.get("description", "")
                    units[column["name"]] = column.get("unit", "")
    return {name: unit for name, unit in units.items() if unit}, descriptions


# Columns that tell rows apart.
_INDEX = ("thickness_um", "backing", "polar_deg", "wavelength_nm")


def read_table(path: Path, *, index: Sequence[str] = _INDEX, coverage_factor: Optional[float] = None, title: str = "") -> Table:
    """A CSV file of the program; lines that begin with # are comments."""
    with open(path, newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(line for line in file if not line.startswith("#"))
    units, descriptions = described(path)
    units = {**{name: unit for name in names if (unit := _unit_in(name))}, **units}
    columns = {name: column_of([row[i] for row in rows]) for i, name in enumerate(names)}
    return Table(columns, index=index, units=units, descriptions=descriptions, coverage_factor=coverage_factor, title=title)


def _unit_in(name: str) -> str:
    name = name.removesuffix(_ERROR)
    return next((unit for end, unit in (("_nm", "nm"), ("_um", "µm"), ("_deg", "°")) if name.endswith(end)), "")


Columns = Union[Table, Mapping[str, Any]]
