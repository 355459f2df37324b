# The front door: wraps the presets of CMakePresets.json. `make help` lists the targets.
#
#   TULLE_NO_INSTALL=1   install no packages, only say which are missing
#   JOBS=N               parallel jobs (default: one per processor)
#   PREFIX=DIR           where `make install` installs (default /usr/local; DESTDIR is heeded)

BUILD := build/release
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
PREFIX ?= /usr/local
# A test may take 600 s; where tests take long, the target has a longer limit.
CTEST := ctest --output-on-failure --no-tests=error -j $(JOBS) --timeout 600
CHECK_PACKAGES := TULLE_NO_INSTALL=1 sh tools/install_packages.sh
INSTALL_PACKAGES := sh tools/install_packages.sh

.PHONY: all view demo pictures fabric-pictures paper paper-quick paper-pictures test test-formats test-long test-asan test-ubsan test-tsan test-msan test-clang test-musl test-m32 test-native python viewer wheel test-python test-python-asan test-blender blender-addon test-notebooks test-view view-pictures coverage check-arm64 check-portability bench bench-compare bench-detect bench-peers validate soak mutate fuzz fuzz-all fuzz-afl fuzz-keep docs test-docs test-sweep install format check-format layers sizes clean help
.NOTPARALLEL:

# The program at build/release/tulle, libtulle.so and libtulle.a beside it.
all:
	@$(CHECK_PACKAGES) build
	@$(MAKE) --no-print-directory build-program

.PHONY: build-program build-tests
build-program:
	@[ -f $(BUILD)/CMakeCache.txt ] || cmake --preset release -DTULLE_BUILD_TESTS=OFF
	@cmake --build $(BUILD) -j $(JOBS) --target tulle_program tulle_shared tulle_static tulle_io_shared tulle_io_static

build-tests:
	@cmake --preset release -DTULLE_BUILD_TESTS=ON -DTULLE_WARNINGS_AS_ERRORS=ON
	@cmake --build $(BUILD) -j $(JOBS)

# The same with `tulle view`: libwebsockets, and a page that npm makes, which becomes part of the program.
view:
	@$(INSTALL_PACKAGES) build view
	@[ -f $(BUILD)/CMakeCache.txt ] || cmake --preset release -DTULLE_BUILD_TESTS=OFF
	@cmake $(BUILD) -DTULLE_VIEW=on >/dev/null
	@$(MAKE) --no-print-directory build-program

# The page of tulle view in a browser: watching, holding, editing, keys, small screens, rates. PATTERN='holding|tour' chooses.
PATTERN ?=
test-view: view
	@$(INSTALL_PACKAGES) test view-test
	@sh web/test.sh $(BUILD)/tulle '$(PATTERN)'
	@$(MAKE) --no-print-directory build-tests
	@cd $(BUILD) && ctest -R 'view' --output-on-failure

# The pictures of the tour in docs/guide/view.md, which the test makes.
view-pictures:
	@$(MAKE) --no-print-directory test-view PATTERN=tour
	@for picture in watch pick hold edit phone; do cp build/web/pictures/tour_$$picture.png docs/pictures/view/$$picture.png; done

# Simulates scenes/needles.yaml, judges every frame, tells how to look at it.
demo:
	@$(INSTALL_PACKAGES) build
	@$(MAKE) --no-print-directory build-program
	@bash tools/demo.sh $(BUILD)/tulle

# The pictures of README.md: runs the scenes of scenes/ into out/pictures (an hour), renders docs/pictures.
pictures:
	@$(INSTALL_PACKAGES) build
	@$(MAKE) --no-print-directory build-program
	@bash tools/pictures.sh $(BUILD)/tulle

# The pictures of docs/pictures/fabric: each fabric on a pedestal, springs beside woven cloth (half an hour).
fabric-pictures:
	@$(INSTALL_PACKAGES) build paper
	@$(MAKE) --no-print-directory build-program
	@"$$(sh paper/find_python.sh 'PIL, matplotlib')" tools/draw_fabrics.py $(BUILD)/tulle

