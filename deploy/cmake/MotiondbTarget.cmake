# motiondb_library(NAME SOURCES... DEPENDS...): one folder, one target, our warnings.
# Not missing-field-initializers: a designated initialiser leaves the rest at its default on purpose.
# Not restrict: g++ 12 reports it on plain string concatenation (GCC bug 105651).
set(MOTIONDB_WARNINGS -Wall -Wextra -Wshadow -Wpedantic -Wnon-virtual-dtor
    -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND MOTIONDB_WARNINGS -Wno-restrict)
endif()
if(MOTIONDB_WERROR)
  list(APPEND MOTIONDB_WARNINGS -Werror)
endif()
if(MOTIONDB_SANITIZE)
  add_compile_options(-fsanitize=${MOTIONDB_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MOTIONDB_SANITIZE})
endif()

# GLUE, of a library, a program or a test: what it does with gRPC, protobuf or CLI11 takes a compiler
# a fraction of the time that their headers take. Sanitizers, which make every line of them dearer,
# get it not optimised and, but for tests, eight files at a time; what computes stays as it is.
function(motiondb_compile_glue name)
  if(MOTIONDB_SANITIZE)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    target_compile_options(${name} PRIVATE -O0)
  endif()
endfunction()

function(motiondb_library name)
  cmake_parse_arguments(arg "GLUE" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS})
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  if(arg_GLUE)
    motiondb_compile_glue(${name})
  endif()
endfunction()

function(motiondb_executable name)
  cmake_parse_arguments(arg "GLUE" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS})
  target_compile_options(${name} PRIVATE ${MOTIONDB_WARNINGS})
  if(arg_GLUE)
    motiondb_compile_glue(${name})
  endif()
endfunction()

# motiondb_test(NAME SOURCES... DEPENDS...): a Catch2 program; registers its sources, so that the
# configure step can tell a test file that no target names.
function(motiondb_test name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS" ${ARGN})
  motiondb_executable(${name} ${arg_UNPARSED_ARGUMENTS}
    SOURCES ${arg_SOURCES} DEPENDS motiondb_test_support ${arg_DEPENDS})
  # Each file of a test has names of its own, as Stub, which one unit could not hold.
  set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
  add_test(NAME ${name} COMMAND ${name})
  foreach(source ${arg_SOURCES})
    get_filename_component(path ${source} ABSOLUTE)
    set_property(GLOBAL APPEND PROPERTY MOTIONDB_TEST_SOURCES ${path})
  endforeach()
endfunction()
