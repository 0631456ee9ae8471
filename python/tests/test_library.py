"""Judges `inkwave.Library` by the numbers that the program and the page are judged by (validation/data/library-golden.json)."""

import base64
import json
import pathlib
import sys
import unittest
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import inkwave as iw  # noqa: E402
from inkwave import _library  # noqa: E402

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

    def test_dots_of_every_ink_are_neugebauers_mean(self):
        """Over a paper that does not spread light, the mean of the overprints by Demichel's shares, each composed alone."""
        paper, screen, (a, b) = {"albedo": 0.7}, {"ruling_per_cm": 60, "spread_um": 0}, (0.3, 0.6)
        layers = ["light", {"plate": "red", "coverage": a}, {"plate": "white", "coverage": b}]
        found = self.library.compose({"layers": layers, "paper": paper, "dots": screen})
        solids = self.library.compose([{"layers": names, "paper": paper} for names in (["light"], ["light", "red"], ["light", "white"], ["light", "red", "white"])])
        shares = np.array([(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b])
        np.testing.assert_allclose(found.factors[0], shares @ solids.lit_at_45, rtol=0, atol=1e-12)

    def test_bare_brightened_paper_has_a_closed_form(self):
        """Behind a gap nothing comes back: of the light E the paper reflects what the brightener leaves, and emits F E besides."""
        excitation, emission, quanta = [[415, 0], [430, 0.6], [480, 0]], [[440, 0], [470, 1], [520, 0.3], [580, 0]], 0.6
        paper = {"albedo": 0.5, "fluorescence": {"excitation": excitation, "emission": emission, "yield": quanta}}
        print_ = {"layers": [{"plate": "red", "coverage": 0}], "paper": paper, "dots": {"ruling_per_cm": 60, "spread_um": 40}}
        found = self.library.compose([{**print_, "condition": "M1"}, {**print_, "condition": "M2"}])
        nm = np.arange(420.0, 661.0, 5.0)
        light = np.array(next(x["powers"] for x in json.loads(LIBRARY.read_text())["lights"] if x["illuminant"] == "D50"))
        taken, sent = (np.interp(nm, *np.array(rows).T, left=0, right=0) for rows in (excitation, emission))
        area = 0.5 * 30 + 0.5 * 50 * 1.3 + 0.5 * 60 * 0.3
        for k, power in enumerate((light, np.where(nm < 420, 0, light))):
            out = [sum(5 * quanta / area * sent[i] * taken[j] * nm[j] / nm[i] * power[j] for j in range(i)) for i in range(nm.size)]
            want = 0.5 * (1 - taken) + np.array(out) / power
            np.testing.assert_allclose(found.factors[k], want[np.searchsorted(nm, found.wavelengths_nm)], rtol=0, atol=1e-12)

    def test_a_transposed_block_is_caught(self):
        """What a block of a plate that lies the other way round changes is far more than a promise allows."""
        content = json.loads(LIBRARY.read_text())
        states = content["plates"][0]["portions"][0]["states"][1]
        m = states["states"][0]
        x = np.frombuffer(base64.b64decode(states["mean"]), "<f8").copy()
        x[: m * m] = x[: m * m].reshape(m, m).T.ravel()
        states["mean"] = base64.b64encode(x.tobytes()).decode()
        stack = {"layers": ["light", "red", "light"]}
        apart = np.abs(iw.Library(content).compose(stack).lit_at_45 - self.library.compose(stack).lit_at_45)[0]
        self.assertGreater(apart[1], 1e-5)
        np.testing.assert_array_equal(apart[[0, 2, 3]], 0)

    def test_a_plate_turned_over_twice_is_itself(self):
        flux = self.library._layer_flux(0, 1.0, _library._Change())
        for part, twice in zip(flux, flux.turned().turned()):
            np.testing.assert_array_equal(part, twice)
        both = flux.then(flux.turned())
        np.testing.assert_allclose(both.ra, both.rb, rtol=0, atol=1e-12)
        np.testing.assert_allclose(both.tab, both.tba, rtol=0, atol=1e-12)

    def test_a_scalar_library_warns_of_the_surface_between_dots(self):
        dots = {"coverage": 0.5, "ruling_per_cm": 60, "spread_um": 40}
        with self.assertWarnsRegex(iw.InkwaveWarning, "the scalar wave crosses the paper's surface"):
            self.library.compose({"layers": ["red"], "paper": {"contact": True}, "dots": dots})
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.library.compose([{"layers": ["red"], "dots": dots}, {"layers": ["red"], "paper": {"contact": True}}])

    def test_refusals_say_what_is_allowed(self):
        cases = [
            ({"layers": []}, "layers"), ({"layers": [{"plate": "gold"}]}, "allowed are red, light, white, pale, foam"),
            ({"layers": [{"plate": "red", "thickness_um": 0.7}]}, "allowed 0.5"),
            ({"layers": [{"plate": "white", "thickness_um": 0.6}]}, "two slabs"),
            ({"layers": [{"plate": "red"}], "paper": {"albedo": 1.2}}, "paper.albedo"),
            ({"layers": [{"plate": "red"}], "illuminant": "F9"}, "F9"), ({"layers": [{"plate": "red"}], "colour": 1}, "colour"),
            ({"layers": [{"plate": "red", "coverage": 0.5}]}, "without a screen"),
            ({"layers": ["red"], "dots": {"ruling_per_cm": 60, "spread_um": 0}}, "found 0 coverages"),
            ({"layers": ["red"], "paper": {"fluorescence": {"excitation": [[330, 0], [365, 0.5], [420, 0]], "emission": [[420, 0], [440, 1]], "yield": 0.5}}},
             "a library from 420.0 nm"),
            ({"layers": ["red"], "paper": {"fluorescence": {"yield": 0.5}}}, "excitation, emission, yield"),
            # what would be passed over or taken for something else
            ({"layers": [{"plate": "red", "covrage": 0.4}]}, "layers.0..covrage"), ({"layers": [{"plate": "red", "thickness": 0.5}]}, "thickness: "),
            ({"layers": ["red"], "dots": {"coverage": 0.4, "ruling_per_cm": 60, "spread_um": 40, "physical_gain": 0.1}}, "physical_gain"),
            ({"layers": ["red"], "dots": {}}, "ruling_per_cm"), ({"layers": ["red"], "condition": "M7"}, "allowed are M0, M1, M2"),
            ({"layers": ["red"], "paper": {"contact": "false"}}, "paper.contact"), ({"layers": "red"}, "found no list"),
            ({"layers": ["red"], "paper": {"albedo": [[400, 0.8], [700, 0.8], [500, 0.9], [710, 0.8]]}}, "rising nm"), ([], "no composition"),
        ]
        for composition, words in cases:
            with self.assertRaisesRegex(iw.InputError, words):
                self.library.compose(composition)
        taken = {"layers": ["red"], "dots": {"coverage": np.float32(0.5), "ruling_per_cm": np.int64(60), "spread_um": 40}}
        self.assertEqual(self.library.compose(taken).lab.shape, (1, 3))
        content = json.loads(LIBRARY.read_text())
        with self.assertRaisesRegex(iw.InputError, "allowed up to 5"):
            iw.Library({**content, "inkwave_library": 6})
        with self.assertRaisesRegex(iw.InputError, "no library"):
            iw.Library({"plates": []})
        with self.assertRaisesRegex(iw.InputError, "damaged"):
            iw.Library({"inkwave_library": 4})
        unbalanced = json.loads(LIBRARY.read_text())
        states = unbalanced["plates"][0]["portions"][0]["states"][1]
        states["mean"] = base64.b64encode((3 * np.frombuffer(base64.b64decode(states["mean"]), "<f8")).tobytes()).decode()
        with self.assertRaisesRegex(iw.InputError, "of the light reflected and passed on"):
            iw.Library(unbalanced)
        dark = iw.Library({**content, "eyes": []}).compose({"layers": ["red"]})
        self.assertTrue(np.isnan(dark.lab).all() and np.isfinite(dark.lit_at_45).all())
        content["plates"][0]["portions"][0]["states"].pop()
        with self.assertRaisesRegex(iw.InputError, "wavelengths"):
            iw.Library(content)


if __name__ == "__main__":
    unittest.main()
