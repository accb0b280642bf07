"""Requests made from the served contract, and what must hold of every answer: property_test.py FURNACE [options].

Standard library only. The same seed makes the same requests; with --seconds they go on for so long. A failure tells its request,
and --seed S --only N sends that one alone (addresses of jobs are others then)."""
import argparse
import collections
import http.client
import io
import json
import random
import re
import sys
import tempfile
import time
import urllib.parse
import zipfile

import http_support as support
from http_support import Server
from property_requests import SKY, Files, Requests, without
from schema_support import Schema, find

Answer = collections.namedtuple("Answer", "status headers body")
MOST_FAILURES = 5
MAGIC = {"image/png": b"\x89PNG", "image/apng": b"\x89PNG", "image/jpeg": b"\xff\xd8", "image/webp": b"RIFF", "image/x-exr": b"\x76\x2f\x31\x01",
         "application/zip": b"PK"}
# Told of each answer alone, or of what others do meanwhile.
OF_EACH = {"date", "x-request-id", "traceresponse", "server-timing", "cache-status", "connection", "keep-alive"}
CHANGING = {"metrics", "getJob", "getJobEvents", "getJobResult", "ready"}
# What api/explain.cpp says of a document that the schema refuses.
SCHEMA_WORDS = re.compile(r"^(unknown key|needs the key|does not fit the schema|must be (an object|an array|a string|a whole number|a number|true or false|null)\b"
                          r"|must have .* got \d+$|.* is none of the \d+ known names)")


class Broken(Exception):
    """A property that does not hold."""


def expect(condition, *what):
    if not condition:
        raise Broken(" ".join(map(str, what)))


def send(port, method, target, headers, body):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=support.PATIENCE_S)
    try:
        connection.putrequest(method, target, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value.encode("latin-1"))
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders()
        try:
            connection.send(body or b"")
        except ConnectionError:
            pass  # refused from its head; the answer is there
        response = connection.getresponse()
        pairs = [(name.lower(), value) for name, value in response.getheaders()]
        expect(len(set(name for name, _ in pairs)) == len(pairs), "a header stands twice:", pairs)
        return Answer(response.status, dict(pairs), response.read())
    finally:
        connection.close()


def is_there(document, place):
    try:
        find(document, place)
    except LookupError:
        return False
    return True


def leads_somewhere(document, place):
    """To a value, or to one that is not there because its default counts."""
    value = document
    for part in place.split("/")[1:]:
        try:
            value = find({"": value}, "//" + part)
        except LookupError:
            return isinstance(value, dict)
    return True


