# Compiles the page's files and the schema into the program.
#
# Included by validate/CMakeLists.txt it adds the generated source to backbend_validate; run as a
# script (cmake -DROOT=... -DOUT=... -P embed.cmake) it writes that source.

if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(report_dir ${CMAKE_CURRENT_LIST_DIR})
  set(report_out ${CMAKE_CURRENT_BINARY_DIR}/report_web_files.cpp)
  file(GLOB report_files CONFIGURE_DEPENDS ${report_dir}/web/*.js ${report_dir}/web/*.css
    ${report_dir}/report.schema.json)
  add_custom_command(OUTPUT ${report_out}
    COMMAND ${CMAKE_COMMAND} -DROOT=${report_dir} -DOUT=${report_out} -P ${CMAKE_CURRENT_LIST_FILE}
    DEPENDS ${report_files} ${CMAKE_CURRENT_LIST_FILE} ${PROJECT_SOURCE_DIR}/cmake/CxxLiteral.cmake
    COMMENT "Embedding the report page" VERBATIM)
  target_sources(backbend_validate PRIVATE ${report_out})
  return()
endif()

include(${CMAKE_CURRENT_LIST_DIR}/../../cmake/CxxLiteral.cmake)

# file(READ) eats nothing as long as no list handling touches the text, so brackets and semicolons
# are kept.
function(joined out pattern)
  file(GLOB files ${ROOT}/${pattern})
  list(SORT files)
  set(text "")
  foreach(path IN LISTS files)
    file(READ ${path} part)
    string(APPEND text "${part}")
  endforeach()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# Base64 of a hexadecimal digest: CMake has the digest but not the encoding that browsers want.
function(base64_sha256 out text)
  string(SHA256 hex "${text}")
  set(alphabet "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
  string(APPEND hex "00")  # 32 bytes are 10 triples and a pair: fill, then mark the fill with =
  set(text64 "")
  foreach(i RANGE 0 60 6)
    string(SUBSTRING ${hex} ${i} 6 triple)
    math(EXPR bits "0x${triple}")
    foreach(shift 18 12 6 0)
      math(EXPR index "(${bits} >> ${shift}) & 63")
      string(SUBSTRING ${alphabet} ${index} 1 letter)
      string(APPEND text64 ${letter})
    endforeach()
  endforeach()
  string(REGEX REPLACE ".$" "=" text64 ${text64})
  set(${out} "sha256-${text64}" PARENT_SCOPE)
endfunction()

joined(css "web/*.css")
joined(js "web/*.js")
set(js "(async () => {\n\"use strict\";\n${js}})();\n")
joined(schema "report.schema.json")
base64_sha256(css_hash "${css}")
base64_sha256(js_hash "${js}")
literal(css_code "${css}")
literal(js_code "${js}")
literal(schema_code "${schema}")
file(WRITE ${OUT}.new "// Written by validate/report/embed.cmake.
#include \"validate/model/web_files.h\"
namespace backbend::validate::web {
std::string_view report_schema_json() { return
${schema_code}; }
std::string_view page_css() { return
${css_code}; }
std::string_view page_script() { return
${js_code}; }
std::string_view page_css_hash() { return \"${css_hash}\"; }
std::string_view page_script_hash() { return \"${js_hash}\"; }
}  // namespace backbend::validate::web
")
file(RENAME ${OUT}.new ${OUT})
