# The report page in a real browser. Skipped, with the reason printed, where Node, Chromium or the
# npm packages (npm ci --prefix tests/web) are absent.
add_executable(report_sample web/sample_report.cpp validate/report_sample_fixture.cpp
  validate/report_picture_fixture.cpp validate/report_mesh_fixture.cpp)
target_link_libraries(report_sample PRIVATE backbend_options backbend_source_folder backbend::validate
  nlohmann_json::nlohmann_json)
find_program(BACKBEND_NODE node)
if(BACKBEND_NODE)
  add_test(NAME web/report_page COMMAND ${BACKBEND_NODE} ${CMAKE_CURRENT_LIST_DIR}/page_test.mjs
    $<TARGET_FILE:report_sample>)
  set_tests_properties(web/report_page PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 1800 LABELS web)
else()
  message(STATUS "Node is not installed: the report page is not tested in a browser")
endif()
