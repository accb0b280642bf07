"""Requests for every operation of an OpenAPI document: those it describes, and those that are nearly so. Small and quick to draw."""
import base64
import collections
import hashlib
import json
import math
import urllib.parse

import http_support as support
from schema_support import NAMES, STRANGE, TYPES, Maker, Schema, broken_text, find, spoil, text_of

# `text`: the document in it, if any; `fits`: whether that is one the schema takes, None: nobody knows.
Request = collections.namedtuple("Request", "method target headers body path operation text fits")

WEIGHTS = {"render": 40, "renderUrl": 16, "renderBatch": 8, "postBundle": 4, "inspect": 8, "putAsset": 6, "postAsset": 5, "getJob": 4, "getJobResult": 4,
           "deleteJob": 3, "putEnvironment": 3, "getAsset": 3}
MAX_DEPTH, MAX_KEY_BYTES = 64, 1024  # of api/document.hpp and api/render_request.hpp
SKY = support.write_hdr(16, 8, lambda x, y: (128, 128, 128 + 8 * x, 128))

HEADERS = {
    "Accept": ["*/*", "image/png", "image/webp, image/*;q=0.5", "image/x-exr", "image/*;q=0", "text/html", "application/json", "", ";q=1", "image/png;q=abc",
               "image/jpeg;q=1.0000001", ",".join(["a/b"] * 300), "image/apng", "application/zip", "\xff/\xfe"],
    "Prefer": ["respond-async", "respond-async, wait=5", "wait=10", "wait=99999999999", "wait=-1", 'respond-async;a="b,c", wait="1"', "respond-asyncs", ";;;", "RESPOND-ASYNC", "x" * 1000],
    "Idempotency-Key": ['"one"', "one", '"two"', '""', "x" * 300, "\xfc", '"a\\"b"', '"'],
    "If-None-Match": ["*", '"0"', 'W/"' + "0" * 64 + '"', ",,,", '"', '"a", "b", *'],
    "Range": ["bytes=0-0", "bytes=-1", "bytes=5-1", "lines=1", "bytes=99999999-", "bytes=0-99999999999999999999", "bytes=-0", "bytes=1-", "bytes=" + "0-," * 50],
    "If-Range": ['"0"', 'W/"a"', "Mon, 23 Nov 2026 03:30:43 GMT", "x"],
    "Content-Range": ["bytes 0-4/10", "bytes */10", "bytes 5-1/10", "bytes 0-0/*", "bytes 0-99999999999999999999/1", "bytes 0-9223372036854775807/9223372036854775807",
                      "", "0-4/10", "bytes 1-1/2", "bytes -1-4/10", "bytes */0", "bytes 0-4/5"],
    "Furnace-Priority": ["0", "9", "10", "-1", "a", "1.5", "9" * 30, " 3", "+1"],
    "Furnace-Webhook": ["http://127.0.0.1:1/hook", "https://example.com/hook", "x", "http://127.0.0.1:1/" + "a" * 3000, "http://[::1]:1/", "file:///etc/passwd",
                        "http://a@127.0.0.1:1/"],
    "traceparent": ["00-" + "1" * 32 + "-" + "2" * 16 + "-01", "00-" + "0" * 32 + "-" + "2" * 16 + "-01", "ff-1", "x" * 500, "00-" + "A" * 32 + "-" + "2" * 16 + "-01"],
    "X-Request-Id": ["mine-1", "a b", "x" * 65, "\xe9", "", "<script>"],
    "Origin": ["https://example.com", "null"],
    "Authorization": ["Bearer x", "Basic eDp5", "Bearer"],
    "Content-Encoding": ["gzip", "identity"],
    "Content-Disposition": ['attachment; filename="a b.glb"', "inline; filename=\"\xfc\"", "attachment; filename=../x", "x" * 2000, 'form-data; filename="'],
    "Content-Type": ["text/plain", "application/json; charset=utf-16", "APPLICATION/JSON", "application/x-www-form-urlencoded", "multipart/form-data",
                     "multipart/form-data; boundary=" + "b" * 80, "multipart/form-data; boundary=\"a b\"", "", "/", "image/png", "\xff"],
    "Expect": ["100-continue", "x"],
}
FOR_JOBS = ["Prefer", "Idempotency-Key", "Furnace-Priority", "Furnace-Webhook"]
STRANGE_PATHS = ["-1", "0", "x", "%00", "%2e%2e%2f%2e%2e", "..", "a" * 300, "%F0%9F%99%82", "%", "%zz", "9" * 40, "A" * 64, "0" * 64, "0" * 32, "*", "a;b", "sky%20"]


