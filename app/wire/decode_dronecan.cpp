#include "app/wire/decode_dronecan.h"

#include <cstdint>
#include <numeric>
#include <ostream>
#include <vector>

#include "app/wire/decode_frames.h"
#include "app/wire/dronecan/dronecan_text.h"

namespace tribus {
namespace {

class TransferCounter final : public RecordingTaker {
  public:
    void feed_frame(const RecordedCanFrame& frame) override { explainer.feed(frame); }

    DroneCanExplainer explainer{[](const ExplainedTransfer&) {}};
};

}  // namespace

bool is_dronecan(RecordingSource& recording) {
    TransferCounter counter;
    recording.read(counter);
    counter.explainer.finish();
    const TransferTally& tally = counter.explainer.tally();
    const auto all = std::accumulate(tally.counts.begin(), tally.counts.end(), std::uint64_t{0});
    return tally.of_known_type > all / 2;
}

TransferDecoding::TransferDecoding(std::optional<std::size_t> columns, const DecodeOutput& output)
    : columns_(columns), output_(output), explainer_([this](const ExplainedTransfer& transfer) {
          const auto text = [this](std::string& line, const ExplainedTransfer& shown) {
              append_transfer_text(line, shown, columns_);
          };
          output_.results << in_format(output_.format, text, append_transfer_json,
                                       append_transfer_csv, transfer);
      }) {}

void TransferDecoding::heading() {
    output_.heading(append_transfer_text_heading, append_transfer_csv_heading);
}

void TransferDecoding::finish(const LogFacts& log) {
    explainer_.finish();
    TransferTally tally = explainer_.tally();
    tally.log = log;
    output_.summary([&](std::string& text) { append_transfer_summary_text(text, tally); },
                    [&](std::string& text) {
                        append_transfer_summary_json(text, tally, output_.input_name());
                    });
}

std::vector<ProtocolUse> without_dronecan(std::span<const ProtocolUse> uses) {
    std::vector<ProtocolUse> others(uses.begin(), uses.end());
    std::erase_if(others,
                  [](const ProtocolUse& use) { return use.protocol->name == kDroneCanName; });
    return others;
}

bool only_dronecan(RecordingSource& recording, std::span<const ProtocolUse> uses) {
    return is_dronecan(recording) && most_frames(without_dronecan(uses), recording) == 0;
}

}  // namespace tribus
