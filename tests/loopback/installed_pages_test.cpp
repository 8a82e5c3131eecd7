#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

/// What `cmake --install`, and so the package, puts on a board to be read there without a net.
namespace tribus::test::installed_pages_test {
namespace {

namespace fs = std::filesystem;

class InstalledPages : public ::testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("'" TRIBUS_CMAKE "' --version").status != 0) {
            GTEST_SKIP() << "needs cmake";
        }
        const Ended ended =
            run_in_shell("DESTDIR='" + folder_.path().string() +
                         "' '" TRIBUS_CMAKE "' --install '" TRIBUS_BUILD_DIR "' --prefix /usr");
        ASSERT_EQ(ended.status, 0) << ended.output;
    }
    const fs::path& root() const { return folder_.path(); }
    bool has(const std::string& path) const { return fs::exists(root() / path.substr(1)); }

    /// Relative to the root.
    std::vector<fs::path> pages() const {
        std::vector<fs::path> found;
        for (const auto& entry : fs::recursive_directory_iterator(root())) {
            if (entry.path().extension() == ".md") {
                found.push_back(entry.path().lexically_relative(root()));
            }
        }
        return found;
    }

  private:
    TemporaryFolder folder_;
};

TEST_F(InstalledPages, AreThere) {
    for (const std::string path : {"/usr/share/man/man1/tribus.1.gz",
                                   "/usr/share/man/man5/tribus.toml.5.gz",
                                   "/usr/share/man/man8/tribus-web.8.gz",
                                   "/usr/share/tribus/page",
                                   "/usr/share/man/man8/tribus-mqtt.8.gz",
                                   "/usr/lib/systemd/system/tribus-mqtt.service",
                                   "/usr/share/doc/tribus/examples/tribus-mqtt.default",
                                   "/usr/lib/systemd/system/tribus-web.socket",
                                   "/usr/lib/systemd/system/tribus-web.service",
                                   "/usr/share/bash-completion/completions/tribus",
                                   "/usr/share/bash-completion/completions/tribus-web",
                                   "/usr/share/bash-completion/completions/tribus-mqtt",
                                   "/usr/share/zsh/vendor-completions/_tribus",
                                   "/usr/share/fish/vendor_completions.d/tribus.fish",
                                   "/usr/share/fish/vendor_completions.d/tribus-web.fish",
                                   "/usr/share/fish/vendor_completions.d/tribus-mqtt.fish",
                                   "/usr/share/doc/tribus/README.md",
                                   "/usr/share/doc/tribus/CHANGELOG.md",
                                   "/usr/share/doc/tribus/docs/README.md",
                                   "/usr/share/doc/tribus/docs/configuration.md",
                                   "/usr/share/doc/tribus/docs/boards/wiring.md",
                                   "/usr/share/doc/tribus/examples/main-job.toml"}) {
        EXPECT_TRUE(has(path)) << path;
    }
    EXPECT_GE(pages().size(), 25U);
}

TEST_F(InstalledPages, ListTheKeysOfThisProgram) {
    const std::string keys = "/usr/share/doc/tribus/docs/configuration.md";
    EXPECT_EQ(text_of_file(root() / keys.substr(1)),
              run_in_shell(TRIBUS_PROGRAM " schema --format markdown").output);
    const std::string schema = "/usr/share/tribus/tribus.schema.json";
    EXPECT_EQ(text_of_file(root() / schema.substr(1)),
              run_in_shell(TRIBUS_PROGRAM " schema").output);
    EXPECT_EQ(
        run_in_shell("zcat '" + (root() / "usr/share/man/man5/tribus.toml.5.gz").string() + "'")
            .output,
        run_in_shell(TRIBUS_PROGRAM " schema --format man").output);
}

TEST_F(InstalledPages, LinkToWhatIsInstalled) {
    std::size_t count = 0;
    for (const fs::path& page : pages()) {
        for (const std::string& target : links_in(text_of_file(root() / page))) {
            const auto dead = dead_link(root(), page, target);
            EXPECT_FALSE(dead) << page.string() << ": " << *dead
                               << "; install it, or rewrite the link in deploy/installed-links.sed";
            ++count;
        }
    }
    EXPECT_GT(count, 100U);
}

TEST_F(InstalledPages, BeginWithAReadmeThatNamesNoScriptOfTheSources) {
    static const std::regex script(R"((^|[^\w/])(deploy|tests|build|app|\.ci)/[a-z]\S*)");
    const std::string installed = text_of_file(root() / "usr/share/doc/tribus/README.md");
    std::smatch match;
    EXPECT_FALSE(std::regex_search(installed, match, script))
        << match.str() << " is not installed; deploy/installed-readme.sed has to take it out";
    EXPECT_TRUE(std::regex_search(text_of_file(readme()), script)) << "what is taken out";
    // All sections stay, those whose commands are others too.
    EXPECT_EQ(headings_in(installed), headings_in(text_of_file(readme())));
    EXPECT_NE(installed.find("\ntribus demo "), std::string::npos);
    EXPECT_NE(installed.find("\nsudo systemctl enable --now tribus@servos "), std::string::npos);
    EXPECT_EQ(installed.find("sudo apt install"), std::string::npos) << "it is installed";
}

TEST_F(InstalledPages, HaveNoLinksToTheHostOfTheSources) {
    const std::string changes = text_of_file(root() / "usr/share/doc/tribus/CHANGELOG.md");
    EXPECT_EQ(changes.find("/compare/"), std::string::npos);
    EXPECT_NE(changes.find("\n## [0.2.0] - 2026-11-28\n"), std::string::npos);
}

/// Paths of the package that a text names.
std::vector<std::string> paths_in(const std::string& text) {
    static const std::regex form(R"(/usr/(share|lib)/[A-Za-z0-9_.@/-]*tribus[A-Za-z0-9_.@/-]*)");
    std::vector<std::string> paths;
    for (std::sregex_iterator match(text.begin(), text.end(), form), none; match != none; ++match) {
        std::string path = match->str();
        path.erase(path.find_last_not_of(".-/") + 1);
        // `80-can*` stands for files; their folder must exist.
        const bool pattern =
            text[static_cast<std::size_t>(match->position() + match->length()) % text.size()] ==
            '*';
        paths.push_back(pattern ? fs::path(path).parent_path().string() : path);
    }
    return paths;
}

TEST_F(InstalledPages, NameFilesThatAreInstalled) {
    std::vector<fs::path> texts = pages();
    std::size_t count = 0;
    for (const fs::path& page : texts) {
        for (const std::string& path : paths_in(text_of_file(root() / page))) {
            EXPECT_TRUE(has(path)) << page.string() << " names " << path;
            ++count;
        }
    }
    for (const char* source :
         {"deploy/man/tribus.1", "deploy/man/tribus-web.8", "deploy/man/tribus-mqtt.8",
          "deploy/debian/description", "app/doctor/line_advice.cpp"}) {
        for (const std::string& path :
             paths_in(text_of_file(fs::path(TRIBUS_SOURCE_DIR) / source))) {
            EXPECT_TRUE(has(path)) << source << " names " << path;
            ++count;
        }
    }
    EXPECT_GT(count, 10U);
}

}  // namespace
}  // namespace tribus::test::installed_pages_test
