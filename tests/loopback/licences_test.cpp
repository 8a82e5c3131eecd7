#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/pages.h"
#include "tests/support/shell.h"

/// deploy/debian/copyright names whatever is compiled into the programs and the page, by the lines
/// that link the programs, the libraries that deploy/prepare.sh installs, and the page's lock file.
namespace tribus::test::licences_test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) {
        words.push_back(word);
    }
    return words;
}

/// The file's paragraphs, each with its fields: `Field: text`, where lines of the text begin with a
/// space.
using Paragraph = std::map<std::string, std::string>;

std::vector<Paragraph> paragraphs() {
    std::istringstream lines(source_text("deploy/debian/copyright"));
    std::vector<Paragraph> found(1);
    std::string field;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty()) {
            found.emplace_back();
        } else if (line.starts_with(" ")) {
            found.back()[field] += line + "\n";
        } else {
            field = line.substr(0, line.find(':'));
            found.back()[field] = line.substr(field.size() + 1) + "\n";
        }
    }
    return found;
}

std::string field_of(const std::string& files, const std::string& field) {
    for (Paragraph& paragraph : paragraphs()) {
        if (paragraph["Files"] == " " + files + "\n") {
            return paragraph[field];
        }
    }
    return {};
}

/// Text of a paragraph that has only a licence.
std::string text_of_licence(const std::string& name) {
    const std::string begin = " " + name + "\n";
    for (Paragraph& paragraph : paragraphs()) {
        if (!paragraph.contains("Files") && paragraph["License"].starts_with(begin)) {
            return paragraph["License"].substr(begin.size());
        }
    }
    return {};
}

/// A component that the file says is compiled in.
struct Component {
    std::string package;
    std::string name;
    std::string licence;
};

std::vector<Component> components() {
    static const std::regex form("\n ([a-z0-9.+-]+): ([^\n]+) \\(([^\n]+)\\)(?=\n)");
    const std::string listed = field_of("usr/bin/*", "Comment");
    std::vector<Component> found;
    for (std::sregex_iterator match(listed.begin(), listed.end(), form), none; match != none;
         ++match) {
        found.push_back({(*match)[1], (*match)[2], (*match)[3]});
    }
    return found;
}

bool names_package(const std::string& package) {
    return std::ranges::any_of(
        components(), [&](const Component& component) { return component.package == package; });
}

/// Lines of the programs' holders that end with the component's name in brackets.
std::vector<std::string> holders_of(const std::string& component) {
    std::istringstream lines(field_of("usr/bin/*", "Copyright"));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) {
        const std::string in_brackets = line.substr(std::min(line.find(" ("), line.size()));
        if (in_brackets.find("(" + component + ")") != std::string::npos ||
            in_brackets.find("(" + component + ",") != std::string::npos ||
            in_brackets.find(", " + component + ")") != std::string::npos) {
            found.push_back(line);
        }
    }
    return found;
}

class Licences : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("ninja --version && dpkg-query --version && [ -e '" TRIBUS_BUILD_DIR
                         "/build.ninja' ]")
                .status != 0) {
            GTEST_SKIP() << "needs ninja, dpkg and the build folder";
        }
    }

    /// Words of the command that links a program.
    static std::vector<std::string> link_words(const std::string& program) {
        const Ended ended =
            run_in_shell("ninja -C '" TRIBUS_BUILD_DIR "' -t commands " + program + " | tail -n 1");
        auto words = words_of(ended.output);
        EXPECT_NE(std::ranges::find(words, "app/" + program), words.end()) << ended.output;
        return words;
    }
    static std::set<std::string> link_words() {
        std::set<std::string> words;
        for (const char* program : {"tribus", "tribus-web", "tribus-mqtt"}) {
            const auto more = link_words(program);
            words.insert(more.begin(), more.end());
        }
        return words;
    }

    static std::vector<std::string> build_libraries() {
        return words_of(
            run_in_shell("cd '" TRIBUS_SOURCE_DIR "'; . deploy/prepare.sh; echo $build_libraries")
                .output);
    }
    /// Whether the programs are linked with a shared library of this package.
    static bool is_linked_shared(const std::string& package) {
        const auto linked = link_words();
        const auto files = words_of(run_in_shell("dpkg-query -L " + package).output);
        return std::ranges::any_of(files, [&](const std::string& file) {
            return file.ends_with(".so") && linked.contains(file);
        });
    }
};

