#!/usr/bin/env python3
"""Jobs that tell of their end, with a receiver on this machine."""
import base64
import hashlib
import hmac
import json
import os
import signal
import tempfile
import time

import http_support as support
from http_support import Case, Server, small
from outbound_support import Receiver, in_turn, redirects, replies, resets, wait_for_job, waits

SECRETS = [bytes(range(start, start + 32)) for start in (0, 100)]
TRACE = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"


def signatures(secret, headers, body):
    text = b".".join([headers["webhook-id"].encode(), headers["webhook-timestamp"].encode(), body])
    return "v1," + base64.b64encode(hmac.new(secret, text, hashlib.sha256).digest()).decode()


class Webhooks(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.keys = f"{self.folder.name}/keys"
        self.write_keys(SECRETS[:1])
        self.receiver = Receiver()
        self.addCleanup(self.receiver.__exit__)
        self.receiver.answers["/hook"] = replies(204)

    def write_keys(self, secrets):
        with open(self.keys, "w", encoding="ascii") as file:
            for number, secret in enumerate(secrets):
                file.write(f"k{number}:whsec_{base64.b64encode(secret).decode()}\n")
        os.chmod(self.keys, 0o600)

    def server(self, *flags, allow=None):
        return Server("--webhook-allow", allow or self.receiver.origin, "--webhook-secrets-file", self.keys,
                      "--webhook-pause", "50ms", *flags)

    def ask(self, server, document, url, *flags):
        return server.render(document, "-H", "Prefer: respond-async", "-H", f"Furnace-Webhook: {url}", *flags)

    def job(self, server, document=None, path="/hook", *flags, receiver=None):
        answer = self.ask(server, document or small(), (receiver or self.receiver).origin + path, *flags)
        self.assertEqual(answer.status, 202, answer.body)
        return answer.headers["location"]

    def wait(self, server, place, status):
        return wait_for_job(server, place, lambda job: job["webhook"]["status"] == status)

    def expect_signed(self, headers, body, secrets):
        self.assertEqual(headers["webhook-signature"].split(" "), [signatures(secret, headers, body) for secret in secrets])
        self.assertLess(abs(int(headers["webhook-timestamp"]) - time.time()), 300)

    def test_none_unless_allowed(self):
        with Server() as server:
            problem = self.expect_problem(self.ask(server, small(), self.receiver.origin + "/hook"), 422)
            self.assertIn("webhook-allow", problem["detail"])
            self.assertIs(json.loads(server.curl("/v1/capabilities").body)["webhooks"], False)
        with self.server() as server:
            for url, status in (("https://example.com/", 422), (f"http://localhost:{self.receiver.port}/hook", 422),
                                (f"https://127.0.0.1:{self.receiver.port}/hook", 422), ("ftp://127.0.0.1/", 400), ("hook", 400),
                                (f"http://user:word@127.0.0.1:{self.receiver.port}/hook", 400)):
                self.expect_problem(self.ask(server, small(), url), status)
            self.expect_problem(server.render(small(), "-H", f"Furnace-Webhook: {self.receiver.origin}/hook"), 400)
            self.assertEqual(server.metric("furnace_jobs_waiting"), 0)
        self.assertEqual(self.receiver.seen, [])

    def test_the_end_of_a_job_is_told(self):
        with self.server() as server:
            place = self.job(server, None, "/hook", "-H", f"traceparent: {TRACE}")
            headers, body = self.receiver.wait_for("/hook")
            self.expect_signed(headers, body, SECRETS[:1])
            self.assertEqual(headers["webhook-id"], "msg_" + place.rsplit("/", 1)[1])
            self.assertEqual(headers["Content-Type"], "application/json")
            self.assertEqual(headers["traceparent"][:36], TRACE[:36], "the same trace")
            self.assertNotEqual(headers["traceparent"], TRACE, "a span of our own")
            job = self.wait(server, place, "delivered")
            self.assertEqual(job.pop("webhook"), {"status": "delivered", "attempts": 1, "lastOutcome": "204"})
            self.assertEqual(json.loads(body), {"type": "job.succeeded", "timestamp": job["finishedAt"], "data": job})
            self.expect_picture(server.curl(json.loads(body)["data"]["result"]), 48, 32)
            self.assertEqual(server.metric("furnace_webhook_attempts_total"), 1)
            self.assertEqual(server.metric("furnace_webhooks_unfinished"), 0)

            self.job(server, None, "/hook", "-H", "traceparent: 00-nonsense")
            self.assertRegex(self.receiver.wait_for("/hook", 2)[0]["traceparent"], "^00-[0-9a-f]{32}-[0-9a-f]{16}-0[0-9]$")

    def test_failure_cancellation_and_a_batch_are_told(self):
        with self.server() as server:
            running = self.job(server, support.slow())
            wait_for_job(server, running, lambda job: job["status"] == "running")
            self.assertEqual(server.curl(running, "-X", "DELETE").status, 204)
            self.assertEqual(json.loads(self.receiver.wait_for("/hook")[1])["type"], "job.cancelled")
            with tempfile.NamedTemporaryFile() as file:
                file.write(b'{"asset":{"version":"2.0"}}')
                file.flush()
                server.curl("/v1/renders", "-H", "Prefer: respond-async", "-H", f"Furnace-Webhook: {self.receiver.origin}/hook", "-F",
                            'request={"scene":{"model":"part:model"},"camera":{"gltf":5}};type=application/json', "-F", f"model=@{file.name}")
            event = json.loads(self.receiver.wait_for("/hook", 2)[1])
            self.assertEqual((event["type"], event["data"]["problem"]["status"]), ("job.failed", 422))
            batch = {"request": small(), "items": [{"name": "a"}]}
            server.curl("/v1/batches", "-H", "Prefer: respond-async", "-H", f"Furnace-Webhook: {self.receiver.origin}/hook",
                        "-H", "Content-Type: application/json", "--data-binary", json.dumps(batch))
            self.assertEqual(json.loads(self.receiver.wait_for("/hook", 3)[1])["type"], "job.succeeded")

    def test_it_is_tried_again_under_the_same_id(self):
        self.receiver.answers["/hook"] = in_turn(replies(500), resets, replies(429, Retry_After="1"), replies(200, bytes(200_000)))
        with self.server() as server:
            place = self.job(server)
            job = self.wait(server, place, "delivered")
            self.assertEqual(job["webhook"], {"status": "delivered", "attempts": 4, "lastOutcome": "200"})
            tries = [self.receiver.wait_for("/hook", count) for count in (1, 2, 3, 4)]
            self.assertEqual(len({headers["webhook-id"] for headers, _ in tries}), 1)
            self.assertEqual(len({body for _, body in tries}), 1)
            self.assertGreaterEqual(int(tries[3][0]["webhook-timestamp"]), int(tries[2][0]["webhook-timestamp"]) + 1)
            for headers, body in tries:
                self.expect_signed(headers, body, SECRETS[:1])

    def test_it_is_given_up(self):
        self.receiver.answers.update({"/gone": replies(410), "/away": redirects("/hook"), "/broken": replies(503)})
        with self.server("--webhook-attempts", "3") as server:
            for path, attempts, outcome in (("/gone", 1, "410"), ("/away", 1, "302"), ("/broken", 3, "503")):
                job = self.wait(server, self.job(server, None, path), "failed")
                self.assertEqual(job["webhook"], {"status": "failed", "attempts": attempts, "lastOutcome": outcome})
            self.assertEqual(self.receiver.count("/hook"), 0)
        # Nobody listens there, and a name that leads to this machine is refused when it is called.
        with Receiver() as closed:
            pass
        local = f"http://localhost:{self.receiver.port}"
        with self.server("--webhook-attempts", "2", allow=f"{closed.origin}, {local}") as server:
            job = self.wait(server, self.job(server, receiver=closed), "failed")
            self.assertEqual(job["webhook"], {"status": "failed", "attempts": 2, "lastOutcome": "unreachable"})
            job = self.wait(server, self.ask(server, small(), local + "/hook").headers["location"], "failed")
            self.assertEqual(job["webhook"], {"status": "failed", "attempts": 1, "lastOutcome": "refused"})
        self.assertEqual(self.receiver.count("/hook"), 0)

    def test_a_late_answer_is_another_attempt(self):
        self.receiver.answers["/hook"] = in_turn(waits(self.receiver, replies(204)), replies(204))
        with self.server("--webhook-timeout", "200ms") as server:
            self.assertEqual(self.wait(server, self.job(server), "delivered")["webhook"]["attempts"], 2)

    def test_a_dead_host_delays_no_other(self):
        with Receiver() as dead, self.server("--webhook-threads", "3", "--webhook-timeout", "100s",
                                             allow=f"{self.receiver.origin}, {dead.origin}") as server:
            dead.answers["/hook"] = waits(dead, replies(204))
            places = [self.job(server, receiver=dead) for _ in range(4)]
            dead.wait_for("/hook", 2)
            self.wait(server, self.job(server), "delivered")
            self.assertEqual(dead.count("/hook"), 2)
            dead.released.set()
            for place in places:
                self.wait(server, place, "delivered")

    def test_nothing_is_lost_when_the_server_is_killed(self):
        self.receiver.answers["/hook"] = in_turn(waits(self.receiver, replies(503)), replies(204))
        with tempfile.TemporaryDirectory() as data:
            with self.server("--data", data, "--webhook-timeout", "100s") as server:
                place = self.job(server)
                first = self.receiver.wait_for("/hook")[0]
                server.process.send_signal(signal.SIGKILL)
                server.process.wait()
            with self.server("--data", data) as server:
                again = self.receiver.wait_for("/hook", 2)[0]
                self.assertEqual(again["webhook-id"], first["webhook-id"])
                self.assertEqual(self.wait(server, place, "delivered")["webhook"]["attempts"], 2)

    def test_a_server_that_stops_waits_for_nobody_for_long(self):
        self.receiver.answers["/hook"] = in_turn(waits(self.receiver, replies(503)), replies(204))
        with tempfile.TemporaryDirectory() as data:
            with self.server("--data", data, "--webhook-timeout", "600s") as server:
                place = self.job(server)
                self.receiver.wait_for("/hook")
                self.assertEqual(server.stop(), 0)
            with self.server("--data", data) as server:
                self.assertEqual(self.wait(server, place, "delivered")["webhook"]["attempts"], 1)

    def test_keys_are_exchanged_without_a_restart(self):
        with self.server() as server:
            self.write_keys(SECRETS)
            server.process.send_signal(signal.SIGHUP)
            end = time.monotonic() + support.PATIENCE_S
            while "keys.reloaded" not in server.log_text():
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)
            self.job(server)
            self.expect_signed(*self.receiver.wait_for("/hook"), SECRETS)

    def test_as_many_as_may_wait(self):
        self.receiver.answers["/hook"] = waits(self.receiver, replies(204))
        with self.server("--webhook-queue", "1") as server:
            self.job(server)
            self.expect_problem(self.ask(server, small(), self.receiver.origin + "/hook"), 429)
            self.receiver.released.set()

    def test_settings_that_cannot_be(self):
        for flags in (("--webhook-allow", "example.com"), ("--webhook-allow", "example.com/path", "--webhook-secrets-file", self.keys),
                      ("--remote-allow", "10.0.0.1/8")):
            told = support.subprocess.run([support.FURNACE, "check-config", *flags], capture_output=True, text=True, check=False)
            self.assertEqual(told.returncode, 1, told)
            self.assertIn(flags[0][2:], told.stderr + told.stdout)


if __name__ == "__main__":
    support.main()
