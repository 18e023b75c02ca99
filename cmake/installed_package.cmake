# How others find the installed core: find_package(battery_sof), or pkg-config. The names are in small letters: battery_sofConfig.cmake
# is catkin's, and CMake takes that one where both are.
include(CMakePackageConfigHelpers)
configure_file(cmake/${PROJECT_NAME}-config.cmake.in ${CMAKE_BINARY_DIR}/${PROJECT_NAME}-config.cmake @ONLY)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/${PROJECT_NAME}-config-version.cmake COMPATIBILITY SameMinorVersion)
#catkin_lint: ignore_once missing_file wrong_install_destination
install(FILES ${CMAKE_BINARY_DIR}/${PROJECT_NAME}-config.cmake ${CMAKE_BINARY_DIR}/${PROJECT_NAME}-config-version.cmake
  DESTINATION ${CONFIG_DESTINATION})

file(RELATIVE_PATH prefix_of_pc_file "/${LIBRARY_DESTINATION}/pkgconfig" "/")  # `cmake --install --prefix` says where
configure_file(cmake/${PROJECT_NAME}.pc.in ${CMAKE_BINARY_DIR}/${PROJECT_NAME}.pc @ONLY)
# catkin installs a file of that name, which asks for all of ROS; cmake leaves it where both are of one second.
#catkin_lint: ignore_once env_var
install(CODE "file(REMOVE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${LIBRARY_DESTINATION}/pkgconfig/${PROJECT_NAME}.pc\")")
#catkin_lint: ignore_once missing_file wrong_install_destination
install(FILES ${CMAKE_BINARY_DIR}/${PROJECT_NAME}.pc DESTINATION ${LIBRARY_DESTINATION}/pkgconfig)
