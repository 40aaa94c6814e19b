# `make demo` sets everything up and compares the solvers on the bundled Cornell box; `make test`
# sets everything up and runs the tests, `make atlas` those that take long.

.PHONY: demo test atlas hardware driver bench peers chart web dist pictures

demo: driver
	cargo run --release --locked

test: driver
	cargo test --workspace --locked

# The failure atlas, random scenes, and whatever needs the files of RADIOSITY_DATA.
atlas: driver
	cargo test --workspace --locked --test atlas

# Every stage of the GPU against its twin, and its times: out/hardware.html.
hardware: driver
	cargo run --release --locked -- hardware

bench: driver
	cargo bench --workspace --locked

peers:
	@sh scripts/embree.sh
	cargo bench --locked -p radiosity-benches --bench embree
	cargo run --release --locked -- solve scenes/cornell_box.obj --solver dense --out target/peers/cornell_box --quiet
	@sh scripts/mitsuba.sh target/peers/cornell_box $${RADIOSITY_DATA:+"$$RADIOSITY_DATA/truth/cornell_32"}

# Speed against accuracy on the bundled scenes, out/chart.html; interrupted, it goes on next time.
chart: driver
	cargo run --release --locked -- chart

# The article "Radiosity, step by step" and the live page as a static site in out/web. It needs no GPU.
web:
	@sh scripts/wasm.sh
	cargo build --release --locked --workspace --bin radiosity --bin web
	target/release/web target/release/radiosity out/web target/live.wasm

# The pictures of README.md and GUIDE.md; `make peers` before it puts Mitsuba into the chart.
pictures: driver
	cargo build --release --locked
	target/release/radiosity solve scenes/cornell_box.obj --solver cpu --out target/pictures/cornell --quiet
	cp target/pictures/cornell/preview.png docs/cornell.png
	target/release/radiosity relight --room scenes/paper_room.obj --object scenes/paper_objects.obj \
	    --solver cpu --out target/pictures/relit --quiet
	cp target/pictures/relit/composite.png docs/relit.png
	mkdir -p target/pictures/chart
	if [ -f out/peers.json ]; then cp out/peers.json target/pictures/chart; fi
	target/release/radiosity chart scenes/cornell_box.obj --solver cpu --out target/pictures/chart
	chromium --headless --no-sandbox --hide-scrollbars --window-size=980,600 \
	    --screenshot=docs/chart.png "file://$(CURDIR)/target/pictures/chart/chart.svg"

# The program as it is handed out: target/dist/radiosity, and its size in bytes.
dist:
	cargo build --profile dist --locked -p radiosity
	@wc -c target/dist/radiosity

driver:
	@sh scripts/driver.sh
