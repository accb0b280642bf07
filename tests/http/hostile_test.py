"""Whatever comes over the wire: hostile_test.py FURNACE [unittest arguments]."""
import json
import os
import socket
import sys

import http_support as support
from http_support import Case, Server, small


class Hostile(Case):
    """Whatever comes, the server answers or hangs up, and goes on."""

    def say(self, server, data):
        with socket.create_connection(("127.0.0.1", server.port), timeout=support.PATIENCE_S) as connection:
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(65536):
                    pass
            except ConnectionError:
                pass

    def expect_alive(self, server):
        self.assertTrue(server.alive(), server.log_text()[-2000:])
        self.expect_picture(server.render(small()), 48, 32)

    def test_raw_requests(self):
        requests = [
            b"", b"\r\n", b"\0" * 100, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"GET / HTTP/1.1\r\nHost: h\r\nContent-Length: -1\r\n\r\n",
            b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n",
            b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n-1\r\n",
            b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nContent-Length: 99999999999999999999\r\n\r\n",
            b"GET /%00%ff%zz%u1234 HTTP/1.1\r\nHost: h\r\n\r\n", b"GET /\xff\xfe HTTP/1.1\r\nHost: h\xff\r\n\xff: \xff\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: h\r\nRange: bytes=" + b"0-," * 2700 + b"\r\n\r\n",
            b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 100000 + b"\r\n", b"A" * 1000000,
        ]
        folder = support.data_folder("malformed", "http-requests")
        if folder is None:
            print("no development data: only the test's own raw requests are sent", file=sys.stderr)
        else:
            for path in support.files_below(folder):
                with open(path, "rb") as file:
                    requests.append(file.read())
        with Server() as server:
            for request in requests:
                self.say(server, request)
            self.expect_alive(server)

    def test_multipart_bodies(self):
        folder = support.data_folder("malformed", "http-multipart")
        if folder is None:
            self.skipTest("no development data: malformed/http-multipart")
        with Server() as server:
            for path in support.files_below(folder):
                with open(path, "rb") as file:
                    body = file.read()
                boundary = body.split(b"\r\n")[0].split(b"\n")[0].lstrip(b"-").decode("latin-1") or "x"
                answer = server.curl("/v1/renders", "-H", f"Content-Type: multipart/form-data; boundary={boundary}",
                                     "--data-binary", f"@{path}")
                self.assertLess(answer.status, 500, path)
            self.expect_alive(server)

    def test_json_documents(self):
        folder = support.data_folder("malformed", "json")
        if folder is None:
            self.skipTest("no development data: malformed/json")
        with Server() as server:
            for path in support.files_below(folder):
                name = os.path.basename(path)
                if not name.endswith(".json"):
                    continue
                answer = server.curl("/v1/renders", "-H", "Content-Type: application/json", "--data-binary", f"@{path}")
                self.assertIn(answer.status, (200, 400, 413, 422), name)
                if name.startswith("n_"):
                    self.assertEqual(answer.status, 400, name)
                if name.startswith("y_"):
                    self.assertIn(answer.status, (200, 400, 422), name)  # 400: duplicate keys are ours to refuse
            self.expect_alive(server)

    def test_models_and_environments(self):
        folders = [support.data_folder("malformed", name) for name in ("gltf-other", "gltf-validator", "exr", "hdr", "png")]
        if None in folders:
            self.skipTest("no development data: malformed")
        with Server("--timeout", "60s") as server:
            for folder in folders:
                kind = "map" if os.path.basename(folder) in ("exr", "hdr", "png") else "model"
                for path in support.files_below(folder)[::7]:  # the floors' own tests read them all
                    if path.endswith(".report.json"):
                        continue
                    request = {**small(16, 16), ("environment" if kind == "map" else "scene"): {kind: "part:file"}}
                    answer = server.curl("/v1/renders", "-F", f"request={json.dumps(request)}", "-F", f'file=@"{path}"')
                    self.assertLess(answer.status, 500, path)
            self.expect_alive(server)


if __name__ == "__main__":
    support.main()
