# Tests of the Python module: every ModuleTest of every *_test.py is a test of its own, run by the
# interpreter that the module is built for.
if(NOT BACKBEND_PYTHON)
  return()
endif()
set(run ${PROJECT_SOURCE_DIR}/tests/cli/run.py)
file(GLOB python_tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*_test.py)
# An interpreter without sanitizers needs their library before all others, and that of C++ with it,
# whose exceptions they look up once.
set(preload "")
if(BACKBEND_SANITIZE MATCHES "address")
  foreach(library libasan.so libstdc++.so)
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${library}
      OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(APPEND preload "${found}:")
  endforeach()
elseif(BACKBEND_SANITIZE MATCHES "thread")
  return()
endif()
foreach(file ${python_tests})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  cmake_path(GET file STEM stem)
  file(STRINGS ${file} classes REGEX "^class [A-Z][A-Za-z]*\\(ModuleTest\\)")
  if(NOT classes)
    message(FATAL_ERROR "${file} holds no class of tests")
  endif()
  foreach(class ${classes})
    string(REGEX REPLACE "^class ([A-Za-z]+)\\(.*" "\\1" class "${class}")
    add_test(NAME python/${stem}.${class} COMMAND ${Python_EXECUTABLE} -B ${run} ${file} ${class})
    set_tests_properties(python/${stem}.${class} PROPERTIES
      LABELS "python;${stem}" SKIP_RETURN_CODE 77 TIMEOUT 900
      ENVIRONMENT "BACKBEND=$<TARGET_FILE:backbend>;BACKBEND_BUILD=${CMAKE_BINARY_DIR};BACKBEND_PRELOAD=${preload};PYTHONPATH=${CMAKE_BINARY_DIR}/python")
  endforeach()
endforeach()
