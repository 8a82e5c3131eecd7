# Read by ctest when it starts: makes an entry of each test in the laboratory's programs.

# So long may all tests of a group take: many times what they need on an idle machine.
set(lab_seconds 1200)
math(EXPR lab_timeout "${lab_seconds} + 60")

# lab_add(GROUP LABEL PROGRAM COMMAND...): the entry GROUP, which runs the program, and an entry
# for each of its tests, which only reports.
function(lab_add group label program)
    add_test(${group} ${ARGN})
    set_tests_properties(${group} PROPERTIES
        FIXTURES_SETUP ${group} LABELS "lab;${label}" PROCESSORS 2 TIMEOUT ${lab_timeout})
    if("${ARGN}" MATCHES "--systemd")
        set_tests_properties(${group} PROPERTIES FIXTURES_REQUIRED package)
    endif()
    if(NOT EXISTS "${program}")
        return()
    endif()
    execute_process(COMMAND "${program}" --gtest_list_tests
        OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE " *#[^\n]*" "" listing "${listing}")
    string(REPLACE "\n" ";" lines "${listing}")
    foreach(line IN LISTS lines)
        if(line MATCHES "^([^ ].*\\.)$")
            set(suite "${CMAKE_MATCH_1}")
        elseif(line MATCHES "^  (.+)$")
            set(name "${suite}${CMAKE_MATCH_1}")
            add_test(${group}.${name} "${lab_scripts}/report_case" "${lab_results}/${group}"
                "${name}")
            set_tests_properties(${group}.${name} PROPERTIES
                FIXTURES_REQUIRED ${group} LABELS "lab;${label}" TIMEOUT 60
                SKIP_REGULAR_EXPRESSION "${lab_skip}")
        endif()
    endforeach()
endfunction()

function(lab_group group label kernel program)
    lab_add(${group} ${label} "${program}" "${lab_scripts}/run_group" "${lab_results}/${group}"
        "${lab_scripts}/run_guest" ${ARGN} "${kernel}" "${lab_results}/${group}" ${lab_seconds}
        "${program}")
endfunction()

# The same tests on the host's own kernel, if it has virtual CAN. They run in a guest anyway, so
# those that need one may be skipped here.
function(lab_host_group group label program)
    execute_process(RESULT_VARIABLE without OUTPUT_QUIET ERROR_QUIET
        COMMAND unshare --net sh -c "ip link add type vcan && ip link add type vxcan")
    if(without EQUAL 0)
        set(lab_skip "this test needs a guest of the laboratory")
        lab_add(${group} ${label} "${program}" "${lab_scripts}/run_group"
            "${lab_results}/${group}" "${lab_scripts}/run_on_host" "${lab_results}/${group}"
            ${lab_seconds} "${program}")
    endif()
endfunction()
