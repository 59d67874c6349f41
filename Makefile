# Everything that a user or a machine runs. Each target installs what it needs first.

CARGO ?= cargo
OUT ?= out

.PHONY: all setup build study test lint bench view doc clean

all: build

setup:
	@scripts/setup.sh

build: setup
	$(CARGO) build --release

# Pictures, times and table 5.8 of the built-in scenes; the page is $(OUT)/index.html.
study: build
	target/release/ssct study -o $(OUT)

test: setup
	$(CARGO) test

lint: setup
	$(CARGO) fmt --check
	$(CARGO) clippy --all-targets -- -D warnings
	$(CARGO) clippy --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --no-deps

bench: setup
	$(CARGO) bench

view: build
	target/release/ssct view

doc: setup
	$(CARGO) doc --no-deps --open

clean:
	$(CARGO) clean
	rm -rf $(OUT)
