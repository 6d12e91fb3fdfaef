"""Dependencies run one way, read from the includes: between rooms engine <- reference <- validation <- benchmarks <- reports,
and inside a room between folders, whose graph has no cycle; folders of engine/ include from those on their left in the table of
CONTRIBUTING.md."""
import collections
import os
import re
import sys

ROOT = sys.argv[1]
ORDER = ["engine", "reference", "validation", "benchmarks", "reports"]
TOP = set(ORDER) | {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", "CONTRIBUTING.md", "docs", "packaging", "action.yml", "CHANGELOG.md", "atwood", "build", "atwood-out",
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
    for base in (here, os.path.join(ROOT, include), os.path.join(ROOT, "engine", include), os.path.join(ROOT, "reference", include)):
        if os.path.exists(base):
            return os.path.relpath(os.path.normpath(base), ROOT)
    return None


def sources():
    """(room, path, path from the root, text) of every source file."""
    for room in ORDER:
        for folder, folders, files in os.walk(os.path.join(ROOT, room)):
            folders[:] = sorted(f for f in folders if f not in ("node_modules", "__pycache__"))
            for name in sorted(files):
                if name.endswith((".cpp", ".hpp")):
                    path = os.path.join(folder, name)
                    yield room, path, os.path.relpath(path, ROOT), open(path, encoding="utf-8").read()


def faults():
    for entry in os.listdir(ROOT):
        if not entry.startswith(".") and entry not in TOP:
            yield f"{entry}: not a room (the top level is fixed)"
    for room, path, shown, text in sources():
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


def folder_includes():
    """{folder: {folder it includes from: ["file includes file", ...]}}, a folder's own files left out."""
    graph = collections.defaultdict(lambda: collections.defaultdict(list))
    for _, path, shown, text in sources():
        for include in INCLUDE.findall(text):
            target = room_of(path, include)
            if target is not None and os.path.dirname(target) != os.path.dirname(shown):
                graph[os.path.dirname(shown)][os.path.dirname(target)].append(f"{shown} includes {include}")
    return graph


def shortest_cycle(graph, start):
    """Folders from `start` back to it along includes, by breadth-first search; None where there is no way back."""
    came_from, queue = {}, collections.deque([start])
    while queue:
        folder = queue.popleft()
        for target in sorted(graph.get(folder, ())):
            if target == start:
                cycle = [start]
                while folder != start:
                    cycle.insert(1, folder)
                    folder = came_from[folder]
                return cycle + [start]
            if target not in came_from:
                came_from[target] = folder
                queue.append(target)
    return None


def cycles():
    graph, told = folder_includes(), set()
    for folder in sorted(graph):
        cycle = shortest_cycle(graph, folder)
        if cycle is None or frozenset(cycle) in told:
            continue
        told.add(frozenset(cycle))
        yield "folders include each other: " + " -> ".join(cycle)
        for a, b in zip(cycle, cycle[1:]):
            for line in sorted(graph[a][b]):
                yield "    " + line


def engine_order():
    """Includes of engine/ from a folder that stands to the right in the table of CONTRIBUTING.md, or in no place there."""
    table = re.search(r"^engine/ +(.*?)^reference/", open(os.path.join(ROOT, "CONTRIBUTING.md"), encoding="utf-8").read(), re.M | re.S)
    order = [name.rstrip("/") for name in table.group(1).split() if name.endswith("/")]
    place = {f"engine/{name}": at for at, name in enumerate(order)}
    place["engine"] = len(order)  # simulation.* and the engine's other files
    graph = folder_includes()
    for folder in sorted(f for f in graph if f.split("/")[0] == "engine"):
        if folder not in place:
            yield f"{folder}: not in the table of CONTRIBUTING.md"
            continue
        for target in sorted(graph[folder]):
            if target.startswith("engine/") and place.get(target, len(order)) > place[folder]:
                yield from (f"{line}, to its right in the table of CONTRIBUTING.md" for line in graph[folder][target])


found = list(faults()) + list(cycles()) + list(engine_order())
print("\n".join(found) if found else "the tree is in order")
sys.exit(1 if found else 0)
