"""What the arm is: joints, limits, builders and the catalogue ``stillreach.arms``."""

from stillreach.arm.dh import DHRow
from stillreach.arm.follower import Follower
from stillreach.arm.joint import Joint
from stillreach.arm.model import Arm

__all__ = ["Arm", "DHRow", "Follower", "Joint"]
