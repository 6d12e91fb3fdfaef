# A software bill of materials (SPDX 2.3, JSON) in each component: what is linked, compiled in, embedded or brought along.
find_package(Python3 REQUIRED COMPONENTS Interpreter)

# atwood_sbom(COMPONENT NAME WHAT...): share/atwood/sbom/NAME.spdx.json; WHAT are further arguments of sbom.py.
function(atwood_sbom component name)
  set(file ${generated}/${name}.spdx.json)
  string(JOIN "\" \"" words ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/sbom.py --name ${name}
         --version ${PROJECT_VERSION} --output ${file} ${ARGN})
  install(CODE "execute_process(COMMAND \"${words}\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
  install(FILES ${file} DESTINATION ${data}/sbom COMPONENT ${component})
endfunction()

set(bin ${CMAKE_BINARY_DIR}/bin)
set(compiled_in
  --compiled-in libboost-dev libcli11-dev libeigen3-dev libsqlitecpp-dev libtomlplusplus-dev nlohmann-json3-dev
  --built-with "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}" "CMake ${CMAKE_VERSION}")
list(TRANSFORM program_workers PREPEND ${bin}/ OUTPUT_VARIABLE programs)
atwood_sbom(program atwood --programs ${bin}/atwood ${programs} ${compiled_in}
            --bundled ${PROJECT_SOURCE_DIR}/reports/web/package-lock.json three uplot)
atwood_sbom(dev atwood-dev --compiled-in libeigen3-dev libtomlplusplus-dev nlohmann-json3-dev
            --built-with "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
foreach(engine dart mujoco simbody)
  if(${engine}_workers)
    list(TRANSFORM ${engine}_workers PREPEND ${bin}/ OUTPUT_VARIABLE programs)
    atwood_sbom(${engine} atwood-${engine} --programs ${programs} ${compiled_in})
  endif()
endforeach()
if(node_engines)
  atwood_sbom(node atwood-node-engines --bundled ${PROJECT_SOURCE_DIR}/reference/node/package-lock.json all)
endif()
