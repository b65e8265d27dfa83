# Finds liblcm. Debian ships no CMake package for it, and its lcm.pc fails without glib's headers.
#
# Defines: LCM_FOUND, LCM_INCLUDE_DIR, LCM_LIBRARY, LCM_GEN_EXECUTABLE (may be NOTFOUND) and the
# imported target LCM::lcm. Set LCM_ROOT to look in another prefix first.
find_path(LCM_INCLUDE_DIR NAMES lcm/lcm.h)
find_library(LCM_LIBRARY NAMES lcm)
find_program(LCM_GEN_EXECUTABLE NAMES lcm-gen)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LCM
  REQUIRED_VARS LCM_LIBRARY LCM_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "on Debian and Ubuntu: apt-get install liblcm-dev liblcm-bin")
mark_as_advanced(LCM_INCLUDE_DIR LCM_LIBRARY LCM_GEN_EXECUTABLE)

if(LCM_FOUND AND NOT TARGET LCM::lcm)
  add_library(LCM::lcm UNKNOWN IMPORTED)
  set_target_properties(LCM::lcm PROPERTIES
    IMPORTED_LOCATION ${LCM_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${LCM_INCLUDE_DIR})
endif()
