# `make demo` and `make test` set everything up; `make help` lists the rest.
PYTHON ?= $(shell command -v python3.11 || echo python3)
JOBS ?= $(shell nproc 2>/dev/null || echo 2)

BIN := .venv/bin
STAMPS := .venv/stamps
CMAKE := PATH="$(CURDIR)/$(BIN):$$PATH" cmake
# The wheel is built where the C++ tests are: the kernels are compiled once for both.
SHARED := -C build-dir=build/cpp -C build.targets=_core_stub -C cmake.define.STILLREACH_PYTHON=ON
SOURCES := $(shell find src include bindings dispatch cmake -name __pycache__ -prune -o -print) CMakeLists.txt pyproject.toml LICENSE README.md
PAGE_SOURCES := $(shell find page -name node_modules -prune -o -type f -print)
LINTED := $(wildcard src tests examples bench scripts docs conanfile.py)
CPP_LINTED := $(shell find include bindings dispatch tests bench page/core ros2 -name "*.?pp" -o -name "*.cu")

export CMAKE_BUILD_PARALLEL_LEVEL := $(JOBS)
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test bench track bench-peers why instructions lint cpp-test pytest wheel wheels page film wasm docs dev format requirements clean help check-tools
.DELETE_ON_ERROR:
.NOTPARALLEL:

demo: $(STAMPS)/all $(STAMPS)/wheel  ## a live and a rehearsed Panda into out/demo, reproduce the paper into out/paper
	-$(BIN)/stillreach view panda --no-browser --out out/demo
	$(BIN)/python examples/08_rehearse.py out/demo
	$(BIN)/stillreach paper --out out/paper
	@echo "Open out/demo/view.html, out/demo/rehearsal.html and out/paper/figure-stillreach.png."
	@echo "The command is $(BIN)/stillreach; after '. $(BIN)/activate' the shell finds it as stillreach."

test: lint cpp-test pytest  ## lint, C++ tests (also under sanitizers), Python tests on the installed wheel

pytest: dev  ## Python tests on the installed wheel
	$(BIN)/python -m pytest -n $(JOBS) --dist loadgroup

cpp-test: $(STAMPS)/wheel  ## C++ tests, plain and under the address and undefined-behaviour sanitizers
	$(CMAKE) -S . -B build/cpp -G Ninja -DSTILLREACH_TESTS=ON >/dev/null
	$(CMAKE) --build build/cpp
	cd build/cpp && ctest --no-tests=error --output-on-failure -j $(JOBS)
	$(CMAKE) -S . -B build/cpp-sanitize -G Ninja -DSTILLREACH_TESTS=ON -DSTILLREACH_SANITIZE=ON >/dev/null
	$(CMAKE) --build build/cpp-sanitize
	cd build/cpp-sanitize && ctest --no-tests=error --output-on-failure -j $(JOBS)

lint: dev  ## ruff, mypy and clang-format
	$(BIN)/clang-format --dry-run -Werror $(CPP_LINTED)
	$(BIN)/ruff check $(LINTED)
	$(BIN)/ruff format --check $(LINTED)
	$(BIN)/mypy

format: $(STAMPS)/test  ## let ruff put the Python files in order, and clang-format those of C++
	$(BIN)/clang-format -i $(CPP_LINTED)
	$(BIN)/ruff check --fix $(LINTED)
	$(BIN)/ruff format $(LINTED)

bench: dev  ## time a tick, beside one peer, and a batch from Python
	$(BIN)/python -m bench.tick
	$(BIN)/python -m bench.batch

track: dev  ## measure how well the default law tracks, beside the bare optimum and a box QP; ARGS="--help" for more
	$(BIN)/python -m bench.tracking $(ARGS)

bench-peers: $(STAMPS)/wheel .venv-peers/installed  ## time stillreach beside its peers, into README.md; ARGS="--help" for more
	.venv-peers/bin/pip install -q --no-deps --force-reinstall build/wheel/stillreach-*.whl
	.venv-peers/bin/python -m bench.compare $(or $(ARGS),--write)

instructions: $(STAMPS)/wheel  ## count the instructions of every kind of tick and store them (needs valgrind)
	$(CMAKE) -S . -B build/cpp -G Ninja -DSTILLREACH_TESTS=ON >/dev/null
	$(CMAKE) --build build/cpp --target ticks
	$(BIN)/python -m bench.instructions --store build/cpp/tests/cpp/ticks

why: dev  ## measure the tables of docs/why-it-is-fast.md and write them there (needs valgrind); ARGS="--help" for more
	$(BIN)/python -m bench.why $(ARGS)

