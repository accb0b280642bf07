"""Holds the served /openapi.json against the rules of openapi_lint/redocly.yaml: openapi_lint.py FURNACE FOLDER [--required].

Redocly CLI (MIT) has no dependencies, and is fetched by npm into FOLDER once; package-lock.json has its version and hash.
Where it cannot run, that is said and the exit status is 77; with --required it is a failure."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from http_support import Server

HERE = pathlib.Path(__file__).resolve().parent / "openapi_lint"
PACKAGE = "@redocly/cli"
OLDEST_NODE = (20, 19)
SKIPPED = 77
# Nothing is told to its makers, nor asked of them.
QUIET = {"REDOCLY_TELEMETRY": "off", "REDOCLY_SUPPRESS_NOTIFICATIONS": "true"}


class CannotRun(Exception):
    pass


def check_node():
    for program in ("node", "npm"):
        if not shutil.which(program):
            raise CannotRun(f"there is no {program} here")
    told = subprocess.run(["node", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    if tuple(map(int, re.findall(r"\d+", told)[:2])) < OLDEST_NODE:
        raise CannotRun(f"node is {told}; the linter needs {'.'.join(map(str, OLDEST_NODE))}")


def installed(folder):
    """The linter's script, fetched unless it is there."""
    package = folder / "node_modules" / PACKAGE
    wanted = json.loads((HERE / "package.json").read_text())["dependencies"][PACKAGE]
    about = package / "package.json"
    if not about.is_file() or json.loads(about.read_text())["version"] != wanted:
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("package.json", "package-lock.json"):
            shutil.copy(HERE / name, folder)
        done = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=folder, capture_output=True, text=True,
                              check=False)
        if done.returncode != 0:
            raise CannotRun(f"npm could not fetch {PACKAGE}:\n{done.stderr[-2000:]}")
    return package / "bin" / "cli.js"


def main():
    folder = pathlib.Path(sys.argv[1])
    try:
        check_node()
        linter = installed(folder)
    except CannotRun as why:
        print(f"SKIPPED: the OpenAPI linter: {why}")
        return 1 if "--required" in sys.argv else SKIPPED
    with Server() as server:
        (folder / "openapi.json").write_bytes(server.curl("/openapi.json").body)
    return subprocess.run(["node", linter, "lint", folder / "openapi.json", "--config", HERE / "redocly.yaml", "--max-problems", "1000"],
                          env={**os.environ, **QUIET}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
