#!/usr/bin/env python3
"""Files of other servers: what is fetched, what is not, and what is told of it."""
import gzip
import json
import tempfile
import time

import http_support as support
from http_support import Case, Server, small, textured_quad
from outbound_support import Receiver, certificate, endless, raw, redirects, replies, resets, wait_for_job, waits


def model(url):
    return {**small(), "scene": {"model": url}}


def serve_quad(receiver, folder="/m/"):
    for name, content in textured_quad().items():
        receiver.answers[folder + name] = replies(200, content, ETag='"1"')
    return f"{receiver.origin}{folder}quad.gltf"


class Remote(Case):
    def setUp(self):
        self.receiver = Receiver()
        self.addCleanup(self.receiver.__exit__)

    def server(self, *flags, **more):
        return Server("--remote-allow", f"example.com, {self.receiver.origin}", *flags, **more)

    def expect_refusal(self, answer, status, pointer="/scene/model"):
        problem = self.expect_problem(answer, status)
        self.assertEqual(problem["pointer"], pointer)
        return problem["detail"]

    def test_nothing_is_fetched_unless_allowed(self):
        with Server() as server:
            detail = self.expect_refusal(server.render(model(serve_quad(self.receiver))), 422)
            self.assertIn("remote-allow", detail)
            self.assertIs(json.loads(server.curl("/v1/capabilities").body)["remoteFiles"], False)
        self.assertEqual(self.receiver.seen, [])

    def test_a_model_with_what_it_names_is_fetched_once(self):
        url = serve_quad(self.receiver)
        # The environment's proxy would not answer.
        with self.server(environment={"http_proxy": "http://127.0.0.1:1", "all_proxy": "http://127.0.0.1:1"}) as server:
            self.assertIs(json.loads(server.curl("/v1/capabilities").body)["remoteFiles"], True)
            answer = server.render(model(url))
            self.expect_picture(answer, 48, 32)
            with tempfile.TemporaryDirectory() as folder:
                flags = []
                for name, content in textured_quad().items():
                    with open(f"{folder}/{name}", "wb") as file:
                        file.write(content)
                    flags += ["-F", f"{name}=@{folder}/{name}"]
                parts = server.curl("/v1/renders", "-F", f"request={json.dumps(model('part:quad.gltf'))};type=application/json", *flags)
            self.assertEqual(answer.headers["etag"], parts.headers["etag"], "a URL is no part of a picture, its bytes are")
            in_url = server.curl(f"/v1/render?model={url}&width=48&height=32&samples=1")
            self.assertEqual(in_url.status, 200, in_url.body)
            job = server.render(model(url), "-H", "Prefer: respond-async").headers["location"]
            self.assertEqual(wait_for_job(server, job, lambda job: "result" in job)["status"], "succeeded")
            report = server.curl("/v1/inspect", "-H", "Content-Type: application/json", "--data-binary", json.dumps({"model": url}))
            self.assertEqual(report.status, 200, report.body)
            self.assertEqual(server.metric("furnace_remote_fetches_total"), 3)
            self.assertEqual(server.metric("furnace_remote_bytes_total"), sum(map(len, textured_quad().values())))
        self.assertEqual(sorted(path for path, _, _ in self.receiver.seen), ["/m/quad.bin", "/m/quad.gltf", "/m/red.png"])
        headers = self.receiver.seen[0][1]
        self.assertTrue(headers["User-Agent"].startswith("furnace/"))
        self.assertEqual({"Authorization", "Cookie", "Accept-Encoding"} & set(headers.keys()), set())

    def test_what_is_not_fresh_is_asked_for_again(self):
        texture = textured_quad()["red.png"]
        self.receiver.answers["/t.png"] = lambda handler: (
            replies(304)(handler) if handler.headers["If-None-Match"] == '"v1"' else replies(200, texture, ETag='"v1"')(handler))
        document = {**small(), "scene": {"nodes": [{"mesh": "builtin:sphere", "material": "m"}],
                                         "materials": {"m": {"textures": {"baseColor": f"{self.receiver.origin}/t.png"}}}}}
        with self.server("--remote-freshness", "200ms") as server:
            tags = set()
            end = time.monotonic() + support.PATIENCE_S
            while not any(headers["If-None-Match"] for _, headers, _ in list(self.receiver.seen)):
                self.assertLess(time.monotonic(), end)
                answer = server.render(document)
                self.assertEqual(answer.status, 200, answer.body)
                tags.add(answer.headers["etag"])
            self.assertEqual(len(tags), 1)
            self.assertGreater(server.metric('furnace_remote_fetches_total{result="304"}'.replace("{", r"\{")), 0)

    def test_hosts_that_are_not_allowed(self):
        origin, port = self.receiver.origin, self.receiver.port
        serve_quad(self.receiver)
        with Server("--remote-allow", f"example.com, {origin}, http://localhost:{port}, http://[::ffff:127.0.0.1]:1") as server:
            for url in (f"https://127.0.0.1:{port}/m/quad.gltf", "http://127.0.0.1:1/", f"http://user@127.0.0.1:{port}/m/quad.gltf",
                        "https://other.example/", "https://example.com.other.example/", "http://example.com/", "https://example.com.:443/",
                        f"http://[::1]:{port}/", "https://2130706433/", "https://0x7f.1/", "HTTPS://[::ffff:127.0.0.1]/", "http:", "https://",
                        f"http://localhost:{port}/m/quad.gltf"):
                self.expect_refusal(server.render(model(url)), 422)
            detail = self.expect_refusal(server.render(model(f"http://localhost:{port}/m/quad.gltf")), 422)
            self.assertNotIn("127.0.0.1", detail)
            document = {**small(), "environment": {"map": "https://other.example/sky.hdr"}}
            self.expect_refusal(server.render(document), 422, "/environment/map")
        self.assertEqual(self.receiver.seen, [])

    def test_redirects(self):
        url = serve_quad(self.receiver)
        answers, origin = self.receiver.answers, self.receiver.origin
        with Receiver() as other, self.server() as server:
            other.answers["/m/quad.gltf"] = replies(200, b"{}")
            answers["/m/1"], answers["/m/2"], answers["/m/3"] = redirects("/m/quad.gltf"), redirects("1"), redirects(f"{origin}/m/2")
            answers["/m/4"] = redirects("3")
            answers["/m/loop"] = redirects("loop")
            answers["/m/away"] = redirects(f"{other.origin}/m/quad.gltf")
            answers["/m/local"] = redirects(f"http://localhost:{self.receiver.port}/m/quad.gltf")
            answers["/m/file"], answers["/m/none"] = redirects("file:///etc/passwd"), replies(302)
            self.assertEqual(server.render(model(f"{origin}/m/3")).headers["etag"], server.render(model(url)).headers["etag"])
            for place, status in (("4", 502), ("loop", 502), ("away", 422), ("local", 422), ("file", 502), ("none", 502)):
                self.expect_refusal(server.render(model(f"{origin}/m/{place}")), status)
            self.assertEqual(self.receiver.count("/m/loop"), 4)
            self.assertEqual(other.seen, [])

    def test_bad_answers(self):
        answers, origin = self.receiver.answers, self.receiver.origin
        answers["/large"] = replies(200, bytes(70_000))
        answers["/endless"] = endless
        answers["/claims"] = raw(b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n")
        answers["/short"] = raw(b"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nshort")
        answers["/nonsense"] = raw(b"nonsense\r\n\r\n")
        answers["/coded"] = replies(200, gzip.compress(b"{}"), Content_Encoding="gzip")
        answers["/reset"] = resets
        answers["/silent"] = raw(b"")
        answers["/500"], answers["/403"] = replies(500), replies(403)
        with self.server("--remote-max-bytes", "64KiB") as server:
            for place, status in (("large", 413), ("endless", 413), ("claims", 413), ("short", 502), ("nonsense", 502), ("coded", 502),
                                  ("reset", 502), ("silent", 502), ("500", 502), ("403", 502), ("nothing", 502)):
                with self.subTest(place):
                    detail = self.expect_refusal(server.render(model(f"{origin}/{place}")), status)
                    self.assertTrue(detail.startswith('/scene/model: "127.0.0.1" '), detail)

    def test_all_files_of_a_request_have_a_bound(self):
        answers, origin = self.receiver.answers, self.receiver.origin
        answers["/t.png"] = replies(200, support.write_png(64, 64, lambda x, y: (x * y % 251, x * x % 241, y * 37 % 239)))
        textures = {"baseColor": f"{origin}/t.png", "emissive": f"{origin}/t.png"}
        document = {**small(), "scene": {"nodes": [{"mesh": "builtin:sphere", "material": "m"}], "materials": {"m": {"textures": textures}}}}
        with self.server("--remote-max-bytes", "12KiB", "--remote-max-request", "12KiB") as server:
            problem = self.expect_problem(server.render(document), 413)
            self.assertTrue(problem["pointer"].startswith("/scene/materials/m/textures/"), problem)

    def test_slow_answers(self):
        self.receiver.answers["/slow"] = waits(self.receiver, replies(200, b"{}"))
        with self.server("--remote-timeout", "200ms") as server:
            self.expect_refusal(server.render(model(f"{self.receiver.origin}/slow")), 504)
        with self.server("--remote-timeout", "100s", "--timeout", "300ms") as server:
            self.expect_problem(server.render(model(f"{self.receiver.origin}/slow")), 504)

    def test_who_leaves_ends_the_fetch(self):
        self.receiver.answers["/slow"] = waits(self.receiver, replies(200, b"{}"))
        with self.server("--remote-timeout", "100s", "--timeout", "100s") as server:
            leaving = support.curl_process(server.url + "/v1/renders", "-H", "Content-Type: application/json", "--data-binary",
                                           json.dumps(model(f"{self.receiver.origin}/slow")))
            self.receiver.wait_for("/slow")
            leaving.kill()
            leaving.communicate()
            end = time.monotonic() + support.PATIENCE_S
            while server.metric("furnace_remote_fetches_total") < 1:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)

    def test_siblings_stay_in_the_models_folder(self):
        def name(uri):
            return lambda document: document["images"][0].update(uri=uri)

        answers, origin = self.receiver.answers, self.receiver.origin
        with self.server() as server:
            for folder, uri in (("/1/", "sub/red.png"), ("/2/", "a%20%3Fb%23.png")):
                files = textured_quad(name(uri))
                answers[folder + "quad.gltf"], answers[folder + "quad.bin"] = replies(200, files["quad.gltf"]), replies(200, files["quad.bin"])
                answers[folder + uri] = replies(200, files["red.png"])
                self.assertEqual(server.render({**model(f"{origin}{folder}quad.gltf"), "strict": True}).status, 200)
                self.assertEqual(self.receiver.count(folder + uri), 1)
            for uri in ("../red.png", "/red.png", "http://127.0.0.1/red.png"):
                answers[f"/m/q{len(uri)}.gltf"] = replies(200, textured_quad(name(uri))["quad.gltf"])
                self.expect_problem(server.render(model(f"{origin}/m/q{len(uri)}.gltf")), 422)
        self.assertEqual(self.receiver.count("/red.png"), 0)

    def test_https_with_certificates_of_ones_own(self):
        with tempfile.TemporaryDirectory() as folder:
            names = certificate(folder)
            with Receiver(names) as receiver:
                url = serve_quad(receiver)
                with Server("--remote-allow", receiver.origin) as server:
                    self.expect_refusal(server.render(model(url)), 502)
                self.assertEqual(receiver.seen, [])
                with Server("--remote-allow", receiver.origin, "--outbound-ca-file", names[0]) as server:
                    self.expect_picture(server.render(model(url)), 48, 32)


if __name__ == "__main__":
    support.main()
