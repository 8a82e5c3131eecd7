#include "app/daemon/preparation.h"

#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "app/cli/replace_file.h"
#include "config/language/read_file.h"
#include "config/load.h"
#include "tests/loopback/machine/hanging_file.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// Another thread prepares a reload.
namespace tribus::test::preparation_test {
namespace {

namespace fs = std::filesystem;

const std::string kText =
    "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyS7\"\n"
    "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyS8\"\n"
    "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";

bool is_readable(int descriptor) {
    pollfd state{.fd = descriptor, .events = POLLIN, .revents = 0};
    return ::poll(&state, 1, 0) == 1;
}

Preparation::Result result_of(Preparation& preparation) {
    EXPECT_TRUE(seen_within([&] { return preparation.done(); }));
    return preparation.take();
}

class PreparationOf : public testing::Test {
  protected:
    ~PreparationOf() override {
        EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
    }
    std::string mistake_of(Preparation& preparation) const {
        const auto result = result_of(preparation);
        EXPECT_FALSE(result);
        return result ? "" : format_mistake(result.error().front());
    }

    TemporaryFolder folder_;
    const std::string file_ = folder_.write("car.toml", kText);
};

TEST_F(PreparationOf, AFileHasItsApplianceAndItsText) {
    const auto result = result_of(*Preparation::of_file(file_));
    ASSERT_TRUE(result);
    ASSERT_NE(result->appliance, nullptr);
    EXPECT_EQ(result->appliance->configuration().outputs.front().name, "servos");
    EXPECT_EQ(result->appliance->configuration().file, file_);
    EXPECT_EQ(result->text, kText);
}

TEST_F(PreparationOf, AFileThatIsALinkFollowsIt) {
    fs::create_symlink(file_, folder_ / "link.toml");
    EXPECT_TRUE(result_of(*Preparation::of_file(folder_ / "link.toml")));
}

TEST_F(PreparationOf, AFileThatIsNotThereSaysSo) {
    EXPECT_EQ(mistake_of(*Preparation::of_file(folder_ / "none")),
              (folder_ / "none") +
                  ": cannot be read: No such file or directory; give the path of a configuration "
                  "file");
}

TEST_F(PreparationOf, AFileWithMistakesNamesThem) {
    folder_.write("car.toml", "[output");
    EXPECT_EQ(mistake_of(*Preparation::of_file(file_)).find(file_ + ":1:"), 0U);
}

TEST_F(PreparationOf, AFileForAProcessorThatThisMachineLacksNamesIt) {
    folder_.write("car.toml", kText + "[runtime]\ncpu = 127\n");
    EXPECT_EQ(mistake_of(*Preparation::of_file(file_)).find(file_ + ":11:"), 0U)
        << mistake_of(*Preparation::of_file(file_));
}

TEST_F(PreparationOf, ADraftIsReadAsIfItStoodInTheFile) {
    const std::string draft = folder_.write("draft.toml", kText);
    fs::remove(file_);
    const auto result = result_of(*Preparation::of_draft(draft, file_));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->appliance->configuration().file, file_);
    EXPECT_EQ(result->text, kText);
    folder_.write("draft.toml", "[output");
    EXPECT_EQ(mistake_of(*Preparation::of_draft(draft, file_)).find(file_ + ":1:"), 0U);
}

TEST_F(PreparationOf, ADraftThatIsALinkIsRefused) {
    fs::create_symlink(file_, folder_ / "draft.toml");
    EXPECT_NE(mistake_of(*Preparation::of_draft(folder_ / "draft.toml", file_))
                  .find("it is a symbolic link"),
              std::string::npos);
}

TEST_F(PreparationOf, ADraftKnowsTheTextOfTheFileThatItMayReplace) {
    const std::string draft = folder_.write("draft.toml", kText + "# more\n");
    EXPECT_EQ(result_of(*Preparation::of_draft(draft, file_))->file_text, kText);
    fs::remove(file_);
    EXPECT_EQ(result_of(*Preparation::of_draft(draft, file_))->file_text, std::nullopt);
}

/// A draft that shall be kept in the place of `file_`.
class KeepingADraft : public PreparationOf {
  protected:
    DraftToKeep draft(const std::string& path) const { return {path, kDraft, kText}; }
    std::string content() const {
        return read_file(file_, 4096, FileKinds::regular).value_or("not to be read");
    }
    static inline const std::string kDraft = kText + "# draft\n";
};

TEST_F(KeepingADraft, PutsItsSuccessorInThePlaceOfTheFile) {
    ASSERT_TRUE(write_successor(file_, kDraft, 0644));
    const auto result = result_of(*Preparation::keeping(draft(file_)));
    ASSERT_TRUE(result);
    EXPECT_EQ(result->text, kDraft);
    EXPECT_EQ(result->appliance, nullptr);
    EXPECT_EQ(content(), kDraft);
    EXPECT_FALSE(fs::exists(successor_of(file_)));
}

TEST_F(KeepingADraft, LeavesALinkToTheFile) {
    fs::create_symlink(file_, folder_ / "link.toml");
    ASSERT_TRUE(write_successor(file_, kDraft, 0644));
    EXPECT_EQ(result_of(*Preparation::keeping(draft(folder_ / "link.toml")))->text, kDraft);
    EXPECT_TRUE(fs::is_symlink(folder_ / "link.toml"));
    EXPECT_EQ(content(), kDraft);
}

TEST_F(KeepingADraft, NeedsNoSuccessorIfTheFileHasItsText) {
    folder_.write("car.toml", kDraft);
    EXPECT_EQ(result_of(*Preparation::keeping(draft(file_)))->text, kDraft);
}

TEST_F(KeepingADraft, WithoutASuccessorSaysWhatTheFileHas) {
    EXPECT_EQ(result_of(*Preparation::keeping(draft(file_)))->text, kText);
    EXPECT_EQ(content(), kText);
}

/// Somebody else may have put it there.
TEST_F(KeepingADraft, TakesNoSuccessorThatIsALink) {
    fs::create_symlink(folder_.write("elsewhere", kDraft), successor_of(file_));
    EXPECT_EQ(result_of(*Preparation::keeping(draft(file_)))->text, kText);
    EXPECT_EQ(content(), kText);
}

TEST_F(KeepingADraft, LeavesAFileThatIsAnotherThanWhenTheTrialBegan) {
    ASSERT_TRUE(write_successor(file_, kDraft, 0644));
    folder_.write("car.toml", "[output");
    EXPECT_EQ(mistake_of(*Preparation::keeping(draft(file_))),
              file_ + ": was changed by another since the draft went on trial");
    EXPECT_EQ(content(), "[output");
}

TEST_F(KeepingADraft, SaysThatTheFileIsNotThere) {
    EXPECT_NE(mistake_of(*Preparation::keeping(draft(folder_ / "none"))), "");
}

TEST_F(KeepingADraft, ChangesNothingOnceItIsAbandoned) {
    ASSERT_TRUE(write_successor(file_, kDraft, 0644));
    HangingFile hanging(file_);
    const auto preparation = Preparation::keeping(draft(file_));
    EXPECT_TRUE(preparation->abandon());
    hanging.answer();
    EXPECT_EQ(mistake_of(*preparation), file_ + ": is as before: the draft was abandoned");
    EXPECT_EQ(content(), kText);
}

TEST_F(KeepingADraft, IsNotAbandonedOnceItIsKept) {
    ASSERT_TRUE(write_successor(file_, kDraft, 0644));
    const auto preparation = Preparation::keeping(draft(file_));
    EXPECT_TRUE(seen_within([&] { return preparation->done(); }));
    EXPECT_FALSE(preparation->abandon());
}

TEST_F(PreparationOf, AConfigurationHasItsApplianceAndNoText) {
    const auto result = result_of(*Preparation::of(load_configuration(kText, "car.toml").value()));
    ASSERT_TRUE(result);
    ASSERT_NE(result->appliance, nullptr);
    EXPECT_EQ(result->appliance->configuration().outputs.front().name, "servos");
    EXPECT_EQ(result->text, "");
}

/// A disk that hangs must not stop the main thread.
TEST_F(PreparationOf, AnApplianceOpensItsFilesToo) {
    const std::string key = folder_.write("boat.key", std::string(64, '7'));
    fs::permissions(key, fs::perms::owner_read | fs::perms::owner_write);
    folder_.write("car.toml", kText +
                                  "[output.radio]\nprotocol = \"network\"\n"
                                  "address = \"127.0.0.1:5717\"\nkey = \"" +
                                  key + "\"\nepoch = \"" + (folder_ / "boat.epoch") +
                                  "\"\n[pipeline.radio]\nfrom = \"receiver\"\nto = \"radio\"\n");
    const auto result = result_of(*Preparation::of_file(file_));
    ASSERT_TRUE(result) << format_mistake(result.error().front());
    EXPECT_TRUE(fs::exists(folder_ / "boat.epoch"));
}

TEST_F(PreparationOf, AFileThatIsNotReadYetIsUnderWayOnAThreadOfItsOwn) {
    EXPECT_FALSE(Preparation::any_abandoned());
    HangingFile hanging(file_);
    const auto preparation = Preparation::of_file(file_);
    EXPECT_TRUE(Preparation::any_abandoned());
    EXPECT_FALSE(preparation->done());
    EXPECT_FALSE(is_readable(preparation->descriptor()));
    EXPECT_TRUE(seen_within([&] { return hanging.thread() == "tribus-reload"; }));
    hanging.answer();
    EXPECT_TRUE(seen_within([&] { return is_readable(preparation->descriptor()); }));
    EXPECT_TRUE(preparation->done());
    std::uint64_t events = 0;
    EXPECT_EQ(::read(preparation->descriptor(), &events, sizeof events), 8);
    EXPECT_EQ(events, 1U);
    EXPECT_TRUE(preparation->take());
    EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
}

TEST_F(PreparationOf, AFileThatNobodyWaitsForAnyMoreGoesOn) {
    HangingFile hanging(file_);
    Preparation::of_file(file_).reset();
    EXPECT_TRUE(Preparation::any_abandoned());
    hanging.answer();
    EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
}

/// In a process that may have no further thread.
int exit_status_without_threads(const std::string& path) {
    constexpr uid_t kNobody = 65534;
    const rlimit none{.rlim_cur = 0, .rlim_max = 0};
    if (::setrlimit(RLIMIT_NPROC, &none) != 0 || (::geteuid() == 0 && ::setuid(kNobody) != 0)) {
        return 1;
    }
    const auto preparation = Preparation::keeping({.path = path, .text = {}, .file_text = {}});
    if (!preparation->done() || !is_readable(preparation->descriptor())) {
        return 2;
    }
    if (Preparation::any_abandoned()) {
        return 3;
    }
    const auto result = preparation->take();
    return result && !result->text.empty() ? 0 : 4;
}

TEST(PreparationWithoutThreads, IsDoneAtOnce) {
    EXPECT_EXIT(::_exit(exit_status_without_threads("/proc/version")), testing::ExitedWithCode(0),
                "");
}

}  // namespace
}  // namespace tribus::test::preparation_test
