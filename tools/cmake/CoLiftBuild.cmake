# How every target of CoLift is compiled.
include(GNUInstallDirs)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})

find_program(CCACHE ccache)
if(CCACHE)
  # what is new is not preprocessed first only to be looked up; what used a precompiled header may be reused, and is known by
  # that header's checksum
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_DEPEND=1 CCACHE_PCH_EXTSUM=1
      ${CCACHE})
endif()

# Eigen's templates fill the compiler's heap, which gcc looks through again and again: with more room for it a file takes a tenth less
# time and a fifth more memory (1.3 GB for the largest unit).
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  add_compile_options(--param=ggc-min-expand=300 --param=ggc-min-heapsize=800000)
endif()

# gold links in a quarter of the time; wherever there are binutils of Debian 12 it is there
include(CheckLinkerFlag)
check_linker_flag(CXX -fuse-ld=gold COLIFT_GOLD)
if(COLIFT_GOLD)
  add_link_options(-fuse-ld=gold)
endif()

set(COLIFT_SANITIZE "" CACHE STRING "Sanitizers: address,undefined or thread")
if(COLIFT_SANITIZE)
  add_compile_options(-fsanitize=${COLIFT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND COLIFT_SANITIZE MATCHES undefined)
    # A check at each reference doubles the time to compile Eigen. A null one ends in AddressSanitizer's report anyway; the
    # parsers, which alone read what may not be aligned, are fuzzed with every check (clang, tests/fuzz).
    add_compile_options(-fno-sanitize=null,alignment,object-size,vptr)
  endif()
  add_link_options(-fsanitize=${COLIFT_SANITIZE})
endif()

# Loops over pixels, of which no thread shares anything while they run: ThreadSanitizer would look at each access, and a lift
# take two and a half minutes. colift_one_thread(NAME) for a library, colift_one_thread(FILES...) for files of one.
function(colift_one_thread)
  if(NOT COLIFT_SANITIZE STREQUAL "thread")
    return()
  endif()
  if(TARGET ${ARGV0})
    target_compile_options(${ARGV0} PRIVATE -fno-sanitize=thread)
  else()
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -fno-sanitize=thread)
  endif()
endfunction()

# Debian's PCL was built with plain malloc: Eigen must not switch to its own aligned one, neither for AVX nor for ASan.
# Layouts depend on it, so colift_hal hands it on to every program that links the library; geometry.hpp checks.
set(COLIFT_EIGEN_LAYOUT EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
add_compile_definitions(${COLIFT_EIGEN_LAYOUT})

add_custom_target(libraries)  # all that are installed

# colift_library(NAME SOURCES... LINK ...): a static library of this repository with its include root and warnings.
function(colift_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  string(REPLACE "colift_" "" short ${name})
  add_library(CoLift::${short} ALIAS ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${short})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/colift>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE})
  colift_warnings(${name})
  colift_precompiled(${name} library)
  colift_units(${name})
  install(TARGETS ${name} EXPORT CoLiftTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libcolift-dev)
  add_dependencies(libraries ${name})
endfunction()

# colift_warnings(), but not for C that was generated.
function(colift_cxx_warnings name)
  target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wnon-virtual-dtor;-Woverloaded-virtual>)
  if(NOT COLIFT_SANITIZE)
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
endfunction()

# Warnings are errors; but through a sanitizer's calls gcc sees some that are none.
function(colift_warnings name)
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                         -Woverloaded-virtual -Wnull-dereference)
  if(NOT COLIFT_SANITIZE)
    target_compile_options(${name} PRIVATE -Werror)
  endif()
  # gcc 12 warns inside Eigen's inlined assignments at -O3; these are known to be false there
  target_compile_options(${name} PRIVATE -Wno-null-dereference
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overread -Wno-restrict>)
endfunction()
