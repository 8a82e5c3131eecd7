#include <pthread.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <string_view>
#include <thread>

// Does what the data thread must not do, in a thread with its name: this proves that the heap trap
// works. The argument selects what it does.

namespace {

/// Keeps the compiler from removing an unused allocation.
void* volatile kept = nullptr;

struct alignas(256) WideBlock {
    std::byte bytes[256];
};

void allocate(std::string_view how) {
    constexpr std::size_t kSize = 100;
    if (how == "malloc") {
        kept = std::malloc(kSize);
    } else if (how == "calloc") {
        kept = std::calloc(1, kSize);
    } else if (how == "realloc") {
        kept = std::realloc(kept, kSize);
    } else if (how == "new") {
        kept = ::operator new(kSize);
    } else if (how == "aligned-new") {
        kept = new WideBlock;
    }
}

}  // namespace

int main(int count, char** words) {
    if (count != 2) {
        return 2;
    }
    kept = std::malloc(1);
    std::thread([how = std::string_view(words[1])] {
        ::pthread_setname_np(::pthread_self(), "tribus-data");
        allocate(how);
    }).join();
    return 0;
}
