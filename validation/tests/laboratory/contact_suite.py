#!/usr/bin/env python3
"""Runs the study `contact` as the suite judges it: of the cells that have a time limit of their own (a minute at rest, heaps),
which take most of the time, our engine alone. `.ci/nightly studies` runs the whole study.

    contact_suite.py ATWOOD STUDY.TOML OUT
"""
import os
import re
import sys


def of_the_suite(block):
    """A block of cells as the suite runs it; empty: it has no method of ours."""
    if not re.search(r"^limit", block, re.M):
        return block
    methods = re.search(r"^methods\s*=\s*\[(.*?)\]", block, re.M | re.S)
    own = [each for each in re.findall(r'"[^"]+"', methods.group(1)) if each.startswith('"atwood/')]
    return block[:methods.start()] + f"methods = [{', '.join(own)}]" + block[methods.end():] if own else ""


def main():
    atwood, study, out = sys.argv[1:]
    with open(study) as file:
        head, *blocks = re.split(r"^(?=\[\[cells\]\])", file.read(), flags=re.M)
    kept = [of_the_suite(block) for block in blocks]
    if not any(old != new for old, new in zip(blocks, kept)):
        sys.exit(f"{study} has no cells with a limit of their own")
    os.makedirs(out, exist_ok=True)
    copy = os.path.join(out, "contact.toml")
    with open(copy, "w") as file:
        file.write(head + "".join(kept))
    os.execv(atwood, [atwood, "run", copy, "--no-timing", "--limit", "300", "--out", out])


main()
