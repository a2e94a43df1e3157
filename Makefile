# Vulkan's layers print a harmless line where it is not set.
export XDG_RUNTIME_DIR ?= /tmp

DEMOS := screens pool

# What SwiftShader is not asked: scenes that take it minutes; what hardly asks a kernel; and bench,
# which compares with the driver's own rasterizer, whose corners snap to 1/16 texel there (1/256 on
# most: crates/gobo-cli/src/bench/raster/agree.rs).
SWIFTSHADER_SKIPS := a_million a_hundred_thousand more_tiles \
	cli:: dither_figures:: bench::

.PHONY: demo program gallery pictures farm examples features test test-slow units test-all test-swiftshader test-mesa test-widths web-test web-kernels web-page export-check gpu-static gpu gpu-pack gpu-pack-test ash web view-test c release-check semver first-minute bevy fuzz soak doc deny foreign \
	bench profile results native tables quality man python test-python setup

# Renders two scenes of data/gallery/ and says where the pictures are.
demo: setup
	@for scene in $(DEMOS); do \
		cargo run --release --quiet -- render data/gallery/$$scene.toml -o out/$$scene || exit; \
	done

# Every scene of data/gallery, a contact sheet and a page with maps, times and counts; fails where a
# picture is missing or shows nothing.
gallery: setup
	cargo run --release --quiet --example gallery

# The program that the checks below run: built, unless GOBO names one.
program: setup
	@[ -n "$(GOBO)" ] || cargo build --release --quiet

# The pictures of the documents, each by the command beside it (docs/pictures.toml): those that differ are made anew. CHECK=1 lists them,
# with status 1, and writes none; ONLY="soft_ glass": those whose path has one of the words. Pillow, numpy and matplotlib come from PyPI.
pictures: program
	@[ -x target/pictures/bin/python ] || python3 -m venv target/pictures
	@target/pictures/bin/python -m pip install --quiet --disable-pip-version-check 'pillow>=10.1' numpy matplotlib
	@target/pictures/bin/python tools/pictures.py

# Eight frames by two farm engines on this machine (tools/farm): after lost, damaged and killed ones the
# same files. Fetches the engines from PyPI.
farm: setup
	cargo build --release --quiet
	sh tools/farm/try.sh

# Hosts of several kinds, each of which fails where it sees something wrong.
examples: setup
	@for example in minimal embed warm_up gpu_particles host_splats host_grid host_renderer; do \
		cargo run --quiet --example $$example || exit; \
	done
	cargo run --quiet --example frame_cost

# Most of the time lavapipe compiles kernels, each on one core: without LLVM's optimisations in half
# of it, to the same results, and with other tests beside.
SUITE := GALLIVM_PERF=nopt RUST_TEST_THREADS=4 cargo test --test root --
# More than half of the suite's time: 64 points on a light, sequences of pictures, many processes.
SLOW = $(shell cat tests/slow.txt)

# All but the slow ones.
test: setup
	@$(SUITE) --exact $(addprefix --skip ,$(SLOW))
	cargo test --quiet --doc

test-slow: setup
	@$(SUITE) --exact $(SLOW)

# Tests of which `make test` asks some on one tier alone.
BY_TIER := maps:: picture:: guest:: contract::recording

# Units, for which each crate is compiled once more.
units:
	cargo test --lib --bins

# And what both leave out: units, long sweeps, and maps and pictures on the other tiers.
test-all: test test-slow units program
	sh tools/gpu_static.sh --all
	GOBO_TEST_TIERS=all $(SUITE) --include-ignored $(BY_TIER)
	$(SUITE) --ignored $(addprefix --skip ,$(BY_TIER))

# The kernels against their CPU references on a second driver, SwiftShader (subgroups of 4).
test-swiftshader: setup
	GOBO_TEST_TIERS=all sh tools/swiftshader.sh cargo test --test root -- $(addprefix --skip ,$(SWIFTSHADER_SKIPS))

# What `make test` asks, on the lavapipe of a newer Mesa (tools/mesa.sh).
test-mesa: setup
	@sh tools/mesa.sh env $(SUITE) --exact $(addprefix --skip ,$(SLOW))

# On lavapipe with subgroups of 4 and 16 lanes instead of 8: stages, maps and pictures. Mesa's cache knows no widths.
test-widths: setup
	@for bits in 128 512; do \
		MESA_SHADER_CACHE_DIR=target/shaders/$$bits LP_NATIVE_VECTOR_WIDTH=$$bits $(SUITE) stages:: maps:: picture:: || exit; \
	done

# In a headless Chromium on SwiftShader: every exported kernel of core, and with subgroups where it has them, by its WGSL
# compiler, Tint; and the page and the npm package of crates/gobo-web, as visitors use them, beside native pictures.
web-test: web-kernels web-page

# The page and the package alone.
web-page:
	sh tools/web_page.sh

# The kernels alone.
web-kernels: program
	sh tools/web_kernels.sh

# The page, dist/web, which any server shows, and the npm package, dist/npm and its tarball.
web:
	sh tools/web.sh

# `gobo view` on a screen without a monitor (Xvfb, which `make setup` does not install).
view-test: setup
	sh tools/view.sh

# The interface for C, crates/gobo-c: its tests, and a C++ program whose maps are those of `gobo render --maps`, bit for bit.
c: program
	sh tools/c.sh

# The example of bevy_gobo (examples/bevy) without a window: fails if its picture is flat or grey.
bevy: setup
	sh tools/bevy.sh

# Every exported kernel through spirv-val and glslangValidator.
export-check: program
	sh tools/export_check.sh

