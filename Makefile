# dexeld: one Makefile, not recursive (the sanitizer targets call it again with another build folder).
VERSION := 0.1.0

B ?= build
ifeq ($(origin CC),default)
CC := gcc
endif
# make V=1 shows the commands
Q := $(if $(V),,@)
OPT ?= -O3
DEXEL_DATA ?= ../shared/data
export DEXEL_DATA

prefix ?= /usr/local
exec_prefix ?= $(prefix)
bindir ?= $(exec_prefix)/bin
sbindir ?= $(exec_prefix)/sbin
libdir ?= $(exec_prefix)/lib
includedir ?= $(prefix)/include
datarootdir ?= $(prefix)/share
mandir ?= $(datarootdir)/man
docdir ?= $(datarootdir)/doc/dexeld
sharedir ?= $(datarootdir)/dexeld
sysconfdir ?= $(prefix)/etc
udevrulesdir ?= $(prefix)/lib/udev/rules.d
unitdir ?= $(prefix)/lib/systemd/system
sysusersdir ?= $(prefix)/lib/sysusers.d
tmpfilesdir ?= $(prefix)/lib/tmpfiles.d
metainfodir ?= $(datarootdir)/metainfo
completionsdir ?= $(datarootdir)/bash-completion/completions
# Where Debian's python3 looks: /usr/lib/python3, but below any other prefix a folder of its own version.
pythondir ?= $(prefix)/lib/python3$(if $(filter-out /usr,$(prefix)),$(shell \
  python3 -c 'import sys; print(".%d" % sys.version_info[1])' 2>/dev/null))/dist-packages
INSTALL ?= install

PACKAGES := libsystemd yaml-0.1 jansson libpng zlib libzstd liblz4 libusb-1.0 libgpiod
WARN := -Wall -Wextra -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Werror=implicit
# Topology is integer; f32 points must not depend on fused multiply-add (docs/terrain.md).
# gcc 12 has dropped calls of a function whose stores its -fivopts had given addresses relative to another
# array: its later passes take those for accesses at null, and the function for one without effects.
NO_IVOPTS := $(if $(findstring clang,$(shell $(CC) --version 2>/dev/null)),,-fno-ivopts)
BASE_CFLAGS := -std=gnu17 $(OPT) $(NO_IVOPTS) -g $(WARN) -ffp-contract=off -fPIC \
               -fvisibility=hidden -pthread
CPPFLAGS += -I. -D_GNU_SOURCE -DDEXELD_VERSION='"$(VERSION)"'
PKG_CFLAGS = $(shell pkg-config --cflags $(PACKAGES) 2>/dev/null)
PKG_LIBS = $(shell pkg-config --libs $(PACKAGES) 2>/dev/null) -llzf -lm
ALL_CFLAGS = $(BASE_CFLAGS) $(CPPFLAGS) $(PKG_CFLAGS) $(CFLAGS) $(SAN)
ALL_LDFLAGS = -pthread $(LDFLAGS) $(SAN)

# Loops of their own file for an instruction set (core/rows/rows.h).
NOT_HERE := $(if $(findstring x86_64,$(shell $(CC) -dumpmachine 2>/dev/null)),,core/rows/rows_avx2.c core/rows/rows_avx512.c)

# Which libgpiod there is: the other one's back end is left out (drivers/gpio/gpio_port.h).
NOT_HERE += $(if $(filter 1.%,$(shell pkg-config --modversion libgpiod 2>/dev/null)),drivers/gpio/gpio_libgpiod2.c,drivers/gpio/gpio_libgpiod1.c)

