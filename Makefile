# SPDX-License-Identifier: Apache-2.0
# nightmap: what is made of what, and the commands. `make` or `make help` is the front page.

ifeq ($(filter grouped-target,$(.FEATURES)),)
$(error nightmap needs GNU Make 4.3 or newer, this is $(MAKE_VERSION))
endif
# The single-letter flags this make was called with (read before they are added to).
FLAGS := $(filter-out -%,$(firstword $(MAKEFLAGS)))
MAKEFLAGS += --no-builtin-rules --no-builtin-variables --warn-undefined-variables
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
.DEFAULT_GOAL := help

## SITE        the building: configs/sites/<site>.toml
SITE ?= demo
## PROFILE     a set of stage configs: configs/<profile>/<stage>.toml over configs/default
PROFILE ?= default
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
## MAPS        folder of the results: MAPS/<site>/<stage>/
MAPS ?= maps
## LAUNCH      put before every stage's command, as in LAUNCH="srun -c 2" on a cluster
LAUNCH ?=
## THREADS     of each stage; never changes a result
THREADS ?= $(shell nproc)
## LOG_LEVEL   debug, info, warn, err or off
LOG_LEVEL ?= info
## V           1 prints every stage's whole command
V ?= 0
## CASES       of bench
CASES ?= $(SITE)
## BUILD       folder of the programs
BUILD ?= build
# For tests: other site configs, and the sites whose recording the synthesize stage makes.
SITES ?= configs/sites
SYNTHETIC ?= demo building mirror two_floors
PYTHON ?= /usr/bin/python3

M := $(MAPS)/$(SITE)
RUN := $(BUILD)/run
QUIET := $(if $(filter 1,$(V)),,@)
# -n, -q and `why` must change nothing: they look at configs resolved into a folder of their own.
PREVIEW := $(findstring n,$(FLAGS))$(findstring q,$(FLAGS))$(filter why,$(MAKECMDGOALS))
CONFIG := $(M)/$(if $(PREVIEW),.preview,config)
# The last words of a command; none under -q, which would take them for something to do.
say = $(if $(PREVIEW),,echo "$(1)")
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

.PHONY: FORCE help deps build demo map localize plan drive evaluate evaluate-colmap report test test-nightly test-sanitize bench why verify \
        clean distclean format format-check lint

