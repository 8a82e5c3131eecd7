#include "app/wire/decode_dronecan.h"

#include <cstdint>
#include <numeric>
#include <ostream>
#include <vector>

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

}  // namespace

bool is_dronecan(const Recording& recording) {
    DroneCanExplainer explainer([](const ExplainedTransfer&) {});
    explain_recording(recording, explainer);
    const TransferCounts& counts = explainer.tally().counts;
    const auto all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    return explainer.tally().of_known_type > all / 2;
}

TransferDecoding::TransferDecoding(TransferPrinter printer)
    : printer_(printer),
      explainer_([this](const ExplainedTransfer& transfer) { printer_.transfer(transfer); }) {}

void TransferDecoding::finish(const LogFacts& facts) {
    explainer_.finish();
    TransferTally tally = explainer_.tally();
    tally.error_frames = facts.error_frames;
    tally.log_start = facts.log_start;
    printer_.summary(tally);
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
