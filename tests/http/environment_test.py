#!/usr/bin/env python3
"""Environments by name, their maps, the disk cache: with real curl against the real binary."""
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import http_support as support
from http_support import Case, Server, small


def sky(seed=0):
    """Grey above, brown below, and a bright spot."""
    return support.write_hdr(64, 32, lambda x, y: (200, 180, 160 + seed, 140) if (x, y) == (9, 9)
                     else ((128, 128, 128, 128) if y < 16 else (90, 60, 40, 127)))


# Nothing on disk but bakes.
BAKES_ONLY = ("--render-disk-cache", "0")


class Named(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.hdr = os.path.join(self.folder.name, "sky.hdr")
        with open(self.hdr, "wb") as file:
            file.write(sky())

    def tearDown(self):
        self.folder.cleanup()

    def put(self, server, name="lawn", path=None):
        return server.curl(f"/v1/environments/{name}", "-X", "PUT", "--data-binary", f"@{path or self.hdr}")

    def draw(self, server, name="lawn"):
        return server.render({**small(), "environment": {"map": f"environment:{name}"}})

    def test_put_get_list_draw_delete(self):
        with Server() as server:
            answer = self.put(server)
            self.assertEqual(answer.status, 201, answer.body[:300])
            report = json.loads(answer.body)
            self.assertEqual((report["name"], report["width"], report["height"]), ("lawn", 64, 32))
            self.assertEqual(report["cache"], "miss")
            self.assertEqual(self.put(server).status, 200)
            again = json.loads(server.curl("/v1/environments/lawn").body)
            self.assertEqual(again["cache"], "hit")
            self.assertEqual(again["mean"], report["mean"])
            names = json.loads(server.curl("/v1/environments").body)["environments"]
            self.assertEqual([entry["name"] for entry in names], ["lawn"])
            drawn = self.draw(server)
            self.expect_picture(drawn, 48, 32)
            self.assertIn("bake;desc=hit", drawn.headers["server-timing"])
            self.assertEqual(server.curl("/v1/environments/lawn", "-X", "DELETE").status, 204)
            self.expect_problem(server.curl("/v1/environments/lawn"), 404)
            self.expect_problem(self.draw(server), 404)

    def test_maps_are_exr(self):
        with Server() as server:
            report = json.loads(self.put(server).body)
            names = [entry["name"] for entry in report["maps"]]
            self.assertIn("charlie_00", names)
            for path in ("irradiance.exr", "background.exr", "ggx/0.exr", "ggx/7.exr", "charlie/2.exr"):
                answer = server.curl(f"/v1/environments/lawn/{path}")
                self.assertEqual(answer.status, 200, path)
                self.assertEqual(struct.unpack("<I", answer.body[:4])[0], 20000630, path)
            tag = server.curl("/v1/environments/lawn/irradiance.exr").headers["etag"]
            self.assertEqual(server.curl("/v1/environments/lawn/irradiance.exr", "-H", f"If-None-Match: {tag}").status, 304)
            for path in ("ggx/99.exr", "nothing.exr", "irradiance.png"):
                self.expect_problem(server.curl(f"/v1/environments/lawn/{path}"), 404)

    def test_what_is_refused(self):
        with Server("--environments", "9KiB") as server:
            self.expect_problem(self.put(server, "-bad"), 400)
            self.expect_problem(server.curl("/v1/environments/x", "-X", "PUT"), 400)
            self.expect_problem(server.curl("/v1/environments/x", "-X", "PUT", "--data-binary", "no picture"), 415)
            self.expect_problem(server.curl("/v1/environments/x", "-X", "POST", "-d", "x"), 405)
            self.assertEqual(self.put(server, "one").status, 201)
            self.expect_problem(self.put(server, "two"), 413)
            self.assertEqual(self.put(server, "one").status, 200)

    # Face by face a colour: what the server makes of it is downloaded and drawn as a map of its own.
    def test_a_cube_is_the_equirect_that_it_shows(self):
        side = 16
        cells = {(2, 1): (200, 20, 20), (0, 1): (20, 200, 20), (1, 0): (20, 20, 200),
                 (1, 2): (200, 200, 20), (1, 1): (20, 200, 200), (3, 1): (200, 20, 200)}
        path = os.path.join(self.folder.name, "cross.hdr")
        with open(path, "wb") as file:
            file.write(support.write_hdr(4 * side, 3 * side,
                                         lambda x, y: (*cells.get((x // side, y // side), (0, 0, 0)), 129)))
        with Server() as server:
            report = json.loads(self.put(server, "cross", path).body)
            self.assertEqual((report["layout"], report["width"], report["height"]), ("horizontal-cross", 64, 32))
            self.assertEqual(json.loads(self.put(server, "lawn").body)["layout"], "equirect")
            equirect = os.path.join(self.folder.name, "equirect.exr")
            with open(equirect, "wb") as file:
                file.write(server.curl("/v1/environments/cross/background.exr").body)
            self.assertEqual(json.loads(self.put(server, "flat", equirect).body)["layout"], "equirect")
            pixels = [answer.body[answer.body.index(b"IDAT"):] for answer in (self.draw(server, "cross"), self.draw(server, "flat"))]
            self.assertEqual(*pixels)  # what stands before names the request
            said = {"map": "environment:cross", "layout": "horizontal-cross",
                    "background": {"map": "environment:cross", "layout": "horizontal-cross"}}
            self.expect_picture(server.render({**small(), "environment": said}), 48, 32)
            wrong = server.render({**small(), "environment": {**said, "layout": "vertical-strip"}})
            self.expect_problem(wrong, 422)
            self.assertIn("horizontal-cross", json.loads(wrong.body)["detail"])
            nothing = server.render({**small(), "environment": {"map": "builtin:studio", "layout": "equirect"}})
            self.expect_problem(nothing, 422)
            self.assertEqual(json.loads(nothing.body)["pointer"], "/environment/layout")

    def test_a_restart_bakes_nothing_again(self):
        data = os.path.join(self.folder.name, "data")
        with Server("--data", data, *BAKES_ONLY) as server:
            self.put(server)
            first = self.draw(server)
        with Server("--data", data, *BAKES_ONLY) as server:
            second = self.draw(server)
        self.assertIn("bake;desc=disk", second.headers["server-timing"])
        self.assertEqual(first.body, second.body)

    # A background of its own: the environment out of focus, another map sharp, another map out of focus.
    def test_a_restart_blurs_nothing_again(self):
        data = os.path.join(self.folder.name, "data")
        other = os.path.join(self.folder.name, "other.hdr")
        with open(other, "wb") as file:
            file.write(sky(50))
        backgrounds = [{"type": "environment", "blurDegrees": 6},
                       {"type": "environment", "map": "environment:other"},
                       {"type": "environment", "map": "environment:other", "blurDegrees": 20}]
        wanted = [{**small(), "environment": {"map": "environment:lawn", "background": background}}
                  for background in backgrounds]
        with Server("--data", data, *BAKES_ONLY) as server:
            self.put(server)
            self.put(server, "other", other)
            first = [server.render(request) for request in wanted]
        self.assertEqual(len({answer.body for answer in first}), len(wanted))
        for answer in first:
            self.assertNotIn("bake;desc=disk", answer.headers["server-timing"])
        with Server("--data", data, *BAKES_ONLY) as server:
            second = [server.render(request) for request in wanted]
            again = server.render({**wanted[0], "output": {"width": 47, "height": 32}})
        for one, other in zip(first, second):
            self.assertIn("bake;desc=disk", other.headers["server-timing"])
            self.assertEqual(one.body, other.body)
        self.assertIn("bake;desc=hit", again.headers["server-timing"])

    def test_a_damaged_background_is_blurred_again(self):
        data = os.path.join(self.folder.name, "data")
        request = {**small(), "environment": {"map": "environment:lawn", "background": {"type": "environment", "blurDegrees": 6}}}
        with Server("--data", data, *BAKES_ONLY) as server:
            self.put(server)
            kept = set(self.bakes(data))
            first = server.render(request)
            background, = set(self.bakes(data)) - kept
        with open(background, "r+b") as file:
            file.seek(-9, os.SEEK_END)
            byte = file.read(1)
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte[0] ^ 1]))
        for hit in (False, True):
            with Server("--data", data, *BAKES_ONLY) as server:
                again = server.render(request)
            self.assertEqual("bake;desc=disk" in again.headers["server-timing"], hit)
            self.assertEqual(first.body, again.body)

    def test_damaged_bakes_are_baked_again(self):
        data = os.path.join(self.folder.name, "data")
        with Server("--data", data, *BAKES_ONLY) as server:
            self.put(server)
            first = self.draw(server)
        for damage in (lambda content: content[:len(content) // 2], lambda content: b"", lambda content: b"x" + content[1:],
                       lambda content: content[:-9] + bytes([content[-9] ^ 1]) + content[-8:]):
            self.damage(data, damage)
            with Server("--data", data, *BAKES_ONLY) as server:
                again = self.draw(server)
            self.assertNotIn("bake;desc=disk", again.headers["server-timing"])
            self.assertEqual(first.body, again.body)

    def bakes(self, data):
        return [path for path in support.files_below(data) if path.endswith(".exr")]

    def damage(self, data, change):
        bakes = self.bakes(data)
        self.assertEqual(len(bakes), 1, bakes)
        with open(bakes[0], "rb") as file:
            content = file.read()
        with open(bakes[0], "wb") as file:
            file.write(change(content))

    def test_a_data_folder_that_cannot_be_written(self):
        blocked = os.path.join(self.folder.name, "blocked")
        with open(blocked, "w"):
            pass  # a file where the folder should be
        with Server("--data", blocked) as server:
            self.expect_picture(server.render(small()), 48, 32)
            self.assertTrue(server.alive())

    def test_killed_at_any_instant(self):
        data = os.path.join(self.folder.name, "data")
        for round_number in range(6):
            path = os.path.join(self.folder.name, f"sky{round_number}.hdr")
            with open(path, "wb") as file:
                file.write(sky(round_number))
            with Server("--data", data) as server:
                client = support.curl_process(f"{server.url}/v1/environments/lawn", "-X", "PUT", "--data-binary", f"@{path}")
                time.sleep(0.03 * round_number)
                server.process.send_signal(signal.SIGKILL)
                server.process.wait()
                client.communicate()
        with Server("--data", data) as server:
            self.assertIn(self.put(server).status, (200, 201))
            self.expect_picture(self.draw(server), 48, 32)
        left = [path for path in support.files_below(os.path.join(data, "bakes")) if not path.endswith(".exr")]
        self.assertEqual([path for path in left if "damaged" not in path], [])

    def test_a_hundred_at_once_bake_once(self):
        with Server("--queue", "128", "--seats", "4") as server:
            # Each another picture, so that each is drawn.
            bodies = [json.dumps({**small(width=20 + i), "environment": {"map": "part:sky"}}) for i in range(100)]
            clients = [support.curl_process(f"{server.url}/v1/renders", "-F", f"request={body};type=application/json",
                                            "-F", f"sky=@{self.hdr}") for body in bodies]
            answers = [support.answer_of(client) for client in clients]
            self.assertEqual({answer.status for answer in answers}, {200})
            self.assertEqual({answer.headers["cache-status"] for answer in answers}, {"furnace; fwd=miss; stored"})
            bakes_ms = [float(found.group(1)) for answer in answers
                        if (found := re.search(r"bake;dur=([0-9.]+)", answer.headers["server-timing"]))]
            self.assertEqual(len([ms for ms in bakes_ms if ms > 0]), 1, bakes_ms)


class CommandLine(unittest.TestCase):
    def test_bake_writes_every_map(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "sky.hdr")
            with open(path, "wb") as file:
                file.write(sky())
            out = os.path.join(folder, "maps")
            for method in ("spectral", "riemann"):
                subprocess.run([support.FURNACE, "bake", path, "-o", out, "--irradiance-method", method], check=True,
                               stderr=subprocess.DEVNULL)
                with open(os.path.join(out, "bake.json")) as file:
                    report = json.load(file)
                self.assertEqual(report["irradianceMethod"], method)
                for entry in report["maps"]:
                    self.assertTrue(os.path.getsize(os.path.join(out, entry["file"])) > 300, entry)
                shutil.rmtree(out)

    def test_bake_takes_cubes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "strip.hdr")
            with open(path, "wb") as file:
                file.write(support.write_hdr(8, 48, lambda x, y: (128, 128, 128, 128)))
            run = lambda *layout: subprocess.run([support.FURNACE, "bake", path, "-o", os.path.join(folder, "maps"), *layout],
                                                 capture_output=True).returncode
            for layout in ((), ("--layout", "vertical-strip")):
                self.assertEqual(run(*layout), 0)
                with open(os.path.join(folder, "maps", "bake.json")) as file:
                    report = json.load(file)
                self.assertEqual((report["layout"], report["width"], report["height"]), ("vertical-strip", 32, 16))
            self.assertEqual(run("--layout", "equirect"), 1)
            self.assertEqual(run("--layout", "round"), 2)

    def test_failures(self):
        with tempfile.TemporaryDirectory() as folder:
            run = lambda *arguments: subprocess.run([support.FURNACE, "bake", *arguments], capture_output=True).returncode
            self.assertEqual(run(os.path.join(folder, "none.hdr"), "-o", folder), 1)
            self.assertEqual(run("-o", folder), 2)
            self.assertEqual(os.listdir(folder), [])


if __name__ == "__main__":
    support.main()
