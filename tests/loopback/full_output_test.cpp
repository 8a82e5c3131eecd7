#include <algorithm>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/support/program_help.h"
#include "tests/support/shell.h"

/// Standard output that cannot be written, for every command that has results.
namespace tribus::test::full_output_test {
namespace {

/// A command line, with the path of a file in place of each `@name`; $W is tribus-web, $M
/// tribus-mqtt. A daemon runs with @main.toml, its control socket is @control.
struct Writes {
    std::string name;
    std::string line;
};

const std::vector<Writes> kWrites{
    {"init", "\"$TRIBUS\" init --in @receiver=ibus --out @servos=sbus --listen 0 -"},
    {"monitor", "timeout 60 \"$TRIBUS\" monitor --socket @control"},
    {"monitor_once", "\"$TRIBUS\" monitor --once --format json --socket @control"},
    {"status", "\"$TRIBUS\" status --socket @control"},
    {"status_watch", "timeout 60 \"$TRIBUS\" status --watch --format json --socket @control"},
    {"check", "\"$TRIBUS\" check @main.toml"},
    {"diff", "\"$TRIBUS\" diff @main.toml @other.toml"},
    {"diff_daemon", "\"$TRIBUS\" diff --socket @control @other.toml"},
    {"graph", "\"$TRIBUS\" graph @main.toml"},
    {"demo", "timeout 60 \"$TRIBUS\" demo"},
    {"demo_far_ends", "timeout 60 \"$TRIBUS\" demo --far-ends @demo.toml"},
    {"decode", "\"$TRIBUS\" decode @frame.txt"},
    {"encode", "\"$TRIBUS\" encode --protocol sbus @frames.jsonl"},
    {"simulate", "\"$TRIBUS\" simulate @main.toml --in receiver=@frame.txt --out servos=-"},
    {"record", "\"$TRIBUS\" record --socket @control"},
    {"replay", "timeout 60 \"$TRIBUS\" replay @frame.txt --to pty --period 7ms"},
    {"learn",
     "\"$TRIBUS\" learn @main.toml:receiver --recording @loss.txt --off-at 6s --back-at 10s"},
    {"doctor", "\"$TRIBUS\" doctor"},
    {"dbc", "\"$TRIBUS\" dbc"},
    {"bench", "\"$TRIBUS\" bench --only lateness --seconds 0.5"},
    {"pwm", "\"$TRIBUS\" pwm"},
    {"schema", "\"$TRIBUS\" schema"},
    {"pair", "\"$TRIBUS\" pair --look --state @state"},
    {"pair_list", "\"$TRIBUS\" pair --list --state @state"},
    {"key", "rm -f @new.key; \"$TRIBUS\" key new @new.key"},
    {"key_show", "\"$TRIBUS\" key show @boat.key"},
    {"help", "\"$TRIBUS\" --help"},
    {"help_of_a_command", "\"$TRIBUS\" decode --help"},
    {"version", "\"$TRIBUS\" --version"},
    {"completion", "\"$TRIBUS\" --complete ''"},
    {"web_ports", "echo '{}' | \"$W\" ports"},
    {"web_plot", "\"$W\" plot --to 1000 --width 10 @recordings/*"},
    {"web_help", "\"$W\" serve --help"},
    {"web_version", "\"$W\" -V"},
    {"mqtt_help", "\"$M\" --help"},
    {"mqtt_version", "\"$M\" --version"},
};

/// Commands that print no results: they only say something, on standard error.
const std::set<std::string> kWithoutResults{"run", "reload"};
const std::set<std::string> kWithoutResultsBeside{"serve", "run"};

class FullOutput : public Loopback, public testing::WithParamInterface<Writes> {
  protected:
    void SetUp() override {
        device("receiver");
        device("servos");
        std::filesystem::create_directory(folder() / "state");
        const std::string recorder = "[recorder]\ndirectory = \"@recordings\"\n";
        const std::string config = write_config(main_job(kPatientInput) + recorder, "main.toml");
        write_config(main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = 2") + recorder,
                     "other.toml");
        write_config("{\"channels\":[1500,1500,1000,2000]}\n", "frames.jsonl");
        write_config(
            "20 40 db 05 dc 05 54 05 dc 05 e8 03 d0 07 d2 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 "
            "dc "
            "05 da f3\n",
            "frame.txt");
        write_key("boat.key", '7');
        write_loss();
        run(config);
        ASSERT_TRUE(eventually([&] { return std::filesystem::exists(folder() / "control"); }));
        ASSERT_EQ(ended("\"$TRIBUS\" record --socket @control >/dev/null").status, 0);
    }

