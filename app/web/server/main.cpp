#include <string>

#include "app/cli/command_line.h"
#include "app/web/server/web_program.h"

int main(int argc, char** argv) {
    const tribus::BuildFacts built = tribus::build_facts();
    return tribus::run_command_line(
        [&] { return tribus::web::web_program(std::string(built.version)); }, built, argc, argv);
}
