#!/usr/bin/env python3
"""Gives the readers bytes of any content: builds the fuzz targets (validation/tests/fuzz) with Clang's libFuzzer and sanitizers
in a build folder of its own, and runs each for some seconds or runs, from the kept corpus and what earlier campaigns found.

    python3 validation/tests/campaigns/fuzz.py [--seconds 60 | --runs N] [--targets scene-toml,answer] [--logs build/fuzz-logs]

The log folder keeps for each target the corpus that grew (corpus/TARGET), inputs that failed (crashes/TARGET) and one line a
run of a target (runs.tsv): a campaign goes on where the last one ended, and the totals are those of all. Inputs may take 2 s
and 1 GB. Exit code 1 where an input failed, 77 where Clang's libFuzzer is missing."""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
KEPT = os.path.join(ROOT, "validation", "tests", "fuzz", "corpus")
SKIPPED = 77
LIMITS = ["-rss_limit_mb=1024", "-timeout=2", "-max_len=16384", "-print_final_stats=1"]
WORDS = {"scene-toml": "scene.dict", "study": "settings.dict", "gates": "settings.dict", "contact-cases": "scene.dict",
         "scene-json": "scene.dict", "request": "scene.dict", "answer": "wire.dict", "hello": "wire.dict", "field": "wire.dict",
         "urdf": "urdf.dict", "mjcf": "urdf.dict"}


def find_clang():
    """A clang++ that can link libFuzzer, or nothing."""
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(folder, "f.cpp")
        with open(source, "w") as file:
            file.write('extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }\n')
        for name in ("clang++-14", "clang++"):
            if not shutil.which(name):
                continue
            tried = subprocess.run([name, "-fsanitize=fuzzer,address,undefined", source, "-o", source + ".out"], capture_output=True)
            if tried.returncode == 0:
                return name
    return None


def build(folder, jobs):
    clang = find_clang()
    if not clang:
        print("skipped: no clang++ with libFuzzer and sanitizers (Debian: clang-14, libclang-rt-14-dev)")
        sys.exit(SKIPPED)
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=" + clang, "-DCMAKE_BUILD_TYPE=Release",
                    "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DATWOOD_FUZZ=ON", "-DATWOOD_WARNINGS_AS_ERRORS=OFF"],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", folder, f"-j{jobs}", "fuzz_targets"], check=True, stdout=subprocess.DEVNULL)


def targets_of(folder):
    programs = os.path.join(folder, "validation", "tests", "fuzz")
    return {name[len("fuzz-"):]: os.path.join(programs, name) for name in sorted(os.listdir(programs))
            if name.startswith("fuzz-") and os.access(os.path.join(programs, name), os.X_OK)}


def fuzz_once(name, program, logs, amount):
    """One process of a target, until the amount of time or runs is used up or an input fails: how many runs, what failed."""
    grown, crashes = os.path.join(logs, "corpus", name), os.path.join(logs, "crashes", name)
    os.makedirs(grown, exist_ok=True)
    os.makedirs(crashes, exist_ok=True)
    before = set(os.listdir(crashes))
    command = [program, *LIMITS, f"-artifact_prefix={crashes}/", grown, os.path.join(KEPT, name), amount]
    if name in WORDS:
        command.append("-dict=" + os.path.join(os.path.dirname(KEPT), WORDS[name]))
    environment = {**os.environ, "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1"}
    log = os.path.join(logs, name + ".log")
    with open(log, "w") as file:
        ended = subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, env=environment)
    with open(log, errors="replace") as file:
        text = file.read()
    counted = re.findall(r"stat::number_of_executed_units: (\d+)", text) or re.findall(r"^#(\d+)\t", text, re.M)
    # libFuzzer keeps slow inputs too, which are within the limit.
    failed = sorted(each for each in set(os.listdir(crashes)) - before if not each.startswith("slow-unit"))
    if ended.returncode != 0 and not failed:
        failed = [f"exit code {ended.returncode}: {log}"]
    return int(counted[-1]) if counted else 0, failed


def is_slow_again(program, path):
    """Whether an input that took too long does so again: libFuzzer's clock goes on while the machine does something else."""
    return all(subprocess.run([program, *LIMITS, path], capture_output=True).returncode != 0 for _ in range(3))


def run_target(name, program, logs, seconds, runs):
    """Runs until the time or the number of runs is used up, or an input fails; how many runs, how long, what failed."""
    begun, count = time.monotonic(), 0
    while True:
        left = runs - count if runs else int(begun + seconds - time.monotonic())
        if left <= 0:
            return count, time.monotonic() - begun, []
        ran, failed = fuzz_once(name, program, logs, f"-runs={left}" if runs else f"-max_total_time={left}")
        count += ran
        for each in [each for each in failed if each.startswith("timeout-")]:
            path = os.path.join(logs, "crashes", name, each)
            if not is_slow_again(program, path):
                os.remove(path)
                failed.remove(each)
        if failed:
            return count, time.monotonic() - begun, failed


def totals(path):
    runs, hours = {}, {}
    if os.path.exists(path):
        with open(path) as file:
            for line in file:
                name, count, seconds = line.split("\t")[:3]
                runs[name] = runs.get(name, 0) + int(count)
                hours[name] = hours.get(name, 0.0) + float(seconds) / 3600
    return runs, hours


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=60, help="of each target (60)")
    parser.add_argument("--runs", type=int, default=0, help="of each target, instead of seconds")
    parser.add_argument("--targets", default="", help="some of them, separated by commas (all)")
    parser.add_argument("--build", default=os.path.join(ROOT, "build", "fuzz"))
    parser.add_argument("--logs", default=os.path.join(ROOT, "build", "fuzz-logs"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="of the compiler")
    parser.add_argument("--no-build", action="store_true", help="the targets are built already")
    options = parser.parse_args()
    options.logs = os.path.abspath(options.logs)
    if not options.no_build:
        build(options.build, options.jobs)
    programs = targets_of(options.build)
    chosen = options.targets.split(",") if options.targets else list(programs)
    unknown = [name for name in chosen if name not in programs]
    if unknown:
        sys.exit(f"no target {', '.join(unknown)}; there are {', '.join(programs)}")
    os.makedirs(options.logs, exist_ok=True)
    table = os.path.join(options.logs, "runs.tsv")
    failures = []
    for name in chosen:
        count, seconds, failed = run_target(name, programs[name], options.logs, options.seconds, options.runs)
        with open(table, "a") as file:
            file.write(f"{name}\t{count}\t{seconds:.1f}\t{len(failed)}\n")
        failures += [f"{name}: {each}" for each in failed]
        print(f"{name:<14} {count:>12} runs {seconds:>8.0f} s  {', '.join(failed) or 'nothing failed'}", flush=True)
    runs, hours = totals(table)
    print("\nof all campaigns in this log folder:")
    for name in sorted(runs):
        print(f"{name:<14} {runs[name]:>12} runs {hours[name]:>8.2f} h")
    print(f"{'in total':<14} {sum(runs.values()):>12} runs {sum(hours.values()):>8.2f} h")
    if failures:
        print("\nfailed:\n" + "\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
