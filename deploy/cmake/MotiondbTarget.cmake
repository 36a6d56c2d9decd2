# motiondb_library(NAME SOURCES... DEPENDS...): one folder, one target, our warnings.
# Not missing-field-initializers: a designated initialiser leaves the rest at its default on purpose.
# Not restrict: g++ 12 reports it on plain string concatenation (GCC bug 105651); nor array-bounds and
# stringop: it reports them of moved strings once <string> is precompiled. Sanitizers find what they
# would.
set(MOTIONDB_WARNINGS -Wall -Wextra -Wshadow -Wpedantic -Wnon-virtual-dtor
    -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND MOTIONDB_WARNINGS -Wno-restrict -Wno-array-bounds -Wno-stringop-overread
       -Wno-stringop-overflow)
endif()
if(MOTIONDB_WERROR)
  list(APPEND MOTIONDB_WARNINGS -Werror)
endif()
if(MOTIONDB_SANITIZE)
  add_compile_options(-fsanitize=${MOTIONDB_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MOTIONDB_SANITIZE})
endif()

# Headers that most files include and that take the compiler longest, compiled once for all libraries
# and once for all tests. A precompiled header needs the same options in every target that uses it,
# so each of them links the libraries of these headers; users of an installed library need them not.
set(MOTIONDB_PRECOMPILED_DEPENDS PkgConfig::Eigen3 absl::status absl::statusor fmt::fmt)
function(motiondb_precompiled_headers name)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "// A target needs a source.\n")
  add_library(${name} OBJECT ${source})
  target_link_libraries(${name} PRIVATE ${MOTIONDB_PRECOMPILED_DEPENDS})
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

# Targets are compiled a few files at a time, since the headers take most of the compile time: so
# files of one target have no two names alike, and each test file has a namespace of its own. GLUE
# marks a library, a program or a test that uses gRPC, protobuf, Asio or CLI11, whose headers are
# the largest: more files at a time, and without optimisation where speed is not what counts, under
# a sanitizer and in tests. Other targets use the precompiled headers.
function(motiondb_compile name glue precompiled)
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  if(NOT glue)
    foreach(library ${MOTIONDB_PRECOMPILED_DEPENDS})
      target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:${library}>)
    endforeach()
    target_precompile_headers(${name} REUSE_FROM ${precompiled})
    return()
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
  if(MOTIONDB_SANITIZE)
    target_compile_options(${name} PRIVATE -O0)
  endif()
endfunction()

function(motiondb_library name)
  cmake_parse_arguments(arg "GLUE" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS})
  motiondb_compile(${name} ${arg_GLUE} motiondb_precompiled)
endfunction()

function(motiondb_executable name)
  cmake_parse_arguments(arg "GLUE" "PRECOMPILED" "SOURCES;DEPENDS" ${ARGN})
  if(NOT arg_PRECOMPILED)
    set(arg_PRECOMPILED motiondb_precompiled)
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS})
  motiondb_compile(${name} ${arg_GLUE} ${arg_PRECOMPILED})
endfunction()

# motiondb_test(NAME SOURCES... DEPENDS...): a Catch2 program; registers its sources, so that the
# configure step can tell a test file that no target names.
function(motiondb_test name)
  cmake_parse_arguments(arg "GLUE" "" "SOURCES;DEPENDS" ${ARGN})
  set(glue)
  if(arg_GLUE)
    set(glue GLUE)
  endif()
  motiondb_executable(${name} ${glue} PRECOMPILED motiondb_test_precompiled
    SOURCES ${arg_SOURCES} DEPENDS motiondb_test_support ${arg_DEPENDS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 6)
  if(arg_GLUE)
    target_compile_options(${name} PRIVATE -O0)
  endif()
  add_test(NAME ${name} COMMAND ${name})
  foreach(source ${arg_SOURCES})
    get_filename_component(path ${source} ABSOLUTE)
    set_property(GLOBAL APPEND PROPERTY MOTIONDB_TEST_SOURCES ${path})
  endforeach()
endfunction()
