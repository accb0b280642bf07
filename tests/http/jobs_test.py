#!/usr/bin/env python3
"""Renders that are answered later, with real curl against the real binary."""
import hashlib
import io
import json
import os
import signal
import tempfile
import time
import zipfile

import http_support as support
from http_support import Case, Server, curl_process, small

ASYNC = ("-H", "Prefer: respond-async")


def turning(frames, **output):
    return {**small(**output, sequence={"frames": frames, "turntableDegrees": 360})}


class Jobs(Case):
    def ask(self, server, document, *flags):
        answer = server.render(document, *ASYNC, *flags)
        self.assertEqual(answer.status, 202, answer.body[:500])
        job = json.loads(answer.body)
        self.assertEqual(answer.headers["location"], f"/v1/jobs/{job['id']}")
        self.assertEqual(answer.headers["preference-applied"], "respond-async")
        return answer.headers["location"]

    def job(self, server, place):
        answer = server.curl(place)
        self.assertEqual(answer.status, 200, answer.body[:500])
        return json.loads(answer.body)

    def wait(self, server, place, status="succeeded"):
        end = time.monotonic() + support.PATIENCE_S
        while time.monotonic() < end:
            job = self.job(server, place)
            if job["status"] not in ("queued", "running"):
                self.assertEqual(job["status"], status, job)
                return job
            time.sleep(0.05)
        self.fail("the job does not end")

    def test_the_result_is_the_picture_that_waiting_gives(self):
        with Server() as server:
            place = self.ask(server, small())
            job = self.wait(server, place)
            self.assertEqual(job["result"], place + "/result")
            result = server.curl(job["result"])
            self.expect_picture(result, 48, 32)
            self.assertEqual(result.body, server.render(small()).body)
            self.assertEqual(server.curl(job["result"], "-H", f"If-None-Match: {result.headers['etag']}").status, 304)
            self.assertEqual(server.curl(place, "-X", "DELETE").status, 204)
            self.expect_problem(server.curl(place), 404)
            self.expect_problem(server.curl(place + "/result"), 404)

    def test_a_client_says_how_long_it_would_wait(self):
        with Server() as server:
            patient = server.render(small(), "-H", "Prefer: respond-async, wait=60")
            self.expect_picture(patient, 48, 32)
            self.assertEqual(patient.headers["preference-applied"], "respond-async")
            self.assertRegex(patient.headers["content-location"], "^/v1/jobs/[0-9a-f]{32}/result$")
            self.assertEqual(server.curl(patient.headers["content-location"]).body, patient.body)
            hurried = server.render(support.slow(), "-H", "Prefer: respond-async, wait=0")
            self.assertEqual(hurried.status, 202)
            self.assertEqual(server.curl(hurried.headers["location"], "-X", "DELETE").status, 204)
            self.expect_problem(server.render(support.slow(), "-H", "Prefer: wait=0"), 504)

    def test_each_key_sees_its_own(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = os.path.join(folder, "keys")
            with open(keys, "w", encoding="ascii") as file:
                for name in ("anna", "berta", "root"):
                    digest = hashlib.sha256(name.encode()).hexdigest()
                    file.write(f"{name}:{'render,admin' if name == 'root' else 'render'}:{digest}\n")
            with Server("--api-keys-file", keys) as server:
                as_key = lambda name: ("-H", f"X-Api-Key: {name}")
                place = self.ask(server, small(), *as_key("anna"), "-H", 'Idempotency-Key: "k"')
                self.assertNotEqual(place, self.ask(server, small(), *as_key("berta"), "-H", 'Idempotency-Key: "k"'))
                self.assertEqual(place, self.ask(server, small(), *as_key("anna"), "-H", 'Idempotency-Key: "k"'))
                for path in (place, place + "/result", place + "/events"):
                    self.expect_problem(server.curl(path, *as_key("berta")), 404)
                self.expect_problem(server.curl(place, "-X", "DELETE", *as_key("berta")), 404)
                self.assertEqual(server.curl(place, *as_key("anna")).status, 200)
                self.assertEqual(server.curl(place, *as_key("root")).status, 200)
                self.assertEqual(server.curl(place, "-X", "DELETE", *as_key("root")).status, 204)

    def test_what_is_repeated_is_charged_once(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = os.path.join(folder, "keys")
            with open(keys, "w", encoding="ascii") as file:
                file.write(f"anna:render:{hashlib.sha256(b'anna').hexdigest()}:0:7\n")
            with Server("--api-keys-file", keys) as server:
                anna = ("-H", "X-Api-Key: anna")
                batch = {"request": small(), "items": [{"name": f"at_{px}", "changes": {"/output/width": px}} for px in (20, 21, 22)]}
                for key in ("one", "one", "two", "one"):
                    answer = server.curl("/v1/batches", *anna, *ASYNC, "-H", f'Idempotency-Key: "{key}"',
                                         "-H", "Content-Type: application/json", "--data-binary", json.dumps(batch))
                    self.assertEqual(answer.status, 202, answer.body[:500])
                for status in (200, 429):  # the seventh of the day, and one too many
                    self.assertEqual(server.render(small(), *anna).status, status)

    def test_what_is_wrong_is_told_at_once_or_by_the_job(self):
        with Server() as server:
            self.expect_problem(server.render({"output": {"width": 0}}, *ASYNC), 422)
            self.expect_problem(server.render(small(), *ASYNC, "-H", "Furnace-Priority: high"), 400)
            model = b'{"asset":{"version":"2.0"}}'
            with tempfile.NamedTemporaryFile() as file:
                file.write(model)
                file.flush()
                answer = server.curl("/v1/renders", *ASYNC, "-F", 'request={"scene":{"model":"part:model"},"camera":{"gltf":5}};type=application/json',
                                     "-F", f"model=@{file.name}")
            job = self.wait(server, answer.headers["location"], "failed")
            self.assertEqual(job["problem"]["status"], 422)
            self.expect_problem(server.curl(answer.headers["location"] + "/result"), 404)
            self.expect_problem(server.curl("/v1/jobs/" + "0" * 32), 404)
            self.expect_problem(server.curl("/v1/jobs/none"), 404)

    def test_ready_kinds_of_batches(self):
        batch = {"request": small(60, 40), "items": [{"name": "front"}, {"name": "side", "changes": {"/camera/orbit/azimuthDegrees": 90}}],
                 "srcset": {"widths": [30, 15], "formats": ["webp", "png"]}, "contactSheet": {"columns": 4, "cellPx": 24}}
        with Server() as server:
            ask = lambda document: server.curl("/v1/batches", "-H", "Content-Type: application/json", "--data-binary", json.dumps(document))
            answer = ask(batch)
            self.assertEqual(answer.status, 200, answer.body[:500])
            archive = zipfile.ZipFile(io.BytesIO(answer.body))
            index = json.loads(archive.read("index.json"))
            self.assertEqual({item["file"] for item in index["items"]} | {"index.json", "contact-sheet.png"}, set(archive.namelist()))
            self.assertEqual(support.read_png(archive.read("front_15w.png"))[:2], (15, 10))
            self.assertIn({"name": "side", "format": "webp", "srcset": "side_30w.webp 30w, side_15w.webp 15w"}, index["srcsets"])
            self.assertEqual(index["items"][5]["cell"], {"row": 1, "column": 1})
            width, height, channels, pixels = support.read_png(archive.read(index["contactSheet"]))
            self.assertEqual((width, height, channels), (96, 48, 4))
            # The picture of 24 x 16 stands in the middle of its cell.
            self.assertEqual([pixels[y * 96 + 12][3] for y in (3, 4, 19, 20)], [0, 255, 255, 0])

            answer = ask({"request": small(), "turntable": {"frames": 3}, "contactSheet": {"cellPx": 16}})
            self.assertEqual(answer.status, 200, answer.body[:500])
            archive = zipfile.ZipFile(io.BytesIO(answer.body))
            self.assertEqual(set(archive.namelist()), {"turntable.png", "contact-sheet.png", "index.json"})
            self.assertIn(b"acTL", archive.read("turntable.png"))
            self.assertEqual(self.expect_problem(ask({"vary": [{"pointer": "/output/width", "values": list(range(10, 110))}],
                                                      "contactSheet": {"cellPx": 2048}}), 413)["pointer"], "/contactSheet")

    def test_a_batch_is_an_archive_at_once_or_later(self):
        batch = {"request": small(), "items": [{"name": "front", "changes": {"/camera/orbit/azimuthDegrees": 0}}, {"name": "back"}],
                 "vary": [{"pointer": "/output/width", "values": [20, 40]}]}
        with Server() as server:
            def ask(document, *flags):
                return server.curl("/v1/batches", "-H", "Content-Type: application/json", "--data-binary", json.dumps(document), *flags)

            answer = ask(batch)
            self.assertEqual(answer.status, 200, answer.body[:500])
            with zipfile.ZipFile(io.BytesIO(answer.body)) as archive:
                index = json.loads(archive.read("index.json"))["items"]
                self.assertEqual([item["file"] for item in index],
                                 ["front_001.png", "front_002.png", "back_001.png", "back_002.png"])
                self.assertEqual(support.read_png(archive.read("back_002.png"))[:2], (40, 32))
                alone = {**small(width=20), "camera": {"orbit": {"azimuthDegrees": 0}}}
                self.assertEqual(archive.read("front_001.png"), server.render(alone).body)
            later = ask(batch, *ASYNC)
            self.assertEqual(later.status, 202)
            job = self.wait(server, later.headers["location"])
            self.assertEqual(server.curl(job["result"]).body, answer.body)
            # One that cannot be drawn is told in the index; one that cannot be understood ends the batch before it begins.
            wrong = {"request": small(), "items": [{"name": "a"}, {"name": "b", "changes": {"/camera/gltf": 3}}]}
            with zipfile.ZipFile(io.BytesIO(ask(wrong).body)) as archive:
                index = json.loads(archive.read("index.json"))["items"]
                self.assertEqual((index[0]["file"], index[1]["problem"]["status"]), ("a.png", 422))
            self.expect_problem(ask({"items": [{"changes": {"/output/width": 0}}]}), 422)
            self.expect_problem(ask({}), 422)
            self.expect_problem(ask({"vary": [{"pointer": "/output/width", "values": list(range(1, 300))}]}), 413)

    def test_events_tell_until_the_end(self):
        with Server() as server:
            place = self.ask(server, turning(3))
            stream = server.curl(place + "/events")
            self.assertEqual(stream.headers["content-type"], "text/event-stream")
            events = [block.split("\n") for block in stream.body.decode().split("\n\n") if block]
            self.assertEqual(events[-1][0], "event: succeeded")
            last = json.loads(events[-1][1].removeprefix("data: "))
            self.assertEqual(last["id"], place.rsplit("/", 1)[1])
            self.assertEqual(server.curl(last["result"]).body.count(b"fcTL"), 3)

    def render_with_large_sky(self, server, folder, seed, *flags):
        path = os.path.join(folder, "sky.hdr")
        with open(path, "wb") as file:
            file.write(support.write_large_hdr(4096, 2048, lambda y: (100 + y % 100, 90 + seed, 80, 128)))
        request = json.dumps({**small(), "environment": {"map": "part:sky"}})
        return server.curl("/v1/renders", "-F", f"request={request};type=application/json", "-F", f"sky=@{path}", *flags)

    def ask_with_large_sky(self, server, folder, seed):
        answer = self.render_with_large_sky(server, folder, seed, *ASYNC)
        self.assertEqual(answer.status, 202, answer.body[:500])
        return answer.headers["location"]

    def test_events_tell_how_far_a_bake_is(self):
        with Server() as server, tempfile.TemporaryDirectory() as folder:
            place = self.ask_with_large_sky(server, folder, 0)
            blocks = [block for block in server.curl(place + "/events").body.decode().split("\n\n") if "data: " in block]
            told = [json.loads(block.split("data: ", 1)[1]).get("progress", {}) for block in blocks]
            self.wait(server, place)
            shares = [progress.get("share", 0) for progress in told if progress.get("stage") == "bake"]
            self.assertTrue(shares, told)
            self.assertEqual(shares, sorted(shares))
            self.assertTrue(all(0 <= share <= 1 for share in shares), shares)
            self.assertNotIn("progress", json.loads(server.curl(place).body))

    def test_cancelling_ends_a_bake(self):
        with Server() as server, tempfile.TemporaryDirectory() as folder:
            for seed in range(5):  # a machine may bake faster than it is told to stop
                place = self.ask_with_large_sky(server, folder, seed)
                while (job := self.job(server, place))["status"] in ("queued", "running"):
                    if job.get("progress", {}).get("stage") == "bake":
                        break
                    time.sleep(0.005)
                self.assertEqual(server.curl(place, "-X", "DELETE").status, 204)
                # What had been baked to its end would be found.
                again = self.render_with_large_sky(server, folder, seed)
                self.expect_picture(again, 48, 32)
                if "bake;desc=hit" not in again.headers["server-timing"]:
                    return
            self.fail("every bake was finished")

    def test_a_key_makes_one_job(self):
        with Server() as server:
            key = ("-H", 'Idempotency-Key: "8e03978e"')
            place = self.ask(server, small(), *key)
            self.assertEqual(self.ask(server, small(), *key), place)
            self.expect_problem(server.render(small(width=40), *ASYNC, *key), 422)
            self.wait(server, place)
            self.assertEqual(self.ask(server, small(), *key), place)

    def test_cancelling_ends_the_work(self):
        with Server() as server:
            place = self.ask(server, support.slow())
            while self.job(server, place)["status"] == "queued":
                time.sleep(0.02)
            self.assertEqual(server.curl(place, "-X", "DELETE").status, 204)
            self.assertEqual(self.job(server, place)["status"], "cancelled")
            other = self.ask(server, small())
            self.wait(server, other)

    def test_a_full_queue_and_no_stream_left(self):
        with Server("--job-queue", "1", "--event-streams", "0") as server:
            running = self.ask(server, support.slow())
            while self.job(server, running)["status"] == "queued":
                time.sleep(0.02)
            self.ask(server, small())
            self.assertEqual(server.metric("furnace_jobs_waiting"), 1)
            answer = server.render(small(width=20), *ASYNC)
            self.expect_problem(answer, 429)
            self.assertTrue(int(answer.headers["retry-after"]) > 0)
            self.expect_problem(server.curl(running + "/events"), 429)
            self.assertEqual(server.curl(running, "-X", "DELETE").status, 204)

    def test_nothing_is_lost_when_the_server_is_killed(self):
        with tempfile.TemporaryDirectory() as data:
            with Server("--data", data) as server:
                done = self.ask(server, small())
                self.wait(server, done)
                picture = server.curl(done + "/result").body
                running = self.ask(server, turning(40, width=200, height=200))
                waiting = self.ask(server, small(width=30))
                while self.job(server, running).get("progress", {}).get("framesDone", 0) < 1:
                    time.sleep(0.02)
                server.process.send_signal(signal.SIGKILL)
                server.process.wait()
            with Server("--data", data) as server:
                self.assertEqual(server.curl(done + "/result").body, picture)
                self.wait(server, running)
                self.assertEqual(server.curl(running + "/result").body.count(b"fcTL"), 40)
                self.wait(server, waiting)

    def test_a_server_that_stops_keeps_what_it_had_begun(self):
        with tempfile.TemporaryDirectory() as data:
            with Server("--data", data) as server:
                place = self.ask(server, turning(30, width=200, height=200))
                while self.job(server, place)["status"] == "queued":
                    time.sleep(0.02)
            with Server("--data", data) as server:
                self.wait(server, place)

    def test_a_client_that_leaves_a_stream_gives_its_place_back(self):
        with Server("--event-streams", "1") as server:
            place = self.ask(server, support.slow())
            leaving = curl_process(server.url + place + "/events", "-N")
            time.sleep(0.5)
            leaving.kill()
            leaving.communicate()
            self.assertEqual(server.curl(place, "-X", "DELETE").status, 204)
            end = time.monotonic() + 30
            while server.curl(place + "/events").status == 429:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.2)


if __name__ == "__main__":
    support.main()
