#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "tests/loopback/first_channel.h"

/// The socket that only tells, beside the control socket.
namespace tribus::test::look_socket_test {
namespace {

class LookSocket : public FirstChannel {
  protected:
    std::string socket() const { return folder() / "look"; }
    Program& begin() {
        Program& program = run(write_config(main_job(kPatientInput)));
        expect_first_channel(1100);
        EXPECT_TRUE(program.says("under control of receiver"));
        return program;
    }
    std::string error_of(std::string_view request) const {
        const auto answer = ask_daemon(socket(), request, kPatience);
        return answer ? answer->dump() : answer.error();
    }
};

TEST_F(LookSocket, TellsAllThatTheControlSocketTells) {
    Program& program = begin();
    for (const auto& [request, type] : {std::pair("status", "status"),
                                        {"configuration", "configuration"},
                                        {"metrics", "metrics"},
                                        {"recordings", "recordings"},
                                        {"histograms", "histograms"},
                                        {"watch 1s", "status"}}) {
        const auto told = ask_daemon(socket(), request, kPatience);
        ASSERT_TRUE(told) << request << ": " << told.error();
        EXPECT_EQ((*told)["type"], type);
    }
    struct stat file {};
    ASSERT_EQ(::stat(socket().c_str(), &file), 0);
    EXPECT_EQ(file.st_mode & 0777U, 0660U);
    expect_clean_end(program);
    EXPECT_FALSE(std::filesystem::exists(socket()));
}

TEST_F(LookSocket, RefusesAllThatChangesSomethingAndSaysWhere) {
    Program& program = begin();
    write_config(main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = { fixed = 1300 }"));
    for (const std::string_view request :
         {"reload", "reload 30s", "reload draft 30s", "draft", "confirm", "back", "confirm 1"}) {
        EXPECT_NE(error_of(request).find("is refused: this socket only tells, and what changes "
                                         "something goes to " +
                                         (folder() / "control").string()),
                  std::string::npos)
            << request << ": " << error_of(request);
    }
    EXPECT_EQ(error_of("record"),
              "\"record\" begins a recording, and this socket only tells; allowed here: "
              "\"record N\"");
    EXPECT_FALSE(std::filesystem::exists(folder() / "draft"));
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// A daemon translates whatever becomes of its sockets.
TEST_F(LookSocket, IsLeftOutWhereItsPlaceIsTaken) {
    std::ofstream(socket()) << "mine";
    Program& program = begin();
    EXPECT_TRUE(program.says("no socket that only tells: " + socket() + " exists"));
    expect_clean_end(program);
    EXPECT_TRUE(std::filesystem::exists(socket()));
}

TEST_F(LookSocket, IsEnoughForCommandsThatLook) {
    Program& program = begin();
    for (const char* command : {"status", "monitor"}) {
        Program& asked =
            start({command, "--socket", socket(),
                   std::string_view(command) == "monitor" ? "--once" : "--format=json"});
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            return !asked.runs();
        }));
        EXPECT_EQ(asked.end(), 0) << command << ": " << asked.errors();
    }
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::look_socket_test
