#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "app/web/answers/answers.h"
#include "app/web/answers/plot_job.h"
#include "app/web/answers/recordings.h"
#include "app/web/server/site.h"
#include "pipelines/realtime/clock.h"

/// Recordings: their list, their pictures, their archives.
namespace tribus::web {

Site::Reply Site::recordings(const Asked& asked) {
    return with_recordings(asked.daemon, asked.now,
                           [](const RecordingsPlace& place) { return recordings_answer(place); });
}

Site::Reply Site::recording_tar(const Asked& asked) {
    constexpr std::string_view kEnding = ".tar";
    if (!asked.name.ends_with(kEnding)) {
        return refused(404, "there is nothing of that name");
    }
    const std::string name = asked.name.substr(0, asked.name.size() - kEnding.size());
    return with_recordings(asked.daemon, asked.now, [name](const RecordingsPlace& place) -> Reply {
        const auto recording = find_recording(place, name);
        return recording ? recording_tar_answer(*recording) : recording.error();
    });
}

Site::Reply Site::recording_plot(const Asked& asked) {
    return with_recordings(
        asked.daemon, asked.now,
        [this, name = asked.name, query = asked.request.query](const RecordingsPlace& place) {
            return begin_plot(place, name, query);
        });
}

/// The daemon says where its recordings are; without its answer, its configuration does.
Site::Reply Site::with_recordings(const KnownDaemon& daemon, Instant now,
                                  std::function<Reply(const RecordingsPlace&)> go_on) {
    if (daemon.tells.empty()) {
        return go_on(place_in_file(daemon));
    }
    const auto place = std::make_shared<std::optional<RecordingsPlace>>();
    ask(daemon, "recordings", now, [place, daemon](const std::string& json) {
        *place = place_in_answer(json);
        if (!**place) {
            *place = place_in_file(daemon);
        }
        return HttpAnswer{};
    });
    const auto reply = std::make_shared<std::optional<Reply>>();
    return Late([place, reply, go_on = std::move(go_on)]() -> std::optional<HttpAnswer> {
        if (!*place) {
            return std::nullopt;
        }
        if (!*reply) {
            *reply = go_on(**place);
        }
        auto* const late = std::get_if<Late>(&**reply);
        return late != nullptr ? (*late)() : std::get<HttpAnswer>(std::move(**reply));
    });
}

/// One at a time for all pages. A second one is told to come again instead of waiting in a line: a
/// page that is closed meanwhile then costs nothing.
Site::Reply Site::begin_plot(const RecordingsPlace& place, const std::string& name,
                             const std::string& query) {
    const auto recording = find_recording(place, name);
    if (!recording) {
        return recording.error();
    }
    const auto range = plot_range(query);
    if (!range) {
        return refused(400, "a plot needs from and to, in microseconds, and width, from 1 to 4000");
    }
    if (plotting_) {
        HttpAnswer busy = refused(503, "another recording is being read; try again in a moment");
        busy.headers = "Retry-After: 1\r\n";
        return busy;
    }
    auto started = PlotJob::start(*recording, *range, monotonic_now());
    if (!started) {
        return refused(500, started.error());
    }
    plotting_ = *started;
    return Late([job = *std::move(started)] { return job->answer(); });
}

}  // namespace tribus::web
