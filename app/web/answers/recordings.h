#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/web/answers/daemons.h"
#include "app/web/http/http.h"

/// The recordings of a daemon's flight recorder, as the page sees them. Names of recordings are
/// compared with the list and never become a path.
namespace tribus::web {

/// The folder of the recordings; nothing if there is no recorder. The error is a sentence.
using RecordingsPlace = tl::expected<std::optional<std::filesystem::path>, std::string>;
/// As the daemon answers to `recordings`.
RecordingsPlace place_in_answer(const std::string& json);
/// As the configuration of a daemon that does not answer says.
RecordingsPlace place_in_file(const KnownDaemon& daemon);

/// `{"directory", "recordings": [{"id", "time", "cause", "bytes"}]}`, the newest first.
HttpAnswer recordings_answer(const RecordingsPlace& place);
/// The folder of the recording with that name.
tl::expected<std::filesystem::path, HttpAnswer> find_recording(const RecordingsPlace& place,
                                                               std::string_view name);
/// That folder as an archive.
HttpAnswer recording_tar_answer(const std::filesystem::path& recording);

/// Options of `tribus-web plot` for `from=0&to=1000000&width=800`. Nothing unless all three are
/// there and right. Pure.
std::optional<std::vector<std::string>> plot_range(std::string_view query);

}  // namespace tribus::web
