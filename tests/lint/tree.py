"""What every check shares: the files of the tree, and how a check is run and reports."""
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def files(root, suffixes=None):
    """Paths relative to `root` of all files git knows or would add; without git, of all but build/."""
    listed = subprocess.run(
        ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        capture_output=True, check=False)
    if (root / ".git").exists() and listed.returncode == 0:
        names = [name for name in listed.stdout.decode().split("\0") if name]
    else:
        names = [str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()]
        names = [name for name in names if not name.startswith(("build/", ".git/"))]
    return sorted(name for name in set(names)
                  if (root / name).is_file() and (suffixes is None or name.endswith(tuple(suffixes))))


CPP = (".cpp", ".hpp")
GLSL = (".glsl", ".vert", ".frag", ".comp")


def text_of(root, name):
    """The file's text, or None for a binary file."""
    try:
        return (root / name).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return None


def main(title, check):
    """Runs `check(root) -> list of problems` over the real tree."""
    problems = check(ROOT)
    for problem in problems:
        print(problem)
    print(f"{title}: {len(problems)} problems" if problems else f"{title}: ok")
    sys.exit(1 if problems else 0)
