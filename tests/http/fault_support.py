"""A server whose disk, clock and GPU can be broken from outside (tests/fault/shim.cpp), as its tests do it."""
import errno
import http.client
import json
import mmap
import os
import struct
import sys
import tempfile
import time

import http_support as support
from http_support import Case, Server

# The shim: the argument of the test's script behind the program under test.
SHIM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 and os.path.isfile(sys.argv[1]) else "build/tests/fault/libfault_shim.so"
FIELDS = ("disk_errno", "clock_offset_s", "resets", "hang_ms", "steps_to_kill", "steps", "refusals", "unused")
YEAR_S = 365 * 24 * 3600


class Faults:
    """The shim's numbers; each is an attribute."""

    def __init__(self, folder):
        file = tempfile.NamedTemporaryFile(prefix="faults-")
        file.write(bytes(8 * len(FIELDS)))
        file.flush()
        self.__dict__.update(file=file, memory=mmap.mmap(file.fileno(), 0),
                             environment={"LD_PRELOAD": SHIM, "FAULTS_CONTROL": file.name, "FAULTS_FOLDER": folder})

    def __getattr__(self, name):
        return struct.unpack_from("=q", self.memory, 8 * FIELDS.index(name))[0]

    def __setattr__(self, name, value):
        struct.pack_into("=q", self.memory, 8 * FIELDS.index(name), value)

    def close(self):
        self.memory.close()
        self.file.close()


def ask(server, method, path, body=None, **headers):
    """The answer, or None when the connection ends without a whole one."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=support.PATIENCE_S)
    try:
        connection.request(method, path, body, {name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return support.Answer(answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read())
    except (OSError, http.client.HTTPException):
        return None
    finally:
        connection.close()


def post_job(server, document, **headers):
    return ask(server, "POST", "/v1/renders", json.dumps(document), Content_Type="application/json", Prefer="respond-async",
               **headers)


def post_render(server, document):
    return ask(server, "POST", "/v1/renders", json.dumps(document), Content_Type="application/json")


class FaultCase(Case):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="furnace-faults-")
        self.addCleanup(folder.cleanup)
        self.data = os.path.join(folder.name, "data")
        self.faults = Faults(self.data)
        self.addCleanup(self.faults.close)

    def server(self, *flags):
        return Server("--data", self.data, *flags, environment=self.faults.environment)

    def until(self, condition, message=""):
        end = time.monotonic() + support.PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.02)

    def job(self, server, place):
        answer = ask(server, "GET", place)
        self.assertEqual(answer.status, 200, answer.body[:500])
        return json.loads(answer.body)

    def expect_success(self, server, place):
        """The bytes of the job's result, when it has ended well."""
        self.until(lambda: self.job(server, place)["status"] not in ("queued", "running"), "the job does not end")
        self.assertEqual(self.job(server, place)["status"], "succeeded", self.job(server, place))
        answer = ask(server, "GET", place + "/result")
        self.assertEqual(answer.status, 200)
        return answer.body

    def expect_same_handles(self, server, before):
        self.until(lambda: all(now <= then for now, then in zip(support.handles(server), before)),
                   f"descriptors and threads were {before}")

    def unfinished_files(self):
        return [path for path in support.files_below(self.data) if path.endswith((".part", ".tmp"))]


ENOSPC, EROFS = errno.ENOSPC, errno.EROFS
