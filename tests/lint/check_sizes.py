#!/usr/bin/env python3
"""No source file is longer than a sitting; whoever needs more says why here."""
import tree

LIMIT = 450  # lines
SUFFIXES = tree.CPP + tree.GLSL + (".py", ".cmake", ".txt", ".sh", ".js", ".css", ".html")

# path -> (its own limit, why)
LONGER = {}


def check(root, longer=None):
    longer = LONGER if longer is None else longer
    problems = [f"{name}: excused from the limit, but it does not need to be"
                for name in longer if not (root / name).is_file()]
    for name in tree.files(root, SUFFIXES) + (["dev"] if (root / "dev").is_file() else []):
        count = len(tree.text_of(root, name).splitlines())
        limit = longer.get(name, (LIMIT, ""))[0]
        if count > limit:
            problems.append(f"{name}: {count} lines, the limit is {limit}")
        elif name in longer and count <= LIMIT:
            problems.append(f"{name}: excused from the limit, but it does not need to be")
    return problems


if __name__ == "__main__":
    tree.main("sizes", check)
