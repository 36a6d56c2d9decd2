# motiondb_library(NAME SOURCES... DEPENDS...): one target for each folder, with our warnings.
# Disabled warnings: missing-field-initializers, because designated initialisers use defaults on
# purpose; restrict, because g++ 12 reports it for plain string concatenation (GCC bug 105651);
# array-bounds and stringop, because g++ 12 reports them for moved strings if <string> is
# precompiled. The sanitizers find these errors.
set(MOTIONDB_WARNINGS -Wall -Wextra -Wshadow -Wpedantic -Wnon-virtual-dtor
    -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND MOTIONDB_WARNINGS -Wno-restrict -Wno-array-bounds -Wno-stringop-overread
       -Wno-stringop-overflow)
  # g++ spends 8 to 9 % of its time on collecting garbage: start at 512 MiB instead of 128.
  add_compile_options(--param=ggc-min-heapsize=524288)
endif()
if(MOTIONDB_WERROR)
  list(APPEND MOTIONDB_WARNINGS -Werror)
endif()
if(MOTIONDB_SANITIZE)
  add_compile_options(-fsanitize=${MOTIONDB_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MOTIONDB_SANITIZE})
  if(MOTIONDB_SANITIZE MATCHES undefined)
    # Undefined behaviour traps instead of calling a report with data of its own for each check: code
    # and data are half as large. Address Sanitizer shows where (handle_sigill, tests/run.sh). The
    # types of objects (vptr) are not checked.
    add_compile_options(-fsanitize-undefined-trap-on-error)
  endif()
endif()

# Precompiled headers: common headers with long compile times, compiled once for all libraries and
# once for all tests. A precompiled header needs the same options in every target that uses it, so
# each of these targets links the libraries of the headers. Users of an installed library do not
# need them.
set(MOTIONDB_PRECOMPILED_DEPENDS PkgConfig::Eigen3 absl::status absl::statusor fmt::fmt)
function(motiondb_precompiled_headers name)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "// A target needs a source.\n")
  add_library(${name} OBJECT ${source})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${MOTIONDB_PRECOMPILED_DEPENDS})
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  target_precompile_headers(${name} PRIVATE ${ARGN})
  if(CCACHE)
    set_target_properties(${name} PROPERTIES CXX_COMPILER_LAUNCHER
      "${PROJECT_SOURCE_DIR}/deploy/cmake/compile_anew.sh;${CMAKE_CXX_COMPILER_LAUNCHER}")
  endif()
endfunction()

# Unity builds compile several files together, because headers need most of the compile time. So
# names must be unique in a target, and each test file has its own namespace. GLUE marks a target
# that uses gRPC, protobuf, Asio or CLI11, whose headers are the largest: it compiles more files
# together, with less optimisation, because it converts and calls. Other targets use the precompiled
# headers. TEST marks test code: GLUE is not optimised there (a quarter faster than -O1), the rest a
# little, because it computes: with the Address Sanitizer tree_tests take a quarter of their time at
# -O0.
function(motiondb_compile name glue test)
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  if(glue)
    set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
    if(test OR MOTIONDB_SANITIZE)
      target_compile_options(${name} PRIVATE -O0)
    else()
      target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    endif()
    target_compile_options(${name} PRIVATE "SHELL:-include text/compiled_format.h")
    return()
  endif()
  set(precompiled motiondb_precompiled)
  if(test)
    set(precompiled motiondb_test_precompiled)
    target_compile_options(${name} PRIVATE -O1)
  endif()
  foreach(library ${MOTIONDB_PRECOMPILED_DEPENDS})
    target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:${library}>)
  endforeach()
  target_precompile_headers(${name} REUSE_FROM ${precompiled})
endfunction()

function(motiondb_library name)
  cmake_parse_arguments(arg "GLUE;TEST" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS})
  motiondb_compile(${name} ${arg_GLUE} ${arg_TEST})
endfunction()

function(motiondb_executable name)
  cmake_parse_arguments(arg "GLUE;TEST" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS})
  motiondb_compile(${name} ${arg_GLUE} ${arg_TEST})
endfunction()

# motiondb_test(NAME [PART2 PATTERN] SOURCES... DEPENDS...): a Catch2 program. The cases that PATTERN
# matches are a test of their own, NAME_part2, for a second processor. Registers the sources, so
# that the configure step can report a test file without a target.
function(motiondb_test name)
  cmake_parse_arguments(arg "GLUE" "PART2" "SOURCES;DEPENDS" ${ARGN})
  set(glue)
  if(arg_GLUE)
    set(glue GLUE)
  endif()
  motiondb_executable(${name} ${glue} TEST
    SOURCES ${arg_SOURCES} DEPENDS motiondb_test_support ${arg_DEPENDS})
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 6)
  # Comparisons over all recorded motion take minutes with a sanitizer and find nothing new there:
  # the same code runs in other cases.
  set(cases)
  if(MOTIONDB_SANITIZE)
    set(cases "~[slow]")
  endif()
  if(arg_PART2)
    add_test(NAME ${name}_part2 COMMAND ${name} "${cases}${arg_PART2}")
    string(APPEND cases "~${arg_PART2}")
  endif()
  add_test(NAME ${name} COMMAND ${name} ${cases})
  foreach(source ${arg_SOURCES})
    get_filename_component(path ${source} ABSOLUTE)
    set_property(GLOBAL APPEND PROPERTY MOTIONDB_TEST_SOURCES ${path})
  endforeach()
endfunction()
