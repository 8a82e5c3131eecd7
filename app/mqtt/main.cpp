#include <string>

#include "app/cli/command_line.h"
#include "app/mqtt/mqtt_program.h"

int main(int argc, char** argv) {
    const tribus::BuildFacts built = tribus::build_facts();
    return tribus::run_command_line(
        [&] { return tribus::mqtt::mqtt_program(std::string(built.version)); }, built, argc, argv);
}
