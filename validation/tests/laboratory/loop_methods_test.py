"""Every method that claims an order on loops is in the study `loop-orders`, on both loops unless the study says why not. Called
with the program and the project's root."""
import collections
import json
import subprocess
import sys
import tomllib

ATWOOD, ROOT = sys.argv[1], sys.argv[2]
BOTH = {"slider-crank-thrown", "four-bar-crank"}
ON_ONE = {"atwood/adams-moulton4", "atwood/bdf4", "atwood/rkf45", "atwood/rattle6", "atwood/rkf78", "atwood/verner9"}  # the study says why
NOT_HERE = {"atwood/radau15", "atwood/ias15"}

found = collections.defaultdict(set)
with open(f"{ROOT}/validation/study/loop-orders.toml", "rb") as file:
    for cells in tomllib.load(file)["cells"]:
        assert cells["claim"] == "loop", cells
        for method in cells["methods"]:
            found[method.split("@")[0]].update(cells["scenarios"])
listed = json.loads(subprocess.run([ATWOOD, "list", "methods", "--json"], check=True, capture_output=True, text=True).stdout)
methods = listed["methods"] if isinstance(listed, dict) else listed
claiming = {method["id"] for method in methods if "loop" in method["claimed_order"]}
assert len(claiming) > 50, claiming
faults = [f"{method}: on {sorted(found[method]) or 'no loop'} of the study" for method in sorted(claiming - NOT_HERE)
          if found[method] != BOTH and not (method in ON_ONE and found[method])]
faults += [f"{method}: claims no order on loops" for method in sorted(set(found) - claiming) if found[method]]
print("\n".join(faults) or f"{len(claiming)} methods claim an order on loops")
sys.exit(1 if faults else 0)
