"""A furnace process, curl, and files made on the spot. Standard library only; the tests import it."""
import collections
import contextlib
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

# The program under test: the first argument of the script that runs.
FURNACE = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.isfile(sys.argv[1]) else "build/furnace"
PATIENCE_S = 120  # a limit for hangs, not a measure of speed

Answer = collections.namedtuple("Answer", "status headers body")


class Server:
    """`furnace serve` on a free port; `with Server("--queue", "0") as server:`."""

    def __init__(self, *flags, environment=None):
        self.log = tempfile.NamedTemporaryFile(prefix="furnace-", suffix=".log")
        command = [FURNACE, "serve", "--listen", "127.0.0.1:0", *flags]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log, text=True,
                                        env={**os.environ, **(environment or {})})
        self.lines = [self.process.stdout.readline().rstrip("\n")]
        match = re.fullmatch(r"furnace listening on (https?://127\.0\.0\.1:(\d+))", self.lines[0])
        if not match:
            self.process.wait(PATIENCE_S)
            raise AssertionError(f"{command} said {self.lines}; its log:\n{self.log_text()}")
        self.url, self.port = match[1], int(match[2])
        self.lines.append(self.process.stdout.readline().rstrip("\n"))

    def admin_port(self):
        return int(re.fullmatch(r"furnace admin on port (\d+)\n", self.process.stdout.readline())[1])

    def log_text(self):
        with open(self.log.name, encoding="utf-8") as log:
            return log.read()

    def alive(self):
        return self.process.poll() is None

    def stop(self):
        if self.alive():
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE_S)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.stop()
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise
        finally:
            self.process.stdout.close()

    def curl(self, path, *flags, base=None):
        return curl((base or self.url) + path, *flags)

    def render(self, document, *flags):
        text = document if isinstance(document, str) else json.dumps(document)
        return self.curl("/v1/renders", "-H", "Content-Type: application/json", "--data-binary", text, *flags)

    def metric(self, name):
        text = self.curl("/metrics").body.decode()
        return sum(float(line.split()[-1]) for line in text.splitlines() if re.match(rf"{name}[ {{]", line))


def curl_process(url, *flags):
    return subprocess.Popen(["curl", "-sS", "-i", "--max-time", str(PATIENCE_S), url, *flags],
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def answer_of(process):
    out, complaint = process.communicate(timeout=2 * PATIENCE_S)
    if not out:
        raise AssertionError(f"no answer: {complaint.decode()}")
    while True:
        head, _, body = out.partition(b"\r\n\r\n")
        lines = head.decode("latin-1").split("\r\n")
        status = int(lines[0].split()[1])
        if status != 100:
            break
        out = body
    headers = {name.strip().lower(): value.strip() for name, _, value in (line.partition(":") for line in lines[1:])}
    return Answer(status, headers, body)


def curl(url, *flags):
    return answer_of(curl_process(url, *flags))


def thread_names(server):
    """Without the threads that Mesa writes its cache of shaders with, as many as are wanted at the moment, four at most."""
    names = []
    for task in os.listdir(f"/proc/{server.process.pid}/task"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # it has just ended
            with open(f"/proc/{server.process.pid}/task/{task}/comm", encoding="utf-8") as comm:
                names.append(comm.read().strip())
    return sorted(name for name in names if ":disk$" not in name)


def handles(server):
    """Open descriptors and threads of the process."""
    return len(os.listdir(f"/proc/{server.process.pid}/fd")), len(thread_names(server))


def small(width=48, height=32, **output):
    return {"output": {"width": width, "height": height, "samples": 1, **output}}


def slow():
    """A request that any machine works on for a while."""
    return {"output": {"width": 3000, "height": 3000, "samples": 64}}


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
        got_width, got_height, _, pixels = read_png(answer.body)
        self.assertEqual((got_width, got_height), (width, height))
        return pixels


def main():
    unittest.main(module="__main__", verbosity=2)  # names what is skipped


# --- PNG --------------------------------------------------------------------------------------------------------------


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_png(width, height, pixel):
    """RGB; pixel(x, y) -> (r, g, b)."""
    rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(width)) for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + png_chunk(b"IDAT", zlib.compress(rows)) + png_chunk(b"IEND", b"")


def paeth(left, up, corner):
    estimate = left + up - corner
    distances = [abs(estimate - value) for value in (left, up, corner)]
    return (left, up, corner)[distances.index(min(distances))]


def read_png(data):
    """Width, height, channels and the list of pixels of an 8-bit, not interlaced RGB or RGBA file."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", data[:16]
    position, pixels, header = 8, b"", None
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position:position + 8])
        body = data[position + 8:position + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            pixels += body
        position += 12 + length
    width, height, depth, color_type, _, _, interlaced = header
    assert depth == 8 and color_type in (2, 6) and not interlaced, header
    channels = 3 if color_type == 2 else 4
    stride = width * channels
    raw = zlib.decompress(pixels)
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left = row[i - channels] if i >= channels else 0
            corner = above[i - channels] if i >= channels else 0
            row[i] = (row[i] + (0, left, above[i], (left + above[i]) // 2, paeth(left, above[i], corner))[kind]) & 255
        rows.append(row)
        above = row
    return width, height, channels, [tuple(row[i:i + channels]) for row in rows for i in range(0, stride, channels)]


# --- glTF -------------------------------------------------------------------------------------------------------------


def write_hdr(width, height, pixel):
    """RGBE without run lengths; pixel(x, y) -> (r, g, b, e) bytes."""
    rows = b"".join(bytes(pixel(x, y)) for y in range(height) for x in range(width))
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + rows


def write_large_hdr(width, height, pixel):
    """RGBE with run lengths, each row of one colour: pixel(y) -> (r, g, b, e) bytes."""
    def run(value):
        whole, rest = divmod(width, 127)
        return bytes((255, value)) * whole + (bytes((128 + rest, value)) if rest else b"")
    rows = b"".join(bytes((2, 2, width >> 8, width & 255)) + b"".join(run(value) for value in pixel(y)) for y in range(height))
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + rows


def textured_quad(change=lambda document: None):
    """A quad that faces +Z with a texture, as {file name: bytes}: quad.gltf, quad.bin and red.png."""
    positions = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    normals = [(0, 0, 1)] * 4
    uvs = [(0, 1), (1, 1), (1, 0), (0, 0)]
    indices = [0, 1, 2, 0, 2, 3]
    buffer = b"".join(struct.pack("<3f", *vector) for vector in positions + normals)
    buffer += b"".join(struct.pack("<2f", *uv) for uv in uvs) + struct.pack("<6H", *indices)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3,
                                    "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "red.png"}],
        "buffers": [{"uri": "quad.bin", "byteLength": len(buffer)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
            {"buffer": 0, "byteOffset": 96, "byteLength": 32},
            {"buffer": 0, "byteOffset": 128, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
    }
    change(document)
    return {
        "quad.gltf": json.dumps(document).encode(),
        "quad.bin": buffer,
        "red.png": write_png(4, 4, lambda x, y: (200, 10, 10)),
    }


def data_folder(*names):
    """Development data by others, beside the source tree; None when it is not there."""
    source = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    folder = os.path.join(os.path.dirname(source), "shared", "data", *names)
    return folder if os.path.isdir(folder) else None


def files_below(folder):
    return sorted(os.path.join(path, name) for path, _, names in os.walk(folder) for name in names)
