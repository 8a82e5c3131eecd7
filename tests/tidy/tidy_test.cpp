#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

/// Rules of the house that no tool knows.
namespace tribus::test::tidy_test {
namespace {

namespace fs = std::filesystem;

struct SourceLine {
    std::string file;  ///< relative to the project
    std::size_t number = 0;
    std::string text;
};

std::vector<SourceLine> lines_of(const std::vector<std::string_view>& folders) {
    const fs::path root = TRIBUS_SOURCE_DIR;
    std::vector<SourceLine> lines;
    for (const std::string_view folder : folders) {
        for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
            const fs::path& path = entry.path();
            if (path.extension() != ".h" && path.extension() != ".cpp") {
                continue;
            }
            const std::string name = path.lexically_relative(root).string();
            std::ifstream file(path);
            std::string text;
            for (std::size_t number = 1; std::getline(file, text); ++number) {
                lines.push_back({name, number, text});
            }
        }
    }
    return lines;
}

bool has_any(std::string_view text, std::initializer_list<std::string_view> words) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
        return text.find(word) != std::string_view::npos;
    });
}

template <class IsWrong>
void expect_none(const std::vector<SourceLine>& lines, std::string_view rule, IsWrong is_wrong) {
    ASSERT_FALSE(lines.empty());
    for (const SourceLine& line : lines) {
        if (is_wrong(line)) {
            ADD_FAILURE() << line.file << ":" << line.number << ": " << rule << ": " << line.text;
        }
    }
}

const std::vector<std::string_view> kProduct{"core", "transports", "pipelines", "config", "app"};

TEST(Tidy, OneFileReadsTheClock) {
    expect_none(lines_of(kProduct), "ask pipelines/realtime/clock.h", [](const SourceLine& line) {
        return line.file != "pipelines/realtime/clock.cpp" &&
               has_any(line.text,
                       {"clock_gettime", "steady_clock", "system_clock", "high_resolution_clock",
                        "gettimeofday", "adjtimex", "time(nullptr)"});
    });
}

TEST(Tidy, CoreCodecsAndPipelinesIncludeNoSystemHeaderAndNoThread) {
    expect_none(lines_of({"core", "transports/codecs", "transports/registry", "pipelines"}),
                "these layers are pure", [](const SourceLine& line) {
                    return line.file.find("realtime/") == std::string::npos &&
                           line.text.starts_with("#include <") &&
                           has_any(line.text, {"<sys/", "<unistd.h>", "<fcntl.h>", "<poll.h>",
                                               "<linux/", "<asm/", "<thread>", "<mutex>",
                                               "<atomic>", "<iostream>", "<fstream>", "spdlog"});
                });
}

TEST(Tidy, ParserAndPortDoNotKnowEachOther) {
    expect_none(lines_of({"transports/codecs", "transports/links"}),
                "a codec knows no link, a link no codec", [](const SourceLine& line) {
                    const bool codec = line.file.starts_with("transports/codecs");
                    return line.text.starts_with("#include \"transports/") &&
                           has_any(line.text, {codec ? "transports/links" : "transports/codecs"});
                });
}

/// Returns the rooms that a CMakeLists.txt lists behind the folder of a layer, in all its lists.
std::vector<std::string> rooms_of(const std::string& layer) {
    const fs::path top = *fs::path(layer).begin();
    std::ifstream file(fs::path(TRIBUS_SOURCE_DIR) / top / "CMakeLists.txt");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::regex list("FOLDER " + layer + "\\s[^)]*?ROOMS ([a-z_/\\s]+)");
    std::string listed;
    for (std::sregex_iterator match(text.begin(), text.end(), list), none; match != none; ++match) {
        listed += (*match)[1].str() + " ";
    }
    std::istringstream words(listed);
    return {std::istream_iterator<std::string>(words), {}};
}

