# Thin: CMake builds, pip installs, two scripts in cmake/ find what is missing. `make` lists the targets.

BUILD ?= build
SANITIZE ?= $(BUILD)/sanitize
VENV ?= .venv
LAMMPS_DIR ?=
PERIDEM_NATIVE ?= ON
PYTEST_ARGS ?=
# quick tests run side by side; PYTEST_ARGS='-n 0' has them one by one (for --pdb, say)
SIDE_BY_SIDE ?= -n auto --maxprocesses 8 --dist worksteal
VERIFY_ARGS ?=
BENCH_ARGS ?=
PARETO_ARGS ?=
# the examples' and the tests' own defaults suit two cores
RANKS ?= 2

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help demo test quick verify bench pareto docs linkcheck sanitize memcheck build system lint lock clean distclean FORCE
.NOTPARALLEL:

python := $(VENV)/bin/python
tree := $(if $(LAMMPS_DIR),$(abspath $(LAMMPS_DIR)),$(BUILD)/lammps-src)
export LAMMPS_LMP := $(abspath $(BUILD)/lmp)
export PERIDEM_LMP := $(LAMMPS_LMP)
export MPLBACKEND := Agg

# Containers run as root, and small machines have fewer cores than a test has ranks; Open MPI wants
# both said (the last of these is for Open MPI 5).
ifeq ($(shell id -u),0)
  export OMPI_ALLOW_RUN_AS_ROOT := 1
  export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM := 1
endif
export OMPI_MCA_rmaps_base_oversubscribe := 1
export PRTE_MCA_rmaps_default_mapping_policy := :oversubscribe

help: ## list the targets (the default)
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 18
	@echo
	@echo '  LAMMPS_DIR=/path/to/lammps make build    take that source tree (4Feb2025 to 4Jul2026)'
	@echo '  PERIDEM_NATIVE=OFF make build            for any processor of this architecture'
	@echo '  PYTHON=/path/to/python3 make build       the Python that .venv is made with (3.10 to 3.13)'
	@echo '  PYTEST_ARGS="-k restart" make test       options for pytest'
	@echo '  VERIFY_ARGS="--only bar" make verify     some cases anew (--list names them)'
	@echo '  BENCH_ARGS=kernels make bench            some parts anew (bench/README.md names them)'

demo: build ## set everything up, then crush a box of grains: pictures in out/demo
	$(python) examples/compression/compression.py --ranks $(RANKS) --output out/demo

test: build ## set everything up, then run every test
	PERIDEM_TESTS_MUST_RUN=1 $(python) -m pytest tests $(PYTEST_ARGS)

quick: build ## set everything up, then run the tests of a minute (unit and python, but slow ones)
	PERIDEM_TESTS_MUST_RUN=1 $(python) -m pytest tests/unit tests/python -m 'not slow and not seconds' \
	  $(SIDE_BY_SIDE) $(PYTEST_ARGS)

verify: build ## the cases with known answers at full size: doc/verification.md (half an hour)
	cd tests && $(abspath $(python)) -m verification.report $(VERIFY_ARGS)

bench: build ## what things cost on this machine: bench/results, doc/performance.md
	$(python) -m bench $(BENCH_ARGS)

pareto: build ## error against cost, and what to choose: the same places
	$(python) -m bench.pareto $(PARETO_ARGS)

docs: build ## the manual: build/docs/html/index.html
	$(python) -m sphinx -W --keep-going -q -b html doc $(BUILD)/docs/html
	@echo "manual: $(BUILD)/docs/html/index.html"

linkcheck: build ## look up the addresses that the manual names (needs a network)
	$(python) -m sphinx -q -b linkcheck doc $(BUILD)/docs/linkcheck

portable = -D PERIDEM_NATIVE=OFF -D LAMMPS_DIR=$(abspath $(tree)) \
  $(foreach package,PERI GRANULAR BPM MISC EXTRA-FIX EXTRA-COMPUTE EXTRA-PAIR EXTRA-DUMP OPENMP PLUGIN,-D PKG_$(package)=OFF)

