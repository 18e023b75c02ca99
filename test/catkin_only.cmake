# Tests of the catkin package alone: what needs ROS, and what would say the same a second time in a build without it.
battery_sof_gtest(node_options_test FOLDERS unit/ros LINK battery_sof_ros ${YAML_CPP_LIBRARIES})
if(BATTERY_SOF_SANITIZE_THREADS)
  target_compile_options(node_options_test PRIVATE ${thread_sanitizer})
endif()
battery_sof_gtest(property_test FOLDERS property SLOW "IdentifyWithEffects.*:Identify.*NineOfTen*:Identify.ReachesTheOptimum*:*NeverDiverge*" LINK battery_sof battery_sof_scenario_generator)
battery_sof_gtest(architecture_test FOLDERS architecture)
target_compile_definitions(architecture_test PRIVATE BATTERY_SOF_CXX="${CMAKE_CXX_COMPILER}"
  BATTERY_SOF_EIGEN_DIR="${EIGEN3_INCLUDE_DIRS}")
set_target_properties(architecture_test PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)  # it has no Eigen

# What makes a node's core throw, for ros/faults_test.py (no .test file runs it yet).
add_library(faulty_core MODULE EXCLUDE_FROM_ALL ros/faulty_core.cpp)
target_include_directories(faulty_core SYSTEM PRIVATE ${EIGEN3_INCLUDE_DIRS})
target_link_libraries(faulty_core ${CMAKE_DL_LIBS})
set_target_properties(faulty_core PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib)
add_dependencies(tests faulty_core)

