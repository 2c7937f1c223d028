# Everything a fresh clone needs: python3, make and a package index.
#   make run    build the FMUs, couple them, show the stick-slip cycle of the paper's Fig. 2
#   make quick  format, lint, types, and the tests that take a moment and need no other platform's libraries
#   make test   format, lint, types, and every test
#   make verify hold the product against laws, and the paper's claims against the product: a report
#   make fuzz   make up calls to the C code of an FMU until one goes wrong (MODEL=, DURATION=)
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

.PHONY: run quick test setup fmus all-fmus lint types quick-unit unit verify coverage sanitize fuzz bench clean

run: fmus
	$(BIN)/cosim run stick-slip

quick: lint types quick-unit

test: lint types unit

setup: $(VENV)/installed

$(VENV)/installed: requirements.txt pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

fmus: setup
	$(BIN)/python build_fmu.py

# what a release holds and the tests examine: libraries for all platforms in every native FMU
all-fmus: setup
	$(BIN)/python build_fmu.py --platform all

lint: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: setup
	$(BIN)/basedpyright

# A module's tests stay in one process, so what they share is made once; tests/conftest.py puts the costly ones first.
PYTEST = OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadscope --no-loadscope-reorder

quick-unit: fmus
	$(PYTEST) -m "not slow and not cross_build and not emulator and not hardening"

unit: all-fmus
	$(PYTEST)

# Also judged by `unit`, law by law; ARGUMENTS=--html=report.html writes a page, --write-claims docs/claims.md anew.
verify: fmus
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.verify $(ARGUMENTS)

# The C code: docs/hardening.md tells what these three need beside Python.
coverage: setup
	$(BIN)/python -m tests.native.coverage

# more calls at random than make test makes
CALLS ?= 1000000
SEED  ?= $(shell date +%j%H%M)
sanitize: setup
	CALLS=$(CALLS) SEED=$(SEED) $(BIN)/python -m pytest tests/native/test_hardening.py -k at_random

MODEL   ?= DrillstringNeutral
DURATION ?= 600
fuzz: setup
	$(BIN)/python -m tests.native.fuzz $(MODEL) $(DURATION)

# Compares with what users would do otherwise; numba, jitcdde (needs a C compiler) and pytest-benchmark are its own.
bench: fmus $(VENV)/bench-installed
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest tests/bench -o python_files='bench_*.py' -o python_functions='bench_*' \
	    --benchmark-columns=min,median,rounds --benchmark-sort=min --benchmark-group-by=group

$(VENV)/bench-installed: requirements-bench.txt $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-bench.txt
	touch $@

clean:
	rm -rf $(VENV) build dist runs