# Programs that do not start through the sanitizer's library, such as Python, must load it first. A
# test that it stops takes its process along: pytest must not keep what is said on the screen.
sanitize: build ## run unit, fuzz and parallel tests where wrong memory or undefined behaviour stops them (slow)
	cmake -S . -B $(SANITIZE) -D PERIDEM_SANITIZE=ON $(portable)
	cmake --build $(SANITIZE) --parallel $$(nproc)
	PYTHONPATH=$(abspath $(tree))/python LD_LIBRARY_PATH=$(abspath $(SANITIZE)) \
	  LAMMPS_LMP=$(abspath $(SANITIZE))/lmp PERIDEM_LMP=$(abspath $(SANITIZE))/lmp \
	  LD_PRELOAD="$$(for name in asan ubsan stdc++; do $(CXX) -print-file-name=lib$$name.so; done | xargs)" \
	  ASAN_OPTIONS=detect_leaks=0:suppressions=$(abspath tests/sanitize.supp) \
	  UBSAN_OPTIONS=print_stacktrace=1 PERIDEM_TESTS_MUST_RUN=1 \
	  $(abspath $(python)) -m pytest tests/unit tests/fuzz tests/parallel -m 'not slow' \
	  --capture=sys $(SIDE_BY_SIDE) $(PYTEST_ARGS)

memcheck: build ## run two small scenes on two ranks under valgrind (which must be there)
	PERIDEM_TESTS_MUST_RUN=1 \
	  $(abspath $(python)) -m pytest tests/parallel/test_memcheck.py $(PYTEST_ARGS)

build: $(BUILD)/configured ## build/lmp and build/liblammps.so with PERIDEM, and .venv with the lammps module
	@cmake --build $(BUILD) --parallel $$(nproc)
	@cmake/setup-python.sh $(VENV) $(tree) $(BUILD)/liblammps.so

system: ## install what is missing with apt (as root or with sudo), or print the line to run
	@cmake/setup-system.sh

# Configured again only when these options change; CMake itself notices changes of its files.
options = LAMMPS_DIR=$(if $(LAMMPS_DIR),$(abspath $(LAMMPS_DIR))) PERIDEM_NATIVE=$(PERIDEM_NATIVE)
$(BUILD)/options: FORCE
	@mkdir -p $(BUILD)
	@echo '$(options)' | cmp -s - $@ || echo '$(options)' >$@
FORCE:

$(BUILD)/configured: $(BUILD)/options | system
	@if [ ! -f $(BUILD)/CMakeCache.txt ] && command -v ninja >/dev/null; then \
	   export CMAKE_GENERATOR=Ninja; fi; \
	 cmake -S . -B $(BUILD) $(addprefix -D ,$(options))
	@touch $@

lint: build ## check style, types, pages and lists of all files (FIX=1: put the format right)
	$(VENV)/bin/ruff check $(if $(FIX),--fix) .
	$(VENV)/bin/ruff format $(if $(FIX),,--check) .
	$(VENV)/bin/clang-format $(if $(FIX),-i,--dry-run -Werror) src/PERIDEM/*.cpp src/PERIDEM/*.h bench/*.cpp
	$(VENV)/bin/mypy --config-file python/pyproject.toml python/peridem
	$(python) -m pytest -q tests/unit/test_order.py tests/unit/test_manual_index.py
	$(python) doc/check_pages.py
	$(python) doc/check_syntax.py

lock: ## write requirements.txt anew from python/pyproject.toml and requirements.in (needs uv)
	uv pip compile --quiet --universal --python-version 3.10 --generate-hashes --no-build \
	  --no-annotate --custom-compile-command 'make lock' --extra test --extra docs \
	  python/pyproject.toml requirements.in --output-file requirements.txt

clean: ## remove what was built and made, but not what was fetched
	rm -rf $(VENV) out
	if [ -d $(BUILD) ]; then find $(BUILD) -mindepth 1 -maxdepth 1 ! -name downloads -exec rm -rf {} +; fi

distclean: clean ## remove the fetched files too
	rm -rf $(BUILD)
