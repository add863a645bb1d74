# `slim_init_bench soak` for a minute and a half of simulated time: no drift, and drift is seen where
# its bound is below what there is.

# soak(<exit code> <text of the output> <option>...)
function(soak expected text)
  execute_process(COMMAND ${BENCH} soak --builtin figure-eight --duration 30 ${ARGN}
                  RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(NOT code EQUAL expected OR NOT "${output}${errors}" MATCHES "${text}")
    message(FATAL_ERROR "soak ${ARGN}: exit code ${code}, expected ${expected} and \"${text}\":\n"
                        "${output}${errors}")
  endif()
  message(STATUS "soak ${ARGN}\n${output}${errors}")
endfunction()

# Times of a few questions beside other tests say little: what is looked at here are the answers,
# which are the same ones, and memory, with room for that of a machine which runs other tests.
soak(0 "estimates, difference: 0.000" --hours 0.027 --every 12 --ask 1 --time-growth 100)
soak(1 "ratio: [0-9.]+ \\(limit 0.010\\): TOO MUCH" --hours 0.0134 --every 12 --ask 2 --time-growth 0.01)
soak(2 "--hours is 0" --hours 0)
soak(2 "--every is 60 s, must be from 8 to" --every 60)
