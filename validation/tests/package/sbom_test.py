"""The bill of materials: every library that an installed program loads, in the version that is installed, and nothing twice."""
import base64
import json
import os
import re
import subprocess
import sys
import unittest

from prefix import ROOT, Prefix


def words_of(*command):
    return subprocess.run(command, text=True, capture_output=True, timeout=60).stdout


class Bill(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.prefix = Prefix("program")
        with open(os.path.join(cls.prefix.path, "share/atwood/sbom/atwood.spdx.json")) as file:
            cls.bill = json.load(file)
        cls.packages = {package["name"]: package for package in cls.bill["packages"]}

    @classmethod
    def tearDownClass(cls):
        cls.prefix.remove()

    def test_it_is_a_document_of_spdx(self):
        self.assertEqual(self.bill["spdxVersion"], "SPDX-2.3")
        self.assertRegex(self.bill["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        ids = [package["SPDXID"] for package in self.bill["packages"]]
        self.assertEqual(len(ids), len(set(ids)))
        for one in ids:
            self.assertRegex(one, r"^SPDXRef-[A-Za-z0-9.-]+$")
        for relation in self.bill["relationships"]:
            for end in ("spdxElementId", "relatedSpdxElement"):
                self.assertIn(relation[end], [*ids, "SPDXRef-DOCUMENT"])
        related = {relation[end] for relation in self.bill["relationships"] for end in ("spdxElementId", "relatedSpdxElement")}
        self.assertEqual(related, {*ids, "SPDXRef-DOCUMENT"})

    def test_every_loaded_library_is_listed_in_its_version(self):
        found = set()
        for folder in ("bin", "libexec/atwood"):
            for name in os.listdir(os.path.join(self.prefix.path, folder)):
                found |= set(re.findall(r"NEEDED.*\[(.*)\]", words_of("readelf", "-d", os.path.join(self.prefix.path, folder, name))))
        self.assertGreater(len(found), 10)
        cache = dict(re.findall(r"^\s*(\S+) \(.*x86-64.*\) => (\S+)$", words_of("/sbin/ldconfig", "-p"), re.M))
        for library in found:
            path = os.path.realpath(cache[library])
            owner = (words_of("dpkg-query", "-S", path) or words_of("dpkg-query", "-S", path.removeprefix("/usr"))).partition(":")[0]
            self.assertIn(owner, self.packages, library)
            self.assertEqual(self.packages[owner]["versionInfo"], words_of("dpkg-query", "-W", "-f", "${Version}", owner).strip())
            self.assertTrue(self.packages[owner]["externalRefs"][0]["referenceLocator"].startswith(f"pkg:deb/debian/{owner}@"))

    def test_what_is_compiled_in_or_embedded_is_listed(self):
        for name in ("libeigen3-dev", "libboost-dev", "nlohmann-json3-dev", "three", "uplot", "GNU"):
            self.assertIn(name, self.packages)
        with open(os.path.join(ROOT, "reports/web/package-lock.json")) as file:
            locked = json.load(file)["packages"]["node_modules/three"]
        checksum = self.packages["three"]["checksums"][0]
        self.assertEqual(self.packages["three"]["versionInfo"], locked["version"])
        self.assertEqual("sha512-" + base64.b64encode(bytes.fromhex(checksum["checksumValue"])).decode(), locked["integrity"])

    def test_a_package_that_is_not_there_is_an_error(self):
        script = os.path.join(ROOT, "packaging/sbom.py")
        for more in (["--compiled-in", "no-such-package"], ["--bundled", os.path.join(ROOT, "reports/web/package-lock.json"), "no-such"]):
            done = subprocess.run([sys.executable, script, "--name", "a", "--version", "1", "--output",
                                   os.path.join(self.prefix.folder, "x.json"), *more], text=True, capture_output=True, timeout=60)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("no-such", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
