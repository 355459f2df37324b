"""A page for tests of `tulle view`, in Python without packages: starts the program, speaks HTTP and WebSocket over raw sockets, and
decodes frames as web/PROTOCOL.md describes them."""
import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import time

PROGRAM = os.environ.get("TULLE", "tulle")
KIND_MESH, KIND_FRAME, KIND_OVERLAY = 1, 2, 3


class Closed(Exception):
    """The server closed the connection: code and reason."""

    def __init__(self, code, reason):
        super().__init__(f"closed: {code} {reason}")
        self.code, self.reason = code, reason


class Server:
    """A program under test: it ends with the block."""

    def __init__(self, *arguments, folder=None, environment=None):
        self.process = subprocess.Popen([PROGRAM, "view", "--no-browser", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        cwd=folder, text=True, env={**os.environ, **(environment or {})})
        self.line = self.process.stdout.readline().strip()
        match = re.match(r"http://(.*):(\d+)/([0-9a-f]{32})/$", self.line)
        if not match:
            self.process.wait(30)
            raise RuntimeError(f"no address but {self.line!r}: {self.process.stderr.read()}")
        self.host, self.port, self.token = match.group(1), int(match.group(2)), match.group(3)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            output, errors = self.process.communicate(timeout=120)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        self.output, self.errors, self.code = output, errors, self.process.returncode
        if self.code not in (0, 1) or "Sanitizer" in errors:
            raise RuntimeError(f"the program ended with {self.code}: {errors}")

    def read_line(self):
        return self.process.stdout.readline().strip()

    def open_socket(self, timeout=30.0):
        return socket.create_connection((self.host.strip("[]"), self.port), timeout)

    def request(self, path, method="GET", headers=None, host=None, body=b""):
        """Status, headers (small letters) and body of an answer; None where the connection just ends."""
        with self.open_socket() as connection:
            head = f"{method} {path} HTTP/1.1\r\nHost: {host or f'{self.host}:{self.port}'}\r\nConnection: close\r\n"
            head += "".join(f"{name}: {value}\r\n" for name, value in (headers or {}).items()) + "\r\n"
            connection.sendall(head.encode("latin-1") + body)
            data = b""
            try:
                while chunk := connection.recv(1 << 16):
                    data += chunk
            except ConnectionResetError:
                pass
        if b"\r\n\r\n" not in data:
            return None, {}, data
        head, body = data.split(b"\r\n\r\n", 1)
        lines = head.decode("latin-1").split("\r\n")
        pairs = [line.split(":", 1) for line in lines[1:]]
        return int(lines[0].split(" ")[1]), {key.strip().lower(): value.strip() for key, value in pairs}, body

    def get(self, name):
        return self.request(f"/{self.token}/{name}")


class Grid:
    """What a client knows of an object."""

    def __init__(self, vertex_count, positions):
        self.vertex_count, self.positions = vertex_count, positions
        self.low, self.step, self.places = None, 0.0, None


class Page:
    """A WebSocket with what came over it: document, meshes, the newest frame and state."""

    def __init__(self, server, origin=None, path=None, protocol="tulle-1", host=None, begins=True, receive_buffer=None):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(60.0)
        self.socket.connect((server.host, server.port))
        own = f"{server.host}:{server.port}"
        lines = [f"GET {path or f'/{server.token}/session'} HTTP/1.1", f"Host: {host or own}", "Upgrade: websocket",
                 "Connection: Upgrade", f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}", "Sec-WebSocket-Version: 13"]
        if origin != "":
            lines.append(f"Origin: {origin or 'http://' + own}")
        if protocol:
            lines.append(f"Sec-WebSocket-Protocol: {protocol}")
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))
        self.data = b""
        while b"\r\n\r\n" not in self.data:
            chunk = self.socket.recv(1 << 16)
            if not chunk:
                break
            self.data += chunk
        head, _, self.data = self.data.partition(b"\r\n\r\n")
        first = head.split(b"\r\n")[0].split(b" ")
        self.status = int(first[1]) if len(first) > 1 else None
        self.next_id, self.acknowledges = 1, True
        self.document = self.state = self.frame = None
        self.meshes, self.grids, self.overlays, self.texts = [], [], {}, []
        self.frame_count, self.byte_count = 0, 0
        if begins and self.status == 101:
            self.wait_for(lambda: self.document and len(self.meshes) == len(self.document["objects"]))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    # ---- frames of the WebSocket ----

    def send_frame(self, opcode, payload, is_final=True, is_masked=True, reserved=0):
        size = len(payload)
        head = bytes([(0x80 if is_final else 0) | reserved << 4 | opcode])
        mask_bit = 0x80 if is_masked else 0
        if size < 126:
            head += bytes([mask_bit | size])
        elif size < 1 << 16:
            head += bytes([mask_bit | 126]) + struct.pack(">H", size)
        else:
            head += bytes([mask_bit | 127]) + struct.pack(">Q", size)
        mask = os.urandom(4)
        if is_masked:
            long_mask = mask * (size // 4 + 1)
            payload = (int.from_bytes(payload, "big") ^ int.from_bytes(long_mask[:size], "big")).to_bytes(size, "big") if size else b""
            head += mask
        self.socket.sendall(head + payload)

    def take(self, count):
        parts, have = [self.data], len(self.data)
        while have < count:
            chunk = self.socket.recv(1 << 20)
            if not chunk:
                raise Closed(1006, "without a word")
            parts.append(chunk)
            have += len(chunk)
        data = b"".join(parts)
        self.data = data[count:]
        return data[:count]

    def receive_frame(self):
        first, second = self.take(2)
        size = second & 0x7F
        if size == 126:
            size = struct.unpack(">H", self.take(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self.take(8))[0]
        return bool(first & 0x80), first & 0x0F, self.take(size)

    def receive(self):
        """The next message: a dict or bytes."""
        opcode, parts = None, []
        while True:
            is_final, code, payload = self.receive_frame()
            if code == 8:
                code = struct.unpack(">H", payload[:2])[0] if len(payload) >= 2 else 1005
                raise Closed(code, payload[2:].decode("utf-8", "replace"))
            if code == 9:
                self.send_frame(10, payload)
                continue
            if code == 10:
                continue
            opcode = opcode or code
            parts.append(payload)
            if is_final:
                data = b"".join(parts)
                self.byte_count += len(data)
                return data if opcode == 2 else json.loads(data)

    # ---- the protocol ----

    def send(self, type_name, **members):
        self.send_frame(1, json.dumps({"type": type_name, **members}).encode())

    def step_once(self):
        """Takes in one message."""
        message = self.receive()
        if isinstance(message, bytes):
            self.take_binary(message)
        elif message["type"] == "document":
            self.document, self.meshes, self.grids, self.frame = message, [], [], None
        elif message["type"] == "state":
            self.state = message
        else:
            self.texts.append(message)
        return message

    def wait_for(self, condition, seconds=60.0):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError("nothing of that kind came")
            self.step_once()

    def ask(self, type_name, **members):
        """The answer to a request."""
        number, self.next_id = self.next_id, self.next_id + 1
        self.send(type_name, id=number, **members)
        found = []

        def is_there():
            found.extend(text for text in self.texts if text.get("id") == number)
            return bool(found)
        self.wait_for(is_there)
        self.texts = [text for text in self.texts if text.get("id") != number]
        return found[0]

    def take_binary(self, data):
        kind, version, number, frame, seconds, sequence, count = struct.unpack_from("<BBHIdII", data)
        assert version == 1
        if kind == KIND_MESH:
            vertices, triangles, flags = struct.unpack_from("<III", data, 24)
            assert number == len(self.meshes)
            at = 36 + 12 * vertices
            positions = struct.unpack_from(f"<{3 * vertices}f", data, 36)
            corners = struct.unpack_from(f"<{3 * triangles}I", data, at)
            assert len(data) == at + 12 * triangles + (8 * vertices if flags & 1 else 0)
            self.meshes.append((positions, corners))
            self.grids.append(Grid(vertices, positions))
        elif kind == KIND_FRAME:
            self.frame = {"number": frame, "time": seconds, "sequence": sequence, "codings": [], "absent": []}
            self.frame_count += 1
            self.decode(data, count)
            if self.acknowledges:
                self.send("got", sequence=sequence)
        else:
            assert kind == KIND_OVERLAY
            self.overlays[number] = (frame, count, data[24:])

    def decode(self, data, count):
        at = 24
        for _ in range(count):
            assert at % 4 == 0
            index, coding, flags, vertices = struct.unpack_from("<HBBI", data, at)
            grid, at = self.grids[index], at + 8
            assert vertices == grid.vertex_count
            self.frame["codings"].append(coding)
            self.frame["absent"].append(flags & 1)
            if coding == 1:
                grid.positions, grid.places = struct.unpack_from(f"<{3 * vertices}f", data, at), None
                at += 12 * vertices
            elif coding == 2:
                *low, step = struct.unpack_from("<4f", data, at)
                grid.low, grid.step = low, step
                grid.places = list(struct.unpack_from(f"<{3 * vertices}H", data, at + 16))
                at += 16 + 6 * vertices
                at += -at % 4
                grid.positions = None
            elif coding == 3:
                for begin in range(0, 3 * vertices, 192):
                    end = min(begin + 192, 3 * vertices)
                    width, at = data[at], at + 1
                    if width == 1:
                        moves = struct.unpack_from(f"<{end - begin}b", data, at)
                        grid.places[begin:end] = [place + move for place, move in zip(grid.places[begin:end], moves)]
                    elif width == 2:
                        grid.places[begin:end] = struct.unpack_from(f"<{end - begin}H", data, at)
                    at += (end - begin) * width
                at += -at % 4
                grid.positions = None
            else:
                assert coding == 0
        assert at == len(data), (at, len(data))

    def get_positions(self, index):
        grid = self.grids[index]
        if grid.positions is None:
            grid.positions = [grid.low[i % 3] + grid.step * place for i, place in enumerate(grid.places)]
        return grid.positions
