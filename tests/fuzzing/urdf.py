"""URDF files changed as trees of elements, and as XML."""

import xml.etree.ElementTree as ET
from copy import deepcopy

from tests.fuzzing import hostile

TAGS = (
    *(
        "robot",
        "link",
        "joint",
        "parent",
        "child",
        "origin",
        "axis",
        "limit",
        "mimic",
        "inertial",
        "mujoco",
        "xacro:macro",
        "xacro:call_of_mine",
    ),
    *("ns:joint", "Joint", "transmission", "x" * 200),
)
TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "", "Revolute", "ball", " revolute ")
NUMERIC = ("lower", "upper", "velocity", "acceleration", "deceleration", "multiplier", "offset", "value")
TRIPLE = ("xyz", "rpy", "quat_xyzw")
ATTRIBUTES = ("name", "type", "link", "joint", "version", *NUMERIC, *TRIPLE, "xmlns:xacro", "xmlns", "xml:base")
BOMB = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "lol"}">' for k in range(9))
PREAMBLES = (
    f"<!DOCTYPE robot [{BOMB}]>",
    '<!DOCTYPE robot [<!ENTITY e8 SYSTEM "file:///etc/hostname">]>',
    '<!DOCTYPE robot SYSTEM "http://127.0.0.1:9/robot.dtd">',
    '<!DOCTYPE robot [<!ENTITY % p SYSTEM "file:///dev/zero"> %p;]>',
    '<!DOCTYPE robot [<!ATTLIST link name CDATA "default">]>',
    "<!DOCTYPE robot>",
    '<?xml version="1.0" encoding="utf-16"?>',
    '<?xml version="1.0" encoding="nothing"?>',
    '<?xml version="1.0" encoding="utf-7"?>',
    '<?xml version="1.0" encoding="idna"?>',
    '<?xml version="1.0" encoding="rot13"?>',
    '<?xml version="1.0" encoding="iso-8859-1"?>',
    '<?xml version="1.1"?>',
    '<?xml-stylesheet href="x"?>',
    "<!-- -->" * 100,
    "<robot/>",
    " ",
)


def mutated(rng, data):
    """The file with one to six changes to its elements and, now and then, something in front of it."""
    root = ET.fromstring(data)
    for _ in range(min(6, 1 + int(rng.expovariate(0.8)))):
        rng.choice(WAYS)(rng, root)
    text = ET.tostring(root, encoding="unicode", short_empty_elements=rng.random() < 0.9)
    if rng.random() < 0.1:
        text = rng.choice(PREAMBLES) + text.replace('name="', 'name="&e8;', rng.choice((0, 1)))
    return text.encode("utf-8", "surrogatepass")


def _any(rng, root, *tags):
    """An element, of one of the tags if there is one."""
    return rng.choice([e for e in root.iter() if e.tag in tags] or list(root.iter()))


def _parent_of(rng, root):
    """An element that has children."""
    return rng.choice([element for element in root.iter() if len(element)] or [root])


def _names(root):
    return [element.get("name", "") for element in root.iter() if element.tag in ("link", "joint")] or [""]


def _drop(rng, root):
    if len(parent := _parent_of(rng, root)):
        parent.remove(rng.choice(list(parent)))


def _double(rng, root):
    if len(parent := _parent_of(rng, root)):
        where = rng.randrange(len(parent))
        parent.insert(rng.randrange(len(parent) + 1), deepcopy(parent[where]))


def _move(rng, root):
    if len(parent := _parent_of(rng, root)):
        child = rng.choice(list(parent))
        _any(rng, root).append(deepcopy(child))
        parent.remove(child)


def _shuffle(rng, root):
    parent = _parent_of(rng, root)
    children = list(parent)
    rng.shuffle(children)
    parent[:] = children


def _rename(rng, root):
    _any(rng, root).tag = rng.choice(TAGS)


