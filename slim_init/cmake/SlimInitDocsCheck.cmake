# Runs Doxygen and fails when it complains:
#   cmake -DDOXYGEN=<program> -DFOLDER=<with Doxyfile; output> -P SlimInitDocsCheck.cmake
# A struct, class or enumeration without a comment is a complaint. A function or a field without one is
# not: an accessor whose name says it all, or an overload explained by the first of its group.
file(REMOVE ${FOLDER}/warnings.txt)
execute_process(COMMAND ${DOXYGEN} ${FOLDER}/Doxyfile RESULT_VARIABLE _result)
if(NOT _result EQUAL 0 OR NOT EXISTS ${FOLDER}/warnings.txt)
  message(FATAL_ERROR "Doxygen failed (${_result}) or left no ${FOLDER}/warnings.txt")
endif()
file(STRINGS ${FOLDER}/warnings.txt _lines)
set(_complaints "")
set(_count 0)
foreach(_line IN LISTS _lines)
  if(NOT _line MATCHES "Member .* [(](function|variable|typedef|enumvalue)[)] of .* is not documented")
    string(APPEND _complaints "\n  ${_line}")
    math(EXPR _count "${_count} + 1")
  endif()
endforeach()
if(_count GREATER 0)
  message(FATAL_ERROR "Doxygen has ${_count} complaints:${_complaints}")
endif()