# The figures and tables of the paper again, with a report in reproduced/report.html (two hours), or with coarse cloth and short
# runs in reproduced-quick (minutes): lab/paper.md. What was interrupted goes on. PAPER_OPTIONS='--threads 1'
# and PAPER_FIGURES='fig7 table1' choose.
PAPER_FIGURES ?= all
PAPER_OPTIONS ?=
REPRODUCE := sh paper/reproduce.sh $(PAPER_FIGURES) --tulle $(BUILD)/tulle $(PAPER_OPTIONS)
paper: build-paper
	@$(REPRODUCE)

paper-quick: build-paper
	@$(REPRODUCE) --quick

.PHONY: build-paper
build-paper:
	@$(INSTALL_PACKAGES) build paper
	@$(MAKE) --no-print-directory build-program
	@cmake $(BUILD) >/dev/null
	@cmake --build $(BUILD) -j $(JOBS) --target paper_measure tulle_python

# The pictures of docs/pictures/paper, of what `make paper` left in DIR.
DIR ?= reproduced
paper-pictures:
	@$(INSTALL_PACKAGES) paper
	@bash paper/pictures.sh $(DIR)

# The Python package in this checkout: PYTHONPATH=build/release/python python3 -c 'import tulle'. docs/guide/python.md.
FIND_PYTHON := sh paper/find_python.sh
python:
	@$(INSTALL_PACKAGES) build python
	@$(MAKE) --no-print-directory build-program
	@cmake $(BUILD) >/dev/null
	@cmake --build $(BUILD) -j $(JOBS) --target tulle_python

# What turns worlds in notebooks, viewer.js of the package: docs/guide/notebooks.md. Its packages come from npm, into build/viewer.
viewer: python
	@$(INSTALL_PACKAGES) viewer
	@sh python/viewer/build.sh
	@cp python/tulle/viewer.js $(BUILD)/python/tulle

# The package with the libraries and the program inside, and its sources, in build/wheel: pip install build/wheel/tulle-*.whl
wheel:
	@$(INSTALL_PACKAGES) build python wheel viewer
	@sh python/viewer/build.sh --optional
	@JOBS=$(JOBS) "$$($(FIND_PYTHON) 'cffi, numpy, build.__main__')" -m build --no-isolation --outdir build/wheel .

# The package's types and tests, then those of the wheel in an environment of its own. PYTEST_OPTIONS='-k arrays' chooses.
PYTEST_OPTIONS ?=
PYTEST = "$$($(FIND_PYTHON) 'cffi, numpy, pytest')" -m pytest -q -p no:cacheprovider $(PYTEST_OPTIONS)
test-python: python
	@$(INSTALL_PACKAGES) wheel python-test
	@MYPYPATH=$(BUILD)/python mypy --cache-dir build/mypy -p tulle
	@PYTHONPATH=$(BUILD)/python $(PYTEST)
	@sh tools/test_wheel.sh

# The viewer of notebooks in a browser: what it draws, keys, a page of an executed notebook, no request to anyone. A minute.
test-notebooks: viewer
	@$(INSTALL_PACKAGES) python-test notebook-test
	@PYTHONPATH=$(BUILD)/python sh python/viewer/test.sh

# Random calls of the package with libraries under the address sanitizer; EXAMPLES sequences of them.
EXAMPLES ?= 200
test-python-asan: python
	@$(INSTALL_PACKAGES) python-test
	@cmake --preset asan-ubsan
	@cmake --build build/asan-ubsan -j $(JOBS) --target tulle_shared tulle_io_shared
	@LD_PRELOAD="$$(cc -print-file-name=libasan.so) $$(cc -print-file-name=libubsan.so)" ASAN_OPTIONS=detect_leaks=0 \
	UBSAN_OPTIONS=halt_on_error=1 TULLE_EXAMPLES=$(EXAMPLES) TULLE_LIBRARY_PATH=build/asan-ubsan PYTHONPATH=$(BUILD)/python PYTHONMALLOC=malloc \
	$(PYTEST) python/tests/test_random_calls.py python/tests/test_arrays.py

