"""The HTTP door of the real program, asked by a real curl: http_test.py FURNACE [unittest arguments]."""
import json
import os
import re
import signal
import socket
import subprocess
import tempfile

import http_support as support
from http_support import Case, Server, small, slow


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

    def test_layers_of_one_exr(self):
        wanted = ["depth", "diffuseEnvironment", "cryptoObject"]
        answer = self.server.render({**small(format="exr", layers=wanted), "scene": {"nodes": [{"mesh": "builtin:cube", "name": "die"}]}})
        self.assertEqual(answer.status, 200, answer.body[:500])
        header = answer.body[:4096]
        for channel in (b"R", b"depth.Z", b"diffuseEnvironment.G", b"cryptoObject02.A"):
            self.assertIn(b"\0" + channel + b"\0", header)
        self.assertIn(b'{"die":"', header)
        self.assertNotEqual(answer.headers["etag"], self.server.render(small(format="exr")).headers["etag"])
        refused = self.server.render(small(layers=wanted))
        self.assertEqual(refused.status, 422)
        self.assertEqual(json.loads(refused.body)["pointer"], "/output/layers")

    def test_one_layer_alone(self):
        pixels = self.expect_picture(self.server.render(small(48, 32, show="viewNormal")), 48, 32)
        self.assertIn((0, 0, 0), {pixel[:3] for pixel in pixels})
        self.assertGreater(max(pixel[2] for pixel in pixels), 240, "what is seen looks this way")

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

    def test_trace_context(self):
        trace, parent = "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"
        answer = self.server.render("{", "-H", f"TraceParent: 00-{trace}-{parent}-01")
        self.assertEqual(self.expect_problem(answer, 400)["traceId"], trace)
        span = re.fullmatch(rf"00-{trace}-([0-9a-f]{{16}})-01", answer.headers["traceresponse"])[1]
        self.assertNotEqual(span, parent)
        lines = [line for line in map(json.loads, self.server.log_text().splitlines()) if line.get("trace_id") == trace]
        self.assertEqual({line["event"] for line in lines}, {"request.failed", "request.done"})
        self.assertEqual({line["span_id"] for line in lines}, {span})
        self.assertEqual(lines[-1]["parent_span_id"], parent)
        self.assertRegex(self.server.render(small()).headers["traceresponse"], r"^00-[0-9a-f]{32}-[0-9a-f]{16}-02$")
        refused = self.server.curl("/version", "-H", f"traceparent: 00-{trace}-{parent}-01", "-H", "Expect: wonders")
        self.assertEqual(self.expect_problem(refused, 417)["traceId"], trace)

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

    def test_obj_with_materials_and_texture(self):
        files = {"quad.obj": b"mtllib quad.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                             b"vn 0 0 1\nusemtl painted\nf 1/1/1 2/2/1 3/3/1 4/4/1\n",
                 "quad.mtl": b"newmtl painted\nmap_Kd red.png\n"}
        for name, content in files.items():
            with open(os.path.join(self.folder.name, name), "wb") as file:
                file.write(content)
        request = self.request("part:model", strict=True)
        by_parts = self.post(request, "quad.mtl", "red.png", model="quad.obj")
        red, green, blue = self.expect_picture(by_parts, 32, 32)[16 * 32 + 16][:3]
        self.assertGreater(red, 2 * max(green, blue), f"the middle is {red, green, blue}, not the texture's red")
        with Server("--assets", self.folder.name) as server:
            by_file = server.render({**request, "scene": {"model": "file:quad.obj"}})
            self.assertEqual(by_file.body, by_parts.body)
        refused = self.expect_problem(self.post(request, model="quad.obj"), 422)
        self.assertIn("quad.mtl", json.dumps(refused))

    def test_what_is_no_model(self):
        for name, content in (("broken.obj", b"f 1 2 3\n"), ("broken.stl", b"solid\nfacet normal"), ("broken.ply", b"ply\n")):
            with open(os.path.join(self.folder.name, name), "wb") as file:
                file.write(content)
            problem = self.expect_problem(self.post(self.request("part:model"), model=name), 422)
            self.assertEqual(problem["pointer"], "/scene/model", problem)

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

    def test_a_normal_map_does_not_depend_on_scale(self):
        pictures = []
        for scale in (1, 1e-4, 1e4):
            def scaled(document):
                document["nodes"][0]["scale"] = [scale] * 3
                document["materials"] = [{"normalTexture": {"index": 0}, "pbrMetallicRoughness": {"roughnessFactor": 0.3}}]
            # Leans by 45 degrees towards the quad's right.
            files = support.textured_quad(scaled) | {"red.png": support.write_png(4, 4, lambda x, y: (218, 128, 218))}
            with tempfile.TemporaryDirectory() as folder:
                for name, content in files.items():
                    with open(os.path.join(folder, name), "wb") as file:
                        file.write(content)
                request = self.request("part:quad.gltf", environment={"map": "builtin:clear-sky"})
                answer = self.server.curl("/v1/renders", "-F", f"request={json.dumps(request)};type=application/json",
                                          *(flag for name in files for flag in ("-F", f"{name}=@{folder}/{name}")))
            pictures.append(self.expect_picture(answer, 32, 32)[16 * 32 + 16][:3])
        for picture in pictures[1:]:
            for ours, expected in zip(picture, pictures[0]):
                self.assertAlmostEqual(ours, expected, delta=2, msg=f"{pictures}")

    def test_a_file_that_is_no_model(self):
        self.expect_problem(self.post(self.request("part:red.png"), "red.png"), 422)


class Limits(Case):
    """Each question needs a server of its own."""

    def test_429(self):
        with Server("--seats", "1", "--queue", "0") as server:
            first = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(slow()))
            while server.metric("furnace_render_pool_active") == 0:
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
            while server.metric("furnace_render_pool_active") == 0:
                self.assertIsNone(leaving.poll())
            leaving.kill()
            leaving.communicate()
            while server.metric("furnace_render_pool_active") == 1:
                pass  # ends when it is cancelled; the test's own time limit judges
            self.assertEqual(server.metric("furnace_clients_gone_total"), 1)
            self.expect_picture(server.render(small()), 48, 32)

    def test_sigterm_lets_requests_end(self):
        request = {"output": {"width": 700, "height": 700, "samples": 16}}
        with Server() as server:
            working = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(request))
            while server.metric("furnace_render_pool_active") == 0:
                self.assertIsNone(working.poll())
            server.process.send_signal(signal.SIGTERM)
            answer = support.answer_of(working)
            self.assertEqual(answer.status, 200, answer.body[:500])
            self.assertEqual(server.process.wait(support.PATIENCE_S), 0)
            self.assertIn("server.stopped", server.log_text())

    def test_sigterm_does_not_wait_for_ever(self):
        with Server("--drain-timeout", "1ms") as server:
            working = support.curl_process(f"{server.url}/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(slow()))
            while server.metric("furnace_render_pool_active") == 0:
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
                answer = server.curl(path, base=admin)
                self.assertEqual(answer.status, 200, (path, answer.body[:500]))
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


if __name__ == "__main__":
    support.main()
