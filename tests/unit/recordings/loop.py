"""A loop of 1 kHz that records itself: `python loop.py FOLDER`. It says when it begins, and never ends."""

import sys
import time

import numpy as np

import stillreach as sr

PERIOD = 0.001
arm = sr.arms.panda()
controller = sr.Controller(arm, period=PERIOD)
q = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
recorder = sr.Recorder(sys.argv[1], controller)
began, tick = time.monotonic(), 0
while True:
    rates = controller.step(q, [0.02 * np.cos(0.001 * tick), 0, 0, 0, 0, 0]).rates
    recorder.add(q)
    if tick == 0:
        print("begins", flush=True)
    q, tick = q + PERIOD * rates, tick + 1
    time.sleep(max(0.0, began + tick * PERIOD - time.monotonic()))
