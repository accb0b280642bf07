"""The HTTP door of the real program, asked by a real curl: http_test.py FURNACE [unittest arguments]."""
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

if __name__ == "__main__" and len(sys.argv) > 1 and os.path.isfile(sys.argv[1]):
    os.environ["FURNACE_BINARY"] = sys.argv.pop(1)

import http_support as support  # noqa: E402  (reads FURNACE_BINARY)
from http_support import Server, small, slow  # noqa: E402


class Case(unittest.TestCase):
    def expect_problem(self, answer, status):
        self.assertEqual(answer.status, status, answer)
        self.assertEqual(answer.headers["content-type"], "application/problem+json")
        self.assertEqual(answer.headers["cache-control"], "no-store")
        problem = json.loads(answer.body)
        self.assertEqual(problem["status"], status)
        self.assertTrue(problem["type"] and problem["title"] and problem["detail"])
        return problem

    def expect_picture(self, answer, width, height):
        self.assertEqual(answer.status, 200, answer.body[:2000])
        self.assertEqual(answer.headers["content-type"], "image/png")
        self.assertEqual(int(answer.headers["content-length"]), len(answer.body))
        got_width, got_height, _, pixels = support.read_png(answer.body)
        self.assertEqual((got_width, got_height), (width, height))
        return pixels


