#include "app/epoch/epoch_file.h"

#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"
#include "transports/codecs/authenticated/broadcast.h"

/// The file of `epoch`, and what is left of it after a program was killed.
namespace tribus::test::epoch_file_test {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> disk_hangs = false;

constexpr NumberBlocks kBlocks{.block = 100, .ahead = 50};
/// Steps of 10 us that an end reserves when it starts: 20 s, and 12 hours.
constexpr std::uint64_t kOfReceiver = 2'000'000;
constexpr std::uint64_t kOfSender = 4'294'967'296;

constexpr Duration kPatience = std::chrono::seconds(30);

class OpenEpoch : public ::testing::Test {
  protected:
    /// A child of fork must not inherit the lock of a thread that still closes a file.
    void TearDown() override { EXPECT_TRUE(EpochFile::wait_until_closed(kPatience)); }

    static std::string text_of(std::uint64_t number) {
        return "tribus epoch 1\nnext " + std::to_string(number) + "\n";
    }
    std::shared_ptr<EpochFile> file() const { return EpochFile::of(folder_ / "boat.epoch"); }
    std::string stored() const { return folder_.read("boat.epoch"); }
    static std::string error_of(EpochFile& file) {
        const auto opened = file.open(SettingScope::input);
        return opened ? "none" : opened.error();
    }
    std::string error_with(const std::string& content) const {
        folder_.write("boat.epoch", content);
        return error_of(*file());
    }
    /// Waits for the thread of the file.
    static bool comes(const auto& condition) { return seen_within(condition, kPatience); }

    TemporaryFolder folder_;
};

TEST_F(OpenEpoch, GivesNoNumberBefore) {
    EXPECT_FALSE(file()->use(0, kBlocks));
    EXPECT_FALSE(fs::exists(folder_ / "boat.epoch"));
}

TEST_F(OpenEpoch, StoresWhatItReservesBeforeItGivesIt) {
    folder_.write("boat.epoch", text_of(5000));
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    EXPECT_EQ(epoch->next(), 5000U);
    EXPECT_EQ(stored(), text_of(5000 + kOfReceiver));
    EXPECT_TRUE(epoch->use(5000 + kOfReceiver - 1, kBlocks));
    EXPECT_FALSE(epoch->use(5000 + kOfReceiver + 1000, kBlocks));
}

TEST_F(OpenEpoch, StoresMoreWhereMoreIsWanted) {
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    constexpr std::uint64_t kFar = 1'000'000'000'000;
    EXPECT_FALSE(epoch->use(kFar, kBlocks));
    EXPECT_TRUE(comes([&] { return epoch->use(kFar, kBlocks); }));
    EXPECT_EQ(stored(), text_of(kFar + kBlocks.block));
}

/// `tribus run` once as root, in the folder of the service.
TEST_F(OpenEpoch, LeavesFilesOfTheFoldersOwnerWhereRootRanIt) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root gives files away";
    }
    constexpr uid_t kService = 65534;
    ASSERT_EQ(::chown(folder_.path().c_str(), kService, kService), 0);
    ASSERT_TRUE(file()->open(SettingScope::input));
    for (const char* name : {"boat.epoch", "boat.epoch.lock"}) {
        struct stat told {};
        ASSERT_EQ(::stat((folder_ / name).c_str(), &told), 0) << name;
        EXPECT_EQ(told.st_uid, kService) << name;
    }
}