class Unreadable(Exception):
    pass


def strictly(text):
    """The document of a JSON text as the server reads it: each key once, no U+0000, no deeper than it allows."""
    def members(pairs):
        out = {}
        for key, value in pairs:
            if key in out or len(key.encode()) > MAX_KEY_BYTES or "\0" in key:
                raise Unreadable(key)
            out[key] = value
        return out

    def refuse(word):
        raise Unreadable(word)

    def number(word):
        value = float(word)
        return value if math.isfinite(value) else refuse(word)

    def check(value, depth):
        if isinstance(value, (dict, list)):
            if depth == MAX_DEPTH:
                raise Unreadable("depth")
            for member in value.values() if isinstance(value, dict) else value:
                check(member, depth + 1)
        elif isinstance(value, str) and "\0" in value:
            raise Unreadable("U+0000")

    try:
        text.encode()
        value = json.loads(text, object_pairs_hook=members, parse_constant=refuse, parse_float=number)
        json.dumps(value, ensure_ascii=False).encode()  # no lone surrogates
        check(value, 0)
    except (ValueError, RecursionError) as why:
        raise Unreadable(str(why)) from why
    return value


def fits(schema, text):
    try:
        return schema.accepts(strictly(text))
    except Unreadable:
        return False


def data_uri(media_type, data):
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


class Files:
    """What requests may name, and what the server has told of so far."""

    def __init__(self):
        quad = support.textured_quad()
        self.whole = json.dumps({**json.loads(quad["quad.gltf"]), "images": [{"uri": data_uri("image/png", quad["red.png"])}],
                                 "buffers": [{"uri": data_uri("application/octet-stream", quad["quad.bin"]), "byteLength": len(quad["quad.bin"])}]}).encode()
        self.parts = {"model": self.whole, "quad.gltf": quad["quad.gltf"], "quad.bin": quad["quad.bin"], "red.png": quad["red.png"], "sky": SKY, "red": quad["red.png"]}
        self.quad = quad
        self.assets, self.jobs, self.tags = ["0" * 64], ["0" * 32], ["0" * 64]
        self.received = {}  # address of an upload in pieces -> bytes that have come

    def learn(self, request, answer):
        if "upload-offset" in answer.headers:
            self.received[request.target] = int(answer.headers["upload-offset"])
        elif request.method == "PUT":
            self.received.pop(request.target, None)
        place = answer.headers.get("location", "")
        for kept, prefix in ((self.assets, "/v1/assets/"), (self.jobs, "/v1/jobs/")):
            if place.startswith(prefix):
                kept.append(place[len(prefix):])
        if answer.headers.get("content-location", "").startswith("/v1/renders/"):
            self.tags.append(answer.headers["content-location"][len("/v1/renders/"):])
        for kept in (self.assets, self.jobs, self.tags):
            del kept[:-50]

    def texts(self, chance):
        """Strings by the title of their schema."""
        asset = "asset:sha256-" + chance.choice(self.assets)
        files = ["part:model", "file:quad.gltf", "part:red", "part:sky", "file:sky.hdr", "part:missing", "file:missing.glb", "file:../x", asset, asset + "/a", "data:,x",
                 "data:model/gltf+json;base64,e30=", "https://example.com/a.glb", "builtin:sphere", "builtin:studio", "environment:sky", "environment:x", "builtin:"]
        by_title = {
            "Model": ["builtin:sphere", "builtin:torus", "part:model", "file:quad.gltf", *files],
            "Reference to a file": ["builtin:overcast", "builtin:studio", "environment:sky", "part:sky", "file:sky.hdr", *files],
            "Image file": ["part:red", "file:red.png", *files],
            "Photometric file": files,
            "Material": ["gold", "glass", "plastic-red", *NAMES],
            "Date and time": ["2026-06-21T16:30:00Z", "2026-06-21T12:00Z", "2026-13-01T00:00:00Z", "1949-01-01T00:00:00Z", *NAMES],
            "key": ["gold", "quad.bin", "red.png", *NAMES],
            "JSON pointer into the request": ["/output/width", "/strict", "/scene/nodes/0/mesh", "/camera/orbit/azimuthDegrees", "/scene/nodes/9999999999", "/a/b", "output",
                                              "/scene/nodes/-", "", "/", "/~", "/a" * 1000, "/output/width/x"],
            "Name of the file without ending": ["front", "a.b", "_", "-"],
        }
        return lambda title: chance.choice(by_title[title]) if title in by_title else None


