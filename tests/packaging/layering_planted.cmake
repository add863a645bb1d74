# Checks the checker: a tree in order passes, and each planted violation is found and named.
#   cmake -DWORK_DIR=<scratch folder> -P layering_planted.cmake
cmake_minimum_required(VERSION 3.16)

# run(<expected: PASS or FAIL> <text that a failure must name>)
function(run expected text)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${WORK_DIR} -DLINKS_FILE=${WORK_DIR}/links.txt -P
            ${CMAKE_CURRENT_LIST_DIR}/layering.cmake
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(expected STREQUAL "PASS" AND NOT result EQUAL 0)
    message(FATAL_ERROR "a tree in order was refused:\n${output}")
  elseif(expected STREQUAL "FAIL" AND result EQUAL 0)
    message(FATAL_ERROR "not found: ${text}")
  elseif(expected STREQUAL "FAIL")
    string(REGEX REPLACE "[ \n]+" " " flat "${output}")
    string(FIND "${flat}" "${text}" position)
    if(position EQUAL -1)
      message(FATAL_ERROR "the message does not name \"${text}\":\n${output}")
    endif()
  endif()
endfunction()

function(reset)
  file(REMOVE_RECURSE ${WORK_DIR})
  file(WRITE ${WORK_DIR}/slim_init/include/slim_init/types.h "#include <Eigen/Core>\n")
  file(WRITE ${WORK_DIR}/slim_init/src/a.cc "#include <vector>\n#include \"slim_init/types.h\"\n")
  file(WRITE ${WORK_DIR}/slim_init/simulation/include/slim_init/simulation/world.h "\n")
  file(WRITE ${WORK_DIR}/slim_init/evaluation/src/b.cc "#include <nlohmann/json.hpp>\n")
  file(WRITE ${WORK_DIR}/links.txt
       "slim_init_core:Eigen3::Eigen\nslim_init_evaluation:slim_init_core;$<BUILD_INTERFACE:nlohmann_json::nlohmann_json>\n"
  )
endfunction()

reset()
run(PASS "")

# planted_include(<file> <header as written, with its brackets> <name in the message>)
function(planted_include file header name)
  reset()
  file(WRITE ${WORK_DIR}/${file} "#include ${header}\n")
  run(FAIL "${file}: the layer")
  run(FAIL "must not include ${name}")
endfunction()
planted_include(slim_init/src/imu/p.cc "<opencv2/core.hpp>" opencv2/core.hpp)
planted_include(slim_init/include/slim_init/p.h "<ros/ros.h>" ros/ros.h)
planted_include(slim_init/src/p.cc "\"slim_init/simulation/world.h\"" slim_init/simulation/world.h)
planted_include(slim_init/evaluation/src/p.cc "\"slim_init/simulation/world.h\""
                slim_init/simulation/world.h)
planted_include(slim_init/reference/p.h "\"slim_init/types.h\"" slim_init/types.h)
planted_include(feature_tracker_lines/src/p.cc "<sensor_msgs/Image.h>" sensor_msgs/Image.h)
planted_include(vins_estimator_patch/src/p.cc "<opencv2/core.hpp>" opencv2/core.hpp)
planted_include(slim_init/baselines/src/p.cc "<ros/ros.h>" ros/ros.h)
planted_include(feature_tracker_lines/ros/src/p.cc "<rosbag/bag.h>" rosbag/bag.h)
planted_include(vins_estimator_patch/src/p.cc "\"estimator.h\"" estimator.h)

# planted_link(<line of the links file> <library in the message>)
function(planted_link line library)
  reset()
  file(APPEND ${WORK_DIR}/links.txt "${line}\n")
  run(FAIL "must not link ${library}")
endfunction()
planted_link("slim_init_core:Eigen3::Eigen;opencv_core" opencv_core)
planted_link("slim_init_vins_adapter:slim_init_core;slim_init_evaluation" slim_init_evaluation)
planted_link("slim_init_baselines:slim_init_core;slim_init_evaluation" slim_init_evaluation)
planted_link("slim_init_simulation:slim_init_core;$<LINK_ONLY:slim_init_evaluation>"
             slim_init_evaluation)
message("layering: every planted violation was found")
