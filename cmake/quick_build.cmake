# What makes a build from nothing short and changes no result: headers that most files read are read once for a library, files of a
# library that nothing waits for are optimised less (-O2, in the core outside the simulation and the fits), and some are compiled
# together. OFF: every file by itself, as `make test-core` holds. ccache keeps nothing of what was compiled with such headers.
set(quick_build_default ON)
if(CMAKE_CXX_COMPILER_LAUNCHER)
  set(quick_build_default OFF)
endif()
option(BATTERY_SOF_QUICK_BUILD "Precompiled headers, and files compiled together" ${quick_build_default})
# Programs and libraries that link shared libraries of this package stay as they are when only the inside of one has changed.
set(CMAKE_LINK_DEPENDS_NO_SHARED ON)

set(battery_sof_common_headers
  <algorithm> <array> <cmath> <complex> <cstddef> <filesystem> <functional> <limits> <map> <memory> <optional> <sstream> <stdexcept>
  <string> <utility> <vector>)

# battery_sof_build_quickly(LIBRARY [HEADERS <header>...] [TOGETHER | GROUPED]): further headers that its files share; TOGETHER compiles
# eight files at a time, GROUPED those that battery_sof_build_together() names.
function(battery_sof_build_quickly library)
  cmake_parse_arguments(ARG "TOGETHER;GROUPED" "" "HEADERS" ${ARGN})
  target_compile_options(${library} PRIVATE $<$<CONFIG:Release>:-O2>)
  if(NOT BATTERY_SOF_QUICK_BUILD)
    return()
  endif()
  target_precompile_headers(${library} PRIVATE ${battery_sof_common_headers} ${ARG_HEADERS})
  if(ARG_TOGETHER)
    set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  elseif(ARG_GROUPED AND NOT CMAKE_VERSION VERSION_LESS 3.18)
    set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  endif()
endfunction()

# battery_sof_build_together(FOLDER [ALONE <name>...]): eight files of a folder at a time, but for those with names of their own that
# another file of the folder has too.
function(battery_sof_build_together folder)
  cmake_parse_arguments(ARG "" "" "ALONE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cpp)
  string(MAKE_C_IDENTIFIER "${folder}" prefix)
  set(count 0)
  foreach(source ${sources})
    get_filename_component(name ${source} NAME_WE)
    if(NOT name IN_LIST ARG_ALONE)
      math(EXPR group "${count} / 8")
      math(EXPR count "${count} + 1")
      set_property(SOURCE ${source} PROPERTY UNITY_GROUP "${prefix}_${group}")
    endif()
  endforeach()
endfunction()
