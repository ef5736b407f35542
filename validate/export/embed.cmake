# Compiles the scripts for Blender and Maya into the program.
#
# Included by validate/CMakeLists.txt it adds the generated source to backbend_validate; run as a
# script (cmake -DROOT=... -DOUT=... -P embed.cmake) it writes that source.

if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(export_out ${CMAKE_CURRENT_BINARY_DIR}/export_script_files.cpp)
  add_custom_command(OUTPUT ${export_out}
    COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_CURRENT_LIST_DIR} -DOUT=${export_out} -P ${CMAKE_CURRENT_LIST_FILE}
    DEPENDS ${CMAKE_CURRENT_LIST_DIR}/blender_even.py ${CMAKE_CURRENT_LIST_DIR}/maya_even.py
      ${CMAKE_CURRENT_LIST_FILE} ${PROJECT_SOURCE_DIR}/cmake/CxxLiteral.cmake
    COMMENT "Embedding the scripts for Blender and Maya" VERBATIM)
  target_sources(backbend_validate PRIVATE ${export_out})
  return()
endif()

include(${CMAKE_CURRENT_LIST_DIR}/../../cmake/CxxLiteral.cmake)

set(functions "")
foreach(name blender_even maya_even)
  file(READ ${ROOT}/${name}.py text)
  literal(code "${text}")
  string(APPEND functions "std::string_view ${name}() { return\n${code}; }\n")
endforeach()
file(WRITE ${OUT}.new "// Written by validate/export/embed.cmake.
#include \"validate/export/script_files.h\"
namespace backbend::validate::scripts {
${functions}}  // namespace backbend::validate::scripts
")
file(RENAME ${OUT}.new ${OUT})
