#include <string>

#include "app/cli/command_line.h"
#include "app/web/server/web_program.h"
#include "config/language/key_file.h"

int main(int argc, char** argv) {
    // The page judges configurations; their keys are none of its business.
    tribus::forbid_secrets();
    const tribus::BuildFacts built = tribus::build_facts();
    return tribus::run_command_line(
        [&] { return tribus::web::web_program(std::string(built.version)); }, built, argc, argv);
}
