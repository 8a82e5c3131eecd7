#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/support/sanitized.h"

namespace tribus::test::ordinary_user_test {
namespace {

/// A user who has just installed the program and has no special rights. Debian's limit for locked
/// memory is 8 MiB, and so is the default stack of a thread.
class OrdinaryUser : public Loopback {
  protected:
    FarEnd& own_device(const std::string& name) {
        FarEnd& far_end = device(name);
        if (::geteuid() == 0) {
            EXPECT_EQ(::chown(far_end.path().c_str(), kOrdinaryUser, kOrdinaryUser), 0);
        }
        return far_end;
    }
    Program& start_as_user(const std::vector<std::string>& arguments,
                           std::size_t most_locked_bytes = ProgramSettings{}.most_locked_bytes) {
        return start(arguments, of_ordinary_user(most_locked_bytes));
    }
};

TEST_F(OrdinaryUser, RunsTheDemo) {
    Program& program = start_as_user({"demo", "--seconds", "2"});
    EXPECT_EQ(program.end(), 0) << program.errors() << program.output();
    EXPECT_EQ(count_of("lost:     0\n", program.output()), 1U) << program.output();
    EXPECT_EQ(count_of("the data thread has no real-time priority", program.errors()), 1U)
        << program.errors();
}

/// Containers and older systems have such a limit.
TEST_F(OrdinaryUser, RunsTheDemoWhereNearlyNothingMayBeLockedAndIsToldSo) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer locks no memory and says that it has";
    }
    for (const std::size_t most : {std::size_t{64} << 10U, std::size_t{0}}) {
        Program& program = start_as_user({"demo", "--seconds", "1"}, most);
        EXPECT_EQ(program.end(), 0) << program.errors() << program.output();
        EXPECT_EQ(count_of("lost:     0\n", program.output()), 1U) << program.output();
        EXPECT_EQ(count_of("not all memory is locked", program.errors()), 1U) << most << "\n"
                                                                              << program.errors();
    }
}

TEST_F(OrdinaryUser, RunsAConfigurationAndIsToldOnceWhatOfRealTimeThereIsNot) {
    FarEnd& receiver = own_device("receiver");
    FarEnd& servo_wire = own_device("servos");
    ServoBank servos(servo_wire);
    const std::string config = write_config(main_job(kPatientInput));
    Program& program = start_as_user({"run", config});
    ASSERT_TRUE(program.says("started")) << program.errors();
    const Sticks sticks(14, 1600);
    const SbusSight wanted = sbus_sight_of(sticks);
    Repeater repeater(receiver, ibus_bytes(sticks));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        const auto seen = servos.listen();
        return std::any_of(seen.begin(), seen.end(), [&](const SbusSight& sight) {
            return sight.good() && same_channels(sight, wanted);
        });
    })) << program.errors();
    EXPECT_EQ(count_of("the data thread has no real-time priority", program.errors()), 1U)
        << program.errors();
    EXPECT_EQ(count_of("[error]", program.errors()), 0U) << program.errors();

    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded")) << program.errors();
    program.signal(SIGTERM);
    EXPECT_EQ(program.end(), 0) << program.errors();
}

/// If memory that is allocated later were locked too, the reload would fail.
TEST_F(OrdinaryUser, TakesMoreMemoryAtAReloadThanMayBeLocked) {
    own_device("receiver");
    own_device("servos");
    Program& program = start_as_user({"run", write_config(main_job(kPatientInput))});
    ASSERT_TRUE(program.says("started")) << program.errors();
    // 16 MiB for each of the two ports.
    write_config("[recorder]\nmemory = 16384\ndirectory = \"@recordings\"\n" +
                 main_job(kPatientInput));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded")) << program.errors();
    EXPECT_EQ(count_of("of memory for a port", program.errors()), 0U) << program.errors();
    program.signal(SIGTERM);
    EXPECT_EQ(program.end(), 0) << program.errors();
}

/// The data path uses a few MiB, so the limit is enough for it.
TEST_F(OrdinaryUser, HasWhatTheDataPathTouchesInMemory) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer locks no memory";
    }
    own_device("receiver");
    own_device("servos");
    Program& program = start_as_user({"run", write_config(main_job(kPatientInput))});
    ASSERT_TRUE(program.says("started")) << program.errors();
    constexpr long kLimitKib = 8 * 1024;
    // Code and pointers of 32 bits are smaller: 1,880 KiB were seen on armhf.
    constexpr long kLeastKib = sizeof(void*) == 8 ? 2048 : 1536;
    EXPECT_GT(program.memory_kib("VmLck"), kLeastKib);
    EXPECT_LE(program.memory_kib("VmLck"), kLimitKib);
    EXPECT_EQ(count_of("memory is locked", program.errors()), 0U) << program.errors();
}

TEST_F(OrdinaryUser, IsRefusedWhereTheConfigurationRequiresRealTime) {
    own_device("receiver");
    own_device("servos");
    Program& program =
        start_as_user({"run", write_config("[runtime]\nrealtime = \"require\"\n" + main_job())});
    EXPECT_EQ(program.end(), 1) << program.errors();
    EXPECT_EQ(count_of("the data thread has no real-time priority", program.errors()), 1U)
        << program.errors();
}

}  // namespace
}  // namespace tribus::test::ordinary_user_test
