# Allbounce. `make demo` shows it, `make test` checks it, `make bake SCENE=room.glb` bakes a scene stage by stage,
# `make charts` draws where methods hold and where they fail (docs/charts/) and, by `make rival-charts`, speed against accuracy of
# every method in the bundled rooms; `make goals` tells what `bake --error` chooses for them; `make claims` holds the published method to what is said of it; `make bench` measures every operator,
# `make leaks` how much light gets where it is dark (docs/leaks.md), `make pictures` draws the walk through a bake
# (docs/pictures/), `make test-export` asks the Khronos validator about exported files.
#
# Options of a stage go into a variable of its name:
#   make bake SCENE=room.glb VOXEL_SIMPLIFY="--patches 3000" FORMFACTOR="--rays 1024"
# Each stage leaves one .rad file and its report in $(BAKE_DIR). Touching one reruns what depends on it,
# and so does another value of its variable. The path of a scene must not hold spaces.

SHELL := bash
comma := ,
space := $() $()
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
# Software Vulkan drivers want a private folder for their scratch files.
export XDG_RUNTIME_DIR ?= /tmp
.PHONY: help setup build demo test test-export charts stability rival-charts claims goals leaks pictures bench bake clean FORCE

ALLBOUNCE := target/release/allbounce

help:
	@sed -n '1,/^$$/s/^#\( \|$$\)//p' Makefile

setup:
	@./setup.sh

build: setup
	cargo build --release -p allbounce

$(ALLBOUNCE): | build ;

# ---- one scene, stage by stage ----

SCENE ?=
NAME := $(basename $(notdir $(SCENE)))
BAKE_DIR ?= out/$(NAME)
VOXEL_SIMPLIFY ?=
FORMFACTOR ?=
SERIES ?=
PERMUTE ?=
# How the operator is packed: hmatrix or dxt-pack.
OPERATOR ?= hmatrix
HMATRIX ?=
DXT_PACK ?=
TRANSFER ?=

# Prints one stage and runs it: $(call stage,name,input,options)
stage = $(ALLBOUNCE) $(1) $(2) -o $@ $(3) --report $(@:.rad=.json)

PACKING = $(if $(filter dxt-pack,$(OPERATOR)),$(DXT_PACK),$(HMATRIX))

# A file that changes only when the options of a stage do: $(call remember,options)
remember = @mkdir -p $(@D); echo '$(1)' | cmp -s - $@ || echo '$(1)' > $@

# Files beside the scene that it may name: a change of one may change the scene. Folders below are not watched.
BESIDE = $(foreach kind,mtl bin png jpg jpeg,$(wildcard $(dir $(SCENE))*.$(kind)))

# The program is an order-only prerequisite (after the bar): it is brought up to date first, but a new build
# of it does not outdate a bake, so that working on one stage does not rebake every scene. After a change
# of a stage, remove what it made, or the folder of the bake.
ifneq ($(SCENE),)
bake: $(BAKE_DIR)/6-transfer.rad

$(BAKE_DIR)/1-voxel-simplify.rad: $(SCENE) $(BESIDE) $(BAKE_DIR)/.voxel-simplify | build
	$(call stage,voxel-simplify,$(SCENE),$(VOXEL_SIMPLIFY))
$(BAKE_DIR)/2-formfactor.rad: $(BAKE_DIR)/1-voxel-simplify.rad $(BAKE_DIR)/.formfactor | build
	$(call stage,formfactor,$<,$(FORMFACTOR))
$(BAKE_DIR)/3-series.rad: $(BAKE_DIR)/2-formfactor.rad $(BAKE_DIR)/.series | build
	$(call stage,series,$<,$(SERIES))
$(BAKE_DIR)/4-permute.rad: $(BAKE_DIR)/3-series.rad $(BAKE_DIR)/.permute | build
	$(call stage,permute,$<,$(PERMUTE))
$(BAKE_DIR)/5-$(OPERATOR).rad: $(BAKE_DIR)/4-permute.rad $(BAKE_DIR)/.$(OPERATOR) | build
	$(call stage,$(OPERATOR),$<,$(PACKING))
