"""What the arm is: joints, limits and builders."""

from stillreach.arm.dh import DHRow
from stillreach.arm.follower import Follower
from stillreach.arm.joint import Joint
from stillreach.arm.model import Arm

__all__ = ["Arm", "DHRow", "Follower", "Joint"]
