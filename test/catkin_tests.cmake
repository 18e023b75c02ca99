# Programs of tests in the catkin package: run through ctest, and through catkin's run_tests. catkin_add_gtest and add_rostest
# do not quote paths; a checkout in a folder with a space in its name needs the quotes, so the two functions below stand in for
# them.
find_package(rostest REQUIRED)
find_program(BATTERY_SOF_ROSTEST rostest)

# All *_test.cpp below the given folders, in one program. Tests that match SLOW (as --gtest_filter has it) are a row of their own,
# ${name}_slow, which `make test` leaves to `make test-slow`.
function(battery_sof_gtest name)
  cmake_parse_arguments(ARG "" "SLOW" "FOLDERS;LINK" ${ARGN})
  battery_sof_test_sources(sources ${ARG_FOLDERS})
  if(NOT sources)
    return()
  endif()
  catkin_add_executable_with_gtest(${name} ${sources} EXCLUDE_FROM_ALL)
  target_include_directories(${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE
    BATTERY_SOF_SOURCE_DIR="${PROJECT_SOURCE_DIR}" BATTERY_SOF_TEST_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
  target_include_directories(${name} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(${name} ${ARG_LINK} gmock gtest_main)  # matchers
  battery_sof_compile_quickly(${name})
  add_dependencies(tests ${name})
  get_target_property(folder ${name} RUNTIME_OUTPUT_DIRECTORY)
  set(rows ${name})
  set(${name}_filter "*")
  if(ARG_SLOW)
    set(rows ${name} ${name}_slow)
    set(${name}_filter "-${ARG_SLOW}")
    set(${name}_slow_filter "${ARG_SLOW}")
  endif()
  foreach(row ${rows})
    set(results "gtest-${row}.xml")
    catkin_run_tests_target("gtest" ${row} ${results} DEPENDENCIES ${name}
      COMMAND "\"${folder}/${name}\" \"--gtest_filter=${${row}_filter}\" --gtest_output=\"xml:${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/${results}\"")
  endforeach()
  if(ARG_SLOW)
    set_tests_properties(_ctest_${PROJECT_NAME}_gtest_${name}_slow PROPERTIES LABELS slow)
  endif()
endfunction()

# devel/env.sh: the environment catkin caches for tests is that of the first configuration, when nothing was built yet.
function(battery_sof_rostest name)
  set(results "${name}.xml")
  catkin_run_tests_target("rostest" ${name} "rostest-${results}"
    DEPENDENCIES battery_sof_node sof simulate_city_drive
    COMMAND "\"${CATKIN_DEVEL_PREFIX}/env.sh\" \"${PYTHON_EXECUTABLE}\" \"${BATTERY_SOF_ROSTEST}\" \"--pkgdir=${PROJECT_SOURCE_DIR}\" --package=${PROJECT_NAME} --results-filename ${results} --results-base-dir \"${CATKIN_TEST_RESULTS_DIR}\" \"${CMAKE_CURRENT_SOURCE_DIR}/ros/${name}.test\"")
  # One roscore at a time: nodes have samples to keep up with, beside at most what else one core does. Begun first (COST): theirs is the longest row.
  set_tests_properties(_ctest_${PROJECT_NAME}_rostest_${name} PROPERTIES TIMEOUT 300 RESOURCE_LOCK roscore COST 100)
endfunction()
