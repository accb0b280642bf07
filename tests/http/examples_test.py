"""What is documented works: the commands of the README, and all examples and defaults of the contract: examples_test.py FURNACE.

README's blocks run as they are written, in a folder of stand-in files, against servers on free ports. What is put in another's place
is told in REPLACED and in `stand_ins`; what does not run in NOT_RUN."""
import base64
import hashlib
import hmac
import http.server
import json
import os
import re
import struct
import subprocess
import tempfile
import threading
import zipfile

import http_support as support
from http_support import Case, Server
from schema_support import Schema
from tls_test import make_certificate

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NOT_RUN = {"./dev run": "builds and serves until it is stopped", "./dev test": "is what runs this"}
# README -> what stands for it. Fewer samples and frames: what is wanted here is that the command is right.
REPLACED = [
    ("build/furnace", "furnace"), ("http://127.0.0.1:8080", "$URL"), ("--listen 0.0.0.0:8443", ""), ("jobs/ID", "jobs/$ID"),
    ('"quality": "high"', '"quality": "draft"'), ("--quality high", "--quality draft"), ('"frames": 72', '"frames": 3'),
    ('"frames": 36', '"frames": 3'), ("--frames 36", "--frames 3"),
]
# The commands' `curl` fails where the server refuses, and keeps the id of a job; their `furnace serve` goes on beside what follows.
PRELUDE = r"""
set -euo pipefail
servers=()
curl() {
  command curl -sS --fail-with-body --max-time 120 "$@" >answer || { cat answer; echo "FAILED: curl $*"; return 1; }
  cat answer
  ID=$(sed -n 's/.*"id": *"\([0-9a-f]*\)".*/\1/p' answer | head -n 1 | grep . || printf %s "${ID-}")
}
furnace() {
  [[ $1 == serve ]] || { "$FURNACE" "$@"; return; }
  rm -f told && mkfifo told
  "$FURNACE" "$@" --listen 127.0.0.1:0 >told 2>server.log &
  servers+=($!)
  exec 3<told
  URL=
  while [[ ! $URL ]]; do read -r line <&3 || { cat server.log; return 1; }; URL=${line#furnace listening on }; done
  [[ $URL == http* ]] && command curl -sSk --fail "$URL/livez" >>lived
}
stop() { local status=$?; for server in "${servers[@]}"; do kill -TERM "$server"; wait "$server" || status=1; done; exit $status; }
trap stop EXIT
"""
MAGIC = {".png": b"\x89PNG", ".jpg": b"\xff\xd8\xff", ".webp": b"RIFF", ".exr": b"\x76\x2f\x31\x01", ".zip": b"PK"}


def blocks_of(text):
    return re.findall(r"^```\w*\n(.*?)^```$", text, re.M | re.S)


def glb(document, binary):
    """`document`'s first buffer is the file's own."""
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", binary + b"\0" * (-len(binary) % 4))]
    body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def walking(document, binary):
    """Its node goes up and comes down in an eighth of a second."""
    at = len(binary)
    binary += struct.pack("<3f", 0, 0.0625, 0.125) + struct.pack("<9f", 0, 0, 0, 0, 1, 0, 0, 0, 0)
    document["bufferViews"] += [{"buffer": 0, "byteOffset": at, "byteLength": 12}, {"buffer": 0, "byteOffset": at + 12, "byteLength": 36}]
    document["accessors"] += [{"bufferView": 4, "componentType": 5126, "count": 3, "type": "SCALAR", "min": [0], "max": [0.125]},
                              {"bufferView": 5, "componentType": 5126, "count": 3, "type": "VEC3"}]
    document["animations"] = [{"name": "Walk", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                               "samplers": [{"input": 4, "output": 5}]}]
    return binary


