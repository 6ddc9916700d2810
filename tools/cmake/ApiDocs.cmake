# cmake --build build --target api_docs: a reference of the public headers, in build/docs/api. Doxygen is not needed
# for anything else.
find_program(DOXYGEN doxygen)
if(DOXYGEN)
  list(TRANSFORM COLIFT_PUBLIC_HEADERS PREPEND "${PROJECT_SOURCE_DIR}/" OUTPUT_VARIABLE documented)
  list(APPEND documented ${contract_headers} ${PROJECT_SOURCE_DIR}/tools/examples/README.md)
  list(JOIN documented " " DOCUMENTED)
  file(GLOB examples CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tools/examples/*.[ch]pp)  # the main page links them
  list(JOIN examples " " EXAMPLES)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${PROJECT_BINARY_DIR}/docs/Doxyfile @ONLY)
  add_custom_target(api_docs COMMAND ${CMAKE_COMMAND} -DDOXYGEN=${DOXYGEN} -DFOLDER=${PROJECT_BINARY_DIR}/docs
                                     -P ${CMAKE_CURRENT_LIST_DIR}/run_doxygen.cmake
                    COMMENT "Writing the reference to ${PROJECT_BINARY_DIR}/docs/api" VERBATIM)
  if(COLIFT_TESTS)
    add_test(NAME api_docs COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR} --target api_docs)
    set_tests_properties(api_docs PROPERTIES LABELS package TIMEOUT 120)
  endif()
else()
  add_custom_target(api_docs COMMAND ${CMAKE_COMMAND} -E echo "api_docs needs Doxygen: apt-get install doxygen"
                             COMMAND ${CMAKE_COMMAND} -E false VERBATIM)
endif()
