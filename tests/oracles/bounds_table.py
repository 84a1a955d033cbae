"""The table "a fault is a bound", one joint at a time, fault before rate, position and acceleration limit."""

import math


def joint_bounds(
    *,
    fault=None,
    rate=(-math.inf, math.inf),
    position=(-math.inf, math.inf),
    q=0.0,
    period,
    last=0.0,
    acceleration=math.inf,
):
    """Lower and upper bound on one joint's rate, and whether the acceleration limit was given up.

    Args:
        fault: None, "locked", ("derated", fraction) or ("runaway", rate).
        rate, position: lower and upper limit; `acceleration` one number.
        q, last, period: joint position, last commanded rate, period of the tick.
    """
    if fault == "locked":
        return 0.0, 0.0, False
    if fault is not None and fault[0] == "runaway":
        return fault[1], fault[1], False
    fraction = 1.0 if fault is None else fault[1]
    low, high = (side if math.isinf(side) and fraction else fraction * side for side in rate)

    up, down = room_rate(position[1] - q, period, acceleration), room_rate(q - position[0], period, acceleration)
    low, high = max(low, -down), min(high, up)

    first, final = last - acceleration * period, last + acceleration * period
    if final < low:
        return low, low, True
    if first > high:
        return high, high, True
    return max(low, first), min(high, final), False


def room_rate(room, period, acceleration):
    """The largest rate towards a limit `room` away: max(0, room / period), on the braking curve sqrt(2 a room)."""
    if room <= 0:
        return 0.0
    return min(room / period, math.sqrt(2 * acceleration * room))
