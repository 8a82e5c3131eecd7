#include "app/web/answers/recordings.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/recorder/recording_list.h"
#include "app/web/answers/answers.h"
#include "app/web/recordings/plot_curve.h"
#include "app/web/recordings/recording_tar.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "config/load.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

/// The service keeps them there (deploy/systemd/tribus@.service, STATE_DIRECTORY).
constexpr std::string_view kServiceRecordings = "/var/lib/tribus";

/// The value of a number in a query; nothing if it is not there or no number.
std::optional<std::uint64_t> number_in_query(std::string_view query, std::string_view name) {
    while (!query.empty()) {
        const std::size_t end = std::min(query.find('&'), query.size());
        const std::string_view one = query.substr(0, end);
        const std::size_t equals = one.find('=');
        std::uint64_t number = 0;
        if (equals != std::string_view::npos && one.substr(0, equals) == name) {
            const char* const last = one.data() + one.size();
            const auto read = std::from_chars(one.data() + equals + 1, last, number);
            return read.ec == std::errc() && read.ptr == last ? std::optional(number)
                                                              : std::nullopt;
        }
        query.remove_prefix(std::min(end + 1, query.size()));
    }
    return std::nullopt;
}

}  // namespace

RecordingsPlace place_in_answer(const std::string& json) {
    const HttpAnswer answer = as_it_is(json);
    const auto told = parse_json(json);
    if (answer.status != 200 || status_fields::text(told, "type") != "recordings") {
        return tl::unexpected(status_fields::text(told, "error"));
    }
    const std::string directory = status_fields::raw_text(told, "directory");
    return directory.empty() ? std::nullopt : std::optional<fs::path>(directory);
}

RecordingsPlace place_in_file(const KnownDaemon& daemon) {
    const auto text = read_file(daemon.file, kMostConfigurationBytes, FileKinds::regular);
    if (!text) {
        return tl::unexpected(fmt::format("no daemon says where the recordings are, and {}: {}",
                                          daemon.file.string(), text.error()));
    }
    const auto configuration = load_configuration(*text, daemon.file.string());
    if (!configuration) {
        return tl::unexpected(
            fmt::format("no daemon says where the recordings are, and {} has mistakes: {}",
                        daemon.file.string(), configuration.error().front().text));
    }
    if (!configuration->recorder) {
        return std::nullopt;
    }
    if (!configuration->recorder->directory.empty()) {
        return fs::path(configuration->recorder->directory);
    }
    std::error_code error;
    const fs::path usual = fs::path(kServiceRecordings) / daemon.name;
    if (!fs::is_directory(usual, error)) {
        return tl::unexpected(
            fmt::format("no daemon says where the recordings are; the configuration names no "
                        "directory, and {} is not there",
                        usual.string()));
    }
    return usual;
}

HttpAnswer recordings_answer(const RecordingsPlace& place) {
    if (!place) {
        return refused(502, place.error());
    }
    Json list = Json::array();
    if (!*place) {
        return json_answer({{"directory", nullptr}, {"recordings", std::move(list)}});
    }
    const auto found = list_recordings(**place);
    if (!found) {
        return refused(502, found.error());
    }
    for (const ListedRecording& recording : *found) {
        list.push_back({{"id", recording.name},
                        {"time", recording.time},
                        {"cause", recording.cause},
                        {"bytes", recording.bytes}});
    }
    return json_answer({{"directory", (*place)->string()}, {"recordings", std::move(list)}});
}

tl::expected<fs::path, HttpAnswer> find_recording(const RecordingsPlace& place,
                                                  std::string_view name) {
    if (!place) {
        return tl::unexpected(refused(502, place.error()));
    }
    tl::expected<std::vector<ListedRecording>, std::string> list;
    if (*place) {
        list = list_recordings(**place);
    }
    if (!list) {
        return tl::unexpected(refused(502, list.error()));
    }
    const auto found = std::ranges::find(*list, name, &ListedRecording::name);
    if (found == list->end()) {
        return tl::unexpected(refused(404, "there is no such recording"));
    }
    return **place / found->name;
}

HttpAnswer recording_tar_answer(const fs::path& recording) {
    auto opened = RecordingTar::open(recording.parent_path(), recording.filename().string());
    if (!opened) {
        return refused(502, opened.error());
    }
    auto tar = std::make_shared<RecordingTar>(std::move(*opened));
    HttpAnswer answer{.type = "application/x-tar"};
    answer.headers = fmt::format("Content-Disposition: attachment; filename=\"{}.tar\"\r\n",
                                 recording.filename().string());
    answer.source_bytes = tar->bytes();
    answer.source = [tar] { return tar->next(); };
    return answer;
}

std::optional<std::vector<std::string>> plot_range(std::string_view query) {
    const auto from = number_in_query(query, "from");
    const auto to = number_in_query(query, "to");
    const auto width = number_in_query(query, "width");
    if (!from || !to || !width || *from >= *to || *width < 1 || *width > kMostPlotColumns) {
        return std::nullopt;
    }
    return std::vector<std::string>{"--from",  std::to_string(*from), "--to", std::to_string(*to),
                                    "--width", std::to_string(*width)};
}

}  // namespace tribus::web
