"""Clang compiles the product as well as GCC does: clang.py BUILD_FOLDER ROOT [FOLDER...]. Checks the syntax and types of
every source of these folders (engine/, reference/, validation/ and reports/ unless given), tests and what the build wrote
left out, with the build's own flags; generates no code. Answers 77 (skipped)
with a word where clang++ is missing."""
import concurrent.futures
import json
import os
import shlex
import shutil
import subprocess
import sys

SKIPPED = 77
build, root = sys.argv[1], sys.argv[2]
folders = sys.argv[3:] or ["engine", "reference", "validation", "reports"]
# quadmath.h is GCC's own; -idirafter keeps clang's intrinsics before GCC's.
GCC_HEADERS = subprocess.run(["g++", "-print-file-name=include"], capture_output=True, text=True).stdout.strip()
# Flags that only GCC knows.
DROPPED = ("-Wno-maybe-uninitialized", "-Wno-restrict", "-Wno-subobject-linkage", "-Wno-stringop-overflow", "-Wno-stringop-overread",
           "-fpch-preprocess", "-Winvalid-pch")


def command_of(entry):
    words = shlex.split(entry["command"])
    while words[0].endswith("ccache"):
        words.pop(0)
    kept, skip = [], False
    for word, following in zip(words[1:], [*words[2:], ""]):
        if skip or word in DROPPED or word.startswith("-O"):
            skip = False
        elif word == "-include" and following.endswith("cmake_pch.hxx"):  # compiled by GCC; sources include what they need
            skip = True
        elif word in ("-o", "-c"):
            skip = word == "-o"
        else:
            kept.append(word)
    # & of comparisons vectorises where && would branch.
    return ["clang++", "-fsyntax-only", "-idirafter", GCC_HEADERS, *kept, "-Wno-bitwise-instead-of-logical"]


def fault_of(entry):
    ended = subprocess.run(command_of(entry), cwd=entry["directory"], capture_output=True, text=True)
    return "" if ended.returncode == 0 else f"{os.path.relpath(entry['file'], root)}:\n{ended.stderr[:2000]}"


def main():
    if not shutil.which("clang++"):
        print("skipped: clang++ is not installed")
        return SKIPPED
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    chosen = {}
    for entry in entries:
        # Files that are compiled several at a time are named by a file of the build tree, in a folder of the same name.
        path = os.path.relpath(entry["file"], build if entry["file"].startswith(build + os.sep) else root)
        if path.endswith("cmake_pch.hxx.cxx"):
            continue
        if any(path.startswith(folder + "/") for folder in folders) and not path.startswith("validation/tests/"):
            chosen.setdefault(entry["file"], entry)
    if not chosen:
        print("no source of", ", ".join(folders), "in", build)
        return 1
    with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        faults = [fault for fault in pool.map(fault_of, chosen.values()) if fault]
    print("\n".join(faults) if faults else f"clang compiles all {len(chosen)} sources")
    return 1 if faults else 0


sys.exit(main())
