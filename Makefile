# SPDX-License-Identifier: Apache-2.0
# nightmap: the front page. `make` or `make help` shows the commands; configs/pipeline.toml declares the jobs and their files.

ifeq ($(filter grouped-target,$(.FEATURES)),)
$(error nightmap needs GNU Make 4.3 or newer, this is $(MAKE_VERSION))
endif
MAKEFLAGS += --no-builtin-rules --no-builtin-variables --warn-undefined-variables
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := help

## SITE        the building: configs/sites/<site>.toml
SITE ?= demo
## PROFILE     a pipeline and its options, configs/<profile>/; empty: the profile that the site's config names, else default
PROFILE ?=
## SET         single values that replace those of the profile, as in SET="octree.resolution_m=0.1 grid.robot_height_m=1.2"
SET ?=
## SEED        seed of every stage that draws random numbers (a synthetic recording has its own)
SEED ?= 0
## START GOAL  ends of plan and drive: places, queries, objects or things on one floor, see configs/plan/default/plan.toml
START ?=
GOAL ?=
## QUERY       more to localize, as in QUERY="start.jpg goal.jpg": pictures, folders or .txt lists, anywhere; of a laser map, logs of scans
QUERY ?=
## CAMERA      camera of the pictures of QUERY: id of a [[camera]] of the site; empty: cameras.csv or EXIF (datasets.md)
CAMERA ?=
## FOV_DEG     horizontal field of view of those pictures of QUERY that have neither
FOV_DEG ?=
## NEAR        place near which the scans of QUERY were taken, as in NEAR="3.5,-2": x,y in the map, m
NEAR ?=
## NEAR_RADIUS how far from NEAR at most, m; empty: 5
NEAR_RADIUS ?=
## TURN        1 takes the scans of each log of QUERY together: those of a robot that turned on the spot
TURN ?=
## OBJECTS     of use-objects: the file that was drawn on the page of SITE
OBJECTS ?=
## STRICT      1 lets a map that its verdict says not to use end the run with an error
STRICT ?= 0
## DATA        folder of the recordings (datasets.md lists their sources)
DATA ?= data
## MAPS        folder of the results: MAPS/<site>/<job>/
MAPS ?= maps
## LAUNCH      prefix of every program's command; scripts/on_slurm.sh runs it on a cluster (docs/cluster.md)
LAUNCH ?=
## THREADS     threads per program, by default the cores of this machine, or 4 with LAUNCH; no result depends on it
THREADS ?= $(if $(value LAUNCH),4,$(shell nproc))
## LOG_LEVEL   debug, info, warn, err or off
LOG_LEVEL ?= info
## V           1 prints the whole command of every program
V ?= 0
## CASES       cases of bench: SITE or SITE:N, separated by spaces
CASES ?= $(SITE)
## FIGURES     of figures: names of tables; without it all but those that take hours
FIGURES ?=
## BUILD       folder of the programs
BUILD ?= build
## SITES       folder of the site configs
SITES ?= configs/sites
## PYTHON      command of the Python interpreter
PYTHON ?= /usr/bin/python3
## SANITIZED   of test-sanitize: groups of tests, separated by |; `.` stands for all
SANITIZED ?= base|program|io|recording|dense|plan|laser
include scripts/variables.mk

M := $(MAPS)/$(SITE)
ifneq ($(and $(filter clean distclean,$(MAKECMDGOALS)),$(word 2,$(MAKECMDGOALS))),)
$(error run `make $(filter clean distclean,$(MAKECMDGOALS))` alone)
endif

