# The node and the library behind it, and what is installed of a catkin package alone.
file(GLOB ros_sources CONFIGURE_DEPENDS src/ros/*.cpp)
list(FILTER ros_sources EXCLUDE REGEX "_main\\.cpp$")
add_library(${PROJECT_NAME}_ros STATIC ${ros_sources})
target_include_directories(${PROJECT_NAME}_ros SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(${PROJECT_NAME}_ros PUBLIC ${PROJECT_NAME}_bag ${catkin_LIBRARIES} Threads::Threads)
battery_sof_build_quickly(${PROJECT_NAME}_ros TOGETHER)
# Boost.Asio brings netdb.h, whose macro NO_DATA is a name of the actions' codes.
set_source_files_properties(src/ros/background_work.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
add_dependencies(${PROJECT_NAME}_ros ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})

add_executable(${PROJECT_NAME}_node src/ros/battery_sof_node_main.cpp)
target_include_directories(${PROJECT_NAME}_node SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(${PROJECT_NAME}_node ${PROJECT_NAME}_ros)
add_dependencies(${PROJECT_NAME}_node ${${PROJECT_NAME}_EXPORTED_TARGETS})

export(TARGETS ${PROJECT_NAME} NAMESPACE ${PROJECT_NAME}::
  FILE ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake/${PROJECT_NAME}Targets.cmake)
install(TARGETS ${PROJECT_NAME}_node RUNTIME DESTINATION ${PROGRAM_DESTINATION})
install(DIRECTORY completion config launch live DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
# These are whole in one file each: the package of the other scripts (tools/) is for this checkout, and catkin_python_setup()
# would install it to the prefix known when configuring, whatever --prefix says.
catkin_install_python(PROGRAMS scripts/ask_and_compare scripts/can_log scripts/live_page scripts/plot_prediction
  DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})

# On the PATH after setup.sh, which has bin/ but not lib/${PROJECT_NAME}; and the completion of sof.
file(MAKE_DIRECTORY "${CATKIN_DEVEL_PREFIX}/bin")
foreach(name sof ask_and_compare)
  file(CREATE_LINK "../${CATKIN_PACKAGE_BIN_DESTINATION}/${name}" "${CATKIN_DEVEL_PREFIX}/bin/${name}" SYMBOLIC)
  #catkin_lint: ignore_once external_file
  install(FILES "${CATKIN_DEVEL_PREFIX}/bin/${name}" DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION})
endforeach()
catkin_add_env_hooks(50.${PROJECT_NAME} SHELLS bash DIRECTORY "${PROJECT_SOURCE_DIR}/env-hooks")

# catkin writes its setup files to the prefix known when configuring; `cmake --install build --prefix P` gets its own here.
install(CODE "
  if(NOT CMAKE_INSTALL_PREFIX STREQUAL \"${CMAKE_INSTALL_PREFIX}\")
    file(GLOB setup_files \"${CMAKE_BINARY_DIR}/catkin_generated/installspace/*setup*\" \"${CMAKE_BINARY_DIR}/catkin_generated/installspace/env.sh\")
    foreach(setup_file IN LISTS setup_files)
      file(READ \"\${setup_file}\" text)
      string(REPLACE \"${CMAKE_INSTALL_PREFIX}\" \"\${CMAKE_INSTALL_PREFIX}\" text \"\${text}\")
      file(COPY \"\${setup_file}\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}\")  # brings the permissions
      get_filename_component(setup_name \"\${setup_file}\" NAME)
      file(WRITE \"\${CMAKE_INSTALL_PREFIX}/\${setup_name}\" \"\${text}\")
    endforeach()
    file(WRITE \"\${CMAKE_INSTALL_PREFIX}/.catkin\" \"\")
  endif()
")
