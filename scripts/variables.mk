# SPDX-License-Identifier: Apache-2.0
# The values that a user gives to make's variables are data: `value` takes their text unexpanded, recipes read it from the
# environment, and what rules or a shell would interpret is refused here, before anything runs.

override SITE := $(value SITE)
override PROFILE := $(value PROFILE)
override SET := $(value SET)
override SEED := $(value SEED)
override START := $(value START)
override GOAL := $(value GOAL)
override QUERY := $(value QUERY)
override CAMERA := $(value CAMERA)
override FOV_DEG := $(value FOV_DEG)
override NEAR := $(value NEAR)
override NEAR_RADIUS := $(value NEAR_RADIUS)
override TURN := $(value TURN)
override OBJECTS := $(value OBJECTS)
override STRICT := $(value STRICT)
override DATA := $(value DATA)
override MAPS := $(value MAPS)
override LAUNCH := $(value LAUNCH)
override THREADS := $(if $(filter file,$(origin THREADS)),$(THREADS),$(value THREADS))
override LOG_LEVEL := $(value LOG_LEVEL)
override V := $(value V)
override CASES := $(if $(filter file,$(origin CASES)),$(CASES),$(value CASES))
override FIGURES := $(value FIGURES)
override BUILD := $(value BUILD)
override SITES := $(value SITES)
override PYTHON := $(value PYTHON)
override SANITIZED := $(value SANITIZED)
export SITE PROFILE SET SEED START GOAL QUERY CAMERA FOV_DEG NEAR NEAR_RADIUS TURN OBJECTS STRICT DATA MAPS LAUNCH THREADS LOG_LEVEL V CASES FIGURES BUILD SITES PYTHON SANITIZED
# A make that a recipe starts takes them from the environment, and not as text to expand again.
MAKEOVERRIDES :=

quote = '$(subst ','\'',$(1))'
# Those of the command line that are not above.
UNKNOWN := $(strip $(foreach v,$(.VARIABLES),$(if $(filter command,$(firstword $(origin $v))),$v)))
KNOWN := $(sort $(foreach v,$(.VARIABLES),$(if $(filter override,$(origin $v)),$v)))
ifneq ($(UNKNOWN),)
$(error $(or $(shell $(PYTHON) -I -S scripts/unknown_variable.py $(call quote,$(UNKNOWN)) $(KNOWN)),\
  $(UNKNOWN): no such variable; `make help` lists them))
endif

ifeq ($(strip $(PYTHON)),)
$(error PYTHON is empty: give the command of a Python 3.11 or newer, as in PYTHON=/usr/bin/python3)
endif
no_digits = $(subst 0,,$(subst 1,,$(subst 2,,$(subst 3,,$(subst 4,,$(subst 5,,$(subst 6,,$(subst 7,,$(subst 8,,$(subst 9,,$(1)))))))))))
ifneq ($(words $(THREADS))$(call no_digits,$(THREADS)),1)
$(error THREADS=$(THREADS): give a whole number)
endif
ifneq ($(words $(LOG_LEVEL))$(filter-out debug info warn err off,$(LOG_LEVEL)),1)
$(error LOG_LEVEL=$(LOG_LEVEL): give one of debug, info, warn, err and off)
endif
$(foreach v,V STRICT,$(if $(filter-out 1,$(words $($v))$(filter-out 0 1,$($v))),$(error $v=$($v): give 0 or 1)))

ifneq ($(words $(SITE) $(DATA) $(MAPS) $(BUILD) $(SITES))$(findstring /,$(SITE)),5)
$(error SITE, DATA, MAPS, BUILD and SITES must each be one word without spaces; SITE must not contain /)
endif
# Make or a shell would interpret these characters in a name.
define UNSAFE
: % $$ ' " ; & | ( ) < > * ? [ ] { } \ ` = , # !
endef
unsafe_in = $(strip $(foreach c,$(UNSAFE),$(findstring $(c),$(1))))
ifneq ($(call unsafe_in,$(SITE)$(DATA)$(MAPS)$(BUILD)$(SITES)),)
$(error SITE, DATA, MAPS, BUILD and SITES must not contain any of $(strip $(UNSAFE)): rename the folder or make a link to it)
endif
ifneq ($(filter .% -%,$(SITE))$(filter -% ~%,$(DATA) $(MAPS) $(BUILD) $(SITES)),)
$(error SITE must not begin with a dot, and neither SITE nor DATA, MAPS, BUILD or SITES with a dash or ~: rename the folder)
endif
ifneq ($(call unsafe_in,$(subst |,,$(SANITIZED))),)
$(error SANITIZED=$(SANITIZED): give names of groups, as in SANITIZED="base|io")
endif
ifneq ($(call unsafe_in,$(MAKECMDGOALS)),)
$(error no file of nightmap has a name with any of $(strip $(UNSAFE)))
endif
