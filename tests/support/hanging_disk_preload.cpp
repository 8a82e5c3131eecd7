#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>

// For LD_PRELOAD under the built program: while the file that TRIBUS_HANGING_DISK names exists, the
// disk takes nothing, and who waits for it does not come back.

extern "C" int fsync(int descriptor) {
    const char* const sign = std::getenv("TRIBUS_HANGING_DISK");
    while (sign != nullptr && ::access(sign, F_OK) == 0) {
        constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 2'000'000};
        ::nanosleep(&kPause, nullptr);
    }
    return static_cast<int>(::syscall(SYS_fsync, descriptor));
}
