# Fails when a file includes what its own place may not know: another layer, or a later room of its
# own layer. A room is the folder of a file; rooms are listed from the first, which knows no other,
# to the last.
set(solver_uses "solver")
set(skin_uses "solver|skin")
set(import_uses "skin|import")
set(render_uses "render")
set(validate_uses "solver|skin|render|validate")

set(solver_rooms math rig curves systems)
set(skin_rooms character deform gltf clip anatomy weights body)
set(render_rooms image trace review)
set(validate_rooms
  text tasks files verdicts model metrics/math metrics/chain metrics/surface metrics/image sweeps
  live stage measure judge camera compare evidence history report carry calibrate prove hunt night
  clips selftest tune why repair export farm watch serve)

foreach(layer solver skin import render validate)
  file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/${layer}/*.h ${ROOT}/${layer}/*.cpp)
  foreach(source ${sources})
    file(STRINGS ${ROOT}/${source} includes REGEX "^#include \"[a-z]+/")
    cmake_path(GET source PARENT_PATH room)
    string(REPLACE "${layer}/" "" room "${room}")
    list(FIND ${layer}_rooms "${room}" place)
    if(DEFINED ${layer}_rooms AND place EQUAL -1 AND NOT room STREQUAL "openimageio")
      message(SEND_ERROR "${source}: its folder is not a room that tests/layers.cmake lists")
    endif()
    foreach(include ${includes})
      if(NOT include MATCHES "\"(${${layer}_uses})/")
        message(SEND_ERROR "${source}: '${include}' climbs a layer")
      endif()
      if(DEFINED ${layer}_rooms AND include MATCHES "\"${layer}/(.+)/[^/]+\"")
        list(FIND ${layer}_rooms "${CMAKE_MATCH_1}" other)
        if(NOT place EQUAL -1 AND (other EQUAL -1 OR other GREATER place))
          message(SEND_ERROR "${source}: '${include}' is in a later room than its own")
        endif()
      endif()
    endforeach()
  endforeach()
endforeach()
