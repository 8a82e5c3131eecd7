#include "tests/mutation/switch.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

namespace tribus_mutation {

int chosen = 0;
unsigned char* reached = nullptr;

namespace {

/// Before all other objects: those may be mutated.
[[gnu::constructor(101)]] void choose() {
    if (const char* number = std::getenv("TRIBUS_MUTATION"); number != nullptr) {
        chosen = std::atoi(number);
    }
    const char* file = std::getenv("TRIBUS_MUTATIONS_REACHED");
    if (file == nullptr) {
        return;
    }
    const int descriptor = open(file, O_RDWR | O_CLOEXEC);
    const off_t size = descriptor < 0 ? 0 : lseek(descriptor, 0, SEEK_END);
    if (size > 0) {
        void* bytes = mmap(nullptr, static_cast<size_t>(size), PROT_READ | PROT_WRITE, MAP_SHARED,
                           descriptor, 0);
        reached = bytes == MAP_FAILED ? nullptr : static_cast<unsigned char*>(bytes);
    }
    if (descriptor >= 0) {
        close(descriptor);
    }
}

}  // namespace
}  // namespace tribus_mutation
