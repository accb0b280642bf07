#!/usr/bin/env python3
"""Repro bundles: made by the server, drawn again by the command line, without anything that the server had."""
import io
import json
import os
import subprocess
import tempfile
import zipfile

import http_support as support
from http_support import Case, Server, small, textured_quad


def write_files(folder, files):
    for name, data in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


class Bundles(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.replay_folder = os.path.join(self.folder.name, "elsewhere")
        self.served = os.path.join(self.folder.name, "served")
        os.makedirs(self.replay_folder)
        os.makedirs(self.served)

    def tearDown(self):
        self.folder.cleanup()

    def replay(self, bundle, *flags, status=0):
        with open(os.path.join(self.replay_folder, "bundle.zip"), "wb") as file:
            file.write(bundle)
        done = subprocess.run([os.path.abspath(support.FURNACE), "render", "bundle.zip", "-o", "out", *flags], capture_output=True,
                              cwd=self.replay_folder, timeout=support.PATIENCE_S, check=False)
        self.assertEqual(done.returncode, status, done.stderr[-2000:])
        events = [json.loads(line) for line in done.stderr.splitlines() if line.startswith(b"{")]
        verdicts = [event["verdict"] for event in events if event["event"] == "render.bundle"]
        if status != 0:
            return None, done.stderr
        with open(os.path.join(self.replay_folder, "out"), "rb") as file:
            return file.read(), verdicts[0]

    def make(self, server, document, *flags):
        answer = server.curl("/v1/bundles", "-H", "Content-Type: application/json", "--data-binary", json.dumps(document), *flags)
        self.assertEqual(answer.status, 200, answer.body[:500])
        self.assertEqual(answer.headers["content-type"], "application/zip")
        return answer

    def check(self, server, answer, picture):
        archive = zipfile.ZipFile(io.BytesIO(answer.body))
        about = json.loads(archive.read("bundle.json"))
        self.assertEqual(archive.read(about["picture"]), picture)
        self.assertIn(about["etag"][:12], answer.headers["content-disposition"])
        bytes_again, verdict = self.replay(answer.body)
        self.assertEqual(verdict, "the same bytes as the bundle's picture")
        self.assertEqual(bytes_again, picture)
        return archive

    def test_files_of_the_server_travel_along(self):
        write_files(self.served, textured_quad())
        write_files(self.served, {"sky.hdr": support.write_hdr(16, 8, lambda x, y: (100 + x, 128, 90 + y, 129))})
        document = {**small(), "scene": {"model": "file:quad.gltf"}, "environment": {"map": "file:sky.hdr"}}
        with Server("--assets", self.served) as server:
            picture = server.render(document).body
            archive = self.check(server, self.make(server, document), picture)
            request = json.loads(archive.read("request.json"))
            self.assertEqual(request["scene"]["files"].keys(), {"quad.bin", "red.png"})
            self.assertEqual(request["output"]["format"], "png")
            self.assertEqual(sum(name.startswith("parts/") for name in archive.namelist()), 4)

    def test_parts_and_exact_pixels(self):
        files = textured_quad()
        write_files(self.folder.name, files)
        document = {**small(format="exr"), "scene": {"model": "part:quad.gltf"}}
        flags = [flag for name in files for flag in ("-F", f"{name}=@{os.path.join(self.folder.name, name)};filename={name}")]
        form = ("-F", f"request={json.dumps(document)};type=application/json", *flags)
        with Server("--determinism", "exact") as server:
            self.check(server, server.curl("/v1/bundles", *form), server.curl("/v1/renders", *form).body)

    def test_the_default_picture_and_a_changed_one(self):
        with Server() as server:
            answer = self.make(server, small())
            self.check(server, answer, server.render(small()).body)
        changed = io.BytesIO()
        with zipfile.ZipFile(changed, "w") as out, zipfile.ZipFile(io.BytesIO(answer.body)) as archive:
            for name in archive.namelist():
                data = archive.read(name)
                out.writestr(name, data.replace(b'"width": 48', b'"width": 50') if name == "request.json" else data)
        _, verdict = self.replay(changed.getvalue())
        self.assertEqual(verdict, "other bytes than the bundle's picture, on the same build and driver")

    def test_what_is_wrong_is_told(self):
        with Server("--assets", self.served, "--max-bundle", "100") as server:
            write_files(self.served, textured_quad())
            too_large = server.curl("/v1/bundles", "-H", "Content-Type: application/json", "-d", json.dumps({"scene": {"model": "file:quad.gltf"}}))
            self.assertIn("100 bytes", self.expect_problem(too_large, 413)["detail"])
            self.expect_problem(server.curl("/v1/bundles", "-H", "Content-Type: application/json", "-d", '{"scene": 1}'), 422)
        for files in ({"bundle.json": b"{}"}, {"bundle.json": b'{"kind": "furnace-bundle-1"}'}):
            broken = io.BytesIO()
            with zipfile.ZipFile(broken, "w") as out:
                for name, data in files.items():
                    out.writestr(name, data)
            _, complaint = self.replay(broken.getvalue(), status=1)
            self.assertIn(b"bundle", complaint)


if __name__ == "__main__":
    support.main()
