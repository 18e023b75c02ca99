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

# battery_sof_build_quickly(LIBRARY [HEADERS <header>...] [TOGETHER]): further headers that its files share; TOGETHER compiles
# eight files at a time.
function(battery_sof_build_quickly library)
  cmake_parse_arguments(ARG "TOGETHER" "" "HEADERS" ${ARGN})
  target_compile_options(${library} PRIVATE $<$<CONFIG:Release>:-O2>)
  if(NOT BATTERY_SOF_QUICK_BUILD)
    return()
  endif()
  target_precompile_headers(${library} PRIVATE ${battery_sof_common_headers} ${ARG_HEADERS})
  if(ARG_TOGETHER)
    set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  endif()
endfunction()
