"""Scenes of the catalogue have the class under Node.js that the C++ adapters give them, with their bodies in either order: the
table of validation/tests/rivals/scene_class_test.cpp. scene_class_test.py ATWOOD ROOT; skipped without Node.js."""
import json
import os
import re
import shutil
import subprocess
import sys

from workers import has_node

ATWOOD, ROOT = sys.argv[1], os.path.abspath(sys.argv[2])
CLASSES_OF = """
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
const source = (name) => import(pathToFileURL(`${process.argv[1]}/reference/node/${name}.mjs`).href);
const { readScene } = await source("scene"), { sceneClass } = await source("scene_class");
for (const line of readFileSync(0, "utf8").split("\\n").filter(Boolean)) {
  const { scene } = JSON.parse(line), bodies = [...scene.bodies].reverse();
  console.log([scene, { ...scene, bodies }].map((one) => sceneClass(readScene(one))).join(" "));
}
"""

if not has_node():
    print("no Node.js of version 18.3 or newer")
    sys.exit(77)
with open(f"{ROOT}/validation/tests/rivals/scene_class_test.cpp") as file:
    expected = {name: kind.replace("_", "-") for name, kind in re.findall(r'\{"([\w.-]+)", SceneClass::(\w+)\}', file.read())}
assert len(expected) > 20, expected
scenes = [json.dumps(json.loads(subprocess.run([ATWOOD, "describe", name, "--json"], capture_output=True, check=True, cwd=ROOT).stdout))
          for name in expected]
found = subprocess.run([shutil.which("node"), "--input-type=module", "-e", CLASSES_OF, ROOT], input="\n".join(scenes), text=True,
                       capture_output=True, check=True).stdout.splitlines()
wrong = {name: (kind, got) for (name, kind), got in zip(expected.items(), found, strict=True) if got != f"{kind} {kind}"}
print(f"{len(expected)} scenes; wrong (expected, found): {wrong}")
sys.exit(bool(wrong))
