# make run    the main job: simulate the default arm, drive it, record, replay, summarise
# make test   every test, with the linter and the type checker
# Both make the environment in .venv first, if it is missing.

PYTHON ?= python3
VENV   ?= .venv
IN_ENV := $(VENV)/bin/python

# Everything stays on this machine unless the caller says otherwise.
export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST
# A guard of ROS wheels in another environment would keep those of this one from starting up.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: help run test env warm lint format bench contract stress skip guard realtime clean

help:
	@echo "make run     simulate, drive, record and replay the default arm: see runs/latest"
	@echo "make test    all tests"
	@echo "make bench   run time against error, with peers: under half an hour"
	@echo "make contract  tolerances against true errors: a minute and a half"
	@echo "make stress  the stability map: about twelve minutes; make skip: what features cost"
	@echo "make realtime  times real time, and the node's share of a core"
	@echo "make guard   whether steps cost more than they did: a minute"
	@echo "make env     only the environment, in $(VENV)"
	@echo "make lint    linter and type checker; make format rewrites the sources"
	@echo "make clean   remove what was built, but not runs/"

env:
	@$(PYTHON) tools/environment.py "$(VENV)"

warm: env
	@$(IN_ENV) tools/warm_up.py

run: warm
	@$(IN_ENV) -m soft_sim_ros demo

lint: env
	@$(IN_ENV) -m ruff check .
	@$(IN_ENV) -m ruff format --check .
	@$(IN_ENV) -m mypy

format: env
	@$(IN_ENV) -m ruff check --fix .
	@$(IN_ENV) -m ruff format .

test: lint warm
	@$(IN_ENV) -m pytest

# make bench CASES="heavy_arm chirp" PROGRAMS="soft_sim_ros"   a part; see docs/benchmarks.md
bench: warm
	@$(IN_ENV) -m benchmarks $(if $(CASES),--cases $(CASES)) $(if $(PROGRAMS),--programs $(PROGRAMS))

# whether runs with a tolerance keep it, and know it: a minute and a half
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

clean:
	rm -rf "$(VENV)" build install log dist *.egg-info
	rm -rf .pytest_cache .ruff_cache .mypy_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
