"""Drake's differential inverse kinematics, which keeps the twist's direction.

The function for one tick is timed; `DifferentialInverseKinematicsSystem`, a block for Drake's diagrams, is not. At
OSQP's default tolerance rates pass the limit by parts of a thousandth; here it is tightened.
"""

import numpy as np
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import OsqpSolver

from bench.peers.base import TOOL, Robot

SWAP = [3, 4, 5, 0, 1, 2]
"""Drake writes angular velocities first."""
OSQP = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20_000}


class Peer:
    packages = ("drake",)

    def __init__(self, robot: Robot) -> None:
        self.plant = MultibodyPlant(0.0)
        Parser(self.plant).AddModels(robot.urdf)
        self.world = self.plant.world_frame()
        self.plant.WeldFrames(self.world, self.plant.GetFrameByName("base_link"))
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.tool, self.origin = self.plant.GetFrameByName(TOOL), np.zeros(3)
        n = self.plant.num_velocities()
        self.parameters = DifferentialInverseKinematicsParameters(n, n)
        self.parameters.set_joint_velocity_limits((np.full(n, -robot.limit), np.full(n, robot.limit)))
        for name, value in OSQP.items():
            self.parameters.get_mutable_solver_options().SetOption(OsqpSolver.id(), name, value)
        self.working, self.still, self.rates = robot.working, np.zeros(n), np.zeros(robot.n)

    def drake_jacobian(self, q: np.ndarray) -> np.ndarray:
        self.plant.SetPositions(self.context, q)
        return self.plant.CalcJacobianSpatialVelocity(
            self.context, JacobianWrtVariable.kV, self.tool, self.origin, self.world, self.world
        )

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.drake_jacobian(q[self.working])[SWAP]

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        q = q[self.working]
        J = self.drake_jacobian(q)
        found = DoDifferentialInverseKinematics(q, self.still, twist[SWAP], J, self.parameters)
        self.rates[self.working] = self.still if found.joint_velocities is None else found.joint_velocities
        return self.rates
