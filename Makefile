# make demo | test | build | bench | clean. Each installs what is missing first; each is safe to run twice.
BUILD ?= build
JOBS ?= $(shell nproc)
PYTHON := /usr/bin/python3
CMAKE_FLAGS = -DPYTHON_EXECUTABLE=$(PYTHON) -DPython3_EXECUTABLE=$(PYTHON) -DBATTERY_SOF_WERROR=ON

.PHONY: build demo test bench deps clean

deps:
	@scripts/install_dependencies

$(BUILD)/Makefile: CMakeLists.txt test/CMakeLists.txt package.xml | deps
	@scripts/with_ros cmake -S . -B "$(BUILD)" $(CMAKE_FLAGS)

build: deps $(BUILD)/Makefile
	@scripts/with_ros cmake --build "$(BUILD)" -j$(JOBS)

demo: build
	@scripts/demo "$(BUILD)"

test: build
	@scripts/with_ros cmake --build "$(BUILD)" --target tests -j$(JOBS)
	@cd "$(BUILD)" && CTEST_OUTPUT_ON_FAILURE=1 ../scripts/with_ros ctest --no-tests=error

bench: deps
	@scripts/with_ros cmake -S . -B "$(BUILD)" $(CMAKE_FLAGS) -DBATTERY_SOF_BENCH=ON
	@scripts/with_ros cmake --build "$(BUILD)" --target bench_all -j$(JOBS)
	@scripts/bench "$(BUILD)"

clean:
	rm -rf "$(BUILD)"
