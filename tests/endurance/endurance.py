#!/usr/bin/env python3
"""What takes too long for the tests: many renders in one process, and more load than there is room for.

endurance.py soak FURNACE [RENDERS]     small renders one after the other: first and last alike, memory and handles flat
endurance.py load FURNACE [SECONDS]     ten kinds of request at twice what the server takes: nothing but 200 and 429, nothing
                                        after its deadline, health answers meanwhile
"""
import collections
import http.client
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import threading
import time

TIMEOUT_MS = 30_000
MEGABYTE = 1 << 20


class Server:
    """`furnace serve`, its address and what it uses."""

    def __init__(self, furnace, *flags):
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen([furnace, "serve", "--listen", "127.0.0.1:0", "--admin-listen", "127.0.0.1:0", *flags],
                                        stdout=subprocess.PIPE, stderr=self.log, text=True)
        lines = [self.process.stdout.readline() for _ in range(3)]
        self.port = int(re.search(r"listening on http://127\.0\.0\.1:(\d+)", lines[0])[1])
        self.admin_port = int(re.search(r"admin on port (\d+)", "".join(lines))[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()

    def resident_bytes(self):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            return int(re.search(r"VmRSS:\s+(\d+) kB", status.read())[1]) * 1024

    def handles(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def threads(self):
        return len(os.listdir(f"/proc/{self.process.pid}/task"))


class Client:
    """One connection, opened again when the server has closed it."""

    def __init__(self, port):
        self.port, self.connection = port, None

    def ask(self, method, path, body=None):
        for attempt in range(3):
            try:
                if self.connection is None:
                    self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=2 * TIMEOUT_MS / 1000)
                self.connection.request(method, path, body, {"Content-Type": "application/json"} if body else {})
                response = self.connection.getresponse()
                return response.status, response.read()
            except (http.client.HTTPException, ConnectionError):
                self.connection.close()
                self.connection = None
                if attempt == 2:
                    raise
        raise AssertionError


def document(**output):
    return {"output": {"width": 32, "height": 32, **output}}


def kinds():
    """Ten kinds of request, none kept by the cache of renders."""
    return [document(),
            document(format="exr"),
            document(format="webp"),
            document(format="jpeg", toneMap="agx"),
            {**document(width=48), "scene": {"nodes": [{"mesh": "builtin:torus", "material": "copper-brushed"}]}},
            {**document(height=48), "environment": {"map": "builtin:overcast", "background": {"type": "transparent"}}},
            {**document(), "scene": {"nodes": [{"mesh": "builtin:sphere", "material": "glass"}]}},
            document(samples=4, bloom={"intensity": 0.2}),
            document(show="normal"),
            {**document(), "environment": {"ground": {}, "background": {"type": "gradient"}}}]


def soak(furnace, renders):
    documents = [json.dumps(kind) for kind in kinds()]
    with Server(furnace, "--render-cache", "0", "--log-level", "warning") as server:
        client = Client(server.port)
        first, settled = {}, None
        begin = time.monotonic()
        for i in range(renders):
            kind = i % len(documents)
            status, picture = client.ask("POST", "/v1/renders", documents[kind])
            if status != 200:
                sys.exit(f"render {i}: status {status}: {picture[:500]}")
            if first.setdefault(kind, picture) != picture:
                sys.exit(f"render {i} differs from the first of its kind")
            if i + 1 in (renders // 10, renders) or (i + 1) % max(1, renders // 20) == 0:
                used = (server.resident_bytes(), server.handles(), server.threads())
                settled = settled or (used if i + 1 >= renders // 10 else None)
                print(f"{i + 1:8} renders, {time.monotonic() - begin:7.0f} s, {used[0] / MEGABYTE:7.1f} MiB, {used[1]} handles, "
                      f"{used[2]} threads", flush=True)
    # The allocator keeps pages; a leak of a kilobyte a render would be a hundred times as much.
    allowed = settled[0] * 0.05 + 16 * MEGABYTE
    if used[0] - settled[0] > allowed or used[1] > settled[1] + 4 or used[2] > settled[2] + 2:
        sys.exit(f"not flat: {settled} after a tenth, {used} at the end")
    print("first and last alike, memory and handles flat")


def load(furnace, seconds):
    generator = random.Random(1)
    with Server(furnace, "--render-cache", "0", "--log-level", "error", "--queue", "8", "--timeout", f"{TIMEOUT_MS}ms") as server:
        statuses, latencies, health, faults = collections.Counter(), [], [], []
        end = time.monotonic() + seconds

        def ask_on(seed):
            client, own = Client(server.port), random.Random(seed)
            while time.monotonic() < end:
                # A seed in the camera makes each request another: nothing is joined.
                wanted = dict(own.choice(kinds()), camera={"orbit": {"azimuthDegrees": own.uniform(0, 360)}})
                begin = time.monotonic()
                try:
                    status, body = client.ask("POST", "/v1/renders", json.dumps(wanted))
                except OSError as fault:
                    faults.append(repr(fault))
                    continue
                took = time.monotonic() - begin
                statuses[status] += 1
                if status == 200:
                    latencies.append(took)
                elif status != 429:
                    faults.append(f"{status}: {body[:300]}")
                if took > TIMEOUT_MS / 1000 + 1:
                    faults.append(f"an answer after {took:.1f} s")
                if status == 429:
                    time.sleep(0.05)

        def ask_health():
            client = Client(server.admin_port)
            while time.monotonic() < end:
                begin = time.monotonic()
                status, _ = client.ask("GET", "/livez")
                health.append(time.monotonic() - begin)
                if status != 200:
                    faults.append(f"/livez: {status}")
                time.sleep(0.05)

        room = 2 * ((os.cpu_count() or 1) + 1 + 8)
        threads = [threading.Thread(target=ask_on, args=(generator.random(),)) for _ in range(room)]
        threads.append(threading.Thread(target=ask_health))
        used = [server.resident_bytes()]
        for thread in threads:
            thread.start()
        while time.monotonic() < end:
            time.sleep(max(1, seconds / 20))
            used.append(server.resident_bytes())
        for thread in threads:
            thread.join()
        latencies.sort()
        health.sort()

        def quantile(values, share):
            return 1000 * values[min(len(values) - 1, int(share * len(values)))]

        print(f"{room} clients, {seconds} s: {dict(statuses)}; of those admitted p50 {quantile(latencies, 0.5):.0f} ms, "
              f"p99 {quantile(latencies, 0.99):.0f} ms; /livez p99 {quantile(health, 0.99):.0f} ms, worst {1000 * health[-1]:.0f} ms; "
              f"memory {used[len(used) // 5] / MEGABYTE:.0f} MiB after a fifth, {used[-1] / MEGABYTE:.0f} MiB at the end")
        if faults:
            sys.exit(f"{len(faults)} faults, the first: {faults[0]}")


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in ("soak", "load"):
        sys.exit(__doc__)
    amount = int(sys.argv[3]) if len(sys.argv) > 3 else None
    if sys.argv[1] == "soak":
        soak(sys.argv[2], amount or 150_000)
    else:
        load(sys.argv[2], amount or 600)


if __name__ == "__main__":
    main()
