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

    def piece(self, server, whole, first, end, **more):
        return self.put(server, whole[first:end], "-H", f"Content-Range: bytes {first}-{end - 1}/{len(whole)}", name=sha256(whole), **more)

    def received(self, server, whole):
        answer = server.curl(f"/v1/assets/{sha256(whole)}", "-X", "PUT", "-H", f"Content-Range: bytes */{len(whole)}", "-H", "Content-Length: 0")
        self.assertEqual(answer.status, 202, answer.body[:300])
        return int(answer.headers["upload-offset"])

    def test_an_upload_goes_on_where_it_broke_off(self):
        whole = os.urandom(2 << 20)
        with Server("--data", self.data) as server:
            self.assertEqual(self.piece(server, whole, 0, 500_000).status, 202)
            # The client goes in the middle of a piece.
            with socket.create_connection(("127.0.0.1", server.port)) as client:
                head = f"PUT /v1/assets/{sha256(whole)} HTTP/1.1\r\nHost: x\r\nContent-Range: bytes 500000-{len(whole) - 1}/{len(whole)}\r\nContent-Length: {len(whole) - 500_000}\r\n\r\n"
                client.sendall(head.encode() + whole[500_000:900_000])
                client.shutdown(socket.SHUT_WR)
                client.recv(1000)
            there = self.received(server, whole)
            self.assertTrue(500_000 <= there <= 900_000, there)
            self.assertEqual(self.piece(server, whole, there, 1_000_000).status, 202)
            server.process.kill()
            server.process.wait()
        with Server("--data", self.data) as server:
            self.assertEqual(self.received(server, whole), 1_000_000)
            wrong = self.piece(server, whole, 0, 10)
            self.assertEqual((wrong.status, wrong.headers["upload-offset"]), (409, "1000000"))
            self.assertEqual(self.piece(server, whole, 1_000_000, len(whole)).status, 201)
            self.assertEqual(server.curl(f"/v1/assets/{sha256(whole)}").body, whole)
            self.assertEqual(os.listdir(os.path.join(self.data, "assets", "partial")), [])

    def test_parts_of_a_file(self):
        data = os.urandom(300_000)
        with Server("--data", self.data) as server:
            name = f"/v1/assets/{sha256(data)}"
            self.put(server, data)
            part = server.curl(name, "-H", "Range: bytes=100000-199999")
            self.assertEqual((part.status, part.body), (206, data[100_000:200_000]))
            self.assertEqual((part.headers["content-range"], part.headers["content-length"]), ("bytes 100000-199999/300000", "100000"))
            self.assertEqual(server.curl(name, "-H", "Range: bytes=-5", "-H", f'If-Range: "{sha256(data)}"').body, data[-5:])
            self.assertEqual(server.curl(name, "-H", "Range: bytes=5-", "-H", 'If-Range: "other"').body, data)
            self.assertEqual(server.curl(name).headers["accept-ranges"], "bytes")
            beyond = server.curl(name, "-H", "Range: bytes=300000-")
            self.expect_problem(beyond, 416)
            self.assertEqual(beyond.headers["content-range"], "bytes */300000")
            picture = server.render(small())
            kept = server.curl(picture.headers["content-location"], "-H", "Range: bytes=8-15")
            self.assertEqual((kept.status, kept.body), (206, picture.body[8:16]))

    def test_forms_and_names_of_files(self):
        files = textured_quad()
        with Server("--data", self.data) as server:
            flags = [flag for name in files for flag in ("-F", f"{name}=@{self.file(files[name])};filename={name}")]
            answer = server.curl("/v1/assets", *flags)
            self.assertEqual(answer.status, 201, answer.body[:300])
            ids = {asset["name"]: asset["id"] for asset in json.loads(answer.body)["assets"]}
            self.assertEqual(ids.keys(), files.keys())
            scene = {"model": ids.pop("quad.gltf"), "files": ids}
            drawn = server.render({**small(), "scene": scene})
            self.expect_picture(drawn, 48, 32)
            self.assertEqual(drawn.headers["furnace-notes"], "0")
            report = server.curl("/v1/inspect", "-H", "Content-Type: application/json", "-d", json.dumps(scene))
            self.assertEqual(json.loads(report.body)["missingFiles"], [])
            scene["files"]["unknown.png"] = next(iter(ids.values()))
            self.assertEqual(self.expect_problem(server.render({**small(), "scene": scene}), 422)["pointer"], "/scene/files/unknown.png")

    def test_keys_have_their_own(self):
        keys = os.path.join(self.folder.name, "keys")
        with open(keys, "w", encoding="ascii") as file:
            for name, more in (("anna", ":0:0:8KiB"), ("berta", ""), ("root", "")):
                scopes = "assets,admin" if name == "root" else "assets"
                file.write(f"{name}:{scopes}:{sha256(name.encode())}{more}\n")
        with Server("--data", self.data, "--api-keys-file", keys) as server:
            key = lambda name: ("-H", f"X-Api-Key: {name}")
            self.assertEqual(self.put(server, b"1", *key("anna")).status, 201)
            self.assertEqual(self.put(server, b"2", *key("anna")).status, 201)
            self.assertIn("8192", self.expect_problem(self.put(server, b"3", *key("anna")), 413)["detail"])
            self.assertEqual(self.put(server, b"3", *key("berta")).status, 201)
            self.assertEqual(self.put(server, b"3", *key("anna")).status, 200)
            drop = lambda data, name: server.curl(f"/v1/assets/{sha256(data)}", "-X", "DELETE", *key(name))
            self.expect_problem(drop(b"3", "anna"), 403)
            self.assertEqual(drop(b"3", "root").status, 204)
            self.assertEqual(drop(b"1", "anna").status, 204)
            self.assertEqual(self.put(server, b"4", *key("anna")).status, 201)

    def test_without_data_nothing_is_kept(self):
        with Server() as server:
            self.assertIn("--data", self.expect_problem(self.put(server, b"x"), 507)["detail"])


if __name__ == "__main__":
    support.main()
