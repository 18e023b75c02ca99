# The package without ROS: where things are installed.
include(CTest)
include(GNUInstallDirs)

set(LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR})
set(PROGRAM_DESTINATION ${CMAKE_INSTALL_BINDIR})
set(HEADER_DESTINATION include/${PROJECT_NAME})
set(SHARE_DESTINATION ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})
set(CONFIG_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
set(PYTHON_DESTINATION
  lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/dist-packages/${PROJECT_NAME})
set(PYTHON_BUILD_FOLDER ${CMAKE_BINARY_DIR}/python/${PROJECT_NAME})

#catkin_lint: ignore_once wrong_install_destination
install(PROGRAMS scripts/can_log DESTINATION ${PROGRAM_DESTINATION})
#catkin_lint: ignore_once wrong_install_destination
install(DIRECTORY config/scenarios DESTINATION ${SHARE_DESTINATION})
