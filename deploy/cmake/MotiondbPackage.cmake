# The Debian package of the programs. Run `cpack` in the build folder, or build the target
# `package`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME motiondb)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${MOTIONDB_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "database server for human motion, and its client")
set(CPACK_PACKAGE_DESCRIPTION
"Stores motion clips (BVH, ASF/AMC, TRC, C3D, FBX, glTF, ...), recognizes an observed motion,
estimates its state, predicts its next frames, and plans motion to a goal.
motiondbd is the gRPC server; motiondb is its command-line client.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
# Programs and system files, without the client library and its headers.
set(CPACK_INSTALL_CMAKE_PROJECTS
  "${PROJECT_BINARY_DIR};motiondb;programs;/" "${PROJECT_BINARY_DIR};motiondb;system;/")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION database)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # dpkg-shlibdeps: the libraries that the programs link
set(CPACK_DEBIAN_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS bash-completion)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(debian ${PROJECT_SOURCE_DIR}/deploy/debian)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${debian}/conffiles ${debian}/postinst ${debian}/prerm ${debian}/postrm)
include(CPack)
