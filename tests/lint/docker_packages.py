#!/usr/bin/env python3
"""The run stage of docker/Dockerfile installs every package whose library the program loads: docker_packages.py PROGRAM.

Meaningful on the release the image is made of; elsewhere the packages have other names and the check is skipped.
"""
import pathlib
import re
import subprocess
import sys
import tree

DOCKERFILE = "docker/Dockerfile"
RELEASE = "VERSION_CODENAME=bookworm"
# In every image of Debian, or brought by others of the list.
GIVEN = {"libc6", "libgcc-s1", "libstdc++6", "zlib1g"}


def on_image_release():
    release = pathlib.Path("/etc/os-release")
    return release.is_file() and RELEASE in release.read_text()


def direct_libraries(program):
    told = subprocess.run(["readelf", "-d", program], capture_output=True, text=True, check=True).stdout
    return re.findall(r"\(NEEDED\).*\[(.+)\]", told)


def package_of(library, loaded):
    path = pathlib.Path(loaded[library]).resolve()
    for candidate in (path, pathlib.Path(str(path).removeprefix("/usr"))):
        told = subprocess.run(["dpkg", "-S", str(candidate)], capture_output=True, text=True, check=False)
        if told.returncode == 0:
            return told.stdout.split(":")[0]
    return None


def check(root, program):
    told = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    loaded = dict(re.findall(r"(\S+) => (/\S+)", told))
    run_stage = (root / DOCKERFILE).read_text().split("FROM ")[-1]
    installed = set(re.findall(r"[\w.+\-]+", run_stage))
    problems = []
    for library in direct_libraries(program):
        if library not in loaded:
            continue
        package = package_of(library, loaded)
        if package not in GIVEN and package not in installed:
            problems.append(f"{DOCKERFILE}: the run stage lacks {package} ({library})")
    return problems


if __name__ == "__main__":
    if on_image_release():
        tree.main("docker packages", lambda root: check(root, sys.argv[1]))
    print("docker packages: skipped, this is not the release of the image")
