PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
JOBS ?= 2

.PHONY: run native test test-all faults hosts fool fuzz calls lint bench docs wheel clean
run: $(VENV)/installed dist/built          ## build the FMUs, run the Sea Cliff scene, write out/sea_cliff/report.html
	$(BIN)/towage run sea_cliff --fmus dist

native: $(VENV)/installed-native           ## all native FMUs, FMI 2 and 3, for this platform
	$(BIN)/python build_fmus.py --flavour native
	$(BIN)/python build_fmus.py --flavour native --fmi 3

test: $(VENV)/installed-test dist/built    ## lint, types, layers and all tests but the long tail; JOBS=n on n processors
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo
	$(BIN)/pytest -q -n $(JOBS) --dist loadscope

test-all: $(VENV)/installed-test dist/built ## every test
	$(BIN)/pytest -q -n $(JOBS) --dist loadscope -m "slow or not slow"

faults: $(VENV)/installed-test             ## inject every known fault; the table quoted in docs/faults.md
	$(BIN)/python -m tests.faults.table

fool: $(VENV)/installed-test dist/built    ## 5000 random heave scenes and 300 tows against the verdict; goes on where it was stopped
	$(BIN)/python -m tests.verdict.fool heave --count 5000 --jobs $(JOBS)
	$(BIN)/python -m tests.verdict.fool tows --count 300 --jobs $(JOBS)

hosts: $(VENV)/installed-test              ## every scene and unit in every other host that is here; the tables of docs/hosts.md
	$(BIN)/python -m tests.hosts.table

fuzz: $(VENV)/installed-test               ## mutated inputs at every door for an hour; SEED=n, SECONDS=n
	$(BIN)/python -m tests.faults.fuzz --seconds $(or $(SECONDS),3600) --seed $(or $(SEED),1)

calls: $(VENV)/installed-test              ## 1e9 random FMI calls of the native units; goes on where it was stopped; COUNT=n, SEED=n
	$(BIN)/python -m tests.faults.calls --count $(or $(COUNT),1e9) --seed $(or $(SEED),1)

bench: $(VENV)/installed-bench             ## all benchmarks in one run -> docs/benchmarks.json and its page
	$(BIN)/python benchmarks/run_all.py

docs: $(VENV)/installed-docs               ## the pages made from units, scenes, benchmarks and docstrings -> site/
	$(BIN)/python docs/make_units.py
	$(BIN)/python benchmarks/scenes.py
	$(BIN)/python docs/make_scenes.py
	$(BIN)/python docs/make_reports.py
	$(BIN)/python benchmarks/page.py
	$(BIN)/python docs/make_api.py
	$(BIN)/mkdocs build --strict --quiet

wheel: $(VENV)/installed                   ## a wheel with scenes and Python FMUs in dist/; staged, so that no FMU stays here
	rm -rf build/wheel
	mkdir -p build/wheel
	cp -RL towage pyproject.toml README.md LICENSE build/wheel
	$(BIN)/python build_fmus.py --out build/wheel/towage/shipped
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist build/wheel

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

$(VENV)/installed-bench: $(VENV)/installed-test
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[native,bench]'
	touch $@

$(VENV)/installed-docs: $(VENV)/created pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	touch $@ $(VENV)/installed

dist/built: $(VENV)/installed build_fmus.py $(shell find models fmus -name "*.py")
	$(BIN)/python build_fmus.py
	touch $@

clean:
	rm -rf $(VENV) dist out build site *.egg-info
