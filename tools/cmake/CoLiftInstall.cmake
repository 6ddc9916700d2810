# Install, and the package that find_package(CoLift) finds.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/CoLift)
include(PublicHeaders)
foreach(header ${COLIFT_PUBLIC_HEADERS})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/colift/${folder} COMPONENT libcolift-dev)
endforeach()

# the suites that a back end has to pass, as headers: <colift/contract/arm_contract.hpp>
set(contract_include ${PROJECT_SOURCE_DIR}/tests/contract/include)
add_library(colift_contract INTERFACE)
add_library(CoLift::contract ALIAS colift_contract)
set_target_properties(colift_contract PROPERTIES EXPORT_NAME contract)
target_include_directories(colift_contract INTERFACE $<BUILD_INTERFACE:${contract_include}>
                                                     $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(colift_contract INTERFACE colift_hal)
install(TARGETS colift_contract EXPORT CoLiftTargets COMPONENT libcolift-dev)
list(TRANSFORM COLIFT_CONTRACT_HEADERS PREPEND ${contract_include}/colift/contract/ OUTPUT_VARIABLE contract_headers)
install(FILES ${contract_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/colift/contract COMPONENT libcolift-dev)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/colift/config COMPONENT colift)
# recorded frames that look and decide take by name: one of a Kinect, one of a RealSense
set(scenes ${PROJECT_SOURCE_DIR}/tests/data/real)
install(DIRECTORY ${scenes}/01_office_chair_and_bottles ${scenes}/07_carton_before_wall
        DESTINATION ${CMAKE_INSTALL_DATADIR}/colift/scene COMPONENT colift)
install(FILES ${scenes}/LICENSES.txt DESTINATION ${CMAKE_INSTALL_DATADIR}/colift/scene COMPONENT colift)
install(EXPORT CoLiftTargets NAMESPACE CoLift:: DESTINATION ${package_dir} COMPONENT libcolift-dev)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/CoLiftConfig.cmake.in
                              ${CMAKE_BINARY_DIR}/CoLiftConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/CoLiftConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/CoLiftConfig.cmake ${CMAKE_BINARY_DIR}/CoLiftConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT libcolift-dev)
include(ApiDocs)
include(CoLiftPackage)