# ---- a site -------------------------------------------------------------------------------------
# scripts/make_site.py writes the rules of the site to maps/<site>/graph.mk and runs make on them, once for all goals.
# [goals] of the declared pipeline and of the profiles.
GOALS := $(shell sed -snE '/^\[goals\]/,/^$$/s/^([a-z][a-z-]*) = .*/\1/p' configs/pipeline.toml $(wildcard configs/*/pipeline.toml))
# The recipes' shell; the calls of programs above are quicker without it.
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
OF_SITE := $(GOALS) why status
ASKED := $(filter $(OF_SITE) $(M)/% $(DATA)/%,$(MAKECMDGOALS))
.PHONY: help deps build demo inspect use-objects $(OF_SITE) the_site verify clean distclean $(filter $(M)/% $(DATA)/%,$(MAKECMDGOALS))
# It also builds the programs of the site first. Without options for a shell, make starts Python without one: every make does this.
the_site: private SHELL := /bin/sh
the_site: private .SHELLFLAGS := -c
the_site:
	+@$(PYTHON) -I -S scripts/make_site.py $(ASKED)
# Under -q there is no recipe: make would report it as work to do. With plain flags make runs `:` without a shell.
OF_THE_SITE := $(OF_SITE) $(filter $(M)/% $(DATA)/%,$(MAKECMDGOALS))
$(OF_THE_SITE): private .SHELLFLAGS := -c
$(OF_THE_SITE): the_site
	$(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@:)

why: ## the jobs that `make report` would rerun now, with reasons; with SET: the jobs that this change would rerun
status: ## what a make of SITE does now, from another terminal; else how the last one ended, with a report of what there is

# ---- commands -----------------------------------------------------------------------------------
help: ## this page
	@echo "nightmap: maps a building from the recordings of a robot's RGB-D camera. Commands:"; \
	sed -snE '/^\[goals\]/,/^$$/s/^([a-z][a-z-]*) = \{ purpose = "([^"]*)".*/  make \1 \t\2/p' \
	  configs/pipeline.toml $(wildcard configs/*/pipeline.toml) | expand -t 26; \
	sed -nE 's/^([a-z-]+):[^#]*## (.*)$$/  make \1 \t\2/p' Makefile scripts/development.mk | expand -t 26; \
	echo; echo "Variables (current values below):"; \
	sed -nE 's/^## ([A-Z][A-Z_ ]*) +(.*)$$/  \1 \t\2/p' Makefile | expand -t 14; \
	echo; echo "  SITE=$$SITE PROFILE=$$PROFILE SEED=$$SEED DATA=$$DATA MAPS=$$MAPS THREADS=$$THREADS"; \
	names() { for path; do path=$${path%/}; path=$${path##*/}; [ "$$path" = sites ] || printf ' %s' "$${path%.toml}"; done; }; \
	profiles() { for path in configs/*/pipeline.toml; do case $$(<"$$path") in *"pieces = ["*) names "$${path%/*}";; esac; done; }; \
	shopt -s nullglob; echo "  sites:   $$(names "$$SITES"/*.toml)"; echo "  profiles:$$(profiles)"; echo; \
	echo "Use make why in place of make -n: with grouped targets, -n lists only the first of several stale jobs."

deps: ## install the Debian packages that are missing
	@scripts/install_deps.sh

# On a fresh machine python3 and the compiler are installed first; a second make does the rest.
demo: ## all steps on a synthetic building: install, build, map, localize, drive, evaluate, report
	@echo "demo: installs packages, builds the programs of the site, renders a building, maps it: on two cores of 2.1 GHz 11 minutes the first time (packages 3.5, programs 6), then seconds"
	@scripts/install_deps.sh synthesize
	@$(MAKE) --no-print-directory SITE=demo map localize drive evaluate report
	@echo "demo: open $(MAPS)/demo/report/index.html"

inspect: ## contents of the recordings of SITE: channels, rates, gaps, ranges, overlap in time; runs no job
	@NIGHTMAP_PROGRAMS=inspect $(MAKE) --no-print-directory $(BUILD)/programs.mk
	@$(RUN)/inspect --config configs/recording/default/inspect.toml --in site=$(SITES)/$(SITE).toml --in data=$(DATA) --log-level warn

use-objects: ## give the objects that were drawn on the page of SITE, in the file OBJECTS, to its next make
	@$(PYTHON) scripts/use_objects.py --site $(SITES)/$(SITE).toml --data $(DATA) --profile "$(PROFILE)" -- "$$OBJECTS"

verify: ## hash the artifacts of SITE again and compare them with their receipts
	@$(PYTHON) scripts/verify.py $(M)

clean: ## remove the results of SITE
	@$(PYTHON) scripts/remove_results.py site $(M)

distclean: ## remove the results of every site, the programs, and the synthetic recordings
	@$(PYTHON) scripts/remove_results.py all $(MAPS) $(DATA) $(BUILD) $(BUILD)-sanitize

include scripts/development.mk
