"""What the server stands on breaks: faults_test.py FURNACE SHIM [unittest arguments]."""
import hashlib
import json
import os
import subprocess
import time

import http_support as support
from http_support import FURNACE, handles, small
from fault_support import ENOSPC, EROFS, YEAR_S, FaultCase, ask, post_job, post_render

# Every request is drawn: no picture comes from a cache.
UNCACHED = ("--render-cache", "0", "--render-disk-cache", "0")


def sha256(data):
    return hashlib.sha256(data).hexdigest()


def hdr(turn):
    """An environment of one colour, 8 by 4, as Radiance HDR."""
    value = 2 + turn  # three ones would begin a run
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes((value, value, value, 128)) * 32


class Killed(FaultCase):
    """The process dies in the middle of a change of the disk; what it had acknowledged is there after the next start."""

    def work(self, server, turn, kept):
        """An upload, a named environment, a job and a picture, each different in each turn. What is answered goes to `kept`."""
        body = f"asset {turn}".encode() * 5000
        answer = ask(server, "PUT", f"/v1/assets/{sha256(body)}", body)
        if answer is None:
            return
        self.assertEqual(answer.status, 201, answer.body)
        kept["assets"].append(body)
        name = f"room{turn}"
        answer = ask(server, "PUT", f"/v1/environments/{name}", hdr(turn))
        if answer is None:
            return
        self.assertIn(answer.status, (200, 201), answer.body)
        kept["environments"].append(name)
        answer = post_job(server, small(width=20 + turn), Idempotency_Key=f"turn-{turn}")
        if answer is None:
            return
        self.assertEqual(answer.status, 202, answer.body)
        kept["jobs"].append((turn, answer.headers["location"]))
        answer = post_render(server, small(width=20 + turn, height=16))
        if answer is None:
            return
        self.expect_picture(answer, 20 + turn, 16)
        try:
            self.expect_success(server, kept["jobs"][-1][1])
        except AttributeError:  # no answer
            pass

    def expect_kept(self, server, kept):
        self.assertEqual(self.unfinished_files(), [])
        for body in kept["assets"]:
            self.assertEqual(ask(server, "GET", f"/v1/assets/{sha256(body)}").body, body)
        listed = json.loads(ask(server, "GET", "/v1/environments").body)
        for name in kept["environments"]:
            self.assertIn(name, json.dumps(listed))
        for turn, place in kept["jobs"]:
            picture = self.expect_success(server, place)
            self.assertEqual(support.read_png(picture)[:2], (20 + turn, 32))
            again = post_job(server, small(width=20 + turn), Idempotency_Key=f"turn-{turn}")
            self.assertEqual(again.headers["location"], place)

    def test_at_many_instants(self):
        kept = {"assets": [], "environments": [], "jobs": []}
        with self.server() as server:
            before = self.faults.steps
            self.work(server, 1, kept)
            steps = self.faults.steps - before
        self.assertGreater(steps, 20)
        turns = 10
        for turn in range(2, 2 + turns):
            server = self.server()
            try:
                self.expect_kept(server, kept)
                kept = {name: things[-2:] for name, things in kept.items()}  # the older ones have been looked at often enough
                self.faults.steps_to_kill = 1 + (turn - 2) * steps // turns
                self.work(server, turn, kept)
                if self.faults.steps_to_kill > 0:  # the first turn made folders, too
                    self.work(server, 100 + turn, kept)
                self.assertEqual(server.process.wait(support.PATIENCE_S), -9)
            finally:
                self.faults.steps_to_kill = 0
                server.stop()
                server.process.stdout.close()
        with self.server() as server:
            self.expect_kept(server, kept)
            # What was not acknowledged is not there by half: asked for again, it is done once.
            for turn in range(2, 2 + turns):
                places = {post_job(server, small(width=20 + turn), Idempotency_Key=f"turn-{turn}").headers["location"]
                          for _ in range(2)}
                self.assertEqual(len(places), 1)
                self.expect_success(server, places.pop())


