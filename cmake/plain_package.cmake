# The package without ROS: a CMake package that others find, and where things are installed.
include(CTest)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR})
set(PROGRAM_DESTINATION ${CMAKE_INSTALL_BINDIR})
set(HEADER_DESTINATION include/${PROJECT_NAME})
set(SHARE_DESTINATION ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})
set(CONFIG_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
set(PYTHON_DESTINATION
  lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/dist-packages/${PROJECT_NAME})
set(PYTHON_BUILD_FOLDER ${CMAKE_BINARY_DIR}/python/${PROJECT_NAME})

set(package_files ${CMAKE_BINARY_DIR}/${PROJECT_NAME}Config.cmake ${CMAKE_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake)
configure_package_config_file(cmake/${PROJECT_NAME}Config.cmake.in ${CMAKE_BINARY_DIR}/${PROJECT_NAME}Config.cmake
  INSTALL_DESTINATION ${CONFIG_DESTINATION})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
#catkin_lint: ignore_once missing_file wrong_install_destination
install(FILES ${package_files} DESTINATION ${CONFIG_DESTINATION})
#catkin_lint: ignore_once wrong_install_destination
install(DIRECTORY config/scenarios DESTINATION ${SHARE_DESTINATION})
