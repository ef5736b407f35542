# cmake -DPROGRAM=... -DFORM=man -DOUT=... -P Describe.cmake: what the program says of its options.
execute_process(COMMAND ${PROGRAM} completions ${FORM} OUTPUT_FILE ${OUT}.new RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} completions ${FORM} ended with ${result}")
endif()
file(RENAME ${OUT}.new ${OUT})
