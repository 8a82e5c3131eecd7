# Read by cpack before it makes a package.
if(NOT CPACK_PACKAGE_CONTACT)
    execute_process(COMMAND "${CMAKE_CURRENT_LIST_DIR}/maintainer.sh"
        OUTPUT_VARIABLE CPACK_PACKAGE_CONTACT OUTPUT_STRIP_TRAILING_WHITESPACE
        COMMAND_ERROR_IS_FATAL ANY)
endif()
