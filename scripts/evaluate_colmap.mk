# SPDX-License-Identifier: Apache-2.0
# The comparison with COLMAP. The rules of a site include this file when a goal needs it. Each step of COLMAP's work is
# an artifact: an interrupted comparison continues where it stopped, and a changed map repeats only the steps that read it.
# Rules depend on the lists of frames, which hold the hashes of the pixels; they do not depend on the pictures themselves.
M := $(MAPS)/$(SITE)
C := $(M)/evaluate_colmap
RUNS_OF_MAPPER := mapper_1 mapper_2 mapper_3
MAPS_OF_COLMAP := $(RUNS_OF_MAPPER) triangulate
REGISTERED := $(MAPS_OF_COLMAP) held
STEP := $(wildcard scripts/colmap_step.py scripts/nightmap_eval/colmap/colmap_*.py)
step = $(RUN) colmap_$(1) $(LAUNCH) $(PYTHON) scripts/colmap_step.py $(1) --site-dir $(M) --data $(DATA) --threads $(THREADS)

$(C)/features/receipt.json: $(frames.shard) $(M)/frames/cameras.json $(STEP)
	@command -v colmap >/dev/null || scripts/install_deps.sh colmap
	$(call step,features)
$(C)/matches/receipt.json: $(C)/features/receipt.json $(STEP)
	$(call step,matches)
$(RUNS_OF_MAPPER:%=$(C)/%/receipt.json): $(C)/%/receipt.json: $(C)/matches/receipt.json $(STEP)
	$(call step,$*)
$(C)/triangulate/receipt.json: $(C)/matches/receipt.json $(M)/map_frame/trajectory.tum $(STEP)
	$(call step,triangulate)
$(C)/queries/receipt.json $(C)/queries_default/receipt.json: $(C)/%/receipt.json: $(C)/matches/receipt.json \
    $(M)/queries/queries.csv $(M)/queries/query_cameras.json $(STEP)
	$(call step,$*)
$(MAPS_OF_COLMAP:%=$(C)/register_%/receipt.json): $(C)/register_%/receipt.json: $(C)/%/receipt.json
$(MAPS_OF_COLMAP:%=$(C)/register_%_default/receipt.json): $(C)/register_%_default/receipt.json: $(C)/%/receipt.json
$(C)/register_held/receipt.json $(C)/register_held_default/receipt.json: $(C)/triangulate/receipt.json
$(REGISTERED:%=$(C)/register_%/receipt.json): $(C)/queries/receipt.json $(STEP)
$(REGISTERED:%=$(C)/register_%_default/receipt.json): $(C)/queries_default/receipt.json $(STEP)
$(C)/register_%/receipt.json:
	$(call step,register_$*)
$(C)/results.json: $(REGISTERED:%=$(C)/register_%/receipt.json) $(REGISTERED:%=$(C)/register_%_default/receipt.json) \
    $(M)/localize/queries.csv $(M)/localize/receipt.json $(M)/frames/shards.txt \
    $(wildcard $(M)/frames/ground_truth.tum $(M)/queries/query_ground_truth.tum scripts/nightmap_eval/*.py scripts/nightmap_eval/colmap/*.py) \
    $(wildcard scripts/nightmap_site/*.py) scripts/evaluate_colmap.py
	$(RUN) evaluate_colmap $(PYTHON) scripts/evaluate_colmap.py --site-dir $(M) --out $@
.PHONY: evaluate-colmap
evaluate-colmap: $(C)/results.json
