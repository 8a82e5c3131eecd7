#include <charconv>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/recorder/flight_recorder.h"

/// What the recorder answers to clients.
namespace tribus {
namespace {

/// Upper limit of the remembered outcomes of requests.
constexpr std::size_t kRememberedOutcomes = 16;

}  // namespace

std::string FlightRecorder::answer(std::span<const std::string> words, Instant now,
                                   Duration wall_now) {
    std::uint64_t number = 0;
    if (words.empty()) {
        if (!request_) {
            request_ = Event{.kind = "request",
                             .reason = "on request",
                             .wall = wall_now,
                             .at = now,
                             .due = now,
                             .number = ++requests_};
            outcomes_[requests_] = {};
            if (outcomes_.size() > kRememberedOutcomes) {
                outcomes_.erase(outcomes_.begin());
            }
        }
        number = request_->number;
    } else {
        const std::string& word = words.front();
        std::from_chars(word.data(), word.data() + word.size(), number);
    }
    run_jobs(now, wall_now);
    const auto outcome = outcomes_.find(number);
    if (words.size() > 1 || outcome == outcomes_.end()) {
        return error_object("\"record\" takes the number of a requested recording, or nothing");
    }
    const auto& [done, result] = outcome->second;
    nlohmann::ordered_json json = {{"type", "recording"}, {"number", number}};
    json["state"] = !done ? "writing" : result ? "written" : "failed";
    if (done && result) {
        json["folder"] = result->string();
    } else if (done) {
        json["reason"] = result.error();
    }
    return json_text(json);
}

std::string recordings_json(const FlightRecorder* recorder) {
    return json_text({{"type", "recordings"},
                      {"directory", recorder == nullptr
                                        ? nlohmann::ordered_json(nullptr)
                                        : nlohmann::ordered_json(recorder->directory().string())}});
}

}  // namespace tribus
