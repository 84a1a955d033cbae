"""What `stillreach reach` prints."""

import csv
import json

import numpy as np
import pytest

import stillreach as sr


def test_the_command(stillreach):
    facts = json.loads(stillreach("reach", "panda", "--samples", "100", "--q", "middle", "--json").out)
    own = sr.tolerance.reach(sr.arms.panda(), sr.arms.panda().position_limits.mean(axis=1), samples=100, tolerance=1e-6)
    assert [joint["still_reached"] for joint in facts["joints"]] == own.shares.tolist()
    printed = " ".join(stillreach("reach", "panda", "--samples", "100", "--q", "middle").out.split())
    assert printed.startswith("panda reaches 100 poses. With one joint locked in the middle of its limits:")
    assert printed.endswith(own.verdict)


POSES = """time; x [mm]; y [mm]; z; roll [deg]; pitch [deg]; yaw [deg]; note
0; 400; 0; 0,4; 180; 0; 0; 1

1; 500; 100; 0,3; 180; 0; 90; 2
2; 5000; 0; 0,3; 180; 0; 0; 3
"""


def poses_of(*rows):
    """(N, 4, 4) of x, y, z, roll (half a turn) and yaw."""
    made = np.tile(np.eye(4), (len(rows), 1, 1))
    for T, (x, y, z, yaw) in zip(made, rows, strict=True):
        c, s = np.cos(yaw), np.sin(yaw)
        T[:3, :3], T[:3, 3] = [[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]], (x, y, z)
    return made


def test_poses_of_a_file(stillreach, tmp_path):
    """Units of its headings, decimal commas, columns that are not read, the lines in the answer."""
    file, out = tmp_path / "own.csv", tmp_path / "out.csv"
    file.write_text(POSES, encoding="utf-8")
    arm = sr.arms.panda()
    given = poses_of((0.4, 0.0, 0.4, 0.0), (0.5, 0.1, 0.3, np.pi / 2), (5.0, 0.0, 0.3, 0.0))
    middle = arm.position_limits.mean(axis=1)
    own = sr.tolerance.reach(arm, middle, poses=given)
    assert own.before.tolist() == [True, True, False]
    answer = stillreach("reach", "panda", file, "--q", "middle", "--output", out, "--json")
    facts = json.loads(answer.out)
    assert (facts["poses"], facts["reached"]) == (3, 2)
    for i, joint in enumerate(facts["joints"]):
        still = arm.inverse(given, locked={i: middle[i]}, starts=300).reached
        assert joint["lost_lines"] == [
            line for line, before, after in zip((2, 4, 5), own.before, still, strict=True) if before and not after
        ]
    assert any(joint["lost_lines"] for joint in facts["joints"])
    rows = list(csv.reader(out.read_text(encoding="utf-8").splitlines()))
    assert rows[0] == ["line", "x [m]", "y [m]", "z [m]", "all joints", *arm.joint_names]
    assert [row[0] for row in rows[1:]] == ["2", "4", "5"]
    np.testing.assert_allclose(np.array([row[1:4] for row in rows[1:]], float), given[:, :3, 3])
    assert np.array([row[5:] for row in rows[1:]], int).T.tolist() == [
        r.reached.tolist() for r in own.by_joint.values()
    ]
    printed = " ".join(stillreach("reach", "panda", file, "--q", "middle").out.split())
    assert printed.startswith("panda reaches 2 of 3 poses. With")
    assert "not reached by the whole arm: line 5" in printed


def test_poses_without_attitudes_ask_for_positions(stillreach, tmp_path):
    """A place where the tool cannot point up, which an attitude of the identity would mean."""
    (tmp_path / "points.csv").write_text("x,y,z\n80,0,20\n", encoding="utf-8")
    facts = json.loads(stillreach("reach", "panda", tmp_path / "points.csv", "--length", "cm", "--json").out)
    assert facts["reached"] == 1
    up = np.eye(4)
    up[:3, 3] = 0.8, 0.0, 0.2
    assert not sr.arms.panda().inverse(up).reached


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y,z\n1,2,3\n1,2,b\n", "bad.csv:3: got 'b' in column z, expected a number"),
        ("x,y,z\n1,2,3\n\n1,nan,4\n", "bad.csv:4: got 'nan' in column y"),
        ("x,y,z\n1,2\n", "bad.csv:2: got 1, 2, expected 3 numbers"),
        ("x,y\n1,2\n", "bad.csv: got the columns x, y"),
        ("x,y,z [mile]\n1,2,3\n", "bad.csv:1: got the unit 'mile' in column z [mile]"),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n1,2,3,0,0,0,0\n", "bad.csv:3: got 0 in the columns qw"),
        ("x,y,z,roll,pitch,yaw\n1,2,3,0,0,0\n", "--angle: got none"),
    ],
)
def test_a_file_of_poses_with_a_mistake(stillreach, tmp_path, text, said):
    (tmp_path / "bad.csv").write_text(text, encoding="utf-8")
    answer = stillreach("reach", "panda", tmp_path / "bad.csv")
    assert answer.code == 2
    assert said in " ".join(answer.err.split())