$(BAKE_DIR)/6-transfer.rad: $(BAKE_DIR)/5-$(OPERATOR).rad $(BAKE_DIR)/.transfer | build
	$(call stage,transfer,$<,$(TRANSFER))

# Scenes of the same name in different folders share a folder here, so the path is remembered, too.
$(BAKE_DIR)/.voxel-simplify: FORCE
	$(call remember,$(SCENE) $(VOXEL_SIMPLIFY))
$(BAKE_DIR)/.formfactor: FORCE
	$(call remember,$(FORMFACTOR))
$(BAKE_DIR)/.series: FORCE
	$(call remember,$(SERIES))
$(BAKE_DIR)/.permute: FORCE
	$(call remember,$(PERMUTE))
$(BAKE_DIR)/.$(OPERATOR): FORCE
	$(call remember,$(PACKING))
$(BAKE_DIR)/.transfer: FORCE
	$(call remember,$(OPERATOR) $(TRANSFER))
else
bake:
	@echo 'which scene? make bake SCENE=path/to/room.glb [VOXEL_SIMPLIFY="--patches 3000"] …' >&2; exit 2
endif

# ---- the bundled rooms: bake, verify, relight, picture ----

CORNELL := out/cornell/6-transfer.rad
APARTMENT := out/apartment/6-transfer.rad
# Scenes that are cut open; where they are dark, light would be a leak.
LEAKS := rooms boxes curtain
PICTURES := cornell-lamp cornell-lamp-indirect cornell-point cornell-spots cornell-spots-gpu \
    living-day living-evening hall-panel hall-panel-indirect hall-panel-gpu \
    $(foreach scene,$(LEAKS),leak-$(scene) leak-$(scene)-exposed) leak-curtain-traced

demo: build
	$(MAKE) --no-print-directory bake SCENE=assets/cornell/cornell.obj VOXEL_SIMPLIFY="--patches 2500"
	$(MAKE) --no-print-directory bake SCENE=assets/apartment/apartment.obj VOXEL_SIMPLIFY="--patches 4000"
	$(ALLBOUNCE) verify $(CORNELL)
	$(ALLBOUNCE) verify $(APARTMENT)
	$(foreach scene,$(LEAKS),$(MAKE) --no-print-directory bake SCENE=assets/leaks/$(scene)/$(scene).obj \
	    BAKE_DIR=out/leak-$(scene) VOXEL_SIMPLIFY="--patches 1500";)
	$(MAKE) --no-print-directory $(PICTURES:%=out/%.png)
	$(ALLBOUNCE) relight $(CORNELL) --lights assets/cornell/lamp.json -o out/cornell-lamp.csv
	@echo 'look at out/*.png; numbers are in out/*/*.json and out/*.csv; `$(ALLBOUNCE) inspect $(CORNELL)` tells how a bake was made'

out/cornell-%.png: $(CORNELL)
	$(ALLBOUNCE) render $< --camera assets/cornell/camera.json $(call look,cornell,$*) -o $@
out/living-%.png: $(APARTMENT)
	$(ALLBOUNCE) render $< --samples 24 --camera assets/apartment/living.camera.json $(call look,apartment,$*) -o $@
out/hall-%.png: $(APARTMENT)
	$(ALLBOUNCE) render $< --camera assets/apartment/hall.camera.json $(call look,apartment,$(subst panel,hall,$*)) -o $@

# As it is, and exposed twenty times as long, so that a thousandth of the light would show.
out/leak-%.png: out/leak-%/6-transfer.rad
	$(ALLBOUNCE) render $< $(call leak,$*) --height 384 -o $@
out/leak-%-exposed.png: out/leak-%/6-transfer.rad
	$(ALLBOUNCE) render $< $(call leak,$*) --height 384 --exposure 5 -o $@