obj = $(patsubst %.c,$(B)/obj/%.o,$(1))
CORE_SRC := $(filter-out $(NOT_HERE),$(wildcard core/base/*.c core/rows/*.c core/grid/*.c core/cloud/*.c core/wire/*.c))
DRIVERS_SRC := $(filter-out $(NOT_HERE),$(wildcard drivers/*.c drivers/*/*.c))
CLIENT_SRC := $(wildcard client/*.c)
DAEMON_SRC := $(filter-out daemon/main.c,$(wildcard daemon/*.c))
TOOLS_SRC := $(filter-out tools/main.c,$(wildcard tools/*.c))
UNIT_SRC := $(wildcard tests/unit/test_*.c)
SYSTEM_SRC := $(wildcard tests/system/*.c)
SIM_SRC := tests/hil/scip_sim.c
FUZZ_SRC := $(wildcard tests/fuzz/fuzz_*.c)
GUEST_SRC := $(wildcard tests/hil/*.c tests/hil/guest/*.c)
BENCH_SRC := $(wildcard tests/bench/*.c)
FAULT_SRC := $(wildcard tests/faults/*.c)
VALGRIND_SRC := $(wildcard tests/valgrind/*.c)

LIBS := $(B)/lib/libdxtools.a $(B)/lib/libdxdaemon.a $(B)/lib/libdxdrivers.a $(B)/lib/libdexel.a
PROGRAMS := $(B)/bin/dexeld $(B)/bin/dexel
UNIT := $(patsubst tests/unit/%.c,$(B)/tests/%,$(UNIT_SRC))
SYSTEM := $(patsubst tests/system/%.c,$(B)/tests/%,$(SYSTEM_SRC)) \
          $(patsubst tests/hil/%.c,$(B)/tests/%,$(SIM_SRC)) $(B)/tests/dexeld_faults
FUZZ := $(patsubst tests/fuzz/%.c,$(B)/%,$(FUZZ_SRC))

.PHONY: all deps demo check check-long check-unit check-system check-tree hil hil-programs bench bench-live bench-drivers bench-peers \
        bench-peers-clouds performance compare-scans peers-mcap asan tsan valgrind coverage lint lint-flags lint-sources fuzz fuzz-targets format install uninstall deb clean help FORCE
.DELETE_ON_ERROR:
.SECONDARY:

all: $(PROGRAMS) $(B)/lib/libdexel.so $(B)/lib/libdexel.a $(B)/libdexel.pc

help:
	@echo 'make demo        install what is missing, build, replay a scan to a subscriber, show the mesh'
	@echo 'make check       install what is missing, build, run the tests (about ten minutes)'
	@echo 'make hil         the drivers on a real kernel, packages and units under systemd, in guests (docs/hil.md)'
	@echo 'make check-long  the long tests as well: large grids, lint, sanitizers, valgrind, fuzzing'
	@echo 'make all         build the service, the tools and the library under build/'
	@echo 'make deps        install the Debian packages that the build needs'
	@echo 'make bench       benchmarks (ratios within one run)'
	@echo 'make bench-live  a service of its own at 1 to 200 subscribers'
	@echo 'make bench-drivers  each driver of a device at its full rate, with a simulated one'
	@echo 'make bench-clouds  unorganized points: a table of the paper, and growth (LARGE=1: to ten million)'
	@echo 'make bench-peers  frames through PCL and VTK as well, clouds as below (installs libpcl-dev, libvtk9-dev)'
	@echo 'make bench-peers-clouds  unorganized points through CGAL, PCL and Open3D as well, in turn (installs them)'
	@echo 'make performance  all of it, into docs/performance.md (ten minutes, on an idle machine; LARGE=1: half an hour)'
	@echo 'make gallery     pictures of reconstructed clouds, into docs/gallery.md'
	@echo 'make compare-scans  meshes of real scans beside those of PCL, in numbers'
	@echo 'make peers-mcap  recordings to and from the official JavaScript library (needs npm)'
	@echo 'make asan tsan   build and run the tests under the sanitizers'
	@echo 'make lint        clang-tidy and cppcheck over all C files (installs them)'
	@echo 'make coverage    the tests again, and which lines they run'
	@echo 'make valgrind    the programs and unit tests under its memcheck (installs it)'
	@echo 'make fuzz        build the fuzz targets (clang)'
	@echo 'make deb         Debian packages of service, tools and library, in build/deb'
	@echo 'make install     install under $$(DESTDIR)$(prefix);  uninstall, clean'

deps:
	@sh tests/deps.sh

# ---- objects and libraries ------------------------------------------------------------------------
# No loop of core/rows looks at floating-point exceptions; without them selections become vectors.
$(B)/obj/core/rows/rows_%.o: override CFLAGS += -fno-trapping-math -fno-math-errno
$(B)/obj/core/rows/rows_avx2.o: override CFLAGS += -mavx2
$(B)/obj/core/rows/rows_avx512.o: override CFLAGS += -march=x86-64-v4 -mavx512vbmi2 -mprefer-vector-width=512
$(B)/obj/%.o: %.c Makefile
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -MMD -MP -c -o $@ $<

-include $(patsubst %.o,%.d,$(call obj,$(CORE_SRC) $(DRIVERS_SRC) $(CLIENT_SRC) $(DAEMON_SRC) \
           $(TOOLS_SRC) $(UNIT_SRC) $(SYSTEM_SRC) $(GUEST_SRC) $(BENCH_SRC) $(FAULT_SRC) $(VALGRIND_SRC) daemon/main.c tools/main.c))

define archive
	@mkdir -p $(@D)
	$(Q)rm -f $@ && ar crs $@ $^
endef

$(B)/lib/libdexel.a: $(call obj,$(CLIENT_SRC) $(CORE_SRC))
	$(archive)
$(B)/lib/libdxdrivers.a: $(call obj,$(DRIVERS_SRC))
	$(archive)
$(B)/lib/libdxdaemon.a: $(call obj,$(DAEMON_SRC))
	$(archive)
$(B)/lib/libdxtools.a: $(call obj,$(TOOLS_SRC))
	$(archive)

SONAME := libdexel.so.0
$(B)/lib/libdexel.so: $(call obj,$(CLIENT_SRC) $(CORE_SRC))
	@mkdir -p $(@D)
	$(Q)$(CC) -shared -Wl,-soname,$(SONAME) $(ALL_LDFLAGS) -o $@ $^ -lm
	$(Q)ln -sf libdexel.so $(@D)/$(SONAME)

# Made anew each time: prefix may be another one at `make install`.
$(B)/libdexel.pc: client/libdexel.pc.in Makefile FORCE
	@mkdir -p $(@D)
	$(Q)sed -e 's|@prefix@|$(prefix)|;s|@libdir@|$(libdir)|;s|@includedir@|$(includedir)|;s|@version@|$(VERSION)|' $< >$@.$$$$ && mv $@.$$$$ $@

$(B)/bin/dexeld: $(call obj,daemon/main.c) $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS)
# `dexel bench` and test_steady count allocations: tools/alloc_count.c
COUNT_ALLOC := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc
$(B)/bin/dexel: $(call obj,tools/main.c) $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) $(COUNT_ALLOC) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS)

# ---- tests ----------------------------------------------------------------------------------------
$(B)/tests/test_steady: override LDFLAGS += $(COUNT_ALLOC)
FAIL_ALLOC := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=aligned_alloc,--wrap=posix_memalign,--wrap=strdup,--wrap=mmap
$(B)/tests/test_out_of_memory: $(call obj,tests/unit/fail_alloc.c)
$(B)/tests/test_out_of_memory: override LDFLAGS += $(FAIL_ALLOC)
FAIL_SYSTEM := -Wl,--wrap=open,--wrap=eventfd,--wrap=socket,--wrap=listen,--wrap=accept4,--wrap=opendir,--wrap=open_memstream,--wrap=pthread_create
$(B)/tests/test_out_of_descriptors: $(call obj,tests/unit/fail_system.c)
$(B)/tests/test_out_of_descriptors: override LDFLAGS += $(FAIL_SYSTEM)
$(B)/tests/test_listen: override LDFLAGS += -Wl,--wrap=flock,--wrap=listen
# Tests on devices of umockdev. Objects that a test depends on are linked to it.
UMOCKDEV_CFLAGS = $(shell pkg-config --cflags umockdev-1.0)
UMOCKDEV_LIBS = $(shell pkg-config --libs umockdev-1.0)
$(B)/obj/tests/unit/mock_usb.o: override CFLAGS += $(UMOCKDEV_CFLAGS)
$(B)/tests/test_usb_port: $(call obj,tests/unit/mock_usb.c)
$(B)/tests/test_usb_port: TEST_LIBS = $(UMOCKDEV_LIBS)
$(B)/tests/test_hokuyo_usb: $(call obj,tests/unit/mock_usb.c)
$(B)/tests/test_hokuyo_usb: TEST_LIBS = $(UMOCKDEV_LIBS)
$(B)/tests/test_hokuyo_usb: override LDFLAGS += -Wl,--wrap=poll,--wrap=clock_gettime
# Tests with devices of umockdev. Its library of wrappers comes first, so that no LD_PRELOAD is needed.
UMOCK := $(addprefix $(B)/tests/,test_udev test_presence test_v4l2 test_v4l2_errors test_gpio_kernel)
$(UMOCK): override CPPFLAGS += $(shell pkg-config --cflags umockdev-1.0 2>/dev/null)
$(UMOCK): override LDFLAGS += -Wl,--no-as-needed -l:libumockdev-preload.so.0 $(shell pkg-config --libs umockdev-1.0 2>/dev/null)
# tests/unit/v4l2_kernel.h
$(B)/tests/test_v4l2 $(B)/tests/test_v4l2_errors: override LDFLAGS += -Wl,--wrap=poll,--wrap=ioctl,--wrap=open,--wrap=clock_gettime
$(B)/tests/test_kinect_packets $(B)/tests/test_kinect_depth: $(call obj,tests/hil/kinect_sim.c)
$(B)/tests/test_kinect_usb: $(call obj,tests/hil/kinect_sim.c tests/unit/fake_libusb.c)
SCIP_DEVICE := $(call obj,tests/hil/scip_device.c tests/hil/scip_replies.c)
$(addprefix $(B)/tests/,test_scip_session test_hokuyo test_hokuyo_usb test_stage scip_sim): $(SCIP_DEVICE)
$(B)/bench/bench_scip $(B)/hil/bin/redir_scip: $(SCIP_DEVICE)
$(B)/tests/test_kinect_usb: override LDFLAGS += $(COUNT_ALLOC)
# Waits that run out fast: tests/unit/fast_waits.c
FAST_WAITS := $(addprefix $(B)/tests/,test_reader_device test_kinect_usb test_hokuyo)
$(FAST_WAITS): $(call obj,tests/unit/fast_waits.c)
$(FAST_WAITS): override LDFLAGS += -Wl,--wrap=poll,--wrap=ppoll,--wrap=nanosleep,--wrap=clock_gettime
$(B)/tests/%: $(B)/obj/tests/unit/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS) $(TEST_LIBS) -lcmocka
$(B)/tests/%: $(B)/obj/tests/system/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $< $(LIBS) $(PKG_LIBS)
# The service with faults on request (daemon/fault.h): what is linked first is what counts.
$(B)/tests/dexeld_faults: $(call obj,daemon/main.c $(FAULT_SRC)) $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS)
# The same way, the service for small grids alone.
$(B)/tests/dexeld_few_tiles: $(call obj,daemon/main.c $(VALGRIND_SRC)) $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS)
# Simulated devices, usable by hand.
$(B)/tests/%: $(B)/obj/tests/hil/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS)

check: deps
	@$(MAKE) --no-print-directory all $(UNIT) $(SYSTEM)
	@B=$(B) sh tests/run.sh check

check-unit: $(UNIT)
	@B=$(B) sh tests/run.sh unit
check-system: all $(SYSTEM)
	@B=$(B) sh tests/run.sh system
check-tree:
	@B=$(B) sh tests/run.sh tree
check-long: check
	@$(MAKE) --no-print-directory lint asan tsan valgrind
	@B=$(B) sh tests/run.sh long

# The drivers on a real kernel (docs/hil.md): tests/hil/redir_NAME.c is a device, on this side of the guest;
# tests/hil/guest/NAME.c runs inside.
HIL_PROGRAMS := $(patsubst %.c,$(B)/hil/bin/%,$(notdir $(wildcard tests/hil/tsc_khz.c tests/hil/redir_*.c tests/hil/guest/*.c)))
hil: deps
	+@B=$(B) MAKE='$(MAKE)' sh tests/hil/hil.sh
hil-programs: $(HIL_PROGRAMS) $(B)/tests/scip_sim $(B)/tests/dexeld_faults
	@:
$(B)/hil/bin/%: $(B)/obj/tests/hil/guest/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $< $(LIBS) $(PKG_LIBS)
$(B)/hil/bin/redir_kinect: $(call obj,tests/hil/kinect_sim.c)
$(B)/hil/bin/%: $(B)/obj/tests/hil/%.o $(call obj,tests/hil/redir.c tests/hil/usb_answers.c tests/hil/orders.c) $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS) -lusbredirparser

# Programs that are many times slower may take longer before they are thought to hang (tests/run_one.sh).
asan tsan valgrind coverage: export TEST_SECONDS ?= 3600
asan:
	@$(MAKE) --no-print-directory B=build/asan OPT=-O1 \
	  SAN='-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer' \
	  all check-unit check-system
tsan:
	@$(MAKE) --no-print-directory B=build/tsan OPT=-O1 SAN='-fsanitize=thread' \
	  all check-unit check-system
valgrind: all $(UNIT) $(SYSTEM) $(B)/tests/dexeld_few_tiles
	@B=$(B) sh tests/valgrind.sh

# Lines that the tests run, of what is the service's; below 90 % of a room it fails. What a killed process ran is not counted.
coverage:
	@$(MAKE) --no-print-directory B=build/coverage OPT=-O1 SAN='--coverage -fprofile-update=atomic -DCOUNTS_LINES' \
	  all check-unit check-system
	@B=build/coverage sh tests/coverage.sh

lint: deps
	+@B=$(B) sh tests/lint.sh
# What it asks for.
lint-flags:
	@: $(info $(ALL_CFLAGS) $(UMOCKDEV_CFLAGS) -Iclient)
lint-sources:
	@: $(info $(filter-out $(NOT_HERE),$(shell git ls-files '*.c')))

# Fuzz targets: clang, the libraries with coverage under their own folder, the targets linked to them.
FUZZ_SAN := address,undefined -fno-sanitize-recover=all
fuzz:
	@$(MAKE) --no-print-directory B=$(B)/fuzz CC=clang OPT=-O1 \
	  SAN='-fsanitize=fuzzer-no-link,$(FUZZ_SAN)' fuzz-targets
fuzz-targets: $(FUZZ)
$(B)/fuzz_%: $(B)/obj/tests/fuzz/fuzz_%.o $(LIBS)
	$(Q)$(CC) $(ALL_LDFLAGS) -fsanitize=fuzzer -o $@ $< $(LIBS) $(PKG_LIBS) -lcmocka

bench: all
	$(B)/bin/dexel bench --size all --threads 1,2
	$(B)/bin/dexel bench rules
	$(B)/bin/dexel bench update --threads 1,2
bench-live: all
	@B=$(B) sh tests/bench/live.sh
# Drivers at their full rates with simulated devices; they need what their unit tests need.
BENCH_DRIVERS := $(addprefix $(B)/bench/bench_,scip kinect v4l2)
$(B)/bench/bench_kinect: $(call obj,tests/hil/kinect_sim.c tests/unit/fake_libusb.c)
$(B)/bench/bench_v4l2: override CPPFLAGS += $(shell pkg-config --cflags umockdev-1.0 2>/dev/null)
$(B)/bench/bench_v4l2: override LDFLAGS += -Wl,--no-as-needed -l:libumockdev-preload.so.0 $(shell pkg-config --libs umockdev-1.0 2>/dev/null)
$(B)/bench/bench_v4l2: override LDFLAGS += -Wl,--wrap=poll,--wrap=ioctl,--wrap=open,--wrap=clock_gettime
$(B)/bench/%: $(B)/obj/tests/bench/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $(filter %.o,$^) $(LIBS) $(PKG_LIBS) -lcmocka
bench-drivers: all $(BENCH_DRIVERS)
	@B=$(B) sh tests/bench/drivers.sh
performance: all $(BENCH_DRIVERS)
	@B=$(B) CC='$(CC)' OPT='$(OPT)' sh tests/bench/performance.sh >$(B)/performance.md
	@cp $(B)/performance.md docs/performance.md
bench-peers: all
	@B=$(B) sh tests/peers/bench_peers.sh
	@B=$(B) sh tests/peers/bench_peers_clouds.sh
bench-clouds: all
	@B=$(B) sh tests/bench/clouds.sh
	@B=$(B) sh tests/bench/smooth_table.sh
bench-peers-clouds: all
	@B=$(B) sh tests/peers/bench_peers_clouds.sh
	@B=$(B) sh tests/peers/bench_peers_smooth.sh
PEERS := $(B)/peers/depth_pcd $(B)/peers/mesh_counts
.PHONY: gallery bench-clouds
gallery: all
	@B=$(B) sh tests/gallery.sh
compare-scans: all $(PEERS)
	@B=$(B) sh tests/peers/compare_scans.sh
peers-mcap: all $(B)/peers/mcap_peer
	@B=$(B) sh tests/peers/mcap.sh
$(B)/peers/%: $(B)/obj/tests/peers/%.o $(LIBS)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_LDFLAGS) -o $@ $< $(LIBS) $(PKG_LIBS)

demo: deps
	@$(MAKE) --no-print-directory all
	@B=$(B) sh tests/demo.sh

format:
	clang-format -i $$(git ls-files '*.c' '*.h')

# ---- install --------------------------------------------------------------------------------------
MAN1 := docs/dexel.1 $(wildcard docs/dexel-*.1)
UNITS := dexeld.service dexeld.socket dexeld-control.socket dexeld-replay@.service
install: all
	$(INSTALL) -d $(DESTDIR)$(bindir) $(DESTDIR)$(sbindir) $(DESTDIR)$(libdir)/pkgconfig \
	  $(DESTDIR)$(includedir) $(DESTDIR)$(mandir)/man1 $(DESTDIR)$(mandir)/man5 \
	  $(DESTDIR)$(mandir)/man8 $(DESTDIR)$(docdir)/drivers $(DESTDIR)$(docdir)/sensors \
	  $(DESTDIR)$(docdir)/gallery $(DESTDIR)$(sharedir)/grafana $(DESTDIR)$(sharedir)/prometheus \
	  $(DESTDIR)$(sysconfdir)/dexeld $(DESTDIR)$(udevrulesdir) $(DESTDIR)$(unitdir) \
	  $(DESTDIR)$(sysusersdir) $(DESTDIR)$(tmpfilesdir) $(DESTDIR)$(metainfodir) \
	  $(DESTDIR)$(pythondir) $(DESTDIR)$(completionsdir)
	$(INSTALL) -m 755 $(B)/bin/dexel $(DESTDIR)$(bindir)
	$(INSTALL) -m 755 $(B)/bin/dexeld $(DESTDIR)$(sbindir)
	$(INSTALL) -m 644 $(B)/lib/libdexel.a $(DESTDIR)$(libdir)
	$(INSTALL) -m 755 $(B)/lib/libdexel.so $(DESTDIR)$(libdir)/$(SONAME).$(VERSION)
	ln -sf $(SONAME).$(VERSION) $(DESTDIR)$(libdir)/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(libdir)/libdexel.so
	$(INSTALL) -m 644 client/dexel.h $(DESTDIR)$(includedir)
	$(INSTALL) -m 644 $(B)/libdexel.pc $(DESTDIR)$(libdir)/pkgconfig
	$(INSTALL) -m 644 client/python/dexel.py $(DESTDIR)$(pythondir)
	for page in $(MAN1) docs/dexeld.yaml.5 docs/dexeld.8; do \
	  sed 's|/usr/local/etc|$(sysconfdir)|' $$page >$(DESTDIR)$(mandir)/man$${page##*.}/$${page##*/}; \
	done
	$(INSTALL) -m 644 README.md CHANGELOG.md docs/*.md docs/*.png docs/examples/follow.c \
	  $(DESTDIR)$(docdir)
	$(INSTALL) -m 644 docs/gallery/*.png $(DESTDIR)$(docdir)/gallery
	$(INSTALL) -m 644 docs/drivers/*.md $(DESTDIR)$(docdir)/drivers
	$(INSTALL) -m 644 config/sensors/*.yaml $(DESTDIR)$(docdir)/sensors
	$(INSTALL) -m 644 config/grafana/dexeld.json $(DESTDIR)$(sharedir)/grafana
	$(INSTALL) -m 644 config/prometheus/dexeld.rules.yml $(DESTDIR)$(sharedir)/prometheus
	$(INSTALL) -m 644 config/60-dexeld.rules $(DESTDIR)$(udevrulesdir)
	$(INSTALL) -m 644 config/dexeld.sysusers $(DESTDIR)$(sysusersdir)/dexeld.conf
	$(INSTALL) -m 644 config/dexeld.tmpfiles $(DESTDIR)$(tmpfilesdir)/dexeld.conf
	$(INSTALL) -m 644 config/dexeld.metainfo.xml $(DESTDIR)$(metainfodir)
	for name in dexel dexeld; do \
	  $(INSTALL) -m 644 config/dexel.bash-completion $(DESTDIR)$(completionsdir)/$$name; \
	done
	$(INSTALL) -m 644 systemd/network.conf $(DESTDIR)$(docdir)
	for unit in $(UNITS); do \
	  sed -e 's|@sbindir@|$(sbindir)|;s|@sysconfdir@|$(sysconfdir)|' systemd/$$unit \
	    >$(DESTDIR)$(unitdir)/$$unit; \
	done
	[ -e $(DESTDIR)$(sysconfdir)/dexeld/dexeld.yaml ] || \
	  $(INSTALL) -m 644 config/dexeld.yaml $(DESTDIR)$(sysconfdir)/dexeld

uninstall:
	rm -f $(DESTDIR)$(bindir)/dexel $(DESTDIR)$(sbindir)/dexeld $(DESTDIR)$(libdir)/libdexel.a \
	  $(DESTDIR)$(libdir)/libdexel.so $(DESTDIR)$(libdir)/$(SONAME) \
	  $(DESTDIR)$(libdir)/$(SONAME).$(VERSION) $(DESTDIR)$(includedir)/dexel.h \
	  $(DESTDIR)$(libdir)/pkgconfig/libdexel.pc $(addprefix $(DESTDIR)$(mandir)/man1/,$(notdir $(MAN1))) \
	  $(DESTDIR)$(mandir)/man5/dexeld.yaml.5 $(DESTDIR)$(mandir)/man8/dexeld.8 \
	  $(DESTDIR)$(udevrulesdir)/60-dexeld.rules $(DESTDIR)$(sysusersdir)/dexeld.conf \
	  $(DESTDIR)$(tmpfilesdir)/dexeld.conf $(DESTDIR)$(metainfodir)/dexeld.metainfo.xml \
	  $(addprefix $(DESTDIR)$(unitdir)/,$(UNITS)) $(DESTDIR)$(pythondir)/dexel.py \
	  $(addprefix $(DESTDIR)$(completionsdir)/,dexel dexeld)
	rm -rf $(DESTDIR)$(docdir) $(DESTDIR)$(sharedir)

# Debian packages, in build/deb: of what is committed or staged, so that a build leaves the tree as it is.
deb: deps
	@B=$(B) sh debian/build.sh

clean:
	rm -rf build
