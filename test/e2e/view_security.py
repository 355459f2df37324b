"""`tulle view` against strangers and against pages that want too much. usage: view_security.py FOLDER (with sheet.yaml, made by
view_start.bash)"""
import json
import os
import random
import signal
import socket
import struct
import sys
import threading
import time

from view_client import Closed, Page, Server

FOLDER = sys.argv[1]
SCENE = os.path.join(FOLDER, "sheet.yaml")
FAULTS = []


def expect(truth, what):
    if not truth:
        FAULTS.append(what)
        print("fault:", what, flush=True)


def is_well(server):
    """Whether the server serves a page as ever."""
    with Page(server) as page:
        return page.ask("pick", object=0, triangle=0, weights=[1, 0, 0])["type"] == "picked"


def expect_close(page, codes, what):
    """The connection ends with one of these codes; 1006: without a word."""
    try:
        for _ in range(100000):
            page.step_once()
    except Closed as closed:
        expect(closed.code in codes, f"{what}: closed with {closed.code} {closed.reason!r}")
        return
    except (ConnectionResetError, BrokenPipeError):
        expect(1006 in codes, f"{what}: the connection was reset")
        return
    except socket.timeout:
        pass
    expect(False, f"{what}: the connection stays")


def check_headers(server):
    status, headers, body = server.get("")
    expect(status == 200 and b"<" in body, "the page")
    for name in ("", "app.js", "app.css", "icon.svg", "none"):
        status, headers, body = server.get(name)
        expect(status == (404 if name == "none" else 200), f"{name}: {status}")
        expect("default-src 'none'" in headers.get("content-security-policy", ""), f"{name}: Content-Security-Policy")
        expect("unsafe" not in headers.get("content-security-policy", ""), f"{name}: unsafe policy")
        for header, wanted in (("x-content-type-options", "nosniff"), ("referrer-policy", "no-referrer"), ("cache-control", "no-store"),
                               ("cross-origin-resource-policy", "same-origin"), ("cross-origin-opener-policy", "same-origin")):
            expect(headers.get(header) == wanted, f"{name}: {header} is {headers.get(header)}")


def check_tokens(server):
    token = server.token
    wrong = ["0" * 32, token[:-1] + ("0" if token[-1] != "0" else "1"), token.upper() if token.upper() != token else "A" * 32, token[:-1],
             token + "0", "", "%" + token[1:], "*"]
    for other in wrong:
        for name in ("", "app.js", "recording"):
            status, _, _ = server.request(f"/{other}/{name}")
            expect(status in (None, 400, 403, 404), f"token {other!r}: {status}")
        with Page(server, path=f"/{other}/session", begins=False) as page:
            expect(page.status != 101, f"a WebSocket with the token {other!r}")
    expect(server.request(f"/{token}")[0] in (None, 404), "the token without a slash")
    expect(server.request("/")[0] in (None, 404), "no token")


def check_paths(server):
    secret = os.path.join(FOLDER, "secret.txt")
    with open(secret, "w", encoding="ascii") as file:
        file.write("the secret")
    for name in ("../secret.txt", "..%2fsecret.txt", "%2e%2e/secret.txt", "....//secret.txt", "/etc/passwd", "..\\secret.txt", "a/../../etc/passwd",
                 "file:///etc/passwd", "sheet.yaml", "none%00", "examples/ball.yaml", "index.html/..", "recording/../../etc/passwd", "app.js%00.html",
                 "%c0%ae%c0%ae/secret.txt", "x" * 3000):
        for path in (f"/{server.token}/{name}", f"/{name}"):
            status, _, body = server.request(path)
            expect(status in (None, 400, 403, 404, 414), f"{path[:80]}: {status}")
            expect(b"secret\n" not in body and b"root:" not in body and b"title:" not in body, f"{path[:80]} gives a file")
    for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS", "TRACE", "PATCH", "CONNECT", "NONSENSE"):
        status, headers, body = server.request(f"/{server.token}/", method=method)
        expect(status in (None, 400, 403, 404, 405, 501), f"{method}: {status}")
        expect(b"<title" not in body, f"{method} gives the page")
    status, headers, _ = server.request(f"/{server.token}/", method="POST", headers={"Content-Length": "4"}, body=b"data")
    expect(status in (None, 403, 404, 405), f"POST with a body: {status}")
    # What is asked for is not said again.
    _, _, body = server.request(f"/{server.token}/<script>alert(1)</script>")
    expect(b"alert" not in body, "the path is echoed")


