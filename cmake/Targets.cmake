# What every target of ours shares.

# x86-64-v3 (AVX2, FMA) is required of every machine: the C library then picks one and the same
# variant of each mathematical function everywhere, which bit-identical results rest on.
# -Wrestrict is off: g++ 12 raises it falsely on string concatenation (its bug 105651).
add_library(backbend_options INTERFACE)
target_compile_options(backbend_options INTERFACE
  -Wall -Wextra -Wno-restrict $<$<BOOL:${BACKBEND_WERROR}>:-Werror>
  -march=x86-64-v3 -mtune=generic -ffp-contract=off -fno-math-errno -fvisibility=hidden)
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  target_compile_options(backbend_options INTERFACE -Wno-unknown-warning-option)
endif()
if(BACKBEND_FUZZ)
  # Coverage for libFuzzer in all that is ours; its main() comes with each fuzzer alone.
  target_compile_options(backbend_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(BACKBEND_SANITIZE)
  # Sanitizers' code makes g++ 12 believe that std::regex uses what it never set.
  target_compile_options(backbend_options INTERFACE -fsanitize=${BACKBEND_SANITIZE}
    -Wno-maybe-uninitialized -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(backbend_options INTERFACE -fsanitize=${BACKBEND_SANITIZE})
endif()
target_include_directories(backbend_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_definitions(backbend_options INTERFACE GLM_ENABLE_EXPERIMENTAL
  BACKBEND_VERSION="${PROJECT_VERSION}")

# backbend_layer(NAME [EXCEPT FOLDER/]): one layer of the program, from every source file in its
# folder, but for one folder of it.
function(backbend_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 layer "" "EXCEPT" "")
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp *.h)
  if(layer_EXCEPT)
    list(FILTER sources EXCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/${layer_EXCEPT}")
  endif()
  add_library(backbend_${name} STATIC ${sources})
  # Position independent where Python's module is built: it and the program link the same objects.
  set_target_properties(backbend_${name} PROPERTIES LINKER_LANGUAGE CXX)
  if(BACKBEND_PYTHON)
    set_target_properties(backbend_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  add_library(backbend::${name} ALIAS backbend_${name})
  target_link_libraries(backbend_${name} PUBLIC glm::glm PRIVATE backbend_options)
  target_include_directories(backbend_${name} PUBLIC ${PROJECT_SOURCE_DIR})
endfunction()
