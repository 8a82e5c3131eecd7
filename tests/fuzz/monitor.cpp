#include <string>

#include <nlohmann/json.hpp>

#include "app/client/change_reader.h"
#include "app/daemon/control_server.h"
#include "app/inspect/live_difference.h"
#include "app/monitor/monitor_keys.h"
#include "app/monitor/monitor_screen.h"
#include "app/status_command/summary.h"
#include "config/load.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::monitor_target {
namespace {

/// Allows line ends and the escape sequences that erase and position. Colours are off.
bool is_text_and_own_escapes(std::string_view screen) {
    constexpr unsigned char kBlank = 0x20;
    for (std::size_t i = 0; i < screen.size(); ++i) {
        const std::string_view rest = screen.substr(i);
        const bool own = rest.starts_with("\x1b[K") || rest.starts_with("\x1b[H") ||
                         rest.starts_with("\x1b[J") || rest.front() == '\n' || rest.front() == '\r';
        if (static_cast<unsigned char>(rest.front()) < kBlank && !own) {
            return false;
        }
        // U+0080 to U+009F: a terminal may take these for an escape and a letter.
        if (rest.size() > 1 && rest[0] == '\xC2' && static_cast<unsigned char>(rest[1]) < 0xA0) {
            return false;
        }
    }
    return true;
}

}  // namespace

/// Whatever answers on the socket, and whatever keys are pressed: a monitor shows no more lines
/// than fit, and only text and our own escape sequences reach the terminal.
FUZZ_TARGET(monitor) {
    Input input({data, size});
    const ScreenStyle style{.columns = 20U + input.byte(),
                            .rows = 3U + input.byte() % 60U,
                            .unicode = input.byte() % 2 == 0,
                            .colour = false};
    MonitorView view;
    const std::size_t selected = input.byte();
    view.top = size % 64;
    view.paused = input.byte() % 2 == 0;
    const std::string_view text = input.rest_as_text();
    keys_in(text);
    nlohmann::json status = nlohmann::json::parse(text, nullptr, false);
    if (status.is_discarded()) {
        return 0;
    }
    view.status = std::move(status);
    const std::size_t items = selectable(view.status);
    view.selected = items == 0 ? 0 : selected % items;
    const std::string screen = draw_monitor(view, style);
    require(static_cast<std::size_t>(std::count(screen.begin(), screen.end(), '\n')) <= style.rows,
            "a screen has no more lines than the terminal");
    require(is_text_and_own_escapes(screen), "a daemon cannot send escapes to the terminal");
    require(monitor_line(view).find('\n') == std::string::npos, "a line is one line");
    if (const auto summary = status_summary::of_status(view.status)) {
        std::string lines;
        for (const std::string& line : status_summary::lines(*summary)) {
            require(line.find('\n') == std::string::npos, "a line of a summary is one line");
            lines += line;
        }
        require(is_text_and_own_escapes(lines), "a summary sends no escapes to the terminal");
    }
    const std::string change = status_summary::line(status_summary::of_change(view.status));
    require(is_text_and_own_escapes(change), "a change sends no escapes to the terminal");
    ChangeReader reader;
    reader.take_status(view.status);
    reader.take_status({{"changes", 7}});
    reader.take_answer(view.status);
    static const auto configuration = load_configuration(
        "[input.a]\nprotocol=\"ibus\"\ndevice=\"/a\"\n[output.b]\nprotocol=\"sbus\"\n"
        "device=\"/b\"\n[pipeline.c]\nfrom=\"a\"\nto=\"b\"\n",
        "fuzz.toml");
    live_inputs(*configuration, view.status);
    return 0;
}

}  // namespace tribus::fuzz::monitor_target
