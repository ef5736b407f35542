# literal(OUT TEXT): TEXT as C++ raw string literals, which end at )backbend"; no file of ours
# contains that. A C++ compiler need not take literals over 65536 bytes; neighbours are joined.
function(literal out text)
  set(code "")
  string(LENGTH "${text}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} 8000 part)
    string(LENGTH "${part}" taken)
    string(APPEND code "R\"backbend(${part})backbend\"\n")
    math(EXPR at "${at} + ${taken}")
  endwhile()
  set(${out} "${code}" PARENT_SCOPE)
endfunction()
