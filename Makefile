# Everything is done in .venv, which is made when it is needed and made again when pyproject.toml changes.
# `make demo` needs Python 3.11 or newer and nothing else; PYTHON=/path/to/python chooses one.

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules
# Hundreds of tests start turtlewire: each would read all of its source anew.
unexport PYTHONDONTWRITEBYTECODE

BIN := .venv/bin
RUNTIME := .venv/.stamp-runtime
DEV := .venv/.stamp-dev
BENCH := .venv/.stamp-bench
IS_RECENT := 'import sys; sys.exit(sys.version_info < (3, 11))'
PIP_INSTALL := $(BIN)/python -m pip install -qq --disable-pip-version-check --no-input
PICTURES := $(patsubst examples/%.logo,docs/pictures/%.svg,$(wildcard examples/*.logo))

ifeq ($(origin PYTHON),undefined)
PYTHON := $(firstword $(foreach name,python3 python3.14 python3.13 python3.12 python3.11,\
            $(shell $(name) -c $(IS_RECENT) 2>/dev/null && echo $(name))) python3)
endif

# What the tests need, as Debian calls it. Those of the firmware: compilers for here and for the chip, the emulated chip, what
# looks at the source, a fuzzer. UCBLogo, whose example programs run here, too. A browser for the console.
PACKAGES := g++ gcc-avr avr-libc binutils-avr arduino-core-avr arduino-builder avrdude libsimavr-dev libelf-dev clang \
            clang-tidy cppcheck libclang-rt-dev ucblogo chromium
FUZZER := $(or $(wildcard /usr/lib/llvm-*/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a),/usr/lib/libclang_rt.fuzzer.a)
NEEDED := $(addprefix /usr/,bin/g++ bin/avr-g++ bin/avr-size bin/avrdude bin/arduino-builder \
            lib/avr/include/avr/io.h share/arduino/hardware/arduino/avr/platform.txt include/simavr/sim_avr.h include/libelf.h \
            bin/clang++ bin/clang-tidy bin/cppcheck share/ucblogo/csls/student bin/chromium) $(firstword $(FUZZER))

# C++ that people write: what is generated has no layout to speak of.
CODE := $(shell grep -L 'do not edit' $$(find firmware -name '*.h' -o -name '*.cpp' -o -name '*.ino'))

.PHONY: help demo test check tools firmware format nightly mutate bench generate pictures clean

help: ## say what can be made
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' Makefile | expand -t 18

demo: $(RUNTIME) ## let a simulated robot draw a rose, over its wire protocol
	@$(BIN)/turtlewire run examples/rose.logo --picture rose.svg --picture rose.png

test: check tools ## check, see that generated files are current, and run the tests
	@$(BIN)/python -m tools.generate --check
	@$(BIN)/python -m tools.firmware build/firmware
	@# A browser's tests in processes of their own: what drives it has an event loop run in the main thread for good.
	@$(BIN)/python -m pytest -q -m "not nightly" --numprocesses auto --dist loadfile tests/console
	@$(BIN)/python -m pytest -q -m "not nightly" --numprocesses auto --dist worksteal --ignore tests/console

check: $(DEV) ## formatting, lint, types and the layering of the modules
	@$(BIN)/ruff format --quiet --check . || { echo 'run `make format`' >&2; exit 1; }
	@$(BIN)/clang-format --dry-run -Werror $(CODE) || { echo 'run `make format`' >&2; exit 1; }
	@$(BIN)/ruff check --quiet .
	@$(BIN)/mypy --no-error-summary
	@$(BIN)/lint-imports --no-logo > .venv/lint-imports.log || { cat .venv/lint-imports.log; exit 1; }
	@echo 'format, lint, types and layers: fine'

tools:
	@for needed in $(NEEDED); do [ -e "$$needed" ] || missing="$$missing $$needed"; done; \
	[ -z "$$missing" ] || { \
	  sudo=; [ "$$(id -u)" -eq 0 ] || sudo='sudo -n'; \
	  command -v apt-get >/dev/null && $$sudo true 2>/dev/null \
	    || { echo "the tests need$$missing: on Debian, apt install $(PACKAGES)" >&2; exit 1; }; \
	  echo "installing what the tests need" >&2; apt="$$sudo apt-get -qq -o DPkg::Lock::Timeout=900"; \
	  { $$apt update && $$apt install --yes --no-install-recommends $(PACKAGES); } >/dev/null; }

