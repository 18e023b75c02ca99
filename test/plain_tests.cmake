# Programs of tests without ROS: GoogleTest and ctest.
find_package(GTest REQUIRED)

function(battery_sof_gtest name)
  cmake_parse_arguments(ARG "" "" "FOLDERS;LINK" ${ARGN})
  battery_sof_test_sources(sources ${ARG_FOLDERS})
  add_executable(${name} ${sources})
  target_include_directories(${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE
    BATTERY_SOF_SOURCE_DIR="${PROJECT_SOURCE_DIR}" BATTERY_SOF_TEST_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest_main)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 600)
endfunction()
