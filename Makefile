# Vulkan's layers print a harmless line where it is not set.
export XDG_RUNTIME_DIR ?= /tmp

DEMOS := smoke glass

.PHONY: demo test setup

# Renders the scenes of data/ and says where the pictures are.
demo: setup
	@for scene in $(DEMOS); do \
		cargo run --release --quiet -- render data/$$scene.toml -o out/$$scene --maps || exit; \
	done
	@echo "The pictures are above; the shadow maps are in out/*/maps/."

test: setup
	cargo test

# Installs a Vulkan driver and a C++ compiler where they are missing.
setup:
	@sh tools/setup.sh
