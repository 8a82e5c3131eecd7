# How the programs are built, for `--version`. No time and no path: two builds of one commit are the
# same bytes. Included, it has a function; as a script (cmake -P) it writes build_facts.cpp.

# Compiler, system, kind of build, options.
function(tribus_build_facts_text result)
    set(compiler "${CMAKE_CXX_COMPILER_ID}")
    if(compiler STREQUAL "GNU")
        set(compiler GCC)
    endif()
    cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
    set(architecture "${TRIBUS_DEBIAN_ARCHITECTURE}")
    if(NOT architecture)
        execute_process(COMMAND dpkg --print-architecture OUTPUT_VARIABLE architecture
            OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    endif()
    if(NOT architecture)
        set(architecture "${CMAKE_SYSTEM_PROCESSOR}")
    endif()
    string(JOIN " " place ${system_NAME} ${system_VERSION_ID} ${architecture})
    set(options "")
    if(TRIBUS_HARDENED)
        list(APPEND options hardened)
    else()
        list(APPEND options "not hardened")
    endif()
    string(REGEX MATCHALL "-fsanitize=[a-z,]+" sanitizers
        "${CMAKE_CXX_FLAGS} ${TRIBUS_PRODUCT_FLAGS}")
    list(REMOVE_DUPLICATES sanitizers)
    list(APPEND options ${sanitizers})
    string(JOIN ", " text "${compiler} ${CMAKE_CXX_COMPILER_VERSION} for ${place}"
        ${CMAKE_BUILD_TYPE} ${options})
    set(${result} "${text}" PARENT_SCOPE)
endfunction()

# The commit of the sources: from deploy/package.sh, or from git if the sources are a clone of their
# own, not a folder in another one. "with changes" behind it if they are not what was committed.
function(read_commit result)
    set(commit "$ENV{TRIBUS_COMMIT}")
    execute_process(COMMAND git -C "${SOURCES}" rev-parse --show-toplevel OUTPUT_VARIABLE top
        OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
    if(NOT commit AND NOT failed)
        file(REAL_PATH "${SOURCES}" sources)
        file(REAL_PATH "${top}" top)
        if(top STREQUAL sources)
            execute_process(COMMAND git --no-optional-locks -C "${SOURCES}" describe --always
                --abbrev=40 --dirty=-changed --exclude=* OUTPUT_VARIABLE commit
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
        endif()
    endif()
    string(REGEX REPLACE "^([0-9a-f]+)-changed$" "\\1 with changes" commit "${commit}")
    # 12 digits are enough for any repository.
    string(REGEX REPLACE "^([0-9a-f]...........)[0-9a-f]*" "\\1" commit "${commit}")
    set(${result} "${commit}" PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
    read_commit(commit)
    set(text "#include \"app/cli/build_facts.h\"

namespace tribus {

BuildFacts build_facts() {
    return {.version = \"${VERSION}\", .how = \"${HOW}\", .commit = \"${commit}\"};
}

}  // namespace tribus
")
    set(before "")
    if(EXISTS "${WRITE}")
        file(READ "${WRITE}" before)
    endif()
    if(NOT before STREQUAL text)
        file(WRITE "${WRITE}" "${text}")
    endif()
endif()
