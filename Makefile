# On a fresh machine with python3, python3-venv and make, each target sets up what it needs (see tools/bootstrap.sh).
PYTHON ?= python3
WORKERS ?= 2
SEED ?= 2000
COUNT ?= 200
BIN := .venv/bin
READY := .venv/.ready

.PHONY: help setup demo test test-slow test-times check pages docs blind blind-jumps blind-rigs blind-servos blind-next rigs tune bench robustness laws universal mutants architecture matrix scale removal fuzz fuzz-files kill format example lock clean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-11s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: $(READY)  ## the environment in .venv, from the locked versions

$(READY): requirements.txt pyproject.toml tools/bootstrap.sh
	@sh tools/bootstrap.sh $(PYTHON)

demo: $(READY)  ## the main job on the built-in example: from recorded motion to a printable leg
	rm -rf demo
	$(BIN)/synth init leg demo/project
	$(BIN)/synth leg demo/project/leg-design.yaml --out demo/result
	@echo "The report: $(CURDIR)/demo/result/report.html"

check: $(READY)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: export PYTHONDONTWRITEBYTECODE :=  # hundreds of processes are started: a third of a start is to compile our modules
test: $(READY)  ## style, types and all tests but the slowest repeats
	@sh tools/check_and_compile.sh
	@# A module stays in one process: its designs are made once. The longest modules run first (tests/conftest.py).
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder --junit-xml build/tests.xml

test-slow: $(READY)  ## the tests too long for make test: real rigs, other seeds, other scales
	$(BIN)/python -m pytest -m slow -n $(WORKERS)

test-times: $(READY)  ## after make test: record which modules of tests take longest, so that they run first
	$(BIN)/python tools/long_modules.py

pages: $(READY)  ## every command's page in Chromium (apt-get install chromium): build/pages, pictures beside them
	@$(BIN)/python -c 'import playwright' 2>/dev/null || $(BIN)/python -m pip install --quiet playwright
	PYTHONPATH=. $(BIN)/python tools/pages.py

docs: $(READY)  ## the documentation as web pages: build/docs/index.html (Sphinx is installed once)
	@$(BIN)/python tools/docs.py

blind: SEED = 3000
blind: $(READY)  ## the check with the effect withheld: COUNT cases of seed SEED; stopped, it goes on from where it was
	PYTHONPATH=tests $(BIN)/python -m blind --seed $(SEED) --count $(COUNT) --to build/blind --workers $(WORKERS)

blind-jumps: $(READY)  ## the same on jumps of a driven leg: 48 cases of seed SEED, build/blind-jumps
	PYTHONPATH=tests $(BIN)/python -m blind.jumps --seed $(SEED) --count 48 --to build/blind-jumps --workers $(WORKERS)

blind-rigs: SEED = 4300
blind-rigs: $(READY)  ## the same on dirty rigs: one main cause, small ones, wrong numbers: COUNT cases of seed SEED
	PYTHONPATH=tests $(BIN)/python -m blind.rigs --seed $(SEED) --count $(COUNT) --to build/blind-rigs --workers $(WORKERS)

blind-servos: SEED = 5400
blind-servos: COUNT = 40
blind-servos: $(READY)  ## the same on legs that position servos drive: COUNT (40) cases of seed SEED, build/blind-servos
	PYTHONPATH=tests $(BIN)/python -m blind.servos --seed $(SEED) --count $(COUNT) --to build/blind-servos --workers $(WORKERS)

blind-next: SEED = 6000
blind-next: COUNT = 24
blind-next: $(READY)  ## does the suggested command name more causes than a chirp? COUNT (24) servo-driven legs: build/blind-next
	PYTHONPATH=tests $(BIN)/python -m blind.next_command --seed $(SEED) --count $(COUNT) --to build/blind-next --workers $(WORKERS)

rigs: $(READY)  ## what dominates on six real rigs of ../shared, from each half; known faults put into real recordings: build/rigs
	PYTHONPATH=tests $(BIN)/python -m real_rigs --to build/rigs
	PYTHONPATH=tests $(BIN)/python -m real_rigs.planted
	PYTHONPATH=tests $(BIN)/python -m real_rigs.planted large
	PYTHONPATH=tests $(BIN)/python -m real_rigs.planted_driven

tune: SEED = 1000
tune: $(READY)  ## what the odds of the diagnosis rest on: its numbers varied one by one on COUNT cases of seed SEED
	PYTHONPATH=tests $(BIN)/python -m blind.tune --seed $(SEED) --count $(COUNT) --to build/blind --workers $(WORKERS)

