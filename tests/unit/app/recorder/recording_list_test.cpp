#include "app/recorder/recording_list.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::test::recording_list_test {
namespace {

namespace fs = std::filesystem;

class RecordingList : public testing::Test {
  protected:
    void add(const std::string& name, const std::string& content = "12345") {
        fs::create_directories(directory_ / name);
        folder_.write("recordings/" + name + "/input-a.txt", content);
        folder_.write("recordings/" + name + "/README.txt", "123");
    }
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        const auto list = list_recordings(directory_);
        for (const ListedRecording& one : *list) {
            names.push_back(one.name);
        }
        return names;
    }

    TemporaryFolder folder_;
    fs::path directory_ = folder_.path() / "recordings";
};

TEST_F(RecordingList, IsEmptyForADirectoryThatIsNotThere) {
    EXPECT_TRUE(names().empty());
}

TEST_F(RecordingList, IsAnErrorForWhatIsNoDirectory) {
    folder_.write("recordings", "");
    const auto list = list_recordings(directory_);
    ASSERT_FALSE(list);
    EXPECT_NE(list.error().find("recordings: "), std::string::npos) << list.error();
}

TEST_F(RecordingList, HasTheNewestFirstWithTimeCauseAndSize) {
    add("2026-11-22T12-00-05Z-failsafe");
    add("2026-11-22T12-00-06Z-request-10");
    add("2026-11-22T12-00-06Z-request-2", "1234567");
    const auto list = *list_recordings(directory_);
    ASSERT_EQ(list.size(), 3U);
    EXPECT_EQ(list[0].name, "2026-11-22T12-00-06Z-request-10");
    EXPECT_EQ(list[1].name, "2026-11-22T12-00-06Z-request-2");
    EXPECT_EQ(list[1].time, "2026-11-22T12:00:06Z");
    EXPECT_EQ(list[1].cause, "request");
    EXPECT_EQ(list[1].bytes, 10U);
    EXPECT_EQ(list[2].cause, "failsafe");
}

TEST_F(RecordingList, HasNeitherUnfinishedOnesNorWhatIsNone) {
    add("2026-11-22T12-00-05Z-failsafe");
    add("2026-11-22T12-00-05Z-failsafe.unfinished");
    add("2026-11-22T12-00-05Z");
    add("mine");
    folder_.write("recordings/2026-11-22T12-00-07Z-request", "a file");
    EXPECT_EQ(names(), std::vector<std::string>{"2026-11-22T12-00-05Z-failsafe"});
}

TEST_F(RecordingList, FollowsNoLinkAndShowsNoNameThatWouldHaveToBeEscaped) {
    add("2026-11-22T12-00-05Z-failsafe");
    fs::create_directory_symlink(directory_ / "2026-11-22T12-00-05Z-failsafe",
                                 directory_ / "2026-11-22T12-00-08Z-request");
    add("2026-11-22T12-00-09Z-a\"b");
    add("2026-11-22T12-00-09Z-a b");
    add("2026-11-22T12-00-09Z-\xff");
    EXPECT_EQ(names(), std::vector<std::string>{"2026-11-22T12-00-05Z-failsafe"});
}

}  // namespace
}  // namespace tribus::test::recording_list_test
