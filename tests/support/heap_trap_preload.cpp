#include <dlfcn.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

#include "tests/support/every_allocation.h"

// For LD_PRELOAD under the built program: once the data thread has set its name, any allocation by
// it ends the program with a message and status 134. At the end a line on standard error says that
// the thread was watched, also where the program leaves a thread behind and ends by `_exit`.

namespace {

thread_local bool frozen = false;
bool ever_frozen = false;

void say(const char* text) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
}

void tell_once() {
    static std::atomic<bool> told = false;
    if (ever_frozen && !told.exchange(true)) {
        say("heap trap: watched the data thread\n");
    }
}

struct Witness {
    ~Witness() { tell_once(); }
} witness;

}  // namespace

void tribus::test::on_allocation() {
    if (frozen) {
        frozen = false;
        say("heap trap: the data thread allocated\n");
        std::abort();
    }
}

extern "C" {
void _exit(int status) {
    tell_once();
    for (;;) {
        ::syscall(SYS_exit_group, status);
    }
}

int pthread_setname_np(pthread_t thread, const char* name) noexcept {
    using SetName = int (*)(pthread_t, const char*);
    static const auto original =
        reinterpret_cast<SetName>(::dlsym(RTLD_NEXT, "pthread_setname_np"));
    const int result = original(thread, name);
    if (std::strcmp(name, "tribus-data") == 0) {
        frozen = true;
        ever_frozen = true;
    }
    return result;
}
}
