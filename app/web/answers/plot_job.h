#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/web/http/http.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {

/// A process of its own reads a recording: that may take seconds, and what is damaged could break
/// more than the picture. It is this same program, as `tribus-web plot`. Thread-bound; nothing here
/// waits.
class PlotJob {
  public:
    /// `range`: the options of `tribus-web plot`. The error is a sentence.
    static tl::expected<std::shared_ptr<PlotJob>, std::string> start(
        const std::filesystem::path& recording, const std::vector<std::string>& range, Instant now);
    PlotJob(const PlotJob&) = delete;
    PlotJob& operator=(const PlotJob&) = delete;
    /// Ends the process, but does not wait for that.
    ~PlotJob();

    /// Readable when the process has ended.
    int descriptor() const { return ended_.get(); }
    /// When `look` must be called at the latest.
    Instant due() const { return due_; }
    /// Takes the result, or ends a process that takes too long.
    void look(Instant now);
    /// The picture, or why there is none; nothing yet while the process runs.
    const std::optional<HttpAnswer>& answer() const { return answer_; }

    static constexpr Duration kPatience = std::chrono::seconds(20);

  private:
    PlotJob(pid_t process, UniqueFd ended, UniqueFd result, Instant end)
        : process_(process), ended_(std::move(ended)), result_(std::move(result)), due_(end) {}
    HttpAnswer picture();
    HttpAnswer failure(int code, int status);

    pid_t process_;
    UniqueFd ended_;
    UniqueFd result_;  ///< what the process wrote, in memory
    Instant due_;
    bool too_late_ = false;
    std::optional<HttpAnswer> answer_;
};

}  // namespace tribus::web
