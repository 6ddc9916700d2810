# Debian packages by CPack, one per component: `tools/package` makes them, tools/debian has what goes into them.
set(debian ${PROJECT_SOURCE_DIR}/tools/debian)
install(FILES ${debian}/colift.conf DESTINATION /etc/security/limits.d COMPONENT colift EXCLUDE_FROM_ALL)
install(FILES ${debian}/colift-can@.service ${debian}/colift-run@.service DESTINATION /lib/systemd/system
        COMPONENT colift EXCLUDE_FROM_ALL)
install(FILES ${debian}/60-colift.rules DESTINATION /lib/udev/rules.d COMPONENT colift EXCLUDE_FROM_ALL)
install(FILES ${debian}/completion.bash DESTINATION share/bash-completion/completions RENAME colift COMPONENT colift)
install(FILES ${debian}/completion.zsh DESTINATION share/zsh/vendor-completions RENAME _colift COMPONENT colift)
# made by tools/package
install(DIRECTORY ${CMAKE_BINARY_DIR}/debian/man1 DESTINATION share/man COMPONENT colift OPTIONAL)
# Sources for a machine with ROS 2, and what people read. Documents and reference are made by tools/package.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/dds/ros2/colift_msgs ${PROJECT_SOURCE_DIR}/tools/dds/ros2/view
        DESTINATION ${CMAKE_INSTALL_DATADIR}/colift/ros2 COMPONENT colift-ros2 EXCLUDE_FROM_ALL)
install(FILES ${CMAKE_BINARY_DIR}/debian/ros2/README.md DESTINATION share/doc/colift-ros2 COMPONENT colift-ros2
        EXCLUDE_FROM_ALL OPTIONAL)
install(DIRECTORY ${CMAKE_BINARY_DIR}/debian/doc/ DESTINATION share/doc/colift-doc COMPONENT colift-doc EXCLUDE_FROM_ALL OPTIONAL)
install(FILES ${debian}/colift-doc.colift DESTINATION share/doc-base COMPONENT colift-doc EXCLUDE_FROM_ALL)
install(FILES ${CMAKE_BINARY_DIR}/debian/colift-doc.colift-api DESTINATION share/doc-base COMPONENT colift-doc
        EXCLUDE_FROM_ALL OPTIONAL)
get_property(python_depends GLOBAL PROPERTY COLIFT_PYTHON_DEPENDS)  # empty: tools/python was left out
set(packages colift libcolift-dev colift-ros2 colift-doc)
if(python_depends)
  list(APPEND packages python3-colift)
endif()
foreach(package ${packages})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/${package} RENAME copyright COMPONENT ${package})
  install(FILES ${CMAKE_BINARY_DIR}/debian/changelog.gz ${CMAKE_BINARY_DIR}/debian/CHANGELOG.md.gz
          DESTINATION share/doc/${package} COMPONENT ${package} OPTIONAL)
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME colift)
set(CPACK_PACKAGE_CONTACT "the CoLift authors <authors@colift.example>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)  # as many as there are processors
set(CPACK_COMPONENTS_ALL ${packages})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COLIFT_PACKAGE_NAME colift)
set(CPACK_DEBIAN_COLIFT_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COLIFT_PACKAGE_DEPENDS "fonts-dejavu-core")
set(CPACK_DEBIAN_COLIFT_PACKAGE_RECOMMENDS "iproute2")
set(CPACK_DEBIAN_COLIFT_DESCRIPTION "Watches through one depth camera, finds the object and where a person
grasps it, decides where the robot grasps so that both carry their share,
plans the motion, and lifts with the person: with a KUKA LWR 4+, a
BarrettHand and a Kinect, emulated ones, or in simulation.")
set(CPACK_DEBIAN_COLIFT_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/debian/conffiles)
set(CPACK_DEBIAN_LIBCOLIFT-DEV_PACKAGE_NAME libcolift-dev)
set(CPACK_DEBIAN_LIBCOLIFT-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBCOLIFT-DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_LIBCOLIFT-DEV_PACKAGE_DEPENDS
    "colift (= ${PROJECT_VERSION}), libeigen3-dev, libyaml-cpp-dev, libfmt-dev, libexpected-dev, libmujoco-dev, liburdfdom-dev, liboctomap-dev, libfcl-dev, libompl-dev")
set(CPACK_DEBIAN_LIBCOLIFT-DEV_DESCRIPTION "Headers, static libraries and the CMake package of CoLift, and the suites
that a back end of an arm, a hand or a camera has to pass.")
set(CPACK_DEBIAN_PYTHON3-COLIFT_PACKAGE_NAME python3-colift)
set(CPACK_DEBIAN_PYTHON3-COLIFT_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-COLIFT_PACKAGE_DEPENDS "colift (= ${PROJECT_VERSION}), ${python_depends}")
set(CPACK_DEBIAN_PYTHON3-COLIFT_DESCRIPTION "CoLift from Python: depth frames as NumPy arrays, scene analysis,
decisions, simulated runs step by step with own grasps and policies,
recordings and experiments.")
# what Python compiled there is nobody's file
set(CPACK_DEBIAN_PYTHON3-COLIFT_PACKAGE_CONTROL_EXTRA ${debian}/python3-colift/prerm)
foreach(package COLIFT-ROS2 COLIFT-DOC)
  string(TOLOWER ${package} name)
  set(CPACK_DEBIAN_${package}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${package}_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_${package}_PACKAGE_SHLIBDEPS OFF)
endforeach()
set(CPACK_DEBIAN_COLIFT-ROS2_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COLIFT-ROS2_PACKAGE_SUGGESTS "colift, colift-doc")
set(CPACK_DEBIAN_COLIFT-ROS2_DESCRIPTION "CoLift for a machine with ROS 2: sources of the interface package
colift_msgs, to be built in a workspace, a launch file and a layout for RViz
that show a run. Publishing itself is part of the package colift.")
set(CPACK_DEBIAN_COLIFT-DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_COLIFT-DOC_PACKAGE_SUGGESTS "colift, libcolift-dev")
set(CPACK_DEBIAN_COLIFT-DOC_DESCRIPTION "Documents of CoLift: how it works, bring-up and calibration of a robot,
faults, recordings, ROS 2, Python, benchmarks and decisions; and a reference
of the headers in libcolift-dev.")
include(CPack)
