"""The worst contents of files at the limits of docs/limits.md: read or refused by name within a gigabyte of memory. Called with the
program and the project's root."""
import os
import subprocess
import sys
import unittest

from case import ATWOOD, Case

MEBIBYTE = 1 << 20
GIGABYTE = 10**9
CALL = """import resource, subprocess, sys
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(code, usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime)"""
SCENE = """id = "many"
title = "Many balls"
claim = "None."
source = "None."
[run]
t_end_s = 1
steps = [10, 20]
samples = 1
[truth]
kind = "none"
"""
BODY = """[[body]]
name = "ball-{0}"
shape.sphere = {{radius_m = 0.5}}
mass_kg = 1.25
position_m = [{0}.125, {0}.25, 3.0625]
velocity_m_per_s = [0.1, 0.2, 0.3]
"""
LINK = ('<link name="l{0}"><inertial><mass value="1.5"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>\n'
        '<joint name="j{0}" type="continuous"><parent link="{1}"/><child link="l{0}"/><axis xyz="0 1 0"/></joint>\n')


def filled(head, part, end, most):
    """As many parts as fit into `most` bytes; `part`: text, or a function of the part's number."""
    text = [head]
    size = len(head) + len(end)
    for number in range(10**9):
        more = part if isinstance(part, str) else part(number)
        size += len(more)
        if size > most:
            return "".join(text) + end
        text.append(more)


