"""What the studies `default` and `contact` ask of the engines under Node.js: each scene, and heaps at rest at the native
engines' rate. Reads the files of the studies and scenarios alone, so that it needs none of these engines.
engines_under_node_test.py ROOT"""
import fnmatch
import glob
import os
import sys
import tomllib
import unittest

ROOT = os.path.abspath(sys.argv.pop(1))
ENGINES = ("rapier", "jolt", "mujoco3")
FEWEST_PER_S = 60  # steps of a heap at rest


def read(path):
    with open(path, "rb") as file:
        return tomllib.load(file)


SCENES = {scene["id"]: scene for scene in map(read, glob.glob(f"{ROOT}/validation/scenarios/*.toml"))}


def scenes_of(block):
    """The scenes that a block of cells names, by id, glob or tag."""
    return [name for name, scene in SCENES.items() for pattern in block["scenarios"]
            if (pattern[4:] in scene["tags"] if pattern.startswith("tag:") else fnmatch.fnmatchcase(name, pattern))]


def blocks_of(study):
    return read(f"{ROOT}/validation/study/{study}.toml")["cells"]


class EnginesUnderNode(unittest.TestCase):
    def test_every_scene_of_a_study_has_a_cell_of_each_default(self):
        for study in ("default", "contact"):
            blocks = blocks_of(study)
            scenes = {name for block in blocks for name in scenes_of(block)}
            self.assertGreater(len(scenes), 40)
            for engine in ENGINES:
                asked = {name for block in blocks for name in scenes_of(block)
                         if any(fnmatch.fnmatchcase(f"{engine}/default", method) for method in block["methods"])}
                self.assertEqual(scenes - asked, set(), f"{study}: scenes without a cell of {engine}/default")

    def test_presets_stand_in_every_study_of_rigid_bodies(self):
        for study in ("default", "contact", "joints", "heaps"):
            methods = [method for block in blocks_of(study) for method in block["methods"]]
            for preset in ("rapier/tuned", "jolt/tuned", "mujoco3/tuned", "mujoco3/stiff"):
                self.assertTrue(any(fnmatch.fnmatchcase(preset, method) for method in methods), f"{study}: {preset}")

    def test_heaps_at_rest_take_sixty_steps_a_second_or_more(self):
        slow, told = [], 0
        for study in ("default", "contact", "heaps"):
            for block in blocks_of(study):
                for name in scenes_of(block):
                    scene = SCENES[name]
                    if not {"pile", "rest"} <= set(scene["tags"]):
                        continue
                    told += 1
                    fewest, t_end_s = min(block.get("steps", scene["run"]["steps"])), scene["run"]["t_end_s"]
                    if fewest < FEWEST_PER_S * t_end_s:
                        slow.append(f"{study}, {name}: {fewest} steps in {t_end_s:g} s by {', '.join(block['methods'])}")
        self.assertGreater(told, 8)
        self.assertEqual(slow, [])

    def test_heaps_at_rest_are_asked_of_each_engine(self):
        for study, least in (("contact", {"stack-10", "card-house", "wall"}), ("heaps", {"stack-10", "card-house", "wall"})):
            for engine in ENGINES:
                asked = {name for block in blocks_of(study) for name in scenes_of(block)
                         if any(fnmatch.fnmatchcase(f"{engine}/default", method) for method in block["methods"])}
                self.assertLessEqual(least, asked, f"{study}: {engine}")


if __name__ == "__main__":
    unittest.main()
