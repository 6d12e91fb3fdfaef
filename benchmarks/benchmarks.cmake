# What is measured and is no accuracy: times in turns, goals, the frame budget. `atwood bench`, `compare` and `advise` call it.
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
add_library(atwood_benchmarks STATIC
  ${PROJECT_SOURCE_DIR}/benchmarks/bench_file.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/fluid_budget.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/frame_budget.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/goal_candidates.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/goal_figures.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/goal_run.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/goal_variants.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/goals_file.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/last_quarter.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/overheads.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/programs.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/rates.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/stopwatch.cpp
  ${PROJECT_SOURCE_DIR}/benchmarks/turn_times.cpp)
set_target_properties(atwood_benchmarks PROPERTIES UNITY_BUILD ${ATWOOD_UNITY_BUILD})
target_compile_options(atwood_benchmarks PRIVATE $<$<CONFIG:Release>:-O1>)  # the engines' programs do the timed work
atwood_precompile_headers(atwood_benchmarks ${ATWOOD_TEXT_HEADERS})
target_include_directories(atwood_benchmarks PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(atwood_benchmarks PUBLIC atwood_study atwood_gates atwood_metrics atwood_protocol atwood_scene
                                        PRIVATE fmt::fmt nlohmann_json::nlohmann_json)

# One executable an engine: two of them never share a process. Nothing here judges accuracy.
find_package(benchmark REQUIRED)

# atwood_bench(name factory-header factory target)
function(atwood_bench name header factory target)
  add_executable(atwood-bench-${name} ${PROJECT_SOURCE_DIR}/benchmarks/steps.cpp ${ARGN})
  target_compile_definitions(atwood-bench-${name} PRIVATE
    ATWOOD_ENGINE_HEADER="${header}" ATWOOD_ENGINE_FACTORY=${factory} ATWOOD_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(atwood-bench-${name} PRIVATE ${target} atwood_protocol atwood_scene benchmark::benchmark)
  target_include_directories(atwood-bench-${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/reference)
  set_target_properties(atwood-bench-${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
endfunction()

atwood_bench(engine simulation.hpp atwood_engine atwood_engine ${PROJECT_SOURCE_DIR}/benchmarks/kernels.cpp)
target_link_libraries(atwood-bench-engine PRIVATE atwood_metrics)
atwood_bench(cvode cvode/cvode.hpp cvode_engine atwood_cvode)
atwood_bench(bullet64 bullet/bullet.hpp bullet_engine atwood_bullet64)
atwood_bench(bullet32 bullet/bullet.hpp bullet_engine atwood_bullet32)
atwood_bench(ode ode/ode.hpp ode_engine atwood_ode)

add_executable(atwood-bench-scaling ${PROJECT_SOURCE_DIR}/benchmarks/scaling.cpp)
target_link_libraries(atwood-bench-scaling PRIVATE atwood_engine atwood_metrics atwood_scene benchmark::benchmark)
target_include_directories(atwood-bench-scaling PRIVATE ${PROJECT_SOURCE_DIR})
set_target_properties(atwood-bench-scaling PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_executable(atwood-bench-fluids ${PROJECT_SOURCE_DIR}/benchmarks/fluids.cpp)
target_link_libraries(atwood-bench-fluids PRIVATE atwood_engine atwood_metrics atwood_scene benchmark::benchmark)
target_include_directories(atwood-bench-fluids PRIVATE ${PROJECT_SOURCE_DIR})
set_target_properties(atwood-bench-fluids PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
# Figures of its own, not Google Benchmark's: `atwood bench broad-phases`.
add_executable(atwood-broad-phases ${PROJECT_SOURCE_DIR}/benchmarks/broad_phases.cpp)
target_link_libraries(atwood-broad-phases PRIVATE atwood_engine atwood_metrics atwood_scene nlohmann_json::nlohmann_json)
target_include_directories(atwood-broad-phases PRIVATE ${PROJECT_SOURCE_DIR})
set_target_properties(atwood-broad-phases PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_custom_target(benches DEPENDS atwood-broad-phases atwood-bench-engine atwood-bench-fluids atwood-bench-scaling atwood-bench-cvode atwood-bench-bullet64 atwood-bench-bullet32
                  atwood-bench-ode)

# Each executable runs once, briefly, on a few small cases: that it builds and times something is tested, no time is.
find_package(Python3 COMPONENTS Interpreter REQUIRED)
function(atwood_smoke name)
  add_test(NAME smoke_${name} COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/benchmarks/smoke_test.py $<TARGET_FILE:atwood-${name}> ${ARGN})
  set_tests_properties(smoke_${name} PROPERTIES TIMEOUT 1000)
endfunction()
foreach(engine engine cvode bullet64 bullet32 ode)
  atwood_smoke(bench-${engine} "--benchmark_filter=/ballistic/|kepler_e06|free-flight/1/")
endforeach()
atwood_smoke(bench-scaling --benchmark_filter=/1024/)
atwood_smoke(bench-fluids --benchmark_filter=2d/10000/)
atwood_smoke(broad-phases 400)

# Our general methods on the reference's rate, beside odeint, ARKODE and CVODE: the one program that links both.
add_library(atwood_same_rate STATIC ${PROJECT_SOURCE_DIR}/benchmarks/same_rate/same_rate.cpp)
target_link_libraries(atwood_same_rate PUBLIC atwood_engine atwood_stepping)
target_include_directories(atwood_same_rate PUBLIC ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/reference)
target_compile_options(atwood_same_rate PRIVATE -Wno-psabi)
add_executable(atwood-same-rate ${PROJECT_SOURCE_DIR}/benchmarks/same_rate/main.cpp)
target_link_libraries(atwood-same-rate PRIVATE atwood_same_rate)
set_target_properties(atwood-same-rate PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_dependencies(programs atwood-same-rate)
