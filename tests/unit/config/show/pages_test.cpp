#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/pages.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

/// What README.md and docs/ show as configuration is what `tribus check` accepts.
namespace tribus::test::pages_test {
namespace {

namespace fs = std::filesystem;

bool has_table(const std::string& text, const std::string& header) {
    return ("\n" + text).find("\n" + header) != std::string::npos;
}

std::string file_in_title(const std::string& title) {
    static const std::regex form("^`([A-Za-z0-9_.-]+)`");
    std::smatch match;
    return std::regex_search(title, match, form) ? match[1].str() : "";
}

/// Inputs or outputs that a text has tables for, in its order.
std::vector<std::string> ports_in(const std::string& text, const std::string& kind) {
    const std::regex form("\\[" + kind + R"re(\.(\w+)\][^\n]*\n(?:protocol *= "(\w+)")?)re");
    std::vector<std::string> names;
    for (std::sregex_iterator match(text.begin(), text.end(), form), none; match != none; ++match) {
        // What a pipeline has no channels for.
        if ((*match)[2] != "sensors" && (*match)[1] != "dash") {
            names.push_back((*match)[1]);
        }
    }
    return names;
}

std::string quoted(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        text += (text.empty() ? "\"" : ", \"") + name + "\"";
    }
    return "[" + text + "]";
}

/// A table that a snippet names and leaves out.
struct LeftOut {
    std::string table;
    std::string_view names;  ///< what in the snippet names it
    std::string lines;
};

const std::vector<LeftOut>& tables_that_snippets_leave_out() {
    static const std::vector<LeftOut> tables{
        {"input.receiver", R"("receiver"|input\.receiver)", "protocol = \"ibus\"\ndevice = \"a\""},
        {"input.main", R"("main"|input\.main)", "protocol = \"ibus\"\ndevice = \"b\""},
        {"input.backup", R"("backup"|input\.backup)", "protocol = \"sbus\"\ndevice = \"c\""},
        {"input.third", R"("third"|input\.third)", "protocol = \"ibus\"\ndevice = \"d\""},
        {"input.tail", R"("tail"|input\.tail)", "protocol = \"ibus\"\ndevice = \"e\""},
        {"output.servos", R"("servos"|output\.servos)", "protocol = \"sbus\"\ndevice = \"f\""},
        {"output.bus", R"("bus"|output\.bus)", "protocol = \"can\"\ninterface = \"can0\""},
        {"values.battery", R"("battery\.)",
         "interface = \"can0\"\ndbc = \"telemetry.dbc\"\nmessage = \"Battery\""},
        {"sensor_bus.telemetry", R"(sensor_bus\.telemetry)", "device = \"g\"\nrole = \"sensor\""},
    };
    return tables;
}

/// A snippet with the tables that it names and leaves out, and with the pipeline that it needs.
std::string completed(std::string text) {
    for (const LeftOut& left_out : tables_that_snippets_leave_out()) {
        const std::string header = "[" + left_out.table + "]";
        if (!has_table(text, header) &&
            std::regex_search(text, std::regex(std::string(left_out.names)))) {
            text += "\n" + header + "\n" + left_out.lines + "\n";
        }
    }
    if (has_table(text, "[pipeline.main]")) {
        return text;
    }
    if (ports_in(text, "input").empty()) {
        text += "\n[input.receiver]\nprotocol = \"ibus\"\ndevice = \"a\"\n";
    }
    if (ports_in(text, "output").empty()) {
        text += "\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"f\"\n";
    }
    return text + "\n[pipeline.main]\nfrom = " + quoted(ports_in(text, "input")) +
           "\nto = " + quoted(ports_in(text, "output")) + "\n";
}

bool is_complete(const std::string& text) {
    return has_table(text, "[input.") && has_table(text, "[output.") &&
           has_table(text, "[pipeline.");
}

class Pages : public ::testing::Test {
  protected:
    /// The DBC files of the examples, those that pages print below their names, and key files.
    Pages() {
        for (const char* const name : {"drone.key", "boat.key"}) {
            fs::permissions(folder_.write(name, std::string(64, '7')), fs::perms::owner_read);
        }
        const auto examples = fs::path(TRIBUS_SOURCE_DIR) / "config" / "examples";
        for (const auto& entry : fs::directory_iterator(examples)) {
            if (entry.path().extension() == ".dbc") {
                fs::copy_file(entry.path(), folder_ / entry.path().filename().string());
            }
        }
        for (const fs::path& page : manual_pages()) {
            for (const Fence& fence : fences_of(page)) {
                const std::string name = file_in_title(fence.title);
                if (name.ends_with(".dbc")) {
                    folder_.write(name, fence.text);
                }
                if (fence.language == "toml") {
                    snippets_.push_back(fence);
                }
            }
        }
    }

    std::vector<std::string> mistakes_of(const std::string& text) const {
        return mistakes_in(std::regex_replace(text, std::regex("/etc/tribus/keys/"), ""),
                           folder_ / "t.toml");
    }

    TemporaryFolder folder_;
    std::vector<Fence> snippets_;
};

TEST_F(Pages, ShowCompleteConfigurationsThatAreAccepted) {
    std::size_t found = 0;
    for (const Fence& fence : snippets_) {
        if (is_complete(fence.text)) {
            ++found;
            EXPECT_EQ(mistakes_of(fence.text), std::vector<std::string>{}) << fence.where;
        }
    }
    EXPECT_GE(found, 6U);
}

TEST_F(Pages, ShowPartsOfConfigurationsThatAreAcceptedWithWhatTheyLeaveOut) {
    std::size_t found = 0;
    for (const Fence& fence : snippets_) {
        if (!is_complete(fence.text)) {
            ++found;
            const std::string text = completed(fence.text);
            EXPECT_EQ(mistakes_of(text), std::vector<std::string>{}) << fence.where << "\n" << text;
        }
    }
    EXPECT_GE(found, 20U);
}

/// Whoever copies one block of the page has a configuration that works.
TEST_F(Pages, ShowConfigurationsOfTelemetryThatAreAcceptedAlone) {
    std::size_t found = 0;
    for (const Fence& fence : snippets_) {
        if (fence.where.starts_with("telemetry.md")) {
            ++found;
            EXPECT_EQ(mistakes_of(fence.text), std::vector<std::string>{}) << fence.where;
        }
    }
    EXPECT_GE(found, 11U);
}

/// The README leads to a first configuration of one's own: its nine lines with what it adds.
TEST_F(Pages, TheReadmeShowsOneConfigurationInPieces) {
    std::string text;
    for (const Fence& fence : fences_of(readme())) {
        text += fence.language == "toml" ? fence.text + "\n" : "";
    }
    EXPECT_EQ(mistakes_of(text), std::vector<std::string>{}) << text;
    EXPECT_TRUE(is_complete(text));
    EXPECT_TRUE(has_table(text, "[pipeline.main.failsafe]\npreset "));
    EXPECT_TRUE(has_table(text, "[pipeline.main.channels]"));
}

TEST(ReadmeSize, IsOnePage) {
    EXPECT_LE(fs::file_size(readme()), 8000U);
}

}  // namespace
}  // namespace tribus::test::pages_test
