#!/usr/bin/env python3
"""Runs fuzz targets: `short` for the tests, the same each time, `long` for findings. The working directory is the source root.

fuzz.py short PROGRAM TARGET            the inputs that once were findings, the seeds, then some changes of them
fuzz.py long PROGRAM SECONDS [TARGET]   one target or all, as many at once as there are cores
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
REGRESSIONS = HERE / "regressions"
KEPT = pathlib.Path("build/fuzz")  # corpora that grew, findings, logs

# Changed inputs of a short run: a second or two each.
SHORT_RUNS = 1000
SHORTER_RUNS = {"gltf": 200, "glb": 200, "inspect": 150, "accessor": 500, "request": 200, "inspect_request": 200, "batch": 200, "obj": 200}

FLAGS = ("-timeout=10", "-rss_limit_mb=1024", "-print_final_stats=1", "-verbosity=1")
ENVIRONMENT = {"LSAN_OPTIONS": f"suppressions={HERE / 'leaks.supp'}:print_suppressions=0",
               "ASAN_OPTIONS": "detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=0",
               "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1"}


class Run:
    """One process of libFuzzer and what its log says."""

    def __init__(self, program, target, findings, folders, flags, log):
        seeds = program.parent / "seeds"
        words = seeds / f"{target}.dict"
        command = [program, f"--target={target}", f"-artifact_prefix={findings}/", *FLAGS, *flags]
        if words.exists():
            command.append(f"-dict={words}")
        command += [folder for folder in folders if folder.is_dir()]
        with open(log, "ab") as out:
            begin = out.tell()
            self.status = subprocess.run(command, stdout=out, stderr=out, stdin=subprocess.DEVNULL, check=False,
                                         env={**os.environ, **ENVIRONMENT}).returncode
        self.text = log.read_bytes()[begin:].decode(errors="replace")

    def number(self, pattern):
        found = re.findall(pattern, self.text)
        return int(found[-1]) if found else 0

    @property
    def executions(self):
        return self.number(r"number_of_executed_units:\s*(\d+)") or self.number(r"#(\d+)\s")

    @property
    def edges(self):
        return self.number(r"cov: (\d+)")

    @property
    def finding(self):
        found = re.search(r"Test unit written to (\S+)", self.text)
        return found.group(1) if found else None


def sources_of(program, target):
    return [REGRESSIONS / target, program.parent / "seeds" / target]


def short(program, target):
    sources = sources_of(program, target)
    known = sum(len(list(folder.iterdir())) for folder in sources if folder.is_dir())
    runs = known + SHORTER_RUNS.get(target, SHORT_RUNS)
    findings = KEPT / "findings" / target
    findings.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        new = pathlib.Path(folder) / "new"  # libFuzzer writes to the first
        new.mkdir()
        run = Run(program, target, findings, [new, *sources], ["-seed=1", f"-runs={runs}"],
                  pathlib.Path(folder) / "log")
    print(f"{target}: {run.executions} executions, {run.edges} edges")
    if run.status != 0:
        print(run.text[-20000:])
    return run.status == 0


def long(program, target, seconds):
    """A finding ends libFuzzer: it is begun anew, until the same one comes again or time is over."""
    corpus, findings, logs = KEPT / "corpus" / target, KEPT / "findings" / target, KEPT / "logs"
    for folder in (corpus, findings, logs):
        folder.mkdir(parents=True, exist_ok=True)
    log = logs / f"{target}.log"
    log.unlink(missing_ok=True)
    end = time.monotonic() + seconds
    executions = edges = 0
    found = []
    while (left := int(end - time.monotonic())) > 0:
        run = Run(program, target, findings, [corpus, *sources_of(program, target)],
                  [f"-max_total_time={left}"], log)
        executions += run.executions
        edges = max(edges, run.edges)
        if run.status == 0:
            break
        if run.finding is None or run.finding in found:
            found.append(f"status {run.status}, see {log}" if run.finding is None else "again")
            break
        found.append(run.finding)
    inputs = sum(1 for _ in corpus.iterdir())
    print(f"{target}: {executions} executions, {edges} edges, {inputs} inputs kept, {len(found)} findings", flush=True)
    for finding in found:
        print(f"  {finding}", flush=True)
    return not found


def main(arguments):
    mode, program = arguments[0], pathlib.Path(arguments[1]).resolve()
    if mode == "short":
        return short(program, arguments[2])
    seconds, targets = int(arguments[2]), arguments[3:]
    known = subprocess.run([program, "--list"], capture_output=True, text=True, check=True).stdout.split()
    unknown = set(targets) - set(known)
    if unknown:
        sys.exit(f"no target {', '.join(sorted(unknown))}; there are {' '.join(known)}")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return all(list(pool.map(lambda target: long(program, target, seconds), targets or known)))


if __name__ == "__main__":
    if len(sys.argv) < 4 or sys.argv[1] not in ("short", "long"):
        sys.exit(__doc__)
    sys.exit(0 if main(sys.argv[1:]) else 1)
