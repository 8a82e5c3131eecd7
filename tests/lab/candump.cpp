#include "tests/lab/candump.h"

#include <csignal>

#include <gtest/gtest.h>

#include "tests/lab/shell.h"

namespace tribus::test {

// The socket has room for seconds of a busy bus, because an emulated machine stalls now and then.
Candump::Candump(const std::filesystem::path& folder, const std::string& interface)
    : program_(folder, {"-L", "-r", "4194304", interface}, {.executable = "/usr/bin/candump"}) {
    EXPECT_TRUE(eventually([] {
        return read_file("/proc/net/can/rcvlist_all").find(" raw") != std::string::npos;
    })) << program_.errors();
}

std::string Candump::log() {
    program_.signal(SIGTERM);
    program_.end();
    return program_.output();
}

}  // namespace tribus::test
