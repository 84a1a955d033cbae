"""Files spoiled as bytes and as text, by something that knows no format."""

import re

from tests.fuzzing import hostile

NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
QUOTED = re.compile(rb"\"[^\"\n]*\"|'[^'\n]*'")
ENCODINGS = ("utf-16", "utf-16-le", "utf-32", "latin-1", "cp037", "utf-7", "utf-8-sig")
SPECIAL = (
    b"\0", b"\xff", b"\xfe\xff", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\xf4\x90\x80\x80", b"\xc0\x80", b"\r", b"\x0b",
    b"\x1b[2J",
    b"<", b">", b"&", b'"', b"'", b"=", b"[", b"]", b"{", b"}", b"#", b".", b",", b"\n", b"\\",
)  # fmt: skip
BIGGEST = 300_000


def spoiled(rng, data, others):
    """The bytes with one to five changes; `others` are files to take pieces from."""
    for _ in range(min(5, 1 + int(rng.expovariate(1.0)))):
        data = rng.choice(WAYS)(rng, data, others)[:BIGGEST]
    return data


def _place(rng, data, longest=40):
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + 1 + int(rng.random() ** 3 * longest))


def _flip(rng, data, _):
    if not data:
        return data
    where = rng.randrange(len(data))
    return data[:where] + bytes([data[where] ^ (1 << rng.randrange(8))]) + data[where + 1 :]


def _insert(rng, data, _):
    where = rng.randrange(len(data) + 1)
    noise = rng.choice(SPECIAL) if rng.random() < 0.7 else rng.randbytes(rng.randint(1, 20))
    return data[:where] + noise * rng.choice((1, 1, 1, 2, 200)) + data[where:]


def _delete(rng, data, _):
    start, end = _place(rng, data)
    return data[:start] + data[end:]


def _repeat(rng, data, _):
    start, end = _place(rng, data, longest=400)
    return data[:end] + data[start:end] * rng.choice((1, 1, 2, 50)) + data[end:]


def _cut(rng, data, _):
    return data[: rng.randrange(len(data) + 1)]


def _splice(rng, data, others):
    start, end = _place(rng, other := rng.choice(others), longest=1000)
    where = rng.randrange(len(data) + 1)
    return data[:where] + other[start:end] + data[where:]


def _swap_lines(rng, data, _):
    lines = data.split(b"\n")
    one, two = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[one], lines[two] = lines[two], lines[one]
    return b"\n".join(lines)


def _drop_line(rng, data, _):
    lines = data.split(b"\n")
    del lines[rng.randrange(len(lines))]
    return b"\n".join(lines)


def _replaced(rng, data, pattern, make):
    """One match of the pattern, replaced by what `make` makes of it."""
    found = list(pattern.finditer(data))
    if not found:
        return data
    match = rng.choice(found)
    return data[: match.start()] + make(match[0]) + data[match.end() :]


def _number(rng, data, _):
    return _replaced(rng, data, NUMBER, lambda _: hostile.number(rng).encode())


def _nudge(rng, data, _):
    return _replaced(rng, data, NUMBER, lambda old: hostile.nudged(rng, old).encode())


def _text(rng, data, _):
    return _replaced(rng, data, QUOTED, lambda old: old[:1] + hostile.text(rng).encode() + old[-1:])


def _swap_texts(rng, data, _):
    words = QUOTED.findall(data)
    return _replaced(rng, data, QUOTED, lambda _: rng.choice(words))


def _encode(rng, data, _):
    try:
        return data.decode().encode(rng.choice(ENCODINGS))
    except ValueError:
        return data


def _newlines(rng, data, _):
    return data.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b" ")))


WAYS = (
    *(_flip, _insert, _delete, _repeat, _cut, _splice, _swap_lines, _drop_line, _encode, _newlines),
    *(_number, _nudge, _text, _swap_texts) * 2,
)
