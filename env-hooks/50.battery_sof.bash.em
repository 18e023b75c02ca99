# Completion of `sof`, in bash only.
@[if DEVELSPACE]@
. "@(CMAKE_CURRENT_SOURCE_DIR)/completion/sof.bash"
@[else]@
. "$CATKIN_ENV_HOOK_WORKSPACE/@(CATKIN_PACKAGE_SHARE_DESTINATION)/completion/sof.bash"
@[end if]@
