#include "app/client/control_socket.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::control_socket_test {
namespace {

SocketDirectories directories(const std::string& runtime, const std::string& user, bool root) {
    return {.runtime_directory = runtime,
            .user_directory = user,
            .system_directory = "/run",
            .root = root};
}

TEST(DefaultSocket, StandsInTheDirectoryOfTheService) {
    EXPECT_EQ(default_socket(directories("/run/tribus/car", "/run/user/0", true), "/etc/car.toml"),
              "/run/tribus/car/control");
}

TEST(DefaultSocket, HasTheNameOfTheConfiguration) {
    EXPECT_EQ(default_socket(directories("", "", true), "/etc/tribus/car.toml"),
              "/run/tribus/car.sock");
    EXPECT_EQ(default_socket(directories("", "/run/user/1000", false), "car.toml"),
              "/run/user/1000/tribus/car.sock");
}

TEST(DefaultSocket, IsNoneWhereThereIsNoPlace) {
    EXPECT_EQ(default_socket(directories("", "", false), "car.toml"), std::nullopt);
}

/// The folder of a service is for its user and group; who may only look has another folder.
TEST(LookSocket, StandsInAFolderOfItsOwnForAService) {
    EXPECT_EQ(look_socket("/run/tribus/car/control"), "/run/tribus-look/car.look");
}

TEST(LookSocket, StandsBesideTheControlSocketElsewhere) {
    EXPECT_EQ(look_socket("/run/tribus/car.sock"), "/run/tribus/car.look");
    EXPECT_EQ(look_socket("/run/user/1000/tribus/car.sock"), "/run/user/1000/tribus/car.look");
    EXPECT_EQ(look_socket("/tmp/boat/control"), "/tmp/boat/look");
    EXPECT_EQ(look_socket("/tmp/mine"), "/tmp/mine.look");
    EXPECT_EQ(look_socket("car.sock"), "car.look");
}

class Listener : public testing::Test {
  protected:
    test::TemporaryFolder folder_;
    std::string path_ = folder_ / "inner/car.sock";
};

TEST_F(Listener, MakesItsFolderAndIsForUserAndGroupOnly) {
    const auto listener = LocalListener::open(path_);
    ASSERT_TRUE(listener) << listener.error();
    struct stat file {};
    ASSERT_EQ(::stat(path_.c_str(), &file), 0);
    EXPECT_EQ(file.st_mode & 0777U, 0660U);
    EXPECT_TRUE(connect_local(path_));
}

TEST_F(Listener, TakesItsFileAway) {
    { const auto listener = LocalListener::open(path_); }
    EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(Listener, LeavesTheFileOfItsSuccessor) {
    auto first = std::make_unique<LocalListener>(std::move(*LocalListener::open(path_)));
    first->descriptor().reset();
    const auto second = LocalListener::open(path_);
    ASSERT_TRUE(second);
    first.reset();
    EXPECT_TRUE(connect_local(path_));
}

TEST_F(Listener, TakesThePlaceOfOneThatIsDead) {
    std::filesystem::path dead = path_ + ".dead";
    {
        auto listener = LocalListener::open(path_);
        std::filesystem::create_hard_link(path_, dead);
    }
    std::filesystem::rename(dead, path_);
    EXPECT_FALSE(connect_local(path_));
    const auto listener = LocalListener::open(path_);
    ASSERT_TRUE(listener) << listener.error();
    EXPECT_TRUE(connect_local(path_));
}

TEST_F(Listener, RefusesThePlaceOfOneThatLives) {
    const auto first = LocalListener::open(path_);
    const auto second = LocalListener::open(path_);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(),
              "another program answers on " + path_ +
                  ": a second daemon of that name? Give this one another path with --socket");
    EXPECT_TRUE(connect_local(path_));
}

TEST_F(Listener, RefusesThePlaceOfAFile) {
    std::ofstream(folder_ / "file") << "mine";
    const auto listener = LocalListener::open(folder_ / "file");
    ASSERT_FALSE(listener);
    EXPECT_EQ(listener.error(),
              (folder_ / "file") + " exists and is not a socket; choose another --socket");
}

TEST_F(Listener, RefusesAPathThatIsTooLong) {
    EXPECT_FALSE(LocalListener::open(folder_ / std::string(200, 'x')));
}

TEST_F(Listener, IsFoundByItsName) {
    const auto car = LocalListener::open(folder_ / "tribus/car.sock");
    const auto boat = LocalListener::open(folder_ / "tribus/boat/control");
    const auto plane = LocalListener::open(folder_ / "tribus-plane/control");
    const auto found = find_sockets({.runtime_directory = "",
                                     .user_directory = "",
                                     .system_directory = folder_.path().string(),
                                     .root = false});
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[0].name, "boat");
    EXPECT_EQ(found[1].name, "car");
    EXPECT_EQ(found[2].name, "plane");
    EXPECT_EQ(found[1].path, folder_ / "tribus/car.sock");
}

TEST_F(Listener, IsFoundWhereItOnlyTells) {
    const auto car = LocalListener::open(folder_ / "tribus/car.look");
    const auto boat = LocalListener::open(folder_ / "tribus-look/boat.look");
    const auto plane = LocalListener::open(folder_ / "tribus-plane/look");
    const auto changes = LocalListener::open(folder_ / "tribus/car.sock");
    const auto old = LocalListener::open(folder_ / "tribus/old/control");
    const SocketDirectories places{.runtime_directory = "",
                                   .user_directory = "",
                                   .system_directory = folder_.path().string(),
                                   .root = false};
    const auto found = find_telling_sockets(places);
    ASSERT_EQ(found.size(), 4U);
    EXPECT_EQ(found[0].path, folder_ / "tribus-look/boat.look");
    EXPECT_EQ(found[1].name, "car");
    EXPECT_EQ(found[1].path, folder_ / "tribus/car.look");
    EXPECT_EQ(found[2].path, folder_ / "tribus/old/control") << "a daemon that has no other";
    EXPECT_EQ(found[3].name, "plane");
    ASSERT_EQ(find_sockets(places).size(), 2U);
}

TEST_F(Listener, IsNotFoundWhereNobodyAnswers) {
    std::filesystem::create_directories(folder_ / "tribus");
    std::ofstream(folder_ / "tribus/car.sock") << "";
    EXPECT_TRUE(find_sockets({.runtime_directory = "",
                              .user_directory = "",
                              .system_directory = folder_.path().string(),
                              .root = false})
                    .empty());
}

}  // namespace
}  // namespace tribus::control_socket_test
