#pragma once

#include <filesystem>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "config/mistakes.h"
#include "config/read_file.h"
#include "config/schema.h"

namespace tribus {

/// Reads and checks a whole configuration. Opens nothing. Either it is valid, with every default
/// filled in, or all its mistakes are returned, at least one, by line and column. A mistake that
/// only follows from another one is not reported. Any bytes are allowed. `file_name` is for the
/// messages.
tl::expected<Configuration, std::vector<Mistake>> load_configuration(std::string_view text,
                                                                     std::string_view file_name);

/// The same for a file, together with `mistaken_devices`; one that cannot be read is one mistake,
/// without a line. A pipe is read to its end, where `kinds` allows that.
tl::expected<Configuration, std::vector<Mistake>> load_configuration_file(
    const std::filesystem::path& path, FileKinds kinds = FileKinds::any);

}  // namespace tribus
