# Runs Doxygen in FOLDER and fails for any warning. Fields may go without a comment where their name says it all
# (units are in the name, the parameters' help in visit()); classes, structs and all else may not.
cmake_minimum_required(VERSION 3.25)
file(MAKE_DIRECTORY ${FOLDER}/api)
execute_process(COMMAND ${DOXYGEN} Doxyfile WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE result)
file(STRINGS ${FOLDER}/warnings.log warnings)
list(FILTER warnings EXCLUDE REGEX "warning: Member .* is not documented")
list(JOIN warnings "\n" text)
if(NOT result EQUAL 0 OR warnings)
  message(FATAL_ERROR "Doxygen is not content:\n${text}")
endif()