/// The child ends as by SIGKILL: nothing of it is destroyed.
TEST_F(OpenEpoch, BeginsAfterAllThatMayHaveBeenUsedWhereItsProgramWasKilled) {
    const pid_t child = ::fork();
    if (child == 0) {
        const auto epoch = file();
        ::_exit(epoch->open(SettingScope::input) && epoch->use(70, kBlocks) ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    EXPECT_EQ(epoch->next(), kOfReceiver);
}

TEST_F(OpenEpoch, BeginsWhereItsProgramEnded) {
    {
        const auto epoch = file();
        ASSERT_TRUE(epoch->open(SettingScope::input));
        EXPECT_TRUE(epoch->use(70, kBlocks));
    }
    EXPECT_TRUE(EpochFile::wait_until_closed(kPatience));
    EXPECT_EQ(stored(), text_of(71));
}

/// From its beginning to `answer`, who waits for the disk does not come back.
class HangingDisk {
  public:
    HangingDisk() { disk_hangs = true; }
    HangingDisk(const HangingDisk&) = delete;
    HangingDisk& operator=(const HangingDisk&) = delete;
    ~HangingDisk() { answer(); }
    void answer() { disk_hangs = false; }
};

TEST_F(OpenEpoch, IsLeftByAReloadThatDoesNotWaitForItsDisk) {
    auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    HangingDisk disk;
    std::atomic<bool> left = false;
    std::thread reload([&] {
        epoch.reset();
        left = true;
    });
    EXPECT_TRUE(comes([&] { return left.load(); }));
    EXPECT_FALSE(EpochFile::wait_until_closed(std::chrono::milliseconds(20)));
    disk.answer();
    reload.join();
    EXPECT_TRUE(EpochFile::wait_until_closed(kPatience));
}

/// What its thread was about to store when it was left names numbers that it now must not give.
TEST_F(OpenEpoch, GoesOnWithTheNextConfigurationOnceItCouldStoreAgain) {
    auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    EXPECT_TRUE(epoch->use(70, kBlocks));
    HangingDisk disk;
    epoch.reset();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input)) << "it still has the lock";
    EXPECT_EQ(epoch->next(), 71U);
    EXPECT_FALSE(epoch->use(71, kBlocks));
    disk.answer();
    EXPECT_TRUE(comes([&] { return epoch->use(71, kBlocks); }));
    EXPECT_NE(stored(), text_of(71));
}

/// The same for the numbers of a key.
TEST_F(OpenEpoch, GoesOnForAKeyOnceItCouldStoreAgain) {
    auto epoch = file();
    NumberReservation* numbers = &epoch->of_key(0xAA);
    ASSERT_TRUE(epoch->open(SettingScope::input));
    EXPECT_TRUE(numbers->use(70, kBlocks));
    HangingDisk disk;
    epoch.reset();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    epoch = file();
    numbers = &epoch->of_key(0xAA);
    EXPECT_EQ(numbers->next(), 71U);
    EXPECT_FALSE(numbers->use(71, kBlocks));
    disk.answer();
    EXPECT_TRUE(comes([&] { return numbers->use(71, kBlocks); }));
}

TEST_F(OpenEpoch, StoresNoHigherNumberThanItReads) {
    folder_.write("boat.epoch", text_of(kEndOfNumbers - 10));
    {
        const auto epoch = file();
        ASSERT_TRUE(epoch->open(SettingScope::input));
        EXPECT_EQ(stored(), text_of(kEndOfNumbers));
        EXPECT_TRUE(epoch->use(kEndOfNumbers - 1, kBlocks));
        EXPECT_FALSE(epoch->use(kEndOfNumbers, kBlocks));
        EXPECT_FALSE(epoch->use(~std::uint64_t{0} - 20, kBlocks)) << "sums would overflow";
        EXPECT_EQ(epoch->next(), kEndOfNumbers);
    }
    ASSERT_TRUE(EpochFile::wait_until_closed(kPatience));
    EXPECT_EQ(stored(), text_of(kEndOfNumbers));
    const auto again = file();
    ASSERT_TRUE(again->open(SettingScope::input));
    EXPECT_EQ(again->next(), kEndOfNumbers);
}