def _attribute(rng, root):
    """Another value, hostile or nearly right, for an attribute that is there."""
    element = rng.choice([element for element in root.iter() if element.attrib] or [root])
    name = rng.choice(sorted(element.attrib) or ["name"])
    old = element.get(name, "")
    if name in TRIPLE:
        new = rng.choice(hostile.TRIPLES) if rng.random() < 0.5 else _nudged_triple(rng, old)
    elif name in NUMERIC:
        new = rng.choice((hostile.number(rng), hostile.nudged(rng, old)))
    else:
        new = hostile.text(rng, _names(root))
    element.set(name, _printable(new))


def _nudged_triple(rng, old):
    words = old.split() or ["0"]
    words[rng.randrange(len(words))] = rng.choice((hostile.number, lambda rng: hostile.nudged(rng, "0.5")))(rng)
    return " ".join(words)


def _lose(rng, root):
    element = _any(rng, root)
    if element.attrib:
        del element.attrib[rng.choice(sorted(element.attrib))]


def _gain(rng, root):
    _any(rng, root).set(rng.choice(ATTRIBUTES), _printable(rng.choice((hostile.text, hostile.number))(rng)))


def _rewire(rng, root):
    """A joint between other links: cycles, second parents, loose ends, links that are their own parents."""
    end, links = _any(rng, root, "parent", "child"), [link.get("name", "") for link in root.iter("link")]
    end.set("link", rng.choice(links or [""]))


def _swap_ends(rng, root):
    for end in _any(rng, root, "joint"):
        end.tag = {"parent": "child", "child": "parent"}.get(end.tag, end.tag)


def _type(rng, root):
    _any(rng, root, "joint").set("type", rng.choice(TYPES))


def _version(rng, root):
    root.set("version", rng.choice(("1.0", "1.1", "1.2", "1.2", "1.3", "2", "")))


def _mimic(rng, root):
    names = [joint.get("name", "") for joint in root.iter("joint")]
    settings = {"joint": rng.choice([*names, "nobody"]), "multiplier": hostile.number(rng), "offset": "0.1"}
    ET.SubElement(_any(rng, root, "joint"), "mimic", {name: _printable(value) for name, value in settings.items()})


def _limits(rng, root):
    lower, upper = sorted((rng.gauss(0.0, 2.0), rng.gauss(0.0, 2.0)), reverse=rng.random() < 0.2)
    _any(rng, root, "limit").attrib.update(lower=repr(lower), upper=repr(upper))


def _nest(rng, root):
    element = _any(rng, root)
    for _ in range(rng.choice((2, 50, 97, 101, 150))):
        element = ET.SubElement(element, rng.choice(("link", "joint", "a")))


def _grow(rng, root):
    """A long tail of links and fixed or moving joints."""
    last = rng.choice([link.get("name", "") for link in root.iter("link")] or [""])
    kind = rng.choice(("fixed", "continuous"))
    for k in range(rng.choice((1, 3, 10, 30, 100, 1100))):
        name = f"{last}>{k}" if len(last) < 50 else f">{k}"
        ET.SubElement(root, "link", name=name)
        joint = ET.SubElement(root, "joint", name=f"joint {name}", type=kind)
        ET.SubElement(joint, "parent", link=f"{last}>{k - 1}" if k else last)
        ET.SubElement(joint, "child", link=name)
        ET.SubElement(joint, "origin", xyz="0 0 0.01", rpy="0 0.3 0.1")


def _printable(text):
    """What XML 1.0 can hold of a text: the rest is for those who spoil bytes."""
    return "".join(c for c in text if c in "\t\n\r" or (c >= " " and not "\ud800" <= c <= "\udfff" and c < "\ufffe"))


WAYS = (
    *(_drop, _double, _move, _shuffle, _rename, _lose, _gain, _rewire, _swap_ends, _type, _mimic, _limits),
    *(_attribute, _rewire) * 5,
    *(_attribute, _nest, _grow, _version),
)
