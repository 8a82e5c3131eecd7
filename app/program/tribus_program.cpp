#include "app/program/tribus_program.h"

#include "app/bench/bench.h"
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

namespace tribus {

Program tribus_program() {
    return {
        .name = "tribus",
        .help = "Translate RC signals between i.Bus, SBUS, CAN and others",
        .commands = {init_command(),      run_command(),    monitor_command(), status_command(),
                     reload_command(),    check_command(),  diff_command(),    graph_command(),
                     demo_command(),      decode_command(), encode_command(),  simulate_command(),
                     record_command(),    replay_command(), learn_command(),   doctor_command(),
                     dbc_command(),       bench_command(),  pwm_command(),     schema_command(),
                     web::pair_command(), key_command()},
        .examples = {{"tribus demo", "what it does, with nothing attached"},
                     {"tribus init", "writes a first configuration, and says what comes next"},
                     {"tribus check servos.toml", ""},
                     {"tribus run servos.toml", ""}}};
}

}  // namespace tribus
