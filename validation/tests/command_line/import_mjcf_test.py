"""Models in MJCF of unknown origin: the files that they name, and what MuJoCo's parser may take and do. Called with the program."""
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest

from case import ATWOOD, Case

IMPORTER = os.path.join(os.path.dirname(ATWOOD), "atwood-mujoco-import")
BODY = '<worldbody><body name="b"><freejoint/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body></worldbody>'
NAMING = {"mesh": '<asset><mesh name="m" file="{}"/></asset>', "hfield": '<asset><hfield name="m" file="{}" size="1 1 1 1"/></asset>',
          "texture": '<asset><texture name="m" type="2d" file="{}"/></asset>',
          "side": '<asset><texture name="m" type="cube" fileright="{}"/></asset>', "skin": '<asset><skin name="m" file="{}"/></asset>',
          "include": '<include file="{}"/>', "other": '<asset><newer name="m" file="{}"/></asset>'}
TETRAHEDRON = [((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
               ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1))]


def model(*parts):
    return "<mujoco>" + "".join(parts) + BODY + "</mujoco>"


class Imports(Case):
    def setUp(self):
        super().setUp()
        if not os.path.exists(IMPORTER):
            self.skipTest("without MuJoCo no MJCF is read")
        os.mkdir(self.path("m"))

    def refused(self, text, *words, code=2):
        self.path("m/model.xml", text)
        said = self.ask("import", "m/model.xml", code=code, told=words, timeout=60)
        self.assertEqual(said.stdout, "")
        self.assertEqual(said.stderr.count("\n"), 1, said.stderr)
        return said


class NamedFiles(Imports):
    def test_special_files_are_refused_unopened(self):
        os.mkfifo(self.path("m/pipe"))
        os.mkdir(self.path("m/sub"))
        with socket.socket(socket.AF_UNIX) as open_socket:
            open_socket.bind(self.path("m/socket"))
            for kind, element in NAMING.items():
                for name, words in (("pipe", "a pipe"), ("sub", "a folder"), ("socket", "a socket")):
                    with self.subTest(kind=kind, name=name):
                        self.refused(model("\n" + element.format(name)), "m/model.xml:2: <", f'names "{name}", which is {words}')

    def test_nothing_outside_of_the_folder(self):
        self.path("outside", "<mujocoinclude/>")
        os.symlink("/etc/passwd", self.path("m/passwd"))
        os.symlink("/dev/zero", self.path("m/zero"))
        os.symlink("..", self.path("m/up"))
        os.symlink("itself", self.path("m/itself"))
        for kind, element in NAMING.items():
            for name in ("/etc/passwd", "passwd", "zero", "../outside", "up/outside", "../none", "/none"):
                with self.subTest(kind=kind, name=name):
                    self.refused(model(element.format(name)), f'names "{name}", outside of the model\'s folder')
            if kind in ("mesh", "hfield", "skin", "texture"):  # MuJoCo's `strippath` leaves what follows the last separator
                for name in ("none/passwd", "none\\passwd"):
                    with self.subTest(kind=kind, name=name):
                        self.refused(model('<compiler strippath="true"/>', element.format(name)), "outside of the model's folder")
            for name, words in (("itself", "Too many levels of symbolic links"), ("x" * 300, "File name too long")):
                with self.subTest(kind=kind, name=name):
                    self.refused(model(element.format(name)), f"which cannot be followed ({words})")

    def test_the_folders_of_the_compiler(self):
        os.mkdir(self.path("m/sub"))
        self.path("a.stl", "")
        for key, kind in (("meshdir", "mesh"), ("meshdir", "hfield"), ("meshdir", "skin"), ("texturedir", "texture"), ("assetdir", "mesh"),
                          ("assetdir", "side"), ("meshdir", "other"), ("texturedir", "other")):
            for folder in ("..", self.here, "sub/../.."):
                with self.subTest(key=key, folder=folder):
                    self.refused(model(f'<compiler {key}="{folder}"/>', NAMING[kind].format("a.stl")), "outside of the model's folder")
            self.refused(model(f'<compiler {key}="sub"/>', NAMING[kind].format("../../a.stl")), '/../a.stl", outside')

    def test_what_included_files_name(self):
        os.mkfifo(self.path("m/pipe"))
        self.path("m/parts/one.xml", '<mujocoinclude><include file="parts/two.xml"/></mujocoinclude>')
        for text, words in (('<mujoco><asset><mesh file="pipe"/></asset></mujoco>', 'two.xml:1: <mesh> names "pipe", which is a pipe'),
                            ('<mujoco><compiler meshdir="/etc"/><asset><mesh file="passwd"/></asset></mujoco>', "outside"),
                            ('<mujoco><include file="/etc/passwd"/></mujoco>', 'two.xml:1: <include> names "/etc/passwd", outside'),
                            ("<mujoco", "two.xml:1: found no XML")):
            self.path("m/parts/two.xml", text)
            with self.subTest(text=text):
                self.refused(model('<include file="parts/one.xml"/>'), words)

    def test_bounds(self):
        for number in range(300):
            self.path(f"m/{number}.xml", f'<mujoco><include file="{number + 1}.xml"/></mujoco>')
            self.path(f"m/flat{number}.xml", "<mujoco/>")
        self.refused(model('<include file="0.xml"/>'), "is nested in 16 other files; expected fewer")
        self.refused(model(*(f'<include file="flat{i}.xml"/>' for i in range(300))), "is the 257th file that is included")
        self.refused(model("<asset>", *(f'<mesh name="{i}" file="{i}"/>' for i in range(10001)), "</asset>"), "more than 10000 files")
        self.refused(model(NAMING["mesh"].format("x" * 1025)), "has a path of 1025 bytes; expected at most 1024")
        self.refused(model("<asset>", *(f'<mesh file="{i:01000}"/>' for i in range(300)), "</asset>"), "exceed 262144 bytes")
        self.refused(model(*(f'<compiler meshdir="{i}"/>' for i in range(5))), "is one of more than 4 folders")

    def test_text_that_parsers_read_in_two_ways(self):
        self.refused("<!DOCTYPE mujoco [<!-- ]>" + model() + "<!-- -->]>" + model(), "found")
        self.refused("<!DOCTYPE mujoco>" + model(), "model.xml:1: found a <!DOCTYPE>")
        self.refused(model(NAMING["mesh"].format("a&#47;b")), "a path with `&` or a control character")
        self.refused(model("\0"), "found a zero byte")

    def test_files_inside_are_read(self):
        stl = bytes(80) + len(TETRAHEDRON).to_bytes(4, "little")
        for triangle in TETRAHEDRON:
            stl += bytes(12) + b"".join(struct.pack("<3f", *corner) for corner in triangle) + bytes(2)
        self.path("m/meshes/a.stl", "")
        with open(self.path("m/meshes/a.stl"), "wb") as file:
            file.write(stl)
        os.symlink("meshes/a.stl", self.path("m/link.stl"))
        self.path("m/parts/body.xml", '<mujoco><worldbody><body name="shell"><freejoint/><geom type="mesh" mesh="m" density="1000"/></body>'
                                      "</worldbody></mujoco>")
        for folder, name in (("meshes", "a.stl"), ("", "meshes/a.stl"), ("", self.path("m/meshes/a.stl")), ("meshes", "../meshes/a.stl"),
                             ("", "link.stl"), (self.path("m/meshes"), "a.stl")):
            text = model(f'<compiler meshdir="{folder}"/>', NAMING["mesh"].format(name), '<include file="parts/body.xml"/>')
            self.path("m/model.xml", text)
            with self.subTest(folder=folder, name=name):
                self.assertIn('"shell"', self.ask("import", "m/model.xml").stdout)
                self.assertIn('"shell"', self.ask("import", "model.xml", cwd=self.path("m")).stdout)

    def test_refusals_of_mujoco_name_the_file_as_it_was_named(self):
        self.refused("<mujoco><worldbodies/></mujoco>", "atwood: m/model.xml: MuJoCo's compiler says: ")


