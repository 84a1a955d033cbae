"""Your own loop, drawn live in a browser by viser. Needs: pip install viser; then open the address that it prints."""

import time

import numpy as np
import viser
from viser.transforms import SO3

import stillreach as sr

SECONDS, ONSET, PERIOD, EVERY = 20.0, 5.0, 0.01, 4  # [s], [s] until the elbow locks, [s] of a tick, ticks a picture
RADIUS, SPEED = 0.05, 2 * np.pi / 4.0  # [m], [rad/s] of the circle
arm = sr.arms.panda()
q = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
controller = sr.Controller(arm, period=PERIOD)
server = viser.ViserServer(verbose=False)
server.initial_camera.position, server.initial_camera.look_at = (1.4, -0.9, 0.9), (0.2, 0.0, 0.35)
print(f"open http://localhost:{server.get_port()}")
parts = [
    server.scene.add_cylinder(f"/arm/{shape.name}", shape.radius, max(shape.length, 1e-6), (150, 150, 160))
    for shape in arm.shapes(q)
]


def draw(q):
    for part, shape in zip(parts, arm.shapes(q), strict=True):
        part.position, part.wxyz = shape.pose[:3, 3], SO3.from_matrix(shape.pose[:3, :3]).wxyz
        if shape.joint is not None and controller.health[shape.joint] != sr.Health.HEALTHY:
            part.color = (210, 60, 40)


start, began, worst = arm.forward(q), time.monotonic(), 0.0
for tick in range(round(SECONDS / PERIOD)):
    if tick == round(ONSET / PERIOD):
        controller.fail("panda_joint4", sr.Locked())
    c, s = np.cos(SPEED * PERIOD * tick), np.sin(SPEED * PERIOD * tick)
    target = start.copy()
    target[:3, 3] += RADIUS * np.array([0.0, c - 1.0, s])
    velocity = RADIUS * SPEED * np.array([0.0, -s, c, 0.0, 0.0, 0.0])
    q = q + PERIOD * controller.track(q, target, velocity).rates
    worst = max(worst, np.linalg.norm(arm.forward(q)[:3, 3] - target[:3, 3]))
    if tick % EVERY == 0:
        draw(q)
    time.sleep(max(0.0, began + (tick + 1) * PERIOD - time.monotonic()))
print(f"panda_joint4 locked after {ONSET:g} s; the tool was at most {1e3 * worst:.1f} mm off its circle")
assert worst < 0.05
server.stop()