# Everything quick.
test:
	@$(INSTALL_PACKAGES) build test
	@$(MAKE) --no-print-directory build-tests
	@cd $(BUILD) && $(CTEST)

# What tulle convert writes, opened by other programs: docs/contributing/testing.md.
test-formats:
	@$(INSTALL_PACKAGES) build formats
	@$(MAKE) --no-print-directory build-program
	@TULLE=$(abspath $(BUILD)/tulle) sh test/formats/run.sh build/formats

# Everything, the whole scenes too: hours. What was interrupted goes on.
test-long:
	@$(INSTALL_PACKAGES) build test
	@$(MAKE) --no-print-directory build-tests
	@sh tools/long_tests.sh $(BUILD) $(CTEST) --timeout 36000

# The quick tests under the address sanitizer with gcc's checks of undefined behaviour, under clang's, which see more of it, and
# under the thread sanitizer; those of the engine and of files that call no library from elsewhere under the memory sanitizer,
# which is clang's. They take up to twenty times as long. TESTS='base.parallel world.golden' builds and runs these alone.
TESTS ?=
# Tests of the program need that alone, all others their own program.
# Tests of fuzz targets replay their kept inputs; TESTS='fuzz.*' are all of them.
CHOSEN_REPLAYS = $(foreach test,$(filter fuzz.%,$(TESTS)),$(patsubst fuzz/targets/%.c,replay_%,$(wildcard fuzz/targets/$(test:fuzz.%=%).c)))
CHOSEN_TARGETS = $(addprefix --target ,$(CHOSEN_REPLAYS) $(subst .,_test_,$(filter-out e2e.% fuzz.%,$(TESTS))) $(if $(filter e2e.%,$(TESTS)),tulle_program paper_measure bench_scene))
CHOSEN_TESTS = -R '^($(or $(subst $() ,|,$(strip $(TESTS))),.*))$$'
test-asan test-ubsan test-tsan: test-%:
	@$(INSTALL_PACKAGES) build test $(filter ubsan,$*)
	@cmake --preset $(patsubst asan,asan-ubsan,$*)
	@cmake --build build/$(patsubst asan,asan-ubsan,$*) -j $(JOBS) $(CHOSEN_TARGETS)
	@cd build/$(patsubst asan,asan-ubsan,$*) && $(CTEST) --timeout 7200 $(CHOSEN_TESTS)

test-msan:
	@$(INSTALL_PACKAGES) build test msan
	@cmake --preset msan
	@cmake --build build/msan -j $(JOBS) $(or $(CHOSEN_TARGETS),--target tests_for_memory)
	@cd build/msan && $(CTEST) --timeout 7200 -L memory $(CHOSEN_TESTS)

# All of it built by clang, warnings are errors; the tests that hold the golden hashes and the names of the libraries.
test-clang:
	@$(INSTALL_PACKAGES) build test clang
	@cmake --preset clang -DTULLE_BUILD_TESTS=ON
	@cmake --build build/clang -j $(JOBS)
	@cd build/clang && $(CTEST) -R '^(world\.golden|math\.|dynamics\.forces|detect\.narrow|io\.|subdivision\.|examples\.|tools\.(io_)?symbols|tools\.names)'

# libtulle by another C library, with 32-bit pointers, and with all that this processor has: a small host runs and has the golden hash.
test-musl test-m32 test-native: test-%:
	@$(INSTALL_PACKAGES) build $(filter-out native,$*)
	@sh tools/check_small_host.sh $* $(JOBS); code=$$?; [ $$code = 77 ] || exit $$code

# The add-on for Blender with the program inside, build/tulle_addon.zip: docs/guide/blender.md.
blender-addon:
	@$(INSTALL_PACKAGES) build
	@sh tools/make_blender_addon.sh $(JOBS)

# The add-on in Blender without a window, then in one; skips what is not there. A minute.
test-blender:
	@$(INSTALL_PACKAGES) build blender
	@$(MAKE) --no-print-directory build-program
	@TULLE="$(CURDIR)/$(BUILD)/tulle" sh blender/tests/run.sh; code=$$?; [ $$code = 77 ] || exit $$code