def check_hosts(server):
    """DNS rebinding: a name of another site that points here; and pages of other sites."""
    for host in ("evil.example", f"evil.example:{server.port}", f"127.0.0.1.evil.example:{server.port}", "127.0.0.1", f"127.0.0.1:{server.port + 1}",
                 f"localhost.:{server.port}", f"[::]:{server.port}", "", f"127.0.0.1:{server.port}@evil.example", f"0x7f.1:{server.port}"):
        status, _, body = server.request(f"/{server.token}/", host=host or " ")
        expect(status in (None, 400, 403), f"Host {host!r}: {status}")
        with Page(server, host=host or " ", begins=False) as page:
            expect(page.status != 101, f"a WebSocket with Host {host!r}")
    for host in (f"127.0.0.1:{server.port}", f"localhost:{server.port}", f"LOCALHOST:{server.port}"):
        expect(server.request(f"/{server.token}/", host=host)[0] == 200, f"Host {host!r} is refused")
    for origin in ("http://evil.example", f"http://127.0.0.1:{server.port + 1}", f"https://127.0.0.1:{server.port}", "null", "", "file://",
                   f"http://127.0.0.1:{server.port}.evil.example", f"http://evil.example:{server.port}", "http://127.0.0.1"):
        with Page(server, origin=origin, begins=False) as page:
            expect(page.status != 101, f"a WebSocket of the origin {origin!r}")
    for protocol in ("", "tulle-2", "http-only", "tulle-1x", "x, y"):
        with Page(server, protocol=protocol, begins=False) as page:
            expect(page.status != 101, f"a WebSocket of the protocol {protocol!r}")


def check_frames(server):
    """What is no WebSocket frame, or too large."""
    for what, send, codes in (
            ("reserved bits", lambda page: page.send_frame(1, b'{"type":"text"}', reserved=4), (1002, 1006)),
            ("opcode 3", lambda page: page.send_frame(3, b"x"), (1002, 1006)),
            ("a continuation of nothing", lambda page: page.send_frame(0, b"x"), (1002, 1006, 1008)),
            ("a long ping", lambda page: page.send_frame(9, b"x" * 126), (1002, 1006)),
            ("a ping in pieces", lambda page: page.send_frame(9, b"x", is_final=False), (1002, 1006)),
            ("binary", lambda page: page.send_frame(2, b"x"), (1003, 1006)),
            ("no UTF-8", lambda page: page.send_frame(1, b'{"type":"\xff\xfe"}'), (1007, 1008, 1006)),
            ("2^63 bytes", lambda page: page.socket.sendall(b"\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\0\0\0\0abc"), (1002, 1006, 1008, 1009)),
            ("over a megabyte", lambda page: page.send_frame(1, b" " * (1 << 20) + b"{}"), (1008, 1006, 1009)),
            ("over 64 KiB", lambda page: page.send_frame(1, b'{"type":"pick","x":"' + b"a" * (1 << 16) + b'"}'), (1008,))):
        with Page(server) as page:
            page.acknowledges = False
            try:
                send(page)
            except (BrokenPipeError, ConnectionResetError):
                pass
            page.socket.settimeout(20.0)
            expect_close(page, codes, what)
    with Page(server) as page:  # fragments with a ping in between are one message
        text = json.dumps({"type": "text", "id": 77}).encode()
        for i, byte in enumerate(text):
            page.send_frame(1 if i == 0 else 0, bytes([byte]), is_final=i == len(text) - 1)
            if i % 5 == 0:
                page.send_frame(9, b"still there?")
        page.wait_for(lambda: any(text.get("id") == 77 for text in page.texts))
    with Page(server) as page:  # endless fragments are not kept
        page.acknowledges = False
        page.socket.settimeout(30.0)
        try:
            page.send_frame(1, b" " * 1000, is_final=False)
            for _ in range(1100):
                page.send_frame(0, b" " * 1000, is_final=False)
        except (BrokenPipeError, ConnectionResetError):
            pass
        expect_close(page, (1008, 1006), "endless fragments")
    with Page(server) as page:  # no mask: a fault of the page that harms nobody; libwebsockets lets it pass
        page.send_frame(1, b'{"type":"nothing"}', is_masked=False)
        try:
            page.wait_for(lambda: page.texts)
        except Closed:
            pass
    with Page(server) as page:  # a close is answered
        page.send_frame(8, struct.pack(">H", 1000))
        expect_close(page, (1000, 1005, 1006), "a close")


