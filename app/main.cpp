#include <cstdio>
#include <exception>
#include <ios>
#include <vector>

#include "app/bench/bench.h"
#include "app/check.h"
#include "app/command_line.h"
#include "app/dbc_command.h"
#include "app/decode.h"
#include "app/demo.h"
#include "app/diff.h"
#include "app/doctor/doctor.h"
#include "app/encode.h"
#include "app/exit_status.h"
#include "app/graph.h"
#include "app/init/init.h"
#include "app/learn.h"
#include "app/monitor.h"
#include "app/record.h"
#include "app/reload.h"
#include "app/replay.h"
#include "app/run.h"
#include "app/simulate.h"

namespace {

/// In the order in which help lists them.
std::vector<tribus::Command> commands() {
    using namespace tribus;
    return {init_command(),   run_command(),    monitor_command(),  reload_command(),
            check_command(),  diff_command(),   graph_command(),    demo_command(),
            decode_command(), encode_command(), simulate_command(), record_command(),
            replay_command(), learn_command(),  doctor_command(),   dbc_command(),
            bench_command(),  schema_command()};
}

}  // namespace

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    // Libraries throw when memory or a standard stream fails; our own code does not throw.
    try {
        return tribus::run_command_line(commands(), TRIBUS_VERSION, argc, argv);
    } catch (const std::exception& error) {
        std::fputs(error.what(), stderr);
        std::fputs("\n", stderr);
        return tribus::kExitFailed;
    }
}
