#include <dlfcn.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <ctime>

// For LD_PRELOAD under the built program: after a signal, one thread never returns from its next
// reading of the clock, as if it hung in a loop. SIGUSR1 stops the main thread, SIGUSR2 the data
// thread. The other threads go on.

namespace {

thread_local bool is_data_thread = false;
std::atomic<bool> main_thread_hangs{false};
std::atomic<bool> data_thread_hangs{false};

void hang(int signal) {
    (signal == SIGUSR1 ? main_thread_hangs : data_thread_hangs).store(true);
}

bool hangs() {
    return (is_data_thread && data_thread_hangs.load()) ||
           (main_thread_hangs.load() && ::syscall(SYS_gettid) == ::getpid());
}

struct Handlers {
    Handlers() {
        std::signal(SIGUSR1, hang);
        std::signal(SIGUSR2, hang);
    }
} handlers;

}  // namespace

extern "C" {
int clock_gettime(clockid_t clock, timespec* time) noexcept {
    while (hangs()) {
    }
    return static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
}

int pthread_setname_np(pthread_t thread, const char* name) noexcept {
    using SetName = int (*)(pthread_t, const char*);
    static const auto original =
        reinterpret_cast<SetName>(::dlsym(RTLD_NEXT, "pthread_setname_np"));
    is_data_thread = is_data_thread || std::strcmp(name, "tribus-data") == 0;
    return original(thread, name);
}
}
