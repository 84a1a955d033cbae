"""Values that a robot or scenario file should not hold, or only just may."""

NUMBERS = (
    "nan", "inf", "-inf", "NaN", "infinity", "1e308", "-1e308", "1e309", "-1e400", "5e-324", "1e-400", "0", "-0",
    "-0.0", "1", "-1", "3.141592653589793", "1e6", "1000000.1", "1e9", "999999999", "-1e9", "1e17", "2147483648",
    "18446744073709551616", "9" * 400, "0." + "0" * 400 + "1", "1" * 5000, ".", "+", "-", "e5", "1e", "1.2.3", "--1",
    "+-1", "0x10", "1_000", "1,5", "1f", "1d0", "٣", "１", "½", "1 2", "", " ", "\t1\n", "one", "true", "None", "1e+3",
    "07", "${pi/2}", "$(arg x)", "%s%n", "\u2212" + "1",
)  # fmt: skip
TEXTS = (
    "", " ", "x", "0", "world", "base", "tool", "j1", "j1 ", "J1", "j99", "-j1", "a" * 999, "a" * 1001, "a" * 100_000,
    "é", "e\u0301", "名前", "\u202e", "\u200b", "\ufeff", "\U0001f916", "../../../etc/hostname", "/dev/zero",
    "/dev/stdin", "/", ".", "..", "~", "C:\\robot.urdf", "file:///etc/hostname", "package://nothing/x.urdf",
    "package:numpy/x",
    "package:", "package:/", "package:../..", "package:numpy/" + "a/" * 500, "%(x)s", "{0.__class__}", "$(reboot)",
    "`reboot`",
    "'; --", '"', "'", "<", "&", "&amp;", "&#0;", "]]>", "-->", "\\", "\\u0000", "\r\n", "\n" * 50, "nan", "inf",
    "null", "[]", "{}",
)  # fmt: skip
TRIPLES = (
    "0 0 0", "0 0", "0 0 0 0", "", "nan 0 0", "inf 0 0", "1e308 1e308 1e308", "1e200 0 0", "1e-200 0 0", "5e-324 0 0",
    "1e-160 1e-160 1e-160", "1e6 -1e6 1e6", "1 2 x", "0,0,1", "0\t0\n1", "  0 0 1  ", "1e5 1e5 1e5", "0 0 1" * 300,
    "3.2 -7.1 1e3", "1.5707963267948966 -1.5707963267948966 3.141592653589793", "0 0 1\u00a00",
)  # fmt: skip
"""Three numbers, or what stands in their place."""


def number(rng):
    """A number as text, hostile or plain."""
    if rng.random() < 0.5:
        return rng.choice(NUMBERS)
    return repr(rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-12, 12))


def text(rng, known=()):
    """A text that is hostile, or one that the file knows elsewhere."""
    return rng.choice(known) if known and rng.random() < 0.5 else rng.choice(TEXTS)


def nudged(rng, value):
    """A number near another, as text; what is no number is replaced."""
    try:
        return repr(float(value) * rng.uniform(0.5, 1.5) + rng.choice((0.0, 0.0, rng.gauss(0.0, 1.0))))
    except (TypeError, ValueError):
        return number(rng)
