"""Tables of poses from CSV files."""

import tracemalloc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import stillreach as sr


def test_a_pose_table_is_read_from_csv_in_its_units(tmp_path):
    turns = Rotation.random(3, rng=4)
    xyzw = turns.as_quat()
    rows = [
        f"{t},{10 * t},{-t},{5},{-2 * w},{-2 * x},{-2 * y},{-2 * z}"
        for t, (x, y, z, w) in zip((1.0, 2.0, 3.0), xyzw, strict=True)
    ]
    file = tmp_path / "poses.csv"
    file.write_text("\n".join(["time, x, y, z, qw, qx, qy, qz", *rows, ""]))
    table = sr.PoseTable.from_csv(file, length=0.01)
    np.testing.assert_allclose(table.points, [[0.1, -0.01, 0.05], [0.2, -0.02, 0.05], [0.3, -0.03, 0.05]], rtol=1e-15)
    np.testing.assert_allclose(table.orientations, turns.as_matrix(), atol=1e-14)
    rpy = "\n".join(["roll,pitch,yaw,time,x,y,z", "0,0,90,0,0,0,0", "10,20,30,1,1,0,0"])
    file.write_text(rpy)
    table = sr.PoseTable.from_csv(file, angle=np.deg2rad(1))
    wanted = Rotation.from_euler("xyz", [[0, 0, 90], [10, 20, 30]], degrees=True).as_matrix()  # about fixed axes
    np.testing.assert_allclose(table.orientations, wanted, atol=1e-14)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("time,x,y\n0,1,2\n", "the columns time, x, y"),
        ("time,x,y,z,qw\n0,1,2,3,1\n", "the columns"),
        ("time,x,y,z,x\n0,1,2,3,1\n", "the columns"),
        ("time,x,y,z\n", "1 lines"),
        ("", "0 lines"),
        ("time,x,y,z\n0,1,2,3\n1,2,3\n", r"poses\.csv:3: got 1, 2, 3, expected 4 numbers"),
        ("time,x,y,z\n0,1,2,three\n", r"poses\.csv:2"),
        ("time,x,y,z\n0,1,2,nan\n", r"poses\.csv:2.*finite"),
        ("time,x,y,z\n0,1,2,1e300\n", r"poses\.csv:2"),
        ("time,x,y,z\n1,1,2,3\n1,1,2,3\n", "times: got 1 at index 1"),
        ("time,x,y,z\n-1,1,2,3\n1,1,2,3\n", "times from 0 on"),
        ("time,x,y,z,qw,qx,qy,qz\n1,1,2,3,0,0,0,0\n", "quaternion of length 0"),
        ("time;x;y;z\n1;1.234,5;0;0\n", r"poses\.csv:2: got .* decimal commas"),
        ("time;x;y;z\n1;1,234,567;0;0\n", r"poses\.csv:2"),
        ("time;x;y;z\n1;1,234;0.5;0\n", r"poses\.csv:2: got .* decimal commas"),
        ("time,x,y,z\n1,5,2,0,0\n", r"poses\.csv:2: got 1, 5, 2, 0, 0, expected 4 numbers"),
        ("time,x,y,z\n1\n", r"poses\.csv:2: got 1, expected 4 numbers"),
        ("time;x;y\n", "the columns time, x, y,"),
        ("time:x:y:z\n1:2:3:4\n", "the columns time:x:y:z"),
    ],
)
def test_a_table_that_is_none_says_why_and_where(tmp_path, text, match):
    file = tmp_path / "poses.csv"
    file.write_text(text)
    with pytest.raises(sr.InputError, match=match):
        sr.PoseTable.from_csv(file)


COMMAS = "time,x,y,z\n0.5,1,-2e-3,3.25\n1.5,2,.5,4\n"
TABLES = {
    "commas": COMMAS,
    "commas and spaces": COMMAS.replace(",", ", "),
    "semicolons": COMMAS.replace(",", ";"),
    "semicolons and decimal commas": COMMAS.replace(",", ";").replace(".", ","),
    "tabs": COMMAS.replace(",", "\t"),
    "tabs and decimal commas": COMMAS.replace(",", "\t").replace(".", ","),
    "bars": COMMAS.replace(",", " | "),
    "spaces": COMMAS.replace(",", " "),
    "spaces in columns": " " + COMMAS.replace(",", "   ").replace("\n", " \n ").rstrip(" "),
    "spaces and decimal commas": COMMAS.replace(",", "  ").replace(".", ","),
    "quotes": COMMAS.replace("time,x,y,z", '"time","x","y","z"'),
    "quotes and semicolons": '"time";"x";"y";"z"\n"0,5";"1";"-2e-3";"3,25"\n"1,5";"2";",5";"4"\n',
    "empty lines": "\n\n" + COMMAS.replace("\n", "\n\n"),
    "lines of separators": COMMAS.replace(",", ";") + ";;;\n;;;\n",
    "ends of lines of Windows": COMMAS.replace("\n", "\r\n"),
    "ends of lines of old machines": COMMAS.replace(",", ";").replace(".", ",").replace("\n", "\r"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("separated", TABLES)
def test_a_table_says_itself_what_separates_its_columns(separated, encoding, tmp_path):
    file = tmp_path / "poses.csv"
    file.write_bytes(TABLES[separated].encode(encoding))
    table = sr.PoseTable.from_csv(file)
    assert table.times.tolist() == [0.5, 1.5]
    assert table.points.tolist() == [[1.0, -0.002, 3.25], [2.0, 0.5, 4.0]]


@pytest.mark.parametrize("columns", [1500, 100_000])
@pytest.mark.parametrize("rows", ["1\n" * 200_000, "," * 2_000_000], ids=["many rows", "a long row"])
def test_many_columns_ask_for_no_memory(tmp_path, columns, rows):
    file = tmp_path / "poses.csv"
    file.write_text(",".join(f"c{k}" for k in range(columns)) + f"\n{rows}")
    tracemalloc.start()
    try:
        with pytest.raises(sr.InputError, match=r"c0, c1|688889"):
            sr.PoseTable.from_csv(file)
        assert tracemalloc.get_traced_memory()[1] < 100e6  # of which 64 MiB wait for the file
    finally:
        tracemalloc.stop()


def test_a_row_of_many_entries_asks_for_no_memory(tmp_path):
    file = tmp_path / "poses.csv"
    file.write_text("time,x,y,z\n0,0,0,0\n" + "," * 4_000_000)
    with pytest.raises(sr.InputError, match=r"poses\.csv:3: .*4000000"):
        sr.PoseTable.from_csv(file)


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"\xff\xfea", b"\xff", b"time,x,y,z\n0,\x00,1,2\n"])
def test_a_table_that_cannot_be_read_says_so(tmp_path, content):
    file = tmp_path / "poses.csv"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(sr.InputError, match=r"poses\.csv"):
        sr.PoseTable.from_csv(file)
    with pytest.raises(sr.InputError, match="folder"):
        sr.PoseTable.from_csv(tmp_path)
