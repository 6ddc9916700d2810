# Install, and the package that find_package(CoLift) finds.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/CoLift)
foreach(folder hal perception planner control sim_hal)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/colift
          FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/colift/config)
install(EXPORT CoLiftTargets NAMESPACE CoLift:: DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/CoLiftConfig.cmake.in
                              ${CMAKE_BINARY_DIR}/CoLiftConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/CoLiftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/CoLiftConfig.cmake ${CMAKE_BINARY_DIR}/CoLiftConfigVersion.cmake
        DESTINATION ${package_dir})
