# Each target does its own set-up; it takes Python 3.11 or newer, and nothing else.

.DEFAULT_GOAL := help
.PHONY: help demo test lint docs clean
.DELETE_ON_ERROR:

PYTHON ?= $(firstword $(foreach name,python3.11 python3.12 python3.13 python3,$(shell \
	command -v $(name) >/dev/null 2>&1 && $(name) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $(name))))
BIN := .venv/bin
PIP := $(BIN)/python -m pip install -qq --disable-pip-version-check --constraint constraints.txt
CACHE := .venv/compiled.stamp

help:
	@echo "make demo   set up, diagnose the bundled record, print the answer and the report's place"
	@echo "make test   set up, run all tests"
	@echo "make lint   set up, check format, style and types"
	@echo "make docs   set up, build the documentation into site/"
	@echo "make clean  remove everything that was made here"

.venv/run.stamp: pyproject.toml constraints.txt
	@if [ -z "$(PYTHON)" ]; then echo "valvemodel needs Python 3.11 or newer; none was found" >&2; exit 2; fi
	@echo "setting up .venv (once) ..."
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear .venv
	@$(PIP) --editable .
	@touch $@

.venv/test.stamp: .venv/run.stamp
	@echo "setting up the tests (once) ..."
	@$(PIP) --editable '.[test]'
	@touch $@

# Compiled once for each state of the sources; numba keeps the result beside them.
$(CACHE): .venv/run.stamp $(wildcard valvemodel/stages/*.py valvemodel/equations/*.py) valvemodel/chain.py
	@echo "compiling the simulator (once) ..."
	@$(BIN)/valvemodel simulate --input diagnosis/examples/demo.csv --out .venv/warm.csv 2>/dev/null
	@touch $@

demo: $(CACHE)
	@$(BIN)/valvemodel diagnose diagnosis/examples/demo.csv --out demo-report

test: .venv/test.stamp
	@$(BIN)/python -m pytest -n 2 --dist loadfile

.venv/docs.stamp: .venv/run.stamp
	@echo "setting up the documentation (once) ..."
	@$(PIP) --editable '.[docs]'
	@touch $@

docs: .venv/docs.stamp
	@DISABLE_MKDOCS_2_WARNING=true $(BIN)/mkdocs build --quiet --config-file docs/mkdocs.yml
	@echo "open site/index.html"

lint: .venv/test.stamp
	@status=0; \
	$(BIN)/ruff format --check --quiet . || status=1; \
	$(BIN)/ruff check --quiet . || status=1; \
	$(BIN)/mypy valvemodel derivations identification diagnosis benchmarks || status=1; \
	exit $$status

clean:
	@rm -rf .venv build dist site demo-report .pytest_cache .hypothesis .ruff_cache .mypy_cache *.egg-info
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
