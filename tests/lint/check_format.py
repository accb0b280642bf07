#!/usr/bin/env python3
"""Every C++ file is as clang-format would write it; --fix writes it so."""
import re
import subprocess
import sys
import tree

# Versions disagree on details; this is Debian 12's.
MAJOR = 14


def major_version():
    try:
        told = subprocess.run(["clang-format", "--version"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    found = re.search(r"version (\d+)\.", told)
    return int(found.group(1)) if found else None


def unsuitable():
    version = major_version()
    if version == MAJOR:
        return None
    return f"format: skipped, clang-format {MAJOR} is needed and {version or 'none'} is here"


def check(root):
    names = tree.files(root, tree.CPP)
    run = subprocess.run(["clang-format", "--dry-run", "-Werror", *names], cwd=root, capture_output=True, text=True,
                         check=False)
    bad = sorted({line.split(":")[0] for line in run.stderr.splitlines() if "-Wclang-format-violations" in line})
    if run.returncode and not bad:
        return [run.stderr.strip()]
    return [f"{name}: run ./dev format" for name in bad]


def fix(root):
    subprocess.run(["clang-format", "-i", *tree.files(root, tree.CPP)], cwd=root, check=True)


if __name__ == "__main__":
    reason = unsuitable()
    if reason:
        print(reason)
    elif "--fix" in sys.argv:
        fix(tree.ROOT)
    else:
        tree.main("format", check)
