# The one door. Each target makes the environment it needs in .venv, from pyproject.toml
# and constraints.txt, and finds it ready the next time.

# Tests start hundreds of processes, each of which would compile the package anew.
unexport PYTHONDONTWRITEBYTECODE

VENV := .venv
BIN := $(VENV)/bin
# The first interpreter that is new enough; `make PYTHON=... test` chooses another.
PYTHON ?= $(shell for p in python3 python3.11 python3.12 python3.13; do \
  $$p -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
PYTEST := $(BIN)/python -m pytest -n 2 --dist worksteal

.DEFAULT_GOAL := help
.PHONY: help paper explore test test-all coverage mutants lint docs bench clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-9s %s\n", $$1, $$2 }' Makefile

paper: $(VENV)/.runtime ## figures, data and the audit of the article's claims, in paper/
	$(BIN)/remanent paper --out paper

explore: $(VENV)/.runtime ## a page in the browser that follows sliders; Ctrl-C ends it
	$(BIN)/remanent explore

test: $(VENV)/.develop ## the tests, without the slow ones
	$(PYTEST) -m "not slow"

test-all: $(VENV)/.develop ## every test, with many more random cases
	$(PYTEST) --hypothesis-profile=nightly

coverage: $(VENV)/.develop ## lines and branches that the tests run, by package
	rm -rf .adequacy && mkdir .adequacy
	REMANENT_CACHE_DIR=$(CURDIR)/.adequacy/cache \
	  $(PYTEST) -m "not slow" -p tests.adequacy.durations --cov --cov-context=test --cov-report=
	$(BIN)/python -m tests.adequacy.coverage

mutants: $(VENV)/.mutation ## how many random mutants the tests notice; after coverage
	$(BIN)/python -m tests.adequacy

lint: $(VENV)/.develop ## style, format, types, import rules, documentation
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(MAKE) --no-print-directory docs

docs: $(VENV)/.develop docs/_build/extra/explorer.html ## the site, in docs/_build/html
	$(BIN)/sphinx-build -W --keep-going --quiet -b html docs docs/_build/html

# The explorer's saved page, to which the gallery links; `make clean` removes it.
docs/_build/extra/explorer.html: | $(VENV)/.develop
	@mkdir -p $(@D)
	$(BIN)/remanent explore --save $@

bench: $(VENV)/.bench ## the benchmarks, against the peers in the same run
	$(BIN)/python -m benchmarks

clean: ## remove what the other targets wrote, except .venv
	rm -rf paper docs/_build .adequacy .pytest_cache .mypy_cache .ruff_cache .hypothesis dist
	find src tests docs benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

# The environment. Each stamp says that what it names is installed.

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed, with its venv module" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.runtime: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) --editable '.[all]'
	@touch $@

$(VENV)/.develop: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) --editable '.[test,lint,docs]'
	@touch $@ $(VENV)/.runtime

$(VENV)/.mutation: $(VENV)/.develop
	$(INSTALL) --editable '.[mutation]'
	@touch $@

$(VENV)/.bench: $(VENV)/.runtime
	$(INSTALL) --editable '.[bench]'
	@touch $@
