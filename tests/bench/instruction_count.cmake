# Counts the instructions of `slim` and of `drt-l` on the same simulated windows with Callgrind and
# compares their ratio, which compilers and machines change little, with the one measured when this
# was last changed.

# Ratio of the means, and by how much it may grow.
set(ratio_measured_percent 938)
set(allowed_percent 104)

if(NOT VALGRIND)
  message(STATUS "SKIPPED: valgrind is not installed")
  return()
endif()
if(NOT CONFIG STREQUAL "Release" AND NOT CONFIG STREQUAL "RelWithDebInfo")
  message(STATUS "SKIPPED: ${CONFIG} is not an optimised build")
  return()
endif()

# instructions(<method> <result>): of 24 solves, in thousands.
function(instructions method result)
  execute_process(
    COMMAND ${VALGRIND} --tool=callgrind --callgrind-out-file=${WORK_DIR}/callgrind.${method}
            --collect-atstart=no "--toggle-collect=*countedSolves*" ${BENCH} count --methods ${method}
            --duration 30 --windows 24
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE log)
  if(NOT code EQUAL 0 OR NOT output MATCHES "24 windows 24 solved")
    message(FATAL_ERROR "${method} did not answer all windows:\n${output}\n${log}")
  endif()
  if(NOT log MATCHES "Collected : ([0-9]+)")
    message(FATAL_ERROR "Callgrind reported no count:\n${log}")
  endif()
  math(EXPR thousands "${CMAKE_MATCH_1} / 1000")
  if(thousands EQUAL 0)
    message(FATAL_ERROR "nothing was counted:\n${log}")
  endif()
  set(${result} ${thousands} PARENT_SCOPE)
endfunction()

instructions(drt-l reference)
instructions(slim counted)
math(EXPR ratio_percent "100 * ${counted} / ${reference}")
math(EXPR bound_percent "${ratio_measured_percent} * ${allowed_percent} / 100")
message(STATUS "slim ${counted} thousand, drt-l ${reference} thousand instructions in 24 solves: "
               "ratio ${ratio_percent} %, at most ${bound_percent} %")
if(ratio_percent GREATER bound_percent)
  message(FATAL_ERROR "slim has become slower: ratio ${ratio_percent} %, at most ${bound_percent} %. "
                      "Where that is meant, change the ratio in ${CMAKE_CURRENT_LIST_FILE}")
endif()
