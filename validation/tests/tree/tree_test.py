"""Dependencies run one way: engine <- reference <- validation <- benchmarks <- reports. Read from the includes."""
import os
import re
import sys

ROOT = sys.argv[1]
ORDER = ["engine", "reference", "validation", "benchmarks", "reports"]
TOP = set(ORDER) | {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", "CONTRIBUTING.md", "atwood", "build", "atwood-out",
                    "atwood-baseline.tsv", "atwood-baseline.tsv.env"}
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
# What reference/ may use of engine/, and in which files third-party engines may appear.
SHARED = ("scene/", "protocol/")
SUNDIALS = ("reference/sundials", "reference/cvode", "reference/arkode", "reference/ida")
THIRD_PARTY = {r"<btBullet|<BulletDynamics|<BulletCollision|<LinearMath": "reference/bullet", r"<ode/": "reference/ode",
               r"<cvode": "reference/cvode", r"<arkode": "reference/arkode", r"<ida": "reference/ida",
               r"<boost/numeric/odeint": "reference/odeint", r"<fcl/": "reference/fcl", r"<ccd/": "reference/libccd",
               r"<sundials|<nvector|<sunmatrix|<sunlinsol|<sunnonlinsol": SUNDIALS}


def room_of(path, include):
    """The room an include comes from: rooms are looked up as the compiler does."""
    here = os.path.join(os.path.dirname(path), include)
    for base in (os.path.join(ROOT, include), os.path.join(ROOT, "engine", include), os.path.join(ROOT, "reference", include), here):
        if os.path.exists(base):
            return os.path.relpath(os.path.normpath(base), ROOT)
    return None


def faults():
    for entry in os.listdir(ROOT):
        if not entry.startswith(".") and entry not in TOP:
            yield f"{entry}: not a room (the top level is fixed)"
    for room in ORDER:
        for folder, folders, files in os.walk(os.path.join(ROOT, room)):
            folders[:] = [f for f in folders if f not in ("node_modules", "__pycache__")]
            for name in files:
                path = os.path.join(folder, name)
                shown = os.path.relpath(path, ROOT)
                if not name.endswith((".cpp", ".hpp")):
                    continue
                text = open(path, encoding="utf-8").read()
                for pattern, home in THIRD_PARTY.items():
                    if re.search(r"^\s*#\s*include\s+(" + pattern + ")", text, re.M) and not shown.startswith((home if isinstance(home, tuple) else (home,)) + ("validation/tests",)):
                        yield f"{shown}: includes a header that belongs to {home}"
                if shown.startswith("validation/tests"):
                    continue
                for include in INCLUDE.findall(text):
                    target = room_of(path, include)
                    if target is None:
                        continue
                    if ORDER.index(target.split("/")[0]) > ORDER.index(room):
                        yield f"{shown}: includes {include}, to its right"
                    if room == "reference" and target.startswith("engine/") and not include.startswith(SHARED):
                        yield f"{shown}: includes {include}; reference uses the scene and the protocol, nothing else of engine"
                    if room == "validation" and target.startswith("engine/") and not include.startswith(SHARED):
                        yield f"{shown}: includes {include}; validation judges the engine from outside"


found = list(faults())
print("\n".join(found) if found else "the tree is in order")
sys.exit(1 if found else 0)
