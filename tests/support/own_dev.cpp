#include "tests/support/own_dev.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include "transports/links/unique_fd.h"

/// Gives the program a /dev of its own with nothing in it, before its first test. Who may not have
/// that skips all tests.
namespace tribus::test {
namespace {

/// The machine's /dev/null.
UniqueFd& null_device() {
    static UniqueFd device;
    return device;
}

/// Root may have name spaces of mounts; others in one of users, where they are root.
bool enter_own_name_space() {
    const std::string user = std::to_string(::geteuid());
    const std::string group = std::to_string(::getegid());
    if (::unshare(CLONE_NEWNS) == 0) {
        return true;
    }
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) {
        return false;
    }
    std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
    std::ofstream("/proc/self/setgroups") << "deny";
    std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
    return true;
}

class OwnDev : public testing::Environment {
  public:
    void SetUp() override {
        if (!enter_own_name_space() ||
            ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) {
            GTEST_SKIP() << "no name space of mounts here: " << std::strerror(errno);
        }
        null_device() = UniqueFd(::open("/dev/null", O_PATH | O_CLOEXEC));
        ASSERT_EQ(::mount("tests", "/dev", "tmpfs", 0, "mode=755"), 0) << std::strerror(errno);
    }
};

[[maybe_unused]] const auto* const kOwnDev = testing::AddGlobalTestEnvironment(new OwnDev);

}  // namespace

DeviceFile::DeviceFile(const std::string& name) : path_("/dev/" + name) {
    const std::string null = "/proc/self/fd/" + std::to_string(null_device().get());
    const UniqueFd place(::open(path_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600));
    EXPECT_EQ(::mount(null.c_str(), path_.c_str(), nullptr, MS_BIND, nullptr), 0)
        << path_ << ": " << std::strerror(errno);
}

void DeviceFile::remove() {
    ::umount2(path_.c_str(), MNT_DETACH);
    ::unlink(path_.c_str());
}

}  // namespace tribus::test
