"""What the adapters share: question and answer, the orders of a case, polarisations, and the case on voxels (`inkwave.adapter`)."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from inkwave.adapter import Case, Refusal, averaged, index, main, pair, program  # noqa: E402,F401