class Numbers(Imports):
    def test_numbers_that_are_not_finite(self):
        """NaN counts for MuJoCo as an attribute that is not given: some of these leave no trace in its model."""
        body = ('<body name="b" {}>\n<joint name="j" {}/>\n<inertial {}/>\n<geom size=".1" {}/></body>')
        usual = 'pos="0 0 0" mass="1" diaginertia="1 1 1"'
        for words, said in ((("pos='0 nan 0'", "", usual, ""), 'm/model.xml:1: <body> `b`: `pos` holds nan; expected finite numbers'),
                            (("", "axis='nan 0 0'", usual, ""), "m/model.xml:2: <joint> `j`: `axis` holds nan"),
                            (("", "damping='-INF'", usual, ""), "m/model.xml:2: <joint> `j`: `damping` holds -INF"),
                            (("", "range='0 1e999'", usual, ""), "m/model.xml:2: <joint> `j`: `range` holds 1e999"),
                            (("", "", usual + " euler='nan 0 0'", ""), "m/model.xml:3: <inertial>: `euler` holds nan"),
                            (("", "", usual, "mass='NaN'"), "m/model.xml:4: <geom>: `mass` holds NaN")):
            with self.subTest(words=words):
                self.refused(f"<mujoco><worldbody>{body.format(*words)}</worldbody></mujoco>", said)
        named = body.format("childclass='inf'", "", usual, "").replace('"j"', '"nan"')
        self.path("m/model.xml", f'<mujoco><default><default class="inf"/></default><worldbody>{named}</worldbody></mujoco>')
        self.assertIn('name = "nan"', self.ask("import", "m/model.xml").stdout)

    def test_no_body(self):
        self.refused("<mujoco/>", "atwood: m/model.xml: found no body that moves")