out/leak-%-traced.png: assets/leaks/%/lamp.json
	$(ALLBOUNCE) reference assets/leaks/$*/$*.obj $(call leak,$*) --width 160 --height 120 --samples 512 --exposure 5 -o $@
leak = --lights assets/leaks/$(1)/lamp.json --camera assets/leaks/$(1)/camera.json

# Lights and options of a picture's name: lamp-indirect is lamp.json with --indirect-only; -gpu takes the GPU.
look = --lights assets/$(1)/$(firstword $(subst -, ,$(2))).json \
    $(if $(findstring -indirect,$(2)),--indirect-only) $(if $(findstring -gpu,$(2)),--backend gpu)

# ---- the walk through a bake: docs/guide.md ----

WALK := out/walk
WALK_LIGHT := --lights assets/cornell/lamp.json
WALK_CAMERA := --camera assets/cornell/camera.json
# Pictures of light have one exposure, so that they can be compared.
WALK_EXPOSURE := --exposure 4.6
WALK_SMALL := $(WALK_CAMERA) --width 400 --height 400
# Small, for the reference traces thousands of paths a pixel.
WALK_TRUTH := $(WALK_LIGHT) $(WALK_CAMERA) --width 256 --height 256
WALK_PICTURES := patches row direct one-bounce all-bounces compression beside error living-day living-evening

pictures: build
	mkdir -p docs/pictures
	$(MAKE) --no-print-directory bake SCENE=assets/cornell/cornell.obj BAKE_DIR=$(WALK) \
	    VOXEL_SIMPLIFY="--patches 1300" FORMFACTOR="--rays 16384"
	$(MAKE) --no-print-directory bake SCENE=assets/apartment/apartment.obj VOXEL_SIMPLIFY="--patches 4000"
	$(MAKE) --no-print-directory $(WALK_PICTURES:%=docs/pictures/%.png)

# $(call show,what,options): a picture of the first prerequisite, its numbers beside it.
show = $(ALLBOUNCE) show $(1) $< $(WALK_SMALL) $(2) -o $@ --report $(WALK)/$(basename $(@F)).json

docs/pictures/patches.png: $(WALK)/1-voxel-simplify.rad
	$(call show,patches)
docs/pictures/row.png: $(WALK)/2-formfactor.rad
	$(call show,row,--pixel 120$(comma)367)
docs/pictures/direct.png: $(WALK)/2-formfactor.rad
	$(call show,light,$(WALK_LIGHT) $(WALK_EXPOSURE) --bounces 0)
docs/pictures/one-bounce.png: $(WALK)/2-formfactor.rad
	$(call show,light,$(WALK_LIGHT) $(WALK_EXPOSURE) --bounces 1)
docs/pictures/all-bounces.png: $(WALK)/3-series.rad
	$(call show,light,$(WALK_LIGHT) $(WALK_EXPOSURE))
$(WALK)/dense.exr: $(WALK)/4-permute.rad
	$(call show,light,$(WALK_LIGHT))
$(WALK)/packed.exr: $(WALK)/5-hmatrix.rad
	$(call show,light,$(WALK_LIGHT))
docs/pictures/compression.png: $(WALK)/dense.exr $(WALK)/packed.exr
	$(ALLBOUNCE) compare $^ -o $@ --report $(WALK)/compression.json
$(WALK)/truth.exr: assets/cornell/cornell.obj assets/cornell/lamp.json
	$(ALLBOUNCE) reference $< $(WALK_TRUTH) --rel-error 2% --max-samples 32768 -o $@ --report $(WALK)/truth.json
$(WALK)/baked.exr: $(WALK)/6-transfer.rad
	$(ALLBOUNCE) render $< $(WALK_TRUTH) --samples 64 -o $@ --report $(WALK)/baked.json
docs/pictures/beside.png docs/pictures/error.png &: $(WALK)/truth.exr $(WALK)/baked.exr
	$(ALLBOUNCE) compare $^ --range 20% --beside docs/pictures/beside.png -o docs/pictures/error.png --report $(WALK)/error.json
