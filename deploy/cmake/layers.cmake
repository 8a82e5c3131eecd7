# One target per layer. A layer sees only the folders of the layers that it links: each target's
# include root holds a link to its own folder and nothing else, so an include against the
# direction does not compile. AT_START lists sources that run only before frames flow, and beside
# them: they are not locked into memory (app/data_path.ld), and GCC takes a third less time for them
# with -Og than with -Os, for a quarter more code.
#
# Most of a compiler's time goes into headers and what they instantiate, so many sources share that.
# A word with a colon in AT_START begins a group that is compiled as one file: sources that need the
# same costly headers stand in one group. A compiler takes up to 1.4 GiB for a group of such a size
# (deploy/prepare.sh counts on that).
function(tribus_group_sources target folder)
    set(group "")
    foreach(word IN LISTS ARGN)
        if(word MATCHES "^(.+):$")
            set(group "${CMAKE_MATCH_1}")
        else()
            list(APPEND sources "${CMAKE_SOURCE_DIR}/${folder}/${word}")
            set_source_files_properties("${CMAKE_SOURCE_DIR}/${folder}/${word}"
                PROPERTIES UNITY_GROUP "${target}_${group}")
        endif()
    endforeach()
    add_library(${target} OBJECT ${sources})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ${TRIBUS_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()

# Not on every processor.
include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-fstack-clash-protection has_stack_clash_protection)

# The compiler's options for sources of the start. GCC uses a precompiled header only with the options
# that it was made with, so tribus_start_headers and each tribus_group_sources get them here.
function(tribus_start_options target)
    target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-Og>
        $<$<BOOL:${TRIBUS_HARDENED}>:-fstack-protector-strong>
        $<$<AND:$<BOOL:${TRIBUS_HARDENED}>,$<NOT:$<CONFIG:Debug>>>:-D_FORTIFY_SOURCE=2>
        $<$<AND:$<BOOL:${TRIBUS_HARDENED}>,$<BOOL:${has_stack_clash_protection}>>:-fstack-clash-protection>
        ${TRIBUS_PRODUCT_FLAGS})
endfunction()

# Called by a room, a folder of a layer: its sources, in the words of tribus_layer.
function(tribus_room)
    cmake_parse_arguments(ROOM "" "" "SOURCES;AT_START" ${ARGN})
    get_property(folder GLOBAL PROPERTY tribus_folder_of_layer)
    file(RELATIVE_PATH room "${CMAKE_SOURCE_DIR}/${folder}" "${CMAKE_CURRENT_SOURCE_DIR}")
    foreach(kind IN ITEMS SOURCES AT_START)
        list(TRANSFORM ROOM_${kind} PREPEND "${room}/" REGEX "[^:]$")
        set_property(GLOBAL APPEND PROPERTY tribus_${kind}_of_rooms ${ROOM_${kind}})
    endforeach()
endfunction()

# ROOMS lists folders of the layer; each has its own list of sources. With OPEN, the other folders of
# the layer are rooms too, behind those. With EACH_ROOM a release compiles each room as one source, else
# the layer: GCC inlines less of a room among other rooms' sources, and more where rooms call each other.
function(tribus_layer name)
    cmake_parse_arguments(LAYER "OPEN;EACH_ROOM" "FOLDER" "ROOMS;SOURCES;AT_START;DEPENDS" ${ARGN})
    set_property(GLOBAL PROPERTY tribus_folder_of_layer "${LAYER_FOLDER}")
    set_property(GLOBAL PROPERTY tribus_SOURCES_of_rooms "")
    set_property(GLOBAL PROPERTY tribus_AT_START_of_rooms "")
    if(LAYER_OPEN)
        file(GLOB folders CONFIGURE_DEPENDS RELATIVE "${CMAKE_SOURCE_DIR}/${LAYER_FOLDER}"
            "${CMAKE_SOURCE_DIR}/${LAYER_FOLDER}/*/CMakeLists.txt")
        list(TRANSFORM folders REPLACE "/CMakeLists.txt$" "")
        list(APPEND LAYER_ROOMS ${folders})
        list(REMOVE_DUPLICATES LAYER_ROOMS)
    endif()
    foreach(room IN LISTS LAYER_ROOMS)
        add_subdirectory("${CMAKE_SOURCE_DIR}/${LAYER_FOLDER}/${room}")
    endforeach()
    foreach(kind IN ITEMS SOURCES AT_START)
        get_property(of_rooms GLOBAL PROPERTY tribus_${kind}_of_rooms)
        list(APPEND LAYER_${kind} ${of_rooms})
    endforeach()
    set(root "${CMAKE_BINARY_DIR}/layers/${name}")
    get_filename_component(parent "${root}/${LAYER_FOLDER}" DIRECTORY)
    # A link of an older layout could stand in the way.
    file(REMOVE_RECURSE "${root}")
    file(MAKE_DIRECTORY "${parent}")
    file(CREATE_LINK "${CMAKE_SOURCE_DIR}/${LAYER_FOLDER}" "${root}/${LAYER_FOLDER}" SYMBOLIC)
    list(TRANSFORM LAYER_SOURCES PREPEND "${CMAKE_SOURCE_DIR}/${LAYER_FOLDER}/")
    if(LAYER_SOURCES OR LAYER_AT_START)
        add_library(${name} STATIC ${LAYER_SOURCES})
        target_include_directories(${name} PUBLIC "${root}")
        target_link_libraries(${name} PUBLIC ${LAYER_DEPENDS} PRIVATE tribus_warnings)
        target_compile_options(${name} PRIVATE ${TRIBUS_PRODUCT_FLAGS})
        set_target_properties(${name} PROPERTIES UNITY_BUILD ${TRIBUS_UNITY} UNITY_BUILD_BATCH_SIZE 34)
        if(LAYER_EACH_ROOM)
            foreach(source IN LISTS LAYER_SOURCES)
                get_filename_component(room "${source}" DIRECTORY)
                get_filename_component(room "${room}" NAME)
                set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${room}")
            endforeach()
            set_target_properties(${name} PROPERTIES UNITY_BUILD_MODE GROUP)
        endif()
    else()
        add_library(${name} INTERFACE)
        target_include_directories(${name} INTERFACE "${root}")
        target_link_libraries(${name} INTERFACE ${LAYER_DEPENDS})
    endif()
    if(LAYER_AT_START)
        tribus_group_sources(${name}_start "${LAYER_FOLDER}" ${LAYER_AT_START})
        target_link_libraries(${name}_start PUBLIC ${LAYER_DEPENDS} PRIVATE tribus_warnings)
        target_include_directories(${name}_start PUBLIC "${root}")
        tribus_start_options(${name}_start)
        target_precompile_headers(${name}_start REUSE_FROM tribus_start_headers)
        target_sources(${name} PRIVATE $<TARGET_OBJECTS:${name}_start>)
    endif()
endfunction()