def tame(document, chance):
    """Small, seldom with an environment that must be baked first, and mostly without what only other documents may have."""
    if not isinstance(document, dict) or chance.random() < 0.03:
        return document
    output = document.setdefault("output", {})
    if isinstance(output, dict):
        output.update(width=chance.randint(1, 32), height=chance.randint(1, 32), samples=1)
        output.pop("quality", None)
        if isinstance(output.get("sequence"), dict):
            output["sequence"].update(frames=chance.randint(2, 3), turntableDegrees=90)
        if "layers" in output and chance.random() < 0.8:
            output["format"] = "exr"
            for name in ("bitDepth", "compressionQuality", "lossless"):
                output.pop(name, None)
    if isinstance(document.get("scene"), dict) and chance.random() < 0.8:
        for name in ("variant", "animation", "animations", "gltfScene", "upAxis", "files"):
            document["scene"].pop(name, None)
    environment = document.get("environment")
    for holder in (environment, environment.get("background") if isinstance(environment, dict) else None):
        if isinstance(holder, dict) and isinstance(holder.get("map"), dict) and chance.random() < 0.9:
            holder["map"] = chance.choice(["builtin:studio", "builtin:overcast", "builtin:furnace", {"color": [1, 1, 1]}])
    return document


class Requests:
    """Of a server with this contract. Each depends on `chance` and what `files` has learned alone."""

    def __init__(self, openapi, request_schema, files):
        self.openapi, self.files = openapi, files
        self.operations = [(path, method.upper(), operation, item.get("parameters", []))
                           for path, item in openapi["paths"].items() for method, operation in item.items() if method != "parameters"]
        self.weights = [WEIGHTS.get(operation["operationId"], 2) for _, _, operation, _ in self.operations]
        schemas = openapi["components"]["schemas"]
        self.request_schema = Schema(request_schema, request_schema)
        self.documents = {"render": self.request_schema, "postBundle": self.request_schema,
                          "renderBatch": Schema(openapi, schemas["BatchRequest"]), "inspect": Schema(openapi, schemas["InspectRequest"])}

    def make(self, chance, operation_id=None):
        known = [entry for entry in self.operations if entry[2]["operationId"] == operation_id]
        path, method, operation, shared = known[0] if known else chance.choices(self.operations, self.weights)[0]
        parameters = [find(self.openapi, entry["$ref"][1:]) if "$ref" in entry else entry for entry in [*operation.get("parameters", []), *shared]]
        headers, body, text, is_fit = {}, None, None, None
        if "requestBody" in operation:
            headers["Content-Type"], body, text, is_fit = self.body(operation, chance)
        target = path
        for parameter in (entry for entry in parameters if entry["in"] == "path"):
            target = target.replace("{" + parameter["name"] + "}", self.path_text(parameter["name"], chance))
        if operation["operationId"] == "putAsset" and chance.random() < 0.5:
            headers["Content-Range"], body = self.piece(target, body, chance)
        if operation["operationId"] == "renderUrl":
            query, is_fit = self.query([entry for entry in parameters if entry["in"] == "query"], chance)
            target += "?" + query
        elif chance.random() < 0.1:
            target += chance.choice(["?", "?a=b", "?width=1&width=2", "?%zz", "?" + "x" * 9000])
        is_disturbed = self.disturb(headers, operation["operationId"], chance)
        if chance.random() < 0.03:
            method = chance.choice(["PATCH", "TRACE", "DELETE", "PUT", "POST", "GET", "OPTIONS", "HEAD", "FOO", "get", "CONNECT"])
            is_fit, operation = None, self.openapi["paths"][path].get(method.lower(), operation)
        return Request(method, target, headers, body, path, operation, text, None if is_disturbed else is_fit)

    def path_text(self, name, chance):
        known = {"id": self.files.jobs, "tag": self.files.tags, "sha256": [self.files.assets[-1], chance.choice(self.files.assets)], "name": ["sky", "sky", "other"], "index": list("0123")}
        return chance.choice(STRANGE_PATHS) if chance.random() < 0.15 else chance.choice(known[name])

    def disturb(self, headers, operation_id, chance):
        """Adds headers; whether the body is then taken for something else."""
        names = [name for name in FOR_JOBS if chance.random() < 0.4] if operation_id in ("render", "renderBatch") and chance.random() < 0.15 else []
        names += chance.sample([name for name in HEADERS if name not in FOR_JOBS], chance.choice([0, 0, 0, 0, 1, 1, 3]))
        for name in names:
            headers[name] = HEADERS[name][0] if chance.random() < 0.4 else chance.choice(HEADERS[name])
        if "If-None-Match" in headers and chance.random() < 0.5:
            headers["If-None-Match"] = f'"{chance.choice(self.files.tags)}"'
        return "Content-Type" in names or "Content-Encoding" in names or "Expect" in names

    # --- GET /v1/render

    def query(self, parameters, chance):
        """A query, and False where one of its values is outside of its schema."""
        if chance.random() < 0.15:
            text, is_fit = self.document(self.request_schema, chance)
            pairs = [("r", base64.urlsafe_b64encode(text.encode("utf-8", "replace")).decode().rstrip(chance.choice(["", "="])))]
            return urllib.parse.urlencode(pairs), is_fit
        maker, pairs, misfits = Maker(chance, self.files.texts(chance)), {}, set()
        for parameter in chance.sample(parameters, chance.randint(0, 6)):
            schema = Schema(self.openapi, parameter["schema"])
            value = maker.make(schema)
            if chance.random() < 0.1:
                value = spoil([value], chance)
            value = value if not isinstance(value, dict) else "builtin:studio"
            texts = value if isinstance(value, list) else [value]
            text = ",".join(json.dumps(item) if isinstance(item, (bool, int, float)) else str(item) for item in texts)
            pairs[parameter["name"]] = text
            # Numbers are written as in JSON; what other texts come to is the server's to say.
            if TYPES["number"](value) and not schema.accepts(value):
                misfits.add(parameter["name"])
        for name, text in (("width", chance.randint(1, 32)), ("height", chance.randint(1, 32)), ("samples", 1)):
            pairs.setdefault(name, text)
        if chance.random() < 0.8:
            for name in ("quality", "r", "preset", "kid", "exp", "sig"):
                pairs.pop(name, None)
        is_fit = False if misfits & set(pairs) - {"exp"} else None
        pairs = list(pairs.items())
        if chance.random() < 0.05:
            pairs.append(chance.choice([*pairs, ("width", "0x10"), ("", ""), ("unknown", "1"), ("model", "\udcff")]))
        chance.shuffle(pairs)
        query = urllib.parse.urlencode(pairs, errors="surrogateescape")
        return query + (chance.choice(["&", "&&=", "%", "#"]) if chance.random() < 0.03 else ""), is_fit

    # --- bodies

    def document(self, schema, chance):
        """A JSON text, and whether the schema takes it."""
        maker = Maker(chance, self.files.texts(chance))
        value = maker.make(schema)
        if schema is self.request_schema:
            value = tame(value, chance)
        elif schema is self.documents["inspect"] and chance.random() < 0.7:
            value = {"model": value["model"]}
        elif isinstance(value, dict) and "request" in schema.node.get("properties", {}):
            value = self.batch(value, maker, chance)
        what = chance.random()
        if what < 0.25:
            value = spoil(value, chance)
        text = text_of(value, chance)
        if what > 0.93:
            text = broken_text(text, chance)
        return text, fits(schema, text)

    def batch(self, value, maker, chance):
        """With requests that draw, mostly."""
        value["request"] = tame(maker.make(self.request_schema), chance) if chance.random() < 0.5 else {"output": {"width": 8, "height": 8}}
        changes = [{"/output/width": 9}, {"/camera/orbit/azimuthDegrees": 90}, {}]
        odd = [{"/output/height": 0}, {"/scene/nodes/4000000000/mesh": 1}, {"/a~2": 0}, {"/scene/nodes/0/mesh": "builtin:cube"}, {"/strict/x": 1},
               {"/a" * 70: 1}, {"x": chance.choice(STRANGE)}]
        for item in value.get("items", ()):
            item["changes"] = chance.choice(odd if chance.random() < 0.15 else changes)
        quick = {"turntable": {"frames": 2}, "srcset": {"widths": [8, 9], "formats": ["png", "webp"]}, "contactSheet": {"cellPx": 16}}
        for name in set(quick) & set(value):
            if chance.random() < 0.7:
                value[name] = quick[name]
        for dimension in value.get("vary", ()):
            if chance.random() < 0.7:
                dimension.update(chance.choice([{"pointer": "/output/width", "values": [4, 5]}, {"pointer": "/strict", "values": [False]}]))
        return value

    def body(self, operation, chance):
        schema = self.documents.get(operation["operationId"])
        if schema is None:
            return self.bytes_of(operation["operationId"], chance)
        types = operation["requestBody"]["content"]
        kind = chance.choice([*types, "application/json", "application/json", "multipart/form-data"])
        text, is_fit = self.document(schema, chance)
        data = text.encode("utf-8", "surrogatepass")
        if kind == "application/json":
            return kind, data, text, is_fit
        if kind == "multipart/form-data":
            return (*self.form([("request", None, data), *((name, None, part) for name, part in self.files.parts.items())], chance), text, is_fit)
        return kind, spoiled_bytes(self.any_file(chance), chance), None, None

    def any_file(self, chance):
        return self.files.whole if chance.random() < 0.5 else chance.choice([*self.files.quad.values(), SKY, b"", b"x", b"PK\5\6" + b"\0" * 18])

    def form(self, parts, chance):
        boundary = chance.choice(["b", "a" * 70, "x'()+_,-./:=?"])
        for _ in range(chance.choice([0] * 8 + [1, 2])):
            parts.insert(chance.randint(0, len(parts)), chance.choice([("odd", "a/b.png", b""), ("odd", "\xfc.png", b"\0"), ("odd", '\\"', b"x"), ("ODD", None, b"\r\n")]))
        body = b""
        for name, file_name, data in parts:
            file_text = "" if file_name is None else f'; filename="{file_name}"'
            body += f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"{file_text}\r\n\r\n'.encode() + data + b"\r\n"
        return f'multipart/form-data; boundary="{boundary}"', body + f"--{boundary}--\r\n".encode()

    def piece(self, target, whole, chance):
        """The next one of an upload, mostly."""
        first = self.files.received.get(target, 0)
        last = max(first, min(len(whole) - 1, first + chance.choice([0, 10, 1000, 10_000])))
        if chance.random() < 0.15:
            return f"bytes */{len(whole)}", b""
        if chance.random() < 0.15:
            first += chance.choice([-1, 1, 100])
        return f"bytes {first}-{last}/{len(whole)}", whole[max(first, 0):last + chance.choice([1] * 8 + [0, 2])]

    def bytes_of(self, operation_id, chance):
        """A file, whose hash is known from then on."""
        data = self.any_file(chance) if chance.random() < 0.8 else chance.randbytes(chance.choice([1, 5, 5000]))
        if operation_id == "putEnvironment":
            data = SKY if chance.random() < 0.5 else data
        if operation_id == "postAsset" and chance.random() < 0.3:
            return (*self.form([("a", "a.bin", data), ("b", None, b"b")][:chance.randint(0, 2)], chance), None, None)
        self.files.assets.append(hashlib.sha256(data).hexdigest())
        return chance.choice(["application/octet-stream", "model/gltf-binary", "text/html", "image/x-exr"]), spoiled_bytes(data, chance), None, None


def without(request, places):
    """The same request without what stands at some places of its document."""
    document = strictly(request.text)
    for place in sorted(places, key=len, reverse=True):
        above, _, last = place.rpartition("/")
        try:
            holder = find(document, above)
            del holder[int(last) if isinstance(holder, list) else last.replace("~1", "/").replace("~0", "~")]
        except (LookupError, ValueError, TypeError):
            continue
    text = json.dumps(document)
    return request._replace(text=text, body=text.encode())


def spoiled_bytes(data, chance):
    if chance.random() < 0.7 or not data:
        return data
    at = chance.randrange(len(data))
    return data[:at] + bytes([chance.randrange(256)]) + data[at + chance.choice([0, 1, 50]):]