file(GLOB rostests CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/ros/*.test)
foreach(file ${rostests})
  get_filename_component(name ${file} NAME_WE)
  battery_sof_rostest(${name})
endforeach()

# The diagnosis page and the live page in a browser.
add_executable(made_pages EXCLUDE_FROM_ALL page/made_pages_main.cpp)
target_include_directories(made_pages PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(made_pages battery_sof)
add_dependencies(tests made_pages)
get_target_property(made_pages_folder made_pages RUNTIME_OUTPUT_DIRECTORY)
add_test(NAME diagnosis_page_in_a_browser
  COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/page/browser_test.py"
    "${made_pages_folder}/made_pages" "${CMAKE_CURRENT_BINARY_DIR}/page")
set_tests_properties(diagnosis_page_in_a_browser PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
add_test(NAME live_page_in_a_browser
  COMMAND "${CATKIN_DEVEL_PREFIX}/env.sh" "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/page/live_test.py"
    "${CATKIN_DEVEL_PREFIX}" "${CMAKE_CURRENT_BINARY_DIR}/page")
add_test(NAME live_page_under_attack
  COMMAND "${CATKIN_DEVEL_PREFIX}/env.sh" "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/page/live_attack_test.py"
    "${CATKIN_DEVEL_PREFIX}" "${CMAKE_CURRENT_BINARY_DIR}/page")
set_tests_properties(live_page_in_a_browser live_page_under_attack PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300 RUN_SERIAL TRUE)

# A script of tests, and what it is called with: it finds the scripts' own package. 77: skipped.
function(battery_sof_script_test name timeout script)
  add_test(NAME ${name} COMMAND "${PYTHON_EXECUTABLE}" -B "${CMAKE_CURRENT_SOURCE_DIR}/${script}" ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT ${timeout}
    ENVIRONMENT "BATTERY_SOF_BUILD=${CMAKE_BINARY_DIR};PYTHONPATH=${PROJECT_SOURCE_DIR}/tools")
endfunction()

# The benchmark of the diagnosis: its arithmetic, and a tenth of it as a whole (some minutes).
battery_sof_script_test(proof_counts_right 120 proof/proof_test.py)
add_test(NAME proof_quick
  COMMAND "${PYTHON_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/proof" quick --build "${CMAKE_BINARY_DIR}"
    --seal "${CMAKE_CURRENT_SOURCE_DIR}/proof/quick" --out "${CMAKE_BINARY_DIR}/proof/quick")
set_tests_properties(proof_quick PROPERTIES TIMEOUT 600 PROCESSORS 2)

# What judges the diagnosis on forms that no catalogue has: its arithmetic.
battery_sof_script_test(strangers_count_right 120 out_of_model/out_of_model_test.py)

# What the scripts share, and the shell scripts.
battery_sof_script_test(scripts_do_what_they_say 300 tools/tools_test.py)
battery_sof_script_test(can_logs_are_read_by_their_dbc_file 60 tools/can_log_test.py)
battery_sof_script_test(recordings_of_ros_2_are_read 60 tools/ros2_bag_test.py)
battery_sof_script_test(tables_say_what_was_measured 60 tools/measures_test.py)
battery_sof_script_test(causes_in_measured_recordings_are_planned_and_scored 60 tools/causes_test.py)
battery_sof_script_test(where_model_and_recording_deviate_is_scored 60 tools/locating_test.py)
battery_sof_script_test(pages_hold_the_figures_of_the_results 60 tools/results_test.py)
battery_sof_script_test(json_is_what_its_schemas_say 300 tools/schemas_test.py)
battery_sof_script_test(references_are_what_the_sources_say 60 tools/references_test.py)
battery_sof_script_test(pictures_show_what_commands_give 300 tools/pictures_test.py)
battery_sof_script_test(names_are_those_of_the_field 60 tools/names_test.py)
battery_sof_script_test(fleet_has_the_same_rows_however_it_is_run 300 tools/fleet_test.py)
battery_sof_script_test(fleet_survives_damaged_files 300 tools/fleet_attack_test.py)
battery_sof_script_test(setup_brings_path_and_completion 60 tools/path_test.py "${CATKIN_DEVEL_PREFIX}")
battery_sof_script_test(diagnosis_can_be_interrupted 120 tools/interruption_test.py "${CMAKE_BINARY_DIR}")
# What README.md and the pages tell a reader to type, and the site of the pages.
battery_sof_script_test(commands_of_the_pages_run 900 tools/pages_test.py "${CMAKE_BINARY_DIR}")
add_test(NAME layouts_name_what_is_published
  COMMAND "${CATKIN_DEVEL_PREFIX}/env.sh" "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/layouts_test.py")
set_tests_properties(layouts_name_what_is_published PROPERTIES TIMEOUT 60)
add_test(NAME pages_make_a_site COMMAND "${PYTHON_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/make_docs" "${CMAKE_BINARY_DIR}/docs")
set_tests_properties(pages_make_a_site PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
battery_sof_script_test(formulas_of_the_pages_are_typeset 120 tools/formulas_test.py)
foreach(tool clang-format clang-tidy catkin_lint shellcheck)
  battery_sof_script_test(${tool}_finds_nothing 300 tools/style_test.py ${tool})
endforeach()
# At fifty times real time an identification that another program slows down ends some seconds of the bag later.
set_tests_properties(clang-tidy_finds_nothing _ctest_${PROJECT_NAME}_rostest_rates PROPERTIES PROCESSORS 2)

# The example of who asks the node: built as another workspace would, then tried on a drive.
add_test(NAME energy_manager_builds_and_decides
  COMMAND "${CMAKE_COMMAND}" "-DDEVEL=${CATKIN_DEVEL_PREFIX}" "-DSOURCE=${PROJECT_SOURCE_DIR}/examples/energy_manager"
    "-DWORK=${CMAKE_BINARY_DIR}/energy_manager" "-DCXX=${CMAKE_CXX_COMPILER}" "-DPYTHON=${PYTHON_EXECUTABLE}"
    "-DROSTEST=${BATTERY_SOF_ROSTEST}" -DTEST=decisions.test -P "${CMAKE_CURRENT_SOURCE_DIR}/examples/try.cmake")
set_tests_properties(energy_manager_builds_and_decides PROPERTIES TIMEOUT 300 RESOURCE_LOCK roscore COST 200)
add_dependencies(tests experiment)

# The clients that docs/node.md shows, and the script of docs/your-recordings.md.
add_test(NAME clients_of_the_pages_build_and_ask
  COMMAND "${CMAKE_COMMAND}" "-DDEVEL=${CATKIN_DEVEL_PREFIX}" "-DSOURCE=${PROJECT_SOURCE_DIR}/examples/clients"
    "-DWORK=${CMAKE_BINARY_DIR}/clients" "-DCXX=${CMAKE_CXX_COMPILER}" "-DPYTHON=${PYTHON_EXECUTABLE}"
    "-DROSTEST=${BATTERY_SOF_ROSTEST}" -DTEST=clients.test -P "${CMAKE_CURRENT_SOURCE_DIR}/examples/try.cmake")
set_tests_properties(clients_of_the_pages_build_and_ask PROPERTIES TIMEOUT 300 RESOURCE_LOCK roscore)

# The example of a node of ROS 2. Debian 12 has no rclcpp: what the example calls of it are stand-ins.
add_executable(ros2_node_on_stand_ins EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/examples/ros2_node/battery_sof_ros2_node.cpp)
set_property(TARGET ros2_node_on_stand_ins APPEND PROPERTY INCLUDE_DIRECTORIES ${CMAKE_CURRENT_SOURCE_DIR}/examples/ros2_stand_ins)
target_link_libraries(ros2_node_on_stand_ins battery_sof)
add_dependencies(tests ros2_node_on_stand_ins)
battery_sof_script_test(ros2_node_compiles_and_answers_on_stand_ins_for_rclcpp 300 examples/ros2_node_test.py
  "${CMAKE_CXX_COMPILER}" $<TARGET_FILE:ros2_node_on_stand_ins>)

# What takes long and is rarely the first to find something: `make test` leaves it to `make test-slow`, continuous integration runs both.
set_tests_properties(proof_quick _ctest_${PROJECT_NAME}_rostest_rates live_page_in_a_browser live_page_under_attack
  fleet_survives_damaged_files energy_manager_builds_and_decides clang-tidy_finds_nothing PROPERTIES LABELS slow)