# ---- programs -----------------------------------------------------------------------------------
# Ninja links in place; stages run copies that keep their time while their bytes are the same, so
# that a comment in a source reruns no stage. (No -g in a Release build for the same reason.) The lock is for
# two sites that are made at the same time.
PROGRAMS := $(patsubst stages/%/main.cc,%,$(wildcard stages/*/main.cc))
SOURCES := CMakeLists.txt $(wildcard cmake/*.cmake pipeline/*/*.h pipeline/*/*.cc stages/*/*.h stages/*/*.cc)
missing = $(if $(wildcard $(1)),,FORCE)

$(BUILD)/programs.mk: $(SOURCES) $(foreach p,$(PROGRAMS),$(call missing,$(RUN)/$(p)))
	@mkdir -p $(RUN); exec 9>$(BUILD)/programs.lock; flock 9; touch $@.new; \
	cmake -S . -B $(BUILD) -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null; \
	ninja -j $(THREADS) -C $(BUILD) $(PROGRAMS:%=%_program); \
	for p in $(PROGRAMS); do \
	  cmp -s $(BUILD)/bin/$$p $(RUN)/$$p || { cp $(BUILD)/bin/$$p $(RUN)/$$p.new; mv $(RUN)/$$p.new $(RUN)/$$p; }; \
	done; mv $@.new $@
# Order-only: what a stage compares with is the time of its copy. (programs.mk is empty; goals that run
# stages include it, so that Make builds, starts over, and sees the new times.)
$(PROGRAMS:%=$(RUN)/%): | $(BUILD)/programs.mk

# ---- stages -------------------------------------------------------------------------------------
# A line of the table is: stage, inputs NAME=PATH under maps/<site>/, outputs NAME=FILE under
# maps/<site>/<stage>/. In paths % is the shard or tile at hand, < the shard before it (if any), * every
# shard, @ every tile, ~ the tile at hand and its neighbours.
# `data` is the folder of the recordings: pixels are read from it, frames' hashes stand for them.
# What a stage reads it declares here, and nothing else makes it stale but its program and config. A file
# that another input names is `beside`: the program finds it there.
define TABLE
$(call shard,features,    frames=frames/shard_%.csv cameras=frames/cameras.json data, \
                          features=shard_%.h5)
$(call whole,vocabulary,  features=features/shard_*.h5, \
                          vocabulary=vocabulary.h5)
$(call shard,matches,     frames=frames/shard_<.csv frames=frames/shard_%.csv cameras=frames/cameras.json \
                          features=features/shard_<.h5 features=features/shard_%.h5, \
                          pairs=shard_%.h5)
$(call loops,matches,     frames=frames/shard_*.csv cameras=frames/cameras.json features=features/shard_*.h5 \
                          vocabulary=vocabulary/vocabulary.h5, \
                          loops=loops.h5)
$(call shard,odometry,    frames=frames/shard_<.csv frames=frames/shard_%.csv cameras=frames/cameras.json \
                          features=features/shard_<.h5 features=features/shard_%.h5 pairs=matches/shard_%.h5, \
                          odometry=shard_%.h5 trajectory=shard_%.tum)
$(call whole,pose_graph,  frames=frames/shard_*.csv cameras=frames/cameras.json data features=features/shard_*.h5 \
                          odometry=odometry/shard_*.h5 loops=matches/loops.h5 $(ACCELEROMETER), \
                          graph=graph.g2o trajectory=trajectory.tum keyframes=keyframes.tum cameras=cameras.json loops_csv=loops.csv)
$(call whole,tiles,       frames=frames/shard_*.csv cameras=pose_graph/cameras.json keyframes=pose_graph/keyframes.tum, \
                          tiles=tiles.txt)
$(call whole,landmarks,   frames=frames/shard_*.csv cameras=pose_graph/cameras.json features=features/shard_*.h5 \
                          vocabulary=vocabulary/vocabulary.h5 trajectory=pose_graph/trajectory.tum \
                          keyframes=pose_graph/keyframes.tum, \
                          landmarks=landmarks.h5 \
                          $(foreach f,cameras images points3D,$f.txt=colmap/$f.txt $f.bin=colmap/$f.bin) \
                          database=colmap/database.db)
$(call whole,localize,    queries=frames/queries.csv cameras=frames/query_cameras.json data \
                          configured=frames/cameras.json calibrated=pose_graph/cameras.json \
                          landmarks=landmarks/landmarks.h5 vocabulary=vocabulary/vocabulary.h5, \
                          queries=queries.csv trajectory=queries.tum)
endef
define TABLE_AFTER_TILES
$(call tile,point_cloud,  tile=tiles/tile_%.json cameras=tiles/cameras.json data, \
                          tile_cloud=tile_%.ply)
$(call whole,point_cloud, tile=tiles/tile_@.json tile_cloud=point_cloud/tile_@.ply tile_report=point_cloud/report_@.json, \
                          cloud=cloud.ply)
$(call tile,octree,       tile=tiles/tile_%.json cameras=tiles/cameras.json data cloud=point_cloud/tile_~.ply, \
                          tile_ot=tile_%.ot)
$(call whole,octree,      tile=tiles/tile_@.json tile_ot=octree/tile_@.ot tile_report=octree/report_@.json, \
                          ot=map.ot bt=map.bt)
$(call whole,grid,        octree=octree/map.ot keyframes=pose_graph/keyframes.tum, \
                          floors=floors.json pgm=map.pgm yaml=map.yaml png=map.png distances=distances.h5)
$(if $(PLANNING),$(call whole,plan, grid=grid/floors.json $(FLOOR_GRIDS:%=beside=%) trajectory=pose_graph/trajectory.tum $(LOCATED), \
                          csv=path.csv json=path.json nav=path.yaml png=path.png))
$(if $(DRIVING),$(call whole,drive, grid=grid/floors.json $(FLOOR_GRIDS:%=beside=%) csv=plan/path.csv json=plan/path.json, \
                          csv=drive.csv json=drive.json gif=drive.gif))
endef

# Everything below is needed only by goals that make or ask about a site's artifacts.
CHAIN := $(filter map localize plan drive evaluate evaluate-colmap report why $(M)/% $(DATA)/%,$(MAKECMDGOALS))
ifneq ($(CHAIN),)

# The script also prints which shards, tiles and floors there are by the stages' lists. These are data:
# scripts read them and print checked words. Nothing in them is ever included or evaluated.
# (The make that goes on after the tiles is told what the first one found, but reads the lists anew.)
RESTARTS := $(if $(filter undefined,$(origin MAKE_RESTARTS)),,$(MAKE_RESTARTS))
IS_LIST := shard=% tile=% near=% floor=% damaged=% queries
ifneq ($(origin RESOLVED),command line)
RESOLVED := $(shell $(PYTHON) -I -S scripts/resolve_config.py --site $(SITES)/$(SITE).toml --data $(DATA) \
  --profile $(call quote,$(PROFILE)) --seed $(call quote,$(SEED)) --set $(call quote,$(SET)) \
  $(and $(START),--value $(call quote,plan.start=$(START))) $(and $(GOAL),--value $(call quote,plan.goal=$(GOAL))) \
  $(and $(QUERY),--query $(call quote,$(QUERY))) $(and $(CAMERA),--camera $(call quote,$(CAMERA))) \
  $(and $(FOV_DEG),--fov-deg $(call quote,$(FOV_DEG))) \
  --out $(M)/config $(if $(PREVIEW),--preview $(CONFIG)) $(if $(filter $(SITE),$(SYNTHETIC)),--synthetic) \
  $(if $(RESTARTS),--quiet))
ifneq ($(.SHELLSTATUS),0)
$(error the configs could not be resolved, see above)
endif
LISTS := $(filter $(IS_LIST),$(RESOLVED))
AFTER_TILES := $(PREVIEW)
else
LISTS := $(shell $(PYTHON) -I -S scripts/read_lists.py $(M) --quiet)
ifneq ($(.SHELLSTATUS),0)
$(error the lists of shards, tiles and floors could not be read, see above)
endif
AFTER_TILES := yes
endif
RAW_INPUTS := $(filter-out interrupted=% $(IS_LIST),$(RESOLVED))
INTERRUPTED := $(patsubst interrupted=%,%,$(filter interrupted=%,$(RESOLVED)))
ifneq ($(filter-out 1 2 3,$(RESTARTS)),)
$(error something stays out of date however often it is made: is the time of a file in the future?)
endif

ifeq ($(PREVIEW),)
include $(BUILD)/programs.mk
endif

comma := ,
listed = $(patsubst $(1)=%,%,$(filter $(1)=%,$(LISTS)))
SHARDS := $(call listed,shard)
TILES := $(call listed,tile)
$(foreach near,$(call listed,near),$(eval NEAR_$(subst $(comma), ,$(subst :, := ,$(near)))))
FLOOR_YAMLS := $(call listed,floor)
HAS_QUERIES := $(filter queries,$(LISTS))
# The files of each list. They keep their time while their bytes are the same, so they have no rule.
F := $(M)/frames
T := $(M)/tiles
G := $(M)/grid
LISTED_frames := $(if $(wildcard $(F)/shards.txt),$(SHARDS:%=$(F)/shard_%.csv) $(F)/cameras.json $(F)/queries.csv $(F)/query_cameras.json)
LISTED_tiles := $(if $(wildcard $(T)/tiles.txt),$(TILES:%=$(T)/tile_%.json) $(T)/cameras.json)
FLOOR_GRIDS := $(patsubst %,grid/%,$(FLOOR_YAMLS) $(FLOOR_YAMLS:.yaml=.pgm))
LISTED_grid := $(FLOOR_GRIDS:%=$(M)/%) $(FLOOR_YAMLS:%.yaml=$(G)/%.png)

list = $(subst $(eval ) ,$(comma),$(strip $(1)))
# NAME:OUTPUTS:INPUTS of each rule, for `why`.
RULES := programs:$(BUILD)/programs.mk:$(call list,$(SOURCES))
# The path of an input or output NAME=PATH, and the files among the inputs.
paths = $(foreach port,$(1),$(lastword $(subst =, ,$(port))))
# A stage whose outputs are not all there, or whose last run was killed while it committed, or whose list is
# damaged, runs again whatever the times say. Outputs are precious: programs commit all or nothing, so a stage
# that fails leaves the last good ones (stale, and so remade next time).
incomplete = $(call again,$(1),$(2) $(if $(filter frames tiles grid,$(1)),$(LISTED_$(1))))
again = $(if $(filter-out $(wildcard $(2)),$(2))$(filter $(1),$(INTERRUPTED) $(call listed,damaged)),FORCE)
# rule(stage, suffix of report, receipt and log, inputs NAME=PATH, outputs NAME=PATH)
define rule
.PRECIOUS: $(call paths,$(4))
MADE_$(1) += $(call paths,$(4))
AGAIN := $(call incomplete,$(1)$(2),$(call paths,$(4)))
RULES += $(1)$(2):$(call list,$(call paths,$(4))):$(call list,$(RUN)/$(1) $(CONFIG)/$(1).toml $(call paths,$(filter-out data=%,$(3))) $$(AGAIN))
$(call paths,$(4)) &: $(RUN)/$(1) $(CONFIG)/$(1).toml $(call paths,$(filter-out data=%,$(3))) $$(AGAIN)
	@mkdir -p $(dir $(firstword $(call paths,$(4)))) $(M)/logs; echo "== $(1)$(2)"
	$$(QUIET)$$(LAUNCH) $(RUN)/$(1) --config $(CONFIG)/$(1).toml $(patsubst %,--in %,$(filter-out beside=%,$(3))) $(4:%=--out %) \
	  --threads $$(THREADS) --log-level $$(LOG_LEVEL) 2>&1 | tee $(M)/logs/$(1)$(2).log || \
	  { code=$$$$?; echo "nightmap: $(1)$(2) failed, exit code $$$$code" >>$(M)/logs/$(1)$(2).log; exit $$$$code; }
endef
receipts = report=$(M)/$(1)/report$(2).json receipt=$(M)/$(1)/receipt$(2).json

# expand(patterns of the table, shard or tile)
expand = $(foreach word,$(1),$(if $(findstring *,$(word)),$(foreach s,$(SHARDS),$(subst *,$(s),$(word))), \
  $(if $(findstring @,$(word)),$(foreach t,$(TILES),$(subst @,$(t),$(word))), \
  $(if $(findstring ~,$(word)),$(foreach t,$(NEAR_$(2)),$(subst ~,$(t),$(word))), \
  $(if $(findstring <,$(word)),$(if $(BEFORE_$(2)),$(subst <,$(BEFORE_$(2)),$(word))),$(subst %,$(2),$(word)))))))
inputs = $(patsubst data,data=$(DATA),$(subst =,=$(M)/,$(call expand,$(1),$(2))))
outputs = $(subst =,=$(M)/$(1)/,$(call expand,$(2),$(3))) $(call receipts,$(1),$(4))
each = $(foreach n,$(4),$(eval $(call rule,$(1),_$(n),$(call inputs,$(2),$(n)),$(call outputs,$(1),$(3),$(n),_$(n)))))
shard = $(call each,$(1),$(2),$(3),$(SHARDS))
tile = $(call each,$(1),$(2),$(3),$(TILES))
whole = $(eval $(call rule,$(1),,$(call inputs,$(2),),$(call outputs,$(1),$(3),,)))
loops = $(eval $(call rule,$(1),_loops,$(call inputs,$(2),),$(call outputs,$(1),$(3),,_loops)))

# The two stages before the shards are known.
ifneq ($(filter $(SITE),$(SYNTHETIC)),)
RECORDING := $(DATA)/$(SITE)/synthesize.json
RAW_INPUTS += $(RECORDING)
$(eval $(call rule,synthesize,,,site=$(RECORDING) \
  report=$(DATA)/$(SITE)/synthesize_report.json receipt=$(DATA)/$(SITE)/synthesize_receipt.json))
endif
$(eval $(call rule,frames,,site=$(CONFIG)/site/$(SITE).toml data=$(DATA),shards=$(F)/shards.txt $(call receipts,frames,)))
$(F)/shards.txt: $(RAW_INPUTS)

# When the list of shards is out of date, Make runs frames first, removes what is left of shards that are no
# more, and starts over with the new list: the file that it includes is an empty one of the programs' folder.
# The modes that only look must not run frames, so they do not `include`.
$(BUILD)/lists/$(SITE).mk: $(F)/shards.txt
	@mkdir -p $(@D); $(PYTHON) -I -S scripts/remove_leftovers.py $(M); : >$@; touch $@
ifeq ($(PREVIEW),)
include $(BUILD)/lists/$(SITE).mk
endif
unmade = $(filter-out $(wildcard $(1)),$(1))
# For the modes that only look, before there is a list.
$(call unmade,$(F)/cameras.json $(F)/queries.csv $(F)/query_cameras.json): | $(F)/shards.txt
$(call unmade,$(T)/cameras.json): | $(T)/tiles.txt
$(foreach s,features vocabulary matches odometry,$(eval MADE_$(s) ?=))
BEFORE_ :=
previous :=
$(foreach s,$(SHARDS),$(eval BEFORE_$(s) := $(previous))$(eval previous := $(s)))
ACCELEROMETER := $(if $(wildcard $(F)/accelerometer.csv),accelerometer=frames/accelerometer.csv)
LOCATED := $(if $(HAS_QUERIES),queries=localize/queries.csv)
# Only who asks for a path gets it planned, and driven.
DRIVING := $(filter drive $(M)/drive/%,$(MAKECMDGOALS))
PLANNING := $(DRIVING)$(filter plan $(M)/plan/%,$(MAKECMDGOALS))
MADE_plan :=
MADE_drive :=
$(eval $(TABLE))

# The tiles are known when the trajectory is, so this make gets them made and leaves what comes after to a
# second one, which reads their list when it starts. (A start over as for the shards would make the tiles along
# with these, of shards that are not listed yet. Modes that only look see the tiles as they are.)
LATER := $(filter map plan drive evaluate report $(foreach s,point_cloud octree grid plan drive evaluate report,$(M)/$(s)/%),$(MAKECMDGOALS))
ifneq ($(if $(AFTER_TILES),,$(LATER)),)
TILES_NEED := synthesize frames features vocabulary matches odometry pose_graph tiles
FORWARDED := $(LATER) $(filter localize evaluate-colmap,$(MAKECMDGOALS))
.PHONY: tiles_first
tiles_first: $(BUILD)/programs.mk $(MADE_tiles) | $(filter-out $(FORWARDED),$(CHAIN))
	+@$(MAKE) --no-print-directory RESOLVED="$(filter-out $(IS_LIST) $(foreach s,$(TILES_NEED),interrupted=$(s) interrupted=$(s)_%),$(RESOLVED))" $(FORWARDED)
$(FORWARDED): tiles_first ; @:
else
MADE_point_cloud :=
MADE_octree :=
$(eval $(TABLE_AFTER_TILES))
# For the files of a floor that grid finds no more.
$(filter-out $(MADE_grid),$(LISTED_grid)): | $(G)/floors.json

MAP := frames features vocabulary matches odometry pose_graph tiles point_cloud octree grid landmarks
map: $(BUILD)/programs.mk $(foreach s,$(MAP),$(MADE_$(s))) ## the map of SITE: trajectory, cloud, octree, grid, landmarks
	@$(call say,map of $(SITE): $(M))
ifneq ($(HAS_QUERIES),)
localize: $(BUILD)/programs.mk $(MADE_localize) ## where each query picture of SITE was taken
	@$(if $(PREVIEW),,$(PYTHON) -I -S scripts/show_queries.py $(M); )$(call say,located queries: $(M)/localize/queries.csv)
else
localize: $(F)/shards.txt
	@echo "site $(SITE) has no query pictures: name some in QUERY, or give $(SITES)/$(SITE).toml a [[query]] or hold_out_every > 0" >&2; exit 2
endif
plan: $(BUILD)/programs.mk $(MADE_plan) ## a path from START to GOAL on the grid
	@$(call say,path: $(M)/plan/path.json)
drive: $(BUILD)/programs.mk $(MADE_drive) ## the same, and a simulated robot that follows it
	@$(call say,drive: $(M)/drive/drive.json)

# evaluate and report read the whole site folder: they depend on every result in it. The path that is
# there is shown, never planned anew: a map without a way through must not cost the morning its report.
RESULTS := $(foreach s,$(MAP) $(if $(HAS_QUERIES),localize),$(MADE_$(s))) \
  $(if $(PLANNING),$(MADE_plan),$(wildcard $(M)/plan/receipt.json)) \
  $(if $(DRIVING),$(MADE_drive),$(wildcard $(M)/drive/receipt.json))
EVALUATION := $(wildcard scripts/evaluate.py scripts/report.py scripts/nightmap_eval/*.py)
$(M)/evaluate/metrics.json: $(RESULTS) $(EVALUATION)
	@mkdir -p $(@D) $(M)/logs; echo "== evaluate"
	$(QUIET)$(PYTHON) scripts/evaluate.py --site-dir $(M) --data $(DATA) --out $@ 2>&1 | tee $(M)/logs/evaluate.log
# What the report says of a path or drive that is not the one asked for last it takes from the logs and the config.
REPORTED := $(M)/evaluate/metrics.json $(CONFIG)/plan.toml \
  $(wildcard $(M)/logs/plan.log $(M)/logs/drive.log $(M)/evaluate_colmap/results.json) $(EVALUATION)
$(M)/report/index.html: $(REPORTED)
	@mkdir -p $(@D) $(M)/logs; echo "== report"
	$(QUIET)$(PYTHON) scripts/report.py --site-dir $(M) --data $(DATA) --out $@ 2>&1 | tee $(M)/logs/report.log
RULES += raw_inputs:$(F)/shards.txt:$(call list,$(RAW_INPUTS)) \
  evaluate:$(M)/evaluate/metrics.json:$(call list,$(RESULTS) $(EVALUATION)) \
  report:$(M)/report/index.html:$(call list,$(REPORTED))
evaluate: $(BUILD)/programs.mk $(M)/evaluate/metrics.json ## accuracy against the truth of SITE, where there is one
	@$(call say,metrics: $(M)/evaluate/metrics.json)
report: $(BUILD)/programs.mk $(M)/report/index.html ## one page: pictures, time and memory of each stage, accuracy
	@$(call say,report: $(M)/report/index.html)

# The comparison with COLMAP takes long and is made only when asked for; the report shows the one that is
# there. Each step of COLMAP's work is an artifact of its own: an interrupted comparison goes on where it was,
# a changed map repeats only what was made of it. Frames stand for their pixels, as everywhere.
COMPARING := $(filter evaluate-colmap $(M)/evaluate_colmap/%,$(MAKECMDGOALS))
C := $(M)/evaluate_colmap
# colmap_step(step, inputs)
define colmap_step
$(C)/$(1)/receipt.json: $(2) scripts/colmap_step.py $(wildcard scripts/nightmap_eval/colmap_*.py)
	@mkdir -p $(C) $(M)/logs; echo "== colmap_$(1)"
	$$(QUIET)$$(LAUNCH) $(PYTHON) scripts/colmap_step.py $(1) --site-dir $(M) --data $(DATA) --threads $$(THREADS) \
	  2>&1 | tee $(M)/logs/colmap_$(1).log
endef
ifneq ($(COMPARING),)
steps = $(foreach s,$(1),$(C)/$s/receipt.json)
$(eval $(call colmap_step,features,$(SHARDS:%=$(F)/shard_%.csv) $(F)/cameras.json))
$(eval $(call colmap_step,matches,$(call steps,features)))
$(foreach r,1 2 3,$(eval $(call colmap_step,mapper_$r,$(call steps,matches))))
$(eval $(call colmap_step,triangulate,$(call steps,matches) $(M)/pose_graph/trajectory.tum $(M)/pose_graph/cameras.json))
$(foreach n,queries queries_default,$(eval $(call colmap_step,$n,$(call steps,matches) $(F)/queries.csv $(F)/query_cameras.json)))
COLMAP_MAPS := mapper_1 mapper_2 mapper_3 triangulate
register = $(eval $(call colmap_step,register_$(1)$(3),$(call steps,$(2) queries$(3))))
$(foreach d,| _default|,$(foreach m,$(COLMAP_MAPS),$(call register,$m,$m,$(d:|=)))$(call register,held,triangulate,$(d:|=)))
REGISTERED := $(COLMAP_MAPS:%=register_%) register_held
$(C)/results.json: $(call steps,$(REGISTERED) $(REGISTERED:%=%_default)) $(MADE_localize) $(MADE_frames) \
  $(wildcard $(F)/ground_truth.tum $(F)/query_ground_truth.tum) $(EVALUATION) scripts/evaluate_colmap.py
	@echo "== evaluate_colmap"
	$(QUIET)$(PYTHON) scripts/evaluate_colmap.py --site-dir $(M) --out $@ 2>&1 | tee $(M)/logs/evaluate_colmap.log
endif
ifneq ($(HAS_QUERIES),)
evaluate-colmap: $(BUILD)/programs.mk $(C)/results.json ## queries in COLMAP's map and in this one: accuracy, time, size (slow)
	@$(call say,comparison: $(C)/results.json)
else
evaluate-colmap: localize
endif
why: ## what `make report` would rerun now and for what reason; with SET: what that change would rerun
	@printf '%s\n' $(RULES) | $(PYTHON) scripts/why.py --out $(M)
endif # AFTER_TILES
endif # CHAIN

# ---- commands -----------------------------------------------------------------------------------
help: ## this page
	@echo "nightmap: a map of a building from what a robot's RGB-D camera saw. Commands:"; \
	sed -nE 's/^([a-z-]+):[^#]*## (.*)$$/  make \1 \t\2/p' Makefile | expand -t 26; \
	echo; echo "Variables (now):"; \
	sed -nE 's/^## ([A-Z][A-Z_ ]*) +(.*)$$/  \1 \t\2/p' Makefile | expand -t 14; \
	echo; echo "  SITE=$(SITE) PROFILE=$(PROFILE) SEED=$(SEED) DATA=$(DATA) MAPS=$(MAPS) THREADS=$(THREADS)"; \
	echo "  sites:    "$(call quote,$(notdir $(basename $(wildcard $(SITES)/*.toml)))); \
	echo "  profiles: "$(call quote,$(filter-out sites,$(notdir $(wildcard configs/*)))); echo; \
	echo "make -n lists only the first of several stale stages (a trait of grouped targets): use make why."

deps: ## install the Debian packages that are missing
	@scripts/install_deps.sh

build: $(BUILD)/programs.mk ## the stage programs (map and the others build them when needed)
	@$(call say,programs: $(RUN))

# On a fresh machine python3 and the compiler come with deps, so the rest is parsed after it.
demo: ## everything on a made-up building: install, build, map, localize, drive, evaluate, report
	@scripts/install_deps.sh
	@$(MAKE) --no-print-directory SITE=demo map localize drive evaluate report
	@echo "demo: open $(MAPS)/demo/report/index.html"

test: ## unit tests, end-to-end tests, and tests on real data where it is found
	@scripts/install_deps.sh
	@$(MAKE) --no-print-directory build
	ninja -j $(THREADS) -C $(BUILD)
	@ctest --test-dir $(BUILD) -j $(THREADS) --output-on-failure

# What takes too long for every day: a sweep of attacks on all programs and scripts.
test-nightly: ## 2,000 attacks with damaged, hostile and misplaced files; after `make test`
	@$(MAKE) --no-print-directory build
	@NIGHTMAP_BUILD=$(abspath $(BUILD)) $(PYTHON) tests/fuzz/sweep.py --runs 2000

# Other compiler options, other folder. Debug asserts are on; -O1 keeps it bearable. The end-to-end and
# real-data tests are left to `make test`.
test-sanitize: ## unit tests under AddressSanitizer and UndefinedBehaviorSanitizer
	cmake -S . -B $(BUILD)-sanitize -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1 \
	  -DNIGHTMAP_SANITIZE=ON --log-level=WARNING >/dev/null
	ninja -j $(THREADS) -C $(BUILD)-sanitize unit_tests
	ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1:suppressions=$(CURDIR)/tests/asan_suppressions.txt UBSAN_OPTIONS=print_stacktrace=1 \
	  ctest --test-dir $(BUILD)-sanitize -j $(THREADS) --output-on-failure -E '^(e2e|scripts)/|Real'

bench: ## time from raw frames to the trajectory of CASES (SITE or SITE:N, its first N frames) against a yardstick
	@$(MAKE) --no-print-directory build
	@$(PYTHON) scripts/bench.py $(CASES) --data $(DATA) --build $(BUILD) --threads $(THREADS)

verify: ## hash the artifacts of SITE again and compare with their receipts
	@$(PYTHON) scripts/verify.py $(M)

clean: ## remove the results of SITE
	rm -rf $(M)

distclean: ## remove the results of every site, the programs, and the recordings that synthesize made
	rm -rf $(MAPS) $(BUILD) $(BUILD)-sanitize \
	  $(foreach s,$(SYNTHETIC),$(if $(wildcard $(DATA)/$(s)/.made_by_synthesize),$(DATA)/$(s)))

OURS := $(wildcard pipeline/*/*.h pipeline/*/*.cc stages/*/*.h stages/*/*.cc tests/*/*.h tests/*/*.cc tests/*/*/*.h tests/*/*/*.cc)
format: ## rewrite the sources in the project's format
	@clang-format -i $(OURS)

format-check: ## fail when a source is not in the project's format
	@clang-format --dry-run -Werror $(OURS)

# One source file a folder, put together by CMake: clang-tidy reads the heavy headers once for all. Not the
# programs' main.cc: one call each. (A name twice in one folder's files fails here, not in the build.)
LINTED := $(patsubst pipeline/%/,nightmap_%,$(wildcard pipeline/*/)) $(patsubst stages/%/,stage_%,$(wildcard stages/*/))
lint: ## clang-tidy over the sources (again only where something changed), shellcheck over the scripts
	@shellcheck .ci/run scripts/*.sh
	@cmake -S . -B $(BUILD)/lint -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 \
	  -DNIGHTMAP_TESTS=OFF --log-level=WARNING >/dev/null
	@$(MAKE) --no-print-directory -j $(THREADS) $(LINTED:%=$(BUILD)/lint/%.ok)
linted_folder = $(patsubst nightmap_%,pipeline/%,$(patsubst stage_%,stages/%,$(1)))
$(foreach l,$(LINTED),$(eval $(BUILD)/lint/$(l).ok: $(wildcard $(call linted_folder,$(l))/*.cc)))
$(LINTED:%=$(BUILD)/lint/%.ok): $(BUILD)/lint/%.ok: .clang-tidy $(filter pipeline/%.h stages/%.h,$(OURS))
	@echo "clang-tidy $(call linted_folder,$*)"
	@clang-tidy --quiet --config-file=.clang-tidy --extra-arg=-Wno-unknown-warning-option -p $(BUILD)/lint \
	  $(BUILD)/lint/CMakeFiles/$*.dir/Unity/unity_0_cxx.cxx 2> >(grep -v 'warnings\? generated' >&2 || true)
	@touch $@
