"""Judges `inkwave.Library` by the numbers that the program and the page are judged by (validation/data/library-golden.json)."""

import json
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import inkwave as iw  # noqa: E402

LIBRARY = ROOT / "validation" / "data" / "library.json"


class Library(unittest.TestCase):
    """*Planted*: a transposed block of a plate; the mean wave from behind in place of that from in front."""

    @classmethod
    def setUpClass(cls):
        cls.library = iw.Library(LIBRARY)
        cls.golden = json.loads((ROOT / "validation" / "data" / "library-golden.json").read_text())

    def test_stacks_are_those_of_the_program(self):
        found = self.library.compose([one["composition"] for one in self.golden], bars=True)
        for k, one in enumerate(self.golden):
            for name, numbers in one["numbers"].items():
                value, bar = np.atleast_1d(getattr(found, name)[k]), np.atleast_1d(found.errors[name][k])
                # a promise: values to 1e-6; bars to 1 %, of which two digits are read
                np.testing.assert_allclose(value, numbers["value"], rtol=0, atol=1e-6, err_msg=f"{k} {name}")
                np.testing.assert_allclose(bar, numbers["bar"], rtol=1e-2, atol=1e-8, err_msg=f"{k} {name}")

    def test_many_at_once_are_each_alone(self):
        listed = [one["composition"] for one in self.golden]
        together, alone = self.library.compose(listed), [self.library.compose(one) for one in listed]
        # rounding, and a finer mean over the hemisphere where another stack has more fringes
        np.testing.assert_allclose(together.lab, np.concatenate([one.lab for one in alone]), rtol=0, atol=1e-6)

    def test_a_white_furnace_keeps_its_light(self):
        """A perfect white under a layer without absorption returns all light of a uniform sky."""
        content = json.loads(LIBRARY.read_text())
        library = iw.Library(content)
        for contact in (False, True):
            for layers in (["pale"], ["pale", "pale", "pale"]):
                seen = library.compose({"layers": layers, "paper": {"albedo": 1.0, "contact": contact}})
                np.testing.assert_allclose(seen.natural_light, 1.0, atol=1e-9)

    def test_refusals_say_what_is_allowed(self):
        cases = [
            ({"layers": []}, "layers"), ({"layers": [{"plate": "gold"}]}, "allowed are red, light, white, pale"),
            ({"layers": [{"plate": "red", "thickness_um": 0.7}]}, "allowed 0.5"),
            ({"layers": [{"plate": "white", "thickness_um": 0.6}]}, "two slabs"),
            ({"layers": [{"plate": "red"}], "paper": {"albedo": 1.2}}, "paper.albedo"),
            ({"layers": [{"plate": "red"}], "illuminant": "F9"}, "F9"), ({"layers": [{"plate": "red"}], "colour": 1}, "colour"),
        ]
        for composition, words in cases:
            with self.assertRaisesRegex(iw.InputError, words):
                self.library.compose(composition)
        content = json.loads(LIBRARY.read_text())
        with self.assertRaisesRegex(iw.InputError, "allowed up to 2"):
            iw.Library({**content, "inkwave_library": 3})
        with self.assertRaisesRegex(iw.InputError, "no library"):
            iw.Library({"plates": []})
        content["plates"][0]["portions"][0]["states"].pop()
        with self.assertRaisesRegex(iw.InputError, "wavelengths"):
            iw.Library(content)


if __name__ == "__main__":
    unittest.main()
