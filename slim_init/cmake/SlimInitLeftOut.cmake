# What this configuration does without because something was not found. launch/setup.sh ends demo and
# tests with the list, so that nothing is missing unnoticed.

# slim_init_left_out(<name> <reason>): notes that <name> (a part, or tests by name) is left out.
function(slim_init_left_out name reason)
  message(STATUS "Left out: ${name}: ${reason}")
  set_property(GLOBAL APPEND_STRING PROPERTY SLIM_INIT_LEFT_OUT "${name}: ${reason}\n")
endfunction()

# Writes the list to <file>, one line each; empty where nothing was left out.
function(slim_init_write_left_out file)
  get_property(list GLOBAL PROPERTY SLIM_INIT_LEFT_OUT)
  file(WRITE ${file} "${list}")
endfunction()
