#!/usr/bin/env python3
"""Uploads: sized and chunked bodies, models of them, and a server that is killed in the middle."""
import hashlib
import io
import json
import os
import socket
import tempfile
import time
import unittest
import zipfile

import http_support as support
from http_support import Case, Server, small, textured_quad


def sha256(data):
    return hashlib.sha256(data).hexdigest()


def zipped(files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return out.getvalue()


class Assets(Case):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.data = os.path.join(self.folder.name, "data")
        self.uploads = os.path.join(self.data, "assets", "uploads")

    def tearDown(self):
        self.folder.cleanup()

    def file(self, data):
        path = os.path.join(self.folder.name, sha256(data))
        with open(path, "wb") as file:
            file.write(data)
        return path

    def put(self, server, data, *flags, name=None):
        return server.curl(f"/v1/assets/{name or sha256(data)}", "-X", "PUT", "--data-binary", f"@{self.file(data)}", *flags)

    def post(self, server, data, *flags):
        answer = server.curl("/v1/assets", "--data-binary", f"@{self.file(data)}", *flags)
        self.assertIn(answer.status, (200, 201), answer.body[:300])
        return json.loads(answer.body)["id"]

    def test_sized_and_chunked_bodies(self):
        data = os.urandom(3 << 20)
        with Server("--data", self.data, "--max-body", "1MiB", "--max-bodies", "1MiB", "--max-asset", "4MiB") as server:
            self.assertEqual(self.put(server, data, "-H", "Transfer-Encoding: chunked").status, 201)
            self.assertEqual(self.put(server, data).status, 200)
            got = server.curl(f"/v1/assets/{sha256(data)}")
            self.assertEqual((got.status, got.body == data), (200, True))
            self.assertEqual(server.curl(f"/v1/assets/{sha256(data)}", "-I").headers["content-length"], str(len(data)))
            self.expect_problem(self.put(server, data, name="0" * 64), 422)
            for flags in ([], ["-H", "Transfer-Encoding: chunked"]):
                self.expect_problem(self.put(server, bytes(5 << 20), *flags), 413)
            self.assertEqual(os.listdir(self.uploads), [])
            self.assertEqual(server.metric("furnace_assets"), 1)
            self.assertEqual(server.curl(f"/v1/assets/{sha256(data)}", "-X", "DELETE").status, 204)
            self.expect_problem(server.curl(f"/v1/assets/{sha256(data)}"), 404)

    def test_a_zip_is_a_model(self):
        files = textured_quad()
        document = lambda model: {**small(), "scene": {"model": model}}
        with Server("--data", self.data) as server:
            archive = self.post(server, zipped({f"quad/{name}": data for name, data in files.items()}))
            from_zip = server.render(document(archive))
            self.expect_picture(from_zip, 48, 32)
            self.assertEqual(from_zip.headers["furnace-notes"], "0")
            flags = [flag for name in files for flag in ("-F", f"{name}=@{self.file(files[name])};filename={name}")]
            parts = server.curl("/v1/renders", "-F", f"request={json.dumps(document('part:quad.gltf'))};type=application/json", *flags)
            self.assertEqual(from_zip.headers["etag"], parts.headers["etag"])
            report = server.curl(f"/v1/assets/{archive.removeprefix('asset:sha256-')}/inspect")
            self.assertEqual(report.status, 200, report.body[:300])
            two = self.post(server, zipped({"a.gltf": files["quad.gltf"], "b.gltf": files["quad.gltf"]}))
            self.assertIn("a.gltf, b.gltf", self.expect_problem(server.render(document(two)), 422)["detail"])
            self.expect_problem(server.render(document("asset:sha256-" + "0" * 64)), 404)
        with Server("--data", self.data) as server:
            self.expect_picture(server.render(document(archive)), 48, 32)

    def test_killed_during_an_upload(self):
        with Server("--data", self.data) as server:
            kept = self.post(server, b"kept")
            body = os.urandom(1 << 20)
            with socket.create_connection(("127.0.0.1", server.port)) as client:
                client.sendall(f"PUT /v1/assets/{sha256(body)} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n".encode())
                client.sendall(body[:len(body) // 2])
                end = time.monotonic() + support.PATIENCE_S
                while not os.listdir(self.uploads) and time.monotonic() < end:
                    time.sleep(0.01)
                self.assertEqual(len(os.listdir(self.uploads)), 1)
                server.process.kill()
                server.process.wait()
        with Server("--data", self.data) as server:
            self.assertEqual(os.listdir(self.uploads), [])
            self.assertEqual(server.curl(f"/v1/assets/{kept.removeprefix('asset:sha256-')}").body, b"kept")
            self.expect_problem(server.curl(f"/v1/assets/{sha256(body)}"), 404)
            self.assertEqual(self.put(server, body).status, 201)

    def test_without_data_nothing_is_kept(self):
        with Server() as server:
            self.assertIn("--data", self.expect_problem(self.put(server, b"x"), 507)["detail"])


if __name__ == "__main__":
    support.main()