class Limits(Case):
    def judge(self, words, name, text, codes, *told):
        path = self.path(name, text)
        said = subprocess.run([sys.executable, "-c", CALL, ATWOOD, *words, path], cwd=self.here, capture_output=True, text=True,
                              timeout=600)
        code, memory, seconds = said.stdout.split()
        if os.environ.get("ATWOOD_TELL"):
            print(f"{name}: {float(seconds):.2f} s, {int(memory) / 1e6:.0f} MB, {said.stderr[:100]}")
        self.assertIn(int(code), codes, said.stderr[:500])
        self.assertLess(int(memory), GIGABYTE)
        for word in told:
            self.assertIn(word, said.stderr)
        self.assertLess(len(said.stderr), 10000)

    def test_toml(self):
        most = 16 * MEBIBYTE
        values, keys = 1_500_000 - 3, 300_000
        for name, text in (("keys", "".join(f"{str(i)[::-1]:x<20}=1\n" for i in range(10**6, 10**6 + keys))),
                           ("long-keys", "".join(f"{i:k>50}=1\n" for i in range(keys))),
                           ("keys-and-values", "".join(f"{str(i)[::-1]:x<20}=1\n" for i in range(10**6, 10**6 + keys - 1)) +
                            "a=[" + "1.5," * values + "]\n"),
                           ("tables", "".join(f"[k{i}]\n" for i in range(keys))), 
                           ("deep", "".join(f"k{i}{'.a' * 29}=1\n" for i in range(10**4))),
                           ("inline", "a=[" + "{b=1}," * (keys - 1) + "]\n"), ("lists", "a=[" + "[]," * (values // 2) + "]\n"),
                           ("nested", "a=[" + ("[" * 20 + "]" * 20 + ",") * (values // 21) + "]\n"),
                           ("numbers", filled("a=[", "1.2345678901234567e-300,", "]\n", most)),
                           ("texts", "a=[" + '"abcdefg",' * values + "]\n"), ("one-key", "k" * (most - 3) + "=1\n"),
                           ("one-text", "a='''" + "\n" * (most - 10) + "'''\n"), ("comment", "#\n" * (most // 2)),
                           ("instants", SCENE.replace("samples = 1\n", "samples = 1\nframe_ends_s = [" + "0.00001," * 10**6 + "]\n"))):
            with self.subTest(name=name):
                self.assertLessEqual(len(text), most)
                self.judge(["describe"], name + ".toml", text, [2], ".toml:")
        self.judge(["describe"], "over.toml", "#" * (most + 1), [2], "found 16777217 bytes")
        self.judge(["describe"], "over.toml", "".join(f"k{i}=1\n" for i in range(keys + 1)), [2], "more than 300000 keys and tables")
        self.judge(["describe"], "over.toml", "a=[" + "1," * (values + 3), [2], "more than 1500000 values")

    def test_scenes_of_many_bodies_are_read(self):
        self.judge(["describe"], "bodies.toml", SCENE + "".join(BODY.format(i) for i in range(30_000)), [0])

    def test_what_short_scenes_make(self):
        """Hulls, copies of shapes, meshes and tables that are compared with each other."""
        half = [(f"{i % 64 - 31.25:.2f}", f"{i // 64 - 15.25:.2f}", f"{i + 1:.2f}") for i in range(2048)]
        points = ",".join(f"[{x},{y},{z}],[{-float(x):.2f},{-float(y):.2f},-{z}]" for x, y, z in half)
        convex = '[[body]]\nname = "c{}"\nmass_kg = 1\nshape.convex.points_m = [{}]\n'
        few = ",".join(f"[{x},{y},{z}]" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
        grid = '[[grid]]\nbody = "{}"\ncounts = [{}, 1, 1]\nspacing_m = [3, 0, 0]\n'
        self.path("a.obj", "".join(f"v {i % 512} {i // 512} {i * i % 7}\n" for i in range(300_000)) + "f 1 2 513\n")
        mesh = '[[body]]\nname = "m{}"\nfixed = true\nshape.mesh.file = "a.obj"\n'
        fluid = '[[fluid]]\nname = "f{}"\n'
        for text, told in (("".join(convex.format(i, points) for i in range(80)), "the squares of the numbers of points of all convex shapes"),
                           (convex.format("", few) + grid.format("c", 130_000), None),
                           (convex.format("", points) + grid.format("c", 1000), "have more than 1048576 points, triangles and boxes together"),
                           ("".join(grid.format(f"c{i}", 1) for i in range(1001)), "more than 1000 of [[grid]]"),
                           ("[domain]\ndimensions = 2\n" + "".join(fluid.format(i) for i in range(65)) +
                            convex.format("", few), "more than 64 of [[fluid]]"),
                           (mesh.format(0) + mesh.format(1), "at most 524288 points and triangles in all meshes of a scene")):
            with self.subTest(told=told):
                self.judge(["describe"], "scene.toml", SCENE + text, [2] if told else [0], *([told] if told else []))

    def test_forces_of_short_scenes(self):
        """One word names all bodies, and a thruster of all bodies is as many forces: what they make is counted."""
        points = "".join(f'[[body]]\nname = "p{i}"\nmass_kg = 1\nposition_m = [{i}, 0, 0]\n' for i in range(3000))
        gravity = '[[force]]\nkind = "gravity"\nbodies = "all"\nconstant_m3_per_kg_s2 = 1\n'
        grid = '[[body]]\nname = "g"\nmass_kg = 1\n{}[[grid]]\nbody = "g"\ncounts = [{}, 1, 1]\nspacing_m = [3, 0, 0]\n'
        thruster = '[[force]]\nkind = "thruster"\nbodies = "all"\ndirection_body = [0, 0, 1]\nthrust_N = 1\non_s = [{}]\n'
        times = ",".join(f"[{2 * i}, {2 * i + 1}]" for i in range(4096))
        spring = '[[force]]\nkind = "spring"\nbody = "p0"\nanchor_m = [0, 0, 0]\nstiffness_N_per_m = 1\n'
        frame = '[[force]]\nkind = "rotating-frame"\nangular_velocity_rad_per_s = [0, 0, 1]\n'
        for name, text, told in (("gravity", points + gravity * 333, None),
                                 ("more-gravity", points + gravity * 334, "more than 1000000 bodies together (1002000 with this one"),
                                 ("judged", points + gravity * 20_000, "more than 1000000 bodies together (1002000 with this one"),
                                 ("all-of-few", grid.format("fixed = true\n", 190_000) + points + gravity * 333, None),
                                 ("frames", grid.format("", 200_000) + frame * 6, "more than 1000000 bodies together"),
                                 ("thrusters", grid.format("", 100_000) + thruster.format("[0, 1]"), None),
                                 ("more-thrusters", grid.format("", 100_001) + thruster.format("[0, 1]"), "more than 100000 forces"),
                                 ("times", grid.format("", 1000) + thruster.format(times), "more than 1000000 intervals under `on_s`"),
                                 ("springs", points + spring * 55_000, None)):
            with self.subTest(name=name):
                self.assertLess(len(text), 16 * MEBIBYTE)
                self.judge(["describe"], name + ".toml", SCENE + text, [2] if told else [0], *([told, ".toml:"] if told else []))

    def test_holds_of_many_joints(self):
        """Many joints that close loops name all others."""
        part = '[[body]]\nname = "l{0}"\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n'
        joint = '[[joint]]\nname = "{0}{1}"\nkind = "hinge"\nbodies = ["world", "l{1}"]\naxis_body = [0, 0, 1]\n{2}'
        names = ", ".join(f'"j{i}"' for i in range(15_000))
        closing = f"closes_loop = true\nassemble = true\nhold = [{names}]\n"
        text = "".join(part.format(i) + joint.format("j", i, "") for i in range(15_000))
        text += "".join(joint.format("c", i, closing) for i in range(70))
        self.assertLess(len(text), 16 * MEBIBYTE)
        self.judge(["describe"], "holds.toml", SCENE + text, [2], "keeps every joint of the loop")

    def test_json(self):
        most = 32 * MEBIBYTE
        values = 3_200_000 - 2
        words = ["run", "--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960", "--dry-run", "--shard", "1/2", "--costs"]
        rungs = ",".join(f"[{10 * i + 10},{123456 + i}]" for i in range(100))
        costs = ",".join(f'"scene-{i // 100} atwood/method-{i % 100}":[{rungs}]' for i in range(10**4))
        self.judge(words, "costs.json", '{"format":"atwood costs 1","wall_ns_by_steps":{' + costs + "}}", [0])
        for name, text in (("keys", "{" + ",".join(f'"{str(i)[::-1]:x<12}":1' for i in range(10**6, 10**6 + values // 4)) + "}"),
                           ("objects",
                            "[" + '{"abcdefghijklmnop":1},' * (values // 5) + "1]"), ("lists", "[" + "[]," * (values // 2) + "1]"),
                           ("numbers", filled("[", "1.2345678901234567e-300,", "1]", most)), ("short", "[" + "1.5e-3," * values + "1]"),
                           ("one-number", "[" + "1" * (most - 2) + "]"), ("one-text", '["' + "\\u00e9" * (most // 6 - 4) + '"]'),
                           ("texts", "[" + '"abcdefg",' * values + "1]")):
            with self.subTest(name=name):
                self.assertLessEqual(len(text), most)
                self.judge(words, name + ".json", text, [2], "costs")
        self.judge(words, "over.json", "[" + "1," * (values + 2), [2], "more than 3200000 values")
        self.judge(words, "over.json", " " * (most + 1), [2], "bytes")

    def test_urdf(self):
        most = 16 * MEBIBYTE
        elements = 200_000 - 3
        robot = '<robot name="r"><link name="a">{}</link></robot>'
        for name, text, codes in (("visuals", robot.format("<visual/>" * elements), [0, 2]),
                                  ("long-name", f'<robot name="r"><link name="{"n" * 128}">{"<visual/>" * elements}</link></robot>', [0, 2]),
                                  ("tags", robot.format("".join(f"<t{i}/>" for i in range(elements))), [0, 2]),
                                  ("attributes", robot.format("<visual " + 'b="" ' * (10**6 - 2) + "/>"), [0, 2]),
                                  ("nested", robot.format("<a>" * elements + "</a>" * elements), [0, 2]),
                                  ("text", robot.format("x" * (most - 100)), [0, 2]),
                                  ("links", '<robot name="r">' + "".join(f'<link name="{i}"/>' for i in range(elements)) + "</robot>", [2]),
                                  ("chain", '<robot name="r"><link name="base"/>' +
                                   "".join(LINK.format(i, f"l{i - 1}" if i else "base") for i in range(20_000)) + "</robot>", [0, 2]),
                                  ("tree", '<robot name="r"><link name="base"/>' +
                                   "".join(LINK.format(i, "base") for i in range(20_000)) + "</robot>", [0, 2])):
            with self.subTest(name=name):
                self.assertLessEqual(len(text), most)
                self.judge(["import"], name + ".urdf", text, codes)
        for text, told in ((robot.format("<a/>" * 200_000), "more than 200000 elements"),
                           (robot.format("<a " + "b='' " * 10**6), "more than 1000000"),
                           ("<robot>" + " " * most, "bytes"), (robot.replace('"a"', '"' + "n" * 129 + '"'), "a name of 129 bytes")):
            self.judge(["import"], "over.urdf", text, [2], told)

    def test_mjcf(self):
        """What Atwood's own code does before MuJoCo's parser starts; import_mjcf_test holds that parser to its limits."""
        if not os.path.exists(os.path.join(os.path.dirname(ATWOOD), "atwood-mujoco-import")):
            self.skipTest("without MuJoCo no MJCF is read")
        model = "<mujoco><asset>{}</asset></mujoco>"
        for text, told in ((model.format("<a/>" * 200_000), "more than 200000 elements"),
                           (model.format("\n<mesh file='m'/>" * 10_001), ":10002: <mesh>: more than 10000 files"),
                           (model.format("<mesh file='./.././'/>" * 10_000), "outside of the model's folder"),
                           (model.format(("<mesh file='" + "./" * 511 + "x'/>") * 250), "MuJoCo's compiler says"),
                           ("<mujoco>" + " " * 16 * MEBIBYTE, "bytes"),
                           (model.format("<mesh " + "b='' " * (10**6 + 1)), "more than 1000000")):
            with self.subTest(told=told):
                self.judge(["import"], "model.xml", text, [2], told)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
