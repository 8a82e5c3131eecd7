# Read by ctest when it starts: makes an entry of each suite in a program of googletest, named
# PROGRAM.SUITE. A process for each single test would cost more than most tests do.
# Needs the number of processors in `processors`.

# Suites that compute for a second and more, the longest first. They start first: at the end
# processors would wait for them.
set(costly Frames/CodecCounts Usual/RecordedLineAtAPort Usual/LineJudgeAtAPort NeverStale Engine/ProductCounts Formats/CanChainTest
    SbusBesidePlain Tshark Sigrok InitText ParityMarksTest EngineHandset Both/RecordedLine LineJudge Tidy
    IbusBesidePlain Seeds/Canmatrix)
# Suites compute: they leave the processors to tests that wait for real time, and some more of them than
# there are processors run at a time, so that tests that wait run beside them.
math(EXPR at_a_time "${processors} + 2")
set(computed 0)
set(leaving_processors "${CMAKE_CURRENT_LIST_DIR}/support/leaving_processors")
execute_process(COMMAND "${leaving_processors}" true
    RESULT_VARIABLE refused OUTPUT_QUIET ERROR_QUIET)
if(refused)
    set(leaving_processors "")
endif()
# Suites that count what a running program does: other work adds wake-ups. The longest runs beside the
# tests of the others, two of them at a time.
set(longest_counting WebCounts)
set(counting "${longest_counting}|Frames/DaemonCounts|DaemonSystemCalls|DaemonWithPages")
set(counted 0)

# Those that compute, and those that the machine must not disturb. The second ones begin when the
# first ones are over, some at a time.
set(computing "")
set(quiet "")

# add_suite_or_test(NAME FILTER SECONDS COMMAND...)
function(add_suite_or_test name filter seconds)
    add_test("${name}" ${ARGN} --gtest_brief=1 "--gtest_filter=${filter}")
    # A process keeps the memory that it frees: the kernel would clear it anew for each of
    # thousands of simulated worlds, which takes longer than to simulate them.
    set_tests_properties("${name}" PROPERTIES TIMEOUT ${seconds} ENVIRONMENT
        "MALLOC_MMAP_THRESHOLD_=1000000000;MALLOC_TRIM_THRESHOLD_=1000000000")
endfunction()

# add_computing_suite(NAME SUITE PROGRAM SECONDS): with what processors have left over.
function(add_computing_suite name suite program seconds)
    add_suite_or_test("${name}" "${suite}.*" ${seconds} ${leaving_processors}
        "${program}")
    list(FIND costly "${suite}" place)
    if(place EQUAL -1)
        math(EXPR lock "${computed} % ${at_a_time}")
        math(EXPR computed "${computed} + 1")
        set(computed ${computed} PARENT_SCOPE)
        set(cost 0)
    else()
        math(EXPR lock "${place} % ${at_a_time}")
        math(EXPR cost "100 - ${place}")
    endif()
    set_tests_properties("${name}" PROPERTIES COST ${cost} RESOURCE_LOCK "computing ${lock}")
endfunction()

# label_long(NAME SUITE LONG): if the suite is one of those of LONG, a regular expression.
function(label_long name suite long)
    if("${suite}." MATCHES "${long}")
        set_tests_properties("${name}" PROPERTIES LABELS long)
    endif()
endfunction()

# add_suites(PROGRAM_NAME PROGRAM_FILE SECONDS LONG): suites whose names, with a dot behind, match LONG
# get the label "long" and run in the second tier only.
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
            if(suite MATCHES "^(${counting})$")
                continue()
            endif()
            add_computing_suite("${name}.${suite}" "${suite}" "${program}" ${seconds})
            list(APPEND computing "${name}.${suite}")
            label_long("${name}.${suite}" "${suite}" "${long}")
        elseif(suite MATCHES "^(${counting})$" AND line MATCHES "^ +(.+)$")
            set(test "${suite}.${CMAKE_MATCH_1}")
            add_suite_or_test("${name}.${test}" "${test}" ${seconds} "${program}")
            set(lock 2)
            if(NOT suite STREQUAL longest_counting)
                math(EXPR lock "${counted} % 2")
                math(EXPR counted "${counted} + 1")
            endif()
            set_tests_properties("${name}.${test}" PROPERTIES COST 50 RESOURCE_LOCK "counting ${lock}")
            label_long("${name}.${test}" "${suite}" "${long}")
            list(APPEND quiet "${name}.${test}")
        endif()
    endforeach()
    set(computed ${computed} PARENT_SCOPE)
    set(counted ${counted} PARENT_SCOPE)
    set(computing "${computing}" PARENT_SCOPE)
    set(quiet "${quiet}" PARENT_SCOPE)
endfunction()

# keep_quiet(TEST...): these too, which judge times. Four of them run at a time.
function(keep_quiet)
    set(lock 0)
    foreach(test IN LISTS ARGN)
        math(EXPR lock "(${lock} + 1) % 4")
        set_tests_properties("${test}" PROPERTIES RESOURCE_LOCK "judging ${lock}")
    endforeach()
    set_tests_properties(${ARGN} ${quiet} PROPERTIES
        PROCESSORS ${processors} DEPENDS "${computing}")
endfunction()
