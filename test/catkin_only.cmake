# Tests of the catkin package alone: what needs ROS, and what would say the same a second time in a build without it.
battery_sof_gtest(bag_test FOLDERS unit/bag LINK battery_sof_bag ${catkin_LIBRARIES})
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

# The benchmark of the diagnosis: its arithmetic, and a tenth of it as a whole (some minutes).
add_test(NAME proof_counts_right COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/proof/proof_test.py")
set_tests_properties(proof_counts_right PROPERTIES TIMEOUT 120 ENVIRONMENT "BATTERY_SOF_BUILD=${CMAKE_BINARY_DIR}")
add_test(NAME proof_quick
  COMMAND "${PYTHON_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/proof" quick --build "${CMAKE_BINARY_DIR}"
    --seal "${CMAKE_CURRENT_SOURCE_DIR}/proof/quick" --out "${CMAKE_BINARY_DIR}/proof/quick")
set_tests_properties(proof_quick PROPERTIES TIMEOUT 600 PROCESSORS 2)

# What judges the diagnosis on forms that no catalogue has: its arithmetic.
add_test(NAME strangers_count_right COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/out_of_model/out_of_model_test.py")
set_tests_properties(strangers_count_right PROPERTIES TIMEOUT 120)

# What the scripts share, and the shell scripts.
add_test(NAME scripts_do_what_they_say COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/tools_test.py")
set_tests_properties(scripts_do_what_they_say PROPERTIES TIMEOUT 300 ENVIRONMENT "BATTERY_SOF_BUILD=${CMAKE_BINARY_DIR}")
add_test(NAME tables_say_what_was_measured COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/measures_test.py")
set_tests_properties(tables_say_what_was_measured PROPERTIES TIMEOUT 60)
add_test(NAME pages_hold_the_figures_of_the_results COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/results_test.py")
set_tests_properties(pages_hold_the_figures_of_the_results PROPERTIES TIMEOUT 60)
add_test(NAME words_are_those_of_the_field COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/words_test.py")
set_tests_properties(words_are_those_of_the_field PROPERTIES TIMEOUT 120)
add_test(NAME fleet_has_the_same_rows_however_it_is_run COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/fleet_test.py")
set_tests_properties(fleet_has_the_same_rows_however_it_is_run PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300 ENVIRONMENT "BATTERY_SOF_BUILD=${CMAKE_BINARY_DIR}")
add_test(NAME fleet_survives_damaged_files COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/fleet_attack_test.py")
set_tests_properties(fleet_survives_damaged_files PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300)
add_test(NAME setup_brings_path_and_completion
  COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/path_test.py" "${CATKIN_DEVEL_PREFIX}")
set_tests_properties(setup_brings_path_and_completion PROPERTIES TIMEOUT 60)
add_test(NAME diagnosis_can_be_interrupted
  COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/interruption_test.py" "${CMAKE_BINARY_DIR}")
set_tests_properties(diagnosis_can_be_interrupted PROPERTIES TIMEOUT 120)
# What README.md and the pages tell a reader to type, and the site of the pages.
add_test(NAME commands_of_the_pages_run
  COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/pages_test.py" "${CMAKE_BINARY_DIR}")
set_tests_properties(commands_of_the_pages_run PROPERTIES TIMEOUT 600)
add_test(NAME layouts_name_what_is_published
  COMMAND "${CATKIN_DEVEL_PREFIX}/env.sh" "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/layouts_test.py")
set_tests_properties(layouts_name_what_is_published PROPERTIES TIMEOUT 60)
add_test(NAME pages_make_a_site COMMAND "${PYTHON_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/scripts/make_docs" "${CMAKE_BINARY_DIR}/docs")
set_tests_properties(pages_make_a_site PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
foreach(tool clang-format clang-tidy catkin_lint shellcheck)
  add_test(NAME ${tool}_finds_nothing COMMAND "${PYTHON_EXECUTABLE}" "${CMAKE_CURRENT_SOURCE_DIR}/tools/style_test.py" ${tool})
  set_tests_properties(${tool}_finds_nothing PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300
    ENVIRONMENT "BATTERY_SOF_BUILD=${CMAKE_BINARY_DIR}")
endforeach()
# At fifty times real time an identification that another program slows down ends some seconds of the bag later.
set_tests_properties(clang-tidy_finds_nothing _ctest_${PROJECT_NAME}_rostest_rates PROPERTIES PROCESSORS 2)

# The example of who asks the node: built as another workspace would, then tried on a drive.
add_test(NAME energy_manager_builds_and_decides
  COMMAND "${CMAKE_COMMAND}" "-DDEVEL=${CATKIN_DEVEL_PREFIX}" "-DSOURCE=${PROJECT_SOURCE_DIR}/examples/energy_manager"
    "-DWORK=${CMAKE_BINARY_DIR}/energy_manager" "-DCXX=${CMAKE_CXX_COMPILER}" "-DPYTHON=${PYTHON_EXECUTABLE}"
    "-DROSTEST=${BATTERY_SOF_ROSTEST}" -DTEST=decisions.test -P "${CMAKE_CURRENT_SOURCE_DIR}/examples/try.cmake")
set_tests_properties(energy_manager_builds_and_decides PROPERTIES TIMEOUT 300 RESOURCE_LOCK roscore COST 200)
add_dependencies(tests stop_rules_experiment)

# The clients that docs/node.md shows, and the script of docs/your-recordings.md.
add_test(NAME clients_of_the_pages_build_and_ask
  COMMAND "${CMAKE_COMMAND}" "-DDEVEL=${CATKIN_DEVEL_PREFIX}" "-DSOURCE=${PROJECT_SOURCE_DIR}/examples/clients"
    "-DWORK=${CMAKE_BINARY_DIR}/clients" "-DCXX=${CMAKE_CXX_COMPILER}" "-DPYTHON=${PYTHON_EXECUTABLE}"
    "-DROSTEST=${BATTERY_SOF_ROSTEST}" -DTEST=clients.test -P "${CMAKE_CURRENT_SOURCE_DIR}/examples/try.cmake")
set_tests_properties(clients_of_the_pages_build_and_ask PROPERTIES TIMEOUT 300 RESOURCE_LOCK roscore)

# What takes long and is rarely the first to find something: `make test` leaves it to `make test-slow`, continuous integration runs both.
set_tests_properties(proof_quick _ctest_${PROJECT_NAME}_rostest_rates live_page_in_a_browser live_page_under_attack
  fleet_survives_damaged_files energy_manager_builds_and_decides clang-tidy_finds_nothing PROPERTIES LABELS slow)
