#!/usr/bin/env python3
"""Every #include goes to the file's own floor or below, every outside header stands where floors.txt allows it."""
import fnmatch
import re
import tree

TABLE = "tests/lint/floors.txt"
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')
# <vector>, <cstdint>: a standard header has neither a folder nor a suffix.
STANDARD = re.compile(r"^[a-z0-9_]+$")
# Written by the build: furnace_embed() in shaders/embed.cmake.
GENERATED = re.compile(r"^embedded_\w+\.hpp$")
COMMENT_OR_STRING = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.S)


class Table:
    def __init__(self, text):
        self.floors, self.headers, self.tokens = {}, [], []
        for line in text.splitlines():
            if not line.strip() or line.startswith("#"):
                continue
            kind, rest = line.split(None, 1)
            if kind == "floor":
                folder, number, *also = rest.split()
                self.floors[folder] = (int(number), [name.lstrip("+") for name in also])
            else:
                # A regex may hold colons; the separator stands alone.
                what, _, where = (rest + " ").partition(" : ")
                row = (what.strip().removesuffix(" :"), where.split())
                {"header": self.headers, "token": self.tokens}[kind].append(row)

    def folder_of(self, name):
        matches = [folder for folder in self.floors if name.startswith(folder + "/")]
        return max(matches, key=len, default=None)


def allowed(name, patterns):
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def check_project_include(table, root, name, target):
    own, other = table.folder_of(name), table.folder_of(target)
    if not (root / target).is_file():
        return f"there is no {target}; paths are from the root"
    if other is None:
        return f"{target} is on no floor"
    if own == other or other in table.floors[own][1] or other == "shaders":
        return None
    if table.floors[other][0] < table.floors[own][0]:
        return None
    return f"{own} (floor {table.floors[own][0]}) may not include {target} (floor {table.floors[other][0]})"


def check_outside_include(table, name, header):
    if STANDARD.match(header):
        return None
    for pattern, places in table.headers:
        if fnmatch.fnmatchcase(header, pattern):
            return None if allowed(name, places) else f"<{header}> may only be included by: {' '.join(places)}"
    return f"<{header}> may not be included: it is not in {TABLE}"


def check_tokens(table, name, text):
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group())

    plain = COMMENT_OR_STRING.sub(lambda m: m.group() if m.group().startswith('"shaders/') else blank(m), text)
    for pattern, places in table.tokens:
        if allowed(name, places):
            continue
        for match in re.finditer(pattern, plain):
            line = plain.count("\n", 0, match.start()) + 1
            where = " ".join(places) or "nobody"
            yield f"{name}:{line}: {match.group()} may only be used by: {where}"


def check(root):
    table = Table((root / TABLE).read_text())
    problems = []
    for name in tree.files(root, tree.CPP):
        if table.folder_of(name) is None:
            problems.append(f"{name}: is on no floor of {TABLE}")
            continue
        text = tree.text_of(root, name)
        for number, line in enumerate(text.splitlines(), 1):
            include = INCLUDE.match(line)
            if not include or (include.group(1) and GENERATED.match(include.group(1))):
                continue
            if include.group(1):
                problem = check_project_include(table, root, name, include.group(1))
            else:
                problem = check_outside_include(table, name, include.group(2))
            if problem:
                problems.append(f"{name}:{number}: {problem}")
        problems += check_tokens(table, name, text)
    return problems


if __name__ == "__main__":
    tree.main("floors", check)
