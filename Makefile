# make run    the main job: simulate the default arm, drive it, record, replay, summarise
# make test   every test, with the linter and the type checker
# make check  the linter and the quick tests, for daily work
# All make the environment in .venv first, if it is missing.

PYTHON ?= python3
VENV   ?= .venv
IN_ENV := $(VENV)/bin/python
# processes that share the tests
WORKERS ?= logical
# the environment of the oldest versions that setup.py allows
OLDEST ?= .venv-oldest
# the environment that makes the documentation
DOCS ?= .venv-docs

# Everything stays on this machine unless the caller says otherwise.
export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST
# Matrices are small: more threads of BLAS only wait for each other, and workers share the cores.
export OPENBLAS_NUM_THREADS ?= 1
# A guard of ROS wheels in another environment would keep those of this one from starting up.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: help gallery run test check test-oldest env env-test warm warm-tests lint format bench validate contract stress skip guard realtime docs docs-links clean

help:
	@echo "make run     simulate, drive, record and replay the default arm: see runs/latest"
	@echo "make test    all tests; make check: the linter and quick tests, for daily work"
	@echo "make test-oldest  most tests, with the oldest versions that setup.py allows"
	@echo "make bench   run time against error, with peers: half an hour"
	@echo "make validate  judged by others' results: some minutes; BANK=DIR for SoRoSim's bank"
	@echo "make contract  tolerances against true errors: a few minutes"
	@echo "make stress  the stability map: about twelve minutes; make skip: what features cost"
	@echo "make realtime  times real time, and the node's share of a core"
	@echo "make guard   whether steps cost more than they did: a minute"
	@echo "make docs    the documentation site, in build/docs; make docs-links asks other servers"
	@echo "make gallery the pictures of docs/forest.md and docs/fluid.md, made again"
	@echo "make env     only the environment, in $(VENV)"
	@echo "make lint    linter and type checker; make format rewrites the sources"
	@echo "make clean   remove what was built, but not runs/"

env:
	@$(PYTHON) tools/environment.py "$(VENV)"

# and what tests need besides
env-test:
	@$(PYTHON) tools/environment.py "$(VENV)" test

warm: env
	@$(IN_ENV) tools/warm_up.py

run: env
	@$(IN_ENV) -m soft_sim_ros demo

lint: env-test
	@$(IN_ENV) -m ruff check .
	@$(IN_ENV) -m ruff format --check .
	@$(IN_ENV) -m mypy

format: env-test
	@$(IN_ENV) -m ruff check --fix .
	@$(IN_ENV) -m ruff format .

# first: workers would compile the same kernels side by side
warm-tests: env-test
	@$(IN_ENV) tools/warm_up.py --tests

test: lint warm-tests
	@$(IN_ENV) -m pytest -n $(WORKERS)

check: lint warm-tests
	@$(IN_ENV) -m pytest -n $(WORKERS) -m "not slow" \
		test/core test/scene test/recording test/report \
		test/package/test_metadata.py test/package/test_suite.py test/package/test_oldest.py

# with numba's compiled code in the environment itself; no ROS, so no node. OLD=python3.10 chooses
test-oldest: export NUMBA_CACHE_DIR := $(abspath $(OLDEST))/kernels
test-oldest: export PYTHONPATH := $(CURDIR)
test-oldest:
	@$(PYTHON) tools/oldest.py "$(OLDEST)" $(OLD)
	@$(OLDEST)/bin/python tools/warm_up.py --tests
	@$(OLDEST)/bin/python -m pytest -n $(WORKERS) -m "not slow" \
		test/core test/scene test/recording test/report test/commands \
		test/papers/test_b3_floating_frame.py

# make bench CASES="heavy_arm chirp" PROGRAMS="soft_sim_ros"   a part; see docs/benchmarks.md
gallery: warm
	@$(IN_ENV) tools/gallery.py

bench: warm
	@$(IN_ENV) -m benchmarks $(if $(CASES),--cases $(CASES)) $(if $(PROGRAMS),--programs $(PROGRAMS))

# others' results computed again; see docs/validation.md
validate: warm
	@$(IN_ENV) -m benchmarks.validation $(if $(BANK),--bank "$(BANK)")

# whether runs with a tolerance keep it, and know it: a few minutes
contract: warm
	@$(IN_ENV) -m benchmarks.contract

# where the solver completes, refuses, or is wrong: 3000 scenes, see docs/stress.md
stress: warm
	@$(IN_ENV) -m benchmarks.stress

# what features cost scenes that lack them, and how batches use the cores
skip: warm
	@$(IN_ENV) -m benchmarks.skip
	@$(IN_ENV) -m benchmarks.batch

# how much faster than real time the default arm is, and what the node costs and how it starts
realtime: warm
	@$(IN_ENV) -m benchmarks.realtime
	@$(IN_ENV) -m benchmarks.node

# part of .ci/run: fails where a step costs 1.5 times what it did
guard: warm
	@$(IN_ENV) -m benchmarks.guard

# with its own environment: no ROS, and no tool of the tests
$(DOCS)/ready: setup.py
	@$(PYTHON) -m venv "$(DOCS)"
	@"$(DOCS)/bin/python" -m pip install -q --disable-pip-version-check --editable ".[docs]"
	@touch "$@"

# a link to a page, heading or name that does not exist is an error
docs: $(DOCS)/ready
	@"$(DOCS)/bin/python" -m sphinx -q -W --keep-going -b html docs build/docs
	@echo "build/docs/index.html"

docs-links: $(DOCS)/ready
	@"$(DOCS)/bin/python" -m sphinx -q -b linkcheck docs build/links

clean:
	rm -rf "$(VENV)" "$(OLDEST)" "$(DOCS)" build install log dist *.egg-info
	rm -rf .pytest_cache .ruff_cache .mypy_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
