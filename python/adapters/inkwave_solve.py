"""Adapter of inkwave itself, as a whole process: the program `inkwave`, and Python's standard library.

The knob is the largest amplitude error asked for, 1e-3 without one. $INKWAVE names the program.
"""

import json
import os
import subprocess
import sys
import tempfile

DESCRIPTION = {"program": "inkwave solve", "waves": ["scalar", "vector"], "knob": "--accuracy",
               "conventions": "those of inkwave"}


def solve(question):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as case:
        json.dump(question["inputs"], case)
        case.flush()
        options = ["--accuracy", question["knob"] or 1e-3, "--wave", question["wave"], "--memory-gb", question["memory_gb"]]
        command = [os.environ.get("INKWAVE", "inkwave"), "solve", case.name, *map(str, options)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        return {"refusal": done.stderr.strip()}
    found = json.loads(done.stdout)
    orders = []
    for order in found["orders"]:
        for side, key in (("reflected", "R"), ("transmitted", "T")):
            if order["propagating_" + key]:
                orders.append({"m": order["m"], "n": order["n"], "side": side, "amplitude": order[key]})
    return {"orders": orders, "seconds": found["seconds"]}


if "--describe" in sys.argv:
    print(json.dumps(DESCRIPTION))
else:
    asked = json.load(sys.stdin)
    print(json.dumps({"case": asked["case"], **solve(asked)}))