# By day for the room; the automatic exposure is for the spot of the sun.
docs/pictures/living-day.png: WALK_LIVING := --exposure 0.6
docs/pictures/living-%.png: $(APARTMENT)
	$(ALLBOUNCE) render $< --camera assets/apartment/living.camera.json $(call look,apartment,$*) \
	    --width 400 --height 280 --samples 64 $(WALK_LIVING) -o $@

# ---- every check ----

test: setup
	cargo fmt --all --check
	cargo test --release --workspace
	cargo clippy --release --workspace --all-targets -- -D warnings
	cargo clippy --release -p allbounce --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps

# Exported files, judged by the Khronos glTF validator, which comes from npm.
EXPORTED := $(foreach scene,cornell apartment,$(foreach file,scene vertex_colours,out/export-$(scene)/files/$(file).glb))
GLTF_VALIDATOR := gltf-validator@2.0.0-dev.3.10

test-export: build
	./setup.sh npm
	npm install --silent --no-save --no-package-lock --prefix out/npm $(GLTF_VALIDATOR)
	$(call export,cornell,lamp)
	$(call export,apartment,evening)
	NODE_PATH=out/npm/node_modules node tests/validate_gltf.cjs $(EXPORTED)

# Bakes a bundled scene and exports it under one of its lights: $(call export,scene,lights)
export = $(MAKE) --no-print-directory bake SCENE=assets/$(1)/$(1).obj BAKE_DIR=out/export-$(1) \
    VOXEL_SIMPLIFY="--patches 1000" TRANSFER="--lightmap 16384" && \
    $(ALLBOUNCE) export out/export-$(1)/6-transfer.rad --lights assets/$(1)/$(2).json -o out/export-$(1)/files

# ---- charts ----

charts: stability rival-charts

# The stability laboratory.
stability: setup
	cargo run --release -p allbounce-tests --example make_charts

# Speed against accuracy of every method in the bundled rooms, half an hour or more; a quiet machine, named by MACHINE, times better.
rival-charts: build
	mkdir -p out
	$(call rival-chart,cornell,lamp point,camera,200x200)
	$(call rival-chart,apartment,evening day,living.camera,200x140)

# One scene under some of its lights, the first of them seen side by side: $(call rival-chart,scene,lights,camera,size)
rival-chart = $(ALLBOUNCE) chart assets/$(1)/$(1).obj -o out/rivals-$(1) --report out/rivals-$(1).json \
    --lights $(subst $(space),$(comma),$(2:%=assets/$(1)/%.json)) --note "$(MACHINE), commit $$(git rev-parse --short HEAD)" \
    --camera assets/$(1)/$(3).json --size $(4) && cp out/rivals-$(1)/side-by-side.png docs/charts/side-by-side-$(1).png && \
    for kind in csv md svg png; do cp out/rivals-$(1)/chart.$$kind docs/charts/rivals-$(1).$$kind; done && \
    for kind in svg png; do cp out/rivals-$(1)/memory.$$kind docs/charts/rivals-$(1)-memory.$$kind; done && \
    sed -i 's/(chart\./(rivals-$(1)./; s/(memory\./(rivals-$(1)-memory./; s/(side-by-side\./(side-by-side-$(1)./' docs/charts/rivals-$(1).md

# ---- what bakes choose ----

# Bakes each scene for two errors and says in docs/goals.md what was chosen and what came out; some minutes.
GOALS := tests/data/grey/room.obj assets/cornell/cornell.obj assets/apartment/apartment.obj
GOAL_ERRORS := 10% 5%

goals: build
	mkdir -p out/goals
	$(foreach scene,$(GOALS),$(foreach error,$(GOAL_ERRORS),$(ALLBOUNCE) bake $(scene) --error $(error) \
	    -o out/goals/bake.rad --report out/goals/$(notdir $(scene:.obj=))-$(error).json && )) true
	cargo run --release -p allbounce-tests --example goal_table -- docs/goals.md "$(MACHINE)" $$(git rev-parse --short HEAD) \
	    $(foreach scene,$(GOALS),$(GOAL_ERRORS:%=out/goals/$(notdir $(scene:.obj=))-%.json))