wheel: $(STAMPS)/all $(STAMPS)/wheel  ## build the wheel and install it into .venv

wheels: $(STAMPS)/wheel  ## build the wheels to give away into dist/ and try each with every Python; ARGS="--help" for more
	$(BIN)/python scripts/wheels.py $(ARGS)

page: $(STAMPS)/page  ## build the program of the live page (with Node.js)

film: dev  ## film the live page into docs/images/live.webp (needs Chromium)
	$(BIN)/python scripts/moving_picture.py

wasm: check-tools  ## compile the controller of the live page to WebAssembly
	$(PYTHON) -m venv build/zig
	build/zig/bin/pip install -q --no-compile `grep ^ziglang requirements/wheels.txt | cut -d' ' -f1`
	build/zig/bin/python scripts/wasm.py

docs: $(STAMPS)/docs $(STAMPS)/wheel  ## build the documentation site into build/docs and check its links
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs
	$(BIN)/python scripts/check_links.py build/docs
	@echo "Open build/docs/index.html."

dev: $(STAMPS)/test $(STAMPS)/robots $(STAMPS)/wheel  ## everything that working on the code needs, in .venv

# The pinned requirements, from pyproject.toml and requirements/build.in.
requirements: export CUSTOM_COMPILE_COMMAND := make requirements
requirements: PIP_COMPILE := build/pip-tools/bin/pip-compile -q --upgrade --strip-extras --annotation-style=line \
	--no-emit-index-url --no-emit-find-links
requirements: check-tools  ## pin the newest versions of everything
	$(PYTHON) -m venv build/pip-tools
	build/pip-tools/bin/pip install -q pip-tools==7.6.2
	$(PIP_COMPILE) --extra plot --extra netcdf --extra survey --extra test -o requirements/test.txt pyproject.toml
	$(PIP_COMPILE) -c requirements/test.txt --extra plot --extra netcdf --extra page --extra recordings --extra survey -o requirements/all.txt pyproject.toml
	$(PIP_COMPILE) -c requirements/test.txt -o requirements/build.txt requirements/build.in
	$(PIP_COMPILE) -c requirements/test.txt -o requirements/docs.txt requirements/docs.in
	$(PIP_COMPILE) -o requirements/wheels.txt requirements/wheels.in
	$(PIP_COMPILE) -o requirements/page.txt requirements/page.in
	$(PIP_COMPILE) -o requirements/peers.txt requirements/peers.in pyproject.toml
	sed -i 's/+cpu / /' requirements/peers.txt

clean:  ## remove everything that was made; your own runs in out/ stay
	rm -rf .venv .venv-peers build dist page/node_modules src/stillreach/page/dist out/paper out/demo .mypy_cache .pytest_cache .ruff_cache .hypothesis
	rmdir out 2>/dev/null || true
	find src tests examples -name __pycache__ -prune -exec rm -rf {} +

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*  ## /\1\t/p' Makefile | expand -t 14

check-tools:
	@sh scripts/check_tools.sh "$(PYTHON)"

$(STAMPS)/venv: | check-tools
	$(PYTHON) -m venv .venv
	mkdir -p $(STAMPS) && touch $@

# The peers' versions do not go together with those of .venv. Our own requirements are among them.
.venv-peers/installed: requirements/peers.txt requirements/peers.in | check-tools
	@echo "installing $< into .venv-peers"
	$(PYTHON) -m venv .venv-peers
	.venv-peers/bin/python bench/install.py
	touch $@

$(STAMPS)/build $(STAMPS)/all $(STAMPS)/docs $(STAMPS)/test: $(STAMPS)/%: requirements/%.txt $(STAMPS)/venv
	@echo "installing $< into .venv"
	$(BIN)/pip install -q --no-compile -r $<
	touch $@

$(STAMPS)/robots: requirements/robots.txt $(STAMPS)/venv
	@echo "installing $< into .venv: robots that the tests read, about 510 MB to download"
	$(BIN)/pip install -q --no-compile --no-deps -r $<
	touch $@

$(STAMPS)/page: $(PAGE_SOURCES) $(STAMPS)/venv
	@echo "building the program of the live page"
	sh scripts/page.sh
	touch $@

$(STAMPS)/wheel: $(SOURCES) $(STAMPS)/build $(STAMPS)/page | check-tools
	@echo "building the wheel and installing it into .venv"
	rm -rf build/wheel
	$(BIN)/pip wheel -q --no-deps --no-build-isolation --wheel-dir build/wheel $(SHARED) .
	$(BIN)/pip install -q --no-deps --force-reinstall build/wheel/stillreach-*.whl
	touch $@
