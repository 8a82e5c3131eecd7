#include <array>
#include <cstddef>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/pages.h"

/// The version of CMakeLists.txt, the versions of CHANGELOG.md and the supported one of SECURITY.md
/// tell the same.
namespace tribus::test::version_test {
namespace {

using Version = std::array<int, 3>;

const std::string kChanges =
    text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "CHANGELOG.md");

Version version_of(const std::smatch& match) {
    return {std::stoi(match[1]), std::stoi(match[2]), std::stoi(match[3])};
}

std::string text_of(const Version& version) {
    return std::to_string(version[0]) + "." + std::to_string(version[1]) + "." +
           std::to_string(version[2]);
}

/// What CMake calls this version.
Version present() {
    const std::string text =
        text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "CMakeLists.txt");
    std::smatch match;
    const std::regex form(R"(project\(tribus VERSION (\d+)\.(\d+)\.(\d+) )");
    return std::regex_search(text, match, form) ? version_of(match) : Version{};
}

struct Release {
    Version version{};
    std::string day;
};

/// The releases of the changelog, in its order.
std::vector<Release> releases() {
    static const std::regex form(R"(\n## \[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d\d-\d\d)(?=\n))");
    std::vector<Release> found;
    for (std::sregex_iterator match(kChanges.begin(), kChanges.end(), form), none; match != none;
         ++match) {
        found.push_back({version_of(*match), (*match)[4]});
    }
    return found;
}

/// What the changelog says of changes that are in no release yet.
std::string unreleased() {
    const std::string title = "\n## [Unreleased]\n";
    const std::size_t begin = kChanges.find(title);
    if (begin == std::string::npos) {
        return {};
    }
    const std::size_t first = begin + title.size();
    return kChanges.substr(first, kChanges.find("\n## [", first) - first);
}

TEST(Changelog, BeginsWithWhatIsUnreleasedAndGoesBackFromTheNewestRelease) {
    ASSERT_GE(releases().size(), 2U);
    const std::size_t begin = kChanges.find("\n## ");
    EXPECT_EQ(kChanges.substr(begin, 17), "\n## [Unreleased]\n");
    std::size_t sections = 1;
    for (std::size_t at = begin + 1; (at = kChanges.find("\n## ", at)) != std::string::npos; ++at) {
        ++sections;
    }
    EXPECT_EQ(sections, releases().size() + 1) << "a heading is not \"## [1.2.3] - 2026-12-31\"";
    for (std::size_t i = 1; i < releases().size(); ++i) {
        EXPECT_GT(releases()[i - 1].version, releases()[i].version);
        EXPECT_GE(releases()[i - 1].day, releases()[i].day);
    }
}

TEST(Changelog, HasTheVersionOfTheBuildOrWhatIsToBecomeIt) {
    ASSERT_FALSE(releases().empty());
    const Version newest = releases().front().version;
    EXPECT_GE(present(), newest) << "CMakeLists.txt has an older version than the changelog";
    if (present() != newest) {
        EXPECT_NE(unreleased().find("\n- "), std::string::npos)
            << text_of(present()) << " is no release of the changelog, and nothing is unreleased";
    }
}

TEST(Changelog, LinksEachVersionToWhatChangedInIt) {
    const auto all = releases();
    const std::string newest = "v" + text_of(all.front().version);
    EXPECT_NE(kChanges.find("\n[Unreleased]: ../../compare/" + newest + "...HEAD\n"),
              std::string::npos);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string version = text_of(all[i].version);
        const std::string link =
            i + 1 == all.size()
                ? "../../tree/v" + version
                : "../../compare/v" + text_of(all[i + 1].version) + "...v" + version;
        EXPECT_NE(kChanges.find("\n[" + version + "]: " + link + "\n"), std::string::npos) << link;
    }
}

TEST(SecurityPolicy, SupportsThisVersionAndNoOther) {
    const std::string policy =
        text_of_file(std::filesystem::path(TRIBUS_SOURCE_DIR) / "SECURITY.md");
    static const std::regex form(R"((\d+\.\d+\.x))");
    std::vector<std::string> supported;
    for (std::sregex_iterator match(policy.begin(), policy.end(), form), none; match != none;
         ++match) {
        supported.push_back((*match)[1]);
    }
    EXPECT_EQ(supported, std::vector<std::string>{std::to_string(present()[0]) + "." +
                                                  std::to_string(present()[1]) + ".x"});
}

}  // namespace
}  // namespace tribus::test::version_test
