# Everything that a user or a machine runs. Each target installs what it needs first.

CARGO ?= cargo
OUT ?= out
# The profile that everything is built with, the tests included; PROFILE=release leaves out the checks of overflow.
PROFILE ?= dev
BIN ?= $(or $(CARGO_TARGET_DIR),target)/$(patsubst dev,debug,$(PROFILE))/ssct

.PHONY: all setup build dist package install-c study gpu-study bars league test test-one shader-test test-busy test-times test-wgpu test-bevy test-drivers test-debian-12 \
	test-debian-13 test-debian-13-backports test-faults test-sanitized test-gpu-av soak test-blender test-mitsuba test-cluster test-snakemake embree library fuzz lint bench view doc docs \
	clean

all: build

setup:
	@scripts/setup.sh

# The command, and what it needs: the window is a program of its own (`make view`). A binary of the whole workspace, and not
# the one of a package, so that crates have the features here that they have in `make test`, and are compiled once.
build: setup
	$(CARGO) build --profile $(PROFILE) --bin ssct

# The crate that others embed, with its shaders compiled: target/package/ssct-VERSION.crate.
package: setup
	CARGO="$(CARGO)" scripts/package.sh

# One archive of the program for machines with nothing but a driver: target/dist/ssct-VERSION-x86_64-linux.tar.gz.
dist: setup
	CARGO="$(CARGO)" scripts/dist.sh

# The libraries for C, with the header and the files of pkg-config and CMake, in the folder PREFIX.
PREFIX ?= /usr/local

install-c: PROFILE = release
install-c: setup
	CARGO="$(CARGO)" scripts/install-c.sh "$(PREFIX)" --profile $(PROFILE)

# Pictures, times and table 5.8 of the built-in scenes; the page is $(OUT)/index.html.
study: build
	"$(BIN)" study -o $(OUT)

# All measurements of a device, in at most eight minutes on a GPU; the page is $(OUT)/gpu-study/index.html.
gpu-study: PROFILE = release
gpu-study: build
	scripts/gpu-study.sh "$(BIN)" $(OUT)/gpu-study

# unified beside ssct and hzct: times and errors of many views, half an hour on two cores. SCENES may name a
# folder with the thesis's own rooms and Sponza.
bars: PROFILE = release
bars: build
	scripts/bars.sh $(OUT)/bars $(SCENES)

# three.js and Babylon.js in Debian's Chromium beside this program's methods, on scenes whose truth is exact; an hour on two cores.
# METHODS names folders of further methods.
league: PROFILE = release
league: build
	scripts/league.sh "$(BIN)" $(OUT)/league $(METHODS)

test: setup
	$(CARGO) test

# The tests of a shader that changed, as they were built last: FILE=shaders-glsl/history/history.glsl, and TESTS names others than
# those that share a word with it.
shader-test:
	@scripts/shader-test.sh "$(FILE)" $(TESTS)

# Tests after a change of Rust, which is compiled in parts: only what changed. TESTS names them.
test-one:
	CARGO_INCREMENTAL=1 $(CARGO) test --test suite -- $(TESTS)

# The same tests beside eight busy loops: no test may depend on how fast a machine is.
test-busy: setup
	$(CARGO) test --no-run
	CARGO="$(CARGO)" scripts/test-busy.sh

# The same tests, and how long each took.
test-times: setup
	CARGO="$(CARGO)" scripts/test-times.sh $(OUT)/test-times.csv

# The example on wgpu, which is a package of its own, beside the command.
test-wgpu: build
	SSCT_COMMAND="$(BIN)" $(CARGO) test --manifest-path examples/wgpu/Cargo.toml \
		--target-dir "$(or $(CARGO_TARGET_DIR),target)"

# The example in Bevy, whose compiler examples/bevy/rust-toolchain.toml names: ten minutes the first time, on two cores.
test-bevy: build
	cd examples/bevy && if command -v rustup >/dev/null; then rustup toolchain install; fi && \
		SSCT_COMMAND="$(abspath $(BIN))" $(CARGO) test

# The tests of drivers on lavapipe, on SwiftShader and on Mesa 25's lavapipe, the first two under a younger validation
# layer; all but the first are fetched: minutes.
test-drivers: setup
	CARGO="$(CARGO)" scripts/test-drivers.sh

# The README's two commands in a bare Debian, which debootstrap makes in a folder; as root: half an hour. With -backports, on the
# youngest Mesa and layers that this Debian has.
test-debian-12 test-debian-13 test-debian-13-backports: test-debian-%:
	scripts/test-debian.sh $*

# Every allocation and every submission of every method made to fail: minutes.
test-faults: setup
	$(CARGO) test --test alone -- faults:: --include-ignored

# The tests of the interface for C under AddressSanitizer and ThreadSanitizer: a quarter of an hour.
test-sanitized: setup
	CARGO="$(CARGO)" scripts/test-sanitized.sh

