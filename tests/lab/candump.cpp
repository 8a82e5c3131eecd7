#include "tests/lab/candump.h"

#include <csignal>

#include <gtest/gtest.h>

#include "tests/lab/raw_can.h"
#include "tests/lab/shell.h"

namespace tribus::test {

// The socket has room for seconds of a busy bus, because an emulated machine stalls now and then.
Candump::Candump(const std::filesystem::path& folder, const std::string& interface)
    : interface_(interface),
      program_(folder, {"-L", "-r", "4194304", interface}, {.executable = "/usr/bin/candump"}) {
    EXPECT_TRUE(eventually([] {
        return read_file("/proc/net/can/rcvlist_all").find(" raw") != std::string::npos;
    })) << program_.errors();
}

// On a busy machine candump is seconds behind, and a signal ends it at once. It writes whole blocks
// only, so marks follow until one shows.
std::string Candump::log() {
    constexpr std::uint32_t kMarkId = 0x1FEDCBA9;
    constexpr const char* kMark = " 1FEDCBA9#";
    RawCan bus(interface_);
    CanFrame mark = make_frame(kMarkId, {});
    mark.extended = true;
    EXPECT_TRUE(eventually([&] {
        bus.send(mark);
        return program_.output().find(kMark) != std::string::npos;
    })) << program_.errors();
    program_.signal(SIGTERM);
    EXPECT_TRUE(program_.end().has_value()) << "candump does not end";
    const std::string output = program_.output();
    return output.substr(0, output.rfind('\n', output.find(kMark)) + 1);
}

}  // namespace tribus::test
