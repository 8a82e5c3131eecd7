#include "app/mqtt/mqtt_program.h"

#include <utility>

#include "app/mqtt/mqtt_command.h"

namespace tribus::mqtt {

Program mqtt_program(std::string version) {
    return {.name = "tribus-mqtt",
            .help = "Tell an MQTT broker of the daemons of this board",
            .commands = {mqtt_command(std::move(version))},
            .examples = {{"tribus-mqtt run --broker localhost", "a broker on this board"},
                         {"sudo systemctl enable --now tribus-mqtt",
                          "as a service, with the options of /etc/default/tribus-mqtt"}}};
}

}  // namespace tribus::mqtt
