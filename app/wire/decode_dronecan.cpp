#include "app/wire/decode_dronecan.h"

#include <cstdint>
#include <numeric>
#include <ostream>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/wire/decode_can.h"
#include "app/wire/dronecan/dronecan_explainer.h"

namespace tribus {
namespace {

void explain_recording(const Recording& recording, DroneCanExplainer& explainer) {
    for (const RecordedCanFrame& frame : recording.can_frames) {
        explainer.feed(frame);
    }
    explainer.finish();
}

void print_summary(const DroneCanExplainer& explainer, std::uint64_t error_frames,
                   Duration log_start, TransferPrinter& printer) {
    TransferTally tally = explainer.tally();
    tally.error_frames = error_frames;
    tally.log_start = log_start;
    printer.summary(tally);
}

}  // namespace

bool is_dronecan(const Recording& recording) {
    DroneCanExplainer explainer([](const ExplainedTransfer&) {});
    explain_recording(recording, explainer);
    const TransferCounts& counts = explainer.tally().counts;
    const auto all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    return explainer.tally().of_known_type > all / 2;
}

int decode_dronecan_recording(const Recording& recording, TransferPrinter& printer) {
    printer.heading();
    DroneCanExplainer explainer(
        [&printer](const ExplainedTransfer& transfer) { printer.transfer(transfer); });
    explain_recording(recording, explainer);
    print_summary(explainer, recording.error_frames, recording.log_start, printer);
    return kExitFine;
}

int decode_dronecan_stream(const CanLogSource& source, TransferPrinter& printer,
                           std::ostream& results, std::ostream& messages) {
    printer.heading();
    results.flush();
    DroneCanExplainer explainer(
        [&printer](const ExplainedTransfer& transfer) { printer.transfer(transfer); });
    const CanLogEnd end = read_can_log(
        source, [&explainer](const RecordedCanFrame& frame) { explainer.feed(frame); }, results,
        messages);
    explainer.finish();
    print_summary(explainer, end.error_frames, end.log_start, printer);
    return end.failed ? kExitFailed : kExitFine;
}

std::vector<ProtocolUse> without_dronecan(std::span<const ProtocolUse> uses) {
    std::vector<ProtocolUse> others(uses.begin(), uses.end());
    std::erase_if(others,
                  [](const ProtocolUse& use) { return use.protocol->name == kDroneCanName; });
    return others;
}

bool only_dronecan(const Recording& recording, std::span<const ProtocolUse> uses) {
    return is_dronecan(recording) && most_snapshots(without_dronecan(uses), recording) == 0;
}

}  // namespace tribus
