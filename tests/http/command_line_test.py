"""The command line of the real program: command_line_test.py FURNACE [unittest arguments]."""
import io
import json
import os
import subprocess
import tempfile
import zipfile

import http_support as support
from http_support import Case, Server, small


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

    def test_render_one_of_several_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)
            with open(os.path.join(folder, "quad.gltf"), "r+", encoding="utf-8") as file:
                document = json.load(file)
                document["scenes"].append({})
                file.seek(0)
                json.dump(document, file)
                file.truncate()
            seen = []
            for scene in ("0", "1"):
                self.run_furnace("render", "quad.gltf", "--scene", scene, "-o", "out.png", "--width", "40", "--height", "30",
                                 "--samples", "1", "--azimuth", "0", "--elevation", "0", "--background", "transparent", folder=folder)
                with open(os.path.join(folder, "out.png"), "rb") as file:
                    seen.append(support.read_png(file.read())[3][15 * 40 + 20][3])
            self.assertEqual(seen, [255, 0])
            done = self.run_furnace("render", "quad.gltf", "--scene", "2", "-o", "out.png", status=1, folder=folder)
            self.assertIn(b"scene 2 does not exist", done.stderr)

    def test_an_archive_is_a_model(self):
        with tempfile.TemporaryDirectory() as folder:
            with zipfile.ZipFile(os.path.join(folder, "quad.zip"), "w") as archive:
                for name, content in support.textured_quad().items():
                    archive.writestr(f"quad/{name}", content)
                    with open(os.path.join(folder, name), "wb") as file:
                        file.write(content)
            pictures = []
            for model in ("quad.zip", "quad.gltf"):
                self.run_furnace("render", model, "-o", "out.png", "--width", "40", "--height", "30", "--samples", "1", folder=folder)
                with open(os.path.join(folder, "out.png"), "rb") as file:
                    pictures.append(support.read_png(file.read())[3])
            self.assertEqual(*pictures)

    def test_a_turntable_in_every_container(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)

            def turn(out, *more):
                self.run_furnace("render", "quad.gltf", "-o", out, "--width", "48", "--height", "32", "--azimuth", "0", "--turntable", "100",
                                 "--frames", "4", "--fps", "10", *more, folder=folder)
                with open(os.path.join(folder, out.replace("%02d", "01")), "rb") as file:
                    return file.read()

            webp, apng = turn("out.webp"), turn("out.png")
            self.assertEqual(webp.count(b"ANMF"), 4)
            self.assertEqual(apng.count(b"fcTL"), 4)
            with zipfile.ZipFile(io.BytesIO(turn("out.zip"))) as archive:
                self.assertIsNone(archive.testzip())
                names = archive.namelist()
                frames = [archive.read(name) for name in names]
            self.assertEqual(names, [f"frame_{i:04}.png" for i in range(1, 5)])
            self.assertEqual(len(set(frames)), 4)
            turn("out_%02d.png")
            for i, frame in enumerate(frames):
                with open(os.path.join(folder, f"out_{i + 1:02}.png"), "rb") as file:
                    self.assertEqual(file.read(), frame)
            # While the shutter is open the camera goes on.
            sharp, blurred, again = (turn("out.png", "--samples", "4", *more) for more in ((), ("--motion-blur", "0.05"), ("--motion-blur", "0.05")))
            self.assertNotEqual(sharp, blurred)
            self.assertEqual(blurred, again)
            # Nothing moves, and no animation has a length.
            self.run_furnace("render", "quad.gltf", "-o", "out.webp", "--frames", "4", status=1, folder=folder)
            self.run_furnace("render", "quad.gltf", "-o", "out.webp", "--turntable", "90", status=1, folder=folder)

    def test_a_sheet_of_a_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)
            with open(os.path.join(folder, "broken.glb"), "wb") as file:
                file.write(b"glTF")
            done = self.run_furnace("sheet", ".", "-o", "sheet.png", "--cell", "32", "--columns", "2", status=1, folder=folder)
            cells = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual([os.path.basename(cell["model"]) for cell in cells], ["broken.glb", "quad.gltf"])
            self.assertIn("error", cells[0])
            self.assertEqual((cells[1]["row"], cells[1]["column"]), (0, 1))
            with open(os.path.join(folder, "sheet.png"), "rb") as file:
                width, height, channels, pixels = support.read_png(file.read())
            self.assertEqual((width, height, channels), (64, 32, 4))
            self.assertEqual(pixels[0], (0, 0, 0, 0), "the cell of a model that failed")
            self.assertEqual(pixels[16 * 64 + 48][3], 255)
            self.assertGreater(max(pixels[16 * 64 + 48][:3]), 0)
            self.run_furnace("sheet", "absent", "-o", "sheet.png", status=1, folder=folder)

    def test_inspect_a_model(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in support.textured_quad().items():
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)
            report = json.loads(self.run_furnace("inspect", "quad.gltf", folder=folder).stdout)
            self.assertEqual(report["drawn"]["triangles"], 2)
            self.assertEqual(report["drawn"]["bounds"], {"min": [-1, -1, 0], "max": [1, 1, 0]})
            self.assertEqual([(image["format"], image["width"]) for image in report["images"]], [("PNG", 4)])
            self.assertIn(b"draws 2 triangles", self.run_furnace("inspect", "--text", "quad.gltf", folder=folder).stdout)
            os.remove(os.path.join(folder, "red.png"))
            report = json.loads(self.run_furnace("inspect", "quad.gltf", folder=folder).stdout)
            self.assertEqual(report["missingFiles"], ["red.png"])
            os.remove(os.path.join(folder, "quad.bin"))
            done = self.run_furnace("inspect", "quad.gltf", status=1, folder=folder)
            self.assertIn(b"/buffers/0/uri", done.stderr)
        done = self.run_furnace("inspect", "-", data=b'{"asset":{"version":"2.0"}}')
        self.assertEqual(json.loads(done.stdout)["nodes"], 0)
        self.run_furnace("inspect", "-", data=b"no model", status=1)
        self.run_furnace("inspect", "absent.glb", status=1)

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
    support.main()
