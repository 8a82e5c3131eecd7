#include "app/web/answers/checks.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/inspect/diff.h"
#include "app/inspect/graph_model.h"
#include "app/inspect/graph_picture.h"
#include "app/status/fingerprint.h"
#include "app/web/answers/answers.h"
#include "app/web/answers/preview.h"
#include "app/web/http/files.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "config/load.h"
#include "config/show/mistakes_json.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

HttpAnswer picture(const Configuration& configuration) {
    return {.type = "image/svg+xml", .content = graph_svg(graph_of(configuration))};
}

/// The configuration in the daemon's answer. Paths in it count from its file.
tl::expected<Configuration, HttpAnswer> configuration_in(const std::string& running) {
    HttpAnswer answer = as_it_is(running);
    if (answer.status != 200) {
        return tl::unexpected(std::move(answer));
    }
    const auto json = parse_json(running);
    auto configuration = load_configuration(status_fields::raw_text(json, "toml"),
                                            status_fields::raw_text(json, "file"));
    if (!configuration) {
        return tl::unexpected(refused(502, "the running configuration cannot be read again: " +
                                               configuration.error().front().text));
    }
    return *std::move(configuration);
}

/// The time of an id as RFC 3339 writes it. An id has no colons, because some file systems refuse
/// them.
std::string time_of(std::string id) {
    std::replace(std::ranges::find(id, 'T'), id.end(), '-', ':');
    return id;
}

}  // namespace

Json check_draft(const std::string& text, const fs::path& file) {
    const auto configuration = load_configuration(text, file.string());
    return {{"mistakes", configuration ? Json::array() : mistakes_json(configuration.error())}};
}

HttpAnswer picture_of_draft(const std::string& text, const fs::path& file) {
    const auto configuration = load_configuration(text, file.string());
    return configuration ? picture(*configuration)
                         : json_answer({{"error", "the draft has mistakes"},
                                        {"mistakes", mistakes_json(configuration.error())}},
                                       400);
}

HttpAnswer picture_of_running(const std::string& running) {
    const auto configuration = configuration_in(running);
    return configuration ? picture(*configuration) : configuration.error();
}

HttpAnswer difference_to(const std::string& running, const std::string& text, const fs::path& file,
                         const std::string& status) {
    const auto before = configuration_in(running);
    if (!before) {
        return before.error();
    }
    const auto fresh = load_configuration(text, file.string());
    if (!fresh) {
        return json_answer({{"same", false},
                            {"lines", Json::array()},
                            {"mistakes", mistakes_json(fresh.error())}});
    }
    const auto lines = lines_of(configuration_difference(*before, *fresh));
    return json_answer({{"same", lines.empty()},
                        {"lines", lines},
                        {"outputs", channels_changed_by(*before, *fresh, parse_json(status))},
                        {"mistakes", Json::array()}});
}

HttpAnswer configuration_answer(const fs::path& file) {
    if (file.empty()) {
        return refused(404, "its configuration is not in the folder of configurations");
    }
    auto text = read_file(file, kMostConfigurationBytes, FileKinds::regular);
    if (!text) {
        return refused(500, fmt::format("{}: {}", file.string(), text.error()));
    }
    return {.type = "text/plain; charset=utf-8",
            .content = *text,
            .headers = fmt::format("ETag: \"{}\"\r\n", fingerprint(*text))};
}

HttpAnswer history_answer(const fs::path& folder) {
    Json list = Json::array();
    for (const KeptFile& file : kept_files(folder)) {
        list.push_back({{"id", file.id}, {"time", time_of(file.id)}, {"bytes", file.bytes}});
    }
    return json_answer({{"files", std::move(list)}});
}

HttpAnswer kept_file_answer(const fs::path& folder, std::string_view id) {
    const auto files = kept_files(folder);
    const auto file = std::ranges::find(files, id, &KeptFile::id);
    if (file == files.end()) {
        return refused(404, "there is no such earlier configuration");
    }
    auto text = read_file(folder / (file->id + ".toml"), kMostConfigurationBytes);
    return text ? HttpAnswer{.type = "text/plain; charset=utf-8", .content = *std::move(text)}
                : refused(500, text.error());
}

}  // namespace tribus::web
