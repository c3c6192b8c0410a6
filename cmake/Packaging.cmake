# The Debian package: `cpack --config build/release/CPackConfig.cmake`, or cmake/bootstrap package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME regulus)
set(CPACK_PACKAGE_VENDOR "Regulus")
set(CPACK_PACKAGE_CONTACT "Regulus maintainers <maintainers@regulus.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "renderer for glTF scenes with robust light transport")
set(CPACK_PACKAGE_DESCRIPTION
"Path tracing, light tracing, bidirectional path tracing, photon merging and vertex connection
and merging with path space regularization, on any Vulkan device, graphics card or processor.")
set(CPACK_PACKAGE_FILE_NAME regulus_${PROJECT_VERSION}_${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
# The loader is opened when the program runs, so that nothing else tells of it.
set(CPACK_DEBIAN_PACKAGE_DEPENDS libvulkan1)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "parallel, slurm-client")
include(CPack)