class Limits(Imports):
    def test_memory(self):
        """A texture of 1.2 GB, which MuJoCo makes twice."""
        self.path("m/model.xml", model('<asset><texture name="t" type="2d" builtin="flat" width="20000" height="20000"/></asset>'))
        script = ("import resource, subprocess, sys\n"
                  "ended = subprocess.run(sys.argv[1:], capture_output=True, text=True)\n"
                  "print(ended.returncode, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024, ended.stderr)")
        said = subprocess.run([sys.executable, "-c", script, ATWOOD, "import", self.path("m/model.xml")], capture_output=True, text=True)
        code, mebibytes, *words = said.stdout.split()
        self.assertEqual(code, "2", said.stdout)
        self.assertIn("more than 1 GiB of memory", " ".join(words))
        self.assertLess(int(mebibytes), 1536)


class Confined(Case):
    """The program beside a stand-in for the importer."""

    def setUp(self):
        super().setUp()
        self.program = self.path("bin/atwood", "")
        shutil.copy(ATWOOD, self.program)
        self.path("model.xml", model())

    def stand_in(self, text):
        self.path("bin/atwood-mujoco-import", f"#!{sys.executable}\nimport os, signal, socket, sys, time\n" + text, 0o755)

    def imported(self, code, *words):
        ended = subprocess.run([self.program, "import", "model.xml"], cwd=self.here, text=True, capture_output=True, timeout=120)
        return self.expect(ended, code, *words)

    def test_endings(self):
        for text, code, words in (("print('id = 1')", 0, "id = 1"), ("sys.exit('model.xml: bad')", 3, "MuJoCo's parser failed (exited with code 1)"),
                                  ("print('id = 1', flush=True); os.kill(os.getpid(), signal.SIGSEGV)", 3, "killed by signal 11"),
                                  ("sys.stderr.write(sys.argv[1] + ': bad'); sys.exit(2)", 2, "atwood: model.xml: bad"),
                                  ("while True: sys.stdout.write('# x\\n' * 10000)", 2, "would take more than 16 MiB"),
                                  ("while True: sys.stdout.write('x' * 10000)", 2, "would take more than 16 MiB")):
            self.stand_in(text)
            with self.subTest(text=text):
                said = self.imported(code, words)
                if code:
                    self.assertEqual(said.stdout, "")

    def test_notes(self):
        self.stand_in("print('# Imported.\\n# Not taken, or changed:\\n#   a \\x1b[31mgeom\\n#   a tendon\\nid = 1\\n#   no note')")
        self.assertEqual(self.imported(0).stderr, "not taken, or changed: a geom\nnot taken, or changed: a tendon\n")

    def test_time(self):
        self.stand_in("time.sleep(600)")
        self.imported(2, "model.xml: MuJoCo's parser did not end within 20 s")

    def test_nothing_is_written_and_nobody_called(self):
        told = self.run_in("doctor").stdout
        if "NOT confined" in told or "other protocols" in told:
            self.skipTest("not fully confined here")
        self.stand_in(f"""
try: open({self.path('written')!r}, 'w'); print('# wrote')
except OSError: pass
with socket.socket() as listener:
    try: listener.connect(('127.0.0.1', int(open({self.path('port')!r}).read()))); print('# called')
    except OSError: pass
open('own', 'w').close()
print('# scratch', os.getcwd())
""")
        with socket.create_server(("127.0.0.1", 0)) as server:
            self.path("port", str(server.getsockname()[1]))
            said = self.imported(0, "# scratch")
        self.assertNotIn("# wrote", said.stdout)
        self.assertNotIn("# called", said.stdout)
        self.assertFalse(os.path.exists(self.path("written")))
        self.assertFalse(os.path.exists(said.stdout.split()[-1]))  # its scratch directory has gone

    def importer_of(self, running):
        self.stand_in("open(os.environ['TMPDIR'] + '/own', 'w'); print(flush=True); time.sleep(600)")
        process = subprocess.Popen([self.program, "import", "model.xml"], cwd=self.here, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        running.append(process)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            with open(f"/proc/{process.pid}/task/{process.pid}/children") as file:
                for child in file.read().split():
                    with open(f"/proc/{child}/cmdline") as command:
                        if "atwood-mujoco-import" in command.read():
                            return process, int(child)
            time.sleep(0.01)
        self.fail("the importer did not start")

    def test_it_ends_with_the_program(self):
        for sent, code in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGTERM, 128 + signal.SIGTERM), (signal.SIGINT, 128 + signal.SIGINT)):
            running = []
            with self.subTest(signal=sent):
                process, importer = self.importer_of(running)
                process.send_signal(sent)
                process.communicate(timeout=60)
                self.assertEqual(process.returncode, code)
                end = time.monotonic() + 20
                while os.path.exists(f"/proc/{importer}") and time.monotonic() < end:
                    with open(f"/proc/{importer}/stat") as file:
                        if file.read().rsplit(")", 1)[1].split()[0] == "Z":
                            break  # nobody has waited for it
                    time.sleep(0.01)
                else:
                    if os.path.exists(f"/proc/{importer}"):
                        os.kill(importer, signal.SIGKILL)
                        self.fail("the importer outlives the program")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
