#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// Files and standard streams of the subcommands that turn one into another.
namespace tribus {

/// A file, or standard input for "-" and for no name. Reading waits for what comes. Errors are
/// `name: reason`. Thread-bound.
class InputFile {
  public:
    static tl::expected<InputFile, std::string> open(std::string_view name);
    /// Never standard input, whatever the name.
    static tl::expected<InputFile, std::string> open_path(std::string_view path);

    /// As messages call it.
    const std::string& name() const { return name_; }
    /// All of it is there already: no pipe, terminal or device.
    bool is_whole() const;
    /// What is there, at least one byte; nothing at the end.
    tl::expected<std::string, std::string> read_some();
    /// All up to the end.
    tl::expected<std::string, std::string> read_all();

  private:
    InputFile(UniqueFd descriptor, std::string name)
        : descriptor_(std::move(descriptor)), name_(std::move(name)) {}

    UniqueFd descriptor_;
    std::string name_;
};

/// Of the terminal that standard output is; nothing where it is none.
std::optional<std::size_t> terminal_columns();

/// Writes out what std::cout holds. Returns `status`, or a failure, with a message, where it could
/// not be written; a reader that has gone away (`| head`) is none.
int finish_standard_output(int status);

}  // namespace tribus
