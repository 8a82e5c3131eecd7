#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/web/http/http.h"

/// The real checker's opinion of a draft. `file` is where the draft will stand: paths in it count
/// from there. Reads files that the draft names.
namespace tribus::web {

/// `{"mistakes": [{"file", "line", "column", "text"}]}`.
nlohmann::ordered_json check_draft(const std::string& text, const std::filesystem::path& file);
/// A picture, or the mistakes with status 400.
HttpAnswer picture_of_draft(const std::string& text, const std::filesystem::path& file);
/// `running`: the daemon's answer to `configuration`.
HttpAnswer picture_of_running(const std::string& running);
/// `{"same", "lines", "outputs", "mistakes"}`. `status`: the newest one of the daemon, or empty.
HttpAnswer difference_to(const std::string& running, const std::string& text,
                         const std::filesystem::path& file, const std::string& status);

/// The file as it stands, with its fingerprint as ETag.
HttpAnswer configuration_answer(const std::filesystem::path& file);
/// The list of earlier configurations.
HttpAnswer history_answer(const std::filesystem::path& folder);
/// The text of one of them.
HttpAnswer kept_file_answer(const std::filesystem::path& folder, std::string_view id);

}  // namespace tribus::web
