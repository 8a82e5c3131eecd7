#include <chrono>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/web/answers/answers.h"
#include "app/web/server/site.h"

/// Doctor and learn: what opens ports is done by the helper for ports.
namespace tribus::web {
namespace {

constexpr Duration kDoctorPatience = std::chrono::seconds(60);
/// A person who does not go on has left; the port is needed.
constexpr Duration kLearnPatience = std::chrono::minutes(5);
constexpr std::string_view kOthersLearn = "another browser is at it; it stops within 5 minutes";
constexpr std::string_view kHelper = "the helper for ports";

HttpAnswer broken_off(std::string_view why) {
    return json_answer({{"step", "broken"}, {"text", std::string(why)}, {"lines", Json::array()}});
}

}  // namespace

/// Without a device it opens nothing.
Site::Reply Site::doctor(const Asked& asked) {
    const std::string& body = asked.request.body;
    const auto device = text_in(body, "device");
    if (device && asked.visitor->role != Role::change) {
        return refused(403, "this browser may only look, not open ports");
    }
    Json order{{"verb", "doctor"}, {"seconds", number_in(body, "seconds").value_or(3)}};
    if (device) {
        order["device"] = *device;
    }
    auto helper = start_ports_helper(settings_.ports, settings_.configurations.string());
    return ask(LineRequest(LineTalk(kHelper, std::move(helper)), order.dump(),
                           later(asked.now, kDoctorPatience)),
               as_it_is);
}

bool Site::others_learn(const Visitor& visitor) const {
    return learning_ && learning_->visitor != visitor.hash;
}

Site::Reply Site::stop_learning(const Asked& asked) {
    if (others_learn(*asked.visitor)) {
        return refused(409, kOthersLearn);
    }
    constexpr std::string_view kStopped = "Stopped; nothing was learned.";
    end_learning(kStopped);
    return broken_off(kStopped);
}

Site::Reply Site::go_on_learning(const Asked& asked) {
    if (others_learn(*asked.visitor)) {
        return refused(409, kOthersLearn);
    }
    if (!learning_ || learning_->awaits_step) {
        return refused(409, learning_ ? "the step before is not done yet"
                                      : "nothing is being learned any more; begin again");
    }
    learning_->talk.say("");
    return next_step(asked.now);
}

Site::Reply Site::begin_learning(const Asked& asked) {
    const auto& [request, visitor, known, name, who, now] = asked;
    if (others_learn(*visitor)) {
        return refused(409, kOthersLearn);
    }
    const auto daemon = text_in(request.body, "daemon");
    const auto input = text_in(request.body, "input");
    if (!daemon || !input || !find_known(settings_.configurations, *daemon)) {
        return refused(404, "there is no configuration of that name");
    }
    // The one before has to let its port go first.
    end_learning("Begun again.");
    learning_ = std::make_shared<Learning>(Learning{
        .visitor = visitor->hash,
        .talk = LineTalk(kHelper,
                         start_ports_helper(settings_.ports, settings_.configurations.string()))});
    learning_->talk.say(Json{{"verb", "learn"}, {"daemon", *daemon}, {"input", *input}}.dump());
    return next_step(now);
}

Site::Reply Site::next_step(Instant now) {
    learning_->awaits_step = true;
    learning_->step.reset();
    learning_->end = later(now, kLearnPatience);
    return Late([learning = learning_] { return learning->step; });
}

void Site::end_learning(std::string_view why) {
    if (learning_) {
        learning_->step = broken_off(why);
        learning_.reset();
    }
}

void Site::look_at_learning(Instant now) {
    if (!learning_) {
        return;
    }
    const std::shared_ptr<Learning> learning = learning_;
    if (const auto line = learning->awaits_step ? learning->talk.hear() : std::nullopt) {
        learning->awaits_step = false;
        learning->step = as_it_is(*line);
        const auto step = text_in(*line, "step");
        const bool last = !step || *step == "done" || *step == "broken";
        if (last) {
            learning_.reset();
        }
        return;
    }
    if (now >= learning->end || (learning->awaits_step && !learning->talk.failed().empty())) {
        end_learning(learning->talk.failed().empty() ? "Nobody went on." : learning->talk.failed());
    }
}

}  // namespace tribus::web
