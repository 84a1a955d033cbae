"""Arms that come with the package: robots by name, ``panda()``, and arms of any number of joints, ``planar(3)``.

``by_name("panda")`` and ``by_name("planar3")`` make them from text, as scenario files and the command line do.
"""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING, Any

from stillreach._messages import did_you_mean
from stillreach.arms.made import nasa_modular as nasa_modular
from stillreach.arms.made import planar as planar
from stillreach.arms.made import snake as snake
from stillreach.arms.robot import Robot
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm

baxter = Robot("baxter")
canadarm2 = Robot("canadarm2")
fetch = Robot("fetch")
fr3 = Robot("fr3")
gen3 = Robot("gen3")
iiwa14 = Robot("iiwa14")
iiwa7 = Robot("iiwa7")
jaco2 = Robot("jaco2")
panda = Robot("panda")
rizon4 = Robot("rizon4")
sawyer = Robot("sawyer")
talos = Robot("talos")
tiago = Robot("tiago")
xarm7 = Robot("xarm7")

BUILDERS = {name: value for name, value in globals().items() if isinstance(value, Robot)} | {
    builder.__name__: builder for builder in (nasa_modular, planar, snake)
}
"""What makes each arm, by name."""
SIZED = ("planar", "snake")
"""Arms whose number of joints is given: ``planar3``, or ``planar`` with ``n``."""

__all__ = ["by_name", *BUILDERS]


def by_name(name: str, **settings: Any) -> Arm:
    """An arm by its name, e.g. ``by_name("panda", tip="panda_hand_tcp")``, ``by_name("planar3")``.

    Args:
        name: an arm of this module; ``planar`` and ``snake`` with their number of joints, or beside ``n``.
        settings: arguments of that arm, e.g. ``n``, ``lengths``, ``tip``; None: not given.

    Raises:
        InputError: if there is no such arm (argument ``arm``), or a setting is missing, unknown or invalid (argument:
            the setting).
    """
    base, size = split(name)
    if base is None:
        choices = [f"{choice}N" if choice in SIZED else choice for choice in BUILDERS]
        raise InputError("arm", repr(name), f"one of {', '.join(choices)}{did_you_mean(name, BUILDERS)}")
    given = {key: value for key, value in settings.items() if value is not None}
    if size is not None:
        if "n" in given:
            raise InputError("n", repr(given["n"]), f"nothing beside {name}, which holds the number of joints")
        given["n"] = size
    known = inspect.signature(BUILDERS[base]).parameters
    for key in given:
        if key not in known:
            beside = f"only {', '.join(known)} beside {base}" if known else f"nothing beside {base}"
            raise InputError(key, f"the setting {key!r}", beside)
    if "n" in known and "n" not in given:
        raise InputError("n", "nothing", f"the number of joints, which {base} needs, e.g. {base}7")
    arm: Arm = BUILDERS[base](**given)
    return arm


def split(name: str) -> tuple[str | None, int | None]:
    """The builder and the number of joints in a name: ``planar3`` is planar and 3; (None, None) for other names."""
    if name in BUILDERS:
        return name, None
    sized = re.fullmatch(rf"({'|'.join(SIZED)})(\d{{1,4}})", name)
    return (sized[1], int(sized[2])) if sized else (None, None)
