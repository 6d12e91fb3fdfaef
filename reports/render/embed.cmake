# Writes OUTPUT, a C++ file that holds SCRIPT and STYLE as raw strings.
function(embed name file result)
  file(READ ${file} content)
  string(FIND "${content}" ")atwood_asset\"" clash)
  if(NOT clash EQUAL -1)
    message(FATAL_ERROR "${file} contains the delimiter of the raw string")
  endif()
  set(${result} "const std::string_view ${name} = R\"atwood_asset(${content})atwood_asset\";\n" PARENT_SCOPE)
endfunction()

embed(report_script ${SCRIPT} script)
embed(report_style ${STYLE} style)
file(WRITE ${OUTPUT} "#include \"assets.hpp\"\n\nnamespace atwood {\n\n${script}${style}\n}  // namespace atwood\n")