BAD_JSON = ["", " ", "{", "[]", "1", "null", '"type"', '{"type":1}', '{"type":null}', "{}", '{"typ":"run"}', '{"type":"run"} x', '{"type":"run",}', "{'type':'run'}",
            '{"type":"run","type":"pause"}', "[" * 5000, '{"type":"run","x":NaN}', '{"type":"run","x":01}', '{"type":"run","a":"\\ud800"}', "\ufeff{}"]
REFUSED = [
    {"type": "nothing"}, {"type": ""}, {"type": "<img src=x>"}, {"type": "pick"}, {"type": "pick", "object": -1, "triangle": 0, "weights": [1, 0, 0]},
    {"type": "pick", "object": 0.5, "triangle": 0, "weights": [1, 0, 0]}, {"type": "pick", "object": 1e300, "triangle": 0, "weights": [1, 0, 0]},
    {"type": "pick", "object": 99, "triangle": 0, "weights": [1, 0, 0]}, {"type": "pick", "object": 0, "triangle": 4294967295, "weights": [1, 0, 0]},
    {"type": "pick", "object": 0, "triangle": 0, "weights": [1, 0]}, {"type": "pick", "object": 0, "triangle": 0, "weights": [1, 1, 1]},
    {"type": "pick", "object": 0, "triangle": 0, "weights": "abc"}, {"type": "pick", "object": 0, "triangle": 0, "weights": [1, 0, 0, 0]},
    {"type": "frames", "from": 0}, {"type": "got"}, {"type": "got", "sequence": -5}, {"type": "follow", "rate": -1}, {"type": "follow", "rate": 1e9},
    {"type": "overlays", "names": "contacts"}, {"type": "overlays", "names": ["secrets"]}, {"type": "overlays", "names": [1]},
    {"type": "series", "names": ["nothing"]}, {"type": "series", "names": ["contacts"], "buckets": 0}, {"type": "series", "names": ["contacts"], "buckets": 1e9},
    {"type": "step", "count": 0}, {"type": "step", "count": -1}, {"type": "step", "count": 1e18}, {"type": "rewind"}, {"type": "rewind", "step": -1},
    {"type": "grab", "object": 0}, {"type": "grab", "object": 0, "triangle": 10 ** 9, "weights": [1, 0, 0], "point": [0, 0, 0]},
    {"type": "grab", "object": 77, "triangle": 0, "weights": [1, 0, 0], "point": [0, 0, 0]}, {"type": "grab", "object": 1, "triangle": 0, "weights": [1, 0, 0], "point": [0, 0, 0]},
    {"type": "grab", "object": 0, "triangle": 0, "weights": [1, 0, 0], "point": [1e300, 0, 0]}, {"type": "grab", "object": 0, "triangle": 0, "weights": [1, 0, 0], "point": [0, 0, 0], "force": 0},
    {"type": "grab", "object": 0, "triangle": 0, "weights": [1, 0, 0], "point": [0, 0, 0], "force": -3}, {"type": "drag", "grab": 4242, "point": [0, 0, 0]}, {"type": "let_go", "grab": 4242},
    {"type": "cut_pin", "object": 0, "vertex": 50}, {"type": "cut_pin", "object": 0, "vertex": 4294967295}, {"type": "cut_pin", "object": 1, "vertex": 0}, {"type": "cut_pin", "object": 500, "vertex": 0},
    {"type": "move", "object": 0, "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}, {"type": "move", "object": 1, "position": [0, 0, 0], "rotation": [0, 0, 0, 0]},
    {"type": "move", "object": 1, "position": [0, 0, None], "rotation": [1, 0, 0, 0]}, {"type": "move", "object": 9, "position": [0, 0, 0], "rotation": [1, 0, 0, 0]},
    {"type": "set", "what": "time", "value": 1}, {"type": "set", "what": "gravity", "value": 9.81}, {"type": "set", "what": "gravity", "value": [0, 0, 1e7]},
    {"type": "set", "what": "wind", "value": [1, 2]}, {"type": "set", "what": "material", "value": "unobtainium"}, {"type": "set", "what": "material", "object": 1, "value": "silk"},
    {"type": "set", "what": "friction", "value": -1}, {"type": "set", "what": "friction", "object": 2, "value": 0.1}, {"type": "set", "what": "gravity", "value": {"x": 1}},
    {"type": "example", "name": "../sheet.yaml"}, {"type": "example", "name": "a" * 1000}, {"type": "check"}, {"type": "check", "text": 5}, {"type": "save", "text": None}]


def check_messages(server):
    for text in BAD_JSON:
        with Page(server) as page:
            page.send_frame(1, text.encode("utf-8"))
            page.socket.settimeout(20.0)
            expect_close(page, (1008,), f"{text[:40]!r}")
    with Page(server) as page:
        for i, request in enumerate(REFUSED):
            answer = page.ask(**{"type_name": request["type"], **{key: value for key, value in request.items() if key != "type"}})
            expect(answer["type"] == "error" and answer["message"], f"{request}: {str(answer)[:200]}")
            if i % 50 == 49:
                time.sleep(1.0)
        for number in (-1, 0.5, 1e300, "1", None):
            page.send("run", id=number)
        answers = 0
        while answers < 5:
            message = page.step_once()
            answers += isinstance(message, dict) and message["type"] == "error"
    with Page(server) as page:  # over the limit of messages in a second
        page.acknowledges = False
        page.socket.settimeout(20.0)
        try:
            for _ in range(400):
                page.send("got", sequence=0)
        except (BrokenPipeError, ConnectionResetError):
            pass
        expect_close(page, (1008, 1006), "400 messages at once")


def check_random_bytes(server):
    """Whatever comes, the server stays."""
    chance = random.Random(7)
    for round_number in range(60):
        with server.open_socket(5.0) as connection:
            try:
                connection.sendall(bytes(chance.randrange(256) for _ in range(chance.randrange(1, 2000))))
            except OSError:
                pass
    for round_number in range(40):
        with Page(server) as page:
            try:
                page.socket.sendall(bytes(chance.randrange(256) for _ in range(chance.randrange(1, 3000))))
            except OSError:
                pass
    for round_number in range(150):  # messages that are nearly right
        text = bytearray(json.dumps(chance.choice(REFUSED)).encode())
        for _ in range(chance.randrange(1, 4)):
            text[chance.randrange(len(text))] = chance.randrange(256)
        with Page(server, begins=False) as page:
            page.send_frame(1, bytes(text))
            page.socket.settimeout(0.02)
            try:
                page.receive()
            except (Closed, OSError):
                pass


def check_editing(server):
    with open(SCENE, encoding="utf-8") as file:
        before = file.read()
    with Page(server) as page:
        answer = page.ask("save", text="cloth: nonsense\n")
        expect(answer["type"] == "problems" and answer["list"], f"save with errors: {answer}")
        answer = page.ask("save", text=before.replace("resolution: [13, 13]", "resolution: [13, 12000000]"))
        expect(answer["type"] == "problems", f"save of a huge scene: {str(answer)[:200]}")
        answer = page.ask("check", text=before + "\nmesh: {file: /etc/passwd}\n")
        expect(answer["type"] == "problems" and "root:" not in json.dumps(answer), "check shows a file")
        answer = page.ask("check", text="a: &a [*a]\n" * 3)
        expect(answer["type"] == "problems" and answer["list"], "aliases")
    with open(SCENE, encoding="utf-8") as file:
        expect(file.read() == before, "the scene was written with errors")
    left = [name for name in os.listdir(FOLDER) if name not in ("sheet.yaml", "secret.txt", "sheet.run")]
    expect(not left, f"files were left: {left}")


def check_idle_clients(server):
    """100 connections that say nothing, and 40 pages that do nothing: others are served."""
    idle = [server.open_socket() for _ in range(100)]
    for connection in idle[:50]:
        connection.sendall(b"GET / HTTP/1.1\r\nHost:")
    expect(is_well(server), "beside 100 idle connections")
    begin = time.monotonic()
    expect(server.get("")[0] == 200, "the page beside 100 idle connections")
    expect(time.monotonic() - begin < 5.0, "the page took long beside 100 idle connections")
    time.sleep(11.0)  # those whose request is not whole are gone
    ended = 0
    for connection in idle:
        connection.settimeout(10.0)
        try:
            while connection.recv(1000):
                pass
            ended += 1
        except socket.timeout:
            pass
        except ConnectionResetError:
            ended += 1
    expect(ended == 100, f"{100 - ended} of 100 idle connections are still there")
    for connection in idle:
        connection.close()
    pages = [Page(server, begins=False) for _ in range(40)]
    taken = sum(page.status == 101 for page in pages)
    expect(taken == 32, f"{taken} pages at once")
    for page in pages:
        page.socket.close()
    for _ in range(50):
        try:
            if is_well(server):
                break
        except (OSError, Closed, AttributeError, AssertionError):
            time.sleep(0.1)
    expect(is_well(server), "after 40 pages")


def check_half_open(server):
    """300 connections that never finish a request keep no page out, also where the server finds many of them at once."""
    os.kill(server.process.pid, signal.SIGSTOP)
    idle = [server.open_socket() for _ in range(100)]
    for connection in idle:
        connection.sendall(b"GET / HTTP/1.1\r\nHost:")
    os.kill(server.process.pid, signal.SIGCONT)
    idle += [server.open_socket() for _ in range(200)]
    for connection in idle[100::2]:
        connection.sendall(b"GET / HTTP/1.1\r\nHost:")
    begin = time.monotonic()
    expect(server.get("")[0] == 200, "the page beside 300 half-open connections")
    expect(is_well(server), "beside 300 half-open connections")
    expect(time.monotonic() - begin < 5.0, f"a page took {time.monotonic() - begin:.1f} s beside 300 half-open connections")
    for connection in idle:
        connection.close()


def check_greedy_pages(server):
    """30 pages that ask for much and never read: the thread of the network has time for another page."""
    def get_seconds():
        with open(f"/proc/{server.process.pid}/task/{server.process.pid}/stat", encoding="ascii") as file:
            return sum(int(word) for word in file.read().rsplit(")", 1)[1].split()[11:13]) / os.sysconf("SC_CLK_TCK")
    with Page(server) as page:
        page.ask("step", count=500)
        page.wait_for(lambda: page.state and page.state["step"] >= 500)
        greedy = [Page(server, receive_buffer=4096) for _ in range(30)]
        for each in greedy:
            each.socket.settimeout(0.01)
        begin, seconds, answers = time.monotonic(), get_seconds(), 0
        while time.monotonic() - begin < 4.0:
            for each in greedy:
                try:
                    for _ in range(6):
                        each.send("series", id=1, names=["contacts", "smallest_gap", "kinetic_energy"], buckets=2000)
                except OSError:
                    pass
            answers += page.ask("pick", object=0, triangle=0, weights=[1, 0, 0])["type"] == "picked"
        seconds = get_seconds() - seconds
        expect(seconds < 1.3, f"30 greedy pages took {seconds:.2f} of {time.monotonic() - begin:.1f} s of the network's thread")
        expect(answers >= 4, f"{answers} answers in 4 s beside 30 greedy pages")
        print(f"30 greedy pages: {seconds:.2f} s of the network's thread, {answers} answers", flush=True)
        for each in greedy:
            each.socket.close()
    expect(is_well(server), "after greedy pages")


def check_slow_reader(server):
    """A page that never reads: the simulation and another page go on at full rate; memory stays."""
    def get_memory():
        with open(f"/proc/{server.process.pid}/status", encoding="ascii") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1])
    with Page(server, receive_buffer=4096) as slow, Page(server) as page:
        slow.send("overlays", names=["contacts", "velocities", "strain"])
        slow.send("follow", rate=1000)
        for number in range(1, 200):
            slow.send("got", sequence=number)  # it claims to have taken what was never sent
        page.ask("run", speed=0)
        page.wait_for(lambda: page.state and page.state["step"] > 30)
        memory, begin, step, frames = get_memory(), time.monotonic(), page.state["step"], page.frame_count
        end = threading.Event()

        def ask_much():
            while not end.is_set():
                try:
                    slow.send("schema", id=1)
                    time.sleep(0.02)
                except OSError:
                    return
        asker = threading.Thread(target=ask_much)
        asker.start()
        while time.monotonic() - begin < 4.0:
            page.step_once()
        end.set()
        asker.join(2.0)
        seconds = time.monotonic() - begin
        expect(page.state["step"] > step + 20, f"{page.state['step'] - step} steps in {seconds:.1f} s beside a slow page")
        expect(page.frame_count > frames + 20, f"{page.frame_count - frames} frames in {seconds:.1f} s beside a slow page")
        expect(get_memory() < memory + 200000, f"memory grew by {get_memory() - memory} kB beside a slow page")
        page.ask("pause")
        slow.socket.close()
    expect(is_well(server), "after a slow page")


def main():
    with Server(SCENE, "--threads", "1", folder=FOLDER) as server:
        for check in (check_headers, check_tokens, check_paths, check_hosts, check_frames, check_messages, check_random_bytes, check_editing,
                      check_idle_clients, check_half_open, check_greedy_pages, check_slow_reader):
            begin = time.monotonic()
            check(server)
            expect(is_well(server), f"the server after {check.__name__}")
            print(f"{check.__name__}: {time.monotonic() - begin:.1f} s", flush=True)
    expect(server.code == 0, f"exit code {server.code}: {server.errors}")
    tokens = set()
    for _ in range(3):
        with Server(SCENE, folder=FOLDER) as server:
            tokens.add(server.token)
    expect(len(tokens) == 3, "tokens repeat")
    print(f"view_security: {len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
