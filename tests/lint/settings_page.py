#!/usr/bin/env python3
"""server/settings.md says what the program says of itself: settings_page.py [--fix] PROGRAM."""
import re
import subprocess
import sys
import tree

PAGE = "server/settings.md"
ENTRY = re.compile(r"# (?P<help>.+?)(?: \[(?P<choices>[^\]]+)\])?\n# (?P<variable>FURNACE_\w+), from: default\n"
                   r"(?P<name>[\w\-]+) = (?P<value>.*)\n")
HEAD = """# Settings

Of `furnace serve`; `./dev settings` writes this page from the program's table (`server/settings.cpp`), a test compares the
two. A setting is given as a flag (`--queue 8`), as a variable (`FURNACE_QUEUE=8`) or in a file of lines `queue = 8`
(`--config FILE` or `FURNACE_CONFIG`); flags win over variables, variables over the file. Sizes take `KiB`, `MiB`, `GiB`,
times `ms`, `s`, `min`. `furnace check-config` prints what all of it comes to; a wrong value stops the start with every
problem listed.

| Flag and variable | Default | What it sets |
| --- | --- | --- |
"""


def escaped(text):
    return text.replace("|", "\\|")


def page(program):
    told = subprocess.run([program, "check-config"], env={}, capture_output=True, text=True, check=True).stdout
    rows = ["| `--{name}`<br>`{variable}` | {value} | {help}{choices} |".format(
        name=entry["name"], variable=entry["variable"], value=f"`{entry['value']}`" if entry["value"] else "none",
        help=escaped(entry["help"]), choices=f" (`{escaped(entry['choices'])}`)" if entry["choices"] else "")
        for entry in ENTRY.finditer(told)]
    count = told.count(", from: default\n")
    if not rows or len(rows) != count:
        sys.exit(f"{PAGE}: {len(rows)} of {count} settings of check-config were understood")
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    wanted = page(sys.argv[-1])
    path = tree.ROOT / PAGE
    if "--fix" in sys.argv:
        path.write_text(wanted)
    else:
        same = path.is_file() and path.read_text() == wanted
        tree.main("settings page", lambda root: [] if same else [f"{PAGE}: run ./dev settings"])
