# Target regulus_version: #include "base/version.hpp" with version, commit and compiler. The commit is asked for at
# every build, so that it is right without configuring again.
set(version_folder ${CMAKE_BINARY_DIR}/version)
add_custom_target(regulus_version_header
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_SOURCE_DIR} -DTEMPLATE=${CMAKE_SOURCE_DIR}/host/base/version.hpp.in
          -DOUTPUT=${version_folder}/base/version.hpp -DVERSION=${PROJECT_VERSION} -DBUILD_TYPE=${CMAKE_BUILD_TYPE}
          "-DCOMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}"
          -P ${CMAKE_SOURCE_DIR}/cmake/write_version.cmake
  BYPRODUCTS ${version_folder}/base/version.hpp
  COMMENT "" VERBATIM)
add_library(regulus_version INTERFACE)
target_include_directories(regulus_version INTERFACE ${version_folder})
add_dependencies(regulus_version regulus_version_header)
