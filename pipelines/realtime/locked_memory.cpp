#include "pipelines/realtime/locked_memory.h"

#include <link.h>
#include <malloc.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string_view>

// Where the linker put the data path's code and constants (app/data_path.ld); null without it.
extern "C" {
[[gnu::weak]] extern const char kDataPathCodeBegin[];
[[gnu::weak]] extern const char kDataPathCodeEnd[];
[[gnu::weak]] extern const char kDataPathConstantsBegin[];
[[gnu::weak]] extern const char kDataPathConstantsEnd[];
}

namespace tribus {
namespace {

struct MemoryRange {
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;

    bool holds(std::uintptr_t address) const { return begin <= address && address < end; }
};

std::uintptr_t address_of(const char* symbol) {
    return reinterpret_cast<std::uintptr_t>(symbol);
}

/// Of whole pages: 4 KiB, but 16 KiB on a Raspberry Pi 5.
template <class Function>
int advise(Function function, MemoryRange range) {
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const std::uintptr_t begin = range.begin / page * page;
    // The loader and the kernel's list of mappings give addresses as numbers.
    return function(reinterpret_cast<void*>(begin),  // NOLINT(performance-no-int-to-ptr)
                    range.end - begin);
}

int lock(MemoryRange range) {
    return advise([](void* begin, std::size_t length) { return ::mlock(begin, length); }, range);
}

/// Calls `visit` with each segment of the program and its libraries that is never written to, until
/// it returns other than 0.
template <class Visit>
int each_clean_segment(Visit visit) {
    const auto visit_object = [](dl_phdr_info* object, std::size_t, void* data) {
        for (int i = 0; i < object->dlpi_phnum; ++i) {
            const auto& segment = object->dlpi_phdr[i];
            if (segment.p_type == PT_LOAD && (segment.p_flags & PF_W) == 0) {
                const std::uintptr_t begin = object->dlpi_addr + segment.p_vaddr;
                const int result =
                    (*static_cast<Visit*>(data))(MemoryRange{begin, begin + segment.p_memsz});
                if (result != 0) {
                    return result;
                }
            }
        }
        return 0;
    };
    return ::dl_iterate_phdr(visit_object, &visit);
}

/// Their content is that of their files, so dropping them loses nothing.
void drop_clean_segments() {
    each_clean_segment([](MemoryRange segment) {
        advise(
            [](void* begin, std::size_t length) { return ::madvise(begin, length, MADV_DONTNEED); },
            segment);
        return 0;
    });
}

/// The C library's code, found by one of its functions.
int lock_c_library() {
    const auto inside = reinterpret_cast<std::uintptr_t>(&::epoll_pwait2);
    return each_clean_segment(
        [&](MemoryRange segment) { return segment.holds(inside) ? lock(segment) : 0; });
}

/// Data and the stacks of threads. Not the heap: what was made there was written to then, and what
/// is free stays away. Not the main thread's stack either: no frame waits for it.
int lock_writable_memory() {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> maps(std::fopen("/proc/self/maps", "re"),
                                                               &std::fclose);
    std::array<char, 512> line{};
    while (maps && std::fgets(line.data(), line.size(), maps.get()) != nullptr) {
        const std::string_view text(line.data());
        MemoryRange range;
        std::array<char, 5> permissions{};
        std::sscanf(line.data(), "%" SCNxPTR "-%" SCNxPTR " %4s", &range.begin, &range.end,
                    permissions.data());
        const bool written_to = std::string_view(permissions.data()).starts_with("rw");
        const bool other = text.ends_with("[heap]\n") || text.ends_with("[stack]\n");
        if (written_to && !other && lock(range) != 0) {
            return -1;
        }
    }
    return maps ? 0 : -1;
}

}  // namespace

int lock_memory() {
    if (kDataPathCodeBegin == nullptr) {
        return ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno;
    }
    ::munlockall();
    ::malloc_trim(0);
    drop_clean_segments();
    const bool locked =
        ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0 &&
        lock({address_of(kDataPathCodeBegin), address_of(kDataPathCodeEnd)}) == 0 &&
        lock({address_of(kDataPathConstantsBegin), address_of(kDataPathConstantsEnd)}) == 0 &&
        lock_c_library() == 0 && lock_writable_memory() == 0;
    return locked ? 0 : errno;
}

}  // namespace tribus
