#!/usr/bin/env python3
"""Every shader stage compiles in glslangValidator, without features, with each one and with all of them.

Expands as renderer/gl/shader_library.cpp does: includes once, in place; cycles and unknown features are refused.
"""
import re
import shutil
import subprocess
import tree

FEATURES_PATH = "interface/features.glsl"
FEATURE_ROW = re.compile(r"^// (FEATURE_\w+)\s+\S.*$")
FEATURE_TOKEN = re.compile(r"\bFEATURE_\w*")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"\s*$')
STAGES = {".vert": "vert", ".frag": "frag", ".comp": "comp"}


class ShaderError(Exception):
    pass


class Expansion:
    """The text of one stage, and where each of its lines came from."""

    def __init__(self, shaders, features):
        self.shaders, self.features = shaders, features
        self.lines, self.places, self.chain, self.done = [], [], [], set()

    def append(self, path):
        if path in self.chain:
            raise ShaderError(f"includes form a cycle: {' -> '.join(self.chain + [path])}")
        if path in self.done:
            return
        if not (self.shaders / path).is_file():
            raise ShaderError(f"{self.chain[-1] if self.chain else path}: there is no shaders/{path}")
        self.chain.append(path)
        for number, line in enumerate((self.shaders / path).read_text().splitlines(), 1):
            include = INCLUDE.match(line)
            if include:
                self.append(include.group(1))
                continue
            for token in FEATURE_TOKEN.findall(line):
                if token not in self.features:
                    raise ShaderError(f"shaders/{path}:{number}: {token} is not in shaders/{FEATURES_PATH}")
            self.lines.append(line)
            self.places.append(f"shaders/{path}:{number}")
        self.chain.pop()
        self.done.add(path)


def feature_names(shaders):
    rows = [FEATURE_ROW.match(line) for line in (shaders / FEATURES_PATH).read_text().splitlines()]
    return [row.group(1) for row in rows if row]


def variants(features):
    """Name -> the features that are 1: none, all, and each alone."""
    sets = {"no feature": set(), "every feature": set(features)}
    sets.update({name: {name} for name in features})
    return sets


def validate(stage, expansion, on):
    head = ["#version 450 core"] + [f"#define {name} {int(name in on)}" for name in expansion.features]
    run = subprocess.run(["glslangValidator", "--stdin", "-S", stage], input="\n".join(head + expansion.lines) + "\n",
                         capture_output=True, text=True, check=False)
    if run.returncode == 0:
        return []

    def place(match):
        at = int(match.group(1)) - len(head) - 1
        return expansion.places[at] + ":" if 0 <= at < len(expansion.places) else match.group()

    return [re.sub(r"\b0:(\d+):", place, line) for line in run.stdout.splitlines() if line.startswith("ERROR: 0:")]


def check(root):
    shaders = root / "shaders"
    features = feature_names(shaders)
    problems = []
    for name in tree.files(root, STAGES):
        if not name.startswith("shaders/"):
            continue
        path = name.removeprefix("shaders/")
        expansion = Expansion(shaders, features)
        try:
            expansion.append(path)
        except ShaderError as error:
            problems.append(str(error))
            continue
        used = {token for line in expansion.lines for token in FEATURE_TOKEN.findall(line)}
        for label, on in variants([name for name in features if name in used]).items():
            stage = STAGES["." + path.rsplit(".", 1)[1]]
            problems += [f"{path} with {label}: {line}" for line in validate(stage, expansion, on)]
    return problems


if __name__ == "__main__":
    if shutil.which("glslangValidator"):
        tree.main("shaders", check)
    print("shaders: skipped, there is no glslangValidator here (package glslang-tools)")
