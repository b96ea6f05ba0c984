# The front door. Every target says what it does and installs what it needs (Debian 12, root or sudo).
.DEFAULT_GOAL := help
SHELL := /bin/bash
JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 60
SOAK ?= 1
PART ?= all

.PHONY: help run test test-can bench lint fuzz soak
help: ## Show this list
	@grep -hE '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /|/' | awk -F'|' '{printf "  make %-8s %s\n", $$1, $$2}'

run: ## Build, start the demo robot, scan it and show it moving until Ctrl-C
	@tools/setup build
	@tools/build run sinew
	@[[ ! -t 0 ]] || set -m; tools/demo build/run/apps/cli/sinew; exit $$? # set -m: Ctrl-C reaches the demo alone, and make ends well

test: ## Everything that proves it: release tests, real CAN, sanitizers, fuzz corpora
	@tools/setup build test
	@tools/setup guest || true # without it the step says that it is skipped, and why
	@JOBS=$(JOBS) tools/test

test-can: ## What needs the CAN stack of a kernel, in a throw-away guest (part of test)
	@tools/setup build test guest
	@tools/test-can

bench: ## Figures of codec and simulator, printed and as JSON
	@tools/setup build bench
	@tools/bench

lint: ## Formatting, clang-tidy, shell scripts, leftovers
	@tools/setup build test bench lint
	@JOBS=$(JOBS) tools/lint

fuzz: ## Run every fuzz target for FUZZ_SECONDS (60)
	@tools/setup build test
	@tools/fuzz $(FUZZ_SECONDS)

soak: ## The long proofs: PART=properties, fuzz, storm, replug, matching, robot, mutation, kill, tsan, sanitized or can, scaled by SOAK=0.1
	@tools/setup build test
	@SOAK=$(SOAK) tools/soak $(PART)
