"""Keeps of a results.json what claim 19 compares: colours and spectra with their standard errors."""
import json
import pathlib
import sys

results = json.loads(pathlib.Path(sys.argv[1]).read_text())
keys = ["reflectance", "transmittance", "natural_light", "lit_at_45"]
truth = {
    "doc": "Made by `inkwave run validation/data/coverage-truth.toml` and this script; values with standard errors.",
    "program": results["program"],
    "solves": results["solves"]["finished"],
    "colours": {c["conditions"]: [c["lab"], c["lab_standard_error"]] for c in results["colours"]},
    "spectra": [
        {"wavelength_nm": row["wavelength_nm"], **{k: [row[k]["value"], row[k]["standard_error"]] for k in keys}}
        for row in results["spectra"]
        if row["polar_deg"] == 0
    ],
}
pathlib.Path(__file__).with_name("coverage_truth.json").write_text(json.dumps(truth, indent=1, ensure_ascii=False) + "\n")
