#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"
#include "transports/recordings/pieces.h"

/// Files and standard streams of the subcommands that convert between formats.
namespace tribus {

/// Upper limit of what is kept of a pipe or device, which may have no end.
inline constexpr std::size_t kMostPipedBytes = std::size_t{8} * 1024 * 1024;

/// A file, or standard input for "-" or an empty name. Reading blocks. Errors are `name: reason`.
/// Thread-bound.
class InputFile {
  public:
    /// Opens a file, or standard input.
    static tl::expected<InputFile, std::string> open(std::string_view name);
    /// Opens a file even if its name is "-".
    static tl::expected<InputFile, std::string> open_path(std::string_view path);

    /// Name in messages.
    const std::string& name() const { return name_; }
    /// True for a regular file; false for a pipe, terminal or device.
    bool is_whole() const;
    /// The bytes that are there, at least one; empty at the end.
    tl::expected<std::string, std::string> read_some();
    /// `beginning` and everything up to the end. More than kMostPipedBytes of a pipe is an error.
    tl::expected<std::string, std::string> read_all(std::string beginning = {});
    /// Reads again from where it was opened, which is not always the start of standard input. Only
    /// for a regular file.
    void rewind();

  private:
    InputFile(UniqueFd descriptor, std::string name);

    UniqueFd descriptor_;
    std::string name_;
    off_t opened_at_;
};

/// The content of a file. A pipe is read to its end first. Errors of reading are told by `failed`.
/// Thread-bound.
class FilePieces final : public Pieces {
  public:
    static tl::expected<std::unique_ptr<FilePieces>, std::string> open_path(std::string_view path);
    /// Takes a file. `beginning`: what was already read of a pipe.
    static tl::expected<std::unique_ptr<FilePieces>, std::string> of(InputFile file,
                                                                     std::string beginning = {});

    std::string_view next() override;
    void rewind() override;
    /// Why it ended too early.
    const std::optional<std::string>& failed() const { return failed_; }

  private:
    explicit FilePieces(InputFile file) : file_(std::move(file)) {}

    InputFile file_;
    std::string piece_;
    /// Set for a pipe, whose whole content `piece_` holds.
    std::optional<OnePiece> whole_;
    std::optional<std::string> failed_;
};

/// Width of the terminal on this stream; nothing if it is no terminal.
std::optional<std::size_t> terminal_columns(int descriptor = STDOUT_FILENO);
/// Width of sentences on this stream, which are broken at words: that of its terminal, but no more
/// than is easy to read; 80 without a terminal.
std::size_t text_columns(int descriptor);

/// Prints sentences to standard error for the person in front of the terminal. The first line
/// begins with `first`, the others are indented by its length.
void tell_person(std::string_view text, std::string_view first = {});

/// Gives standard streams that the caller has closed a descriptor of which the use fails, so that
/// no file that is opened later takes their place. Call it first in main.
void hold_standard_streams();

/// Writes a line to standard output at once. Returns false if that is not possible or its reader
/// has gone away: a command that would go on for long ends then, and `run_command_line` says why.
bool print_line_now(std::string_view line);

/// Writes what std::cout and stdout still hold. Returns `status`, or prints a message and returns
/// kExitFailed if some of the output could not be written. A reader that went away (`| head`) is
/// not an error. `run_command_line` calls it for every command.
int finish_standard_output(int status);

}  // namespace tribus
