#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "config/language/mistakes.h"
#include "config/language/read_file.h"
#include "config/schema/schema.h"

namespace tribus {

/// Reads and checks a whole configuration. Opens nothing. Returns a valid configuration with every
/// default, or all mistakes (at least one), sorted by line and column. A mistake that only follows
/// from another one is not reported. Accepts any bytes. `file_name` is for messages.
tl::expected<Configuration, std::vector<Mistake>> load_configuration(std::string_view text,
                                                                     std::string_view file_name);

/// The same for a file, including `mistaken_devices`. A file that cannot be read is one mistake
/// without a line. Reads a pipe to its end, if `kinds` permits pipes.
tl::expected<Configuration, std::vector<Mistake>> load_configuration_file(
    const std::filesystem::path& path, FileKinds kinds = FileKinds::any);

/// The same for a text as if it stood in `path`. Mistakes name `path`.
tl::expected<Configuration, std::vector<Mistake>> load_configuration_draft(
    std::string_view text, const std::filesystem::path& path);

/// The text of a configuration file. Mistakes as of `load_configuration_file`.
tl::expected<std::string, std::vector<Mistake>> read_configuration_text(
    const std::filesystem::path& path, FileKinds kinds);

}  // namespace tribus
