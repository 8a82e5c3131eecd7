#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz.h"

/// Runs a target without libFuzzer: every file of the given folders as it is, then so many inputs
/// that are made of them by chance. The same seed gives the same inputs. What breaks a promise is
/// left in a file.
///
///     TARGET [--runs N] [--seed N] FILE_OR_FOLDER...
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kLongestInput = 8192;
constexpr const char* kFailureFile = "fuzz-failure.bin";

const Bytes* current = nullptr;

/// Only what a signal handler may call.
void save_current(int number) {
    const int file = ::open(kFailureFile, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0 && current != nullptr && ::write(file, current->data(), current->size()) >= 0) {
        constexpr std::string_view kSaid = "the input is kept in fuzz-failure.bin\n";
        [[maybe_unused]] const auto told = ::write(STDERR_FILENO, kSaid.data(), kSaid.size());
    }
    std::signal(number, SIG_DFL);
    std::raise(number);
}

void run(const Bytes& input) {
    current = &input;
    LLVMFuzzerTestOneInput(input.data(), input.size());
}

Bytes read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    bytes.resize(std::min(bytes.size(), kLongestInput));
    return bytes;
}

void add_seeds(std::vector<Bytes>& seeds, const std::filesystem::path& path) {
    if (!std::filesystem::is_directory(path)) {
        seeds.push_back(read(path));
        return;
    }
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
        if (entry.is_regular_file()) {
            files.push_back(entry.path());
        }
    }
    std::ranges::sort(files);
    for (const auto& file : files) {
        seeds.push_back(read(file));
    }
}

class Mutator {
  public:
    Mutator(const std::vector<Bytes>& seeds, std::uint64_t seed) : seeds_(seeds), random_(seed) {}

    Bytes next() {
        Bytes input = seeds_[below(seeds_.size())];
        for (std::size_t count = 1 + below(6); count > 0; --count) {
            change(input);
        }
        input.resize(std::min(input.size(), kLongestInput));
        return input;
    }

  private:
    std::size_t below(std::size_t limit) { return random_() % limit; }
    void change(Bytes& input) {
        const std::size_t at = below(input.size() + 1);
        const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
        const std::size_t behind = input.size() - at;
        switch (below(6)) {
            case 0:
                input.insert(place, static_cast<std::uint8_t>(random_()));
                break;
            case 1:
                input.erase(place, place + static_cast<std::ptrdiff_t>(below(behind + 1)));
                break;
            case 2: {
                // A part of another seed in the middle of this one.
                const Bytes& other = seeds_[below(seeds_.size())];
                const std::size_t from = below(other.size() + 1);
                const std::size_t length = below(other.size() - from + 1);
                input.insert(place, other.begin() + static_cast<std::ptrdiff_t>(from),
                             other.begin() + static_cast<std::ptrdiff_t>(from + length));
                break;
            }
            case 3:
                if (behind > 0) {
                    *place = static_cast<std::uint8_t>(*place ^ (1U << below(8)));
                }
                break;
            case 4:
                if (behind > 0) {
                    constexpr std::uint8_t kTelling[] = {0x00, 0xFF, 0x7F, 0x80, 0x0F, 0x20, '"'};
                    *place = kTelling[below(std::size(kTelling))];
                }
                break;
            default:
                if (behind > 0) {
                    *place = static_cast<std::uint8_t>(random_());
                }
        }
    }

    const std::vector<Bytes>& seeds_;
    std::mt19937_64 random_;
};

}  // namespace

int main(int argc, char** argv) {
    std::uint64_t runs = 1000;
    std::uint64_t seed = 1;
    std::vector<Bytes> seeds{{}};
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if ((argument == "--runs" || argument == "--seed") && i + 1 < argc) {
            (argument == "--runs" ? runs : seed) = std::strtoull(argv[++i], nullptr, 10);
        } else {
            add_seeds(seeds, argument);
        }
    }
    for (const int number : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
        std::signal(number, save_current);
    }
    for (const Bytes& input : seeds) {
        run(input);
    }
    Mutator mutator(seeds, seed);
    for (std::uint64_t i = 0; i < runs; ++i) {
        run(mutator.next());
    }
    std::printf("%zu seeds and %llu inputs made of them: every promise was kept\n", seeds.size(),
                static_cast<unsigned long long>(runs));
    return 0;
}
