# make demo   a picture of the demo scene, from a fresh clone
# make test   everything that must hold
# make build  the program, target/release/bendylights
#
# Needs Rust and, on Debian, nothing else: `make packages` installs what is missing, with sudo only where that is needed.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.PHONY: build demo test packages

PICTURE := demo.png
export CARGO_TERM_COLOR ?= auto

build: packages
	cargo build --release --locked -p bendylights
	@echo "Built target/release/bendylights; try: target/release/bendylights --help"

demo: build
	target/release/bendylights render demo:vases --samples 16 -o $(PICTURE)
	@echo "The picture is $(CURDIR)/$(PICTURE)"

test: packages
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
	cargo test --workspace --locked

# A C compiler and linker, a Vulkan driver that needs no GPU (Mesa's lavapipe) and its loader, and systemd-analyze for
# the test of the unit in deploy/.
PACKAGES := gcc libc6-dev libvulkan1 mesa-vulkan-drivers systemd

packages:
	@command -v cargo > /dev/null || { echo "Rust is missing: install it from your distribution or rustup.rs"; exit 1; }
	@if ! command -v dpkg-query > /dev/null; then \
	  echo "Not Debian: if anything is missing below, install the equals of: $(PACKAGES)"; exit 0; fi; \
	missing=(); \
	for package in $(PACKAGES); do \
	  [[ $$(dpkg-query -W -f '$${Status}' $$package 2> /dev/null || true) == *' installed' ]] || missing+=($$package); \
	done; \
	if (( $${#missing[@]} == 0 )); then exit 0; fi; \
	sudo=$$( (( EUID == 0 )) || echo sudo ); \
	echo "Installing: $${missing[*]}$${sudo:+ (with sudo)}"; \
	$$sudo apt-get update -q; \
	$$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$${missing[@]}"