TEST_F(OpenEpoch, GoesNeverBack) {
    folder_.write("boat.epoch", text_of(5000));
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    epoch->use(4000, kBlocks);
    EXPECT_EQ(epoch->next(), 5000U);
    constexpr std::uint64_t kFar = 1'000'000'000'000;
    EXPECT_FALSE(epoch->use(kFar, kBlocks));
    // A lower number that comes before the higher one is stored.
    EXPECT_FALSE(epoch->use(kFar - 100'000, kBlocks));
    EXPECT_TRUE(comes([&] { return epoch->use(kFar, kBlocks); }));
    EXPECT_EQ(epoch->next(), kFar + 1);
}

TEST_F(OpenEpoch, HasNumbersOfItsOwnForEachKey) {
    folder_.write("boat.epoch", text_of(5000) + "key 000000aa 7000\n");
    {
        const auto epoch = file();
        NumberReservation& named = epoch->of_key(0xAA);
        NumberReservation& other = epoch->of_key(0xBB);
        ASSERT_TRUE(epoch->open(SettingScope::input));
        EXPECT_EQ(named.next(), 7000U);
        EXPECT_EQ(other.next(), 5000U) << "as before files named keys";
        EXPECT_TRUE(named.use(7100, kBlocks)) << "it has reserved some";
        EXPECT_FALSE(other.use(kEndOfNumbers - 1, kBlocks));
        EXPECT_TRUE(comes([&] { return other.use(kEndOfNumbers - 1, kBlocks); }));
        EXPECT_TRUE(named.use(7101, kBlocks));
        EXPECT_EQ(&epoch->of_key(0xBB), &other);
    }
    ASSERT_TRUE(EpochFile::wait_until_closed(kPatience));
    EXPECT_EQ(stored(), text_of(5000) + "key 000000aa 7102\nkey 000000bb 9223372036854775807\n");
    const auto again = file();
    ASSERT_TRUE(again->open(SettingScope::input));
    EXPECT_EQ(again->of_key(0xAA).next(), 7102U);
    EXPECT_EQ(again->of_key(0xBB).next(), kEndOfNumbers);
    EXPECT_EQ(again->of_key(0xCC).next(), 5000U);
}

/// A killed program forgets what it used of its reservation.
TEST_F(OpenEpoch, BeginsForAKeyAfterAllThatMayHaveBeenUsedWhereItsProgramWasKilled) {
    const pid_t child = ::fork();
    if (child == 0) {
        const auto epoch = file();
        NumberReservation& numbers = epoch->of_key(0xAA);
        ::_exit(epoch->open(SettingScope::input) && numbers.use(70, kBlocks) ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    EXPECT_EQ(epoch->of_key(0xAA).next(), kOfReceiver);
}

TEST_F(OpenEpoch, KeepsTheNumbersOfTheLatestFourKeys) {
    for (std::uint32_t key = 1; key <= 6; ++key) {
        {
            const auto epoch = file();
            NumberReservation& numbers = epoch->of_key(key);
            ASSERT_TRUE(epoch->open(SettingScope::input));
            EXPECT_TRUE(numbers.use(100 * key, kBlocks));
        }
        ASSERT_TRUE(EpochFile::wait_until_closed(kPatience));
    }
    EXPECT_EQ(stored(), text_of(0) + "key 00000003 301\nkey 00000004 401\nkey 00000005 501\n" +
                            "key 00000006 601\n");
}

TEST_F(OpenEpoch, WithADamagedLineOfAKeyIsRefused) {
    for (const char* const line : {"key 000000aa\n", "key 000000aa 9223372036854775808\n",
                                   "key 1000000aa 5\n", "key aa 5", "key aa 5\nkey\n"}) {
        EXPECT_NE(error_with(text_of(5000) + line), "none") << line;
    }
}

TEST_F(OpenEpoch, IsTheSameForAllConfigurationsOfAProgram) {
    const auto before = file();
    ASSERT_TRUE(before->open(SettingScope::input));
    EXPECT_TRUE(before->use(70, kBlocks));
    const auto after = file();
    ASSERT_TRUE(after->open(SettingScope::input));
    EXPECT_EQ(after->next(), 71U);
}

/// The numbers in the lost file were used with the same key.
TEST_F(OpenEpoch, BeginsAnywhereForASenderThatLostItsFile) {
    std::set<std::uint64_t> first;
    for (const std::string name : {"a.epoch", "b.epoch", "c.epoch"}) {
        const auto epoch = EpochFile::of(folder_ / name);
        ASSERT_TRUE(epoch->open(SettingScope::output));
        first.insert(epoch->next());
        EXPECT_TRUE(folder_.read(name).starts_with(text_of(epoch->next() + kOfSender)));
    }
    EXPECT_EQ(first.size(), 3U);
    EXPECT_LT(*first.rbegin(), std::uint64_t{1} << 62U) << "far from the highest number";
}

/// Numbers of a sender count steps of 10 us by the machine's clock.
std::uint64_t step_now() {
    return authenticated::clock_step(monotonic_now());
}

TEST_F(OpenEpoch, GoesOnByTheClockForASenderThroughEveryRestart) {
    std::uint64_t first = 0;
    // The machine may be busy while the file is opened.
    const std::uint64_t before = step_now();
    std::uint64_t after = 0;
    {
        const auto epoch = file();
        ASSERT_TRUE(epoch->open(SettingScope::output));
        first = epoch->next();
        after = step_now();
        EXPECT_TRUE(epoch->use(epoch->at(step_now()), kBlocks));
    }
    EXPECT_TRUE(EpochFile::wait_until_closed(kPatience));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    // This one ends as by SIGKILL.
    const pid_t child = ::fork();
    if (child == 0) {
        ::_exit(file()->open(SettingScope::output) ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::output));
    EXPECT_GE(epoch->next(), first + 2000);
    const std::uint64_t now = step_now();
    constexpr std::uint64_t kOneMillisecond = 100;
    EXPECT_LE(epoch->next(), first + (now - before) + kOneMillisecond);
    EXPECT_GE(epoch->at(now) + kOneMillisecond, first + (now - after));
    EXPECT_TRUE(epoch->use(epoch->at(step_now()), kBlocks));
}

TEST_F(OpenEpoch, BeginsADayLaterForASenderAfterAnotherStartOfTheMachine) {
    for (const std::string clock :
         {"", "clock 00000000-0000-0000-0000-000000000000,time:[4026531834], 0 12345\n"}) {
        folder_.write("boat.epoch", text_of(5000) + clock);
        const auto epoch = file();
        ASSERT_TRUE(epoch->open(SettingScope::output));
        EXPECT_EQ(epoch->next(), 5000 + authenticated::kNewClockNumbers);
        EXPECT_GE(epoch->at(step_now()), epoch->next());
    }
}

TEST_F(OpenEpoch, BeginsADayLaterForASenderWhereTheClockWentBack) {
    const ClockRun run = clock_run();
    const std::uint64_t ahead = 1'000'000'000'000'000;
    folder_.write("boat.epoch", text_of(ahead) + "clock " + run.name + " " +
                                    std::to_string(run.asleep.count()) + " 0\n");
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::output));
    EXPECT_EQ(epoch->next(), ahead + authenticated::kNewClockNumbers);
}

TEST_F(OpenEpoch, TakesAnotherClockForASenderAfterASuspend) {
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::output));
    const std::uint64_t before = epoch->next();
    epoch->look();
    EXPECT_LT(epoch->at(step_now()), before + kOfSender) << "it was not suspended";
    ClockRun later = clock_run();
    later.asleep += std::chrono::seconds(10);
    for (int turn = 0; turn < 2; ++turn) {
        epoch->look(later);
        const std::uint64_t now = epoch->at(step_now());
        EXPECT_GE(now, before + kOfSender + authenticated::kNewClockNumbers);
        EXPECT_LT(now, before + kOfSender + 2 * authenticated::kNewClockNumbers) << "once";
    }
    EXPECT_TRUE(comes([&] {
        return epoch->use(epoch->at(step_now()), authenticated::BroadcastSender::kNumbers);
    }));
    EXPECT_NE(stored().find(" " + std::to_string(later.asleep.count()) + " "), std::string::npos);
}

