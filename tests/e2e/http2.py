"""What HTTP/2 is made of, for clients that no library would play."""

import struct

DATA, HEADERS, RESET, SETTINGS, PING, WINDOW_UPDATE = 0, 1, 3, 4, 6, 8
END_STREAM, END_HEADERS, ACK = 1, 4, 1  # flags
INITIAL_WINDOW_SIZE = 4  # a setting
START = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"  # of a connection


def frame(kind, flags, stream, payload):
    head = struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream)
    return head + payload


def header(name, value):
    """A header field that HPACK leaves as it is."""
    return b"\0" + bytes([len(name)]) + name.encode() + bytes([len(value)]) + value.encode()


def request_headers(method):
    """The block of headers of a call: "DatabaseService/ListDatabases"."""
    return b"".join(header(*pair) for pair in [
        (":method", "POST"), (":scheme", "http"), (":authority", "localhost"),
        (":path", "/motiondb.v1." + method), ("content-type", "application/grpc"),
        ("te", "trailers")])


def message(payload):
    """A message of a call, as gRPC frames it."""
    return b"\0" + struct.pack(">I", len(payload)) + payload
