#!/usr/bin/env python3
"""The committed bundle is what its sources and lockfile build: bundle_test.py reports/web. Needs npm and the registry;
answers 77 (skipped) with a word where one is missing. Works in a copy."""
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def main():
    web = pathlib.Path(sys.argv[1])
    if not shutil.which("node") or not shutil.which("npm"):
        print("skipped: Node and npm are not installed, so the bundle cannot be rebuilt here")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "web"
        shutil.copytree(web, copy, ignore=shutil.ignore_patterns("node_modules", "dist"))
        try:
            # The lockfile pins every byte that is installed; install scripts are not needed and not run.
            installed = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--prefer-offline"],
                                       cwd=copy, capture_output=True, text=True, timeout=180)
        except subprocess.TimeoutExpired:
            print("skipped: npm ci did not end within 180 s (is the registry reachable?)")
            return SKIPPED
        if installed.returncode != 0:
            words = installed.stderr.strip()
            if any(sign in words for sign in ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ETIMEDOUT", "ECONNRESET", "ENETUNREACH", "ENOTCACHED")):
                print("skipped: the npm registry is unreachable:", words.splitlines()[-1] if words else "")
                return SKIPPED
            print("npm ci failed:\n" + words)
            return 1
        built = subprocess.run(["node", "build.mjs"], cwd=copy, capture_output=True, text=True, timeout=120)
        if built.returncode != 0:
            print("the bundle does not build:\n" + built.stdout + built.stderr)
            return 1
        for name in ("report.js", "report.css", "pages.js", "player.js", "player.css"):
            if (copy / "dist" / name).read_bytes() != (web / "dist" / name).read_bytes():
                print(f"dist/{name} differs from what its sources build: run `npm ci && npm run build` in reports/web and commit dist/")
                return 1
        checked = subprocess.run(["npm", "run", "--silent", "check"], cwd=copy, capture_output=True, text=True, timeout=120)
        if checked.returncode != 0:
            print("the sources do not pass the type check:\n" + checked.stdout)
            return 1
    print("dist/ is what its sources build")
    return 0


if __name__ == "__main__":
    sys.exit(main())