TEST_F(Licences, NameEachStaticLibraryOfTheLinkLine) {
    std::size_t own = 0;
    for (const std::string& word : link_words()) {
        const bool is_object = word.ends_with(".a") || word.ends_with(".o");
        if (is_object && word.starts_with("/")) {
            const std::string owner = run_in_shell("dpkg-query -S " + word).output;
            EXPECT_TRUE(names_package(owner.substr(0, owner.find(':'))))
                << word << " of " << owner << " is static: link the shared library, or list it";
        } else if (is_object) {
            own += word.ends_with(".a") ? 1U : 0U;
        } else if (word.starts_with("-static-")) {
            EXPECT_FALSE(holders_of(word.substr(std::string("-static-").size())).empty()) << word;
        } else {
            EXPECT_FALSE(word.starts_with("-l") || word == "-static" ||
                         word.find("-Bstatic") != std::string::npos)
                << word << ": name the library by its file, so that this test can judge it";
        }
    }
    EXPECT_GE(own, 8U);
}

TEST_F(Licences, NameEachLibraryThatIsOnlyHeaders) {
    std::size_t shared = 0;
    ASSERT_GE(build_libraries().size(), 10U);
    for (const std::string& package : build_libraries()) {
        const bool is_shared = is_linked_shared(package);
        EXPECT_NE(names_package(package), is_shared)
            << package << (is_shared ? " is linked as a shared library" : " is compiled in");
        shared += is_shared ? 1U : 0U;
    }
    EXPECT_GE(shared, 4U);
}

TEST_F(Licences, HaveHoldersThatDebianNamesToo) {
    if (run_in_shell("grep -q VERSION_CODENAME=bookworm /etc/os-release").status != 0) {
        GTEST_SKIP() << "later releases name some holders in another way";
    }
    for (const Component& component : components()) {
        EXPECT_FALSE(holders_of(component.name).empty()) << component.name;
        const std::string debian =
            run_in_shell("for package in " + component.package +
                         " $(dpkg-query -W -f '${Depends}' " + component.package +
                         " | tr -d ' ' | tr ',' '\n' | sed 's/[(:|].*//'); do "
                         "cat /usr/share/doc/$package/copyright; done 2>/dev/null")
                .output;
        if (debian.empty()) {
            continue;  // a system that leaves documentation out
        }
        static const std::regex name("[A-Z][a-z]+ (?:[A-Z]\\. )?[A-Z][a-z]+");
        for (const std::string& line : holders_of(component.name)) {
            std::smatch match;
            ASSERT_TRUE(std::regex_search(line, match, name)) << line;
            EXPECT_NE(debian.find(match.str()), std::string::npos)
                << match.str() << " is not in the copyright of " << component.package;
        }
    }
}

TEST_F(Licences, HaveATextEach) {
    ASSERT_GE(components().size(), 8U);
    static const std::regex common("/usr/share/common-licenses/[A-Za-z0-9.-]+[0-9]");
    const std::string of_programs = field_of("usr/bin/*", "License");
    for (const Component& component : components()) {
        EXPECT_NE(of_programs.find(component.licence), std::string::npos) << component.licence;
        const std::string text = text_of_licence(component.licence);
        std::smatch match;
        if (std::regex_search(text, match, common)) {
            EXPECT_TRUE(fs::exists(match.str())) << match.str();
        } else {
            EXPECT_GE(std::ranges::count(text, '\n'), 15) << component.licence;
        }
    }
}

TEST(PageLicences, NameEachPackageOfTheLockFile) {
    const auto lock = nlohmann::json::parse(source_text("app/web/page/package-lock.json"));
    const std::string holders = field_of("usr/share/tribus/page/*", "Copyright");
    std::size_t count = 0;
    for (const auto& [path, package] : lock.at("packages").items()) {
        if (path.empty() || package.value("dev", false)) {
            continue;
        }
        const std::string name = path.substr(std::string("node_modules/").size());
        const std::string scope = name.substr(0, name.find('/'));
        EXPECT_TRUE(holders.find(name) != std::string::npos ||
                    holders.find(scope + ",") != std::string::npos)
            << name;
        EXPECT_EQ(package.value("license", ""), "MIT") << name;
        ++count;
    }
    EXPECT_GE(count, 10U);
}

}  // namespace
}  // namespace tribus::test::licences_test
