# What makes a build from nothing shorter. Both are about whole targets and change no result:
#
# SINEW_PRECOMPILE: the headers that most source files include are compiled once for all. Off where a compiler cache is at
# work (tools/build), which a change of one header would empty, and where missing includes are to be found (tidy).
#
# SINEW_PLAIN: what is not optimised. UNIT_TESTS: the test programs of the rooms and of the command; TESTS: every test
# program, and the command as well, so that only the rooms they look at are optimised.

function(sinew_precompiled name)
    file(TOUCH ${PROJECT_BINARY_DIR}/precompiled.cpp)
    add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
    target_link_libraries(${name} PRIVATE sinew_flags fmt::fmt)
    target_compile_options(${name} PRIVATE ${ARGN})
    set(headers <algorithm> <array> <charconv> <chrono> <cmath> <expected> <filesystem> <fstream> <functional> <map> <memory>
        <optional> <set> <span> <string> <string_view> <utility> <vector> <fmt/format.h> <fmt/ranges.h>
        sinew/family/families.hpp sinew/bus/bus.hpp sinew/robot/robot.hpp sinew/sim/simulator.hpp)
    if(SINEW_TESTS)
        target_link_libraries(${name} PRIVATE GTest::gtest)
        list(APPEND headers <gtest/gtest.h>)
    endif()
    target_precompile_headers(${name} PRIVATE ${headers})
endfunction()

function(sinew_build_fast_below folder)
    get_directory_property(targets DIRECTORY ${folder} BUILDSYSTEM_TARGETS)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE place)
    foreach(target IN LISTS targets)
        get_target_property(type ${target} TYPE)
        if(NOT type MATCHES "EXECUTABLE|STATIC_LIBRARY")
            continue()
        endif()
        set(precompiled sinew_precompiled)
        if((SINEW_PLAIN STREQUAL TESTS AND (type STREQUAL EXECUTABLE OR place MATCHES "^(apps|tests)/"))
           OR (SINEW_PLAIN STREQUAL UNIT_TESTS AND type STREQUAL EXECUTABLE AND target MATCHES "_test$" AND NOT place MATCHES "^tests/"))
            target_compile_options(${target} PRIVATE -O0)
            set(precompiled sinew_precompiled_plain)
        endif()
        # What the counts look at is compiled alike in every build: other headers before it change what g++ inlines.
        if(SINEW_PRECOMPILE AND NOT target MATCHES "^(sinew_(base|wire|link|bus|family|actuator|allocations)|transactions|cycles)$")
            target_precompile_headers(${target} REUSE_FROM ${precompiled})
        endif()
    endforeach()
    get_directory_property(folders DIRECTORY ${folder} SUBDIRECTORIES)
    foreach(below IN LISTS folders)
        sinew_build_fast_below(${below})
    endforeach()
endfunction()

function(sinew_build_fast)
    if(SINEW_PRECOMPILE)
        # g++ wants the macros of those headers' libraries to be the same wherever they are used, and g++ 12 no longer sees
        # which of its false warnings stand in headers of its own.
        target_compile_definitions(sinew_flags INTERFACE FMT_SHARED GTEST_HAS_PTHREAD=1)
        target_compile_options(sinew_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds -Wno-restrict
            -Wno-stringop-overflow -Wno-stringop-overread -Wno-maybe-uninitialized>)
        sinew_precompiled(sinew_precompiled)
        if(SINEW_PLAIN)
            sinew_precompiled(sinew_precompiled_plain -O0)
        endif()
    endif()
    sinew_build_fast_below(${PROJECT_SOURCE_DIR})
endfunction()
