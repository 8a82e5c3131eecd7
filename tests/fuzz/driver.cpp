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

/// Runs a target without libFuzzer: first every seed as it is, then N inputs made from the seeds at
/// random. The same `--seed` gives the same inputs. An input that breaks a promise is left in a
/// file.
///
///     fuzz_targets TARGET [--runs N] [--seed N] PATH...
///
/// A path is a file with one seed, a folder of such files, or a packed file of seeds (*.seeds).
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kLongestInput = 8192;
constexpr const char* kFailureFile = "fuzz-failure.bin";

const Bytes* current = nullptr;

/// Calls only functions that are allowed in a signal handler.
void save_current(int number) {
    const int file = ::open(kFailureFile, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0 && current != nullptr && ::write(file, current->data(), current->size()) >= 0) {
        constexpr std::string_view kSaid = "the input is kept in fuzz-failure.bin\n";
        [[maybe_unused]] const auto told = ::write(STDERR_FILENO, kSaid.data(), kSaid.size());
    }
    std::signal(number, SIG_DFL);
    std::raise(number);
}

void run(tribus::fuzz::Target target, const Bytes& input) {
    current = &input;
    target(input.data(), input.size());
}

/// Ends the program, because fewer seeds than there should be are a weaker test.
[[noreturn]] void refuse(const std::string& place, std::string_view mistake) {
    std::fprintf(stderr, "%s: %.*s\n", place.c_str(), static_cast<int>(mistake.size()),
                 mistake.data());
    std::exit(2);
}

std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file) {
        refuse(path, "cannot be read");
    }
    return bytes;
}

/// The bytes of pairs of hexadecimal digits, or nothing if the text is something else.
Bytes bytes_of_hex(std::string_view text) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    Bytes bytes;
    for (; text.size() >= 2; text.remove_prefix(2)) {
        const std::size_t high = kDigits.find(text[0]);
        const std::size_t low = kDigits.find(text[1]);
        if (high == std::string_view::npos || low == std::string_view::npos) {
            return {};
        }
        bytes.push_back(static_cast<std::uint8_t>(high << 4U | low));
    }
    return text.empty() ? bytes : Bytes{};
}

/// Adds the seeds of a packed file, which tests/fuzz/seeds.sh writes.
void add_packed(std::vector<Bytes>& seeds, const std::filesystem::path& path) {
    const std::string text = read(path);
    if (!text.ends_with('\n')) {
        refuse(path, "is empty or its last line is cut off; restore it from git");
    }
    std::string_view name_before;
    std::string_view rest = text;
    for (int number = 1; !rest.empty(); ++number) {
        const std::string place = path.string() + ":" + std::to_string(number);
        const std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(line.size() + 1);
        const std::string_view name = line.substr(0, line.find(' '));
        const Bytes bytes = bytes_of_hex(line.substr(std::min(name.size() + 1, line.size())));
        if (name.empty() || bytes.empty()) {
            refuse(place,
                   "is not a name, a space and pairs of the digits 0-9 and A-F; "
                   "restore the line from git");
        }
        if (name <= name_before) {
            refuse(place,
                   "its name is there twice, or the lines are not sorted; "
                   "sort them: LC_ALL=C sort -u -o FILE FILE");
        }
        seeds.push_back(bytes);
        name_before = name;
    }
}

void add_file(std::vector<Bytes>& seeds, const std::filesystem::path& path) {
    const std::string bytes = read(path);
    seeds.emplace_back(bytes.begin(), bytes.end());
}

void add_folder(std::vector<Bytes>& seeds, const std::filesystem::path& path) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
        if (entry.is_regular_file()) {
            files.push_back(entry.path());
        }
    }
    std::ranges::sort(files);
    for (const auto& file : files) {
        add_file(seeds, file);
    }
}

void add_seeds(std::vector<Bytes>& seeds, const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path)) {
        add_folder(seeds, path);
    } else if (path.extension() == ".seeds") {
        add_packed(seeds, path);
    } else {
        add_file(seeds, path);
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
    const auto& targets = tribus::fuzz::targets();
    const auto target = targets.find(argc < 2 ? "" : argv[1]);
    if (target == targets.end()) {
        refuse(argc < 2 ? "TARGET" : argv[1], "is no target; tests/fuzz/README.md lists them");
    }
    std::uint64_t runs = 1000;
    std::uint64_t seed = 1;
    std::vector<Bytes> seeds{{}};
    for (int i = 2; i < argc; ++i) {
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
    for (Bytes& input : seeds) {
        input.resize(std::min(input.size(), kLongestInput));
        run(target->second, input);
    }
    Mutator mutator(seeds, seed);
    for (std::uint64_t i = 0; i < runs; ++i) {
        run(target->second, mutator.next());
    }
    std::printf("%zu seeds and %llu inputs made of them: every promise was kept\n", seeds.size(),
                static_cast<unsigned long long>(runs));
    return 0;
}
