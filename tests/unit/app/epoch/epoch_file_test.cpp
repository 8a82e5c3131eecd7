#include "app/epoch/epoch_file.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

/// The file of `epoch`, and what is left of it after a program was killed.
namespace tribus::test::epoch_file_test {
namespace {

namespace fs = std::filesystem;

constexpr NumberBlocks kBlocks{.block = 100, .ahead = 50};
/// Steps of 10 us that an end reserves when it starts: 20 s, and 12 hours.
constexpr std::uint64_t kOfReceiver = 2'000'000;
constexpr std::uint64_t kOfSender = 4'294'967'296;

class OpenEpoch : public ::testing::Test {
  protected:
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
    /// Waits for the thread of the file: at most ten seconds.
    static bool comes(const auto& condition) {
        for (int i = 0; i < 10'000 && !condition(); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return condition();
    }

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
    EXPECT_EQ(stored(), text_of(71));
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
TEST_F(OpenEpoch, OfASenderThatLostItsFileBeginsAnywhere) {
    std::set<std::uint64_t> first;
    for (const std::string name : {"a.epoch", "b.epoch", "c.epoch"}) {
        const auto epoch = EpochFile::of(folder_ / name);
        ASSERT_TRUE(epoch->open(SettingScope::output));
        first.insert(epoch->next());
        EXPECT_EQ(folder_.read(name), text_of(epoch->next() + kOfSender));
    }
    EXPECT_EQ(first.size(), 3U);
    EXPECT_LT(*first.rbegin(), std::uint64_t{1} << 62U) << "far from the highest number";
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
