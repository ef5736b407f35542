# The command-line tests: every class of every cli/*_test.py becomes a test of its own, run against
# the built program, so that none can be written and never run.
# By the interpreter of the Python module, that is the system's, for one that a version manager puts
# in front of it takes several times as long to start.
if(NOT DEFINED Python3_EXECUTABLE AND Python_Interpreter_FOUND)
  set(Python3_EXECUTABLE ${Python_EXECUTABLE})
endif()
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)

file(GLOB cli_tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*_test.py)
foreach(file ${cli_tests})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  cmake_path(GET file STEM stem)
  file(STRINGS ${file} classes REGEX "^class [A-Z][A-Za-z]*\\(")
  if(NOT classes)
    message(FATAL_ERROR "${file} holds no class of tests")
  endif()
  set(most_seconds 900)
  if(stem MATCHES "^(kills|failing_calls)_test$")
    set(most_seconds 10800)  # as the presets `kills` and `faults` run them
  elseif(BACKBEND_SANITIZE MATCHES "thread")
    set(most_seconds 14400)  # a preset's own bound does not count where a test has one
  endif()
  foreach(class ${classes})
    string(REGEX REPLACE "^class ([A-Za-z]+)\\(.*" "\\1" class "${class}")
    add_test(NAME cli/${stem}.${class}
      COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/run.py ${file} ${class})
    set_tests_properties(cli/${stem}.${class} PROPERTIES
      LABELS "cli;${stem}" SKIP_RETURN_CODE 77 TIMEOUT ${most_seconds}
      ENVIRONMENT "BACKBEND=$<TARGET_FILE:backbend>;BACKBEND_BUILD=${CMAKE_BINARY_DIR}")
  endforeach()
endforeach()

# The layout of every source file is clang-format's. Versions differ in taste: 14 decides.
add_test(NAME format COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P
  ${CMAKE_CURRENT_LIST_DIR}/format.cmake)
set_tests_properties(format PROPERTIES SKIP_REGULAR_EXPRESSION "format: skipped")
