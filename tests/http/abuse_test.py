"""Clients that are slow, gone, half gone or talk nonsense: abuse_test.py FURNACE [unittest arguments]."""
import contextlib
import json
import random
import socket
import time

import http_support as support
from http_support import Case, Server, slow, small

HEAD = b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nContent-Type: application/json\r\nConnection: close\r\n"


def posted(document):
    body = json.dumps(document).encode()
    return HEAD + b"Content-Length: %d\r\n\r\n" % len(body) + body


class Abuse(Case):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--admin-listen", "127.0.0.1:0", "--header-timeout", "60s", "--io-timeout", "60s")
        cls.admin = f"http://127.0.0.1:{cls.server.admin_port()}"

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0, cls.server.log_text()
        cls.server.process.stdout.close()

    def setUp(self):
        self.expect_picture(self.server.render(small()), 48, 32)
        self.handles = support.handles(self.server)

    def tearDown(self):
        self.assertTrue(self.server.alive(), self.server.log_text()[-2000:])
        self.until(lambda: all(now <= then for now, then in zip(support.handles(self.server), self.handles)),
                   f"descriptors and threads were {self.handles}")
        self.expect_picture(self.server.render(small()), 48, 32)

    def until(self, condition, message=""):
        end = time.monotonic() + support.PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.02)

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.server.port), timeout=support.PATIENCE_S)

    def metric(self, name):
        text = self.server.curl("/metrics", base=self.admin).body.decode()
        return sum(float(line.split()[-1]) for line in text.splitlines() if line.startswith(name + " "))

    def rest(self, connection):
        """All that comes, without the signs of life before the answer."""
        out = b""
        with contextlib.suppress(ConnectionError):
            while piece := connection.recv(65536):
                out += piece
        while out.startswith(b"HTTP/1.1 102 "):
            out = out.partition(b"\r\n\r\n")[2]
        return out

    def test_many_slow_heads_and_bodies(self):
        starts = (b"GET /livez HTTP/1.1\r\nHost: h\r\nX: ", HEAD + b"Content-Length: 1000\r\n\r\n{",
                  HEAD + b"Transfer-Encoding: chunked\r\n\r\n5\r\n{")
        with contextlib.ExitStack() as open_ones:
            for i in range(120):
                open_ones.enter_context(self.connect()).sendall(starts[i % len(starts)])
            self.assertEqual(self.server.curl("/livez", base=self.admin).status, 200)
            # Each of them could hold its thread for a minute: this would run into the client's own time limit.
            self.assertEqual(self.server.curl("/livez", "--max-time", "30").status, 200)
            self.expect_picture(self.server.render(small()), 48, 32)

    def test_a_client_that_does_not_read(self):
        with self.connect() as connection:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.sendall(b"GET /openapi.json HTTP/1.1\r\nHost: h\r\n\r\n" * 200)
            self.expect_picture(self.server.render(small()), 48, 32)

    def test_a_client_that_only_ends_its_side_is_answered(self):
        with self.connect() as connection:
            connection.sendall(posted({"output": {"width": 500, "height": 500, "samples": 16}}))
            connection.shutdown(socket.SHUT_WR)
            self.assertTrue(self.rest(connection).startswith(b"HTTP/1.1 200 "))

    def test_a_client_that_is_gone_is_not_waited_for(self):
        gone = self.metric("furnace_clients_gone_total")
        for half_first in (False, True):
            with self.connect() as connection:
                connection.sendall(posted(slow()))
                self.until(lambda: self.metric("furnace_render_pool_active") == 1)
                if half_first:
                    connection.shutdown(socket.SHUT_WR)
                    self.assertTrue(connection.recv(64).startswith(b"HTTP/1.1 102 "))
                    self.assertEqual(self.metric("furnace_render_pool_active"), 1)
            self.until(lambda: self.metric("furnace_render_pool_active") == 0, "it is drawn for nobody")
        self.assertEqual(self.metric("furnace_clients_gone_total"), gone + 2)

    def test_half_an_old_client_is_gone(self):
        gone = self.metric("furnace_clients_gone_total")
        with self.connect() as connection:
            connection.sendall(posted(slow()).replace(b"HTTP/1.1", b"HTTP/1.0"))
            connection.shutdown(socket.SHUT_WR)
            self.assertTrue(self.rest(connection).startswith((b"HTTP/1.1 504 ", b"HTTP/1.0 504 ")))
        self.assertEqual(self.metric("furnace_clients_gone_total"), gone + 1)

    def test_nonsense(self):
        chance = random.Random(6)
        sound = [b"GET /v1/capabilities HTTP/1.1\r\nHost: h\r\nAccept: */*\r\n\r\n", posted({"output": {"width": 0}}),
                 HEAD + b"Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\nTrailer: x\r\n\r\n",
                 b"PUT /v1/assets/" + b"0" * 64 + b" HTTP/1.1\r\nHost: h\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\nabc"]
        words = [b"\r\n", b"\n", b"\r", b"\0", b" ", b":", b"\t", b"%", b"?", b"/", b"HTTP/1.1", b"HTTP/9.9", b"Content-Length: 5\r\n",
                 b"Content-Length: -1\r\n", b"Transfer-Encoding: chunked\r\n", b"Transfer-Encoding: gzip, chunked\r\n", b"ffffffffffffffff",
                 b"Host: a\r\n", b"Connection: upgrade\r\n", b"\x80\xff", b"X" * 9000, b"Expect: 200\r\n", b"Range: bytes=0-,0-\r\n"]
        for _ in range(300):
            said = chance.choice(sound)
            for _ in range(chance.randint(1, 4)):
                at = chance.randrange(len(said) + 1)
                said = said[:at] + chance.choice(words) + said[at + chance.choice((0, 0, 1, 5, 40)):]
            with self.connect() as connection:
                with contextlib.suppress(ConnectionError):
                    connection.sendall(said)
                    connection.shutdown(socket.SHUT_WR)
                answer = self.rest(connection)
                if answer:
                    self.assertRegex(answer[:13], rb"^HTTP/1\.[01] ([1234]|50[1457])", said)


if __name__ == "__main__":
    support.main()
