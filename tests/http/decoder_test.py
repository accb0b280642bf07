#!/usr/bin/env python3
"""Files are decoded in processes of their own, and what happens to one of them costs one request."""
import json
import os
import signal
import subprocess
import tempfile
import time

import http_support as support
from http_support import Case, Server, small

GREY = b"\x80\x80\x80\x81"
SKY = {**small(), "environment": {"map": "part:sky"}}


def doctor():
    told = subprocess.run([support.FURNACE, "doctor", "--json"], capture_output=True, text=True, check=False)
    return json.loads(told.stdout)["decoders"]


# Where the system has no filters the children are tested without.
STRICTEST = "require" if doctor()["sandboxed"] else "prefer"


def parent_of(pid):
    """0 when there is no such process, or only what it leaves behind."""
    try:
        with open(f"/proc/{pid}/stat", encoding="latin-1") as stat:
            state, parent = stat.read().rpartition(")")[2].split()[:2]
    except OSError:
        return 0
    return 0 if state == "Z" else int(parent)


def children_of(pid):
    return [int(entry) for entry in os.listdir("/proc") if entry.isdigit() and parent_of(entry) == pid]


def wait_until(true):
    end = time.monotonic() + support.PATIENCE_S
    while not true():
        if time.monotonic() > end:
            raise AssertionError("it never came")
        time.sleep(0.01)


class Decoders(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.count = 0

    def tearDown(self):
        self.folder.cleanup()

    def flags(self, width=64, body=None):
        """Of a request for a sky that no other request had."""
        self.count += 1
        path = os.path.join(self.folder.name, f"{self.count}.hdr")
        with open(path, "wb") as file:
            rows = GREY * (width * width // 2) if body is None else body
            file.write(f"#?RADIANCE\n#{self.count}\nFORMAT=32-bit_rle_rgbe\n\n-Y {width // 2} +X {width}\n".encode() + rows)
        return ("-F", f"request={json.dumps(SKY)};type=application/json", "-F", f"sky=@{path}")

    def ask(self, server, **file):
        return server.curl("/v1/renders", *self.flags(**file))

    def expect_failed_decoder(self, answer):
        problem = self.expect_problem(answer, 422)
        self.assertIn("the decoder", json.dumps(problem))
        self.assertIn("/environment/map", json.dumps(problem))

    def test_the_same_picture_either_way(self):
        flags, answers = self.flags(), []
        for sandbox in (STRICTEST, "off"):
            with Server("--decoder-sandbox", sandbox) as server:
                answers.append(server.curl("/v1/renders", *flags))
                self.expect_picture(answers[-1], 48, 32)
                self.assertEqual(bool(children_of(server.process.pid)), sandbox != "off")
                self.assertEqual(server.metric("furnace_decoder_jobs_total"), 0 if sandbox == "off" else 1)
                damaged = self.expect_problem(self.ask(server, body=b"\x02\x02\x01"), 422)
                self.assertIn("damaged", json.dumps(damaged))
        self.assertEqual(len({answer.body for answer in answers}), 1)
        self.assertEqual(len({answer.headers["etag"] for answer in answers}), 1)

    def test_a_child_that_is_killed_costs_one_request(self):
        with Server("--decoders", "1") as server:
            child, = children_of(server.process.pid)
            os.kill(child, signal.SIGSTOP)  # so that it is at work when it is killed
            process = support.curl_process(server.url + "/v1/renders", *self.flags())
            wait_until(lambda: server.metric("furnace_requests_in_progress") == 2)  # and this very question
            time.sleep(0.2)
            os.kill(child, signal.SIGKILL)
            self.expect_failed_decoder(support.answer_of(process))
            self.expect_picture(self.ask(server), 48, 32)
            self.assertNotEqual(children_of(server.process.pid), [child])
            self.assertEqual(server.metric("furnace_decoder_crashes_total"), 1)
            self.assertEqual(server.metric("furnace_decoder_starts_total"), 2)
            self.assertEqual(server.metric("furnace_decoders"), 1)
            crash, = [json.loads(line) for line in server.log_text().splitlines() if "decoder.crashed" in line]
            self.assertIn("signal 9", crash["reason"])
            self.assertEqual((crash["job"], crash["pid"]), ("environment", child))

    def test_time(self):
        with Server("--decoders", "1", "--decoder-timeout", "1ms") as server:
            self.expect_failed_decoder(self.ask(server, width=1024))
            self.assertEqual(server.metric("furnace_decoder_timeouts_total"), 1)
        with Server("--decoders", "1", "--timeout", "500ms") as server:
            child, = children_of(server.process.pid)
            os.kill(child, signal.SIGSTOP)
            self.expect_problem(self.ask(server), 504)
            self.assertEqual(children_of(server.process.pid), [])
            self.assertEqual(server.metric("furnace_decoder_timeouts_total"), 1)

    def test_children_end_with_the_server(self):
        with Server() as server:
            children = children_of(server.process.pid)
            self.assertTrue(children)
            server.process.kill()
            server.process.wait()
        wait_until(lambda: not any(parent_of(child) for child in children))

    def test_doctor_and_command_line(self):
        told = doctor()
        self.assertEqual(told["sandboxed"], told["problem"] == "", told)
        request = os.path.join(self.folder.name, "request.json")
        sky = self.flags()[-1].partition("@")[2]
        with open(request, "w", encoding="utf-8") as file:
            json.dump({**small(), "environment": {"map": "file:" + os.path.basename(sky)}}, file)
        pictures = []
        for sandbox in ("off", STRICTEST):
            out = os.path.join(self.folder.name, f"{sandbox}.png")
            subprocess.run([support.FURNACE, "render", request, "--decoder-sandbox", sandbox, "-o", out],
                           check=True, capture_output=True)
            with open(out, "rb") as file:
                pictures.append(file.read())
        self.assertEqual(pictures[0], pictures[1])


if __name__ == "__main__":
    support.main()
