# Precompiled headers: what many sources include and take long to read. Sources still include what they use, so that
# they compile without (-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON, as cmake/lint does).
#
# regulus_precompile(TARGET host|tests): TARGET reads the headers of that group, which are compiled once.
# A target whose own headers are heavy calls target_precompile_headers itself instead.
set(REGULUS_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory>
  <numbers> <optional> <span> <string> <string_view> <utility> <vector> <fmt/format.h> <glm/glm.hpp>)

# A library without content whose flags are those of the targets that read its headers.
function(regulus_precompiled_group group)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled/${group}.cpp CONTENT "// Carries precompiled headers.\n")
  add_library(regulus_precompiled_${group} OBJECT ${CMAKE_BINARY_DIR}/precompiled/${group}.cpp)
  target_link_libraries(regulus_precompiled_${group} PRIVATE regulus_options ${ARGN})
endfunction()

regulus_precompiled_group(host fmt::fmt glm::glm)
set_target_properties(regulus_precompiled_host PROPERTIES POSITION_INDEPENDENT_CODE ON)  # as what reads them
target_precompile_headers(regulus_precompiled_host PRIVATE ${REGULUS_COMMON_HEADERS})
if(REGULUS_TESTS)
  regulus_precompiled_group(tests fmt::fmt glm::glm GTest::gtest nlohmann_json::nlohmann_json)
  target_compile_options(regulus_precompiled_tests PRIVATE ${REGULUS_LIGHT_OPTIMIZATION})
  target_precompile_headers(regulus_precompiled_tests PRIVATE ${REGULUS_COMMON_HEADERS} <gtest/gtest.h> <nlohmann/json.hpp>)
endif()

function(regulus_precompile target group)
  target_precompile_headers(${target} REUSE_FROM regulus_precompiled_${group})
endfunction()
