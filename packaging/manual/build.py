#!/usr/bin/env python3
"""Builds the manual: the pages of docs/, and pages that the program writes about itself, as a site.

    build.py --program build/release/bin/atwood --output build/release/manual [--pages-only]

The program's pages are made here, each time, and never committed: they cannot differ from the program."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys

import pages
import reference_pages

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def assemble(program, output, pictures=True):
    """Writes output/docs, what mkdocs reads; answers the faults of its links. `pictures`: of all scenes, of none (False),
    or of those in this set of ids."""
    docs = output / "docs"
    shutil.rmtree(docs, ignore_errors=True)
    shutil.copytree(ROOT / "docs", docs, ignore=shutil.ignore_patterns("README.md"))
    reference_pages.write(program, docs, pictures)
    faults = pages.bring_in(ROOT, docs)
    shutil.copy(HERE / "manual.css", docs / "manual.css")
    return faults + pages.broken_links(docs)


def can_build_sites():
    """Whether mkdocs is here with its Material theme."""
    if not shutil.which("mkdocs"):
        return False
    return "material" in subprocess.run(["mkdocs", "build", "--help"], capture_output=True, text=True).stdout


def site(output):
    """output/site from output/docs; exit code 1 where mkdocs has a complaint."""
    shutil.copy(HERE / "mkdocs.yml", output / "mkdocs.yml")
    shutil.rmtree(output / "theme", ignore_errors=True)
    shutil.copytree(HERE / "theme", output / "theme")
    environment = {"SOURCE_DATE_EPOCH": "0", **os.environ}  # the same bytes from the same pages
    ended = subprocess.run(["mkdocs", "build", "--strict", "--quiet", "--config-file", "mkdocs.yml"], cwd=output,
                           env=environment)
    if ended.returncode:
        return ended.returncode
    search = output / "site/search"
    index = (search / "search_index.json").read_text(encoding="utf-8")
    (search / "index.js").write_text(f"var __search = {{ index: Promise.resolve({index}) }};\n", encoding="utf-8")
    shutil.copy(HERE / "worker_in_frame.js", search / "worker_in_frame.js")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=pathlib.Path, required=True, help="the built atwood")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="a folder: docs, then site")
    parser.add_argument("--pages-only", action="store_true", help="write and check output/docs; needs no mkdocs")
    words = parser.parse_args()
    if not words.pages_only and not can_build_sites():
        sys.exit("manual: mkdocs with its Material theme is not installed; apt-get install mkdocs-material")
    if not words.program.is_file():
        sys.exit(f"manual: no program at {words.program}; `ninja programs` builds it")
    words.output.mkdir(parents=True, exist_ok=True)
    faults = assemble(words.program.resolve(), words.output.resolve(), pictures=not words.pages_only)
    if faults:
        sys.exit("\n".join(faults))
    if not words.pages_only:
        code = site(words.output.resolve())
        if code == 0:
            print(f"manual: {words.output / 'site/index.html'}")
        sys.exit(code)


if __name__ == "__main__":
    main()