# Which lines and branches of the libraries the quick tests reach; fails below the limits of tools/check_coverage.py. Left out are
# tests that run no code of the libraries, and long ones of the program that reach nothing more.
NOT_COUNTED := ^(tools|paper|examples|validation|blender)[.]|^e2e[.](paper|bench_series|run_interrupted_step)|^check[.]cgal
coverage:
	@$(INSTALL_PACKAGES) build test
	@cmake --preset coverage
	@cmake --build build/coverage -j $(JOBS)
	@find build/coverage -name '*.gcda' -delete
	@cd build/coverage && $(CTEST) --timeout 3600 -E '$(NOT_COUNTED)'
	@python3 tools/check_coverage.py build/coverage

# Library, program and some tests compiled for arm64, the tests run by an emulator: docs/contributing/portability.md. Some minutes.
check-arm64:
	@$(INSTALL_PACKAGES) build test portability
	@sh tools/check_arm64.sh $(JOBS); code=$$?; [ $$code = 77 ] || exit $$code

# The same, and the default build on the oldest x86-64 processor.
check-portability: check-arm64
	@$(MAKE) --no-print-directory build-tests
	@cd $(BUILD) && $(CTEST) -R 'tools\.(baseline|oldest_processor)'

# What the stages of a step cost: lab/benchmarks.md. Inputs are made once (2k and 9.8k: some minutes), then measured;
# tables are printed, all measures are in build/bench.csv. BENCH_SCENES and BENCH_OPTIONS choose others, as
# BENCH_OPTIONS='--particles all --threads 1'; BENCH_SCENES may be a scene file of yours.
BENCH_SCENES ?= all
BENCH_OPTIONS ?=
BENCH := python3 bench/bench.py --tulle $(BUILD)/tulle $(BENCH_SCENES) --inputs build/bench_states --csv build/bench.csv
bench: build-bench
	@$(BENCH) $(BENCH_OPTIONS)

# The same, and the size 0.4k, beside bench/baseline.csv: what got slower, what counts otherwise; fails if anything did.
# Instructions of the sizes up to 2.5k are counted by valgrind, where it is there.
bench-compare: build-bench
	@$(INSTALL_PACKAGES) bench
	@$(BENCH) --particles 0.1k,0.4k,1k,2k,2.5k,9.8k,10k --instructions --compare bench/baseline.csv $(BENCH_OPTIONS)

.PHONY: build-bench
build-bench:
	@$(INSTALL_PACKAGES) build
	@$(MAKE) --no-print-directory build-program
	@cmake --build $(BUILD) -j $(JOBS) --target bench_scene

# The tables of lab/detection.md: makes the inputs once (half an hour), then measures.
bench-detect:
	@$(INSTALL_PACKAGES) build test
	@$(MAKE) --no-print-directory build-tests
	@sh bench/make_inputs.sh $(BUILD)/tulle build/bench_inputs
	@$(BUILD)/bench/bench_detect --paper --csv build/bench_detect.csv

# Tulle beside Blender, MuJoCo and Bullet in the same scenes, one after the other (an hour): lab/benchmarks.md. What is not
# there is skipped and told; PEERS_OPTIONS='--limit 60 --tools Tulle,Blender' chooses less. Rows are in build/peers.csv.
PEERS_OPTIONS ?=
bench-peers:
	@$(INSTALL_PACKAGES) build peers
	@$(MAKE) --no-print-directory build-program
	@sh bench/peers/prepare.sh build/peers
	@python3 bench/peers/run.py --tulle $(BUILD)/tulle $(PEERS_OPTIONS)

# The physics of contact: measured against expected (hours; VALIDATE_OPTIONS=--quick: a minute); fails where a row is
# off. Plots are drawn if matplotlib is there, build/validation holds them and the rows. What was interrupted goes on with
# VALIDATE_OPTIONS=--resume. tools/make_validation_page.py takes the rows into the book.
VALIDATE_OPTIONS ?=
validate:
	@$(INSTALL_PACKAGES) build test
	@cmake --preset release -DTULLE_BUILD_TESTS=ON -DTULLE_WARNINGS_AS_ERRORS=ON
	@cmake --build $(BUILD) -j $(JOBS) --target tulle_validate
	@mkdir -p build/validation
	@$(BUILD)/test/tulle_validate --csv build/validation/validation.csv --plots build/validation $(VALIDATE_OPTIONS); code=$$?; \
	python3=$$($(FIND_PYTHON) matplotlib) && "$$python3" tools/plot_validation.py build/validation; \
	exit $$code

