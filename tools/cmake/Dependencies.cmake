# Everything that CoLift takes from Debian; tools/setup installs it.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp 0.7 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(PNG REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(LZF REQUIRED liblzf)
find_package(ZLIB REQUIRED)
find_package(Threads REQUIRED)

if(COLIFT_THESIS)
  # Debian's libpcl-dev needs VTK and Qt (2.3 GB), its component libraries do not. tools/setup unpacks the headers of
  # libpcl-dev and libflann-dev into .deps; an installed libpcl-dev is taken first.
  find_path(PCL_INCLUDE_DIR pcl/point_types.h
            PATHS /usr/include/pcl-1.13 ${PROJECT_SOURCE_DIR}/.deps/usr/include/pcl-1.13 NO_DEFAULT_PATH)
  find_path(FLANN_INCLUDE_DIR flann/flann.hpp
            PATHS /usr/include ${PROJECT_SOURCE_DIR}/.deps/usr/include NO_DEFAULT_PATH)
  if(NOT PCL_INCLUDE_DIR OR NOT FLANN_INCLUDE_DIR)
    message(FATAL_ERROR "PCL's headers are missing: run tools/setup, or configure with -DCOLIFT_THESIS=OFF")
  endif()
  add_library(colift_pcl INTERFACE)
  target_include_directories(colift_pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIR} ${FLANN_INCLUDE_DIR})
  foreach(part common search kdtree)  # the rest is instantiated where it is used
    find_library(PCL_${part}_LIBRARY NAMES pcl_${part} libpcl_${part}.so.1.13 REQUIRED)
    target_link_libraries(colift_pcl INTERFACE ${PCL_${part}_LIBRARY})
    list(APPEND COLIFT_PCL_LIBRARIES ${PCL_${part}_LIBRARY})
  endforeach()
  target_link_libraries(colift_pcl INTERFACE Eigen3::Eigen)
endif()

if(COLIFT_KINECT)
  # linked into the capture process alone; fakenect is Debian's library of the same name that plays recordings
  pkg_check_modules(FREENECT IMPORTED_TARGET libfreenect>=0.5)
  if(NOT FREENECT_FOUND)
    message(FATAL_ERROR "libfreenect is missing: run tools/setup (Debian: libfreenect-dev), or configure with "
                        "-DCOLIFT_KINECT=OFF for a CoLift that has no Kinect")
  endif()
  file(GLOB COLIFT_FAKENECT_LIBRARY /usr/lib/*/fakenect/libfreenect.so.0.5)
endif()

if(COLIFT_OPENNI2)
  # linked into its capture process alone
  pkg_check_modules(OPENNI2 IMPORTED_TARGET libopenni2>=2.2)
  if(NOT OPENNI2_FOUND)
    message(FATAL_ERROR "OpenNI2 is missing: run tools/setup (Debian: libopenni2-dev), or configure with "
                        "-DCOLIFT_OPENNI2=OFF for a CoLift without its cameras")
  endif()
  find_library(COLIFT_OPENNI2_LIBRARY libOpenNI2.so.0 REQUIRED)  # as the programs of a distribution load it
endif()

if(COLIFT_DDS)
  # optional: without it `colift run --ros2` says what is missing
  find_package(CycloneDDS 0.10 QUIET)
  find_program(IDLC idlc)
  if(CycloneDDS_FOUND AND IDLC)
    enable_language(C)  # what idlc writes
  else()
    message(STATUS "Cyclone DDS is missing (Debian: cyclonedds-dev, cyclonedds-tools): CoLift is built without ROS 2")
    set(COLIFT_DDS OFF)
  endif()
endif()
