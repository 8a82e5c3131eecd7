# Read by ctest when it starts: makes an entry of each test in the laboratory's programs.

# So long may all tests of a group take: many times what they need on an idle machine.
set(lab_seconds 1200)
math(EXPR lab_timeout "${lab_seconds} + 60")
# What run_group and report_case end with where a machine cannot run the group.
set(lab_skipped 77)
# A guest ends with ctest, however that ends.
set(without_parent setpriv --pdeathsig KILL)

# lab_add(GROUP LABELS PROCESSORS PROGRAM FILTER COMMAND...): the entry GROUP, which runs the
# program, and an entry for each of its tests that the filter lets through, which only reports.
function(lab_add group labels processors program filter)
    add_test(${group} ${without_parent} "${lab_scripts}/run_group" "${lab_results}/${group}"
        ${ARGN})
    set_tests_properties(${group} PROPERTIES FIXTURES_SETUP ${group} LABELS "${labels}"
        PROCESSORS ${processors} TIMEOUT ${lab_timeout} SKIP_RETURN_CODE ${lab_skipped} COST 100)
    if("${ARGN}" MATCHES "--systemd")
        set_tests_properties(${group} PROPERTIES FIXTURES_REQUIRED package)
    endif()
    if(NOT EXISTS "${program}")
        return()
    endif()
    execute_process(COMMAND "${program}" --gtest_list_tests "--gtest_filter=${filter}"
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
                FIXTURES_REQUIRED ${group} LABELS "${labels}" TIMEOUT 60
                SKIP_RETURN_CODE ${lab_skipped} SKIP_REGULAR_EXPRESSION "${lab_skip}")
        endif()
    endforeach()
endfunction()

function(lab_group group label kernel program)
    lab_add(${group} "lab;${label}" 2 "${program}" "*" "${lab_scripts}/run_guest" ${ARGN}
        "${kernel}" "${lab_results}/${group}" ${lab_seconds} "${program}")
endfunction()

# The host's own kernel, if it has virtual CAN and this user may have a network of its own.
execute_process(RESULT_VARIABLE without_can OUTPUT_QUIET ERROR_QUIET
    COMMAND unshare --net --mount sh -c "ip link add type vcan && ip link add type vxcan")

# can_group(GROUP LONG|"" PROGRAM FILTER): on the host's own kernel if it has virtual CAN, else in a
# guest. Tests that need a machine of their own are skipped on the host's.
#
# One guest runs at a time. Its programs are processes of the host that it switches all the time, and on
# a host that is itself a virtual machine two such guests wait for each other: together they need longer
# than one after the other.
function(can_group group long program filter)
    string(TOLOWER "${long}" label)
    if(without_can)
        set(runner "${lab_scripts}/run_uml")
    else()
        set(runner "${lab_scripts}/run_on_host")
        set(lab_skip "this test needs a guest of the laboratory")
    endif()
    lab_add(${group} "${label}" 1 "${program}" "${filter}" ${runner} "${lab_results}/${group}"
        ${lab_seconds} "${program}" "--gtest_filter=${filter}")
    set_tests_properties(${group} PROPERTIES DEPENDS "${lab_guest_before}")
    set(lab_guest_before ${group} PARENT_SCOPE)
endfunction()