# dist/gpu-pack.tar.gz: what measures a card on a machine without Rust, network and sources (tools/gpu_pack/run.sh), and its
# proof on this machine's driver.
gpu-pack: program
	sh tools/gpu_pack.sh

gpu-pack-test: gpu-pack
	sh tools/gpu_pack_test.sh

# The same on this machine's driver: benches/results/<device>.json, and a page in target/gpu-pack/results. GOBO_PACK_SMALL=1: smaller cases.
gpu: gpu-pack
	sh tools/gpu.sh

# What exported kernels need on GPUs (registers, spills, code), by a GPU's compiler without one: tools/gpu_static/limits.toml.
gpu-static: program
	sh tools/gpu_static.sh

# Exported frames run by Vulkan alone, without wgpu: the same maps bit for bit.
ash: program
	sh tools/ash.sh

# Each reader of files on changed ones, FUZZ_SECONDS of CPU time each: fails where one panics, hangs or takes 2 GiB, or what it accepts cannot be
# rendered, and keeps what made it.
fuzz: program
	cargo run --release --quiet --example fuzz

# Files that other programs write (from npm, PyPI and Debian), beside numbers of numpy: a table, which fails where one is wrong.
foreign: program
	sh tools/foreign/run.sh

# Memory over 2,000 frames of one run: fails where it grows.
soak: program
	sh tools/soak.sh

# The pages of all crates without a warning.
doc:
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --lib --quiet

# README's first minute as strangers run it, each line timed from nothing: needs Xvfb and Chromium, and half an hour.
first-minute:
	sh tools/first_minute.sh

# What the registries would get, and dry runs: docs/release.md. Publishes nothing.
release-check:
	sh tools/release_check.sh

# Changes of the crates' interfaces since a version that its number does not allow: BASE=v0.3.0, by default the last tag.
BASE ?= $(shell git describe --tags --abbrev=0 --match 'v*' 2>/dev/null)
semver:
	@[ -n "$(BASE)" ] || { echo "semver: there is no tag yet: name a commit, BASE=.." >&2; exit 1; }
	@command -v cargo-semver-checks >/dev/null || cargo install --debug --locked --quiet cargo-semver-checks
	cargo semver-checks --baseline-rev $(BASE) -p gobo -p gobo-reference -p gobo-scene -p gobo-picture -p gobo-cli

# Licences, sources and, as far as they can be read, advisories of what each workspace depends on: deny.toml.
deny:
	@command -v cargo-deny >/dev/null || cargo install --debug --locked --quiet cargo-deny
	@for manifest in $$(git ls-files '*Cargo.lock' | sed 's/lock$$/toml/'); do \
		echo $$manifest; \
		cargo deny --manifest-path $$manifest --all-features --config $$PWD/deny.toml check licenses bans sources || exit; \
		cargo deny --manifest-path $$manifest --all-features --config $$PWD/deny.toml check advisories || \
			echo "deny: the advisories above, or their database cannot be read here" >&2; \
	done

# Shadow maps beside the raster pipeline: a quick table, and a page with plots.
bench: setup
	cargo run --release --quiet -- bench --casters 10k,100k --vs raster --html bench.html
	@echo "The plots are in bench.html."

# Where whole commands spend their time, tiny pictures of data/gallery and of five million particles: GOBO_OLD=path beside another
# program, SCENES="pool wine" alone.
profile: setup
	@[ -n "$(GOBO)" ] || cargo build --release --quiet
	@python3 tools/profile.py

# The cases that the README shows, as benches/results/$(DEVICE).json: close what else runs. Then what core costs beside
# the device's tier.
DEVICE := llvmpipe
CASES := 10kx6,100kx16,1mx16,1mx6,1mx0.5,1mx16@1
results: setup
	@mkdir -p benches/results
	cargo run --release --quiet -- bench --case $(CASES) --vs raster --runs 9 \
		--json benches/results/$(DEVICE).json
	python3 tools/core_cost.py target/release/gobo $(CASES) benches/results/$(DEVICE)-core.json

# Kernels beside loops for the CPU that do the same work.
native: setup
	cargo bench --quiet -p gobo-benches --bench native

# The figures of docs/dither.md, and what a frame of many views asks of a GPU (benches/NOTES.md).
tables: setup
	cargo run --release --quiet --example dither_tables
	cargo run --release --quiet --example view_tables

# The figures of docs/curves.md.
quality: setup
	cargo run --release --quiet --example curve_tables

# The library feature by feature, and it, scenes and pictures for a browser.
features:
	@for features in "" device export serde; do \
		cargo clippy --quiet -p gobo --lib --features "$$features" -- -D warnings || exit; \
	done
	@rustup target add wasm32-unknown-unknown
	cargo clippy --quiet -p gobo --lib --target wasm32-unknown-unknown -- -D warnings
	cargo clippy --quiet -p gobo -p gobo-scene -p gobo-picture --lib --features gobo/webgpu \
		--target wasm32-unknown-unknown -- -D warnings
	@echo "Crates of the bare library, its own included:"
	@cargo tree -p gobo --no-dedupe -e normal --prefix none | sort -u | wc -l

# Pages of the manual, target/man, and completions for shells, target/completions.
man:
	cargo build --release --quiet
	@mkdir -p target/completions
	target/release/gobo man -o target/man
	@for shell in bash elvish fish powershell zsh; do \
		target/release/gobo completions $$shell > target/completions/gobo.$$shell || exit; \
	done
	@echo target/completions

# The Python package, dist/*.whl: for every CPython from 3.9 on.
python:
	sh tools/python.sh wheel

# Its tests, in an environment of their own.
test-python: setup
	sh tools/python.sh test

# Installs a Vulkan driver and a C++ compiler where they are missing.
setup:
	@sh tools/setup.sh
