"""Image URLs, their signatures and API keys, of the real program: url_test.py FURNACE [unittest arguments]."""
import base64
import hashlib
import hmac
import json
import os
import signal
import subprocess
import tempfile
import time
import urllib.parse

import http_support as support
from http_support import FURNACE, Case, Server, small


def run(*arguments):
    return subprocess.run([FURNACE, *arguments], capture_output=True, text=True, timeout=support.PATIENCE_S)


def sign(pairs, key_id, secret, expires):
    """By the words of the README, not by the program."""
    text = urllib.parse.urlencode([*pairs, ("kid", key_id), ("exp", expires)], quote_via=urllib.parse.quote, safe="")
    digest = hmac.new(secret, f"GET\n/v1/render\n{text}".encode(), hashlib.sha256).digest()
    return f"/v1/render?{text}&sig={base64.urlsafe_b64encode(digest).decode().rstrip('=')}"


class Urls(Case):
    def test_pictures_presets_and_caches(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "ring.json"), "w", encoding="utf-8") as file:
                json.dump({"furnace:open": ["width"], "scene": {"model": "builtin:torus"}, "output": {"height": 32}}, file)
            with Server("--presets", folder, "--image-max-age", "60s", "--max-url", "300") as server:
                posted = server.render({**small(48, 32), "scene": {"model": "builtin:torus"}})
                flat = server.curl("/v1/render?model=builtin:torus&width=48&height=32&samples=1")
                self.expect_picture(flat, 48, 32)
                self.assertEqual(flat.body, posted.body)
                preset = server.curl("/v1/render?preset=ring&width=48&samples=1")
                self.assertEqual(preset.headers["etag"], posted.headers["etag"])
                self.assertEqual(preset.headers["content-disposition"], 'inline; filename="ring.png"')
                self.assertEqual(preset.headers["cache-control"], "public, max-age=60, stale-while-revalidate=60")
                self.assertEqual(preset.headers["cross-origin-resource-policy"], "cross-origin")
                head = server.curl("/v1/render?preset=ring&width=48&samples=1", "--head")
                self.assertEqual((head.status, head.body, head.headers["etag"]), (200, b"", posted.headers["etag"]))
                again = server.curl("/v1/render?preset=ring&width=48&samples=1", "-H", f"If-None-Match: {head.headers['etag']}")
                self.assertEqual(again.status, 304)
                self.assertEqual(self.expect_problem(server.curl("/v1/render?width=0"), 422)["pointer"], "?width")
                self.expect_problem(server.curl("/v1/render?model=" + "x" * 300), 414)
                self.assertEqual(json.loads(server.curl("/v1/presets").body)["presets"], [{"name": "ring", "open": ["width"]}])

    def test_a_wrong_preset_stops_the_start(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a", "b"):
                with open(os.path.join(folder, name + ".json"), "w", encoding="utf-8") as file:
                    file.write('{"output":{"width":0}}')
            told = run("serve", "--listen", "127.0.0.1:0", "--presets", folder)
            self.assertEqual(told.returncode, 1)
            for name in ("a", "b"):
                self.assertIn(f"{name}.json/output/width", told.stderr)

    def test_signatures_and_keys(self):
        with tempfile.TemporaryDirectory() as folder:
            url_keys, api_keys = os.path.join(folder, "url"), os.path.join(folder, "api")
            line = run("hash-key", "--url", "k1").stdout
            with open(os.open(url_keys, os.O_CREAT | os.O_WRONLY, 0o600), "w", encoding="utf-8") as file:
                file.write(line)
            secret = bytes.fromhex(line.strip().split(":")[1])
            key, key_line = run("hash-key", "shop", "--rate", "1000", "--renders", "2").stdout.splitlines()
            with open(api_keys, "w", encoding="utf-8") as file:
                file.write(key_line + "\n")
            size = [("width", 48), ("height", 32), ("samples", 1)]
            bearer = ("-H", f"Authorization: Bearer {key}")
            with Server("--url-keys-file", url_keys, "--api-keys-file", api_keys, "--cors-origins", "https://example.com") as server:
                mine = server.curl(sign(size, "k1", secret, int(time.time()) + 60))
                self.expect_picture(mine, 48, 32)
                theirs = run("sign-url", "--key-file", url_keys, *(f"{name}={value}" for name, value in size)).stdout.strip()
                self.assertEqual(server.curl(theirs).headers["etag"], mine.headers["etag"])
                self.expect_problem(server.curl(theirs + "&quality=high"), 403)
                self.expect_problem(server.curl(sign(size, "k1", secret, int(time.time()) - 1)), 403)
                self.expect_problem(server.curl("/v1/render?width=48"), 403)

                self.assertIn("Bearer", self.refused(server.render(small()), 401)["www-authenticate"])
                rendered = server.render(small(), *bearer, "-H", "Origin: https://example.com")
                self.assertEqual(rendered.status, 200)
                self.assertEqual(rendered.headers["access-control-allow-origin"], "https://example.com")
                self.assertIn('"renders";r=1;', rendered.headers["ratelimit"])
                self.assertEqual(server.render(small(), *bearer).status, 200)
                self.assertIn("retry-after", self.refused(server.render(small(), *bearer), 429))
                self.refused(server.curl("/metrics", *bearer), 403)
                for path in ("/livez", "/readyz", "/version", "/openapi.json"):
                    self.assertEqual(server.curl(path).status, 200, path)

                other, other_line = run("hash-key", "other", "--scopes", "admin").stdout.splitlines()
                with open(api_keys, "w", encoding="utf-8") as file:
                    file.write(other_line + "\n")
                server.process.send_signal(signal.SIGHUP)
                deadline = time.monotonic() + support.PATIENCE_S
                while server.curl("/metrics", "-H", f"X-Api-Key: {other}").status != 200:
                    self.assertLess(time.monotonic(), deadline)
                    time.sleep(0.05)
                self.refused(server.render(small(), *bearer), 401)
                text = server.log_text()
                self.assertIn('"client":"shop"', text)
                for hidden in (key, other, secret.hex()):
                    self.assertNotIn(hidden, text)

    def refused(self, answer, status):
        self.expect_problem(answer, status)
        return answer.headers

    def test_what_does_not_start(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "keys")
            with open(os.open(path, os.O_CREAT | os.O_WRONLY, 0o644), "w", encoding="utf-8") as file:
                file.write("k1:" + "7" * 64 + "\n")
            os.chmod(path, 0o644)
            told = run("serve", "--listen", "127.0.0.1:0", "--url-keys-file", path)
            self.assertEqual(told.returncode, 1)
            self.assertIn("can be read by everyone", told.stderr)
            self.assertEqual(run("sign-url", "--key-file", path, "width=1").returncode, 1)
            os.chmod(path, 0o600)
            self.assertEqual(run("sign-url", "--key-file", path, "width=1", "--expires-in", "2y").returncode, 1)
            self.assertEqual(run("sign-url", "--key-file", path, "width=1&height=1").returncode, 1)
        told = run("check-config", "--listen", "0.0.0.0:0")
        self.assertEqual(told.returncode, 1)
        self.assertIn("allow-anonymous", told.stderr)
        self.assertEqual(run("check-config", "--listen", "0.0.0.0:0", "--allow-anonymous", "on").returncode, 0)


if __name__ == "__main__":
    support.main()
