# Needs Python 3.11, 3.12, 3.13 or 3.14, git and make; all else goes into .venv.

.DELETE_ON_ERROR:
.PHONY: run test test-thorough test-all test-interop test-browser test-playground studio-page playground site test-site site-version lint check newcomer bench bench-meltingpot gpu gpu-page gpu-model damage fuzz golden docs notebooks results diagrams wheel-test types clean

PYTHON ?= $(shell for p in python3.13 python3.14 python3.12 python3.11 python3; do \
  if $$p -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' 2>/dev/null; \
  then echo $$p; break; fi; done)
BIN := .venv/bin
export NO_MKDOCS_2_WARNING := 1
# The commands that tests start would each compile all of Python's modules anew.
unexport PYTHONDONTWRITEBYTECODE
RUN := runs/first
# A file is one worker's: what its tests share is made once. Files come in the order of tests/conftest.py: the longest first.
PYTEST := $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder
BENCH := $(BIN)/python -m bench.speed
ENVS ?= 1,128,1024,4096
NINE := coins harvest_open harvest_closed harvest_partnership clean_up coop_mining gift_refinement mushrooms pd_arena
OURS := ferry reputation stag_chase
PAGE := --markdown docs/research/speed_tables.md
# A Python whose JAX sees a GPU, with the packages of pyproject.toml.
GPU_PYTHON ?= python3
# `make gpu` stops after so long, and keeps the figures that it has by then, and those of earlier runs.
GPU_MINUTES ?= 9
GPU_MODEL := build/gpu-model/.venv/bin/python -W ignore bench/gpu_model.py --json bench/gpu_model.json
# Some shells look for the first name alone that `command -v` is given.
CHROMIUM := command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null || \
  apt-get install -y --no-install-recommends chromium || { echo 'these tests want Chromium: apt-get install chromium'; exit 1; }
# Where the playground's visitors load Pyodide from, if it is not part of the build: cdn, or a URL.
PYODIDE ?=

# The quickest tour: a game as Python, as pictures, and learnt by agents.
run: .venv/ready
	rm -rf $(RUN)
	mkdir -p $(RUN)
	$(BIN)/sjdsl compile games/clean_up.sj
	$(BIN)/sjdsl render clean_up --steps 60 -o $(RUN)/clean_up.gif
	$(BIN)/sjdsl train coins --preset two_cores --reward common --run $(RUN)/coins --episodes 0
	$(BIN)/sjdsl render coins --policy $(RUN)/coins --steps 60 -o $(RUN)/coins.gif
	$(BIN)/sjdsl evaluate $(RUN)/coins

test: .venv/ready
	$(PYTEST)

# The long tests that `make test` leaves out: whole runs, sweeps, pages of code, chances of the games.
test-thorough: .venv/ready
	$(PYTEST) --thorough
	$(PYTEST) --gpu-forms tests/differential tests/laws

# Also every variant and crowd, with XLA's optimisations: takes much longer.
test-all: .venv/ready
	$(PYTEST) --all

# The path of a newcomer, timed: from `pip install` of the wheel to a changed rule that moves, under two minutes.
newcomer: .venv/ready
	$(BIN)/python -m tests.packaging.newcomer

# The adapters for other libraries, which are installed for it.
test-interop: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-interop.txt
	$(PYTEST) -o addopts=-q tests/interop

# Pages, in a headless Chromium: the one that is installed, or else Debian's, which takes root.
test-browser: .venv/ready
	@$(CHROMIUM)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-browser.txt
	$(PYTEST) -o addopts=-q tests/browser

# The script of the studio's page, from editors/studio; needs npm.
studio-page:
	cd editors/studio && npm ci --no-audit --no-fund && npm run build

# docs/ and what is made from the code, as a site with search: build/site/index.html. Pictures of games are drawn once, into build/site-boards.
site: .venv/site
	$(BIN)/python -m mkdocs build

# Builds the site and checks its links, its reference and its gallery.
test-site: site
	$(PYTEST) -o addopts=-q -n 0 tests/site

# Puts the site of a version on the branch gh-pages, beside those of others: make site-version VERSION=0.1. Nothing is pushed.
site-version: .venv/site
	@test -n "$(VERSION)" || { echo "name the version: make site-version VERSION=0.1"; exit 1; }
	PATH="$(CURDIR)/$(BIN):$$PATH" PYTHONPATH=. mike deploy --update-aliases $(VERSION) latest
	PATH="$(CURDIR)/$(BIN):$$PATH" PYTHONPATH=. mike set-default latest

.venv/site: .venv/ready requirements-site.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-site.txt
	@touch $@

# Runs the notebooks of examples/ and keeps their outputs in them.
notebooks: .venv/ready
	$(BIN)/python -m tests.notebooks.keep

# The studio as static files that need no server, in build/playground; needs npm and Node. With PYODIDE=cdn, visitors load Pyodide from a
# public server.
playground: .venv/ready
	cd editors/playground && npm ci --no-audit --no-fund
	$(BIN)/python editors/playground/build.py build/playground $(if $(PYODIDE),--pyodide $(PYODIDE))

# Builds the playground with all its files, and uses it in a headless Chromium.
test-playground: .venv/ready
	@$(CHROMIUM)
	$(MAKE) playground PYODIDE=
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-browser.txt
	$(BIN)/python -m pytest -o addopts=-q tests/browser/test_playground.py

# mypy finds `sjdsl.trainers` where it is when installed: inside sjdsl.
types: .venv/ready
	rm -rf build/types
	mkdir -p build/types/sjdsl
	ln -s $(CURDIR)/sjdsl/* build/types/sjdsl/
	ln -s $(CURDIR)/trainers build/types/sjdsl/trainers
	cd build/types && ../../$(BIN)/mypy --config-file ../../pyproject.toml -p sjdsl

# Layout, lint, and that what is generated is up to date.
lint: .venv/ready
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/sjdsl fmt --check games tests/cases tests/differential tests/runtime tests/statistics
	$(BIN)/sjdsl compile games/*.sj --check
	$(BIN)/python -m bench.game_pages --check

check: types lint
	$(PYTEST)

# As many random programs as one likes, each in every way it can be compiled; what fails is made small and kept in runs/fuzz.
fuzz: .venv/ready
	$(BIN)/python -m tests.fuzz.campaign --examples $(or $(EXAMPLES),2000) --seed $(or $(SEED),0) --coverage

# Writes the tables of docs/research/speed_tables.md again; they are worth something on a machine with nothing else to do.
bench: .venv/ready
	$(BENCH) race $(NINE) --envs $(ENVS) --crowd --observation tokens,onehot --json runs/bench/race.json
	$(BENCH) training $(NINE) --hours 1e9 --repeats 3 --json runs/bench/training.json
	$(BENCH) training coins clean_up harvest_open --networks mlp,cnn --repeats 3 --json runs/bench/networks.json
	$(BENCH) training coins clean_up --algorithms ippo,mappo,vdn --sharings shared,per_agent --hours 1e9 --repeats 3 --json runs/bench/algorithms.json
	$(BENCH) sweep harvest_open regrow_3 --values 64 --json runs/bench/regrow.json
	$(BENCH) sweep pd_arena payoff --values 64 --json runs/bench/payoff.json
	JAX_NUM_CPU_DEVICES=2 $(BENCH) race $(NINE) --devices 2 --envs 128,1024,4096 --json runs/bench/devices.json
	$(BENCH) tables runs/bench/*.json $(PAGE)

# The tables of Melting Pot's substrates in docs/research/speed_tables.md. The file is written after each of them: `tables` also reads that of a run
# that was stopped.
bench-meltingpot: .venv/ready
	$(BENCH) substrates --repeats 3 --json runs/substrates.json
	$(BENCH) tables runs/substrates.json $(PAGE)

# Everything that a GPU is needed for, in nine minutes: figures as JSON in runs/gpu, each as soon as it is measured.
gpu:
	@$(GPU_PYTHON) -c 'import jax, sys; sys.exit(0 if jax.default_backend() == "gpu" else "this JAX sees no GPU; name a Python whose JAX does: make gpu GPU_PYTHON=...")'
	@$(GPU_PYTHON) -c 'import sjdsl.trainers' 2>/dev/null || $(GPU_PYTHON) -m pip install --quiet --no-deps --no-build-isolation -e .
	if [ -d runs/gpu ]; then mv runs/gpu runs/gpu-$$(date +%Y%m%d-%H%M%S); fi
	timeout $(GPU_MINUTES)m $(GPU_PYTHON) -m bench.speed everything runs/gpu $(NINE) || test $$? = 124

# The tables of docs/research/speed_tables.md from the figures that `make gpu` has left, on any machine.
gpu-page: .venv/ready
	$(BENCH) tables runs/gpu/*.json $(PAGE)

# What a step costs on a GPU that is not there, counted in what XLA compiles for a described one: needs 6 GB of packages and no GPU, and
# compiles for two hours on one core, or as long as it takes for what has changed. SUITE=CHECKOUT: also the suite's own environments.
gpu-model: build/gpu-model/ready
	$(GPU_MODEL) nine --envs 1024,4096,65536 --observation tokens,onehot
	$(GPU_MODEL) ten --envs 1024,4096,65536 --observation tokens,onehot
	$(GPU_MODEL) nine --envs 4096 --gpu a100
	$(if $(SUITE),$(GPU_MODEL) nine --envs 1024,4096,65536 --only-suite --suite $(SUITE))
	$(if $(SUITE),$(GPU_MODEL) nine --envs 4096 --gpu a100 --only-suite --suite $(SUITE))
	$(GPU_MODEL) coins harvest_open --update mlp,cnn
	$(GPU_MODEL) $(PAGE)

build/gpu-model/ready: requirements.txt
	$(PYTHON) -m venv build/gpu-model/.venv
	build/gpu-model/.venv/bin/python -m pip install --quiet --disable-pip-version-check -r requirements.txt "jax[cuda12]==$$(sed -n 's/^jax==//p' requirements.txt)"
	build/gpu-model/.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps chex==0.1.92 toolz==1.2.0 # of the suite
	build/gpu-model/.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

# What becomes of damaged games, thousands of them: docs/proof.md.
damage: .venv/ready
	$(BIN)/python -m tests.damage.campaign --examples $(or $(EXAMPLES),5000) --seed $(or $(SEED),0)

# Writes again what tests compare to; read the difference before it is committed.
golden: .venv/ready
	$(BIN)/sjdsl compile games/*.sj
	$(BIN)/python -m bench.game_pages
	$(PYTEST) --update-golden

# Writes the pages of the games again: their texts, and what a random policy comes to where the rules have changed.
docs: .venv/ready
	$(BIN)/python -m bench.game_pages

# Writes the tables and pictures of docs/results.md again, from the results in docs/results/data.
results: .venv/ready
	$(BIN)/python -m bench.paper

# Plays the scripted Schelling diagrams of the nine games and of our own again, and writes the tables of docs/schelling.md and its appendix: about 40 minutes.
diagrams: .venv/ready
	mkdir -p runs/diagrams
	for game in $(NINE) $(OURS); do \
	  $(BIN)/sjdsl schelling $$game --cooperators cooperator --defectors defector --episodes 200 -o runs/diagrams/$$game && \
	  mkdir -p docs/schelling/$$game && cp runs/diagrams/$$game/schelling.json runs/diagrams/$$game/schelling.svg docs/schelling/$$game/ || exit 1; \
	done
	$(BIN)/python docs/schelling/tables.py

# Installs the wheel where nothing else is, and uses it far from this folder; with WHEEL=FILE that one, as it has been built.
wheel-test: .venv/ready
	SJDSL_WHEEL="$(abspath $(WHEEL))" $(BIN)/python -m pytest --all tests/packaging

clean:
	rm -rf .venv build dist *.egg-info .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/ready: requirements.txt pyproject.toml
	@test -n "$(PYTHON)" || { echo "no Python 3.11 to 3.14 with venv was found; name one: make PYTHON=/path/to/python"; exit 1; }
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(0 if (3, 11) <= v < (3, 15) else f"{sys.executable} is Python {v[0]}.{v[1]}; 3.11 to 3.14 is needed")'
	$(PYTHON) -m venv .venv
	@# Python compiles modules when they are imported; most of what pip would compile never is.
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -r requirements.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@
