"""Runs a benchmark executable once, briefly: smoke_test.py PROGRAM ARGUMENTS... It must end with 0 and print JSON with at
least one figure above 0. Nothing is asserted about how large a figure is."""
import json
import subprocess
import sys

program, arguments = sys.argv[1], sys.argv[2:]
if any(word.startswith("--benchmark_filter") for word in arguments):
    arguments += ["--benchmark_min_time=1e-9", "--benchmark_format=json"]
ended = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=900)
if ended.returncode != 0:
    sys.exit(f"{program} ended with {ended.returncode}: {ended.stderr.strip()[-2000:]}")
if "{" not in ended.stdout:
    sys.exit(f"no benchmark ran: {ended.stderr.strip()[-2000:]}")
found = json.loads(ended.stdout[ended.stdout.index("{"):])
if "tables" in found:
    figures = [cell for table in found["tables"] for row in table["rows"] for cell in row if isinstance(cell, (int, float))]
else:
    figures = [run["cpu_time"] for run in found["benchmarks"] if not run.get("error_occurred")]
    failed = [run["name"] for run in found["benchmarks"] if run.get("error_occurred") and "not timed" not in run["error_message"]]
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")
if not any(figure > 0 for figure in figures):
    sys.exit(f"no figure above 0 among {len(figures)}")
print(f"{len(figures)} figures")
