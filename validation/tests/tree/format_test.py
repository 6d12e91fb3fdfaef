"""The sources are formatted and their constants named alike: format_test.py ROOT. `.clang-format` is checked with
clang-format 14 (Debian 12's; other versions break lines elsewhere); where it is missing, that part is skipped with a
word, and 77 is answered if nothing else was wrong. Comments, which clang-format leaves as they are, end at column 120.
A constant at namespace scope is named kLikeThis, a trait is_like_this or has_like_this, a constant inside of a function
like_this; tests name the quantities of their scenes as their formulas do."""
import os
import re
import shutil
import subprocess
import sys

SKIPPED = 77
WIDTH = 120
ROOT = sys.argv[1]
FOLDERS = ("engine", "reference", "validation", "benchmarks", "reports")
CONSTANT = re.compile(r"^(?:template\s*<[^>]*>\s*)?(?:inline |static )*constexpr (?P<rest>[^()]*?(?: =|\{)|[^()]*$)")
INNER = re.compile(r"^ +(?:static )?constexpr .*?\b(?P<name>k[A-Z]\w*)(?:\[\w*\])*\s*(?:=(?!=)|\{)")
SCOPE = re.compile(r"^\s*(?:template\s*<.*>\s*)?(?:struct|class|union|namespace)\b")
NAME = re.compile(r"(\w+)(?:<[^<>]*>)?(?:\[\w*\])*\s*(?:=|\{|$)")


def sources():
    for folder in FOLDERS:
        for at, _, names in os.walk(os.path.join(ROOT, folder)):
            if "node_modules" in at:
                continue
            yield from (os.path.join(at, name) for name in names if name.endswith((".cpp", ".hpp")))


def misnamed(path):
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            constant = CONSTANT.match(line.split("//")[0].rstrip())
            name = constant and NAME.search(constant.group("rest"))
            if name and not re.match(r"k[A-Z]", name.group(1)) and not re.match(r"(is|has)_", name.group(1)):
                yield f"{os.path.relpath(path, ROOT)}:{number}: the constant `{name.group(1)}` should be named kLikeThis"


def misnamed_in_functions(path):
    """Constants that are named kLikeThis inside of a function: the line before them that is indented less begins neither
    a class nor a namespace."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    indents = [len(line) - len(line.lstrip()) for line in lines]
    for number, line in enumerate(lines):
        constant = INNER.match(line.split("//")[0])
        if not constant:
            continue
        around = next(lines[i] for i in range(number - 1, -1, -1) if lines[i].strip() and indents[i] < indents[number]
                      and not re.match(r" *(?:public|private|protected):|#", lines[i]))
        if not SCOPE.match(around):
            yield (f"{os.path.relpath(path, ROOT)}:{number + 1}: the constant `{constant.group('name')}` of a function "
                   "should be named like_this")


def too_wide(path):
    """Comments that go beyond column 120; long string literals are no fault, for clang-format decides about code."""
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if len(line.rstrip("\n")) > WIDTH and re.search(r'(?:^|[\s;{},)])//(?![^"]*"[^"]*$)', line):
                yield f"{os.path.relpath(path, ROOT)}:{number}: the comment goes beyond column {WIDTH}"


def clang_format():
    for program in ("clang-format-14", "clang-format"):
        found = shutil.which(program)
        if found and " 14." in subprocess.run([found, "--version"], capture_output=True, text=True).stdout:
            return found
    return None


def main():
    every = sorted(sources())
    if len(every) < 500:
        print(f"{len(every)} sources in {ROOT}; expected the tree")
        return 1
    faults = [fault for path in every if "/tests/" not in path for check in (misnamed, misnamed_in_functions)
              for fault in check(path)]
    faults += [fault for path in every for fault in too_wide(path)]
    print("\n".join(faults), end="\n" if faults else "")
    program = clang_format()
    if program is None:
        print("skipped: clang-format 14 is not installed")
        return 1 if faults else SKIPPED
    checked = subprocess.run([program, "--dry-run", "-Werror", "--ferror-limit=1", *every], capture_output=True, text=True)
    if checked.returncode != 0:
        files = sorted(set(re.findall(r"^(\S+?):\d+:\d+: error", checked.stderr, re.M)))
        print("\n".join(f"{os.path.relpath(path, ROOT)} is not formatted: clang-format -i {os.path.relpath(path, ROOT)}"
                        for path in files) or checked.stderr[:2000])
        return 1
    print(f"{len(every)} sources are formatted")
    return 1 if faults else 0


sys.exit(main())
