# SPDX-License-Identifier: Apache-2.0
# nightmap: the front page. `make` or `make help` shows the commands; configs/pipeline.toml declares what is made of what.

ifeq ($(filter grouped-target,$(.FEATURES)),)
$(error nightmap needs GNU Make 4.3 or newer, this is $(MAKE_VERSION))
endif
MAKEFLAGS += --no-builtin-rules --no-builtin-variables --warn-undefined-variables
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := help

## SITE        the building: configs/sites/<site>.toml
SITE ?= demo
## PROFILE     a set of configs, configs/<profile>/: default, or what the site's config names
PROFILE ?=
## SET         single values over the profile, as in SET="octree.resolution_m=0.1 grid.robot_height_m=1.2"
SET ?=
## SEED        seed of every stage that draws random numbers (a made-up recording has its own)
SEED ?= 0
## START GOAL  of plan and drive: a place or a query on any one floor, see configs/default/plan.toml
START ?=
GOAL ?=
## QUERY       more pictures to localize, as in QUERY="start.jpg goal.jpg": files, folders or .txt lists, anywhere
QUERY ?=
## CAMERA      of QUERY: id of a [[camera]] of the site; without it their cameras.csv or EXIF says (datasets.md)
CAMERA ?=
## FOV_DEG     of QUERY: horizontal field of view of pictures of which neither says
FOV_DEG ?=
## DATA        folder of the recordings (datasets.md says where to get them)
DATA ?= data
## MAPS        folder of the results: MAPS/<site>/<job>/
MAPS ?= maps
## LAUNCH      put before every program, as in LAUNCH="srun -c 2" on a cluster
LAUNCH ?=
## THREADS     of each program; never changes a result
THREADS ?= $(shell nproc)
## LOG_LEVEL   debug, info, warn, err or off
LOG_LEVEL ?= info
## V           1 prints every program's whole command
V ?= 0
## CASES       of bench
CASES ?= $(SITE)
## FIGURES     of figures: names of tables; without it all but those of COLMAP
FIGURES ?=
## BUILD       folder of the programs
BUILD ?= build
# For tests: other site configs.
SITES ?= configs/sites
PYTHON ?= /usr/bin/python3
export SITE PROFILE SET SEED START GOAL QUERY CAMERA FOV_DEG DATA MAPS LAUNCH THREADS LOG_LEVEL V BUILD SITES PYTHON

M := $(MAPS)/$(SITE)
quote = '$(subst ','\'',$(1))'

ifneq ($(words $(SITE) $(DATA) $(MAPS) $(BUILD))$(findstring /,$(SITE)),4)
$(error SITE, DATA, MAPS and BUILD must each be one word without spaces, and SITE a name without /)
endif
# What Make or a shell would take for more than a letter of a name.
define UNSAFE
: % $$ ' " ; & | ( ) < > * ? [ ] { } \ ` = , # !
endef
ifneq ($(strip $(foreach c,$(UNSAFE),$(findstring $(c),$(SITE)$(DATA)$(MAPS)$(BUILD)))),)
$(error SITE, DATA, MAPS and BUILD must have none of $(strip $(UNSAFE)) in their names: rename the folder or make a link to it)
endif
ifneq ($(and $(filter clean distclean,$(MAKECMDGOALS)),$(word 2,$(MAKECMDGOALS))),)
$(error run `make $(filter clean distclean,$(MAKECMDGOALS))` alone)
endif

# ---- a site -------------------------------------------------------------------------------------
# scripts/make_site.py writes the rules of the site to maps/<site>/graph.mk and runs make on them, once for all goals.
OF_SITE := map localize plan drive evaluate evaluate-colmap report why status
ASKED := $(filter $(OF_SITE) $(M)/% $(DATA)/%,$(MAKECMDGOALS))
.PHONY: help deps build demo inspect $(OF_SITE) the_site verify clean distclean $(filter $(M)/% $(DATA)/%,$(MAKECMDGOALS))
the_site: $(if $(filter why status,$(MAKECMDGOALS)),,$(BUILD)/programs.mk)
	+@$(PYTHON) -I -S scripts/make_site.py $(ASKED)
# (No recipe under -q, which would take it for something to do.)
$(OF_SITE) $(filter $(M)/% $(DATA)/%,$(MAKECMDGOALS)): the_site
	$(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@:)

map: ## the map of SITE: trajectory, cloud, octree, grid, landmarks
localize: ## where each query picture of SITE was taken
plan: ## a path from START to GOAL on the grid
drive: ## the same, and a simulated robot that follows it
evaluate: ## accuracy against the truth of SITE, where there is one
evaluate-colmap: ## queries in COLMAP's map and in this one: accuracy, time, size (slow)
report: ## one page: pictures, time and memory of each job, accuracy, what failed
why: ## what `make report` would rerun now and for what reason; with SET: what that change would rerun
status: ## how the last run of SITE ended; writes the page of what there is, and makes nothing

# ---- commands -----------------------------------------------------------------------------------
help: ## this page
	@echo "nightmap: a map of a building from what a robot's RGB-D camera saw. Commands:"; \
	sed -nE 's/^([a-z-]+):[^#]*## (.*)$$/  make \1 \t\2/p' Makefile scripts/development.mk | expand -t 26; \
	echo; echo "Variables (now):"; \
	sed -nE 's/^## ([A-Z][A-Z_ ]*) +(.*)$$/  \1 \t\2/p' Makefile | expand -t 14; \
	echo; echo "  SITE=$(SITE) PROFILE=$(PROFILE) SEED=$(SEED) DATA=$(DATA) MAPS=$(MAPS) THREADS=$(THREADS)"; \
	echo "  sites:    "$(call quote,$(notdir $(basename $(wildcard $(SITES)/*.toml)))); \
	echo "  profiles: "$(call quote,$(filter-out sites pipeline.toml,$(notdir $(wildcard configs/*)))); echo; \
	echo "make -n lists only the first of several stale jobs (a trait of grouped targets): use make why."

deps: ## install the Debian packages that are missing
	@scripts/install_deps.sh

# On a fresh machine python3 and the compiler come with deps, so the rest is a make of its own after it.
demo: ## everything on a made-up building: install, build, map, localize, drive, evaluate, report
	@scripts/install_deps.sh
	@$(MAKE) --no-print-directory SITE=demo map localize drive evaluate report
	@echo "demo: open $(MAPS)/demo/report/index.html"

inspect: $(BUILD)/programs.mk ## what the recordings of SITE hold: channels, rates, gaps, ranges, overlap in time; makes nothing of them
	@$(RUN)/inspect --config configs/default/inspect.toml --in site=$(SITES)/$(SITE).toml --in data=$(DATA) --log-level warn

verify: ## hash the artifacts of SITE again and compare with their receipts
	@$(PYTHON) scripts/verify.py $(M)

clean: ## remove the results of SITE
	rm -rf $(M)

distclean: ## remove the results of every site, the programs, and the recordings that synthesize made
	rm -rf $(MAPS) $(BUILD) $(BUILD)-sanitize $(patsubst %/.made_by_synthesize,%,$(wildcard $(DATA)/*/.made_by_synthesize))

include scripts/development.mk
