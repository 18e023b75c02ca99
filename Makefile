# make demo | test | test-slow | test-all | test-core | tidy | docs | deb | try-deb | try-wheel | sanitize | fuzz | tsan | soak | stress | build | bench | reproduce | study | calibrate | proof | proof-quick | clean. Each installs what is missing first; each is safe to run twice.
BUILD ?= build
BUILD_CORE ?= $(BUILD)/core
BUILD_SANITIZED ?= $(BUILD)/sanitized
# Hidden: roslaunch looks for programs everywhere below the package.
BUILD_TSAN ?= $(BUILD)/.tsan
SECONDS ?= 60
JOBS ?= $(shell nproc)
PYTHON := /usr/bin/python3
CMAKE_FLAGS = -DPYTHON_EXECUTABLE=$(PYTHON) -DPython3_EXECUTABLE=$(PYTHON) -DBATTERY_SOF_WERROR=ON

CONFIGURE = bash scripts/with_ros cmake -S . -B "$(BUILD)" $(CMAKE_FLAGS)
COMPILE = bash scripts/with_ros cmake --build "$(BUILD)" -j$(JOBS)
CTEST = cd "$(BUILD)" && CTEST_OUTPUT_ON_FAILURE=1 bash "$(CURDIR)/scripts/with_ros" ctest -j$(JOBS) --no-tests=error

.PHONY: build demo docs deb try-deb try-wheel test test-slow test-all tests test-core tidy sanitized sanitize fuzz tsan soak stress bench reproduce study calibrate proof proof-quick clean

# The packages of a target: scripts/install_dependencies has the lists.
deps-%:
	@bash scripts/install_dependencies $*

# demo configures without tests and Python, build with Python, test with both. What a folder has been configured for stays, so that
# targets may be made in any order.
demo: deps-demo
	@[ -f "$(BUILD)/Makefile" ] || $(CONFIGURE) -DCATKIN_ENABLE_TESTING=OFF -DBATTERY_SOF_PYTHON=OFF
	@$(COMPILE) --target sof battery_sof_node battery_sof_generate_messages_cpp battery_sof_generate_messages_py
	@bash scripts/demo "$(BUILD)"

build: deps-build
	@[ -f "$(BUILD)/.with_python" ] || { $(CONFIGURE) -DCATKIN_ENABLE_TESTING=OFF -DBATTERY_SOF_PYTHON=ON && touch "$(BUILD)/.with_python"; }
	@$(COMPILE)

tests: deps-test
	@[ -f "$(BUILD)/.with_tests" ] || { $(CONFIGURE) -DCATKIN_ENABLE_TESTING=ON -DBATTERY_SOF_PYTHON=ON && touch "$(BUILD)/.with_python" "$(BUILD)/.with_tests"; }
	@$(COMPILE) --target all tests

# All but what is labelled slow (test/catkin_only.cmake), which is test-slow; both are test-all.
test: tests
	@$(CTEST) -LE slow

# The benchmarks are compiled with it, so that a change of the library does not break them unseen.
test-slow: tests deps-bench
	@$(CONFIGURE) -DBATTERY_SOF_BENCH=ON
	@$(COMPILE) --target bench_all
	@$(CTEST) -L slow

test-all: tests
	@$(CTEST)

# The pages as a site: build/docs/index.html. A link that leads nowhere ends it.
docs: deps-docs
	@$(PYTHON) scripts/make_docs "$(BUILD)/docs"

