# Read by ctest when it starts: makes an entry of each suite in a program of googletest, named
# PROGRAM.SUITE. A process for each single test would cost more than most tests do.

# Suites that take 4 seconds and more, the longest first. They start first: at the end processors
# would wait for them.
set(costly StateLogAtPtys NeverStale Frames/CodecCounts LineJudge Engine/ProductCounts AttackedLink
    References Redundancy Formats/CanChainTest InitText SbusBound)
# Suites that count what a running program does: other work adds wake-ups.
set(quiet_suites "Frames/DaemonCounts|DaemonSystemCalls|WebCounts")

# Those that compute, and those that the machine must not disturb. The second ones begin when the
# first ones are over, some at a time.
set(computing "")
set(quiet "")

function(add_suite_or_test name program filter seconds)
    add_test("${name}" "${program}" --gtest_brief=1 "--gtest_filter=${filter}")
    # A process keeps the memory that it frees: the kernel would clear it anew for each of
    # thousands of simulated worlds, which takes longer than to simulate them.
    set_tests_properties("${name}" PROPERTIES TIMEOUT ${seconds} ENVIRONMENT
        "MALLOC_MMAP_THRESHOLD_=1000000000;MALLOC_TRIM_THRESHOLD_=1000000000")
endfunction()

# add_suites(PROGRAM_NAME PROGRAM_FILE SECONDS LONG): suites whose names match LONG get the label
# "long" and run in the second tier only.
function(add_suites name program seconds long)
    if(NOT EXISTS "${program}")
        add_test(${name} "${program}")
        return()
    endif()
    execute_process(COMMAND "${program}" --gtest_list_tests
        OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE " *#[^\n]*" "" listing "${listing}")
    string(REPLACE "\n" ";" lines "${listing}")
    set(suite "")
    foreach(line IN LISTS lines)
        if(line MATCHES "^([^ ]+)\\.$")
            set(suite "${CMAKE_MATCH_1}")
            if(suite MATCHES "^(${quiet_suites})$")
                continue()
            endif()
            add_suite_or_test("${name}.${suite}" "${program}" "${suite}.*" ${seconds})
            list(APPEND computing "${name}.${suite}")
            list(FIND costly "${suite}" place)
            if(place GREATER -1)
                math(EXPR cost "100 - ${place}")
                set_tests_properties("${name}.${suite}" PROPERTIES COST ${cost})
            endif()
            if(suite MATCHES "${long}")
                set_tests_properties("${name}.${suite}" PROPERTIES LABELS long)
            endif()
        elseif(suite MATCHES "^(${quiet_suites})$" AND line MATCHES "^ +(.+)$")
            set(test "${suite}.${CMAKE_MATCH_1}")
            add_suite_or_test("${name}.${test}" "${program}" "${test}" ${seconds})
            list(APPEND quiet "${name}.${test}")
        endif()
    endforeach()
    set(computing "${computing}" PARENT_SCOPE)
    set(quiet "${quiet}" PARENT_SCOPE)
endfunction()

# keep_quiet(PROCESSORS TEST...): some at a time.
function(keep_quiet processors)
    set_tests_properties(${ARGN} ${quiet} PROPERTIES
        PROCESSORS ${processors} DEPENDS "${computing}")
    set_tests_properties(${quiet} PROPERTIES COST 50)
endfunction()
