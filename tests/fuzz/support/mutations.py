"""Changes the bytes of a file at random. All choices come from the given generator."""

import gzip
import io
import json
import math
import re
import struct
import zipfile
import zlib

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
TOKEN = re.compile(rb"[^\s,;:\"'<>=\[\]{}()]+")
HUGE = [b"0", b"-1", b"255", b"65536", b"2147483647", b"2147483648", b"4294967295", b"1e308",
        b"-1e308", b"1e-320", b"nan", b"inf", b"18446744073709551616", b"9" * 400]
WORDS = [0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF,
         0x7FFFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFF]
MAX_BYTES = 4 << 20


def flip_bits(random, data):
    data = bytearray(data)
    for _ in range(1 << random.randrange(4)):
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)
    return bytes(data)


def truncate(random, data):
    return data[:random.randrange(len(data))]


def block(random, data):
    """Returns begin and end of a block, mostly short."""
    length = min(len(data), 1 + int(len(data) ** random.random()))
    begin = random.randrange(len(data) - length + 1)
    return begin, begin + length


def duplicate_block(random, data):
    begin, end = block(random, data)
    count = min(1 << random.randrange(10), MAX_BYTES // (end - begin))
    return data[:end] + data[begin:end] * random.randint(1, max(1, count)) + data[end:]


def delete_block(random, data):
    begin, end = block(random, data)
    return data[:begin] + data[end:]


def move_block(random, data):
    begin, end = block(random, data)
    rest = data[:begin] + data[end:]
    at = random.randrange(len(rest) + 1)
    return rest[:at] + data[begin:end] + rest[at:]


def insert_bytes(random, data):
    at = random.randrange(len(data) + 1)
    return data[:at] + random.randbytes(1 << random.randrange(8)) + data[at:]


def set_word(random, data):
    """Replaces a binary number."""
    size = random.choice([1, 2, 4, 8])
    at = random.randrange(len(data))
    word = random.choice(WORDS) & ((1 << 8 * size) - 1)
    order = random.choice(["little", "little", "big"])
    return data[:at] + word.to_bytes(size, order) + data[at + size:]


def spans(random, pattern, data, count):
    """Returns matches of the pattern, spread over the data."""
    found = []
    for _ in range(count):
        match = pattern.search(data, random.randrange(len(data)))
        if match:
            found.append(match.span())
    return found


def huge_number(random, data):
    for begin, end in spans(random, NUMBER, data, 1):
        data = data[:begin] + random.choice(HUGE) + data[end:]
    return data


def swap_tokens(random, data):
    found = sorted(spans(random, TOKEN, data, 2))
    if len(found) < 2 or found[0][1] > found[1][0]:
        return data
    (a, b), (c, d) = found
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def repeat_token(random, data):
    for begin, end in spans(random, TOKEN, data, 1):
        data = data[:end] + b" " + data[begin:end] + data[end:]
    return data


def other_number(random, data):
    """Replaces a number by another one of the file, or by a number near it."""
    found = spans(random, NUMBER, data, 2)
    if len(found) < 2:
        return data
    (begin, end), (from_begin, from_end) = found
    number = data[from_begin:from_end] if random.randrange(2) else b"%d" % random.randint(-200, 200)
    return data[:begin] + number + data[end:]


def change_line(random, data):
    """Deletes a line, or repeats it."""
    lines = data.splitlines(keepends=True)
    at = random.randrange(len(lines))
    lines[at:at + 1] = [lines[at]] * random.choice([0, 2, 2, 100])
    return b"".join(lines)


CHANGES = [flip_bits, truncate, duplicate_block, delete_block, move_block, insert_bytes, set_word,
           huge_number, swap_tokens, repeat_token]
TEXT_CHANGES = [huge_number, other_number, other_number, swap_tokens, repeat_token, change_line]


def mutated(random, data):
    """Returns the bytes after one to four changes, mostly of tokens if they are text."""
    is_text = b"\0" not in data[:1000]
    for _ in range(random.choice([1, 1, 1, 2, 4])):
        if not data:
            break
        changes = TEXT_CHANGES if is_text and random.randrange(3) else CHANGES
        data = random.choice(changes)(random, data)
    return data[:MAX_BYTES]


def mutated_in_place(random, data):
    """Returns as many bytes: for formats with offsets, such as binary FBX."""
    for _ in range(random.choice([1, 1, 2, 4])):
        begin, end = block(random, data)
        what = random.randrange(4)
        if what == 0:
            data = flip_bits(random, data)
        elif what == 1:
            data = set_word(random, data)
        elif what == 2:  # another block
            at = random.randrange(len(data) - (end - begin) + 1)
            data = data[:begin] + data[at:at + end - begin] + data[end:]
        else:
            number = struct.pack("<d", random.choice([0, -1, 1e-300, 1e300, math.nan, math.inf]))
            data = data[:begin] + number + data[begin + len(number):]
    return data


def mutated_npz(random, data):
    """Returns a valid archive of changed arrays: their data, headers, names and number."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    for _ in range(random.choice([1, 1, 2, 4])):
        at = random.randrange(len(members))
        name, content = members[at]
        what = random.randrange(6)
        if what == 0 and len(members) > 1:
            del members[at]
        elif what == 1:  # another array's content
            members[at] = (name, random.choice(members)[1])
        elif what == 2:  # another name
            name = random.choice(["poses.npy", "trans.npy", "fps.npy", "x" + name])
            members[at] = (name, content)
        elif what == 3:  # the header, which says how many numbers there are
            end = content.find(b"\n") + 1
            members[at] = (name, mutated(random, content[:end]) + content[end:])
        else:
            members[at] = (name, mutated(random, content))
    out = io.BytesIO()
    method = random.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
    with zipfile.ZipFile(out, "w", method, compresslevel=1) as archive:
        for name, content in dict(members).items():
            archive.writestr(name, content)
    return out.getvalue()


def mutated_glb(random, data):
    """Returns a GLB file with correct lengths around changed JSON or a changed buffer."""
    chunks = []
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<I4s", data, at)
        chunks.append([kind, data[at + 8:at + 8 + length]])
        at += 8 + length
    if not chunks:
        return mutated(random, data)
    chunk = random.choice(chunks)
    chunk[1] = mutated_json(random, chunk[1]) if chunk[0] == b"JSON" else mutated(random, chunk[1])
    body = b""
    for kind, content in chunks:
        content += b" " * (-len(content) % 4)
        body += struct.pack("<I4s", len(content), kind) + content
    return data[:8] + struct.pack("<I", 12 + len(body)) + body


def mutated_json(random, data):
    """Returns valid JSON with a changed value, or changed bytes."""
    if random.randrange(3) == 0:
        return mutated(random, data)
    try:
        root = json.loads(data)
    except ValueError:
        return mutated(random, data)
    values = []  # containers with their keys

    def collect(value):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, part in pairs:
            values.append((value, key))
            if isinstance(part, (dict, list)):
                collect(part)

    if isinstance(root, (dict, list)):
        collect(root)
    for _ in range(random.choice([1, 1, 2, 4])):
        if not values:
            break
        holder, key = random.choice(values)
        other, other_key = random.choice(values)
        try:
            holder[key] = random.choice(
                [-1, 0, 1, 1000, 2**31, 2**32 - 1, 2**63, 1e308, -0.5, "", "x" * 300, None, [], {},
                 True, json.loads(json.dumps(other[other_key]))])
        except (KeyError, IndexError):
            pass  # the value was in a replaced one
    return json.dumps(root).encode()


def bomb(random, size):
    """Returns a gzip file of a few bytes that becomes `size` bytes."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, 31)
    byte = random.choice([b"\0", b" ", b"1 ", b"\n"])
    return deflate.compress(byte * (size // len(byte))) + deflate.flush()


def mutated_gzip(random, plain, mutate):
    """Returns a gzip file: valid around changed content, with several members, or corrupt."""
    what = random.randrange(8)
    if what == 0:
        return mutated(random, gzip.compress(plain, 1))
    if what == 1:
        cut = random.randrange(len(plain) + 1)
        return gzip.compress(plain[:cut], 1) + gzip.compress(plain[cut:], 1)
    if what == 2:
        return bomb(random, random.choice([1 << 20, 40 << 20]))
    return gzip.compress(mutate(random, plain), 1)
