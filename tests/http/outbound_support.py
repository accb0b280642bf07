"""A server that misbehaves as told: what furnace calls in the tests."""
import http.server
import json
import socket
import ssl
import struct
import subprocess
import threading
import time

import http_support as support


class Receiver:
    """HTTP on 127.0.0.1; `answers[path]` is a function of the handler. `with Receiver() as receiver:`."""

    def __init__(self, certificate=None):
        receiver = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                receiver.answer(self)

            do_POST = do_GET

            def log_message(self, *_):
                pass

        self.answers, self.seen = {}, []
        self.changed, self.released = threading.Condition(), threading.Event()
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.port = self.server.server_address[1]
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.origin = f"http{'s' if certificate else ''}://127.0.0.1:{self.port}"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.released.set()
        self.server.shutdown()
        self.server.server_close()

    def answer(self, handler):
        body = handler.rfile.read(int(handler.headers.get("Content-Length") or 0))
        with self.changed:
            self.seen.append((handler.path, handler.headers, body))
            self.changed.notify_all()
        handler.close_connection = True
        try:
            self.answers.get(handler.path, replies(404))(handler)
        except (ConnectionError, ssl.SSLError):
            pass  # the other side had enough

    def count(self, path):
        return sum(1 for seen, _, _ in list(self.seen) if seen == path)

    def wait_for(self, path, count=1):
        """The headers and body of the count-th request for the path."""
        with self.changed:
            if not self.changed.wait_for(lambda: self.count(path) >= count, support.PATIENCE_S):
                raise AssertionError(f"{path} was not asked for {count} times: {[path for path, _, _ in self.seen]}")
            return [(headers, body) for seen, headers, body in self.seen if seen == path][count - 1]


def replies(status, body=b"", **headers):
    def answer(handler):
        handler.send_response(status)
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.send_header("Content-Length", str(len(body)))
        handler.end_headers()
        handler.wfile.write(body)
    return answer


def redirects(place):
    return replies(302, Location=place)


def in_turn(*answers):
    """The last one for ever."""
    left = list(answers)
    return lambda handler: (left.pop(0) if len(left) > 1 else left[0])(handler)


def waits(receiver, then):
    def answer(handler):
        receiver.released.wait(support.PATIENCE_S)
        then(handler)
    return answer


def raw(data):
    return lambda handler: handler.wfile.write(data)


def resets(handler):
    handler.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    handler.connection.close()


def endless(handler):
    handler.wfile.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n")
    while True:
        handler.wfile.write(b"1000\r\n" + bytes(0x1000) + b"\r\n")


def certificate(folder):
    """A certificate of 127.0.0.1 and its key, as paths."""
    names = (f"{folder}/cert.pem", f"{folder}/key.pem")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                    "-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1", "-out", names[0], "-keyout", names[1]],
                   check=True, capture_output=True)
    return names


def wait_for_job(server, place, done):
    """The job's document once done(document) holds."""
    end = time.monotonic() + support.PATIENCE_S
    while time.monotonic() < end:
        job = json.loads(server.curl(place).body)
        if done(job):
            return job
        time.sleep(0.05)
    raise AssertionError(f"not yet: {job}")
