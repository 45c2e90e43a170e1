# Everything runs in .venv, which is made and kept up to date from the pinned versions on its own.
PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
STAMP := $(VENV)/.installed
MAKEFLAGS += --no-print-directory
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# One thread each: NumPy and SciPy bring a BLAS of their own, and the two fight for the cores.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.DEFAULT_GOAL := help
.PHONY: help run case-exists test test-physics test-all browser verify lint check bench wheel lock readme docs clean clean-outputs distclean
.DELETE_ON_ERROR:

help:
	@echo "make run CASE=name [ARGS=...]  run cases/name.yaml into outputs/name"
	@echo "make test                      tests that take no long solves: about a minute"
	@echo "make test-physics              those that solve scenes, without the slow ones: some minutes"
	@echo "make test-all                  all tests"
	@echo "make browser                   the report in Chromium (needs chromium and chromedriver)"
	@echo "make verify                    references and exact solutions: a table in outputs/verification"
	@echo "make lint                      ruff and mypy"
	@echo "make check                     lint, test and test-physics"
	@echo "make bench [ARGS=two_flaws]    speed beside an earlier commit, of all or some cases"
	@echo "make wheel                     the package as a wheel, in dist"
	@echo "make lock                      renew the pinned versions: .requirements.lock"
	@echo "make readme                    run the commands of all READMEs"
	@echo "make docs                      write the parts of the READMEs that are made of declarations;"
	@echo "                               with ARGS=--pictures the pictures of README.md, too"
	@echo "make clean | distclean         remove caches | and .venv"
	@echo "make clean-outputs             remove all results in outputs, after asking"

# Without the stamp the environment is new or half made: start afresh. With it, only bring the versions up to date.
$(STAMP): .requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) not found: install Python 3.11 or newer, or set PYTHON=" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "crackgrow needs Python 3.11 or newer, $(PYTHON) is $$($(PYTHON) --version 2>&1): set PYTHON=" >&2; exit 1; }
	@if [ ! -f $@ ] || ! $(PY) -m pip --version >/dev/null 2>&1; then \
		echo "making $(VENV)"; \
		$(PYTHON) -m venv --clear $(VENV) || \
			{ echo "$(PYTHON) cannot make $(VENV): install its venv module (python3-venv)" >&2; exit 1; }; \
	fi
	@rm -f $@
	@echo "installing the pinned versions"
	@$(PY) -m pip install --quiet --requirement .requirements.lock
	@$(PY) -m pip install --quiet --no-deps --no-build-isolation --editable .
	@echo "compiling the kernels: less than a minute"
	@folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT && \
		$(PY) -m crackgrow run cases/compression30.yaml --out "$$folder/run" --quiet --set growth.steps=1 2>"$$folder/told" || \
		{ cat "$$folder/told" >&2; exit 1; }
	@touch $@

run: case-exists $(STAMP)
	@$(PY) -m crackgrow run "cases/$(CASE).yaml" --out "outputs/$(CASE)" $(ARGS)

case-exists:
	@if [ -z "$(CASE)" ] || [ ! -f "cases/$(CASE).yaml" ]; then \
		if [ -z "$(CASE)" ]; then echo "which case? make run CASE=name"; else echo "no case cases/$(CASE).yaml"; fi >&2; \
		echo "cases:" $$(ls cases 2>/dev/null | sed -n 's/\.yaml$$//p') >&2; exit 2; \
	fi

PYTEST := -m pytest -q -n auto --maxprocesses 8
TABLE := -p tests.verification.table

test: $(STAMP)
	@$(PY) $(PYTEST) -m "not physics and not slow" --dist loadfile

test-physics: $(STAMP)
	@$(PY) $(PYTEST) -m "physics and not slow" --dist loadfile $(TABLE)

test-all: $(STAMP)
	@$(PY) $(PYTEST) --dist loadfile $(TABLE)

browser: $(STAMP)
	@$(PY) -m pytest -q -m browser tests/browser

verify: $(STAMP)
	@$(PY) $(PYTEST) -m "not slow" --dist loadfile $(TABLE) tests/verification/rows $(ARGS)

lint: $(STAMP)
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check --quiet .
	@$(PY) -m mypy

check: lint test test-physics

bench: $(STAMP)
	@$(PY) -m tests.benchmarks.cost --against 473cd78 $(ARGS)

# Without a build folder: setuptools would pack what an earlier build has left in it.
wheel: $(STAMP)
	@rm -rf build dist
	@$(PY) -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .
	@ls dist/*.whl

# In an environment of its own, with the newest versions that fit pyproject.toml.
lock:
	@folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT && $(PYTHON) -m venv "$$folder" && \
		"$$folder/bin/python" -m pip install --quiet --upgrade setuptools wheel ".[dev,maps,sweep]" && \
		"$$folder/bin/python" -m pip freeze --all --exclude pip --exclude crackgrow > "$$folder/found" && \
		LC_ALL=C sort -f "$$folder/found" > .requirements.lock
	@rm -rf build

readme: $(STAMP)
	@$(PY) -m tests.readme.run $(ARGS)

docs: $(STAMP)
	@$(PY) -m tests.readme.generated $(ARGS)

clean:
	@rm -rf build dist .pytest_cache .mypy_cache .ruff_cache
	@find . -name __pycache__ -not -path './$(VENV)/*' -prune -exec rm -rf {} +

# Results are the user's: nothing else of this file removes them.
clean-outputs:
	@n=$$(find outputs -mindepth 1 -maxdepth 1 ! -path outputs/README.md | wc -l); \
	if [ $$n -eq 0 ]; then echo "outputs is empty"; exit 0; fi; \
	find outputs -mindepth 1 -maxdepth 1 ! -path outputs/README.md | sort; \
	printf 'remove these and all that is in them? [y/N] '; read answer || answer=; \
	case "$$answer" in \
		y|Y|yes) find outputs -mindepth 1 ! -path outputs/README.md -delete; echo "removed";; \
		*) echo "nothing is removed";; \
	esac

distclean: clean
	@rm -rf $(VENV) *.egg-info
