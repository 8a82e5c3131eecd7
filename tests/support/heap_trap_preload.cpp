#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

// For LD_PRELOAD under the built program: once the data thread has set its name, any allocation by
// it ends the program with a message and status 134. At exit a line on standard error says that the
// thread was watched.

namespace {

thread_local bool frozen = false;
bool ever_frozen = false;

void say(const char* text) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
}

void check() {
    if (frozen) {
        frozen = false;
        say("heap trap: the data thread allocated\n");
        std::abort();
    }
}

struct Witness {
    ~Witness() { say(ever_frozen ? "heap trap: watched the data thread\n" : ""); }
} witness;

}  // namespace

extern "C" {
// Entry points of the C library that its header does not declare.
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* block, std::size_t size);             // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
    check();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    check();
    return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
    check();
    return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    check();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
    check();
    *block = __libc_memalign(alignment, size);
    return *block == nullptr ? ENOMEM : 0;
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