firmware: $(DEV) tools ## build the sketches for the Uno into build/firmware, within firmware/budgets.toml
	@$(BIN)/python -m tools.firmware build/firmware

format: $(DEV) ## format the Python code, and the C++ of the firmware
	@$(BIN)/ruff format --quiet .
	@$(BIN)/clang-format -i $(CODE)
	@$(BIN)/ruff check --quiet --fix .

nightly: $(DEV) tools ## the long tests: ten million inputs for each decoder, 10^8 for the core, mutation, soaks
	@$(PIP_INSTALL) --editable '.[console,dev,fuzz]'
	@$(BIN)/python -m pytest -q -m nightly
	@for robot in simple frame walter; do $(BIN)/python -m tests.soak $$robot || exit 1; done
	@$(BIN)/python -m tools.mutation

mutate: $(DEV) tools ## make small mistakes in the firmware's core, and see that its tests notice each of them
	@$(BIN)/python -m tools.mutation

bench: $(BENCH) ## measure against the peers
	@for benchmark in benchmarks/*.py; do $(BIN)/python "$$benchmark" || exit 1; done

generate: $(DEV) ## make the files again that are made from the specification
	@$(BIN)/python -m tools.generate

pictures: $(PICTURES) docs/pictures/drive.svg docs/pictures/console-drive.png ## draw every example, the dashboard and the console, into docs/pictures

docs/pictures/drive.svg: tools/dashboard_picture.py $(DEV)
	@$(BIN)/python -m tools.dashboard_picture > $@

docs/pictures/console-drive.png: tools/console_pictures.py $(DEV)
	@$(BIN)/python -m tools.console_pictures $(@D)

docs/pictures/%.svg: examples/%.logo $(RUNTIME)
	@mkdir -p $(@D)
	@$(BIN)/turtlewire run $< --picture $@ $(RUN_OPTIONS)

docs/pictures/maze.svg: RUN_OPTIONS = --port 'sim:walter?arena=examples/maze.toml'

clean: ## remove everything that can be made again
	@rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .coverage build dist
	@rm -f rose.svg rose.png
	@find src tests tools benchmarks -type d -name __pycache__ -prune -exec rm -rf {} +

$(RUNTIME): pyproject.toml
	@$(make_environment)
	@$(PIP_INSTALL) --editable .
	@touch $@

$(DEV): pyproject.toml
	@$(make_environment)
	@$(PIP_INSTALL) --editable '.[console,dev]'
	@touch $@ $(RUNTIME)

$(BENCH): $(DEV)
	@$(PIP_INSTALL) --editable '.[bench,console,dev]'
	@touch $@

# A working .venv is kept and only brought up to date. Debian keeps venv in a package of its own: installed
# where nobody is there to be asked (CI) and it is allowed, otherwise named.
define make_environment
set -e; \
if $(BIN)/python -c $(IS_RECENT) 2>/dev/null && $(BIN)/python -m pip --version >/dev/null 2>&1; then \
  echo 'bringing the environment in .venv up to date' >&2; exit 0; \
fi; \
if ! $(PYTHON) -c $(IS_RECENT) 2>/dev/null; then \
  echo 'turtlewire needs Python 3.11 or newer, and $(PYTHON) is not: install one,' \
    'or name it: make PYTHON=/path/to/python3.11 ...' >&2; exit 1; \
fi; \
if ! $(PYTHON) -c 'import ensurepip, venv' 2>/dev/null; then \
  package='$(notdir $(PYTHON))-venv'; sudo=; [ "$$(id -u)" -eq 0 ] || sudo='sudo -n'; \
  if [ -n "$$CI" ] && command -v apt-get >/dev/null && $$sudo true 2>/dev/null; then \
    $$sudo apt-get update -qq && $$sudo apt-get install -qq --yes "$$package" >/dev/null; \
  else \
    echo "this Python cannot make virtual environments: install its venv module" \
      "(on Debian and Ubuntu: sudo apt install $$package)" >&2; exit 1; \
  fi; \
fi; \
echo 'making the environment in .venv' >&2; \
$(PYTHON) -m venv --clear --upgrade-deps .venv
endef
