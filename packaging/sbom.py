#!/usr/bin/env python3
"""sbom.py --name NAME --version V --output FILE [--programs EXE...] [--compiled-in PACKAGE...] [--bundled LOCK NAME...]
[--built-with TEXT...]

A software bill of materials (SPDX 2.3, JSON) of one package: the Debian packages of the libraries that its programs load,
those whose headers or archives are compiled in, and the npm packages of a lock file that are bundled (`all`: every one),
each with its version. Of equal inputs the bytes are equal: the date is SOURCE_DATE_EPOCH's, 1970 without one."""
import argparse
import base64
import datetime
import hashlib
import json
import os
import re
import subprocess
import urllib.parse


def output_of(*words):
    """What a command prints; empty where it fails or is not there."""
    try:
        return subprocess.run(words, text=True, capture_output=True, check=False).stdout
    except FileNotFoundError:
        return ""


def loaded_libraries(programs):
    """{soname: path} of all shared libraries that the programs load, directly or through others."""
    found = {}
    for program in programs:
        for line in output_of("ldd", program).splitlines():
            match = re.match(r"\s*(\S+) => (/\S+)", line)
            if match:
                found[match[1]] = match[2]
            elif "not found" in line:
                raise SystemExit(f"sbom.py: {program}: {line.strip()}")
    return found


def debian_owner(path):
    """The Debian package of a file, also where /lib stands for /usr/lib; empty: none."""
    real = os.path.realpath(path)
    for candidate in dict.fromkeys((path, real, real.removeprefix("/usr"), "/usr" + real)):
        owner = output_of("dpkg-query", "-S", candidate).partition(": ")[0]
        if owner:
            return owner.partition(",")[0]
    return ""


def debian_package(name):
    """The SPDX entry of an installed Debian package."""
    fields = output_of("dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}\t${Maintainer}\n", name)
    if not fields.strip():
        raise SystemExit(f"sbom.py: no Debian package {name} is installed")
    package, version, architecture, maintainer = fields.splitlines()[0].split("\t")
    url = f"pkg:deb/debian/{package}@{urllib.parse.quote(version, safe='')}?arch={architecture}&distro=debian-12"
    return entry(package, version, url, supplier="Organization: Debian (" + maintainer.partition(" <")[0] + ")")


def npm_packages(lock, names):
    """The SPDX entries of packages of a lock file, with its checksums."""
    with open(lock, encoding="utf-8") as file:
        locked = {path.partition("node_modules/")[2]: one for path, one in json.load(file)["packages"].items() if path}
    for name in sorted(locked) if names == ["all"] else names:
        if name not in locked:
            raise SystemExit(f"sbom.py: {lock} has no package {name}")
        one = locked[name]
        url = f"pkg:npm/{urllib.parse.quote(name, safe='/')}@{one['version']}"
        algorithm, _, digest = one["integrity"].partition("-")
        checksum = {"algorithm": algorithm.upper(), "checksumValue": base64.b64decode(digest).hex()}
        yield entry(name, one["version"], url, licence=one.get("license", "NOASSERTION"), checksum=checksum)


def entry(name, version, url="", licence="NOASSERTION", supplier="NOASSERTION", checksum=None):
    spdx_id = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", f"{url.partition(':')[2].partition('/')[0]}-{name}".strip("-"))
    described = {"SPDXID": spdx_id, "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION",
                 "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence,
                 "copyrightText": "NOASSERTION", "supplier": supplier}
    if checksum:
        described["checksums"] = [checksum]
    if url:
        described["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": url}]
    return described


def bill(options):
    own = entry(options.name, options.version, licence="MIT", supplier="Organization: The Atwood maintainers")
    own["SPDXID"] = "SPDXRef-Package"
    own["copyrightText"] = "Copyright (c) 2026 The Atwood maintainers"
    packages, relations = {own["SPDXID"]: own}, {("SPDXRef-DOCUMENT", "DESCRIBES", own["SPDXID"])}

    def relate(package, kind):
        packages[package["SPDXID"]] = package
        relations.add((own["SPDXID"], kind, package["SPDXID"]))

    for soname, path in loaded_libraries(options.programs).items():
        owner = debian_owner(path)
        relate(debian_package(owner) if owner else entry(soname, "NOASSERTION"), "DYNAMIC_LINK")
    for name in options.compiled_in:
        relate(debian_package(name), "STATIC_LINK")
    if options.bundled:
        for package in npm_packages(options.bundled[0], options.bundled[1:]):
            relate(package, "CONTAINS")
    for tool in options.built_with:
        name, _, version = tool.rpartition(" ")
        package = entry(name, version)
        packages[package["SPDXID"]] = package
        relations.add((package["SPDXID"], "BUILD_TOOL_OF", own["SPDXID"]))
    listed = [packages[key] for key in sorted(packages)]
    related = [{"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b} for a, kind, b in sorted(relations)]
    content = hashlib.sha256(json.dumps([listed, related]).encode()).hexdigest()
    created = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), datetime.timezone.utc)
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
            "name": f"{options.name}-{options.version}",
            "documentNamespace": f"https://spdx.org/spdxdocs/{options.name}-{options.version}-{content[:32]}",
            "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: atwood-sbom"]},
            "packages": listed, "relationships": related}


def main():
    parser = argparse.ArgumentParser()
    for name in ("--name", "--version", "--output"):
        parser.add_argument(name, required=True)
    for name in ("--programs", "--compiled-in", "--bundled", "--built-with"):
        parser.add_argument(name, nargs="+", default=[])
    options = parser.parse_args()
    text = json.dumps(bill(options), indent=1) + "\n"
    os.makedirs(os.path.dirname(options.output), exist_ok=True)
    unfinished = f"{options.output}.{os.getpid()}"  # the file is whole at any time, also while two installations run
    with open(unfinished, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(unfinished, options.output)


main()
