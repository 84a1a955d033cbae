"""URDF files as text: one joint, a whole file, and random trees."""

import numpy as np


def joint(name, parent, child, kind="revolute", *, xyz="0 0 0", rpy="0 0 0", axis="0 0 1", limit=None, extra=""):
    """One joint element; a limit where its type needs one."""
    if limit is None:
        limit = 'lower="-1" upper="2" velocity="3" effort="4"' if kind in ("revolute", "prismatic") else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{f"<limit {limit}/>" if limit else ""}{extra}</joint>'
    )


def robot(*joints, links=(), name="test robot"):
    """A file of these joints, with all links that they name and some more."""
    words = " ".join(joints).split('link="')[1:]
    named = dict.fromkeys([*(word.split('"')[0] for word in words), *links])
    body = "\n".join([*(f'<link name="{link}"/>' for link in named), *joints])
    return f'<?xml version="1.0"?>\n<robot name="{name}">\n{body}\n</robot>\n'


def random_tree(seed, n=12):
    """Text of a tree of n joints of all four types at random places, in random order."""
    text, _ = random_coupled_tree(seed, n, share=0.0)
    return text


def random_coupled_tree(seed, n=12, share=0.4):
    """The same where a share of the moving joints follows others: {follower: (leader, multiplier, offset)}."""
    rng, follow = np.random.default_rng(seed), np.random.default_rng([9, seed])
    numbers = lambda values: " ".join(repr(float(v)) for v in values)  # noqa: E731
    joints, leaders, follows = [], [], {}
    for i in range(1, n + 1):
        kind = rng.choice(["revolute", "continuous", "prismatic", "fixed"], p=[0.4, 0.2, 0.2, 0.2])
        parent = rng.integers(max(0, i - 3), i)
        settings = {key: numbers(rng.uniform(-1.5, 1.5, 3)) for key in ("xyz", "rpy", "axis")}
        if kind != "fixed" and leaders and follow.random() < share:
            leader, (multiplier, offset) = str(follow.choice(leaders)), follow.uniform(-2, 2, 2).tolist()
            follows[f"joint{i}"] = leader, multiplier, offset
            settings["extra"] = f'<mimic joint="{leader}" multiplier="{multiplier!r}" offset="{offset!r}"/>'
            settings["limit"] = 'lower="-99" upper="99" velocity="9" effort="9"'
        elif kind != "fixed":
            leaders.append(f"joint{i}")
        joints.append(joint(f"joint{i}", f"link{parent}", f"link{i}", kind, **settings))
    return robot(*(joints[k] for k in rng.permutation(n))), follows
