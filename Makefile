# `make` sets up everything in .venv and draws every figure of the paper; `make help` lists the rest.

PYTHON ?= python3
ENVIRONMENT := .venv
BIN := $(ENVIRONMENT)/bin
# Python compiles a module when it is first imported; compiling all modules of all packages would take half a minute. The
# locks are complete, so that nothing has to be resolved.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --no-deps --require-hashes
# Two halves of a lock are unpacked at once: pip itself uses one processor.
define install_lock
	awk '/^[a-z0-9]/ { n++ } { print > "$(ENVIRONMENT)/half-" n % 2 ".lock" }' $(1)
	printf '%s\n' 0 1 | xargs -P 2 -I '{}' $(INSTALL) --requirement '$(ENVIRONMENT)/half-{}.lock'
endef
CORES ?= 2
SNAKEMAKE := $(BIN)/snakemake -c$(CORES)
# Datasets go into and come out of a shared cache only where the reader names one. The option comes last, because it would
# take a target after it for the name of a rule.
CACHE := $(if $(SNAKEMAKE_OUTPUT_CACHE),--cache)
# The peers of the benchmarks pin old packages, so they live apart from the environment that draws the figures.
BENCHMARK_ENVIRONMENT := .venv-benchmark
BENCHMARK_BIN := $(BENCHMARK_ENVIRONMENT)/bin
FORMATTED_RULES := Snakefile $(wildcard workflow/rules/*.smk)

# Python keeps what it compiles, whatever the caller's shell forbids: without that, every process of the workflow and of the
# tests would compile numpy, scipy and matplotlib anew.
export PYTHONDONTWRITEBYTECODE :=

# When make was called, so that `all` can say how long its parts took.
export STARTED := $(shell date +%s)

.DEFAULT_GOAL := all
.PHONY: all env development docs test test-slow test-workflow test-faults test-slurm test-versions lint style types format check bench slurm studio lock clean help

all: env ## set up, then draw every figure (snakemake -c2 all)
	@installed=$$(date +%s); \
	$(SNAKEMAKE) paper $(CACHE) && paper=$$(date +%s) && $(SNAKEMAKE) all $(CACHE) && \
	echo 'Figures, their numbers and the claims are in paper_figs/.' && \
	echo "Seconds: installation $$((installed - STARTED)), the paper $$((paper - installed))," \
	  "everything $$(($$(date +%s) - installed)) ($(CORES) cores)."

env: $(ENVIRONMENT)/.installed ## only set up .venv from the hashed lock

# The stamp is written last, so that an interrupted installation is taken up again.
$(ENVIRONMENT)/.installed: requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("camid needs Python 3.11 or newer; call make PYTHON=python3.x") if sys.version_info < (3, 11) else None'
	test -x $(BIN)/python || $(PYTHON) -m venv $(ENVIRONMENT)
	$(call install_lock,requirements.lock)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	$(BIN)/python -m camid.compile_all
	touch $@

# What the tests, the linters and the documentation need in addition.
development: $(ENVIRONMENT)/.development

$(ENVIRONMENT)/.development: requirements-development.lock $(ENVIRONMENT)/.installed
	$(call install_lock,requirements-development.lock)
	touch $@

# Whole files go to a worker, so that what a file computes for all its tests is computed once.
PYTEST := $(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder

test: development ## run the tests, in minutes
	$(PYTEST)

test-slow: development ## run the tests with large samples, many seeds and the whole catalogue
	$(PYTEST) -m slow

# The page of the studio and the report are looked at in a Chromium, which the system has to have.
test-workflow: development studio ## run the whole workflow in fresh copies, what it promises, the notebook and the studio
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --requirement requirements-browser.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --requirement requirements-notebook.lock
	$(BIN)/python -m pytest -m workflow

test-faults: development ## kills, full disks, damaged data, wrong clocks, hostile files: half an hour, counts printed
	-$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps --requirement requirements-faults.lock
	$(BIN)/python -m tests.faults

test-slurm: slurm development ## a real Slurm on this machine (superuser, Debian's packages): same bytes, jobs and node killed
	$(BIN)/python -m tests.slurm

test-versions: development ## the tests with the oldest and newest packages, on each Python that there is (needs uv)
	$(BIN)/python -m tests.versions

# Two at a time where make is called with -j2.
lint: style types docs ## ruff, snakefmt, mypy, import-linter, and the documentation built strictly

style: development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check $(FORMATTED_RULES)
	$(BIN)/lint-imports

types: development
	$(BIN)/mypy

format: development ## let the formatters rewrite the sources
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt $(FORMATTED_RULES)

check: env ## draw every figure from nothing, then compare with config/tolerances.yaml
	$(SNAKEMAKE) --forceall check

docs: development ## build the documentation into results/site, with the committed claims, ablations and proof
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo 'The documentation is in results/site/index.html.'

bench: $(BENCHMARK_ENVIRONMENT)/.installed ## compare speed and error with other tools, side by side; writes docs/benchmarks.md
	$(BENCHMARK_BIN)/python -m benchmarks

$(BENCHMARK_ENVIRONMENT)/.installed: requirements-benchmark.lock pyproject.toml
	test -x $(BENCHMARK_BIN)/python || $(PYTHON) -m venv $(BENCHMARK_ENVIRONMENT)
	$(BENCHMARK_BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-benchmark.lock
	$(BENCHMARK_BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

slurm: env ## let Snakemake send its jobs to Slurm (snakemake --profile workflow/profiles/slurm)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-slurm.lock

studio: env ## install what `camid studio` needs besides (then: .venv/bin/camid studio)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --requirement requirements-studio.lock

COMPILE := uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-annotate \
  --custom-compile-command "make lock"

lock: ## renew the hashed locks (needs uv)
	$(COMPILE) --extra workflow --extra build pyproject.toml --output-file requirements.lock
	$(COMPILE) --extra workflow --extra development --constraint requirements.lock pyproject.toml \
	  --output-file requirements-development.lock
	$(COMPILE) --extra benchmark pyproject.toml --output-file requirements-benchmark.lock
	$(COMPILE) --extra slurm --constraint requirements.lock pyproject.toml --output-file requirements-slurm.lock
	$(COMPILE) --extra studio --constraint requirements-development.lock pyproject.toml --output-file requirements-studio.lock
	$(COMPILE) --extra browser --constraint requirements-development.lock pyproject.toml --output-file requirements-browser.lock
	$(COMPILE) --extra faults --constraint requirements-development.lock pyproject.toml --output-file requirements-faults.lock
	$(COMPILE) --extra notebook --constraint requirements-development.lock pyproject.toml --output-file requirements-notebook.lock

clean: ## remove what the workflow computed; the committed figures stay
	rm -rf results .snakemake

help:
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16
