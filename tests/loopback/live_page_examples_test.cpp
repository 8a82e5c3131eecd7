#include <grp.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <regex>
#include <string>

#include "tests/support/page_examples.h"
#include "tests/support/shell.h"

/// What docs/ shows of commands that look at something alive, such as a port or a daemon. Numbers
/// differ at each run, so the words are compared: docs/commands.md, "Files for the examples", with
/// the two pseudo-terminals.
namespace tribus::test::live_page_examples_test {
namespace {

/// A busy machine may disturb a run: a command has so many tries to print what the page shows.
constexpr int kTries = 4;

std::string servos_toml() {
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"receiver\"\n"
           "[output.servos]\nprotocol = \"sbus\"\ndevice = \"servos\"\n"
           "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";
}

class LivePageExamples : public testing::Test {
  protected:
    LivePageExamples() {
        const std::string place = folder_ / "";
        std::string text = servos_toml();
        for (const std::string name : {"receiver", "servos"}) {
            const std::string line = "device = \"" + name + "\"";
            text.replace(text.find(line), line.size(), "device = \"" + place + name + "\"");
        }
        folder_.write("servos.toml", text);
        folder_.write("new.toml",
                      text + "[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n");
    }

    /// Runs `commands` while a receiver and servos play at the ports `receiver` and `servos`, and
    /// an SBUS receiver in failsafe at `lost`. All of them end with it.
    std::string run_at_ports(const std::string& commands) const {
        return run_in_shell("cd '" + folder_ / "" + R"('
tribus() { "$TRIBUS" "$@"; }
sticks() { awk -v flag="$1" 'BEGIN { for (i = 0; i < 260; i++)
    printf "{\"t_us\":%d,\"channels\":[%d,1500,1000,1500],\"failsafe\":%s}\n", i * 7700,
        flag == "true" ? 1500 : 1500 + 400 * sin(i * 6.2832 / 130) + 0.5, flag }'; }
sticks false | tribus encode --protocol ibus --format timed > receiver.txt
sticks true | tribus encode --protocol sbus --format timed > lost.txt
played=""
play() {
    "$TRIBUS" replay "$1" --to pty --link "$2" --loop > "$2.log" 2>&1 &
    played="$played $!"
}
play receiver.txt receiver
play receiver.txt servos
play lost.txt lost
wait_for() {
    for try in $(seq 500); do
        "$@" && return
        sleep 0.02
    done
}
for port in receiver servos lost; do
    wait_for test -e "$port"
done
with_daemon() {
    "$TRIBUS" run --socket "$PWD/control" "${file:-servos.toml}" > run.log 2>&1 &
    daemon=$!
    wait_for grep -q "under control" run.log
    sleep 0.3
    "$@"
    kill "$daemon"
    wait "$daemon"
}
)" + commands + "\nkill $played\nwait $played 2>/dev/null\n")
            .output;
    }
    /// The output that pages show of the command, wherever that is.
    static std::string shown(const std::string& command) {
        for (const PageExample& example : examples_of_the_program()) {
            if (example.command == command) {
                return example.output;
            }
        }
        ADD_FAILURE() << "no page shows `" << command << "`";
        return "";
    }
    static void expect_words(const std::string& command, const std::string& shown,
                             const std::function<std::string()>& run) {
        std::string got;
        for (int number = 0; number < kTries; ++number) {
            got = run();
            if (prints_the_words(shown, got)) {
                return;
            }
        }
        ADD_FAILURE() << "$ " << command << "\nprints\n" << got << "and a page shows\n" << shown;
    }
    /// The page shows what `commands` print, which do the same as `command` in this folder.
    void expect_at_ports(const std::string& command, const std::string& commands) const {
        expect_words(command, shown(command), [&] { return run_at_ports(commands); });
    }

    TemporaryFolder folder_;
};

TEST_F(LivePageExamples, ShowWhatInitHears) {
    expect_at_ports("tribus init --in /tmp/receiver --out /tmp/servos rc.toml",
                    "tribus init --in \"$PWD/receiver\" --out \"$PWD/servos\" --force rc.toml");
}

TEST_F(LivePageExamples, ShowWhatDoctorHears) {
    expect_at_ports("tribus doctor /tmp/receiver", "tribus doctor \"$PWD/receiver\"");
    expect_at_ports("tribus doctor /dev/pts/0", "tribus doctor \"$PWD/lost\"");
}

TEST_F(LivePageExamples, ShowWhatADaemonTells) {
    expect_at_ports("tribus monitor --once",
                    "with_daemon tribus monitor --once --socket \"$PWD/control\"");
    expect_at_ports(
        "tribus status",
        "file=\"$PWD/servos.toml\"; with_daemon tribus status --socket \"$PWD/control\"");
    expect_at_ports("tribus diff new.toml",
                    "with_daemon tribus diff --socket \"$PWD/control\" new.toml");
}

TEST_F(LivePageExamples, ShowTheLogOfARun) {
    expect_at_ports("tribus run servos.toml",
                    "with_daemon true; grep ' info ' run.log | sed '$i ^C'");
}

TEST_F(LivePageExamples, ShowARecordingAndItsReplay) {
    expect_at_ports(
        "tribus record /tmp/receiver --protocol ibus --out got.txt --for 2s",
        "tribus record \"$PWD/receiver\" --protocol ibus --out got.txt --for 2s --force");
    expect_at_ports(
        "tribus replay receiver.txt --to pty --link /tmp/receiver --loop",
        "\"$TRIBUS\" replay receiver.txt --to pty --link \"$PWD/again\" --loop > again.log 2>&1 & "
        "again=$!\nwait_for grep -q waiting again.log\ncat again > copy 2> /dev/null & "
        "sleep 1; kill $again; wait $again\n"
        "sed 's/^sent/^C\\n&/' again.log");
}

TEST_F(LivePageExamples, ShowANewKey) {
    if (::geteuid() == 0 && ::getgrnam("tribus") != nullptr) {
        GTEST_SKIP() << "the page shows what others than root are told, or before the package is "
                        "installed";
    }
    expect_at_ports("tribus key new boat.key", "rm -f boat.key; tribus key new boat.key");
}

TEST_F(LivePageExamples, ShowADemo) {
    const std::string command = "tribus demo --seconds 8 | cat";
    expect_words(command, shown(command),
                 [] { return run_in_shell("\"$TRIBUS\" demo --seconds 8 | cat").output; });
}

TEST_F(LivePageExamples, ShowAMeasurement) {
    // Users have other rights, and machines compare otherwise with a bare relay.
    const auto without_verdict = [](const std::string& text) {
        static const std::regex verdict("better than|as good as|nearly as good as|worse than");
        static const std::regex right("not permitted here: [^\n]*\n");
        return std::regex_replace(std::regex_replace(text, right, ""), verdict, "beside");
    };
    const std::string options = "bench --only latency --seconds 1 --require p99=1us";
    const std::string command = "sudo tribus " + options;
    expect_words(command, without_verdict(shown(command)),
                 [&] { return without_verdict(run_in_shell("\"$TRIBUS\" " + options).output); });
}

}  // namespace
}  // namespace tribus::test::live_page_examples_test
