"""HTTPS of the real program, with certificates made on the spot: tls_test.py FURNACE [unittest arguments]."""
import hashlib
import json
import os
import shutil
import signal
import socket
import ssl
import subprocess
import tempfile
import time

import http_support as support
from http_support import FURNACE, Case, Server, slow, small

POST = b"POST /v1/renders HTTP/1.1\r\nHost: h\r\nContent-Type: application/json\r\nConnection: close\r\nContent-Length: "


def make_certificate(folder, name):
    """NAME.pem and NAME.key, for this machine's own address."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                    "-subj", f"/CN={name}", "-addext", "subjectAltName=IP:127.0.0.1",
                    "-out", f"{folder}/{name}.pem", "-keyout", f"{folder}/{name}.key"], check=True, capture_output=True)
    os.chmod(f"{folder}/{name}.key", 0o600)


def posted(document):
    body = json.dumps(document).encode()
    return POST + b"%d\r\n\r\n" % len(body) + body


class Tls(Case):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory()
        for name in ("one", "two"):
            make_certificate(cls.made.name, name)

    @classmethod
    def tearDownClass(cls):
        cls.made.cleanup()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.certificate, self.key = (os.path.join(self.folder, name) for name in ("certificate", "key"))
        self.use("one")

    def use(self, certificate, key=None):
        shutil.copy(f"{self.made.name}/{certificate}.pem", self.certificate)
        shutil.copy(f"{self.made.name}/{key or certificate}.key", self.key)

    def server(self, *flags):
        return Server("--tls-certificate", self.certificate, "--tls-key", self.key, *flags)

    def ask(self, server, path, *flags):
        return server.curl(path, "--cacert", self.certificate, *flags)

    def context(self):
        context = ssl.create_default_context(cafile=f"{self.made.name}/one.pem")
        context.load_verify_locations(f"{self.made.name}/two.pem")
        return context

    def tcp(self, server):
        return socket.create_connection(("127.0.0.1", server.port), timeout=support.PATIENCE_S)

    def connect(self, server, context=None):
        return (context or self.context()).wrap_socket(self.tcp(server), server_hostname="127.0.0.1")

    def name_shown(self, server):
        with self.connect(server) as connection:
            return dict(pair[0] for pair in connection.getpeercert()["subject"])["commonName"]

    def until(self, condition, message=""):
        end = time.monotonic() + support.PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), end, message)
            time.sleep(0.02)

    def rest(self, connection):
        out = b""
        while piece := connection.recv(65536):
            out += piece
        return out

    def metric(self, admin, name):
        text = support.curl(f"http://127.0.0.1:{admin}/metrics").body.decode()
        return sum(float(line.split()[-1]) for line in text.splitlines() if line.startswith(name + " "))

    def test_pictures_and_uploads(self):
        with self.server("--data", os.path.join(self.folder, "data")) as server:
            self.assertTrue(server.url.startswith("https://"))
            answer = self.ask(server, "/v1/renders", "-H", "Content-Type: application/json", "-d", json.dumps(small(900, 700)))
            self.expect_picture(answer, 900, 700)
            self.assertEqual(answer.headers["strict-transport-security"], "max-age=31536000")
            body = os.urandom(5 << 20)
            path = os.path.join(self.folder, "body")
            with open(path, "wb") as file:
                file.write(body)
            asset = f"/v1/assets/{hashlib.sha256(body).hexdigest()}"
            self.assertEqual(self.ask(server, asset, "-T", path).status, 201)
            self.assertEqual(self.ask(server, asset).body, body)
            self.expect_problem(self.ask(server, "/v1/nothing"), 404)
            with self.connect(server) as connection:
                for _ in range(3):
                    connection.sendall(b"GET /livez HTTP/1.1\r\nHost: h\r\n\r\n")
                    answer = b""
                    while not answer.endswith(b"\r\n\r\nalive\n"):
                        piece = connection.recv(65536)
                        self.assertTrue(piece, answer)
                        answer += piece
                    self.assertTrue(answer.startswith(b"HTTP/1.1 200 "))

    def test_protocols(self):
        with self.server() as server:
            context = self.context()
            context.set_alpn_protocols(["h2", "http/1.1"])
            with self.connect(server, context) as connection:
                self.assertEqual(connection.selected_alpn_protocol(), "http/1.1")
                self.assertEqual(connection.version(), "TLSv1.3")
            context.set_alpn_protocols(["h2"])
            with self.assertRaises(OSError):
                self.connect(server, context)
            old = self.context()
            old.maximum_version = ssl.TLSVersion.TLSv1_2
            with self.connect(server, old) as connection:
                self.assertRegex(connection.cipher()[0], "^ECDHE-.*(GCM|POLY1305)")
            old.set_ciphers("ECDHE-ECDSA-AES128-SHA")
            with self.assertRaises(OSError):
                self.connect(server, old)
            for nonsense in (b"GET / HTTP/1.1\r\nHost: h\r\n\r\n", b"\x16\x03\x01\xff\xff" + b"x" * 5000):
                with self.tcp(server) as connection:
                    try:
                        connection.sendall(nonsense)
                        self.assertNotIn(b"HTTP/1.1 200", self.rest(connection))
                    except ConnectionError:
                        pass
            self.assertEqual(self.ask(server, "/livez").status, 200)

    def test_a_new_certificate_while_it_serves(self):
        with self.server("--keep-alive", "10min") as server:
            self.assertEqual(self.name_shown(server), "one")
            with self.connect(server) as old:
                self.use("two")
                server.process.send_signal(signal.SIGHUP)
                self.until(lambda: self.name_shown(server) == "two")
                old.sendall(b"GET /livez HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n")
                self.assertTrue(self.rest(old).startswith(b"HTTP/1.1 200 "))
            self.use("one", key="two")
            server.process.send_signal(signal.SIGHUP)
            self.until(lambda: "tls.kept" in server.log_text())
            self.assertIn("is not the key of the certificate", server.log_text())
            self.assertEqual(self.name_shown(server), "two")
            self.use("one")
            server.process.send_signal(signal.SIGHUP)
            self.until(lambda: self.name_shown(server) == "one")

    def test_what_is_wrong_is_told_before_the_start(self):
        def told(*flags):
            run = subprocess.run([FURNACE, "check-config", *flags], capture_output=True, text=True, timeout=support.PATIENCE_S)
            return run.returncode, run.stderr

        files = ("--tls-certificate", self.certificate, "--tls-key", self.key)
        self.assertEqual(told(*files)[0], 0, told(*files))
        for change, words in ((lambda: self.use("one", key="two"), "is not the key of the certificate"),
                              (lambda: os.chmod(self.key, 0o644), "can be read by everyone"),
                              (lambda: shutil.copyfile(self.certificate, self.key), "is not a private key"),
                              (lambda: shutil.copyfile(self.key, self.certificate), "does not begin with a certificate"),
                              (lambda: os.remove(self.certificate), "cannot be opened")):
            self.use("one")
            os.chmod(self.key, 0o600)
            change()
            status, text = told(*files)
            self.assertEqual(status, 1)
            self.assertIn(words, text)
        status, text = told("--tls-key", self.key)
        self.assertEqual(status, 1)
        self.assertIn("without the other", text)

    def test_slow_clients(self):
        with self.server("--header-timeout", "300ms", "--io-timeout", "300ms") as server:
            for hello in (b"", b"\x16\x03\x01\x02\x00\x01\x00"):
                with self.tcp(server) as connection:
                    connection.sendall(hello)
                    self.assertNotIn(b"HTTP", self.rest(connection))
            for start in (b"GET /livez HTTP/1.1\r\nHo", POST + b"100\r\n\r\n{"):
                with self.connect(server) as connection:
                    connection.sendall(start)
                    self.assertTrue(self.rest(connection).startswith(b"HTTP/1.1 408 "))

    def test_plain_http_is_told_what_it_met(self):
        with self.server() as server:
            plain = f"http://127.0.0.1:{server.port}"
            answer = support.curl(f"{plain}/v1/renders", "-d", "{}")
            self.expect_problem(answer, 400)
            self.assertIn(b"https://", answer.body)
            self.assertEqual(answer.headers["connection"], "close")
            path = os.path.join(self.folder, "upload")
            with open(path, "wb") as file:
                file.write(bytes(2 << 20))
            self.assertEqual(support.curl(f"{plain}/v1/assets", "-T", path).status, 400)
            self.assertEqual(self.ask(server, "/livez").status, 200)

    def test_many_that_never_finish_their_handshake(self):
        with self.server("--header-timeout", "10min") as server:
            before = support.handles(server)
            silent = [self.tcp(server) for _ in range(80)]
            self.assertEqual(self.ask(server, "/livez", "--max-time", "60").status, 200)
            for connection in silent:
                connection.close()
            self.until(lambda: all(now <= then for now, then in zip(support.handles(server), before)), f"{before}")

    def test_clients_that_leave(self):
        with self.server("--admin-listen", "127.0.0.1:0") as server:
            admin = server.admin_port()
            with self.connect(server) as connection:
                connection.sendall(posted({"output": {"width": 500, "height": 500, "samples": 16}}))
                other = socket.socket(fileno=os.dup(connection.fileno()))
                other.shutdown(socket.SHUT_WR)
                other.close()
                parts = self.rest(connection).split(b"HTTP/1.1 ")
                self.assertTrue(parts[-1].startswith(b"200 "), parts)
            with self.connect(server) as connection:
                connection.sendall(posted(slow()))
                self.until(lambda: self.metric(admin, "furnace_render_pool_active") == 1)
            self.until(lambda: self.metric(admin, "furnace_render_pool_active") == 0)
            self.assertEqual(self.metric(admin, "furnace_clients_gone_total"), 1)


if __name__ == "__main__":
    support.main()
