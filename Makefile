# Two commands: `make demo` sets everything up and compares the solvers on the bundled Cornell
# box; `make test` sets everything up and runs all tests.

.PHONY: demo test driver bench chart

demo: driver
	cargo run --release --locked

test: driver
	cargo test --workspace --locked

bench: driver
	cargo bench --workspace --locked

# Speed against accuracy on the bundled scenes, out/chart.html; interrupted, it goes on next time.
chart: driver
	cargo run --release --locked -- chart

driver:
	@sh scripts/driver.sh
