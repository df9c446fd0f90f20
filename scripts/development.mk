# SPDX-License-Identifier: Apache-2.0
# For those who change nightmap: the build of the programs, tests, benchmarks, format and lint. The Makefile includes it.

.PHONY: FORCE build test test-nightly test-sanitize bench format format-check lint
RUN := $(BUILD)/run

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
build: $(BUILD)/programs.mk ## the stage programs (map and the others build them when needed)
	$(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@echo "programs: $(RUN)")

test: ## unit tests, end-to-end tests, and tests on real data where it is found
	@scripts/install_deps.sh
	@$(MAKE) --no-print-directory build
	ninja -j $(THREADS) -C $(BUILD)
	@ctest --test-dir $(BUILD) -j $(THREADS) --output-on-failure

# What takes too long for every day.
test-nightly: ## 2,000 attacks with damaged, hostile and misplaced files, a site of 5,000 shards; after `make test`
	@$(MAKE) --no-print-directory build
	@NIGHTMAP_BUILD=$(abspath $(BUILD)) $(PYTHON) tests/fuzz/sweep.py --runs 2000
	@cd tests/e2e; NIGHTMAP_BUILD=$(abspath $(BUILD)) NIGHTMAP_NIGHTLY=1 $(PYTHON) -m unittest shards_test

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
.SECONDEXPANSION:
$(LINTED:%=$(BUILD)/lint/%.ok): $(BUILD)/lint/%.ok: .clang-tidy $(filter pipeline/%.h stages/%.h,$(OURS)) \
    $$(wildcard $$(call linted_folder,$$*)/*.cc)
	@echo "clang-tidy $(call linted_folder,$*)"
	@clang-tidy --quiet --config-file=.clang-tidy --extra-arg=-Wno-unknown-warning-option -p $(BUILD)/lint \
	  $(BUILD)/lint/CMakeFiles/$*.dir/Unity/unity_0_cxx.cxx 2> >(grep -v 'warnings\? generated' >&2 || true)
	@touch $@
