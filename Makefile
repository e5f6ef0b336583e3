# One command a chore. Every target makes the environment it needs: only Python >= 3.11, make and git
# have to be there.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= results
# more options of a study, such as ARGS=--overwrite
ARGS ?=
INSTALLED := $(VENV)/installed
# two processes of tests share two cores; threads that wait for each other would take half of them
ONE_THREAD := OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# where Python may not keep compiled files, every process compiles program and tests anew: 10 s for all tests
COMPILED_ONCE := PYTHONDONTWRITEBYTECODE=
TESTING := $(ONE_THREAD) $(COMPILED_ONCE)
PACKAGES := -p exudyn_crawler -p fem -p meshes -p studies

.PHONY: help demo kinematics forces uneven stress rollers closed ground life sweep-terrain sweep-plate scatter verify check test test-slow lint format bench \
	test-lowest test-newest docs notebooks lock clean

help:  ## what can be made
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

$(INSTALLED): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python >= 3.11 is needed; name one with: make PYTHON=python3.12 ..."; exit 1; }
	@echo "installing into $(VENV): packages (about 1 GB, one or two minutes), then what is compiled (one or two more)"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	$(BIN)/exudyn-crawler demo --prepare
	@touch $@
	@echo "installed: make demo shows a track, make help what else there is"

demo: $(INSTALLED)  ## half a machine drives on a closed track with a flexible shoe: a page to look at, in 20 s
	$(BIN)/exudyn-crawler demo --out $(OUT)/demo $(ARGS)

kinematics: $(INSTALLED)  ## the kinematics study: 10 s, straight and turning
	$(BIN)/python -m studies kinematics --out $(OUT)/kinematics $(ARGS)

forces: $(INSTALLED)  ## the forces study; reuses the histories of the kinematics study
	$(BIN)/python -m studies forces --out $(OUT)/forces $(ARGS)

uneven: $(INSTALLED)  ## the track over a step, a ramp and rough ground, with the second contact model
	$(BIN)/python -m studies uneven --out $(OUT)/uneven $(ARGS)

stress: $(INSTALLED)  ## the stress study: 40 s with six flexible shoes; goes on where it was stopped
	$(BIN)/python -m studies stress --out $(OUT)/stress $(ARGS)

life: $(INSTALLED)  ## life of the shoes in machine hours, of the stress study; ARGS="--rollers results/rollers" adds the rolled
	$(BIN)/python -m studies shovel-life --out $(OUT)/life --stress $(OUT)/stress $(ARGS)

rollers: $(INSTALLED)  ## the machine rolls over six flexible shoes and digs above them; beside the papers' dragging
	$(BIN)/python -m studies rollers --out $(OUT)/rollers $(ARGS)

closed: $(INSTALLED)  ## one revolution of a closed track on the papers' ground with the stress of a shoe; ARGS="--flexible 0" without
	$(BIN)/python -m studies closed --out $(OUT)/closed $(ARGS)

ground: $(INSTALLED)  ## the machine rolls over sand, oil sand and hard floor with ruts, stones and ridges
	$(BIN)/python -m studies grounds --out $(OUT)/ground $(ARGS)

verify: $(INSTALLED)  ## the two-body problem against its hand solution
	$(BIN)/python -m studies verify

sweep-terrain: $(INSTALLED)  ## 40 runs: stiffness of the ground and friction against the forces in the links
	$(BIN)/exudyn-crawler sweep studies/terrain_sweep.toml --out $(OUT)/terrain_sweep $(ARGS)

scatter: $(INSTALLED)  ## 200 runs over oil sand that is drawn from a distribution: quantiles of pull and forces
	$(BIN)/exudyn-crawler scatter studies/scatter.toml --out $(OUT)/scatter $(ARGS)

sweep-plate: $(INSTALLED)  ## 9 runs: top plate of the shoe and the ground against the life of the roller path
	$(BIN)/python -m studies plate-sweep --out $(OUT)/plate_sweep $(ARGS)

check: $(INSTALLED) lint  ## lint and the tests that run no simulation, within a minute
	$(TESTING) $(BIN)/python -m pytest -m "not slow and not simulation" -n 2

test: $(INSTALLED)  ## the tests, less the slow ones, on two processes
	$(TESTING) $(BIN)/python -m pytest -m "not slow" -n 2 --dist loadscope --no-loadscope-reorder

test-slow: $(INSTALLED)  ## the studies at full length against the papers; once before a release
	$(BIN)/python -m pytest -m slow

test-lowest:  ## the tests of make check with the lowest versions that pyproject.toml admits
	.ci/versions lowest

test-newest:  ## the tests of make check with the newest versions of all requirements
	.ci/versions newest

lint: $(INSTALLED)  ## ruff and mypy, also for what is there on Windows and macOS
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32 $(PACKAGES)
	$(BIN)/mypy --platform darwin --cache-dir .mypy_cache/darwin $(PACKAGES)

format: $(INSTALLED)  ## put the code into its standard form
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: $(INSTALLED)  ## handbook, tutorial, gallery and API reference as one site with a search, into site/
	$(BIN)/sphinx-build -q -W --keep-going -c docs . site
	@echo "site/index.html: open it in a browser"

notebooks: $(INSTALLED)  ## execute the handbook's notebooks anew, in their places
	$(BIN)/python -m docs.notebooks

bench: $(INSTALLED)  ## time the runs and show their accuracy; ARGS=docs/images renews the curves of docs/speed.md
	$(BIN)/python -m benchmarks.run $(ARGS)

lock: $(INSTALLED)  ## resolve the versions anew into requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv
	$(BIN)/uv pip compile --universal --upgrade --extra dev --python-version 3.11 --no-header \
		--no-annotate --no-emit-find-links --no-emit-index-url pyproject.toml --output-file requirements.lock

clean:  ## remove the environment and the caches
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache *.egg-info docs/api
