# Checks whether this version of smr, read from the header, meets the request of find_package.
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/../../../include/smr.h" smr_numbers REGEX "^#define SMR_VERSION_[A-Z]+ [0-9]+")
string(REGEX REPLACE ".*MAJOR ([0-9]+).*MINOR ([0-9]+).*PATCH ([0-9]+).*" "\\1.\\2.\\3" PACKAGE_VERSION "${smr_numbers}")
string(REGEX MATCH "^[0-9]+[.][0-9]+" smr_minor "${PACKAGE_VERSION}")
if(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)
  set(PACKAGE_VERSION_EXACT TRUE)
endif()
# Before 1.0 every minor version may change the interface.
if("${PACKAGE_FIND_VERSION_MAJOR}.${PACKAGE_FIND_VERSION_MINOR}" VERSION_EQUAL smr_minor AND NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
