# cmake --install: the rooms as static libraries with their headers, and a CMake package, so that
#   find_package(planecast CONFIG REQUIRED)
#   target_link_libraries(robot PRIVATE planecast::planecast)
# works from anywhere. Runs after every room is known (see the deferred call at the end).
include(CMakePackageConfigHelpers)

function(planecast_install)
  get_property(rooms GLOBAL PROPERTY PLANECAST_ROOMS)
  add_library(planecast_all INTERFACE)
  target_link_libraries(planecast_all INTERFACE ${rooms})
  set_target_properties(planecast_all PROPERTIES EXPORT_NAME planecast)
  add_library(planecast::planecast ALIAS planecast_all)

  set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/planecast)
  install(TARGETS ${rooms} planecast_all EXPORT planecast_targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  install(EXPORT planecast_targets NAMESPACE planecast:: FILE planecast-targets.cmake
          DESTINATION ${package_dir} COMPONENT development)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/core ${PROJECT_SOURCE_DIR}/transport
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/planecast COMPONENT development
          FILES_MATCHING PATTERN "*.hpp")

  configure_package_config_file(${PROJECT_SOURCE_DIR}/toolchains/planecast-config.cmake.in
    ${PROJECT_BINARY_DIR}/planecast-config.cmake INSTALL_DESTINATION ${package_dir})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/planecast-config-version.cmake
    VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/planecast-config.cmake
          ${PROJECT_BINARY_DIR}/planecast-config-version.cmake
          ${PROJECT_SOURCE_DIR}/toolchains/FindLCM.cmake
          DESTINATION ${package_dir} COMPONENT development)
endfunction()

cmake_language(DEFER DIRECTORY ${CMAKE_SOURCE_DIR} CALL planecast_install)
