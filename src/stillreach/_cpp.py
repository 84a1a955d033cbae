"""Where the C++ headers and CMake files of this package are."""

from __future__ import annotations

from pathlib import Path

__all__ = ["get_cmake_dir", "get_include"]

_PACKAGE = Path(__file__).resolve().parent


def get_include() -> str:
    """The folder of the C++ headers, for the option ``-I`` of a compiler."""
    return str(_PACKAGE / "include")


def get_cmake_dir() -> str:
    """The folder of ``stillreach-config.cmake``, for CMake's ``-Dstillreach_DIR``."""
    return str(_PACKAGE / "share" / "cmake" / "stillreach")