def stand_ins(folder):
    """The files that the commands name."""
    quad = support.textured_quad(lambda document: document["buffers"][0].update(uri="chair.bin") or document["images"][0].update(uri="textures/Wood.png"))
    files = {"chair.gltf": quad["quad.gltf"], "chair.bin": quad["quad.bin"], "textures/Wood.png": quad["red.png"], "grain.png": quad["red.png"]}
    document = json.loads(quad["quad.gltf"])
    del document["images"], document["textures"], document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    document["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "oak"}, {"name": "midnight"}]}}
    document["extensionsUsed"] = ["KHR_materials_variants"]
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    document["nodes"].append({"camera": 0, "translation": [0, 0, 3]})
    document["scenes"][0]["nodes"].append(1)
    model = glb(document, quad["quad.bin"])
    files |= {"model.glb": model, "models/one.glb": model, "models/two.glb": model, "assets/chairs/chair.glb": model, "assets/shoe.glb": model,
              "site/chair.gltf": model}
    files["fox.glb"] = glb(document, walking(document, quad["quad.bin"]))
    document.pop("animations")
    files["assets/chairs/chair.gltf"] = json.dumps({**document, "buffers": [{"uri": "chair.bin", "byteLength": len(quad["quad.bin"])}],
                                                    "accessors": document["accessors"][:4], "bufferViews": document["bufferViews"][:4]}).encode()
    files["assets/chairs/chair.bin"] = quad["quad.bin"]
    files["part.stl"] = b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"
    files["sky.hdr"] = support.write_hdr(16, 8, lambda x, y: (128, 128, 128 + 8 * x, 128))
    files["request.json"] = json.dumps(support.small()).encode()
    files["presets/product.json"] = b'{"furnace:open": ["model"], "output": {"width": 64, "height": 64}}'
    for name, content in files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content)
    with zipfile.ZipFile(os.path.join(folder, "chair.zip"), "w") as archive:
        for name in ("chair.gltf", "chair.bin", "textures/Wood.png"):
            archive.write(os.path.join(folder, name), name)
    make_certificate(folder, "tls")
    os.rename(f"{folder}/tls.pem", f"{folder}/fullchain.pem")
    os.rename(f"{folder}/tls.key", f"{folder}/privkey.pem")


