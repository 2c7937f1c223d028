# Everything a fresh clone needs: python3, make and a package index.
#   make run    build the FMUs, couple them, show the stick-slip cycle of the paper's Fig. 2
#   make quick  format, lint, types, and the tests that take a moment and need no other platform's libraries
#   make test   format, lint, types, and every test
#   make verify hold the product against laws, and the paper's claims against the product: a report
#   make endurance  let each law drill for a day: a table (LAW=, HOURS=, SEED=)
#   make console  the driller's console, a page for the browser; needs Node.js and npm: build/console/console.html
#   make fuzz   make up calls to the C code of an FMU until one goes wrong (MODEL=, DURATION=)
PYTHON ?= python3
VENV   := .venv
ifeq ($(OS),Windows_NT)
BIN    := $(VENV)/Scripts
else
BIN    := $(VENV)/bin
endif

# What Python has compiled is kept, whatever the shell says: the tests start thousands of processes that import the same.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run quick test setup fmus all-fmus lint types quick-unit unit verify endurance coverage sanitize fuzz bench \
    console wheel check-release pins hunt clean

run: fmus
	$(BIN)/cosim run stick-slip

quick: lint types quick-unit

test: lint types unit

setup: $(VENV)/installed

# Installs a file of hashed requirements: by uv where it is there (UV=: not), else by the environment's own pip, or the
# one that is asked for: PIP='pip==23.2.1', PIP='--upgrade pip'. Without a home to keep a cache in uv gives up, pip not.
UV  ?= $(shell test -w "$$HOME" && command -v uv 2>/dev/null)
PIP ?=
define install
	@echo "installing what $(1) pins, with $(or $(UV),pip)"
	@$(if $(UV),$(UV) pip install --compile-bytecode --python $(BIN)/python,$(BIN)/python -m pip install --disable-pip-version-check) \
	    --require-hashes -r $(1)
endef

# To run is to build and couple FMUs: no test tools.
$(VENV)/run-installed: requirements/run.txt pyproject.toml setup.py
	$(PYTHON) -m venv $(VENV)
	$(if $(PIP),$(BIN)/python -m pip install --quiet --disable-pip-version-check $(PIP))
	$(call install,requirements/run.txt)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/installed: requirements/test.txt $(VENV)/run-installed
	$(call install,requirements/test.txt)
	@touch $@

fmus: $(VENV)/run-installed
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

quick-unit: setup fmus
	$(PYTEST) -m "not slow and not cross_build and not emulator and not hardening"

unit: all-fmus
	$(PYTEST)

# Also judged by `unit`, law by law; ARGUMENTS=--html=report.html writes a page, --write-claims docs/claims.md anew.
verify: setup fmus
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.verify $(ARGUMENTS)

# Ten minutes of it are among the tests. LAW= may name several; without, all drill.
HOURS ?= 24
endurance: setup fmus
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.endurance $(LAW) --hours $(HOURS) \
	    --seed $(if $(filter command environment,$(firstword $(origin SEED))),$(SEED),1)

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
bench: setup fmus $(VENV)/bench-installed
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest tests/bench -o python_files='bench_*.py' -o python_functions='bench_*' \
	    --benchmark-columns=min,median,rounds --benchmark-sort=min --benchmark-group-by=group

$(VENV)/bench-installed: requirements/bench.txt $(VENV)/installed
	$(call install,requirements/bench.txt)
	@touch $@

# One page in build/console that needs nothing else; with the packages of npm that web/package-lock.json pins.
console: setup
	$(BIN)/python -m fmu_src.console

# A wheel that runs in any folder without a compiler: it holds the FMUs and the step loop for every platform, and
# the console if npm is there.
wheel: setup $(if $(shell command -v npm 2>/dev/null),console)
	rm -rf dist/wheel
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist/wheel .

# what is published: the wheel, tried in an empty environment, and every FMU, checked
check-release: wheel all-fmus
	$(BIN)/python -m pytest tests/packaging
	for fmu in dist/native/*.fmu; do $(BIN)/cosim check $$fmu || exit 1; done

# The pins anew: all that pyproject.toml asks for, of one resolution, for every platform and Python. UPGRADE= keeps
# the versions there are as far as they fit.
UPGRADE ?= --upgrade
PIN     := $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-strip-extras \
    --no-annotate --no-header --no-emit-index-url --custom-compile-command "make pins" pyproject.toml
pins: setup
	cp requirements/test.txt requirements/all.txt
	$(PIN) $(UPGRADE) --extra build --extra theory --extra stream --extra data --extra report --extra dask --extra sensitivity --extra container --extra test --extra docs --extra bench \
	    -o requirements/all.txt
	$(PIN) -c requirements/all.txt --extra build -o requirements/run.txt
	$(PIN) -c requirements/all.txt --extra build --extra theory --extra stream --extra data --extra report --extra dask --extra sensitivity \
	    --extra container --extra test -o requirements/test.txt
	$(PIN) -c requirements/all.txt --extra bench -o requirements/bench.txt
	$(PIN) -c requirements/all.txt --extra docs --extra theory -o requirements/docs.txt
	rm requirements/all.txt

# The tests that draw examples, with new ones each time; what fails prints how to make it again.
HUNTS ?= 20
hunt: all-fmus
	for hunt in $$(seq $(HUNTS)); do HYPOTHESIS_PROFILE=hunt $(BIN)/python -m pytest -m hypothesis || exit 1; done

clean:
	rm -rf $(VENV) build dist runs
