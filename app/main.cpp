#include <cstdio>
#include <exception>
#include <ios>
#include <vector>

#include "app/bench/bench.h"
#include "app/cli/command_line.h"
#include "app/cli/exit_status.h"
#include "app/daemon/run.h"
#include "app/demo/demo.h"
#include "app/doctor/doctor.h"
#include "app/init/init.h"
#include "app/inspect/check.h"
#include "app/inspect/diff.h"
#include "app/inspect/graph.h"
#include "app/inspect/reload.h"
#include "app/key/key_command.h"
#include "app/learn/learn.h"
#include "app/monitor/monitor.h"
#include "app/pwm/pwm.h"
#include "app/replay/record.h"
#include "app/replay/replay.h"
#include "app/replay/simulate.h"
#include "app/status_command/status_command.h"
#include "app/web/pairing/pair_command.h"
#include "app/wire/dbc_command.h"
#include "app/wire/decode_command.h"
#include "app/wire/encode.h"

namespace {

/// In the order in which help lists them.
std::vector<tribus::Command> commands() {
    using namespace tribus;
    return {init_command(),      run_command(),    monitor_command(), status_command(),
            reload_command(),    check_command(),  diff_command(),    graph_command(),
            demo_command(),      decode_command(), encode_command(),  simulate_command(),
            record_command(),    replay_command(), learn_command(),   doctor_command(),
            dbc_command(),       bench_command(),  pwm_command(),     schema_command(),
            web::pair_command(), key_command()};
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
