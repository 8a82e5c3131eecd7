#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tribus::doctor {

/// The files in which the kernel tells of itself: /sys, /proc, /dev. What is not there, or may not
/// be read, is empty. May block for as long as the kernel takes.
class KernelFiles {
  public:
    /// `root` is "/" but for tests.
    explicit KernelFiles(std::filesystem::path root) : root_(std::move(root)) {}

    /// Paths are given without a slash in front.
    std::filesystem::path at(std::string_view path) const { return root_ / path; }
    bool has(std::string_view path) const;
    /// The beginning of a file, up to some pages.
    std::string text(std::string_view path) const;
    /// Without the spaces and line ends around it; zeros, which end strings of device trees, count
    /// as spaces.
    std::string line(std::string_view path) const;
    /// In decimal, or behind 0x in hexadecimal.
    std::optional<std::int64_t> number(std::string_view path) const;
    /// The number behind a name that starts a line, as "Max realtime priority".
    static std::optional<std::string> word_behind(std::string_view text, std::string_view name);
    /// In order.
    std::vector<std::string> names_in(std::string_view folder) const;
    /// Where a link in the end leads, or nothing.
    std::optional<std::filesystem::path> target(std::string_view path) const;

  private:
    std::filesystem::path root_;
};

}  // namespace tribus::doctor
