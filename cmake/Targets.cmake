# regulus_library(NAME SOURCES... LINK...) and regulus_test(NAME SOURCES... LINK...):
# the warnings, include roots and conventions that all targets share.
add_library(regulus_options INTERFACE)
target_include_directories(regulus_options INTERFACE ${CMAKE_SOURCE_DIR}/host ${CMAKE_SOURCE_DIR}/host/include ${CMAKE_SOURCE_DIR}/shaders)
target_compile_options(regulus_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion -ffp-contract=off)
if(CMAKE_UNITY_BUILD)  # where sources look like headers
  target_compile_options(regulus_options INTERFACE -Wno-subobject-linkage)
endif()
if(REGULUS_WERROR)
  target_compile_options(regulus_options INTERFACE -Werror)
endif()

# HEADERS: heavy headers of its own that are compiled once for all its sources, instead of the common ones.
function(regulus_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;HEADERS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)  # goes into libregulus, too
  target_link_libraries(${name} PUBLIC regulus_options ${ARG_LINK})
  if(ARG_HEADERS)
    target_precompile_headers(${name} PRIVATE ${REGULUS_COMMON_HEADERS} ${ARG_HEADERS})
  else()
    regulus_precompile(${name} host)
  endif()
endfunction()

# Tests and the command line spend no time in code of their own; optimizing it is most of what compiling it costs.
set(REGULUS_LIGHT_OPTIMIZATION $<$<CONFIG:Release>:-O1>)

# All tests that need no device: what is built and run under sanitizers.
add_custom_target(regulus_host_tests)

# A GoogleTest executable `regulus_test_<name>`, registered with ctest under its own name.
# Labels (for `ctest -L`): DEVICE when the test needs a Vulkan device.
# TOGETHER: of many sources, whose helpers have names of their own: they may be compiled as one.
function(regulus_test name)
  cmake_parse_arguments(ARG "TOGETHER" "" "SOURCES;LINK;LABELS" ${ARGN})
  set(target regulus_test_${name})
  add_executable(${target} ${ARG_SOURCES})
  if(NOT ARG_TOGETHER)  # cases have helpers of the same names
    set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  endif()
  target_link_libraries(${target} PRIVATE regulus_options GTest::gtest GTest::gtest_main fmt::fmt
    ${ARG_LINK})
  target_compile_options(${target} PRIVATE ${REGULUS_LIGHT_OPTIMIZATION})
  regulus_precompile(${target} tests)
  target_compile_definitions(${target} PRIVATE
    REGULUS_SOURCE_DIR="${CMAKE_SOURCE_DIR}" REGULUS_ASSETS_DIR="${CMAKE_SOURCE_DIR}/../shared/assets")
  if(NOT "DEVICE" IN_LIST ARG_LABELS)
    add_dependencies(regulus_host_tests ${target})
  endif()
  add_test(NAME ${name} COMMAND ${target} WORKING_DIRECTORY ${CMAKE_BINARY_DIR})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 900)
  if(REGULUS_TEST_CASES)
    gtest_discover_tests(${target} TEST_PREFIX "${name}/" WORKING_DIRECTORY ${CMAKE_BINARY_DIR} DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS CASE TIMEOUT 900)
  endif()
endfunction()