# A live scene for hours: the judge, memory, the cost of a step, saved states: test/README.md. Prints a line a minute.
MINUTES ?= 120
soak:
	@$(INSTALL_PACKAGES) build test
	@cmake --preset release -DTULLE_BUILD_TESTS=ON -DTULLE_WARNINGS_AS_ERRORS=ON
	@cmake --build $(BUILD) -j $(JOBS) --target world_test_soak
	@TULLE_SOAK_MINUTES=$(MINUTES) $(BUILD)/test/world_test_soak

# Small changes of the engine's code, one after the other: does a test notice? test/README.md. Survivors are listed,
# results kept in build/mutate; what was interrupted goes on. MUTATE_OPTIONS='--seed 2 --file untangle' chooses others.
MUTANTS ?= 300
MUTATE_OPTIONS ?=
mutate:
	@$(INSTALL_PACKAGES) build test mutate
	@python3 tools/mutate.py --count $(MUTANTS) $(MUTATE_OPTIONS)

# Fuzzing: fuzz/README.md. `make fuzz TARGET=obj SECONDS=600`, or all targets, which share the time; the corpus is
# in build/fuzz, and a later call goes on with it. fuzz-afl is the same with AFL++; fuzz-keep chooses the files of fuzz/corpus anew.
TARGET ?=
SECONDS ?= 60
fuzz fuzz-all: build-fuzz
	@[ "$@" = fuzz-all ] || [ -n "$(TARGET)" ] || { echo "which one? make fuzz TARGET=NAME, of:" $(notdir $(basename $(wildcard fuzz/targets/*.c))) >&2; exit 2; }
	@sh fuzz/run.sh $(SECONDS) $(if $(filter fuzz,$@),$(TARGET))

fuzz-keep: build-fuzz
	@sh fuzz/keep.sh $(TARGET)

.PHONY: build-fuzz
build-fuzz:
	@$(INSTALL_PACKAGES) build test fuzz
	@cmake --preset fuzz
	@cmake --build build/fuzz -j $(JOBS) --target fuzz_targets

fuzz-afl:
	@$(INSTALL_PACKAGES) build test fuzz
	@[ -n "$(TARGET)" ] || { echo "which one? make fuzz-afl TARGET=NAME" >&2; exit 2; }
	@cmake --preset fuzz-afl
	@cmake --build build/fuzz-afl -j $(JOBS) --target replay_$(TARGET)
	@sh fuzz/run_afl.sh $(SECONDS) $(TARGET)

# The book as a static site with search: docs/, the pages of the public headers and of the Python package. It needs no network; the search needs a
# server, as `python3 -m http.server --directory build/site`.
docs:
	@$(INSTALL_PACKAGES) docs
	@python3 tools/make_book.py build/book
	@mkdocs build --quiet --strict
	@echo "the book is in build/site; look at it: python3 -m http.server 8000 --directory build/site"

# Every public name has its comment, every link leads somewhere, the site builds without a warning and asks no other host.
test-docs: docs
	@python3 tools/make_reference.py --self-test
	@python3 tools/make_python_reference.py --self-test
	@python3 tools/check_links.py --self-test
	@python3 tools/check_links.py
	@sh tools/check_site.sh build/site

# Sweeps under a Slurm of two nodes on this machine and on Dask clusters, with nodes and workers that die: docs/guide/sweeps.md. Some
# minutes. Slurm's part needs root, and skips without it.
test-sweep:
	@$(INSTALL_PACKAGES) build slurm
	@$(MAKE) --no-print-directory build-program
	@PYTHONPATH=python TULLE=$(CURDIR)/$(BUILD)/tulle TULLE_TEST_CLUSTERS=1 "$$(sh paper/find_python.sh 'yaml, numpy, pytest')" -m pytest -p no:cacheprovider -v -rs python/tests/test_sweep*.py

install: all
	@cmake --install $(BUILD) --prefix $(PREFIX)

format:
	@sh tools/format.sh

check-format:
	@sh tools/format.sh --check

layers:
	@python3 tools/check_layers.py

sizes:
	@python3 tools/check_sizes.py

clean:
	rm -rf build

help:
	@echo "make              release build: $(BUILD)/tulle, libtulle.so and libtulle.a beside it"
	@echo "make demo         cloth falls on needles, every frame is judged (installs missing packages)"
	@echo "make pictures     runs all scenes and makes the pictures of README.md (an hour)"
	@echo "make fabric-pictures  each fabric on a pedestal, springs beside woven cloth (half an hour)"
	@echo "make paper        the figures and tables of the paper again, with a report (two hours; goes on after Ctrl-C)"
	@echo "make paper-quick  the same with coarse cloth and short runs: minutes"
	@echo "make paper-pictures DIR=reproduced   the pictures of lab/paper.md, of what make paper left there"
	@echo "make test         all quick tests (installs missing packages)"
	@echo "make test-formats what tulle convert writes, opened by glTF's validator, three.js, tinyusdz and Blender"
	@echo "make test-long    all tests, the whole scenes too (hours; what was interrupted goes on)"
	@echo "make test-asan    the quick tests under the address and undefined-behaviour sanitizers"
	@echo "make test-ubsan   the quick tests under clang's sanitizer of undefined behaviour"
	@echo "make test-msan    the tests that call no library from elsewhere under clang's memory sanitizer"
	@echo "make test-tsan    the quick tests under the thread sanitizer"
	@echo "make test-clang   all built by clang, with the same hashes"
	@echo "make test-musl    the library by musl-gcc, linked statically into a small host, with the same hash"
	@echo "make test-m32     the same for 32-bit x86"
	@echo "make test-native  the same by -march=native"
	@echo "make test-blender the add-on in Blender without a window and in one (installs Blender)"
	@echo "make blender-addon  the add-on with the program inside: build/tulle_addon.zip"
	@echo "make check-arm64  compiles for arm64 and runs some tests by an emulator"
	@echo "make check-portability the same, and the default build on an emulated x86-64 processor without extensions"
	@echo "make bench        what the stages of a step cost (makes its inputs once: some minutes)"
	@echo "make bench-compare the same beside the baseline: what got slower"
	@echo "make bench-detect tables of the detector's speed (makes its inputs once: half an hour)"
	@echo "make bench-peers  the same scenes in Blender, MuJoCo and Bullet (installs them; an hour)"
	@echo "make validate     the physics of contact, measured against expected (hours)"
	@echo "make soak MINUTES=120   a live scene for hours: nothing crosses, grows or gets dearer"
	@echo "make mutate MUTANTS=300   changes the engine's code in many small places: which changes no test notices (an hour or two)"
	@echo "make fuzz TARGET=obj SECONDS=60   fuzzes one target with libFuzzer (installs clang); fuzz-afl: with AFL++"
	@echo "make fuzz-all SECONDS=600   all targets, which share the time"
	@echo "make coverage     lines and branches of the libraries that the quick tests reach; fails below 95 % and 90 %"
	@echo "make view         the program with tulle view, which shows scenes in a browser (installs libwebsockets, node and npm)"
	@echo "make test-view    its page in a browser (installs chromium)"
	@echo "make viewer       what turns worlds in notebooks (installs node and npm)"
	@echo "make test-notebooks   the viewer in a browser (installs chromium)"
	@echo "make docs         the book as a static site with search, build/site (installs mkdocs and doxygen)"
	@echo "make test-docs    the same; every public name has its comment, every link leads somewhere"
	@echo "make test-sweep   sweeps under Slurm and on Dask, with nodes that die (installs them; some minutes)"
	@echo "make install      to PREFIX (default /usr/local)"
	@echo "make format       lay out the code; check-format, layers, sizes: check the rules of the house"
	@echo "make clean        remove build/"
