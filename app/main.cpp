#include <ios>

#include "app/cli/command_line.h"
#include "app/program/tribus_program.h"

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    return tribus::run_command_line(tribus::tribus_program, tribus::build_facts(), argc, argv);
}
