# The user module `smr` for ports of MicroPython that are built by make:
#
#     make -C ports/PORT USER_C_MODULES=.../core/micropython SMR_LIB=.../libsmr.a
#
# SMR_LIB      the library for the processor of the board: see README.md
# SMR_INCLUDE  the folder of smr.h, if this folder was copied out of the project

SMR_INCLUDE ?= $(USERMOD_DIR)/../../c/include

ifeq ($(filter clean submodules,$(MAKECMDGOALS)),)
ifeq ($(wildcard $(SMR_LIB)),)
$(error smr: there is no library SMR_LIB=$(SMR_LIB). Build one in the folder of smr: core/c/install.sh PREFIX TARGET, with a target of Rust as \
  thumbv7em-none-eabihf for a Cortex-M4 or M7 with FPU. Then SMR_LIB=PREFIX/lib/libsmr.a)
endif
endif

SRC_USERMOD_C += $(USERMOD_DIR)/smr.c
CFLAGS_USERMOD += -I$(SMR_INCLUDE)

# Some ports link LIBS, and set it after this file. Others put LDFLAGS before the objects, where the linker reads an archive only with -u.
LIBS_USERMOD += $(SMR_LIB)
LDFLAGS_USERMOD += -u smr_init $(SMR_LIB)
ifeq ($(notdir $(CURDIR)),unix)
# On a host the archive contains Rust's standard library.
LDFLAGS_USERMOD += -lpthread -ldl
endif
