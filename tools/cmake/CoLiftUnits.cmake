# Half of the time of a whole build goes into reading the same headers and making the same templates for every file.
# With -DCOLIFT_UNITY=ON several files of a library are compiled as one: what the scripts in tools/ do. For working on the code it is off: a change then
# compiles one file.
option(COLIFT_UNITY "Compile several files as one unit" OFF)
find_program(AWK NAMES awk REQUIRED)

# colift_units(TARGET): after all its sources are known. Files whose own names would meet stay apart, see units.awk.
function(colift_units target)
  if(NOT COLIFT_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  set(files "")
  foreach(source ${sources})
    get_filename_component(file ${source} ABSOLUTE)
    get_source_file_property(alone ${file} COMPILE_DEFINITIONS)
    if(file MATCHES "^${PROJECT_SOURCE_DIR}/.*\\.cpp$" AND NOT file MATCHES "^${PROJECT_BINARY_DIR}/" AND NOT alone)
      list(APPEND files ${file})
    endif()
  endforeach()
  list(SORT files)
  execute_process(COMMAND ${AWK} -v most_lines=3000 -f ${PROJECT_SOURCE_DIR}/tools/cmake/units.awk ${files}
                  OUTPUT_VARIABLE units COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\n" ";" units "${units}")
  foreach(line ${units})
    if(line MATCHES "^([0-9]+) (.*)$")
      set_source_files_properties(${CMAKE_MATCH_2} PROPERTIES UNITY_GROUP ${target}_${CMAKE_MATCH_1})
    endif()
  endforeach()
  # What a file has for itself is seen by the whole unit: gcc takes it for a header's, and for what a local name hides.
  # Builds without units warn of both.
  target_compile_options(${target} PRIVATE -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