/// Files beside the rooms are below all of them. What begins with `above` may include all of them.
/// A room of an open layer that is not listed is above all that are.
void expect_rooms_in_order(const std::string& layer, std::string_view above, bool open = false) {
    std::vector<std::string> rooms = rooms_of(layer);
    ASSERT_GT(rooms.size(), 3U) << layer;
    rooms.insert(rooms.begin(), ".");
    const auto is_above = [&](const fs::path& file) {
        return !above.empty() && file.lexically_relative(layer).string().starts_with(above);
    };
    const auto room_of = [&](const fs::path& file) {
        return file.parent_path().lexically_relative(layer).string();
    };
    const auto place_of = [&](const fs::path& file) {
        return std::ranges::find(rooms, room_of(file));
    };
    const std::regex include("#include \"(" + layer + "/.+)\"");
    expect_none(lines_of({layer}), "a CMakeLists.txt lists the rooms from the lowest",
                [&](const SourceLine& line) {
                    std::smatch matched;
                    const bool includes = line.text.starts_with("#include \"");
                    if ((!includes && line.number != 1) || is_above(line.file)) {
                        return false;
                    }
                    if (!open && place_of(line.file) == rooms.end()) {
                        return true;
                    }
                    if (!includes || !std::regex_match(line.text, matched, include)) {
                        return false;
                    }
                    const fs::path included = matched[1].str();
                    return is_above(included) || (room_of(included) != room_of(line.file) &&
                                                  place_of(included) >= place_of(line.file));
                });
}

TEST(Tidy, ARoomIncludesOnlyRoomsBeforeItInTheList) {
    expect_rooms_in_order("transports/codecs", "", true);
    expect_rooms_in_order("transports/links", "", true);
    expect_rooms_in_order("pipelines", "realtime/");
    expect_rooms_in_order("config", "load.");
    expect_rooms_in_order("app", "main.");
}

/// In the preset dev they are built without it.
TEST(Tidy, TestsOfTheLayersBelowDoNotRunTheProgram) {
    expect_none(lines_of({"tests/unit/core", "tests/unit/transports", "tests/unit/pipelines"}),
                "belongs to tests/unit/app or tests/loopback", [](const SourceLine& line) {
                    return has_any(line.text, {"TRIBUS_PROGRAM", "tests/support/shell.h",
                                               "tests/support/page_examples.h", "program_help.h"});
                });
}

/// googletest allows no underscore in a name, and reports SUITE.NAME, which is read as a sentence.
TEST(Tidy, NamesOfTestsAreWordsThatBeginWithCapitals) {
    static const std::regex name(R"(^(TEST|TEST_F|TEST_P|RC_GTEST_\w*PROP)\(\w+,\s*(\w+).*)");
    expect_none(lines_of({"tests"}), "the name is to read ThatItIsSo, and not to begin with Of",
                [](const SourceLine& line) {
                    std::smatch matched;
                    if (!has_any(line.text, {"TEST", "PROP"}) ||
                        !std::regex_match(line.text, matched, name)) {
                        return false;
                    }
                    const std::string said = matched[2];
                    return std::islower(static_cast<unsigned char>(said.front())) != 0 ||
                           said.find('_') != std::string::npos ||
                           (said.starts_with("Of") && said.size() > 2 &&
                            std::isupper(static_cast<unsigned char>(said[2])) != 0);
                });
}

TEST(Tidy, NoLineIsLongerThan100Columns) {
    expect_none(lines_of({"core", "transports", "pipelines", "config", "app", "tests"}), "too long",
                [](const SourceLine& line) {
                    if (line.text.size() <= 100) {
                        return false;
                    }
                    // Continuation bytes of UTF-8 take no column of their own.
                    const auto columns =
                        std::count_if(line.text.begin(), line.text.end(), [](char byte) {
                            return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80;
                        });
                    return columns > 100;
                });
}

TEST(Tidy, NothingIsLeftToDoInAComment) {
    expect_none(lines_of(kProduct), "do it, or file an issue", [](const SourceLine& line) {
        return has_any(line.text, {"TODO", "FIXME", "XXX", "HACK"});
    });
}

/// tests/README.md names tests by the beginnings of their names.
TEST(Tidy, WhatIsPromisedIsShownByTestsThatThereAre) {
    std::ifstream page(std::string(TRIBUS_SOURCE_DIR) + "/tests/README.md");
    std::string names;
    for (const auto& [file, number, text] : lines_of({"tests"})) {
        names += text + "\n";
    }
    std::ifstream cmake(std::string(TRIBUS_SOURCE_DIR) + "/tests/lab/CMakeLists.txt");
    names.append(std::istreambuf_iterator<char>(cmake), {});
    const std::regex test("`(([A-Z][A-Za-z0-9]+)|lab_[a-z]+)`");
    std::size_t found = 0;
    for (std::string line; std::getline(page, line);) {
        for (std::sregex_iterator match(line.begin(), line.end(), test), none; match != none;
             ++match) {
            ++found;
            EXPECT_NE(names.find((*match)[1]), std::string::npos) << (*match)[1];
        }
    }
    EXPECT_GT(found, 30U);
}

