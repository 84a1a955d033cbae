"""A loop of this process that records itself, and what another reader finds in the file."""

import os

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import stillreach as sr

FULL = bool(os.environ.get("STILLREACH_FULL"))
PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
POSE = PANDA.forward(START)
TICKS = 700


def looped(recorder, controller, ticks=TICKS):
    """What a loop of its own did: times, positions, rates, targets (None where there was none), health and status."""
    q, did = START.copy(), []
    for k in range(ticks):
        if k == 300:
            controller.fail("panda_joint4", sr.Locked())
        target = None
        if k % 10 < 7:
            target = POSE.copy()
            target[0, 3] += 0.05 * np.sin(0.01 * k)
            out = controller.track(q, target)
        else:
            out = controller.step(q, [0.0, 0.01, 0.0, 0.0, 0.0, 0.02])
        assert recorder.add(q, target, 100.0 + 0.001 * k)
        did.append((q, out.rates, target, out.twist, controller.health, out.status))
        q = q + 0.001 * out.rates
    return did


def decoded(file):
    """Times [ns] and messages by topic, as another reader sees them."""
    found = {}
    with file.open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()], validate_crcs=True)
        for _, channel, message, content in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, message.sequence, content))
    return found


def in_header(message):
    """[ns]"""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
