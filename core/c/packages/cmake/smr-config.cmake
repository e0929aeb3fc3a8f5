# find_package(smr): defines the target smr::smr, and smr_REFINER (yes or no).
#
# An installation by core/c/install.sh has one libsmr.a, named in smr-installed.cmake. In the archive for all processors,
# smr-choose.cmake chooses one.
get_filename_component(smr_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
include("${CMAKE_CURRENT_LIST_DIR}/smr-installed.cmake" OPTIONAL RESULT_VARIABLE smr_installed)
if(NOT smr_installed)
  include("${CMAKE_CURRENT_LIST_DIR}/smr-choose.cmake")
endif()
if(NOT TARGET smr::smr)
  add_library(smr::smr STATIC IMPORTED GLOBAL)
  set_target_properties(smr::smr PROPERTIES
    IMPORTED_LOCATION "${smr_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${smr_prefix}/include"
    INTERFACE_COMPILE_DEFINITIONS "${smr_DEFINITIONS}"
    INTERFACE_LINK_LIBRARIES "-Wl,--gc-sections;${smr_LIBRARIES}")
endif()
