# The versions of what is linked, for the bill of materials in each report: those of the
# distribution's packages, or where there are none what each library's own CMake file says.
set(backbend_libraries "")
foreach(entry
    "assimp libassimp-dev ${assimp_VERSION}" "CLI11 libcli11-dev ${CLI11_VERSION}" "draco libdraco-dev ${draco_VERSION}"
    "eigen libeigen3-dev ${Eigen3_VERSION}" "embree libembree-dev ${embree_VERSION}" "glm libglm-dev ${glm_VERSION}" "imath libimath-dev ${Imath_VERSION}"
    "meshoptimizer libmeshoptimizer-dev ${meshoptimizer_VERSION}" "nlopt libnlopt-dev " "nlohmann-json nlohmann-json3-dev ${nlohmann_json_VERSION}" "openexr libopenexr-dev ${OpenEXR_VERSION}"
    "openimageio libopenimageio-dev ${OpenImageIO_VERSION}" "tbb libtbb-dev ${TBB_VERSION}"
    "sqlite libsqlite3-dev ${SQLite3_VERSION}"
    "tinygltf libtinygltf-dev ${TinyGLTF_VERSION}" "tomlplusplus libtomlplusplus-dev ${tomlplusplus_VERSION}"
    "xxhash libxxhash-dev " "zlib zlib1g-dev ${ZLIB_VERSION}")
  separate_arguments(entry)
  list(GET entry 0 name)
  list(GET entry 1 package)
  execute_process(COMMAND dpkg-query -W -f "\${Version}" ${package}
    OUTPUT_VARIABLE version ERROR_QUIET RESULT_VARIABLE result)
  if(NOT result EQUAL 0 OR version STREQUAL "")
    list(LENGTH entry known)
    set(version unknown)
    if(known GREATER 2)
      list(GET entry 2 version)
    endif()
  endif()
  string(APPEND backbend_libraries "${name} ${version}|")
endforeach()