class Receiver(http.server.SimpleHTTPRequestHandler):
    """Another server: gives files, and takes webhooks."""
    hooks = []

    def do_POST(self):
        Receiver.hooks.append((dict(self.headers), self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_):
        pass


class Readme(Case):
    @classmethod
    def setUpClass(cls):
        with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
            cls.text = file.read()
        cls.blocks = blocks_of(cls.text)
        cls.made = tempfile.TemporaryDirectory()
        cls.folder = cls.made.name
        stand_ins(cls.folder)
        site = os.path.join(cls.folder, "site")
        cls.other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), lambda *arguments: Receiver(*arguments, directory=site))
        threading.Thread(target=cls.other.serve_forever, daemon=True).start()
        cls.origin = f"http://127.0.0.1:{cls.other.server_port}"
        cls.key, line = cls.furnace("hash-key", "shop").splitlines()
        with open(f"{cls.folder}/keys", "w", encoding="utf-8") as file:
            file.write(line + "\n")
        cls.furnace("render", "request.json", "--width", "32", "--height", "16", "-o", "sky.exr")
        cls.server = Server("--data", f"{cls.folder}/data", "--assets", f"{cls.folder}/assets", "--presets", f"{cls.folder}/presets")

    @classmethod
    def tearDownClass(cls):
        cls.other.shutdown()
        cls.other.server_close()
        assert cls.server.stop() == 0, cls.server.log_text()
        cls.server.process.stdout.close()
        cls.made.cleanup()

    @classmethod
    def furnace(cls, *arguments):
        return subprocess.run([os.path.abspath(support.FURNACE), *arguments], cwd=cls.folder, capture_output=True, text=True, check=True).stdout

    def hash_of(self, name):
        with open(os.path.join(self.folder, name), "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()

    def prepared(self, block):
        for documented, here in REPLACED:
            block = block.replace(documented, here)
        assets = {"9f2c...": "chair.zip", "4b1d...": "chair.gltf", "77aa...": "chair.bin", "c0de...": "textures/Wood.png"}
        for shown, name in assets.items():
            block = block.replace("asset:sha256-" + shown, "asset:sha256-" + self.hash_of(name))
        block = block.replace("cdn.example.com", self.origin, 1).replace("https://cdn.example.com", self.origin)
        return block.replace("webhook-allow example.com", f"webhook-allow {self.origin}").replace("https://example.com/hook", f"{self.origin}/hook")

    def run_block(self, block, before=""):
        done = subprocess.run(["bash", "-c", PRELUDE + before + self.prepared(block)], cwd=self.folder, capture_output=True, timeout=600, check=False,
                              env={**os.environ, "URL": self.server.url, "FURNACE": os.path.abspath(support.FURNACE), "LC_ALL": "C.UTF-8"})
        self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout[-3000:].decode('utf-8', 'replace')}\n{done.stderr[-3000:].decode('utf-8', 'replace')}")
        self.check_files(block)
        return done.stdout

    def check_files(self, block):
        """What the commands write is there, and is what its name says."""
        for name in set(re.findall(r" -o ([\w.%]+)", block)):
            path = os.path.join(self.folder, name.replace("%04d", "0001"))
            self.assertTrue(os.path.isfile(path) or os.path.isdir(path), f"{block}\ndoes not write {name}")
            if os.path.isfile(path):
                with open(path, "rb") as file:
                    start = file.read(16)
                self.assertTrue(start.startswith(MAGIC[os.path.splitext(name)[1]]), (block, start))
                os.remove(path)

    def test_every_block(self):
        special = {"$KEY": self.with_a_key, "--webhook-allow": self.with_a_webhook, "<img ": self.in_a_page, "sign-url": self.signed,
                   "model=file%3Aa%20b.glb": self.to_be_signed}
        self.assertGreater(len(self.blocks), 20)
        for block in self.blocks:
            with self.subTest(block[:70]):
                if block.strip() in NOT_RUN:
                    continue
                ways = [way for mark, way in special.items() if mark in block]
                (ways[0] if ways else self.run_block)(block)

    def with_a_key(self, block):
        self.run_block(block, f"KEY={self.key}; furnace serve --api-keys-file keys\n"
                              '[[ $(command curl -s -o /dev/null -w "%{http_code}" -X POST "$URL/v1/renders") == 401 ]]\n')

    def with_a_webhook(self, block):
        self.run_block(block + '\nuntil command curl -sS "$URL/v1/jobs/$ID" | grep -q delivered; do sleep 0.1; done\n')
        (headers, body), = Receiver.hooks
        with open(os.path.join(self.folder, "webhook-secrets"), encoding="utf-8") as file:
            secret = base64.b64decode(file.read().strip().split("whsec_")[1])
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        self.assertEqual(headers["webhook-signature"], "v1," + base64.b64encode(hmac.new(secret, signed, "sha256").digest()).decode())
        self.assertEqual(json.loads(body)["type"], "job.succeeded")
        openapi = json.loads(self.server.curl("/openapi.json").body)
        event = openapi["webhooks"]["jobEnded"]["post"]
        self.assertEqual(list(Schema(openapi, event["requestBody"]["content"]["application/json"]["schema"]).problems(json.loads(body))), [])
        sent = {name.lower() for name in headers}
        self.assertEqual([entry["name"] for entry in event["parameters"] if entry["name"] not in sent], [])

    def in_a_page(self, block):
        pages = re.findall(r'<img src="http://127\.0\.0\.1:8080([^"]*)">', block)
        self.assertEqual(len(pages), block.count("<img"))
        for page in pages:
            self.assertEqual(self.server.curl(page).status, 200, page)
        self.run_block(re.sub(r"<img .*\n", "", block))

    def signed(self, block):
        told = self.run_block(block + "\nfurnace serve --url-keys-file url-keys --presets presets --assets assets\n"
                                      'command curl -sS --fail "$URL$(furnace sign-url --key-file url-keys --expires-in 30d preset=product model=file:chairs/chair.glb)" --output signed.png\n')
        self.assertIn(b"/v1/render?preset=product&model=file", told)
        with open(os.path.join(self.folder, "signed.png"), "rb") as file:
            self.assertEqual(support.read_png(file.read())[:2], (64, 64))

    def to_be_signed(self, block):
        expected = re.search(r"sig=([\w-]{43})", self.text)[1]
        digest = hmac.new(b"0123456789abcdef0123456789abcdef", block.rstrip("\n").encode(), "sha256").digest()
        self.assertEqual(base64.urlsafe_b64encode(digest).decode().rstrip("="), expected)


