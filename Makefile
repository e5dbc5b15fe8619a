# make demo     the main job on real input, pictures in build/demo
# make test     all tests
# make check    style, types, the engine's tests and a case of every kind in one Blender: minutes
# make torture  the engine's process killed at random moments, again and again: KILLS=100
# make farm     a bake on a real Slurm of this machine: Debian and root only
# make bench    how fast and how large: docs/benchmark.md; JSON and curves in build/bench
# make gallery  the pictures of README and docs, every HDRI and mode beside Cycles: docs/gallery.md
# make order    what nine coefficients can show of a room at best: docs/order.md
# make web      the viewer of web pages, built anew, and the demo's scene in it: build/web
# make course   the GAMES202 course's homework, its files in build/course and its pictures: docs/course.md
# make lint     style, types, workflows and issue forms
# make docs     the documents and the engine's reference as a site: build/docs
# make package  the zips that people install, in dist
# make app      those zips tried in a real Blender's window: Debian and root only; sets up APP_ROOT, pictures in build/app
# Each makes the environment that it needs under build/venv, and looks for the libraries of the system that bpy links to.
# PYTHON chooses the interpreter and with it the Blender: 3.11 runs bpy 4.5 LTS (or 5.0 with BPY=5.0), 3.13 runs bpy 5.2 LTS.

PYTHON ?= python3
PY := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
BPY_3.11 := 4.5
BPY_3.13 := 5.2
BPY ?= $(BPY_$(PY))
VENV := build/venv/py$(PY)-bpy$(BPY)
LINT := build/venv/lint-py$(PY)
DOCS := build/venv/docs-py$(PY)
BLEND ?=
TESTS ?=
KILLS ?= 100
APP_ROOT ?= build/app/root
PYTEST = cd tests && ../$(VENV)/bin/python -m pytest

.PHONY: demo test check check-engine check-blender torture farm bench gallery order course web lint docs package app clean

demo: $(VENV)/.ready
	$(VENV)/bin/python tools/demo.py $(if $(BLEND),--blend "$(BLEND)")

test: build/.web $(VENV)/.ready
	$(PYTEST) $(TESTS)

check: $(VENV)/.ready $(LINT)/.ready
	$(MAKE) -j2 --output-sync=target check-engine check-blender

check-engine: lint
	$(PYTEST) core worker

check-blender: $(VENV)/.ready
	$(PYTEST) -m "not slow and not once" --ignore=core --ignore=worker

torture: $(VENV)/.ready
	export PRT_KILLS=$(KILLS) PRT_KILLS_SEED=$$$$; $(PYTEST) worker -k random_moments

farm: $(VENV)/.ready
	cd tests && ../tools/farm/slurm.sh ../$(VENV)/bin/python -m pytest farm/test_slurm.py

bench: build/.web $(VENV)/.bench
	$(VENV)/bin/python tools/bench --page docs/benchmark.md

gallery: $(VENV)/.ready
	$(VENV)/bin/python tools/gallery.py
	$(VENV)/bin/python tools/previews.py --output docs/pictures/previews.jpg

order: $(VENV)/.ready
	$(VENV)/bin/python tools/order_bound.py

web: build/.web $(VENV)/.ready
	cd web && npm run build --workspace @prt-relight/viewer
	$(VENV)/bin/python tools/web.py

course: $(VENV)/.ready
	$(VENV)/bin/python tools/course

# Tools are scripts that import each other by bare names, and two folders have a file of one name: each is checked by itself.
lint: $(LINT)/.ready
	$(LINT)/bin/ruff check .
	$(LINT)/bin/ruff format --check .
	mkdir -p build/types && ln -sfn ../.. build/types/prt_relight
	$(LINT)/bin/mypy
	for folder in tools tools/bench tools/course tools/app; do \
		MYPYPATH=tools:$$folder:. $(LINT)/bin/mypy $$folder/*.py || exit 1; done
	MYPYPATH=.:tools $(LINT)/bin/mypy tests
	$(LINT)/bin/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(LINT)/bin/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(LINT)/bin/check-jsonschema --builtin-schema vendor.github-issue-forms $(filter-out %/config.yml,$(wildcard .github/ISSUE_TEMPLATE/*.yml))

docs: $(DOCS)/.ready
	rm -rf docs/engine
	$(DOCS)/bin/python -m sphinx --quiet --fail-on-warning --fresh-env docs build/docs

package: $(VENV)/.ready
	$(VENV)/bin/python tools/package.py

app: package
	tools/app/root.sh $(APP_ROOT)
	tools/app/run.sh $(APP_ROOT) build/app

build/.system: tools/system.sh
	tools/system.sh $(PYTHON)
	@mkdir -p build && touch $@

build/.system-node: tools/system.sh
	tools/system.sh $(PYTHON) node
	@mkdir -p build && touch $@ build/.system

build/.web: web/package-lock.json | build/.system-node
	cd web && npm ci --no-audit --no-fund --loglevel=error
	touch $@

$(VENV)/.ready: pyproject.toml | build/.system
	@test -n "$(BPY)" || { echo "No bpy for Python $(PY): use PYTHON=python3.11 or PYTHON=python3.13."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/python -m pip install --quiet --upgrade "pip>=25.1"
	$(VENV)/bin/python -m pip install --quiet "bpy==$(BPY).*" --group test
	touch $@

$(VENV)/.bench: $(VENV)/.ready
	$(VENV)/bin/python -m pip install --quiet --group bench
	touch $@

$(LINT)/.ready $(DOCS)/.ready: build/venv/%-py$(PY)/.ready: pyproject.toml | build/.system
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/python -m pip install --quiet --upgrade "pip>=25.1"
	$(@D)/bin/python -m pip install --quiet --group $*
	touch $@

clean:
	rm -rf build dist
