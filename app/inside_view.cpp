#include "app/inside_view.h"

#include <spdlog/spdlog.h>

#include "app/control_socket.h"
#include "app/status_json.h"
#include "pipelines/realtime/clock.h"

namespace tribus {

tl::expected<std::unique_ptr<InsideView>, std::string> InsideView::open(
    const std::string& config, const std::optional<std::string>& socket) {
    std::unique_ptr<InsideView> view(new InsideView);
    const auto path = socket ? socket : default_socket(SocketHomes::of_this_process(), config);
    if (!path) {
        spdlog::info(
            "no control socket: neither RUNTIME_DIRECTORY nor XDG_RUNTIME_DIR is set; "
            "--socket gives it a place");
        return view;
    }
    auto control = ControlServer::open(*path);
    if (!control && socket) {
        return tl::unexpected(control.error());
    }
    if (!control) {
        spdlog::info("no control socket: {}", control.error());
        return view;
    }
    view->control_ = std::move(*control);
    view->control_->add("status", [self = view.get()](auto) { return self->status(); });
    return view;
}

void InsideView::show(const Appliance& appliance, Instant now) {
    appliance_ = &appliance;
    keeper_.emplace(appliance, now);
}

void InsideView::look() {
    keeper_->look(*appliance_);
}

std::vector<int> InsideView::descriptors() const {
    return control_ ? std::vector{control_->descriptor()} : std::vector<int>();
}

Instant InsideView::due() const {
    return control_ ? control_->due() : kNever;
}

void InsideView::serve(Instant now) {
    if (control_ && keeper_) {
        control_->serve(now);
    }
}

std::string InsideView::status() const {
    return status_json(keeper_->report(*appliance_, monotonic_now(), wall_time_now()));
}

}  // namespace tribus
