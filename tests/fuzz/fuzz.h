#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <span>
#include <string_view>

/// Shared code of the targets. Each target is one function, FUZZ_TARGET(NAME), which takes any
/// bytes, `size` of them at `data`, aborts if a promise is broken, and returns 0. With libFuzzer
/// each target is a program; without it they are one program, whose driver (driver.cpp) calls them
/// by name.
namespace tribus::fuzz {

/// `promise` is the text for whoever finds it broken.
inline void require(bool kept, const char* promise) {
    if (!kept) {
        std::fprintf(stderr, "broken: %s\n", promise);
        std::abort();
    }
}

/// Takes decisions from the front of the input. When the input is used up, all further ones are 0.
class Input {
  public:
    explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    bool empty() const { return bytes_.empty(); }
    std::uint8_t byte() {
        if (bytes_.empty()) {
            return 0;
        }
        const std::uint8_t first = bytes_.front();
        bytes_ = bytes_.subspan(1);
        return first;
    }
    std::uint32_t word() {
        std::uint32_t word = 0;
        for (int i = 0; i < 4; ++i) {
            word = word << 8U | byte();
        }
        return word;
    }
    std::size_t below(std::size_t limit) { return byte() % limit; }
    /// Takes `count` bytes, or all that are left.
    std::span<const std::uint8_t> take(std::size_t count) {
        const auto taken = bytes_.first(std::min(count, bytes_.size()));
        bytes_ = bytes_.subspan(taken.size());
        return taken;
    }
    std::span<const std::uint8_t> rest() { return take(bytes_.size()); }
    std::string_view rest_as_text() {
        const auto all = rest();
        return {reinterpret_cast<const char*>(all.data()), all.size()};
    }

  private:
    std::span<const std::uint8_t> bytes_;
};

using Target = int (*)(const std::uint8_t* data, std::size_t size);

/// All targets of the program, by name.
inline std::map<std::string_view, Target>& targets() {
    static std::map<std::string_view, Target> all;
    return all;
}

}  // namespace tribus::fuzz

#ifdef TRIBUS_LIBFUZZER
#define FUZZ_TARGET(name) \
    extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
#else
#define FUZZ_TARGET(name)                                                             \
    static int run(const std::uint8_t* data, std::size_t size);                       \
    [[maybe_unused]] static const bool known = targets().emplace(#name, &run).second; \
    static int run(const std::uint8_t* data, std::size_t size)
#endif
