PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: run native test test-all lint bench docs clean
run: $(VENV)/installed dist/built          ## build the FMUs, run the Sea Cliff scene, write out/sea_cliff/report.html
	$(BIN)/towage run sea_cliff --fmus dist

native: $(VENV)/installed-native           ## all native FMUs, FMI 2 and 3, for this platform
	$(BIN)/python build_fmus.py --flavour native
	$(BIN)/python build_fmus.py --flavour native --fmi 3

test: $(VENV)/installed-test dist/built    ## lint, types and all tests but the long tail
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -q

test-all: $(VENV)/installed-test dist/built ## every test
	$(BIN)/pytest -q -m "slow or not slow"

bench: $(VENV)/installed-test              ## speed against error; the tables quoted in docs/
	for file in benchmarks/*.py; do $(BIN)/python $$file || exit 1; done

docs: $(VENV)/installed                    ## the pages made from the units' declarations
	$(BIN)/python docs/make_units.py

$(VENV)/created:
	$(PYTHON) -c 'import sys; assert sys.version_info >= (3, 11), "towage needs Python 3.11 or newer; set PYTHON="'
	$(PYTHON) -m venv $(VENV)
	touch $@

$(VENV)/installed: $(VENV)/created pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	touch $@

$(VENV)/installed-test: $(VENV)/created pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	touch $@ $(VENV)/installed

$(VENV)/installed-native: $(VENV)/created pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[native]'
	touch $@ $(VENV)/installed

dist/built: $(VENV)/installed build_fmus.py $(wildcard models/*.py fmus/*.py)
	$(BIN)/python build_fmus.py
	touch $@

clean:
	rm -rf $(VENV) dist out build *.egg-info
