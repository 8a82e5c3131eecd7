#include <cstdio>
#include <exception>
#include <utility>
#include <vector>

#include "app/cli/command_line.h"
#include "app/cli/exit_status.h"
#include "app/mqtt/mqtt_command.h"

int main(int argc, char** argv) {
    // Libraries throw when memory fails; our own code does not throw.
    try {
        std::vector commands{tribus::mqtt::mqtt_command(TRIBUS_VERSION)};
        return tribus::run_command_line(std::move(commands), TRIBUS_VERSION, argc, argv);
    } catch (const std::exception& error) {
        std::fputs(error.what(), stderr);
        std::fputs("\n", stderr);
        return tribus::kExitFailed;
    }
}