    /// 4 s of movement, 2 s still, 4 s of another throttle, 2 s as before.
    void write_loss() {
        std::ofstream file(folder() / "loss.txt");
        for (int step = 0; step < 1200; ++step) {
            Sticks sticks(14, step < 400 ? 1000 + step * 37 % 1001 : 1500);
            sticks[2] = step >= 600 && step < 1000 ? 900 : 1000 + step % 2;
            file << step * 10'000;
            for (const std::uint8_t byte : ibus_bytes(sticks)) {
                constexpr const char* kDigits = "0123456789abcdef";
                file << ' ' << kDigits[byte >> 4] << kDigits[byte & 15];
            }
            file << '\n';
        }
    }

    Ended ended(std::string line) const {
        for (std::size_t at = line.find('@'); at != std::string::npos; at = line.find('@')) {
            line.replace(at, 1, folder().string() + "/");
        }
        return run_in_shell("W='" TRIBUS_WEB "'; M='" TRIBUS_MQTT "'; " + line);
    }
};

TEST_P(FullOutput, EndsWithOneAndSaysSoInOneLine) {
    for (const char* output : {" >/dev/full", " >&-"}) {
        const Ended result = ended(GetParam().line + output + "; exit $?");
        EXPECT_EQ(result.status, 1) << GetParam().line << output << "\n" << result.output;
        EXPECT_EQ(count_of("cannot write to standard output\n", result.output), 1U)
            << GetParam().line << output << "\n"
            << result.output;
    }
}

INSTANTIATE_TEST_SUITE_P(Writes, FullOutput, testing::ValuesIn(kWrites),
                         [](const auto& writes) { return writes.param.name; });

TEST(FullOutputTable, HasEveryCommandThatHasResults) {
    const auto check = [](const std::string& variable, const std::string& program,
                          const std::set<std::string>& without) {
        for (const std::string& command : commands_of(program)) {
            const bool tried = std::ranges::any_of(kWrites, [&](const Writes& writes) {
                return writes.line.find("--help") == std::string::npos &&
                       (writes.line.find(variable + " " + command + " ") != std::string::npos ||
                        writes.line.ends_with(variable + " " + command));
            });
            EXPECT_NE(tried, without.contains(command)) << program << " " << command;
        }
    };
    check("\"$TRIBUS\"", TRIBUS_PROGRAM, kWithoutResults);
    check("\"$W\"", TRIBUS_WEB, kWithoutResultsBeside);
    check("\"$M\"", TRIBUS_MQTT, kWithoutResultsBeside);
}

/// A file that is opened later must not take the place of a closed standard output.
TEST_F(Loopback, AClosedOutputIsNotTheFileThatIsOpenedNext) {
    const std::string file = folder() / "demo.toml";
    const Ended result =
        run_in_shell("\"$TRIBUS\" demo --seconds 0.1 --far-ends '" + file + "' >&-; exit $?");
    EXPECT_EQ(result.status, 1) << result.output;
    std::ifstream stream(file);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_EQ(text.find("now run"), std::string::npos) << text;
    EXPECT_NE(text.find("[pipeline"), std::string::npos) << text;
}

}  // namespace
}  // namespace tribus::test::full_output_test