# Every method and unified's own tests with instrumented shaders; known failures of drivers and layers are listed in
# tests/expected_failures.toml. lavapipe optimises instrumented shaders for longer than it runs them, so it does not.
test-gpu-av: setup
	SSCT_GPU_AV=1 GALLIVM_PERF=nopt $(CARGO) test --test suite -- validation:: unified::

# Ten thousand frames while sizes and methods change: minutes.
soak: setup
	$(CARGO) test --test alone -- soak:: --ignored --nocapture

# The maps for Blender on frames that Blender renders; where Python 3.13 is not at hand, it says so.
test-blender: build
	scripts/test_blender.sh "$(BIN)" "$(OUT)/blender"

# The world reference against Mitsuba 3, which is installed from PyPI into a folder of its own.
MITSUBA = .venv-mitsuba/.mitsuba-3.9.1

$(MITSUBA):
	python3 -m venv .venv-mitsuba
	.venv-mitsuba/bin/pip install --quiet mitsuba==3.9.1 numpy pillow
	touch $@

test-mitsuba: build $(MITSUBA)
	@set -e; for of in "rooms corridor 0" "rooms corridor 0.1" "rooms window 0.6" "atrium hall 0.3"; do \
		set -- $$of; dir="$(OUT)/mitsuba/$$1-$$2-$$3"; \
		"$(BIN)" truth export --scene $$1 --view $$2 --roughness $$3 --size 160x90 --samples 256 -o "$$dir"; \
		.venv-mitsuba/bin/python scripts/mitsuba_compare.py "$$dir" --samples 256 --json "$$dir/report.json"; \
	done

# The walk of `traced` beside Embree's on one core; embreex is installed from PyPI into a folder of its own.
EMBREE = .venv-embree/.embreex-4.4.0

$(EMBREE):
	python3 -m venv .venv-embree
	.venv-embree/bin/pip install --quiet embreex==4.4.0.post1 numpy
	touch $@

embree: build $(EMBREE)
	.venv-embree/bin/python scripts/embree.py "$(BIN)" "$(OUT)/embree"

# A study on a real Slurm of four nodes, all on this machine, with killed tasks and a lost node. Installs Debian's
# slurmctld, slurmd, slurm-client and munge, and leaves no service running.
test-cluster: build
	scripts/cluster/test.sh "$(BIN)"

# A study in shards by Snakemake, which is installed from PyPI into a folder of its own.
SNAKEMAKE = .venv-snakemake/.snakemake-9.27.1

$(SNAKEMAKE):
	python3 -m venv .venv-snakemake
	.venv-snakemake/bin/pip install --quiet snakemake==9.27.1
	touch $@

test-snakemake: build $(SNAKEMAKE)
	scripts/cluster/test_snakemake.sh "$(BIN)" .venv-snakemake/bin/snakemake

# A quick study of this commit, added to the library of results in $(LIBRARY), and the page over all of them.
LIBRARY ?= library

library: build
	scripts/library.sh "$(BIN)" "$(LIBRARY)"

# Coverage-guided fuzzing of the loaders, so many executions of each target; logs go to $(OUT)/fuzz, and what the
# kept inputs (an archive a target, in fuzz/corpus) lack is added to them. `make test` replays them.
FUZZ_RUNS ?= 200000
FUZZ_TARGETS = obj gltf texture gbuffer gbuffer_map scene camera_path method includes run

fuzz: setup
	scripts/fuzz.sh build
	scripts/fuzz.sh run "$(OUT)/fuzz" $(FUZZ_RUNS) $(FUZZ_TARGETS)
	scripts/fuzz.sh merge "$(OUT)/fuzz" $(FUZZ_TARGETS)

lint: setup
	$(CARGO) fmt --check
	$(CARGO) fmt --check --manifest-path examples/wgpu/Cargo.toml
	$(CARGO) fmt --check --manifest-path examples/bevy/Cargo.toml
	$(CARGO) clippy --all-targets -- -D warnings
	$(CARGO) clippy --package ssct --features compile-shaders -- -D warnings
	$(CARGO) clippy --package ssct-c --features compile-shaders --all-targets -- -D warnings
	$(CARGO) clippy --package ssct-lab --features ssct-lab/tracy -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --no-deps

bench: setup
	$(CARGO) bench

# The window, which `ssct view` starts.
view: build
	$(CARGO) build --profile $(PROFILE) --bin ssct-view
	"$(BIN)" view

# The tables and numbers in README.md and docs/, from the records under benches/runs and the queries in lab/docs/queries, and the header
# for C. The program is a binary of the whole workspace, as in `build`.
docs: setup
	$(CARGO) run --quiet --bin ssct-docs
	SSCT_WRITE_DOCS=1 $(CARGO) test --test header

doc: setup
	$(CARGO) doc --no-deps
	$(CARGO) doc --no-deps --package ssct-lab --open

clean:
	$(CARGO) clean
	rm -rf $(OUT)
