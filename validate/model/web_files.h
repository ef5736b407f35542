#pragma once
#include <string_view>

namespace backbend::validate::web {

/// Files of validate/report compiled into the program by embed.cmake, byte for byte.
std::string_view report_schema_json();
std::string_view page_css();     // report/web/*.css, joined in name order
std::string_view page_script();  // report/web/*.js, joined in name order inside one function

/// `sha256-BASE64` of the two texts above, for the page's content security policy.
std::string_view page_css_hash();
std::string_view page_script_hash();

}  // namespace backbend::validate::web
