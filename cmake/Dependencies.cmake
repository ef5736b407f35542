# Every third-party library backbend links, found once. All install from Debian 12 and 13 packages.
find_package(Threads REQUIRED)
find_package(glm REQUIRED CONFIG)
find_package(TBB REQUIRED CONFIG)
find_package(tomlplusplus REQUIRED CONFIG)
find_package(nlohmann_json REQUIRED CONFIG)
find_package(TinyGLTF REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(spdlog REQUIRED CONFIG)
find_package(Imath REQUIRED CONFIG)
find_package(OpenEXR REQUIRED CONFIG)
find_package(OpenImageIO REQUIRED CONFIG)
find_package(assimp REQUIRED CONFIG)
find_package(draco REQUIRED CONFIG)
find_package(meshoptimizer REQUIRED CONFIG)
find_package(SQLite3 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Eigen3 3.4 REQUIRED CONFIG NO_MODULE)
# Its CMake package is in other places on Debian 12 and 13; the C interface needs no more.
find_path(BACKBEND_NLOPT_INCLUDE nlopt.h REQUIRED)
find_library(BACKBEND_NLOPT_LIBRARY nlopt REQUIRED)

# Debian's OpenImageIO target lists an OpenCV include folder that its packages do not install.
get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
set(oiio_present "")
foreach(dir ${oiio_includes})
  if(IS_DIRECTORY ${dir})
    list(APPEND oiio_present ${dir})
  endif()
endforeach()
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_present}")

# Embree 4 (Debian 13) is preferred where it exists; 3.13 is Debian 12's.
find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED CONFIG)
endif()

# Offered for review pictures where it is found; Debian 12 has no package of it.
find_package(OpenImageDenoise 2 QUIET CONFIG)

# The module for Python. It is for the system's own interpreter, which Debian's Blender uses too; the
# first on the PATH may be another.
if(NOT DEFINED Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The interpreter that the Python module is for")
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.10 QUIET CONFIG)
set(BACKBEND_PYTHON AUTO CACHE STRING "Build the Python module: ON, OFF, or AUTO: where python3-dev and pybind11-dev are installed")
set_property(CACHE BACKBEND_PYTHON PROPERTY STRINGS AUTO ON OFF)
set(can_build_python OFF)
if(Python_Development.Module_FOUND AND pybind11_FOUND AND NOT BACKBEND_FUZZ)
  set(can_build_python ON)
endif()
if(BACKBEND_PYTHON STREQUAL AUTO)
  # Looked at whenever CMake runs, so that packages which come later count.
  set(BACKBEND_PYTHON ${can_build_python})
elseif(BACKBEND_PYTHON AND NOT can_build_python)
  message(FATAL_ERROR "BACKBEND_PYTHON=ON needs python3-dev and pybind11-dev, for ${Python_EXECUTABLE}, and no fuzzers")
endif()

find_path(BACKBEND_XXHASH_INCLUDE xxhash.h REQUIRED)
find_library(BACKBEND_XXHASH_LIBRARY xxhash REQUIRED)