# The packages of Debian 12 in build/deb, built in a clean root file system (as root); try-deb installs them in a bare one and asks.
deb: deps-deb
	@root=$$(mktemp -d) && bash scripts/try_dockerfile --file debian/Dockerfile "$$root" && mkdir -p "$(BUILD)/deb" && \
	  cp "$$root"/build/*.deb "$(BUILD)/deb/" && rm -rf --one-file-system "$$root" && ls -l "$(BUILD)/deb"

try-deb: deps-deb
	@root=$$(mktemp -d) && bash scripts/try_dockerfile --file debian/try.Dockerfile --context "$(BUILD)/deb" "$$root" && rm -rf --one-file-system "$$root"

# The wheel in build/wheel, by Debian's Python and without ROS, installed in a virtual environment and asked.
try-wheel: deps-wheel
	@CMAKE_BUILD_PARALLEL_LEVEL=$(JOBS) bash scripts/try_wheel "$(BUILD)/wheel"

# The build without ROS (docs/cpp-and-python.md), and what can differ in it: files and commands, the installed package, Python. Each file
# is compiled by itself, as it stands.
test-core: deps-test-core
	@cmake -S . -B "$(BUILD_CORE)" -DBATTERY_SOF_ROS=OFF -DBATTERY_SOF_QUICK_BUILD=OFF $(CMAKE_FLAGS)
	@cmake --build "$(BUILD_CORE)" --target core_checks -j$(JOBS)
	@cd "$(BUILD_CORE)" && ctest -L core_checks --output-on-failure --no-tests=error

# clang-tidy over all of src and include: an hour of one core. ctest -R tidy looks at what has changed.
tidy: deps-test build
	@$(PYTHON) scripts/tidy "$(BUILD)" --jobs $(JOBS)

# The core once more with AddressSanitizer, UndefinedBehaviorSanitizer and assertions (docs/reliability.md), by clang.
sanitized:
	@bash scripts/install_dependencies test-core clang libclang-rt-dev
	@cmake -S . -B "$(BUILD_SANITIZED)" -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo -DBATTERY_SOF_ROS=OFF -DBATTERY_SOF_PYTHON=OFF -DBATTERY_SOF_FUZZ=ON

# The unit tests under the sanitizers: an hour on two cores.
sanitize: sanitized
	@cmake --build "$(BUILD_SANITIZED)" -j$(JOBS)
	@cd "$(BUILD_SANITIZED)" && UBSAN_OPTIONS=print_stacktrace=1 ctest -E outside_project --output-on-failure --no-tests=error

# Each fuzz target for SECONDS.
fuzz: sanitized
	@cmake --build "$(BUILD_SANITIZED)" --target fuzz_targets -j$(JOBS)
	@bash scripts/fuzz "$(BUILD_SANITIZED)" $(SECONDS)

# The node's threads under ThreadSanitizer (docs/reliability.md): some minutes once it is built.
tsan: deps-test
	@bash scripts/with_ros cmake -S . -B "$(BUILD_TSAN)" $(CMAKE_FLAGS) -DBATTERY_SOF_PYTHON=OFF -DBATTERY_SOF_SANITIZE_THREADS=ON
	@bash scripts/with_ros cmake --build "$(BUILD_TSAN)" --target battery_sof_node sof simulate_city_drive node_options_test -j$(JOBS)
	@bash scripts/tsan "$(BUILD_TSAN)"

# The node through HOURS of driving, fifty times as fast: memory, files, threads (docs/reliability.md). A day takes half an hour.
HOURS ?= 24
soak: deps-study build
	@bash scripts/with_ros bash -c '. "$$0/devel/setup.sh" && exec $(PYTHON) scripts/stress soak "$$0" --hours $(HOURS)' "$(BUILD)"

# The node killed a hundred times, with more clients and samples than a car has, and on disks that are full or gone (root: mounts a tmpfs).
stress: deps-study build
	@for kind in kill overload disk; do \
	  bash scripts/with_ros bash -c '. "$$0/devel/setup.sh" && exec $(PYTHON) scripts/stress "$$1" "$$0"' "$(BUILD)" $$kind || exit 1; done

bench: deps-bench
	@bash scripts/with_ros cmake -S . -B "$(BUILD)" $(CMAKE_FLAGS) -DBATTERY_SOF_BENCH=ON
	@bash scripts/with_ros cmake --build "$(BUILD)" --target bench_all query_bench sof battery_sof_node -j$(JOBS)
	@$(PYTHON) scripts/bench "$(BUILD)"
	@$(PYTHON) scripts/bench_composed "$(BUILD)"
	@bash scripts/with_ros bash -c '. "$$0/devel/setup.sh" && exec $(PYTHON) scripts/bench_queries "$$0" 60' "$(BUILD)"

reproduce: deps-study build
	@bash scripts/with_ros cmake --build "$(BUILD)" --target experiment -j$(JOBS)
	@$(PYTHON) scripts/reproduce "$(BUILD)"

# DATA: folder with startstop_car/, for the real recordings.
study: deps-study build
	@bash scripts/with_ros cmake --build "$(BUILD)" --target experiment -j$(JOBS)
	@$(PYTHON) scripts/study "$(BUILD)" $(if $(DATA),--data "$(DATA)")

# Effects, nulls, decoys and unknowns counted: some 40 minutes on two cores, goes on where it was cut off.
calibrate: deps-study build
	@$(PYTHON) scripts/calibrate_diagnosis "$(BUILD)" --first-seed 1001 --set null=200 structural_null=60 effect=10 decoy=3 unknown=4

# The sealed benchmark: the committed seal drawn again and its digest compared, then run and scored into build/proof/sealed; goes on where it was cut off.
proof: deps-study build
	@$(PYTHON) scripts/proof sealed --build "$(BUILD)" --docs docs/proof --out "$(BUILD)/proof/sealed"

# A tenth of it (own fixed seal) with bounds.
proof-quick: deps-study build
	@$(PYTHON) scripts/proof quick --build "$(BUILD)" --seal test/proof/quick --out "$(BUILD)/proof/quick"

clean:
	rm -rf "$(BUILD)"