class Contract(Case):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory()
        stand_ins(cls.made.name)
        cls.server = Server("--assets", f"{cls.made.name}/assets")
        cls.openapi = json.loads(cls.server.curl("/openapi.json").body)
        cls.schema = json.loads(cls.server.curl("/v1/schema.json").body)

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.log_text()
        cls.server.process.stdout.close()
        cls.made.cleanup()

    def schemas_of(self, document, node, place=""):
        """Whatever has examples or a default, and its place."""
        if isinstance(node, dict):
            if {"examples", "default"} & set(node) and {"type", "$ref", "anyOf", "enum"} & set(node):
                yield Schema(document, node), place
            for key, member in node.items():
                if key not in ("examples", "default", "example", "enum"):
                    yield from self.schemas_of(document, member, f"{place}/{key}")
        elif isinstance(node, list):
            for i, member in enumerate(node):
                yield from self.schemas_of(document, member, f"{place}/{i}")

    def test_examples_and_defaults_fit_their_schemas(self):
        count = 0
        for document in (self.schema, self.openapi):
            for schema, place in self.schemas_of(document, document):
                for value in [*schema.node.get("examples", ()), *([schema.node["default"]] if "default" in schema.node else ())]:
                    self.assertEqual(list(schema.problems(value)), [], (place, value))
                    count += 1
        self.assertGreater(count, 300)

    def test_examples_of_parameters_and_headers_fit(self):
        count = 0
        for kind in ("parameters", "headers"):
            for name, entry in self.openapi["components"][kind].items():
                if "example" in entry:
                    self.assertEqual(list(Schema(self.openapi, entry["schema"]).problems(entry["example"])), [], name)
                    count += 1
        self.assertGreater(count, 5)

    def smaller(self, value):
        """The same with fewer samples and pixels."""
        output = value.get("output", {})
        if "quality" in output:
            output["quality"] = "draft"
        output.update({name: min(output[name], most) for name, most in (("width", 256), ("height", 256), ("samples", 2)) if name in output})
        return value

    def post(self, path, kind, value):
        if kind != "multipart/form-data":
            return self.server.curl(path, "-H", f"Content-Type: {kind}", "--data-binary", json.dumps(self.smaller(value)))
        folder = self.made.name
        return self.server.curl(path, "-F", f"request={json.dumps(value['request'])};type=application/json", "-F", f"helmet.glb=@{folder}/model.glb",
                                "-F", f"sky.hdr=@{folder}/sky.hdr")

    def test_every_example_of_a_body_is_answered_200(self):
        count = 0
        for path, item in self.openapi["paths"].items():
            for kind, media in item.get("post", {}).get("requestBody", {}).get("content", {}).items():
                for name, example in media.get("examples", {}).items():
                    with self.subTest(path=path, example=name):
                        answer = self.post(path, kind, example["value"])
                        self.assertEqual(answer.status, 200, answer.body[:1000])
                        count += 1
        self.assertGreater(count, 12)


if __name__ == "__main__":
    support.main()
