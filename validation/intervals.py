#!/usr/bin/env python3
"""Keeps what claim 24 needs of its truth.

    inkwave run validation/data/intervals.toml --output FOLDER
    python3 validation/intervals.py FOLDER/results.json > validation/data/intervals.json
"""

import json
import sys

with open(sys.argv[1]) as file:
    results = json.load(file)
if results["status"] != "complete":
    sys.exit("the truth is not complete")
provenance = {key: results[key] for key in ("study_hash", "program", "method_version", "seed", "realisations", "solves")}
kept = ("reflectance", "transmittance", "natural_light", "lit_at_45")
estimate = lambda e: [e["value"], e["standard_error"]]
spectra = [
    {"wavelength_nm": row["wavelength_nm"], **{key: estimate(row[key]) for key in kept}}
    for row in results["spectra"]
    if row["polar_deg"] == 0
]
colours = [
    {"conditions": c["conditions"], "lab": c["lab"], "standard_error": c["lab_standard_error"]}
    for c in results["colours"]
]
json.dump({"provenance": provenance, "colours": colours, "spectra": spectra}, sys.stdout, indent=1, ensure_ascii=False)
print()
