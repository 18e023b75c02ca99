# The catkin package: messages, what other packages find, where things are installed.
if(CMAKE_INSTALL_PREFIX_INITIALIZED_TO_DEFAULT)
  set(CMAKE_INSTALL_PREFIX ${CMAKE_BINARY_DIR}/install CACHE PATH "install space" FORCE)
endif()
find_package(catkin REQUIRED COMPONENTS
  actionlib actionlib_msgs diagnostic_msgs diagnostic_updater message_generation roscpp sensor_msgs std_msgs std_srvs)

# The Python module and the messages are one Python package. What catkin_python_setup() would say: its __init__.py is in the
# sources (python/), so genpy installs none.
if(BATTERY_SOF_PYTHON)
  set(${PROJECT_NAME}_CATKIN_PYTHON_SETUP_HAS_PACKAGE_INIT TRUE)
endif()
add_message_files(DIRECTORY msg)
add_service_files(DIRECTORY srv)
add_action_files(DIRECTORY action)
generate_messages(DEPENDENCIES actionlib_msgs std_msgs)

# The extras bring battery_sof::core, the target that the plain package has too.
catkin_package(
  INCLUDE_DIRS include
  LIBRARIES ${PROJECT_NAME}
  CATKIN_DEPENDS actionlib actionlib_msgs diagnostic_msgs diagnostic_updater message_runtime roscpp sensor_msgs std_msgs std_srvs
  CFG_EXTRAS ${PROJECT_NAME}-extras.cmake)

# Interfaces of 0.x may differ from one minor version to the next: catkin's own file takes any older version for compatible.
include(CMakePackageConfigHelpers)
foreach(folder "${CATKIN_DEVEL_PREFIX}/share/${PROJECT_NAME}/cmake" "${CMAKE_BINARY_DIR}/catkin_generated/installspace")
  write_basic_package_version_file("${folder}/${PROJECT_NAME}Config-version.cmake" VERSION ${${PROJECT_NAME}_VERSION}
    COMPATIBILITY SameMinorVersion)
endforeach()

set(LIBRARY_DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
set(PROGRAM_DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
set(HEADER_DESTINATION ${CATKIN_PACKAGE_INCLUDE_DESTINATION})
set(SHARE_DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
set(CONFIG_DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")  # where Debian's catkin puts its part of a package with libraries
  set(CONFIG_DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}/cmake/${PROJECT_NAME})
endif()
set(PYTHON_DESTINATION ${CATKIN_PACKAGE_PYTHON_DESTINATION})
set(PYTHON_BUILD_FOLDER ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_PYTHON_DESTINATION})
