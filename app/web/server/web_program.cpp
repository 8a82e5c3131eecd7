#include "app/web/server/web_program.h"

#include <utility>

#include "app/web/recordings/plot_command.h"
#include "app/web/server/ports_command.h"
#include "app/web/server/web_command.h"

namespace tribus::web {

Program web_program(std::string version) {
    return {.name = "tribus-web",
            .help = "Show the daemons of this board in a browser",
            .commands = {web_command(std::move(version)), ports_command(), plot_command()},
            .examples = {{"tribus-web serve", "the page is at http://127.0.0.1:8480"},
                         {"sudo systemctl enable --now tribus-web.socket",
                          "the same as a service, which starts when a browser comes"}}};
}

}  // namespace tribus::web
