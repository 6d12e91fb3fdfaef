# Run at every build: rewrites build_info.cpp only when something in it changed.
execute_process(COMMAND git -C ${SOURCE_DIR} rev-parse --short=12 HEAD OUTPUT_VARIABLE COMMIT ERROR_QUIET
                OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND git -C ${SOURCE_DIR} status --porcelain --untracked-files=no OUTPUT_VARIABLE CHANGES ERROR_QUIET)
if(NOT COMMIT)
  set(COMMIT "unknown")
elseif(CHANGES)
  set(COMMIT "${COMMIT}+changes")
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
