# make demo     deform a real volume in four ways: .vti files and a picture in demo-output/
# make test     check style and run all tests
# make bench    measure against other programs (LARGE=1: also 256^3)
# make lint     check style only
# make clean    remove what these commands made
#
# Everything is installed in .venv; stamp files remember what is there. Commands run as
# `.venv/bin/python -m ...`: with relative paths they also work in a folder with a space in its name.
.DELETE_ON_ERROR:
.PHONY: demo test bench lint clean
PYTHON ?= python3
PY := .venv/bin/python

demo: .venv/demo.stamp
	@bash .ci/drivers $(PY)
	@$(PY) -m vtk_mls demo demo-output

test: .venv/test.stamp
	@bash .ci/drivers $(PY)
	@bash tests/paraview/install.sh
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m pytest

lint: .venv/test.stamp
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

bench: .venv/bench.stamp
	@$(PY) tests/benchmarks/bench.py $(if $(LARGE),--large)

clean:
	rm -rf .venv .cache .pytest_cache .ruff_cache build demo-output dist

.venv/made.stamp:
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "make: $(PYTHON) cannot make virtual environments. On Debian: apt-get install python3-venv"; \
	  exit 1; }
	$(PYTHON) -m venv --clear .venv
	@touch $@

.venv/demo.stamp: EXTRAS = pocl,demo
.venv/test.stamp: EXTRAS = test
.venv/bench.stamp: EXTRAS = bench
.venv/%.stamp: pyproject.toml .venv/made.stamp
	$(PY) -m pip install --quiet --disable-pip-version-check -e '.[$(EXTRAS)]'
	@touch $@