tune-rigs: SEED = 4200
tune-rigs: COUNT = 80
tune-rigs: $(READY)  ## the same far above the noise, on COUNT (80) dirty rigs of seed SEED
	PYTHONPATH=tests $(BIN)/python -m blind.tune_rigs --seed $(SEED) --count $(COUNT) --to build/blind-rigs --workers $(WORKERS)

bench: $(READY)  ## speed, beside other engines in the same run: build/bench/bench.html (BENCH=--hopper: the jumping leg too)
	PYTHONPATH=tests $(BIN)/python -m bench.report --to build/bench $(BENCH)

matrix: $(READY)  ## a test of each room with Python 3.11, 3.12, 3.13, locked and lowest versions (TESTS=tests: all): build/matrix
	$(BIN)/python tools/matrix.py --to build/matrix --workers $(WORKERS) $(TESTS)

scale: PROJECTS = 300
scale: TRIALS = 1000
scale: ROWS = 1000000
scale: PARTS = 100000
scale: DESIGNS = 1000000
scale: SHARE = 1
scale: $(READY)  ## time and memory of PROJECTS, TRIALS, ROWS, PARTS, DESIGNS at 1/4, 1/2, 1 (SHARE=0.01: of each; CASES=fits,rows): build/scale
	PYTHONPATH=tests:. $(BIN)/python -m scale --to build/scale --share $(SHARE) $(if $(CASES),--cases $(CASES)) --fits $(PROJECTS) \
		--gaps $(PROJECTS) --trials $(TRIALS) --rows $(ROWS) --parts $(PARTS) --designs $(DESIGNS)

removal: COUNT = 200
removal: SEED = 1
removal: $(READY)  ## choosing without a part against what choosing with it had listed: COUNT (200) random projects from seed SEED on
	PYTHONPATH=tests $(BIN)/python -m design.removal $(COUNT) $(SEED)

fuzz: COUNT = 300
fuzz: $(READY)  ## COUNT (300) random joints from seed SEED, each built and checked in its own process: build/fuzz
	$(BIN)/python tools/fuzz_joints.py --seed $(SEED) --count $(COUNT) --workers $(WORKERS) --to build/fuzz

mutants: $(READY)  ## do the tests notice a wrong formula? forty single changes of the core, at least 95 % caught: build/mutants
	$(BIN)/python tools/mutants.py --to build/mutants --workers $(WORKERS)

reference: $(READY)  ## pages and JSON Schemas of all files, from the schema classes: docs/reference
	$(BIN)/python tools/reference.py

architecture: $(READY)  ## draw the packages from their imports: docs/architecture.svg
	$(BIN)/python tools/architecture.py

fuzz-files: COUNT = 2000
fuzz-files: $(READY)  ## COUNT (2000) damaged projects, tables and command lines of seed SEED, each run in its own process: build/fuzz-files
	PYTHONPATH=tests $(BIN)/python -m fuzzing --seed $(SEED) --count $(COUNT) --workers $(WORKERS) --to build/fuzz-files

kill: COUNT = 40
kill: SEED = 1
kill: $(READY)  ## COUNT (40) kills at random moments over gap, leg, folder, sweep and cluster: same bytes, no litter: build/kill
	PYTHONPATH=tests:. $(BIN)/python -m kills --count $(COUNT) --seed $(SEED) --to build/kill

universal: COUNT = 500
universal: $(READY)  ## one cost for every response: ours against the thesis' on COUNT (500) random legs: build/universal; goes on from where it was
	PYTHONPATH=tests $(BIN)/python -m robustness.universal --count $(COUNT) --to build/universal --workers $(WORKERS)

laws: SEED = 985000
laws: COUNT = 40
laws: $(READY)  ## the fit of legs that rub, with quadratic damping, driven by a hand, and free: COUNT (40) each of seed SEED: build/laws
	PYTHONPATH=tests $(BIN)/python -m robustness.laws --seed $(SEED) --count $(COUNT) --to build/laws

robustness: COUNT = 500
robustness: SEED = 1
robustness: $(READY)  ## how often the fit is right: COUNT (500) random legs of seed SEED, with figures: build/robustness; goes on from where it was
	PYTHONPATH=tests $(BIN)/python -m robustness --seed $(SEED) --count $(COUNT) --to build/robustness --workers $(WORKERS)

format: $(READY)  ## let ruff mend the style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

example: $(READY)  ## make the built-in examples again
	$(BIN)/python tools/make_example.py

lock:  ## choose and lock package versions again (UPGRADE=--upgrade for the newest)
	@PYTHON=$(PYTHON) sh tools/lock.sh $(UPGRADE)

clean:  ## everything that can be made again, the environment too
	rm -rf .venv build dist demo .mypy_cache .ruff_cache .pytest_cache .hypothesis