class Pictures(Case):
    """Questions that one server answers one after the other."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server("--max-body", "200KiB")

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.log_text()
        cls.server.process.stdout.close()

    def test_200_png(self):
        answer = self.server.render(small(48, 32))
        pixels = self.expect_picture(answer, 48, 32)
        self.assertGreater(len(set(pixels)), 100, "the default picture is not one of a few colours")
        self.assertRegex(answer.headers["etag"], r'^"[0-9a-f]{64}"$')
        self.assertEqual(answer.headers["vary"], "Accept")
        self.assertEqual(answer.headers["x-content-type-options"], "nosniff")
        self.assertIn("default-src 'none'", answer.headers["content-security-policy"])
        self.assertTrue(answer.headers["furnace-fingerprint"])
        self.assertRegex(answer.headers["server-timing"], r"queue;.*, decode;.*, bake;.*, upload;.*, draw;.*, encode;")
        self.assertRegex(answer.headers["furnace-notes"], r"^0$")

    def test_200_exr(self):
        for answer in (self.server.render(small(), "-H", "Accept: image/x-exr"), self.server.render(small(format="exr"))):
            self.assertEqual(answer.status, 200, answer.body[:500])
            self.assertEqual(answer.headers["content-type"], "image/x-exr")
            self.assertEqual(answer.body[:4], b"\x76\x2f\x31\x01")

    def test_the_printed_command_works(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(self.server.lines[1], shell=True, check=True, cwd=folder, stderr=subprocess.DEVNULL)
            with open(os.path.join(folder, "picture.png"), "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_transparent_background_has_alpha(self):
        answer = self.server.render({**small(), "environment": {"background": {"type": "transparent"}}})
        pixels = self.expect_picture(answer, 48, 32)
        self.assertEqual(pixels[0][3], 0)
        self.assertIn(255, {pixel[3] for pixel in pixels})

    def test_304(self):
        first = self.server.render(small())
        drawn = self.server.metric("furnace_renders_total")
        again = self.server.render(small(), "-H", f"If-None-Match: {first.headers['etag']}")
        self.assertEqual((again.status, again.body), (304, b""))
        self.assertEqual(again.headers["etag"], first.headers["etag"])
        self.assertEqual(self.server.metric("furnace_renders_total"), drawn, "it was drawn for nothing")

    def test_same_request_same_bytes(self):
        self.assertEqual(self.server.render(small()).body, self.server.render(small()).body)

    def test_400(self):
        self.expect_problem(self.server.render("{"), 400)
        self.expect_problem(self.server.render('{"scene":{},"scene":{}}'), 400)
        self.expect_problem(self.server.curl("/v1/renders", "-H", "Content-Type: multipart/form-data; boundary=x",
                                             "--data-binary", "--y"), 400)

    def test_404(self):
        self.expect_problem(self.server.curl("/v1/nothing"), 404)
        problem = self.expect_problem(self.server.render({"scene": {"model": "part:absent.glb"}}), 404)
        self.assertIn("/scene/model", json.dumps(problem))

    def test_405(self):
        answer = self.server.curl("/v1/renders")
        self.expect_problem(answer, 405)
        self.assertEqual(answer.headers["allow"], "POST, OPTIONS")
        self.expect_problem(self.server.curl("/version", "-X", "DELETE"), 405)

    def test_406(self):
        self.expect_problem(self.server.render(small(), "-H", "Accept: text/html"), 406)
        self.expect_problem(self.server.render(small(format="exr"), "-H", "Accept: image/png"), 406)

    def test_413(self):
        with tempfile.NamedTemporaryFile() as large:
            large.write(b" " * (300 << 10))
            large.flush()
            for header in ("Expect: 100-continue", "Expect:", "Transfer-Encoding: chunked"):
                answer = self.server.curl("/v1/renders", "-H", "Content-Type: application/json", "-H", header,
                                          "--data-binary", f"@{large.name}")
                self.expect_problem(answer, 413)
        self.expect_problem(self.server.render(small(5000, 5)), 413)

    def test_414(self):
        self.expect_problem(self.server.curl("/" + "a" * 9000), 414)

    def test_415(self):
        self.expect_problem(self.server.curl("/v1/renders", "-d", "{}"), 415)
        answer = self.server.render(small(), "-H", "Content-Encoding: gzip")
        self.expect_problem(answer, 415)

    def test_422(self):
        problem = self.expect_problem(self.server.render({"output": {"width": 0, "colour": "red"}}), 422)
        self.assertEqual({error["pointer"] for error in problem["errors"]}, {"/output/width", "/output/colour"})
        self.assertTrue(problem["instance"])

    def test_431(self):
        answer = self.server.curl("/version", *(flag for i in range(10) for flag in ("-H", f"X-{i}: " + "a" * 5000)))
        self.expect_problem(answer, 431)

    def test_head(self):
        answer = self.server.curl("/openapi.json", "--head")
        self.assertEqual((answer.status, answer.body), (200, b""))
        self.assertGreater(int(answer.headers["content-length"]), 1000)

    def test_documents(self):
        self.assertEqual(json.loads(self.server.curl("/openapi.json").body)["openapi"][:3], "3.1")
        self.assertIn("properties", json.loads(self.server.curl("/v1/schema.json").body))
        fingerprint = self.server.render(small()).headers["furnace-fingerprint"]
        self.assertIn(fingerprint, json.dumps(json.loads(self.server.curl("/v1/capabilities").body)))
        self.assertEqual(json.loads(self.server.curl("/version").body)["fingerprint"], fingerprint)
        self.assertIn(b"/v1/renders", self.server.curl("/").body)

    def test_health(self):
        self.assertEqual(self.server.curl("/livez").status, 200)
        ready = self.server.curl("/readyz")
        self.assertEqual(ready.status, 200, ready.body)

    def test_request_ids(self):
        answer = self.server.render("{", "-H", "X-Request-Id: mine-7")
        self.assertEqual(answer.headers["x-request-id"], "mine-7")
        self.assertIn("mine-7", self.expect_problem(answer, 400)["instance"])
        self.assertIn('"request":"mine-7"', self.server.log_text())

    def test_keep_alive(self):
        process = subprocess.run(["curl", "-sS", "-w", "%{num_connects}\n", "-o", "/dev/null", f"{self.server.url}/version",
                                  "-o", "/dev/null", f"{self.server.url}/version"], capture_output=True, check=True)
        self.assertEqual(process.stdout, b"1\n0\n")


class Multipart(Case):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.folder = tempfile.TemporaryDirectory()
        for name, content in support.textured_quad().items():
            with open(os.path.join(cls.folder.name, name), "wb") as file:
                file.write(content)

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.log_text()
        cls.server.process.stdout.close()
        cls.folder.cleanup()

    def post(self, request, *names, **renamed):
        forms = [f"request={json.dumps(request)};type=application/json"] if request is not None else []
        forms += [f"{name}=@{os.path.join(self.folder.name, name)}" for name in names]
        forms += [f"{part}=@{os.path.join(self.folder.name, name)}" for part, name in renamed.items()]
        return self.server.curl("/v1/renders", *(flag for form in forms for flag in ("-F", form)))

    def request(self, reference, **more):
        return {**small(32, 32), "scene": {"model": reference}, "camera": {"orbit": {"azimuthDegrees": 0, "elevationDegrees": 0}},
                "environment": {"map": {"color": [1, 1, 1]}}, **more}

    def test_gltf_with_buffer_and_texture(self):
        answer = self.post(self.request("part:quad.gltf"), "quad.gltf", "quad.bin", "red.png")
        pixels = self.expect_picture(answer, 32, 32)
        red, green, blue = pixels[16 * 32 + 16][:3]
        self.assertGreater(red, 2 * max(green, blue), f"the middle is {red, green, blue}, not the texture's red")

    def test_parts_by_name_and_by_file_name(self):
        by_file = self.post(self.request("part:quad.gltf"), "quad.gltf", "quad.bin", "red.png")
        by_part = self.post(self.request("part:model"), "quad.bin", "red.png", model="quad.gltf")
        self.assertEqual(by_file.body, by_part.body)
        self.assertEqual(by_file.headers["etag"], by_part.headers["etag"])

    def test_a_missing_texture_is_noted(self):
        answer = self.post(self.request("part:quad.gltf"), "quad.gltf", "quad.bin")
        self.assertEqual(answer.status, 200, answer.body[:500])
        self.assertRegex(answer.headers["furnace-notes"], r'^1;codes="[a-z-]+"$')

    def test_strict_turns_the_note_into_422(self):
        answer = self.post(self.request("part:quad.gltf", strict=True), "quad.gltf", "quad.bin")
        problem = self.expect_problem(answer, 422)
        self.assertEqual(len(problem["errors"]), 1)

    def test_a_missing_buffer_is_an_error(self):
        self.expect_problem(self.post(self.request("part:quad.gltf"), "quad.gltf"), 422)

    def test_without_a_request_part(self):
        self.expect_picture(self.post(None, "red.png"), 1024, 1024)

    def test_a_file_that_is_no_model(self):
        self.expect_problem(self.post(self.request("part:red.png"), "red.png"), 422)


class Limits(Case):
    """Each question needs a server of its own."""

    def test_429(self):
        with Server("--seats", "1", "--queue", "0") as server:
            first = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(slow()))
            while server.metric("furnace_seats_in_use") == 0:
                self.assertIsNone(first.poll(), "the slow picture was drawn before anyone could see it")
            answer = server.render(small())
            self.expect_problem(answer, 429)
            self.assertEqual(answer.headers["retry-after"], "1")
            first.kill()
            first.communicate()

    def test_504(self):
        with Server("--timeout", "1ms") as server:
            self.expect_problem(server.render(slow()), 504)
            self.assertEqual(server.curl("/livez").status, 200)

    def test_a_client_that_leaves_frees_its_seat(self):
        with Server("--seats", "1", "--queue", "0") as server:
            leaving = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(slow()))
            while server.metric("furnace_seats_in_use") == 0:
                self.assertIsNone(leaving.poll())
            leaving.kill()
            leaving.communicate()
            while server.metric("furnace_seats_in_use") == 1:
                pass  # ends when it is cancelled; the test's own time limit judges
            self.assertEqual(server.metric("furnace_clients_gone_total"), 1)
            self.expect_picture(server.render(small()), 48, 32)

    def test_sigterm_lets_requests_end(self):
        request = {"output": {"width": 700, "height": 700, "samples": 16}}
        with Server() as server:
            working = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(request))
            while server.metric("furnace_seats_in_use") == 0:
                self.assertIsNone(working.poll())
            server.process.send_signal(signal.SIGTERM)
            answer = support.answer_of(working)
            self.assertEqual(answer.status, 200, answer.body[:500])
            self.assertEqual(server.process.wait(support.PATIENCE_S), 0)
            self.assertIn("server.stopped", server.log_text())

    def test_sigterm_does_not_wait_for_ever(self):
        with Server("--drain-timeout", "1ms") as server:
            working = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(slow()))
            while server.metric("furnace_seats_in_use") == 0:
                self.assertIsNone(working.poll())
            server.process.send_signal(signal.SIGTERM)
            self.expect_problem(support.answer_of(working), 504)
            self.assertEqual(server.process.wait(support.PATIENCE_S), 0)

    def test_slow_clients_do_not_block_others(self):
        with Server("--header-timeout", "60s") as server:
            slow_ones = []
            for _ in range(60):
                slow_one = socket.create_connection(("127.0.0.1", server.port))
                slow_one.sendall(b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nX: ")
                slow_ones.append(slow_one)
            self.expect_picture(server.render(small()), 48, 32)
            for slow_one in slow_ones:
                slow_one.close()

    def test_many_clients_at_once(self):
        with Server("--queue", "40") as server:
            clients = [support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(small()))
                       for _ in range(24)]
            bodies = {support.answer_of(client).body for client in clients}
            self.assertEqual(len(bodies), 1)

    def test_two_processes_same_bytes(self):
        answers = []
        for _ in range(2):
            with Server() as server:
                answers.append(server.render(small(64, 64, format="exr")))
        self.assertEqual(answers[0].status, 200)
        self.assertEqual(answers[0].body, answers[1].body)
        self.assertEqual(answers[0].headers["etag"], answers[1].headers["etag"])

    def test_admin_listener(self):
        with Server("--admin-listen", "127.0.0.1:0") as server:
            admin = f"http://127.0.0.1:{server.admin_port()}"
            for path in ("/livez", "/readyz", "/metrics", "/version"):
                self.assertEqual(server.curl(path, base=admin).status, 200, path)
            self.expect_problem(server.curl("/v1/renders", base=admin), 404)
            self.expect_problem(server.curl("/metrics"), 404)
            self.assertEqual(server.curl("/livez").status, 200)

    def test_files_below_configured_roots_only(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "inside"))
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, "inside", name), "wb") as file:
                    file.write(content)
            with open(os.path.join(folder, "outside.gltf"), "wb") as file:
                file.write(support.textured_quad()["quad.gltf"])
            os.symlink("../outside.gltf", os.path.join(folder, "inside", "link.gltf"))
            with Server("--assets", os.path.join(folder, "inside")) as server:
                self.expect_picture(server.render({**small(), "scene": {"model": "file:quad.gltf"}}), 48, 32)
                for escape in ("file:../outside.gltf", "file:link.gltf", f"file:{folder}/outside.gltf", "file:/etc/passwd",
                               "file:absent.gltf", "file:%2e%2e/outside.gltf"):
                    answer = server.render({**small(), "scene": {"model": escape}})
                    self.assertIn(answer.status, (404, 422), escape)
                    self.assertNotIn(folder.encode(), answer.body)


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


class CommandLine(Case):
    def run_furnace(self, *arguments, status=0, data=None, folder=None, environment=None):
        done = subprocess.run([os.path.abspath(support.FURNACE), *arguments], capture_output=True, input=data, cwd=folder,
                              timeout=support.PATIENCE_S, env={**os.environ, **(environment or {})})
        self.assertEqual(done.returncode, status, (arguments, done.stdout[-500:], done.stderr[-2000:]))
        return done

    def test_render_a_request_from_stdin_to_stdout(self):
        done = self.run_furnace("render", "-", "-o", "-", data=json.dumps(small()).encode())
        self.assertEqual(support.read_png(done.stdout)[:2], (48, 32))
        events = [json.loads(line)["event"] for line in done.stderr.splitlines()]
        self.assertIn("render.done", events)

    def test_same_bytes_as_over_http(self):
        with Server() as server:
            over_http = server.render(small()).body
        done = self.run_furnace("render", "-", "-o", "-", data=json.dumps(small()).encode())
        self.assertEqual(done.stdout, over_http)

    def test_render_a_model_with_options(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)
            self.run_furnace("render", "quad.gltf", "-o", "out.png", "--width", "40", "--height", "30", "--samples", "1",
                             "--azimuth", "0", "--elevation", "0", "--background", "transparent", "--environment", "overcast",
                             "--repeat", "2", folder=folder)
            with open(os.path.join(folder, "out.png"), "rb") as file:
                width, height, channels, pixels = support.read_png(file.read())
            self.assertEqual((width, height, channels), (40, 30, 4))
            self.assertGreater(pixels[15 * 40 + 20][0], pixels[15 * 40 + 20][1])
            self.run_furnace("render", "quad.gltf", "-o", "out.exr", "--width", "40", "--height", "30", "--samples", "1", folder=folder)
            with open(os.path.join(folder, "out.exr"), "rb") as file:
                self.assertEqual(file.read(4), b"\x76\x2f\x31\x01")

    def test_options_override_a_request(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "request.json"), "w", encoding="utf-8") as file:
                json.dump(small(), file)
            self.run_furnace("render", "request.json", "-o", "out.png", "--width", "20", folder=folder)
            with open(os.path.join(folder, "out.png"), "rb") as file:
                self.assertEqual(support.read_png(file.read())[:2], (20, 32))

    def test_failures_are_1_with_a_pointer(self):
        done = self.run_furnace("render", "-", "-o", "-", data=b'{"output":{"width":0}}', status=1)
        self.assertIn(b"/output/width", done.stderr)
        self.run_furnace("render", "absent.glb", "-o", "-", status=1)
        self.run_furnace("render", "-", "-o", "/no/such/folder/out.png", data=json.dumps(small()).encode(), status=1)

    def test_wrong_usage_is_2(self):
        for wrong in ([], ["fly"], ["render"], ["render", "-"], ["render", "-", "-o", "x.png", "--width", "many"],
                      ["serve", "--queue", "-1"], ["serve", "--listen", "nowhere"], ["serve", "--no-such-flag", "1"]):
            self.run_furnace(*wrong, status=2)

    def test_every_configuration_problem_is_told(self):
        done = self.run_furnace("serve", "--queue", "many", "--timeout", "3", status=2, environment={"FURNACE_SEATS": "-4"})
        for name in (b"--queue", b"--timeout", b"FURNACE_SEATS"):
            self.assertIn(name, done.stderr)

    def test_check_config(self):
        done = self.run_furnace("check-config", "--queue", "5", environment={"FURNACE_SEATS": "3", "FURNACE_SEETS": "3"})
        self.assertIn(b"\nqueue = 5\n", done.stdout)
        self.assertIn(b"\nseats = 3\n", done.stdout)
        self.assertIn(b"FURNACE_SEETS", done.stderr)
        self.run_furnace("check-config", "--queue", "many", status=1)

    def test_an_address_in_use_is_a_failure(self):
        with Server() as server:
            done = self.run_furnace("serve", "--listen", f"127.0.0.1:{server.port}", status=1)
            self.assertIn(b"cannot listen", done.stderr)

    def test_doctor(self):
        done = self.run_furnace("doctor")
        self.assertIn(b"[works]", done.stdout)
        report = json.loads(self.run_furnace("doctor", "--json").stdout)
        self.assertTrue(report["usable"])
        self.assertTrue(any(device["usable"] and device["renderer"] for device in report["devices"]))

    def test_version_and_help(self):
        self.assertRegex(self.run_furnace("version").stdout.decode(), r"^furnace \d+\.\d+\.\d+\+[0-9a-f]{12}\n$")
        self.assertIn(b"FURNACE_LISTEN", self.run_furnace("serve", "--help").stdout)


if __name__ == "__main__":
    unittest.main()
