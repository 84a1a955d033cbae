"""EmbodiK's velocity solver in the mode that minimises the error.

Its default mode scales the whole twist down and misses what another choice of rates could do. Its singular-value
threshold is the largest tried that misses no feasible twist: 0.02 and more (the default is 0.1) misses some, 0.002 and
less leaves far larger errors where the twist is not feasible. A model without the failed joints takes a third of the
time of velocity limits of zero.
"""

import embodik
import numpy as np

from bench.peers.base import TOOL, Robot

THRESHOLD = 0.005


class Peer:
    packages = ("embodik",)

    def __init__(self, robot: Robot) -> None:
        self.model = embodik.RobotModel(robot.urdf)
        self.solver = embodik.KinematicsSolver(self.model)
        self.solver.enable_position_limits(False)
        self.solver.enable_velocity_limits(True)
        self.solver.set_tolerance(THRESHOLD)
        self.task = self.solver.add_frame_task(TOOL, TOOL)
        self.task.solve_mode = embodik.TaskSolveMode.MIN_ERROR
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        self.model.update_configuration(q[self.working])
        return self.model.get_frame_jacobian(TOOL)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.task.set_target_velocity(twist)
        self.rates[self.working] = self.solver.solve_velocity_dq(q[self.working])
        return self.rates
