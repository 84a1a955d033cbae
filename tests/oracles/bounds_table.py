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
        fault: None, "locked", ("derated", fraction), ("runaway", rate), ("one-way", direction) or
            ("confined", low, high).
        rate, position: lower and upper limit; `acceleration` one number.
        q, last, period: joint position, last commanded rate, period of the tick.
    """
    if fault == "locked":
        return 0.0, 0.0, False
    if fault is not None and fault[0] == "runaway":
        return fault[1], fault[1], False
    kind = fault and fault[0]
    fraction = fault[1] if kind == "derated" else 1.0
    low, high = (side if math.isinf(side) and fraction else fraction * side for side in rate)
    if kind == "one-way":
        low, high = (0.0, high) if fault[1] > 0 else (low, 0.0)
    if kind == "confined":
        low = max(low, -room_rate(q - fault[1], period, acceleration))
        high = min(high, room_rate(fault[2] - q, period, acceleration))

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
