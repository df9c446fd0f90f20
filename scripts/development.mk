# SPDX-License-Identifier: Apache-2.0
# Commands for developers: build, tests, benchmarks, format and lint. The Makefile includes this file.

.PHONY: FORCE build build_tests test test-slurm test-nightly test-sanitize bench figures format format-check lint
RUN := $(BUILD)/run
# Rules whose lists of sources take long to read are there for the goals that need them alone: most makes are of a site, and
# find nothing to do.
asked = $(filter $(1),$(MAKECMDGOALS))

# ---- programs -----------------------------------------------------------------------------------
# Ninja links in place. Stages run copies, which keep their modification time while their bytes stay the
# same, so a changed comment reruns no stage. (A Release build has no -g for the same reason.) The lock
# protects the build when two sites are made at the same time.
#
# NIGHTMAP_PROGRAMS, from those who need some programs only (make_site.py), are built with all that were built before, so that
# no program in RUN is older than the sources.
ALL_PROGRAMS := $(notdir $(patsubst %/main.cc,%,$(wildcard stages/*/*/main.cc)))
NIGHTMAP_PROGRAMS ?= $(ALL_PROGRAMS)
PROGRAMS := $(filter $(NIGHTMAP_PROGRAMS) $(notdir $(wildcard $(RUN)/*)),$(ALL_PROGRAMS))
ifneq ($(call asked,build $(BUILD)/programs.mk),)
SOURCES := CMakeLists.txt $(wildcard cmake/*.cmake pipeline/*/links.cmake stages/*/links.cmake pipeline/*/*.h pipeline/*/*.cc stages/*/*/*.h stages/*/*/*.cc)
missing = $(if $(wildcard $(1)),,FORCE)

$(BUILD)/programs.mk: $(SOURCES) $(foreach p,$(PROGRAMS),$(call missing,$(RUN)/$(p)))
	@mkdir -p $(RUN); exec 9>$(BUILD)/programs.lock; flock 9; touch $@.new; \
	scripts/install_deps.sh --quiet $(PROGRAMS) || echo "make: goes on without these packages" >&2; \
	cmake -S . -B $(BUILD) -G Ninja -DCMAKE_BUILD_TYPE=Release -DNIGHTMAP_PROGRAMS="$(if $(filter-out $(PROGRAMS),$(ALL_PROGRAMS)),$(PROGRAMS))" \
	  --log-level=WARNING >/dev/null; \
	ninja -j "$$THREADS" -C $(BUILD) $(PROGRAMS:%=%_program); \
	for p in $(if $(PROGRAMS),nightmap_media.so) $(PROGRAMS); do \
	  cmp -s $(BUILD)/bin/$$p $(RUN)/$$p || { cp $(BUILD)/bin/$$p $(RUN)/$$p.new; mv $(RUN)/$$p.new $(RUN)/$$p; }; \
	done; mv $@.new $@
endif
build: $(BUILD)/programs.mk ## build all stage programs (map and the other commands build those that they run)
	$(if $(findstring q,$(firstword -$(MAKEFLAGS))),,@echo "programs: $(RUN)")

build_tests:
	@scripts/install_deps.sh tests
	@$(MAKE) --no-print-directory build
	@cmake -S . -B $(BUILD) -DNIGHTMAP_TESTS=ON --log-level=WARNING >/dev/null
	ninja -j "$$THREADS" -C $(BUILD)

test: build_tests ## unit tests, end-to-end tests, and tests on the real data that is present
	@ctest --test-dir $(BUILD) -j "$$THREADS" --output-on-failure | \
	  $(PYTHON) tests/summary.py $(BUILD)/Testing/Temporary/LastTest.log

test-slurm: build_tests ## the demo and small sites on a Slurm cluster of two nodes on this machine, one of which is lost
	@ctest --test-dir $(BUILD) --output-on-failure -R slurm

# Tests that take too long for every change. NIGHTMAP_NIGHTLY=1 makes tests do all they can.
test-nightly: ## the slow lint, all unit tests under sanitizers, all tests whole, 2,000 attacks with damaged files
	@rm -f $(BUILD)/lint/*.ok
	@TIDY_OFF= $(MAKE) --no-print-directory lint
	@NIGHTMAP_NIGHTLY=1 SANITIZE_OFF= $(MAKE) --no-print-directory test-sanitize SANITIZED=.
	@$(MAKE) --no-print-directory build_tests
	@NIGHTMAP_NIGHTLY=1 ctest --test-dir $(BUILD) --output-on-failure
	ninja -j "$$THREADS" -C $(BUILD) benchmarks
	@NIGHTMAP_BUILD=$(abspath $(BUILD)) $(PYTHON) tests/fuzz/sweep.py --runs 2000

# Other compiler options need another folder. Debug asserts are on; -O1 keeps the tests fast enough. The
# end-to-end and real-data tests run only in `make test`.
# These checks take 40 % of the time of compilation, and AddressSanitizer finds most of what they do: at night they are made too.
SANITIZE_OFF ?= -fno-sanitize=null,object-size,alignment,vptr
sanitized_programs = $(if $(filter .,$(SANITIZED)),unit_tests,$(addprefix test_,$(subst |, ,$(SANITIZED))))
test-sanitize: ## tests of what reads files under AddressSanitizer and UndefinedBehaviorSanitizer (SANITIZED=. runs all)
	cmake -S . -B $(BUILD)-sanitize -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1 \
	  -DNIGHTMAP_SANITIZE=ON -DNIGHTMAP_SANITIZE_OFF="$(SANITIZE_OFF)" -DNIGHTMAP_TESTS=ON --log-level=WARNING >/dev/null
	ninja -j "$$THREADS" -C $(BUILD)-sanitize $(sanitized_programs)
	ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1:suppressions=$(CURDIR)/tests/asan_suppressions.txt UBSAN_OPTIONS=print_stacktrace=1 \
	  GTEST_FILTER=-*Real* ctest --test-dir $(BUILD)-sanitize -j "$$THREADS" --output-on-failure -R "^($$SANITIZED)" -E '^(e2e|scripts)/'

bench: ## time from raw frames to trajectory, relative to a yardstick, for CASES (SITE, or SITE:N: its first N frames)
	@$(MAKE) --no-print-directory build
	@$(PYTHON) tests/bench/bench.py $$CASES --data $(DATA) --build $(BUILD) --threads "$$THREADS"

figures: ## measure the tables of docs/figures.md again (FIGURES names some); hours, on a machine that does nothing else
	@$(MAKE) --no-print-directory build
	@$(PYTHON) tests/bench/figures.py $$FIGURES --data $(DATA) --build $(BUILD) --threads "$$THREADS"

OURS = $(foreach folder,pipeline/* stages/*/* tests/* tests/*/* tests/*/*/*,$(wildcard $(folder)/*.h $(folder)/*.cc))
with_packages = scripts/install_deps.sh --quiet lint || echo "make: goes on without these packages" >&2
format: ## rewrite the sources in the project's format
	@$(with_packages)
	@clang-format -i $(OURS)

format-check: ## fail when a source is not in the project's format
	@$(with_packages)
	@clang-format --dry-run -Werror $(OURS)

# CMake joins the sources of a folder into one file, so clang-tidy reads the heavy headers once per folder.
LINTED = $(patsubst pipeline/%/,nightmap_%,$(wildcard pipeline/*/)) $(patsubst %,stage_%,$(ALL_PROGRAMS))
# One check takes a minute of pipeline/io (it looks for changes of each parameter in all that the headers define): only
# the nightly tests make it. From the environment, because a command line takes variables of users alone.
TIDY_OFF ?= -performance-unnecessary-value-param
# With this plugin clang-tidy skips what system headers declare. The nightly tests do without it.
TIDY_PLUGIN := $(BUILD)/lint/own_declarations.so
$(TIDY_PLUGIN): tests/lint/own_declarations.cc
	@c++ -std=c++17 -O1 -fno-rtti -fPIC -shared -isystem "$$(llvm-config --includedir)" $< -o $@ 2>$@.log || \
	  echo "lint: goes on without its plugin, which makes it three times as fast (libclang-dev, llvm-dev; see $@.log)" >&2
lint: ## clang-tidy on the changed sources, shellcheck on the scripts
	@$(with_packages)
	@shellcheck .ci/run scripts/*.sh
	@cmake -S . -B $(BUILD)/lint -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=WARNING >/dev/null
	@$(MAKE) -s --no-print-directory $(TIDY_PLUGIN)
	@$(MAKE) --no-print-directory -j "$$THREADS" $(LINTED:%=$(BUILD)/lint/%.ok)
ifneq ($(call asked,$(BUILD)/lint/%.ok),)
linted_folder = $(patsubst nightmap_%,pipeline/%,$(if $(filter stage_%,$(1)),$(wildcard stages/*/$(1:stage_%=%)),$(1)))
.SECONDEXPANSION:
$(LINTED:%=$(BUILD)/lint/%.ok): $(BUILD)/lint/%.ok: .clang-tidy $(filter pipeline/%.h stages/%.h,$(OURS)) \
    $$(wildcard $$(call linted_folder,$$*)/*.cc)
	@echo "clang-tidy $(call linted_folder,$*)"
	@clang-tidy --quiet --config-file=.clang-tidy --checks='$(TIDY_OFF)' \
	  $(if $(TIDY_OFF),$(addprefix --load=,$(abspath $(wildcard $(TIDY_PLUGIN))))) --extra-arg=-Wno-unknown-warning-option -p $(BUILD)/lint \
	  $(BUILD)/lint/CMakeFiles/$*.dir/Unity/unity_0_cxx.cxx 2> >(grep -v 'warnings\? generated' >&2 || true)
	@touch $@
endif
