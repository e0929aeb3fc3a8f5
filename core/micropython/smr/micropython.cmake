# The user module `smr` for ports of MicroPython that are built by CMake, as rp2 is:
#
#     make -C ports/rp2 BOARD=RPI_PICO2 USER_C_MODULES=.../core/micropython/smr/micropython.cmake CMAKE_ARGS=-DSMR_LIB=.../libsmr.a
#
# SMR_LIB      the library for the processor of the board: see README.md
# SMR_INCLUDE  the folder of smr.h, if this folder was copied out of the project

if(NOT EXISTS "${SMR_LIB}")
  message(FATAL_ERROR "smr: there is no library SMR_LIB=${SMR_LIB}. Build one in the folder of smr: core/c/install.sh PREFIX TARGET, with a "
    "target of Rust as thumbv8m.main-none-eabihf for an RP2350. Then -DSMR_LIB=PREFIX/lib/libsmr.a")
endif()
if(NOT SMR_INCLUDE)
  set(SMR_INCLUDE ${CMAKE_CURRENT_LIST_DIR}/../../c/include)
endif()

add_library(usermod_smr INTERFACE)
target_sources(usermod_smr INTERFACE ${CMAKE_CURRENT_LIST_DIR}/smr.c)
target_include_directories(usermod_smr INTERFACE ${SMR_INCLUDE})
target_link_libraries(usermod_smr INTERFACE ${SMR_LIB})
target_link_libraries(usermod INTERFACE usermod_smr)
