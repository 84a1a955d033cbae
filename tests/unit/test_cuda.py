"""The headers compile as CUDA: by NVRTC from its wheel, which needs neither a card nor a driver, and by nvcc.

What the device code computes is tested where it can run: ``tests/cpp/test_portable_pack.cpp`` holds the same structs to
the same numbers as the compiler's vectors.
"""

import ctypes
import importlib.util
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "tests" / "cpp" / "batch_kernel.cu"
OPTIONS = ["-std=c++17", "--fmad=false", "--device-debug", f"-I{ROOT / 'include'}"]
"""Without the compiler's optimiser, which takes nine tenths of its time."""
KERNELS = {"solve_rows_of_jacobians", "tick_rows"}

pytestmark = pytest.mark.timeout(900)


def nvrtc_library() -> ctypes.CDLL:
    """NVRTC of the wheel nvidia-cuda-nvrtc; skips the test where it is not installed."""
    spec = importlib.util.find_spec("nvidia")
    folders = list(spec.submodule_search_locations or []) if spec else []
    found = [path for folder in folders for path in sorted(Path(folder).glob("*/lib/libnvrtc.so.*"))]
    if not found:
        pytest.skip("NVRTC is not installed: pip install nvidia-cuda-nvrtc")
    return ctypes.CDLL(str(found[-1]))


def nvrtc(source: str, *options: str) -> tuple[int, str, str]:
    """Error code, log and PTX of a run-time compilation."""
    library, program = nvrtc_library(), ctypes.c_void_p()

    def text(size_of: str, get: str) -> str:
        size = ctypes.c_size_t()
        assert getattr(library, size_of)(program, ctypes.byref(size)) == 0
        buffer = ctypes.create_string_buffer(size.value)
        assert getattr(library, get)(program, buffer) == 0
        return buffer.value.decode()

    assert library.nvrtcCreateProgram(ctypes.byref(program), source.encode(), b"source.cu", 0, None, None) == 0
    try:
        code = library.nvrtcCompileProgram(
            program, len(options), (ctypes.c_char_p * len(options))(*map(str.encode, options))
        )
        log = text("nvrtcGetProgramLogSize", "nvrtcGetProgramLog")
        return code, log, text("nvrtcGetPTXSize", "nvrtcGetPTX") if code == 0 else ""
    finally:
        library.nvrtcDestroyProgram(ctypes.byref(program))


def check_ptx(ptx: str, target: str) -> None:
    """Both kernels, for the processor asked for, and nothing that has to come from elsewhere."""
    assert set(re.findall(r"^\.visible \.entry (\w+)", ptx, re.MULTILINE)) == KERNELS
    assert re.findall(r"^\.target (\w+)", ptx, re.MULTILINE) == [target]
    assert ".extern" not in ptx
    assert "fma.rn.f64" in ptx


def test_the_headers_compile_at_run_time() -> None:
    code, log, ptx = nvrtc(SOURCE.read_text(), *OPTIONS, "--gpu-architecture=compute_80")
    assert (code, log) == (0, "")
    check_ptx(ptx, "sm_80")


def test_a_function_for_the_host_alone_is_seen() -> None:
    code, log, _ = nvrtc("inline int f() { return 1; }\n" + SOURCE.read_text(), *OPTIONS)
    assert code != 0
    assert "host functions are not allowed" in log


@pytest.mark.skipif(shutil.which("nvcc") is None, reason="nvcc, of the CUDA toolkit, is not installed")
def test_the_headers_compile_with_nvcc(tmp_path: Path) -> None:
    command = ["nvcc", *OPTIONS, "-arch=sm_90", "-ptx", str(SOURCE), "-o", str(tmp_path / "kernel.ptx")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    check_ptx((tmp_path / "kernel.ptx").read_text(), "sm_90")
