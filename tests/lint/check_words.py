#!/usr/bin/env python3
"""No notes to self, no code switched off, nothing that is true on one machine only."""
import re
import tree

# The words are put together here so that this file does not hold them.
NOTES = re.compile(r"\b(TO" + r"DO|FIX" + r"ME|XX" + r"X|HA" + r"CK)\b")
SWITCHED_OFF = re.compile(r"^\s*#\s*if\s+0\b")
MACHINE_PATH = re.compile(r"(?<![\w.\-/])/(work|home|root|Users|mnt|tmp/[\w.]+)/")
HOST = re.compile(r"\bhttps?://((?:[A-Za-z0-9\-]+\.)+[A-Za-z]{2,})\b")

# Hosts that a reader may be sent to, or that name a specification. Everything else needs a row.
KNOWN_HOSTS = {
    "json-schema.org", "ns.adobe.com", "www.apache.org", "www.w3.org",
    "github.com", "gcc.gnu.org", "jcgt.org", "registry.khronos.org", "www.khronos.org", "www.rfc-editor.org",
}
# Names that nobody can have (RFC 2606).
RESERVED = re.compile(r"(^|\.)example(\.com|\.org)?$")
# The licence's own text is not ours to edit.
PASSED_OVER = ("LICENSE",)


def problems_of_line(line):
    note = NOTES.search(line)
    if note:
        yield f"{note.group()} belongs in the tracker"
    if SWITCHED_OFF.match(line):
        yield "code that is switched off: git remembers it"
    path = MACHINE_PATH.search(line)
    if path:
        yield f"{path.group()} is a path of one machine"
    for host in HOST.findall(line):
        if host not in KNOWN_HOSTS and not RESERVED.search(host):
            yield f"{host} is not among the hosts that tests/lint/check_words.py knows"


def check(root):
    problems = []
    for name in tree.files(root):
        text = None if name in PASSED_OVER else tree.text_of(root, name)
        for number, line in enumerate((text or "").splitlines(), 1):
            problems += [f"{name}:{number}: {problem}" for problem in problems_of_line(line)]
    return problems


if __name__ == "__main__":
    tree.main("words", check)
