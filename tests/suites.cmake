# Read by ctest when it starts: makes an entry of each suite in a program of googletest, named
# PROGRAM.SUITE. A process for each single test would cost more than most tests do.

# add_suites(PROGRAM_NAME PROGRAM_FILE SECONDS LONG): suites whose names match LONG get the label
# "long" and run in the second tier only.
# Suites that compute for 20 seconds and more. They start first: at the end processors would wait for
# them.
set(costly LineJudge|NeverStale|Frames/CodecCounts|SensorValue|Ibus2Decoder|SbusResyncProperty
    IbusBesidePlain|SbusBesidePlain)
list(JOIN costly "|" costly)
# Suites that count what a running daemon does. Other work adds wake-ups, so they run alone.
set(alone Frames/DaemonCounts)

function(add_suites name program seconds long)
    if(NOT EXISTS "${program}")
        add_test(${name} "${program}")
        return()
    endif()
    execute_process(COMMAND "${program}" --gtest_list_tests
        OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE " *#[^\n]*" "" listing "${listing}")
    string(REPLACE "\n" ";" lines "${listing}")
    foreach(line IN LISTS lines)
        if(line MATCHES "^([^ ]+)\\.$")
            add_test("${name}.${CMAKE_MATCH_1}" "${program}" --gtest_brief=1
                "--gtest_filter=${CMAKE_MATCH_1}.*")
            set(suite "${CMAKE_MATCH_1}")
            # A process keeps the memory that it frees: the kernel would clear it anew for each of
            # thousands of simulated worlds, which takes longer than to simulate them.
            set_tests_properties("${name}.${suite}" PROPERTIES TIMEOUT ${seconds} ENVIRONMENT
                "MALLOC_MMAP_THRESHOLD_=1000000000;MALLOC_TRIM_THRESHOLD_=1000000000")
            if(suite MATCHES "^(${costly})$")
                set_tests_properties("${name}.${suite}" PROPERTIES COST 100)
            endif()
            if(suite MATCHES "^(${alone})$")
                set_tests_properties("${name}.${suite}" PROPERTIES RUN_SERIAL TRUE)
            endif()
            if(suite MATCHES "${long}")
                set_tests_properties("${name}.${suite}" PROPERTIES LABELS long)
            endif()
        endif()
    endforeach()
endfunction()
