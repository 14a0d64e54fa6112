# make demo     the demo scene in a browser, from a fresh clone; LISTEN=9000 for another port
# make test     everything that must hold
# make check    formatting, clippy and unit tests, while you work
# make build    the program with its page inside, target/release/bendylights
# make install  the same, put where cargo puts programs: ~/.cargo/bin
# make studies  target/release/bendylights-studies, measurements of the light model that do not ship
#
# Needs Rust and Node.js; what else is missing, `make packages` installs on Debian, with sudo only where that is needed.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.PHONY: build install studies page demo test check packages test-packages openapi-tools

PAGE_SOURCES := $(shell find web-client/src web-client/public -type f) $(wildcard web-client/*.html web-client/*.ts web-client/*.json)

DATA := demo-data
LISTEN := 127.0.0.1:8080
# `dev` takes the build of the tests: alone, the program's crates would be compiled again without the features that only
# tests enable.
PROFILE := release
PROGRAM := $(or $(CARGO_TARGET_DIR),target)/$(if $(filter dev,$(PROFILE)),debug,$(PROFILE))/bendylights
export CARGO_TERM_COLOR ?= auto

build: packages page
	cargo build --profile $(PROFILE) --locked $(if $(filter dev,$(PROFILE)),--workspace --bins --tests,-p bendylights)
	@echo "Built $(PROGRAM); try: $(PROGRAM) --help"

install: packages page
	cargo install --locked --path crates/bendylights

studies: packages
	cargo build --release --locked -p studies

# Neither is done again without a change: a test runs `make demo` while others use the packages and the page.
page: web-client/dist/index.html

web-client/node_modules/.package-lock.json: web-client/package-lock.json | packages
	cd web-client && npm ci --no-audit --no-fund --loglevel=error
	touch $@

web-client/dist/index.html: web-client/node_modules/.package-lock.json $(PAGE_SOURCES)
	cd web-client && npm run --silent build

# Open the address that it prints; stop it with Ctrl+C. What was edited is in $(DATA) and there at the next start.
demo: build
	$(PROGRAM) serve --data $(DATA) --listen $(LISTEN)

test: packages test-packages page openapi-tools
	cd web-client && npm run --silent check && npm test
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
	@$(if $(SHARED_ASSETS),,echo "../shared/assets is missing: what needs it stays ignored")
	RUST_TEST_THREADS=$(TEST_THREADS) cargo test --workspace --locked -- --include-ignored --skip child_that_ $(if $(SHARED_ASSETS),,--skip shared_assets)

# The inner loop: what a change of code breaks at once.
check: packages
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	cargo test --workspace --locked --lib --bins

# Tests wait for browsers, servers and disks, so that cores idle with one thread each. Three a core took longer than two.
TEST_THREADS = $(shell echo $$((2 * $$(getconf _NPROCESSORS_ONLN))))

# Scenes of other makers, beside the checkout and not part of it. CI promises them: where they are missing its tests fail.
SHARED_ASSETS := $(or $(wildcard ../shared/assets),$(filter true,$(CI)))

# Compilers of C and C++ and a linker.
PACKAGES := gcc g++ libc6-dev
# Where Debian 12, whose lavapipe is of Mesa 22, keeps one of Mesa 25. That one jumps over branches in shaders; 22 runs both sides.
BACKPORTS := http://deb.debian.org/debian
# A Vulkan driver that needs no GPU (Mesa's lavapipe) and its loader, for tests of wgpu. A browser for the page, strace to see that what is acknowledged is on disk, curl and jq for the commands of README and docs, systemd-analyze
# for the units in deploy/, nginx and Caddy for its snippets, and Python for the tools that check openapi.json.
TEST_PACKAGES := libvulkan1 mesa-vulkan-drivers chromium-headless-shell strace curl jq systemd nginx-light caddy python3 python3-venv

packages:
	@command -v cargo > /dev/null || { echo "Rust is missing: install it from your distribution or rustup.rs"; exit 1; }
	@node -e 'const [a, b] = process.versions.node.split(".").map(Number); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)' 2> /dev/null \
	  || { echo "Node.js 20.19 or newer is missing, which builds the page: install it from your distribution or nodejs.org"; exit 1; }
	@$(call install,$(PACKAGES))

test-packages: packages
	@$(upgrade-mesa)
	@$(call install,$(TEST_PACKAGES))

openapi-tools: target/openapi-tools/installed

target/openapi-tools/installed: tests/openapi/requirements.txt | test-packages
	python3 -m venv --clear target/openapi-tools
	target/openapi-tools/bin/pip install --quiet --disable-pip-version-check --requirement $<
	touch $@

# From lists of its own, so that the system's sources stay as they are and nobody is asked for a password in vain; without
# them the distribution's package is installed below. Nothing is removed for it.
define upgrade-mesa
mesa=$$(dpkg-query -W -f '$${db:Status-Status} $${Version}' mesa-vulkan-drivers 2> /dev/null | sed -n 's/^installed //p' || true); \
if ! grep -qsx 'VERSION_CODENAME=bookworm' /etc/os-release || dpkg --compare-versions "$$mesa" ge 25; then exit 0; fi; \
sudo=$$( (( EUID == 0 )) || echo sudo ); \
echo "Installing: mesa-vulkan-drivers from bookworm-backports, whose Mesa 25 draws faster than Debian 12's 22$${sudo:+ (with sudo)}"; \
apt=$$(mktemp -d); trap 'rm -rf "$$apt"' EXIT; chmod 755 "$$apt"; \
mkdir -p "$$apt"/{sources,lists/partial,cache/archives/partial}; \
cp -r /etc/apt/sources.list.d/. "$$apt/sources" || true; \
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $(BACKPORTS) bookworm-backports main" > "$$apt/sources/bookworm-backports.list"; \
lists=(-o Dir::Etc::sourceparts="$$apt/sources" -o Dir::State::lists="$$apt/lists" -o Dir::Cache="$$apt/cache"); \
apt-get update -q "$${lists[@]}" -o Acquire::Retries=1 -o Acquire::http::Timeout=10 \
  && $$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends --no-remove "$${lists[@]}" \
    mesa-vulkan-drivers/bookworm-backports \
  || echo "Mesa 25 cannot be had from $(BACKPORTS): the distribution's will do, but draws slower"
endef

define install
if ! command -v dpkg-query > /dev/null; then \
  echo "Not Debian: if anything is missing below, install the equals of: $(1)"; exit 0; fi; \
missing=(); \
for package in $(1); do \
  [[ $$(dpkg-query -W -f '$${Status}' $$package 2> /dev/null || true) == *' installed' ]] || missing+=($$package); \
done; \
if (( $${#missing[@]} == 0 )); then exit 0; fi; \
sudo=$$( (( EUID == 0 )) || echo sudo ); \
echo "Installing: $${missing[*]}$${sudo:+ (with sudo)}"; \
$$sudo apt-get update -q; \
$$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$${missing[@]}"
endef