class Disk(FaultCase):
    def expect_no_room(self, server, turn):
        body = b"%d" % turn
        self.expect_problem(ask(server, "PUT", f"/v1/assets/{sha256(body)}", body), 507)
        self.expect_problem(ask(server, "PUT", "/v1/environments/none", hdr(7)), 507)
        self.expect_problem(post_job(server, small(width=30 + turn)), 507)
        self.expect_picture(post_render(server, small(width=40 + turn)), 40 + turn, 32)
        self.expect_picture(post_render(server, {**small(), "environment": {"map": {"color": [turn, 1, 1]}}}), 48, 32)
        for path in ("/livez", "/readyz", "/metrics"):
            self.assertEqual(ask(server, "GET", path).status, 200, path)

    def test_full_and_read_only(self):
        with self.server() as server:
            asset = f"/v1/assets/{sha256(b'kept')}"
            self.assertEqual(ask(server, "PUT", asset, b"kept").status, 201)
            place = post_job(server, small()).headers["location"]
            picture = self.expect_success(server, place)
            self.expect_picture(post_render(server, small()), 48, 32)
            before = handles(server)
            for turn, fault in enumerate((ENOSPC, EROFS), 1):
                self.faults.disk_errno = fault
                self.expect_no_room(server, turn)
                self.assertEqual(ask(server, "GET", asset).body, b"kept")
                self.assertEqual(self.expect_success(server, place), picture)
                self.faults.disk_errno = 0
                self.expect_success(server, post_job(server, small(width=50 + turn)).headers["location"])
                self.assertEqual(ask(server, "PUT", f"/v1/assets/{sha256(b'%d' % turn)}", b"%d" % turn).status, 201)
            self.faults.disk_errno = EROFS
            self.expect_problem(ask(server, "DELETE", asset), 507)
            self.faults.disk_errno = 0
            self.expect_same_handles(server, before)
            self.assertGreater(self.faults.refusals, 10)
            self.assertEqual(self.unfinished_files(), [])

    def test_what_a_job_has_come_to_waits_for_room(self):
        with self.server(*UNCACHED) as server:
            place = post_job(server, {"output": {"width": 400, "height": 400, "samples": 16}}).headers["location"]
            self.until(lambda: self.job(server, place)["status"] == "running")
            self.faults.disk_errno = ENOSPC
            self.until(lambda: "jobs.failed" in server.log_text())
            self.assertEqual(self.job(server, place)["status"], "running")
            self.expect_problem(post_job(server, small()), 507)
            self.faults.disk_errno = 0
            self.expect_success(server, place)
            self.expect_success(server, post_job(server, small()).headers["location"])

    def test_full_from_the_start(self):
        with self.server() as server:
            place = post_job(server, small()).headers["location"]
            picture = self.expect_success(server, place)
        self.faults.disk_errno = ENOSPC
        with self.server() as server:
            self.expect_no_room(server, 1)
            self.faults.disk_errno = 0
            self.assertEqual(self.expect_success(server, place), picture)
            self.expect_success(server, post_job(server, small(width=60)).headers["location"])

    def test_read_only_from_the_start(self):
        self.faults.disk_errno = EROFS
        with self.server() as server:
            self.expect_picture(post_render(server, small()), 48, 32)
            self.expect_problem(ask(server, "PUT", f"/v1/assets/{sha256(b'x')}", b"x"), 507)
            self.assertIn("jobs.not_kept", server.log_text())


class Graphics(FaultCase):
    def test_a_lost_context(self):
        with self.server(*UNCACHED) as server:
            whole = post_render(server, small()).body
            before = handles(server)
            self.faults.resets = 1
            self.assertEqual(post_render(server, small()).body, whole)
            self.assertEqual(self.faults.resets, 0)
            self.assertIn("gl.lost", server.log_text())
            self.faults.resets = 1000
            refused = post_render(server, small())
            self.expect_problem(refused, 503)
            self.assertIn("retry-after", refused.headers)
            self.faults.resets = 0
            self.assertEqual(post_render(server, small()).body, whole)
            self.assertEqual(ask(server, "GET", "/readyz").status, 200)
            self.expect_same_handles(server, before)

    def test_a_job_meets_a_lost_context(self):
        with self.server(*UNCACHED) as server:
            self.faults.resets = 1
            self.assertEqual(self.expect_success(server, post_job(server, small()).headers["location"]),
                             post_render(server, small()).body)

    def test_a_drawing_that_hangs(self):
        with self.server("--gl-watchdog", "100ms", "--job-timeout", "1s", *UNCACHED) as server:
            self.expect_picture(post_render(server, small()), 48, 32)  # what is loaded and compiled once is not the job's time
            self.faults.hang_ms = 3600 * 1000
            places = [post_job(server, small(width=width)).headers["location"] for width in (48, 50)]
            self.assertEqual(server.process.wait(support.PATIENCE_S), 3)
            self.assertIn("gl.hangs", server.log_text())
        with self.server() as server:
            for place in places:
                self.expect_success(server, place)


