"""Scenario files changed as tables of values, and written as TOML again."""

import datetime
import json
import tomllib
from copy import deepcopy

from tests.fuzzing import hostile

KEYS = (
    *(
        "name",
        "units",
        "robot",
        "start",
        "motion",
        "faults",
        "law",
        "task",
        "period",
        "duration",
        "gain",
        "loop",
        "kind",
    ),
    *(
        "arm",
        "n",
        "lengths",
        "dh",
        "urdf",
        "mjcf",
        "tip",
        "fixed",
        "joint",
        "at",
        "until",
        "rate",
        "fraction",
        "lower",
        "direction",
    ),
    *(
        "twist",
        "orientation",
        "quaternion",
        "rpy",
        "to",
        "points",
        "times",
        "file",
        "relative",
        "weights",
        "rows",
        "",
        "a.b",
        "é",
    ),
)
WORDS = (
    *(
        "m",
        "in",
        "deg",
        "rad",
        "locked",
        "derated",
        "runaway",
        "confined",
        "one-way",
        "free-swinging",
        "twist",
        "wait",
        "line",
        "circle",
        "waypoints",
        "pose-table",
    ),
    *(
        "least-error",
        "singularity-robust",
        "keep-direction",
        "pseudoinverse",
        "exact",
        "closed-form",
        "none",
        "keep",
        "follow",
    ),
    *(
        "nasa_modular",
        "canadarm2",
        "planar",
        "snake",
        "manipulability",
        "centring",
        "posture",
        "rates",
        "open",
        "closed",
        "rk4",
    ),
    *(
        "robot.urdf",
        "robot.xml",
        "poses.csv",
        "tool",
        "j1",
        "j2",
        "standard",
        "modified",
        "trapezoidal",
        "minimum-jerk",
        "RPRPRP",
    ),
)
NUMBERS = (
    *(0, 1, -1, 2, 7, 500, 501, 10**6, 10**18, 2**63, 10**400, -0.0, 0.5, 1e-7, 1e-6, 1e-3, 1e9, 1.1e9, 1e300, 5e-324),
    *(float("inf"), float("-inf"), float("nan"), 0.1, 20.0, 3.14159),
)
OTHERS = (
    *(True, False, [], {}, [[]], [{}], [1, "x"], [[1.0], [2.0, 3.0]], {"": 0}, {"j1": 0.1}, {"j1": {"j2": 1}}),
    *(datetime.date(2020, 2, 29), datetime.datetime(1, 1, 1, tzinfo=datetime.UTC), datetime.time(23, 59)),
)


def mutated(rng, data):
    """The file with one to six of its values, keys or tables changed, and written in another style."""
    content = tomllib.loads(data.decode())
    for _ in range(min(6, 1 + int(rng.expovariate(0.8)))):
        if holders := list(_holders(content)):
            rng.choice(WAYS)(rng, rng.choice(holders), holders)
    return written(content).encode()


def written(content):
    """Tables as TOML, everything below the first level in one line each."""
    plain, tables = [], []
    for key, value in content.items():
        lines = [f"{_key(k)} = {_value(v)}" for k, v in value.items()] if isinstance(value, dict) else []
        if isinstance(value, dict):
            tables += [f"\n[{_key(key)}]", *lines]
        else:
            plain.append(f"{_key(key)} = {_value(value)}")
    return "\n".join([*plain, *tables, ""])


def _key(key):
    return key if key and key.isascii() and key.replace("_", "").isalnum() else json.dumps(key)


def _value(value):
    match value:
        case bool():
            return str(value).lower()
        case str():
            return json.dumps(value).replace("\x7f", "\\u007f")
        case dict():
            return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(_value, value)) + "]"
        case datetime.date() | datetime.time():
            return value.isoformat()
        case _:
            return repr(value)


def _holders(content):
    """Every table and list that holds something."""
    stack = [content]
    while stack:
        holder = stack.pop()
        if holder:
            yield holder
        stack += [value for value in _members(holder) if isinstance(value, dict | list)]


def _members(holder):
    return holder.values() if isinstance(holder, dict) else holder


def _place(rng, holder):
    return rng.choice(list(holder)) if isinstance(holder, dict) else rng.randrange(len(holder))


def _drop(rng, holder, _):
    del holder[_place(rng, holder)]


def _rename(rng, holder, _):
    if isinstance(holder, dict):
        old = _place(rng, holder)
        holder[rng.choice((_misspelt(rng, old), rng.choice(KEYS)))] = holder.pop(old)


def _misspelt(rng, word):
    where = rng.randrange(len(word) + 1)
    return rng.choice((word.upper(), word[:where] + word[where + 1 :], word[:where] + "x" + word[where:], word[::-1]))


def _add(rng, holder, holders):
    value = rng.choice((_fresh(rng), _elsewhere(rng, holders)))
    if isinstance(holder, dict):
        holder[rng.choice(KEYS)] = value
    else:
        holder.insert(rng.randrange(len(holder) + 1), value)


def _change(rng, holder, _):
    place = _place(rng, holder)
    old = holder[place]
    if isinstance(old, float | int) and not isinstance(old, bool) and rng.random() < 0.6:
        holder[place] = rng.choice(
            (rng.choice(NUMBERS), _scaled(old, rng.uniform(-2.0, 2.0)), -old, old + 1, int(min(1e9, abs(old))))
        )
    elif isinstance(old, str) and rng.random() < 0.7:
        holder[place] = rng.choice((_misspelt(rng, old), rng.choice(WORDS), rng.choice(hostile.TEXTS)))
    else:
        holder[place] = _fresh(rng)


def _scaled(number, factor):
    """The product, also of integers beyond any float."""
    try:
        return number * factor
    except OverflowError:
        return number * int(10.0 * factor)


def _fresh(rng):
    return deepcopy(rng.choice(rng.choice((NUMBERS, WORDS, hostile.TEXTS, OTHERS))))


def _elsewhere(rng, holders):
    return deepcopy(rng.choice(list(_members(rng.choice(holders))) or [0]))


def _copy(rng, holder, holders):
    if holder:
        holder[_place(rng, holder)] = _elsewhere(rng, holders)


def _wrap(rng, holder, _):
    place = _place(rng, holder)
    for _ in range(rng.choice((1, 1, 2, 31, 32, 60))):
        holder[place] = [holder[place]] if rng.random() < 0.5 else {rng.choice(KEYS): holder[place]}


def _repeat(rng, holder, _):
    if isinstance(holder, list):
        value = holder[_place(rng, holder)]
        holder.extend(deepcopy(value) for _ in range(rng.choice((1, 2, 10, 600))))


def _shuffle(rng, holder, _):
    if isinstance(holder, list):
        rng.shuffle(holder)
    else:
        values = list(holder.values())
        rng.shuffle(values)
        holder.update(zip(holder, values, strict=True))


WAYS = (*(_drop, _rename, _add, _copy, _repeat, _shuffle), *(_change,) * 8, *(_wrap, _drop))
