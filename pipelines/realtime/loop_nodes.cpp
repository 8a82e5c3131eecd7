#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

namespace tribus {

/// DroneCAN nodes send in a lane of their own, after the outputs of the interface.
void Loop::write_nodes(Instant now) {
    for (const std::size_t index : can_ports_) {
        Port& port = ports_[index];
        if (!port.wiring.node) {
            continue;
        }
        dronecan::Node& node = engine_.node(*port.wiring.node);
        const auto frames = node.frames_to_send(now);
        if (frames.empty()) {
            continue;
        }
        const WriteStatus status =
            port.link ? port.link->as_can()->write(port.wiring.outputs.size(), frames, now)
                      : WriteStatus::lost;
        switch (status) {
            case WriteStatus::written:
                capture(port, Transmission(frames), now);
                node.written();
                break;
            case WriteStatus::busy:
                node.busy(now);
                break;
            case WriteStatus::unavailable:
            case WriteStatus::lost:
                node.dropped();
                break;
        }
        if (status == WriteStatus::lost && port.link) {
            lose(port);
        }
    }
}

}  // namespace tribus
