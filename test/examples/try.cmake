# cmake -DDEVEL=.. -DSOURCE=.. -DWORK=.. -DCXX=.. -DPYTHON=.. -DROSTEST=.. -DTEST=.. -P try.cmake: builds an example against the devel space, as a
# workspace would that lies beside it, and runs its rostest TEST.
function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY "${WORK}" RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    string(REPLACE ";" " " call "${ARGN}")
    message(FATAL_ERROR "${call}\nended with ${code}")
  endif()
endfunction()

file(MAKE_DIRECTORY "${WORK}")
run("${DEVEL}/env.sh" "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${WORK}" "-DCMAKE_CXX_COMPILER=${CXX}" "-DPYTHON_EXECUTABLE=${PYTHON}" "-DPython3_EXECUTABLE=${PYTHON}"
  "-DCMAKE_CXX_FLAGS=-Werror")
run("${CMAKE_COMMAND}" --build "${WORK}")
run("${WORK}/devel/env.sh" "${PYTHON}" "${ROSTEST}" "${SOURCE}/test/${TEST}")
