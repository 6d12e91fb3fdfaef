#!/usr/bin/env python3
"""The runs of the study `determinism`, made by our engine's worker under other circumstances: each vector width forced, in the
engine and in the C library, other numbers of threads, locales and folders, and other builds of the engine. Every number of
every sample must have the same bits; samples are compared as the worker writes them, with all their digits.

    python3 validation/tests/campaigns/same_bits.py BUILD_FOLDER SOURCE_FOLDER [--build 'COMPILER FLAGS']... [--builds-only]
        [--build-folder DIR]

--build 'clang++ -O1' builds the engine alone with that compiler and these flags, in a folder of its own (kept, so that the
next call compiles only what changed), and its warnings are errors there too. --builds-only leaves the other circumstances
out. Answers 77 (skipped) with a word where such a compiler is not installed.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

SKIPPED = 77
# What the C library would choose its functions by (sin, exp, pow, memcpy).
NARROW_LIBRARY = "glibc.cpu.hwcaps=" + ",".join("-" + f for f in ("AVX2", "AVX2_Usable", "FMA", "FMA_Usable", "FMA4", "FMA4_Usable",
                                                                 "AVX512F", "AVX512VL", "ERMS", "AVX_Fast_Unaligned_Load"))


def cells_of(source):
    with open(os.path.join(source, "validation/study/determinism.toml"), "rb") as file:
        study = tomllib.load(file)
    for group in study["cells"]:
        for scenario in group["scenarios"]:
            for method in group["methods"]:
                yield scenario, method, group.get("steps")


def requests_of(program, source):
    """The lines that ask for every run, and what each is called."""
    described, names, lines = {}, [], []
    for scenario, method, steps in cells_of(source):
        if scenario not in described:
            told = subprocess.run([program, "describe", scenario, "--json"], capture_output=True, text=True, check=True)
            described[scenario] = json.loads(told.stdout)
        told = described[scenario]
        for count in steps or told["run"]["steps"]:
            names.append(f"{scenario} {method} {count}")
            lines.append({"request": "run", "cell": len(lines), "method": method, "pass": "accuracy", "t_end_s": told["run"]["t_end_s"],
                          "steps": count, "samples": told["run"]["samples"], "scene": told["scene"]})
    return names, lines


def hashes_of(worker, lines, environment, folder, threads=None):
    """By cell: the hash of its samples, or how it ended."""
    asked = [json.dumps({**line, "method": re.sub(r"threads=\d+", f"threads={threads}", line["method"]) if threads else line["method"]})
             for line in lines]
    ended = subprocess.run([worker], input="\n".join(asked) + "\n", capture_output=True, text=True, cwd=folder,
                           env={**os.environ, **environment}, timeout=1800)
    if ended.returncode != 0:
        raise SystemExit(f"FAILED: {worker} ended with {ended.returncode}: {ended.stderr[-500:]}")
    found = [hashlib.sha256() for _ in lines]
    outcome = [None] * len(lines)
    for line in ended.stdout.splitlines():
        answer = json.loads(line)
        if "done" in answer:
            outcome[answer["cell"]] = (answer["done"]["status"], answer["done"].get("reason", ""), answer["done"].get("steps_taken"))
        else:
            found[answer["cell"]].update(line.encode())
    return [(o, h.hexdigest()) for o, h in zip(outcome, found)]


def built(words, source, folder):
    compiler, *flags = words.split()
    if not shutil.which(compiler):
        print(f"skipped: {compiler} is not installed")
        raise SystemExit(SKIPPED)
    place = os.path.join(folder, re.sub(r"[^A-Za-z0-9]+", "-", words).strip("-"))
    more = ["-DCMAKE_CXX_FLAGS=-w"]  # levels of optimisation differ in what GCC takes for uninitialised
    if "clang" in compiler:  # quadmath.h is GCC's; -idirafter keeps clang's intrinsics before GCC's
        headers = subprocess.run(["g++", "-print-file-name=include"], capture_output=True, text=True, check=True).stdout.strip()
        more = [f"-DCMAKE_CXX_FLAGS=-idirafter {headers}", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON"]  # each source includes what it needs
    for command in (["cmake", "-S", source, "-B", place, "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler}", "-DCMAKE_BUILD_TYPE=Release",
                     f"-DCMAKE_CXX_FLAGS_RELEASE={' '.join(flags)} -DNDEBUG", *more],
                    ["ninja", "-C", place, "-j", str(os.cpu_count()), "atwood-engine"]):
        made = subprocess.run(command, capture_output=True, text=True)
        if made.returncode != 0:
            raise SystemExit(f"FAILED: {' '.join(command)}\n{made.stdout[-3000:]}{made.stderr[-3000:]}")
    return os.path.join(place, "bin", "atwood-engine")


def has_avx512():
    with open("/proc/cpuinfo") as file:
        flags = next((line.split() for line in file if line.startswith("flags")), [])
    return {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= set(flags)


def circumstances(ours, scratch, odd):
    """The same program otherwise called: by name the worker, what it adds to the environment, its folder and its threads."""
    widths = ["narrow", "v3", "v4"]
    if not has_avx512():  # the worker would take the widest that there is
        print("vectors v4: skipped, this processor has no AVX-512")
        widths.remove("v4")
    variants = {f"vectors {width}": (ours, {"ATWOOD_VECTOR_WIDTH": width}, scratch, None) for width in widths}
    variants["the C library without AVX and FMA"] = (ours, {"GLIBC_TUNABLES": NARROW_LIBRARY}, scratch, None)
    variants["another folder and locale"] = (ours, {"LC_ALL": "C", "LANG": "de_DE.UTF-8", "TZ": "Asia/Kathmandu"}, odd, None)
    for threads in (1, 16):
        variants[f"{threads} thread{'' if threads == 1 else 's'}"] = (ours, {}, scratch, threads)
    return variants


def main():
    options = argparse.ArgumentParser()
    options.add_argument("build")
    options.add_argument("source")
    options.add_argument("--build", dest="others", action="append", default=[])
    options.add_argument("--builds-only", action="store_true")
    options.add_argument("--build-folder", default=None)
    given = options.parse_args()
    ours = os.path.join(os.path.abspath(given.build), "bin", "atwood-engine")
    names, lines = requests_of(os.path.join(given.build, "bin", "atwood"), given.source)
    with tempfile.TemporaryDirectory() as scratch:
        odd = os.path.join(scratch, "a folder, with a comma")
        os.mkdir(odd)
        first = hashes_of(ours, lines, {}, scratch)
        refused = [f"{name}: {outcome}" for name, (outcome, _) in zip(names, first) if outcome is None or outcome[0] != "ok"]
        variants = {} if given.builds_only else circumstances(ours, scratch, odd)
        for words in given.others:
            worker = built(words, given.source, given.build_folder or os.path.join(given.build, "same-bits"))
            variants[words] = (worker, {}, scratch, None)
        wrong = list(refused)
        with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            others = list(pool.map(lambda how: hashes_of(how[0], lines, *how[1:]), variants.values()))
        for variant, other in zip(variants, others):
            differ = [name for name, a, b in zip(names, first, other) if a != b]
            print(f"{variant}: {len(names) - len(differ)} of {len(names)} runs have the same bits", flush=True)
            wrong += [f"{variant}: {name}" for name in differ]
    if wrong:
        print("FAILED:\n" + "\n".join(wrong))
    print(f"hash of all runs: {hashlib.sha256(json.dumps([h for _, h in first]).encode()).hexdigest()[:16]}")
    return 1 if wrong else 0


sys.exit(main())