# ---- the claims of the published method ----

CLAIMS := $(foreach scene,cornell apartment,$(foreach n,1000 2500,$(scene)-$(n)))

# Sides of voxels and their form factors; the rest is done where it is measured. A quiet machine, named by MACHINE, times better.
claims: $(CLAIMS:%=claims-%)
	cargo run --release -p allbounce-tests --example paper_claims -- docs/charts/claims.md $(TODAY) $$(git rev-parse --short HEAD) \
	    "$(MACHINE)" $(foreach bake,$(CLAIMS),$(firstword $(subst -, ,$(bake)))=out/claims/$(bake)/2-formfactor.rad)

claims-%:
	$(MAKE) --no-print-directory out/claims/$*/2-formfactor.rad BAKE_DIR=out/claims/$* \
	    SCENE=assets/$(firstword $(subst -, ,$*))/$(firstword $(subst -, ,$*)).obj \
	    VOXEL_SIMPLIFY="--patches $(lastword $(subst -, ,$*)) --mode faces" FORMFACTOR="--rays 4096"

# ---- the leak suite ----

leaks: setup
	cargo run --release -p allbounce-tests --example make_leaks

# ---- the bench of operators ----

# Bakes each scene at several numbers of patches into out/bench, packs and times every operator, and draws the record.
# `make bench SPONZA=path/to/Sponza.gltf MACHINE=name`; 8000 patches want 8 GiB of memory, and all of it takes an hour.
MACHINE ?= $(shell uname -m)-$(shell getconf _NPROCESSORS_ONLN)c
SPONZA ?=
BENCH_PATCHES ?= 1300 2600 5000 8000

BENCH_SCENES := cornell apartment $(if $(SPONZA),sponza)
BENCH_CORNELL := assets/cornell/cornell.obj
BENCH_APARTMENT := assets/apartment/apartment.obj
BENCH_BAKES := $(foreach scene,$(BENCH_SCENES),$(BENCH_PATCHES:%=$(scene)-%))
# Orders are worth a packing each where that is quick; at the most patches they are timed.
BENCH_ORDERED := $(foreach scene,$(BENCH_SCENES),$(scene)-$(firstword $(BENCH_PATCHES))) apartment-$(lastword $(BENCH_PATCHES))

TODAY := $(shell date +%F)
# Arguments of an example that writes a record: $(call record,subject,bakes)
record = bench/record/$(MACHINE)/$(TODAY)-$(1).csv $(TODAY) $$(git rev-parse --short HEAD) $(MACHINE) \
    $(foreach bake,$(2),$(firstword $(subst -, ,$(bake)))=out/bench/$(bake)/3-series.rad)

bench: $(BENCH_BAKES:%=bench-%)
	@$(if $(SPONZA),,echo 'bench: without Sponza; SPONZA=path/to/Sponza.gltf adds it')
	cargo run --release -p allbounce-tests --example bench_operators -- $(call record,operators,$(BENCH_BAKES))
	cargo run --release -p allbounce-tests --example bench_orders -- $(call record,orders,$(BENCH_ORDERED))
	echo $(MACHINE)/$(TODAY) > bench/record/shown
	$(MAKE) --no-print-directory stability

bench-cornell-%: ; $(call bench-bake,cornell,$(BENCH_CORNELL))
bench-apartment-%: ; $(call bench-bake,apartment,$(BENCH_APARTMENT))
bench-sponza-%: ; $(call bench-bake,sponza,$(SPONZA))

# One bake up to the dense operator: $(call bench-bake,name,scene file), the number of patches is the stem.
bench-bake = $(MAKE) --no-print-directory out/bench/$(1)-$*/3-series.rad BAKE_DIR=out/bench/$(1)-$* SCENE=$(2) \
    VOXEL_SIMPLIFY="--patches $*" FORMFACTOR="--rays 4096"

clean:
	rm -rf out target
