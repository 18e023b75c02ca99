# Tests of the package without ROS alone.

# An outside project finds the installed package, links battery_sof::core and asks it a question.
add_test(NAME outside_project
  COMMAND ${CMAKE_COMMAND} "-DBUILD=${PROJECT_BINARY_DIR}" "-DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/outside_project"
    "-DWORK=${CMAKE_CURRENT_BINARY_DIR}/outside project" "-DCXX=${CMAKE_CXX_COMPILER}" "-DSOF=$<TARGET_FILE:sof>"
    "-DSCENARIO=${PROJECT_SOURCE_DIR}/config/scenarios/city_drive.yaml"
    -P "${CMAKE_CURRENT_SOURCE_DIR}/outside_project/try.cmake")
set_tests_properties(outside_project PROPERTIES TIMEOUT 300)

# What can differ from the catkin package, for `make test-core`; the other programs are the same sources once more.
set(core_checks recording_test report_test bag_test cli_test)
add_custom_target(core_checks DEPENDS ${core_checks} sof simulate_city_drive)
set_tests_properties(${core_checks} outside_project PROPERTIES LABELS core_checks)
if(BATTERY_SOF_PYTHON)
  add_dependencies(core_checks battery_sof_python)
  set_tests_properties(python_module PROPERTIES LABELS core_checks)
endif()
