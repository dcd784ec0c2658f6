# `make report`  set up everything and run the standard suite (SUITE=smoke for the short one)
# `make check`   set up everything and compare the physics with baselines/standard (SUITE=smoke for a part of it)
# `make test`    set up everything and run the whole test suite (JOBS=4 for four processes)
# `make bench`   measure what the reference engine promises and enter it in docs/benchmarks.md
# Needs Python 3.11 or newer with pip and venv; PyBullet has wheels up to Python 3.11 and is left out beyond it.

PYTHON ?= $(firstword $(shell command -v python3.11) $(shell command -v python3) python)
SUITE ?= standard
JOBS ?= 2
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable

.PHONY: report check test test-browser bench lint clean

report: $(VENV)/.engines
	$(BIN)/plumbline run $(SUITE) --fail-on harness

check: $(VENV)/.engines
	$(BIN)/plumbline check $(SUITE) --baseline standard $(OPTIONS)

test: $(VENV)/.test
	$(BIN)/python -m pytest -n $(JOBS) --dist loadscope --no-loadscope-reorder

test-browser: $(VENV)/.test
	$(BIN)/python -m pytest -m browser

bench: $(VENV)/.test
	$(BIN)/python -m benchmarks --write

lint: $(VENV)/.test
	$(INSTALL) '.[dev]'
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.engines: $(VENV)/bin/python pyproject.toml constraints.txt
	$(INSTALL) '.[engines]'
	touch $@

$(VENV)/.test: $(VENV)/.engines
	$(INSTALL) '.[engines,test]'
	touch $@

clean:
	rm -rf $(VENV) runs build dist .pytest_cache .hypothesis .mypy_cache .ruff_cache
