#!/bin/sh
# Answers a missing tool with one line that says what to install, before anything is built. Argument: the Python.
set -u
python=$1

missing() {
  echo "stillreach: $1 (on Debian: apt-get install $2)" >&2
  exit 1
}

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null ||
  missing "Python 3.11 or newer is needed, and '$python' is not one; name another with 'make PYTHON=...'" python3
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
  missing "'$python' has no venv and ensurepip modules" python3-venv
"$python" -c 'import os, sysconfig; os.stat(os.path.join(sysconfig.get_paths()["include"], "Python.h"))' 2>/dev/null ||
  missing "'$python' has no header Python.h" python3-dev
compiler=${CXX:-$(command -v c++ || command -v g++ || command -v clang++ || echo c++)}
echo '#include <optional>
int main() { if constexpr (sizeof(int) > 1) return std::optional<int>(0).value(); }' |
  "$compiler" -std=c++17 -x c++ -fsyntax-only - 2>/dev/null ||
  missing "a C++17 compiler is needed, and '$compiler' is not one; name another with 'CXX=... make'" g++
command -v cmake >/dev/null || missing "CMake 3.21 or newer is needed" cmake