TEST_F(OpenEpoch, IsRefusedForASenderIfItIsDamaged) {
    for (const std::string clock :
         {"clock", "clock x\n", "clock x 1\n", "clock x 1 2", "clock x 1 2 3\n", "clock x -1 2\n",
          "clock x 1 2\nclock x 1 2\n"}) {
        EXPECT_NE(error_with(text_of(5000) + clock), "none") << clock;
    }
}

TEST_F(OpenEpoch, IsNotOpenedByTwoPrograms) {
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    // Another path to it stands for another program: only the lock tells them apart.
    fs::create_directory_symlink(folder_.path(), folder_ / "same");
    const auto other = EpochFile::of(folder_ / "same/boat.epoch");
    EXPECT_EQ(error_of(*other),
              (folder_ / "same/boat.epoch") +
                  " is in use by another program; each end of a link needs its own");
}

TEST_F(OpenEpoch, IsForItsOwnerOnly) {
    const auto epoch = file();
    ASSERT_TRUE(epoch->open(SettingScope::input));
    struct stat told {};
    ASSERT_EQ(::stat((folder_ / "boat.epoch").c_str(), &told), 0);
    EXPECT_EQ(told.st_mode & 07777U, 0600U);
}

TEST_F(OpenEpoch, RefusesAFileOfAnotherProgram) {
    const std::string path = folder_ / "boat.epoch";
    for (const std::string& content :
         {std::string(), std::string("tribus epoch 1\n"), std::string("tribus epoch 2\nnext 1\n"),
          std::string("tribus epoch 1\nnext\n"), std::string("tribus epoch 1\nnext 1"),
          std::string("tribus epoch 1\nnext -1\n"), std::string("tribus epoch 1\nnext 1 \n"),
          std::string("tribus epoch 1\nnext 9223372036854775808\n"), std::string(1000, '7')}) {
        const std::string error = error_with(content);
        EXPECT_EQ(error.rfind(path + " is no epoch file: it has ", 0), 0U) << error;
        EXPECT_EQ(folder_.read("boat.epoch"), content) << "it is left as it was";
    }
    EXPECT_EQ(error_with("tribus epoch 1\nnext 9223372036854775807\n"), "none");
}