class Contract:
    def __init__(self, openapi):
        self.openapi = openapi
        self.problem = Schema(openapi, openapi["components"]["schemas"]["Problem"])
        self.job = Schema(openapi, openapi["components"]["schemas"]["Job"])
        self.exclusions = {rule["description"] for rule in self.rules_of(openapi) if "description" in rule}

    def rules_of(self, node):
        if isinstance(node, dict):
            if isinstance(node.get("not"), dict):
                yield from node["not"].get("anyOf", [node["not"]])
            for member in node.values():
                yield from self.rules_of(member)

    def documented(self, operation, status):
        for key in (str(status), f"{status // 100}XX"):
            if key in operation["responses"]:
                entry = operation["responses"][key]
                return find(self.openapi, entry["$ref"][1:]) if "$ref" in entry else entry
        raise Broken(f"the status {status} is not documented")

    def check(self, request, answer):
        expect(answer.status < 500, "the server is at fault:", answer.status)
        expect("x-request-id" in answer.headers, "no X-Request-Id")
        expect(answer.headers.get("x-content-type-options") == "nosniff", "no nosniff")
        if request.method != "HEAD" and answer.status not in (204, 304) and "transfer-encoding" not in answer.headers:
            expect(int(answer.headers["content-length"]) == len(answer.body), "a wrong Content-Length")
        if answer.status >= 400:
            self.check_problem(request, answer)
        if request.method.lower() in self.openapi["paths"][request.path]:
            response = self.documented(request.operation, answer.status)
            self.check_content(response, answer)
        if request.fits is False:
            expect(answer.status >= 400, "a document that the schema refuses is taken:", answer.status)
        if request.fits and answer.status >= 400 and answer.body:
            self.check_reasons(request, json.loads(answer.body))

    def check_problem(self, request, answer):
        expect(answer.headers["content-type"] == "application/problem+json", answer.headers)
        expect(answer.headers["cache-control"] == "no-store", answer.headers)
        if request.method == "HEAD":
            return
        problem = json.loads(answer.body)
        expect(self.problem.accepts(problem), "no problem document:", list(self.problem.problems(problem)))
        expect(problem["status"] == answer.status, "another status in the problem")
        expect(problem["instance"] == answer.headers["x-request-id"], "another request id in the problem")
        for place in [problem.get("pointer", ""), *(entry["pointer"] for entry in problem.get("errors", ()))]:
            self.check_pointer(request, problem, place)

    def check_pointer(self, request, problem, place):
        if place.startswith("?"):
            names = [name for name, _ in urllib.parse.parse_qsl(request.target.partition("?")[2], keep_blank_values=True, errors="surrogateescape")]
            expect(place[1:].encode("utf-8", "replace") in [name.encode("utf-8", "replace") for name in names] or place == "?preset",
                   "no such key in the query:", place)
            return
        expect(place == "" or place.startswith("/"), "no JSON pointer:", place)
        if request.text is None or not place or self.is_of_an_item(request, problem):
            return
        try:
            document = json.loads(request.text.lstrip("\ufeff"))
        except (ValueError, RecursionError):
            return
        expect(leads_somewhere(document, place), place, "leads nowhere in the document")

    def is_of_an_item(self, request, problem):
        """Those of a batch's items point into the item's request; under "strict" they are notes, which may point into a model."""
        is_item = request.path == "/v1/batches" and not problem.get("pointer", "").startswith(("/request", "/items", "/vary"))
        return is_item or problem["detail"].startswith("strict: ")

    def check_content(self, response, answer):
        content = response.get("content", {})
        kind = answer.headers.get("content-type", "").partition(";")[0]
        if not content:
            expect(not answer.body and not kind, "a body that is not documented:", kind, answer.body[:100])
            return
        known = [key for key in (kind, kind.partition("/")[0] + "/*", "*/*") if key in content]
        expect(known, "the media type is not documented:", kind)
        if not answer.body:
            return
        if kind == "application/json" and "application/json" in known:
            problems = list(Schema(self.openapi, content["application/json"]["schema"]).problems(json.loads(answer.body)))
            expect(not problems, "the answer does not fit its schema:", problems[:5])
        if kind == "text/event-stream":
            jobs = re.findall(rb"^data: (.*)$", answer.body, re.M)
            expect(jobs and all(self.job.accepts(json.loads(job)) for job in jobs), "events without jobs:", answer.body[:500])
        if "*/*" not in known:
            expect(answer.body.startswith(MAGIC.get(kind, b"")), "is not what its media type says:", answer.body[:8])
        if kind == "application/zip" and "*/*" not in known:
            self.check_archive(answer)

    def check_archive(self, answer):
        with zipfile.ZipFile(io.BytesIO(answer.body)) as archive:
            expect(archive.testzip() is None, "a damaged archive")
            if "index.json" in archive.namelist():
                index = json.loads(archive.read("index.json"))
                items = index["items"]
                files = [item["file"] for item in items if "file" in item] + ([index["contactSheet"]] if "contactSheet" in index else [])
                expect(sorted([*files, "index.json"]) == sorted(archive.namelist()), "the index tells of other files", archive.namelist())
                for item in items:
                    expect(("file" in item) != ("problem" in item) and self.problem.accepts(item.get("problem", self.problem.node["examples"][0])), item)

    def check_reasons(self, request, problem):
        """Whatever else is wrong with it, the schema took the document."""
        for entry in () if self.is_of_an_item(request, problem) else problem.get("errors", ()):
            expect(not SCHEMA_WORDS.match(entry["detail"]) and entry["detail"] not in self.exclusions, "the schema takes this:", entry)