class Time(FaultCase):
    """The wall clock is set by years; what has an age, a rate or a deadline does not mind."""

    def test_jumps(self):
        os.mkdir(self.data)
        url_keys, api_keys = os.path.join(self.data, "url"), os.path.join(self.data, "api")
        key = lambda *arguments: subprocess.run([FURNACE, "hash-key", *arguments], capture_output=True, text=True, check=True).stdout
        with open(os.open(url_keys, os.O_CREAT | os.O_WRONLY, 0o600), "w", encoding="utf-8") as file:
            file.write(key("--url", "k1"))
        own, own_line = key("own", "--scopes", "render,assets,admin").splitlines()
        daily, daily_line = key("daily", "--renders", "1").splitlines()
        seldom, seldom_line = key("seldom", "--rate", "1").splitlines()
        with open(api_keys, "w", encoding="utf-8") as file:
            file.write(f"{own_line}\n{daily_line}\n{seldom_line}\n")
        url = subprocess.run([FURNACE, "sign-url", "--key-file", url_keys, "width=20", "height=16", "samples=1"],
                             capture_output=True, text=True, check=True).stdout.strip()
        with self.server("--url-keys-file", url_keys, "--api-keys-file", api_keys, "--job-ttl", "10min", "--asset-ttl", "10min") as server:
            def mine(method, path, body=None, **headers):
                return ask(server, method, path, body, X_Api_Key=own, **headers)

            def draw(key):
                return ask(server, "POST", "/v1/renders", json.dumps(small()), Content_Type="application/json", X_Api_Key=key)

            def job(document):
                return mine("POST", "/v1/renders", json.dumps(document), Content_Type="application/json", Prefer="respond-async")

            def status(place):
                return json.loads(mine("GET", place).body)["status"]

            asset = f"/v1/assets/{sha256(b'old')}"
            self.assertEqual(mine("PUT", asset, b"old").status, 201)
            place = job(small()).headers["location"]
            self.until(lambda: status(place) == "succeeded")
            self.assertEqual(ask(server, "GET", url).status, 200)
            self.assertEqual([draw(daily).status for _ in range(2)], [200, 429])
            drawn_at = time.monotonic()
            self.assertEqual([draw(seldom).status for _ in range(2)], [200, 429])
            running = job({"output": {"width": 500, "height": 500, "samples": 16}}).headers["location"]
            self.until(lambda: status(running) == "running")
            for years in (10, -10):
                self.faults.clock_offset_s = years * YEAR_S
                self.assertEqual(ask(server, "GET", url).status, 403, "an address says when it ends, by the calendar")
                other = job(small(width=60 + years)).headers["location"]
                self.until(lambda: status(other) == "succeeded")
                self.assertEqual(status(place), "succeeded", "finished jobs are kept for ten minutes")
                self.assertEqual(mine("GET", asset).body, b"old")
                self.assertEqual(draw(daily).status, 200, "another day by the calendar")
                refused = draw(seldom).status
                if time.monotonic() - drawn_at < 60:
                    self.assertEqual(refused, 429, "a minute is not over")
            self.until(lambda: status(running) == "succeeded")
            self.faults.clock_offset_s = 0
            self.assertEqual(ask(server, "GET", url).status, 200)
            self.assertEqual(mine("GET", place + "/result").status, 200)

    def test_a_request_lives_through_a_jump(self):
        with self.server("--timeout", "60s", *UNCACHED) as server:
            client = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d",
                                          json.dumps({"output": {"width": 400, "height": 400, "samples": 16}}))
            self.until(lambda: server.metric("furnace_render_pool_active") == 1)
            self.faults.clock_offset_s = YEAR_S
            self.assertEqual(support.answer_of(client).status, 200)


if __name__ == "__main__":
    support.main()
