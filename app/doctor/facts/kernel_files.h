#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tribus::doctor {

/// Files with facts about the machine: /sys, /proc, /dev. A file that does not exist or may not be
/// read is empty. May block as long as the kernel does.
class KernelFiles {
  public:
    /// `root` is "/" except in tests.
    explicit KernelFiles(std::filesystem::path root) : root_(std::move(root)) {}

    /// Paths have no leading slash.
    std::filesystem::path at(std::string_view path) const { return root_ / path; }
    /// True if the path exists.
    bool has(std::string_view path) const;
    /// The beginning of a file, at most 16 KiB.
    std::string text(std::string_view path) const;
    /// The content without blanks and line ends around it; zero bytes, which end strings in device
    /// trees, count as blanks.
    std::string line(std::string_view path) const;
    /// A decimal number, or a hexadecimal one after 0x.
    std::optional<std::int64_t> number(std::string_view path) const;
    /// The word after `name` at the start of a line, such as "Max realtime priority".
    static std::optional<std::string> word_behind(std::string_view text, std::string_view name);
    /// Sorted.
    std::vector<std::string> names_in(std::string_view folder) const;
    /// The final target of a link; nothing if there is none.
    std::optional<std::filesystem::path> target(std::string_view path) const;

  private:
    std::filesystem::path root_;
};

}  // namespace tribus::doctor
