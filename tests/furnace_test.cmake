# Every test program that needs neither GL nor a socket: what is built with sanitizers.
add_custom_target(unit_tests)
# Every benchmark, in build/bench/.
add_custom_target(benchmarks)

# furnace_test(NAME LABEL unit|gl|golden|http SOURCES a.cpp ... LINK furnace_x ... [TIMEOUT seconds])
# One GoogleTest program, one ctest entry; the working directory is the source root. Golden and http tests run alone:
# they fill every core themselves or wait for a socket.
function(furnace_test name)
  cmake_parse_arguments(T "" "LABEL;TIMEOUT" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${T_SOURCES})
  target_link_libraries(${name} PRIVATE ${T_LINK} GTest::gtest_main GTest::gmock)
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${FURNACE_SOURCE_DIR})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 300)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS ${T_LABEL} TIMEOUT ${T_TIMEOUT})
  if(T_LABEL STREQUAL "unit")
    add_dependencies(unit_tests ${name})
  elseif(T_LABEL STREQUAL "golden" OR T_LABEL STREQUAL "http")
    set_tests_properties(${name} PROPERTIES RUN_SERIAL ON)
  endif()
endfunction()

# furnace_bench(NAME_bench SOURCES a.cpp ... LINK furnace_x ...): one Google Benchmark program with its own or our main.
function(furnace_bench name)
  cmake_parse_arguments(B "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${B_SOURCES})
  target_link_libraries(${name} PRIVATE ${B_LINK} benchmark::benchmark_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bench)
  add_dependencies(benchmarks ${name})
endfunction()
