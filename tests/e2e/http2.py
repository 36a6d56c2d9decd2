"""HTTP/2 frames and headers, for clients that no library implements."""

import struct

DATA, HEADERS, PRIORITY, RESET, SETTINGS, PING, WINDOW_UPDATE, CONTINUATION = 0, 1, 2, 3, 4, 6, 8, 9
END_STREAM, END_HEADERS, ACK = 1, 4, 1  # flags
INITIAL_WINDOW_SIZE = 4  # a setting
START = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"  # connection preface


def frame(kind, flags, stream, payload):
    head = struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream)
    return head + payload


def text(value):
    """Returns an HPACK string literal without Huffman code."""
    length, prefix = len(value), bytes([min(len(value), 127)])
    if length >= 127:  # the rest in groups of 7 bits
        length -= 127
        while length > 127:
            prefix, length = prefix + bytes([length % 128 + 128]), length // 128
        prefix += bytes([length])
    return prefix + value.encode()


def header(name, value):
    """Returns a header field that is not added to the dynamic table."""
    return b"\0" + text(name) + text(value)


def indexed_header(name, value):
    """Returns a header field that is added to the dynamic table."""
    return b"\x40" + text(name) + text(value)


NEWEST_ENTRY = b"\xbe"  # the newest field of the dynamic table: index 62


def call_headers(path, *pairs):
    """Returns the header block of a call, with extra fields."""
    return b"".join(header(*pair) for pair in [
        (":method", "POST"), (":scheme", "http"), (":authority", "localhost"), (":path", path),
        ("content-type", "application/grpc"), ("te", "trailers"), *pairs])


def request_headers(method, *pairs):
    """Returns the header block of a motiondb call, such as "DatabaseService/ListDatabases"."""
    return call_headers("/motiondb.v1." + method, *pairs)


def header_frames(flags, stream, block, max_bytes=16384):
    """Returns a header block as one HEADERS frame and the CONTINUATION frames that it needs."""
    parts = [block[i:i + max_bytes] for i in range(0, len(block), max_bytes)]
    last = len(parts) - 1
    return b"".join(
        frame(CONTINUATION if i else HEADERS,
              (END_HEADERS if i == last else 0) | (0 if i else flags), stream, part)
        for i, part in enumerate(parts))


def message(payload):
    """Returns a message with gRPC's length prefix."""
    return b"\0" + struct.pack(">I", len(payload)) + payload