class Run:
    def __init__(self, server, seed, verbose):
        self.server, self.seed, self.verbose = server, seed, verbose
        openapi = json.loads(server.curl("/openapi.json").body)
        self.files, self.contract = Files(), Contract(openapi)
        self.requests = Requests(openapi, json.loads(server.curl("/v1/schema.json").body), self.files)
        self.failures, self.statuses = [], collections.Counter()

    def case(self, number, operation_id=None):
        chance = random.Random(f"{self.seed}/{number}")
        request = self.requests.make(chance, operation_id)
        answer = None
        try:
            answer = self.ask(request)
            self.contract.check(request, answer)
            self.files.learn(request, answer)
            if request.method == "GET" and chance.random() < 0.3:
                self.check_head(request, answer)
            if answer.status == 200 and "etag" in answer.headers and request.method in ("GET", "POST") and chance.random() < 0.2:
                self.check_not_modified(request, answer)
            for _ in range(4):
                request, answer = self.mend(request, answer)
        except (Broken, OSError, http.client.HTTPException, ValueError, KeyError) as why:
            self.fail(number, request, answer, why)
        self.statuses[(request.operation["operationId"], answer.status if answer else 0)] += 1

    def ask(self, request, method=None, **headers):
        begun = time.monotonic()
        answer = send(self.server.port, method or request.method, request.target, {**request.headers, **headers}, request.body)
        if self.verbose:
            print(f"{time.monotonic() - begun:7.3f} s {answer.status} {request.method} {request.target[:100]}")
        return answer

    def mend(self, request, answer):
        """The request without what was told to be wrong, which is not told again; in a list others move up."""
        is_plain = request.fits and answer.status == 422 and request.text is not None and request.headers["Content-Type"] == "application/json"
        if not is_plain or request.path == "/v1/batches":
            return request, answer
        told = {(entry["pointer"], entry["detail"]) for entry in json.loads(answer.body).get("errors", ())
                if entry["pointer"] and is_there(json.loads(request.text), entry["pointer"])}
        request = without(request, {place for place, _ in told})
        request = request._replace(fits=self.requests.documents[request.operation["operationId"]].accepts(json.loads(request.text)))
        answer = self.ask(request)
        self.contract.check(request, answer)
        if answer.status == 422:
            again = {(entry["pointer"], entry["detail"]) for entry in json.loads(answer.body).get("errors", ())} & told
            # A default may be more than this server allows, too.
            again = [(place, detail) for place, detail in again if not re.search(r"/\d", place) and "than this server's" not in detail]
            expect(not again, "is told of what was left out:", again)
        self.statuses[("mended", answer.status)] += 1
        return request, answer

    def check_head(self, request, answer):
        head = self.ask(request, "HEAD")
        expect(head.body == b"", "HEAD has a body")
        if request.operation["operationId"] in CHANGING or "Range" in request.headers:
            return
        expect(head.status == answer.status, "HEAD is answered", head.status)
        ours, theirs = ({name: value for name, value in one.headers.items() if name not in OF_EACH} for one in (answer, head))
        if answer.status >= 400:
            ours.pop("content-length"), theirs.pop("content-length")  # request ids differ in length
        expect(ours == theirs, "HEAD has other headers:", set(ours.items()) ^ set(theirs.items()))

    def check_not_modified(self, request, answer):
        again = self.ask(request, **{"If-None-Match": answer.headers["etag"]})
        expect((again.status, again.body, again.headers.get("etag")) == (304, b"", answer.headers["etag"]), "not 304 but", again.status, again.headers)

    def fail(self, number, request, answer, why):
        self.failures.append(number)
        print(f"\nFAILED: {type(why).__name__}: {why}\n--seed {self.seed} --only {number}: {request.operation['operationId']}, fits: {request.fits}\n"
              f"{request.method} {request.target}\n{request.headers}\n{(request.text or request.body or '')[:3000]!r}\n-> "
              + (f"{answer.status} {answer.headers}\n{answer.body[:1000]!r}" if answer else "no answer"), flush=True)

    def wait_for_jobs(self):
        end = time.monotonic() + support.PATIENCE_S
        while any(self.server.metric(name) for name in ("furnace_jobs_waiting", "furnace_seats_in_use")):
            assert time.monotonic() < end, "the jobs do not end"
            time.sleep(0.05)

    def picture(self):
        answer = self.server.render(support.small(), "-H", "Accept: image/png")
        assert answer.status == 200, answer
        return answer.body

    def go(self, options):
        """Whether all holds. What the server makes when it is first needed is made before threads and descriptors are counted."""
        first = self.picture()
        if options.only is not None:
            self.case(options.only)
            return not self.failures
        for number, entry in enumerate(self.requests.operations * 3):
            self.case(-1 - number, entry[2]["operationId"])
        self.wait_for_jobs()
        before = support.handles(self.server)
        end = time.monotonic() + (options.seconds or float("inf"))
        number = 0
        while (time.monotonic() < end if options.seconds else number < options.cases) and len(self.failures) < MOST_FAILURES and self.server.alive():
            self.case(number)
            number += 1
        if not self.server.alive():
            print(f"the server has ended at case {number - 1} of seed {self.seed}:\n{self.server.log_text()[-3000:]}")
            return False
        self.wait_for_jobs()
        assert self.picture() == first
        self.expect_handles(before)
        print(f"seed {self.seed}: {number} requests, {len(self.failures)} failures; operations and statuses:")
        for (operation, status), count in sorted(self.statuses.items()):
            print(f"  {operation} {status}: {count}")
        return not self.failures

    def expect_handles(self, before):
        end = time.monotonic() + support.PATIENCE_S
        while any(now > then for now, then in zip(support.handles(self.server), before)):
            assert time.monotonic() < end, (f"descriptors and threads were {before}, are {support.handles(self.server)}: "
                                            f"{support.thread_names(self.server)}")
            time.sleep(0.1)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=1200)
    parser.add_argument("--seconds", type=float, help="instead of a number of cases")
    parser.add_argument("--only", type=int, help="one case")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    files = Files()
    with tempfile.TemporaryDirectory() as data, tempfile.TemporaryDirectory() as assets, tempfile.TemporaryDirectory() as presets:
        for name, content in {**files.quad, "sky.hdr": SKY}.items():
            with open(f"{assets}/{name}", "wb") as file:
                file.write(content)
        with open(f"{presets}/ring.json", "w", encoding="utf-8") as file:
            json.dump({"furnace:open": ["width"], "scene": {"model": "builtin:torus"}, "output": {"width": 16, "height": 16}}, file)
        with Server("--data", data, "--assets", assets, "--presets", presets, "--max-side", "64", "--max-area", "2048", "--max-frames", "4",
                    "--max-samples", "4", "--max-batch", "8", "--timeout", "60s") as server:
            done = Run(server, options.seed, options.verbose).go(options)
    sys.exit(0 if done else 1)


if __name__ == "__main__":
    main()
