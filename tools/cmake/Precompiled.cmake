# Half of the compiler's work on a usual file is Eigen's headers, in the tests Catch2's as well: parsed once they cost nothing.
# A file still includes what it uses; -DCOLIFT_PCH=OFF shows whether it does.
option(COLIFT_PCH "Parse the common headers once" ON)

# colift_precompiled_headers(KIND OPTIONS...): makes tools/cmake/precompiled/KIND.hpp, for targets with these options
function(colift_precompiled_headers kind)
  set(source ${PROJECT_BINARY_DIR}/precompiled_${kind}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(precompiled_${kind} OBJECT ${source})
  target_precompile_headers(precompiled_${kind} PRIVATE ${PROJECT_SOURCE_DIR}/tools/cmake/precompiled/${kind}.hpp)
  target_compile_options(precompiled_${kind} PRIVATE ${ARGN} $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  target_link_libraries(precompiled_${kind} PRIVATE Eigen3::Eigen fmt::fmt)
  if(CCACHE)
    set_target_properties(precompiled_${kind} PROPERTIES
                          CXX_COMPILER_LAUNCHER "${PROJECT_SOURCE_DIR}/tools/cmake/precompiled/with_checksum;${CMAKE_CXX_COMPILER_LAUNCHER}")
  endif()
  colift_warnings(precompiled_${kind})  # the same macros: -Wpedantic takes one away
endfunction()

# colift_precompiled(TARGET library|program|test)
function(colift_precompiled target kind)
  if(COLIFT_PCH)
    target_precompile_headers(${target} REUSE_FROM precompiled_${kind})
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  endif()
endfunction()

if(COLIFT_PCH)
  colift_precompiled_headers(library)
  colift_precompiled_headers(program -O1)
  target_link_libraries(precompiled_program PRIVATE CLI11::CLI11 nlohmann_json::nlohmann_json)
  if(COLIFT_TESTS)
    colift_precompiled_headers(test -O1)
    set_target_properties(precompiled_test PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(precompiled_test PRIVATE -fPIE)  # tests are executables
  endif()
endif()
