"""Scenes of the catalogue have the class under Node.js that the C++ adapters give them: the table of
validation/tests/rivals/scene_class_test.cpp. scene_class_test.py ATWOOD ROOT NODE."""
import json
import re
import subprocess
import sys

ATWOOD, ROOT, NODE = sys.argv[1:4]
CLASS_OF = ("import { readScene } from '%s/reference/node/scene.mjs'; import { sceneClass } from '%s/reference/node/scene_class.mjs';"
            "import { readFileSync } from 'node:fs';"
            "for (const line of readFileSync(0, 'utf8').split('\\n').filter(Boolean))"
            " console.log(sceneClass(readScene(JSON.parse(line).scene)));") % (ROOT, ROOT)

with open(f"{ROOT}/validation/tests/rivals/scene_class_test.cpp") as file:
    expected = {name: kind.replace("_", "-") for name, kind in re.findall(r'\{"([\w.-]+)", SceneClass::(\w+)\}', file.read())}
assert len(expected) > 20, expected
scenes = [json.dumps(json.loads(subprocess.run([ATWOOD, "describe", name, "--json"], capture_output=True, check=True, cwd=ROOT).stdout))
          for name in expected]
found = subprocess.run([NODE, "--input-type=module", "-e", CLASS_OF], input="\n".join(scenes), capture_output=True, text=True, check=True)
wrong = {name: (kind, got) for (name, kind), got in zip(expected.items(), found.stdout.split(), strict=True) if kind != got}
print(f"{len(expected)} scenes; wrong (expected, found): {wrong}")
sys.exit(bool(wrong))
