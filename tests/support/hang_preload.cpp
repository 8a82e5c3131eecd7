#include <dlfcn.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <ctime>

// For LD_PRELOAD under the built program: after a signal, one thread does not return from its next
// reading of the clock. The other threads go on. SIGUSR1 stops the main thread, SIGUSR2 the data
// thread, both for good, as if they hung in a loop. SIGURG stops the thread of the GPIO lines, as
// if the kernel kept it, and lets it go on again.

namespace {

thread_local bool is_data_thread = false;
thread_local bool is_gpio_thread = false;
std::atomic<bool> main_thread_hangs{false};
std::atomic<bool> data_thread_hangs{false};
std::atomic<bool> gpio_thread_hangs{false};

/// With a time of 64 bits on a processor of 32 bits, the kernel has other calls for it.
#ifdef SYS_clock_gettime64
constexpr long kGetTime = SYS_clock_gettime64;
constexpr long kSleep = SYS_clock_nanosleep_time64;
#else
constexpr long kGetTime = SYS_clock_gettime;
constexpr long kSleep = SYS_clock_nanosleep;
#endif

void hang(int signal) {
    (signal == SIGUSR1 ? main_thread_hangs : data_thread_hangs).store(true);
}

void hang_or_go_on(int /*signal*/) {
    gpio_thread_hangs.store(!gpio_thread_hangs.load());
}

bool hangs() {
    return (is_data_thread && data_thread_hangs.load()) ||
           (main_thread_hangs.load() && ::syscall(SYS_gettid) == ::getpid());
}

struct Handlers {
    Handlers() {
        std::signal(SIGUSR1, hang);
        std::signal(SIGUSR2, hang);
        std::signal(SIGURG, hang_or_go_on);
    }
} handlers;

}  // namespace

extern "C" {
int clock_gettime(clockid_t clock, timespec* time) noexcept {
    while (hangs()) {
    }
    while (is_gpio_thread && gpio_thread_hangs.load()) {
        constexpr timespec kMillisecond{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::syscall(kSleep, CLOCK_MONOTONIC, 0, &kMillisecond, nullptr);
    }
    return static_cast<int>(::syscall(kGetTime, clock, time));
}

int pthread_setname_np(pthread_t thread, const char* name) noexcept {
    using SetName = int (*)(pthread_t, const char*);
    static const auto original =
        reinterpret_cast<SetName>(::dlsym(RTLD_NEXT, "pthread_setname_np"));
    is_data_thread = is_data_thread || std::strcmp(name, "tribus-data") == 0;
    is_gpio_thread = is_gpio_thread || std::strcmp(name, "tribus-gpio") == 0;
    return original(thread, name);
}
}