TEST_F(OpenEpoch, RefusesAFolderThatCannotBeWritten) {
    const auto lost = EpochFile::of(folder_ / "none/boat.epoch");
    EXPECT_EQ(error_of(*lost),
              "cannot write " + (folder_ / "none/boat.epoch") + ".lock: No such file or directory");
}

TEST_F(OpenEpoch, GivesNoMoreNumbersThanItCouldStoreAndGoesOnWhenItCan) {
    fs::create_directory(folder_ / "disk");
    const auto epoch = EpochFile::of(folder_ / "disk/boat.epoch");
    ASSERT_TRUE(epoch->open(SettingScope::input));
    fs::rename(folder_ / "disk", folder_ / "pulled");
    EXPECT_TRUE(epoch->use(kOfReceiver - 1, kBlocks));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(epoch->use(kOfReceiver, kBlocks));
    fs::rename(folder_ / "pulled", folder_ / "disk");
    EXPECT_TRUE(comes([&] { return epoch->use(kOfReceiver, kBlocks); }));
}

}  // namespace
}  // namespace tribus::test::epoch_file_test

/// In place of that of the C library.
extern "C" int fsync(int descriptor) {
    while (tribus::test::epoch_file_test::disk_hangs) {
        ::usleep(1000);
    }
    return static_cast<int>(::syscall(SYS_fsync, descriptor));
}
