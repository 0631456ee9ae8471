"""Predicts what a printer-ink or paint layer looks like: the program `inkwave`, called from Python.

Every function runs the program, so the numbers are those of the command line. It works without a wheel: with this folder on
the path (`PYTHONPATH=python`), the program on the PATH or named by $INKWAVE, and NumPy. pandas, xarray and matplotlib are used
where they are installed.

    import inkwave as iw
    ink = iw.Layer(1.0, binder=1.558, pigments=[iw.Pigment(d_nm=250, share=0.30, index="yellow")])
    r = iw.run(ink, paper=0.9, delta_e=0.5)
    r.lab, r.lab_error, r.spectra
"""

from ._files import Layer, Pigment, material
from ._library import Composed, Library
from ._program import InkwaveError, InkwaveWarning, InputError, MissingProgram, program
from ._results import Colour, Design, Fit, Ink, Sweep, export, read
from ._shards import Submitted, submit
from ._solve import Scan, solve
from ._strategies import compare, conforms
from ._tables import Table, Value
from ._work import design, fit, pack, run, sweep

__version__ = "0.1.0"

__all__ = [
    "Colour", "Composed", "Design", "Fit", "Ink", "InkwaveError", "InkwaveWarning", "InputError", "Layer", "Library", "MissingProgram", "Pigment", "Scan",
    "Submitted", "Sweep", "Table", "Value", "compare", "conforms", "design", "export", "fit", "material", "pack", "program", "read",
    "run", "solve", "submit", "sweep",
]