/// The README's commands are called by their paths.
TEST(Tidy, WhatSaysHowToRunItCanBeRun) {
    std::size_t found = 0;
    for (const std::string_view folder : {".ci", "deploy", "tests"}) {
        for (const auto& entry :
             fs::recursive_directory_iterator(fs::path(TRIBUS_SOURCE_DIR) / folder)) {
            std::ifstream file(entry.path());
            std::string line;
            const bool own = entry.path().string().find("node_modules") == std::string::npos;
            if (own && entry.is_regular_file() && std::getline(file, line) &&
                line.starts_with("#!")) {
                ++found;
                EXPECT_NE(entry.status().permissions() & fs::perms::owner_exec, fs::perms::none)
                    << entry.path();
            }
        }
    }
    EXPECT_GT(found, 10U);
}

/// Files of tests are compiled together, so names of one must not meet those of another.
TEST(Tidy, AFileOfTestsHasANamespaceOfItsOwnName) {
    const fs::path tests = fs::path(TRIBUS_SOURCE_DIR) / "tests";
    std::size_t seen = 0;
    for (const auto& entry : fs::recursive_directory_iterator(tests)) {
        const std::string name = entry.path().stem().string();
        if (entry.path().extension() != ".cpp" || !name.ends_with("_test")) {
            continue;
        }
        ++seen;
        std::ifstream file(entry.path());
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        const std::size_t end = text.find("::" + name + " {\n");
        const std::size_t begin = text.rfind('\n', end) + 1;
        EXPECT_TRUE(end != std::string::npos && text.substr(begin).starts_with("namespace tribus"))
            << entry.path() << ": namespace tribus::" << name;
    }
    EXPECT_GT(seen, 200U);
}

/// Relative to the project. Of files for two versions of a library one is compiled: they have one
/// name.
std::string name_of_source(const fs::path& source) {
    const std::regex for_a_version("(.+)_v[0-9]+[.]cpp");
    const std::string name = source.lexically_relative(TRIBUS_SOURCE_DIR).string();
    return std::regex_replace(name, for_a_version, "$1");
}

/// Configures the preset dev in a folder of its own and returns the sources that have a command
/// there.
std::set<std::string> sources_with_a_command() {
    const TemporaryFolder folder;
    const Ended configured = run_in_shell("cd '" TRIBUS_SOURCE_DIR "' && cmake --preset dev -B '" +
                                          folder.path().string() + "'");
    EXPECT_EQ(configured.status, 0) << configured.output;
    std::ifstream commands(folder / "compile_commands.json");
    const std::regex entry("  \"file\": \"(.+)\",?");
    std::set<std::string> found;
    std::smatch matched;
    for (std::string line; std::getline(commands, line);) {
        if (std::regex_match(line, matched, entry)) {
            found.insert(name_of_source(matched[1].str()));
        }
    }
    return found;
}

/// What editors know of a source is the command that compiles it by itself.
TEST(Tidy, EverySourceHasACommandOfItsOwnInDev) {
    const std::set<std::string> commanded = sources_with_a_command();
    std::size_t seen = 0;
    for (const char* folder : {"core", "transports", "pipelines", "config", "app", "tests"}) {
        for (const auto& entry :
             fs::recursive_directory_iterator(fs::path(TRIBUS_SOURCE_DIR) / folder)) {
            if (entry.path().extension() == ".cpp") {
                ++seen;
                EXPECT_TRUE(commanded.contains(name_of_source(entry.path())))
                    << entry.path() << ": no target compiles it by itself";
            }
        }
    }
    EXPECT_GT(seen, 1000U);
}

TEST(Tidy, TheTopListOfTheBuildHasAtMost200Lines) {
    std::ifstream file(std::string(TRIBUS_SOURCE_DIR) + "/CMakeLists.txt");
    const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
    EXPECT_GT(lines, 50);
    EXPECT_LE(lines, 200) << "what is machinery goes to deploy/cmake";
}

TEST(Tidy, NoSourceFileIsLongerThan400Lines) {
    for (const SourceLine& line : lines_of(kProduct)) {
        EXPECT_NE(line.number, 401U) << line.file;
    }
}

}  // namespace
}  // namespace tribus::test::tidy_test
