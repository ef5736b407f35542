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
  if(BACKBEND_SANITIZE_OMIT)
    target_compile_options(backbend_options INTERFACE -fno-sanitize=${BACKBEND_SANITIZE_OMIT})
  endif()
endif()
target_include_directories(backbend_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_definitions(backbend_options INTERFACE GLM_ENABLE_EXPERIMENTAL
  BACKBEND_VERSION="${PROJECT_VERSION}")

# Files of one folder are compiled a few at a time: what they include is read once for all of them,
# which takes about 0.6 of the time. `debug` compiles each by itself, so that none leans on what
# another includes. Names without linkage must differ within a folder, and among cold ones.
option(BACKBEND_UNITY "Compile the files of a folder together, a few at a time" ON)
set(BACKBEND_FILES_TOGETHER 8)
if(BACKBEND_UNITY)
  # Raised for every file but the one that is named to the compiler.
  target_compile_options(backbend_options INTERFACE -Wno-subobject-linkage)
endif()

# backbend_together(TARGET SOURCES [ALONE FILES] [COLD FOLDERS]): gives a target its sources, those of
# each folder in files that include them, but for those that have compile options of their own. Paths
# are taken from the project's root, so that every checkout has the same files, for a compiler cache.
# COLD folders, whose code takes no time that anybody waits for, are taken as one, and -O1 compiles them
# in three quarters of the time.
function(backbend_together target sources)
  cmake_parse_arguments(PARSE_ARGV 2 together "" "" "ALONE;COLD")
  if(NOT BACKBEND_UNITY)
    target_sources(${target} PRIVATE ${sources})
    return()
  endif()
  list(TRANSFORM together_ALONE PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  get_filename_component(here ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  list(TRANSFORM together_COLD PREPEND ${here}_ OUTPUT_VARIABLE cold_folders)
  set(folders "")
  foreach(source ${sources})
    if(source MATCHES "[.]h$" OR source IN_LIST together_ALONE)
      target_sources(${target} PRIVATE ${source})
      continue()
    endif()
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${source})
    get_filename_component(folder ${path} DIRECTORY)
    string(MAKE_C_IDENTIFIER ${folder} folder)
    if(folder IN_LIST cold_folders)
      set(folder cold)
    endif()
    list(APPEND folders ${folder})
    list(APPEND files_${folder} ${path})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder ${folders})
    list(LENGTH files_${folder} count)
    math(EXPR parts "(${count} + ${BACKBEND_FILES_TOGETHER} - 1) / ${BACKBEND_FILES_TOGETHER}")
    foreach(part RANGE 1 ${parts})
      math(EXPR first "(${part} - 1) * ${count} / ${parts}")
      math(EXPR length "${part} * ${count} / ${parts} - ${first}")
      list(SUBLIST files_${folder} ${first} ${length} files)
      list(TRANSFORM files REPLACE "(.+)" "#include \"\\1\"\n")
      list(JOIN files "" text)
      set(file ${CMAKE_CURRENT_BINARY_DIR}/${target}_together/${folder}_${part}.cpp)
      file(CONFIGURE OUTPUT ${file} CONTENT "${text}" @ONLY)
      target_sources(${target} PRIVATE ${file})
      if(folder STREQUAL cold)
        set_source_files_properties(${file} PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
      endif()
    endforeach()
  endforeach()
endfunction()

# backbend_layer(NAME [EXCEPT FOLDER/] [ALONE FILES] [COLD FOLDERS]): one layer of the program, from
# every source file in its folder, but for one folder of it.
function(backbend_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 layer "" "EXCEPT" "ALONE;COLD")
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp *.h)
  if(layer_EXCEPT)
    list(FILTER sources EXCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/${layer_EXCEPT}")
  endif()
  add_library(backbend_${name} STATIC)
  backbend_together(backbend_${name} "${sources}" ALONE ${layer_ALONE} COLD ${layer_COLD})
  # Position independent where Python's module is built: it and the program link the same objects.
  set_target_properties(backbend_${name} PROPERTIES LINKER_LANGUAGE CXX)
  if(BACKBEND_PYTHON)
    set_target_properties(backbend_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  add_library(backbend::${name} ALIAS backbend_${name})
  target_link_libraries(backbend_${name} PUBLIC glm::glm PRIVATE backbend_options)
  target_include_directories(backbend_${name} PUBLIC ${PROJECT_SOURCE_DIR})
endfunction()
